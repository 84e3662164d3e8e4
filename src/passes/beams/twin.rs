//! Twin of `beams.wgsl`.

use super::{Beams, LOOKS, Lamp, RATIO, TAKEN, ranges_m};
use crate::passes::deck::field::phases;
use glam::Vec3;

/// A ray passes a lamp no nearer than its glass, m^2.
const GLASS_M2: f32 = 0.04;

/// Luminance of all lamps' light along a ray that ends at `end_m`, cd/m2.
pub fn luminance(beams: &Beams, direction: Vec3, end_m: f32) -> f32 {
    let (mut sum, mut depth, mut begin) = (0.0, 0.0, 0.0f32);
    for (t, extinction) in ranges_m().into_iter().zip(beams.extinction_per_m).take(LOOKS) {
        // Each look stands for the stretch between the middles, by ratio, to its neighbours.
        let until = (t * RATIO.sqrt()).min(end_m);
        let ds = (until - begin).max(0.0);
        let at = t.min(0.5 * (begin + until));
        let before = depth + 0.5 * extinction * ds;
        for lamp in &beams.lamp[..beams.lamps as usize] {
            let way = direction * at - Vec3::from(lamp.position_m);
            let squared = way.length_squared().max(GLASS_M2);
            let distance = squared.sqrt();
            let towards = way / distance;
            // From the lamp it is as thick as from the eye, metre for metre.
            let passed = (-TAKEN * before * (1.0 + distance / at.max(1e-3))).exp();
            sum += shines(lamp, towards) * phases(-towards.dot(direction))[0] * extinction * ds * passed / squared;
        }
        depth += extinction * ds;
        begin = until.max(begin);
    }
    sum
}

/// Intensity in a direction, cd: a Gaussian of the angle from the axis (by the chord, which at ten degrees is an eighth of a
/// per cent shorter).
pub fn shines(lamp: &Lamp, towards: Vec3) -> f32 {
    lamp.intensity_cd * (-(towards - Vec3::from(lamp.axis)).length_squared() * lamp.narrowness).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn beams(lamp: Lamp, extinction: f32) -> Beams {
        let mut lamps = [Lamp::default(); super::super::LAMPS];
        lamps[0] = lamp;
        Beams { lamps: 1, pad0: 0, pad1: 0, pad2: 0, lamp: lamps, extinction_per_m: [extinction; LOOKS] }
    }

    fn landing(right_m: f32) -> Lamp {
        Lamp { position_m: [right_m, -2.0, -1.5], intensity_cd: 6e5, axis: [0.0, 1.0, 0.0], narrowness: 60.0 }
    }

    fn strobe() -> Lamp {
        Lamp { position_m: [17.0, -8.0, 0.0], intensity_cd: 1_200.0, axis: [0.0, 0.0, 1.0], narrowness: 0.0 }
    }

    /// The same integral by many even steps.
    fn many(lamp: &Lamp, extinction: f32, direction: Vec3) -> f32 {
        let ds = 0.01;
        let at = |k: u32| {
            let t = (k as f32 + 0.5) * ds;
            let way = direction * t - Vec3::from(lamp.position_m);
            let squared = way.length_squared().max(GLASS_M2);
            let towards = way / squared.sqrt();
            let passed = (-TAKEN * extinction * (t + squared.sqrt())).exp();
            f64::from(shines(lamp, towards) * phases(-towards.dot(direction))[0] * extinction * ds * passed / squared)
        };
        (0..46_000).map(at).sum::<f64>() as f32
    }

    #[test]
    fn few_looks_are_near_many() {
        for extinction in [0.003, 0.02, 0.06] {
            for direction in [Vec3::Y, Vec3::new(0.2, 1.0, 0.1), Vec3::new(-0.3, 1.0, -0.2), Vec3::new(0.05, 1.0, 0.0)]
            {
                let direction = direction.normalize();
                for lamp in [landing(3.0), strobe()] {
                    let (few, exact) =
                        (luminance(&beams(lamp, extinction), direction, 1e9), many(&lamp, extinction, direction));
                    // Looks a third further each: a beam's edge of ten degrees is crossed within three of them.
                    assert!((few / exact - 1.0).abs() < 0.12, "{extinction} {direction} {lamp:?}: {few}, {exact}");
                }
            }
        }
    }

    #[test]
    fn a_lamp_all_round_in_thin_haze_has_the_closed_form() {
        // With nothing taken away and a phase function p(angle), L = I sigma / d times the integral of p over the angle at which
        // the ray's points are seen from the lamp (Kulla and Fajardo 2012).
        let (lamp, extinction) = (strobe(), 1e-7);
        let direction = Vec3::Y;
        let away = Vec3::from(lamp.position_m);
        let nearest = away.dot(direction);
        let d = (away - direction * nearest).length();
        let [first, last] = [0.0, 462.0f32].map(|t| ((t - nearest) / d).atan());
        let step = (last - first) / 4_000.0;
        let angle = |k: u32| first + (k as f32 + 0.5) * step;
        let integral: f32 = (0..4_000).map(|k| phases(-angle(k).sin())[0] * step).sum();
        let closed = lamp.intensity_cd * extinction / d * integral;
        let found = luminance(&beams(lamp, extinction), direction, 1e9);
        // Looks a third further each.
        assert!((found / closed - 1.0).abs() < 0.05, "{found} {closed}");
    }

    #[test]
    fn clear_air_ground_and_lamps_that_are_off_give_nothing() {
        let lit = |extinction, end_m| luminance(&beams(landing(3.0), extinction), Vec3::Y, end_m);
        assert_eq!(lit(0.0, 1e9), 0.0);
        assert_eq!(lit(0.05, 0.0), 0.0);
        assert!(lit(0.05, 30.0) > 0.0 && lit(0.05, 30.0) < 0.9 * lit(0.05, 1e9));
        let off = Beams { lamps: 0, ..beams(landing(3.0), 0.05) };
        assert_eq!(luminance(&off, Vec3::Y, 1e9), 0.0);
        // In the lamp itself it is finite.
        let own = Lamp { position_m: [0.0; 3], ..landing(0.0) };
        assert!(luminance(&beams(own, 0.06), Vec3::Y, 1e9).is_finite());
    }
}
