//! Random numbers by counter: the n-th number of a seed and stream, whatever was asked before.

/// A stream of random numbers. Equal seeds and streams give equal numbers on every machine.
#[derive(Clone, Debug)]
pub struct Stream {
    key: u64,
    counter: u64,
}

impl Stream {
    /// The stream of this number under a seed.
    pub fn new(seed: u64, stream: u64) -> Self {
        Self { key: mix(mix(seed) ^ stream.wrapping_mul(0xd1b5_4a32_d192_ed03)), counter: 0 }
    }

    /// The next 64 bits: SplitMix64 (Steele, Lea and Flood 2014) read by counter.
    pub fn bits(&mut self) -> u64 {
        self.counter += 1;
        mix(self.key.wrapping_add(self.counter.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
    }

    /// Evenly from the open interval 0 to 1.
    pub fn unit(&mut self) -> f64 {
        ((self.bits() >> 11) as f64 + 0.5) * (1.0 / (1_u64 << 53) as f64)
    }

    /// Standard normal (Box and Muller 1958, the cosine half).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * self.unit().ln()).sqrt();
        radius * (std::f64::consts::TAU * self.unit()).cos()
    }

    /// Log-normal with a median and the standard deviation of the common logarithm, drawn again while outside
    /// `[low, high]` (and clamped after 64 draws, so that no argument makes it hang).
    pub fn log_normal(&mut self, median: f64, sigma_log10: f64, [low, high]: [f64; 2]) -> f64 {
        let mut value = median;
        for _ in 0..64 {
            value = median * 10.0_f64.powf(sigma_log10 * self.normal());
            if value >= low && value <= high {
                return value;
            }
        }
        value.clamp(low, high)
    }
}

/// The finaliser of SplitMix64: a bijection that changes half the bits for any one bit changed.
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reference_sequence_of_splitmix64() {
        // Seed 1234567, first outputs of the published reference implementation (Vigna, splitmix64.c).
        let mut stream = Stream { key: 1_234_567, counter: 0 };
        assert_eq!(stream.bits(), 6_457_827_717_110_365_317);
        assert_eq!(stream.bits(), 3_203_168_211_198_807_973);
    }

    #[test]
    fn moments_of_the_unit_and_the_normal() {
        let mut stream = Stream::new(7, 0);
        let n = 100_000;
        let mean = (0..n).map(|_| stream.unit()).sum::<f64>() / f64::from(n);
        // Standard error 0.2887 / sqrt(1e5) = 0.0009; five of them.
        assert!((mean - 0.5).abs() < 0.0046, "{mean}");
        let (mut sum, mut square) = (0.0, 0.0);
        for _ in 0..n {
            let x = stream.normal();
            sum += x;
            square += x * x;
        }
        // Standard errors 0.0032 and 0.0045; five of them.
        assert!((sum / f64::from(n)).abs() < 0.016 && (square / f64::from(n) - 1.0).abs() < 0.023);
    }

    #[test]
    fn streams_and_seeds_differ() {
        let first = |seed, stream| Stream::new(seed, stream).bits();
        assert_eq!(first(1, 2), first(1, 2));
        assert!(first(1, 2) != first(2, 1) && first(1, 2) != first(1, 3) && first(0, 0) != first(1, 0));
    }
}
