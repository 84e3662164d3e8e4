//! What the three reports on light in clouds share: a patchy cloud, bolts, and the relative error of lists.

use super::subject::Stopped;
use crate::numeric::noise::fractal;
use crate::scattering::medium::Medium;
use crate::scattering::ordinates::PointSource;
use glam::Vec3;

/// A cloud of noise in an ellipsoid, of greatest optical depth `depth` per longest edge of a cell; about two thirds of the cells
/// have some.
pub fn cloud(cells: [usize; 3], spacing_m: [f64; 3], depth: f32) -> Result<Medium, Stopped> {
    let edge = spacing_m.iter().copied().fold(0.0, f64::max) as f32;
    let mut values = Vec::with_capacity(cells.iter().product());
    for z in 0..cells[2] {
        for y in 0..cells[1] {
            for x in 0..cells[0] {
                let part = |i: usize, n: usize| (i as f32 + 0.5) / n as f32;
                let at = Vec3::new(part(x, cells[0]), part(y, cells[1]), part(z, cells[2]));
                let centred = (at * 2.0 - Vec3::ONE) * Vec3::new(1.0, 1.0, 0.8);
                let noise = 0.5 + 0.8 * fractal(at * Vec3::new(8.0, 8.0, 2.0), [8, 8, 2], 3, 5);
                values.push((1.0 - centred.length_squared()).max(0.0) * noise.clamp(0.0, 1.0));
            }
        }
    }
    let most = values.iter().copied().fold(1e-9, f32::max);
    let values = values.into_iter().map(|v| v / most * depth / edge).collect();
    Medium::new(cells, spacing_m, values, false).map_err(|why| Stopped::Failed(why.to_string()))
}

/// A bolt of `seeds` branches of 200 points in all, each from inside the box to below it (the paper's figure 7 has 1 to 5 seeds).
pub fn bolt(size_m: [f64; 3], seeds: usize, seed: u64) -> Vec<PointSource> {
    let mut random = crate::lightning::random::Stream::new(seed, seeds as u64);
    let mut points = Vec::new();
    let each = 200 / seeds.max(1);
    for _ in 0..seeds {
        let mut at = [0, 1, 2].map(|k| size_m[k] * if k == 2 { 0.7 } else { 0.25 + 0.5 * random.unit() });
        let step = 1.6 * size_m[2] / each as f64;
        for _ in 0..each {
            at[0] += step * random.normal();
            at[1] += step * random.normal();
            at[2] -= step * random.unit() * 1.6;
            points.push(PointSource { position_m: at, intensity: 1.0 / (each * seeds) as f64 });
        }
    }
    points
}

/// Root of the summed squares of differences, over that of the reference.
pub fn relative(found: impl IntoIterator<Item = f64>, reference: impl IntoIterator<Item = f64>) -> f64 {
    let (mut difference, mut whole) = (0.0, 0.0);
    for (a, b) in found.into_iter().zip(reference) {
        difference += (a - b) * (a - b);
        whole += b * b;
    }
    (difference / whole).sqrt()
}

/// The same for lists of f32.
pub fn relative_f32(found: &[f32], reference: &[f32]) -> f64 {
    relative(found.iter().map(|v| f64::from(*v)), reference.iter().map(|v| f64::from(*v)))
}

/// [`relative`] against a truth that two references tell, each with noise of its own: products of differences from one and the
/// other have the expectation of squares of differences from the truth, so that the noise does not count.
pub fn less_noise(found: &[f64], one: &[f64], two: &[f64]) -> f64 {
    let (mut difference, mut whole) = (0.0, 0.0);
    for ((x, a), b) in found.iter().zip(one).zip(two) {
        difference += (x - a) * (x - b);
        whole += a * b;
    }
    (difference.max(0.0) / whole).sqrt()
}

/// Any complaint as the end of a subject.
pub fn failed(why: impl std::fmt::Display) -> Stopped {
    Stopped::Failed(why.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bolts_have_unit_intensity_and_errors_are_computed_by_hand() {
        for seeds in [1, 2, 3, 5] {
            let sum: f64 = bolt([32.0, 32.0, 4.0], seeds, 7).iter().map(|p| p.intensity).sum();
            assert!((sum - 1.0).abs() < 1e-9);
        }
        assert!((relative([3.0, 4.0], [3.0, 0.0]) - 4.0 / 3.0).abs() < 1e-12);
        assert_eq!(relative_f32(&[1.0], &[1.0]), 0.0);
        // The truth is 2 and 1, the references half too much and half too little: (0.5 1.5 + 0) / (2.5 1.5 + 1).
        let error = less_noise(&[3.0, 1.0], &[2.5, 1.0], &[1.5, 1.0]);
        assert!((error - (0.75_f64 / 4.75).sqrt()).abs() < 1e-12, "{error}");
        let depth = cloud([8, 8, 4], [2.0; 3], 1.5).expect("legal").greatest_cell_depth();
        assert!((depth - 1.5).abs() < 1e-6);
    }
}
