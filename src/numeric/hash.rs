//! Counter-based random numbers: a hash of integers, so that the same counter gives the same number on every machine.

/// PCG hash of three counters (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering", `pcg3d`).
pub fn pcg3d(x: u32, y: u32, z: u32) -> [u32; 3] {
    let step = |v: u32| v.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let (mut x, mut y, mut z) = (step(x), step(y), step(z));
    x = x.wrapping_add(y.wrapping_mul(z));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    x ^= x >> 16;
    y ^= y >> 16;
    z ^= z >> 16;
    x = x.wrapping_add(y.wrapping_mul(z));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    [x, y, z]
}

/// A hash as a number in [0, 1): the upper 24 bits, which f32 holds exactly.
pub fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unit_is_uniform() {
        // 30,000 uniform numbers have a mean of 0.5 with a standard error of 0.29 / sqrt(30000) = 0.0017; five of these.
        let numbers: Vec<f32> = (0..10_000).flat_map(|i| pcg3d(i, 7, 11)).map(unit).collect();
        let mean = numbers.iter().sum::<f32>() / numbers.len() as f32;
        assert!((mean - 0.5).abs() < 0.0085, "mean {mean}");
        assert!(numbers.iter().all(|n| (0.0..1.0).contains(n)));
    }

    #[test]
    fn neighbours_differ() {
        assert_ne!(pcg3d(1, 2, 3), pcg3d(2, 2, 3));
        assert_ne!(pcg3d(1, 2, 3), pcg3d(1, 3, 2));
    }
}
