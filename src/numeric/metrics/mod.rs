//! How far one picture is from another.

mod flip;
mod noisy;

pub use flip::{PIXELS_PER_DEGREE, flip, flip_map};
pub use noisy::relative_square_less_noise;

/// Relative mean squared error: the mean of `(x - r)^2 / (r^2 + (0.01 m)^2)` over all values, `m` the mean of the
/// reference (Rousselle, Knaus and Zwicker 2011, "Adaptive Sampling and Reconstruction using Greedy Error Minimization",
/// section 3, whose constant of 0.01 is made one of scale, so that the unit of the picture does not matter).
///
/// 0 for equal pictures; NaN where a value is NaN, the lengths differ, or there are none. A reference that is black
/// everywhere gives 0 or infinity.
pub fn relative_mse(picture: &[f32], reference: &[f32]) -> f64 {
    if picture.len() != reference.len() || picture.is_empty() {
        return f64::NAN;
    }
    let count = picture.len() as f64;
    let mean = reference.iter().map(|r| f64::from(*r)).sum::<f64>() / count;
    let floor = (0.01 * mean).powi(2);
    let term = |(x, r): (&f32, &f32)| {
        let (x, r) = (f64::from(*x), f64::from(*r));
        let squared = (x - r) * (x - r);
        if squared == 0.0 { 0.0 } else { squared / (r * r + floor) }
    };
    picture.iter().zip(reference).map(term).sum::<f64>() / count
}

/// Root mean squared difference of 8-bit values, as a share of 255. NaN where the lengths differ or there are none.
pub fn rms_of_codes(picture: &[u8], reference: &[u8]) -> f64 {
    if picture.len() != reference.len() || picture.is_empty() {
        return f64::NAN;
    }
    let sum: u64 = picture.iter().zip(reference).map(|(a, b)| u64::from(a.abs_diff(*b)).pow(2)).sum();
    (sum as f64 / picture.len() as f64).sqrt() / 255.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relative_mse_by_hand() {
        // Mean 2, floor 4e-4: (0.5^2 / 1.0004 + 0 + 1 / 9.0004) / 3 with references 1, 2, 3.
        let expected = (0.25 / 1.0004 + 1.0 / 9.0004) / 3.0;
        let found = relative_mse(&[1.5, 2.0, 4.0], &[1.0, 2.0, 3.0]);
        // All in f64: rounding alone.
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        // The unit does not matter; the values are rounded to f32 (6e-8 each, of differences a third of them).
        let scaled = relative_mse(&[1.5e6, 2.0e6, 4.0e6], &[1.0e6, 2.0e6, 3.0e6]);
        assert!((scaled / expected - 1.0).abs() < 1e-9);
    }

    #[test]
    fn what_cannot_be_compared_is_not_zero() {
        assert!(relative_mse(&[], &[]).is_nan() && relative_mse(&[1.0], &[1.0, 1.0]).is_nan());
        assert!(relative_mse(&[f32::NAN, 1.0], &[1.0, 1.0]).is_nan());
        assert_eq!(relative_mse(&[0.0, 0.0], &[0.0, 0.0]), 0.0);
        assert_eq!(relative_mse(&[1.0, 0.0], &[0.0, 0.0]), f64::INFINITY);
        assert!(rms_of_codes(&[1], &[]).is_nan());
    }

    #[test]
    fn rms_by_hand() {
        // Differences 3 and 4: root of 12.5.
        assert!((rms_of_codes(&[3, 10], &[0, 14]) - 12.5f64.sqrt() / 255.0).abs() < 1e-15);
    }
}
