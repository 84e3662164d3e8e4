//! Median and 99th percentile of what was measured.

/// Values in the order in which they came.
#[derive(Debug, Default)]
pub(super) struct Spread {
    values: Vec<f64>,
}

impl Spread {
    /// Adds a value.
    pub(super) fn add(&mut self, value: f64) {
        self.values.push(value);
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.values.len()
    }

    /// The smallest value that is no less than `share` (0 to 1) of all (nearest rank). `None`: there are none.
    pub(super) fn percentile(&self, share: f64) -> Option<f64> {
        let mut sorted = self.values.clone();
        sorted.sort_by(f64::total_cmp);
        let rank = (share * sorted.len() as f64).ceil() as usize;
        sorted.get(rank.saturating_sub(1)).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_by_nearest_rank() {
        let mut spread = Spread::default();
        assert_eq!(spread.percentile(0.5), None);
        (1..=200).rev().for_each(|n| spread.add(f64::from(n)));
        assert_eq!(spread.percentile(0.5), Some(100.0));
        assert_eq!(spread.percentile(0.99), Some(198.0));
        assert_eq!(spread.percentile(1.0), Some(200.0));
        assert_eq!(spread.percentile(0.0), Some(1.0));
        assert_eq!(spread.count(), 200);
    }
}
