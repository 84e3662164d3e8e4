//! Weighted draws from a list that changes: weights in blocks, so that a draw looks at one sum a block and then at one block.

/// Weights to a block.
const BLOCK: usize = 64;

/// Non-negative weights, drawn from in proportion.
///
/// A block's sum is formed anew from its weights whenever one changes: sums kept by adding and subtracting would hold residues
/// larger than the small weights.
#[derive(Clone, Debug, Default)]
pub(super) struct Urn {
    weights: Vec<f64>,
    sums: Vec<f64>,
}

impl Urn {
    #[cfg(test)]
    pub fn len(&self) -> usize {
        self.weights.len()
    }

    pub fn weight(&self, slot: usize) -> f64 {
        self.weights[slot]
    }

    pub fn push(&mut self, weight: f64) {
        self.weights.push(weight);
        self.sums.resize(self.weights.len().div_ceil(BLOCK), 0.0);
        self.sum_again(self.weights.len() - 1);
    }

    pub fn set(&mut self, slot: usize, weight: f64) {
        self.weights[slot] = weight;
        self.sum_again(slot);
    }

    /// Sets every weight.
    pub fn set_all(&mut self, weight: impl Fn(usize) -> f64) {
        for (number, (weights, sum)) in self.weights.chunks_mut(BLOCK).zip(&mut self.sums).enumerate() {
            for (k, slot) in weights.iter_mut().enumerate() {
                *slot = weight(number * BLOCK + k);
            }
            *sum = weights.iter().sum();
        }
    }

    /// Takes a weight out; the last one moves into its slot.
    pub fn swap_remove(&mut self, slot: usize) {
        self.weights.swap_remove(slot);
        self.sums.truncate(self.weights.len().div_ceil(BLOCK));
        if slot < self.weights.len() {
            self.sum_again(slot);
        }
        if !self.weights.is_empty() {
            self.sum_again(self.weights.len() - 1);
        }
    }

    /// The slot at share `u` (0 to 1) of the sum of all weights; none when that sum is not positive.
    pub fn draw(&self, u: f64) -> Option<usize> {
        let block = |number: usize| &self.weights[number * BLOCK..self.weights.len().min((number + 1) * BLOCK)];
        draw(u, &self.sums, block).map(|(number, lane)| number * BLOCK + lane)
    }

    fn sum_again(&mut self, slot: usize) {
        let block = slot / BLOCK;
        let end = self.weights.len().min((block + 1) * BLOCK);
        self.sums[block] = self.weights[block * BLOCK..end].iter().sum();
    }
}

/// The block and lane at share `u` of the sum of all weights, given block sums and blocks; none when that sum is not positive.
pub(super) fn draw<'a, T: Copy + Into<f64> + 'a>(
    u: f64,
    sums: &[T],
    block: impl Fn(usize) -> &'a [T],
) -> Option<(usize, usize)> {
    let total: f64 = sums.iter().map(|&sum| sum.into()).sum();
    if total <= 0.0 || !total.is_finite() {
        return None;
    }
    let mut left = u * total;
    // Rounding can leave a little over after the last weight of a block or of all: then the last one is meant.
    let mut chosen = None;
    for (number, sum) in sums.iter().map(|&sum| sum.into()).enumerate().filter(|(_, sum)| *sum > 0.0) {
        chosen = Some((number, left));
        if left < sum {
            break;
        }
        left -= sum;
        chosen = Some((number, f64::INFINITY));
    }
    let (number, mut left) = chosen?;
    let mut lane = None;
    for (k, weight) in block(number).iter().map(|&weight| weight.into()).enumerate().filter(|(_, weight)| *weight > 0.0)
    {
        lane = Some(k);
        left -= weight;
        if left < 0.0 {
            break;
        }
    }
    lane.map(|lane| (number, lane))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lightning::random::Stream;

    #[test]
    fn draws_follow_the_weights_after_changes() {
        let mut urn = Urn::default();
        for k in 0..200 {
            urn.push(f64::from(k % 5));
        }
        urn.set(7, 100.0);
        urn.swap_remove(64);
        urn.swap_remove(198);
        let total: f64 = (0..urn.len()).map(|slot| urn.weight(slot)).sum();
        let mut stream = Stream::new(1, 0);
        let (mut sevens, mut zeros) = (0.0, 0);
        let n = 20_000;
        for _ in 0..n {
            let slot = urn.draw(stream.unit()).expect("weights are there");
            sevens += f64::from(u8::from(slot == 7));
            zeros += u32::from(urn.weight(slot) == 0.0);
        }
        let p = 100.0 / total;
        // Five standard errors of a share p of n draws.
        assert!((sevens / f64::from(n) - p).abs() < 5.0 * (p * (1.0 - p) / f64::from(n)).sqrt(), "{sevens} {p}");
        assert_eq!(zeros, 0);
    }

    #[test]
    fn the_ends_of_the_unit_interval_and_nothing_to_draw() {
        let mut urn = Urn::default();
        assert_eq!(urn.draw(0.5), None);
        for weight in [0.0, 1e-300, 2.0, 0.0] {
            urn.push(weight);
        }
        assert_eq!((urn.draw(0.0), urn.draw(1.0)), (Some(1), Some(2)));
        urn.set_all(|_| 0.0);
        assert_eq!(urn.draw(0.5), None);
    }
}
