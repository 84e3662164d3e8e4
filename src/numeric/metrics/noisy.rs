//! Error against a reference that has noise of its own.

/// Squared error over the square of the reference, both summed over all values, with the reference's own noise taken out
/// of both sums: `(sum (x - r)^2 - sum s^2) / (sum r^2 - sum s^2)`, `s` the standard error of each reference value. Its
/// expectation is that against the reference without noise; it may be slightly negative where there is no error.
///
/// NaN where the lengths differ, there are none, or the reference is nothing but noise.
pub fn relative_square_less_noise(picture: &[f64], reference: &[f64], standard_error: &[f64]) -> f64 {
    if picture.len() != reference.len() || reference.len() != standard_error.len() || picture.is_empty() {
        return f64::NAN;
    }
    let sum = |term: &dyn Fn(usize) -> f64| (0..picture.len()).map(term).sum::<f64>();
    let noise = sum(&|i| standard_error[i].powi(2));
    let apart = sum(&|i| (picture[i] - reference[i]).powi(2)) - noise;
    let signal = sum(&|i| reference[i].powi(2)) - noise;
    if signal > 0.0 { apart / signal } else { f64::NAN }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::hash::{pcg3d, unit};

    #[test]
    fn by_hand() {
        // (1 + 4 - 0.5) / (16 + 9 - 0.5).
        let found = relative_square_less_noise(&[5.0, 1.0], &[4.0, 3.0], &[0.5, 0.5]);
        assert!((found - 4.5 / 24.5).abs() < 1e-15, "{found}");
        assert!(relative_square_less_noise(&[1.0], &[1.0], &[2.0]).is_nan(), "nothing but noise");
        assert!(relative_square_less_noise(&[], &[], &[]).is_nan());
    }

    #[test]
    fn noise_of_the_reference_does_not_count_as_error() {
        // The truth is 1, the picture 1.1, the reference the truth with even noise of half width 0.5 (variance 1 / 12).
        let n = 20_000;
        let reference: Vec<f64> = (0..n).map(|i| 0.5 + f64::from(unit(pcg3d(i, 3, 5)[0]))).collect();
        let error = vec![(1.0f64 / 12.0).sqrt(); n as usize];
        let found = relative_square_less_noise(&vec![1.1; n as usize], &reference, &error);
        // 0.01 but for what is left of the noise: the mean of (0.1 - e)^2 has a standard error of about 0.1 / sqrt(n).
        assert!((found - 0.01).abs() < 4.0 * 0.1 / f64::from(n).sqrt(), "{found}");
    }
}
