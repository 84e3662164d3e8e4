//! Twin of `stroke.wgsl`: the same lines of light, each added to the pixels within its reach.

use super::{REACH, SHORTEST_PX, Segment};
use glam::Vec2;

/// Luminance of all segments, cd/m2, row by row; `passed`: what comes through the clouds at each node of the veil.
pub fn image(size_px: [u32; 2], segments: &[Segment], passed: &[f32]) -> Vec<f32> {
    let [width, height] = size_px.map(|n| n as usize);
    let mut image = vec![0.0; width * height];
    for segment in segments {
        let (from, to) = (Vec2::from(segment.from_px), Vec2::from(segment.to_px));
        let reach = REACH * segment.sigma_px;
        let [low, high] = [from.min(to) - reach, from.max(to) + reach];
        let pixels = |low: f32, high: f32, count: usize| {
            (low.floor().clamp(0.0, count as f32) as usize)..(high.ceil().clamp(0.0, count as f32) as usize)
        };
        for y in pixels(low.y, high.y, height) {
            for x in pixels(low.x, high.x, width) {
                image[x + y * width] += luminance(segment, passed, Vec2::new(x as f32 + 0.5, y as f32 + 0.5));
            }
        }
    }
    image
}

/// Luminance of one segment at a place of the picture, pixels.
pub fn luminance(segment: &Segment, passed: &[f32], at: Vec2) -> f32 {
    let (from, to) = (Vec2::from(segment.from_px), Vec2::from(segment.to_px));
    let length = from.distance(to);
    let along = if length > 1e-6 { (to - from) / length } else { Vec2::X };
    let (s, h) = (along.dot(at - from), along.perp_dot(at - from));
    let reach = REACH * segment.sigma_px;
    if h.abs() > reach || s < -reach || s > length + reach {
        return 0.0;
    }
    let unit = std::f32::consts::FRAC_1_SQRT_2 / segment.sigma_px;
    let bell = |x: f32| 0.564_189_6 * unit * (-x * x * unit * unit).exp();
    let profile = if length < SHORTEST_PX {
        bell(h) * bell(s - 0.5 * length)
    } else {
        bell(h) * 0.5 * (erf(s * unit) - erf((s - length) * unit)) / length
    };
    let mix = |a: f32, b: f32, share: f32| a + (b - a) * share;
    let share = mix(segment.share_from, segment.share_to, (s / length.max(1e-6)).clamp(0.0, 1.0));
    let node = segment.node as usize;
    segment.light * profile * mix(passed[node], passed[node + 1], share)
}

/// Abramowitz and Stegun 7.1.26: to 1.5e-7.
fn erf(x: f32) -> f32 {
    let t = 1.0 / (1.0 + 0.327_591_1 * x.abs());
    let poly = t * (0.254_829_6 + t * (-0.284_496_72 + t * (1.421_413_8 + t * (-1.453_152 + t * 1.061_405_4))));
    x.signum() * (1.0 - poly * (-x * x).exp())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::passes::stroke::NARROWEST_PX;

    fn segment(from_px: [f32; 2], to_px: [f32; 2], sigma_px: f32) -> Segment {
        Segment { from_px, to_px, light: 100.0, sigma_px, share_from: 0.0, share_to: 1.0, node: 0, pad: 0 }
    }

    fn sum(segments: &[Segment], passed: &[f32]) -> f32 {
        image([64, 48], segments, passed).iter().sum()
    }

    #[test]
    fn a_lines_light_is_kept_whatever_its_length_width_and_place() {
        for sigma in [NARROWEST_PX, 1.0, 2.7] {
            for length in [0.0, 0.01, 0.049, 0.051, 0.3, 1.0, 7.3, 20.0] {
                for k in 0..7 {
                    let (x, angle) = (22.0 + 0.137 * k as f32, 0.4 * k as f32);
                    let (from, way) = (Vec2::new(x, 20.3), Vec2::from_angle(angle) * length);
                    let found = sum(&[segment(from.into(), (from + way).into(), sigma)], &[1.0, 1.0]);
                    // Sums at pixels' centres: 2 exp(-2 pi^2 0.6^2) = 1.6e-3 for each axis; beyond the reach 6e-5 each.
                    assert!((found - 100.0).abs() < 0.4, "sigma {sigma}, length {length}: {found}");
                }
            }
        }
    }

    #[test]
    fn a_line_cut_in_two_is_the_same_line() {
        let (a, b, c) = ([10.2, 9.7], [15.8, 14.6], [21.4, 19.5]);
        let half = |from, to| Segment { light: 50.0, ..segment(from, to, 0.8) };
        let whole = image([32, 32], &[segment(a, c, 0.8)], &[1.0, 1.0]);
        let cut = image([32, 32], &[half(a, b), half(b, c)], &[1.0, 1.0]);
        let most = whole.iter().copied().fold(0.0, f32::max);
        // Rounding, and the approximation of the error function.
        assert!(whole.iter().zip(&cut).all(|(a, b)| (a - b).abs() < 2e-3 * most));
    }

    #[test]
    fn the_veil_is_laid_over_it_from_node_to_node() {
        let line = segment([10.0, 20.5], [50.0, 20.5], 1.0);
        assert_eq!(sum(&[line], &[0.0, 0.0]), 0.0);
        let half = sum(&[line], &[0.0, 1.0]);
        assert!((half - 50.0).abs() < 0.5, "{half}");
        let near = |x: f32| {
            luminance(&line, &[0.2, 0.6], Vec2::new(x, 20.5)) / luminance(&line, &[1.0, 1.0], Vec2::new(x, 20.5))
        };
        assert!((near(20.0) - 0.3).abs() < 1e-3 && (near(40.0) - 0.5).abs() < 1e-3);
    }

    #[test]
    fn the_error_function_has_its_published_values() {
        // Abramowitz and Stegun, table 7.1.
        for (x, value) in [(0.0, 0.0), (0.5, 0.520_499_9), (1.0, 0.842_700_8), (2.0, 0.995_322_3)] {
            assert!((erf(x) - value).abs() < 5e-7 && (erf(-x) + value).abs() < 5e-7);
        }
    }
}
