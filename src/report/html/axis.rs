//! A logarithmic axis: from values to a range of decades or parts of them, ticks and places.

/// A logarithmic axis over positive values.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    low: f64,
    high: f64,
}

impl Axis {
    /// An axis that holds all positive values, with some room; `None` without any.
    pub fn over(values: impl Iterator<Item = f64>) -> Option<Self> {
        let (mut low, mut high) = (f64::MAX, 0.0f64);
        for value in values.filter(|v| v.is_finite() && *v > 0.0) {
            (low, high) = (low.min(value), high.max(value));
        }
        if high == 0.0 {
            return None;
        }
        // Room of a tenth on both sides, and half a decade at least, so that one point does not fill the axis.
        let (mut low, mut high) = (low.log10(), high.log10());
        let room = (0.08 * (high - low)).max(0.5 * (0.5 - (high - low))).max(0.04);
        (low, high) = (low - room, high + room);
        Some(Self { low, high })
    }

    /// Place of a positive value, 0 to 1.
    pub fn place(&self, value: f64) -> f64 {
        (value.log10() - self.low) / (self.high - self.low)
    }

    /// Values to be labelled: decades, or 1, 2 and 5 of each where there are few.
    pub fn ticks(&self) -> Vec<f64> {
        let decades = self.high - self.low;
        let every = (decades / 6.0).ceil().max(1.0) as i32;
        let parts: &[f64] = match decades {
            d if d > 2.5 => &[1.0],
            d if d > 0.9 => &[1.0, 2.0, 5.0],
            _ => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0],
        };
        let first = self.low.floor() as i32;
        let last = self.high.ceil() as i32;
        (first..=last)
            .filter(|decade| decade.rem_euclid(every) == 0)
            .flat_map(|decade| parts.iter().map(move |part| part * 10f64.powi(decade)))
            .filter(|value| (0.0..=1.0).contains(&self.place(*value)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axis_holds_its_values_and_has_a_few_ticks() {
        for (low, high) in [(1e-9, 1e3), (0.01, 0.02), (1.0, 1.0), (3.0, 40.0), (1e-300, 1e300), (0.9, 1.1)] {
            let axis = Axis::over([low, high].into_iter()).expect("positive");
            assert!(axis.place(low) > 0.0 && axis.place(high) < 1.0, "{low} {high}");
            let ticks = axis.ticks();
            assert!((2..=13).contains(&ticks.len()), "{low} {high}: {ticks:?}");
        }
        assert_eq!(Axis::over([0.0, -1.0, f64::NAN, f64::INFINITY].into_iter()), None);
    }

    #[test]
    fn decades_lie_evenly() {
        let axis = Axis::over([0.1, 10.0].into_iter()).expect("positive");
        // Rounding of two logarithms: a few 1e-16.
        assert!((axis.place(1.0) - 0.5).abs() < 1e-12);
    }
}
