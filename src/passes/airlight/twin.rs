//! Twin of `airlight.wgsl`.

use super::{FARTHEST_M, STEPS, Source};
use crate::passes::common::{AIR_SCALE_M, Camera, HAZE_SCALE_M};
use crate::passes::ground;
use crate::passes::sky::atmosphere::{HAZE_ALBEDO, HAZE_ASYMMETRY};
use glam::Vec3;

/// Luminance along a ray of all lights' light that the air scatters once, cd/m2; `passed`: what comes through the clouds at
/// each node of the veil.
pub fn luminance(camera: &Camera, sources: &[Source], passed: &[f32], direction: Vec3) -> f32 {
    let end = ground::twin::range(camera, direction).min(FARTHEST_M);
    let of = |source: &Source| scattered(camera, direction, end, source, STEPS) * passed[source.node as usize];
    sources.iter().map(of).sum()
}

fn scattered(camera: &Camera, direction: Vec3, end: f32, source: &Source, steps: u32) -> f32 {
    let away = Vec3::from(source.position_m) - Vec3::new(0.0, 0.0, camera.eye_m);
    let nearest = away.dot(direction);
    let off = away - direction * nearest;
    let d = (off.length_squared() + source.width_m * source.width_m).sqrt();
    let first = (-nearest / d).atan();
    let width = (((end - nearest) / d).atan() - first) / steps as f32;
    let mut sum = 0.0;
    for i in 0..steps {
        let angle = first + (i as f32 + 0.5) * width;
        let (sine, cosine) = (angle.sin(), angle.cos().max(1e-4));
        let t = (nearest + d * sine / cosine).clamp(0.0, end);
        let height = camera.height_at(direction.z, t).max(0.0);
        let haze = camera.haze_per_m * (-height / HAZE_SCALE_M).exp();
        let air = camera.air_per_m * (-height / AIR_SCALE_M).exp();
        let towards = HAZE_ALBEDO * haze * haze_phase(-sine) + air * 0.059_683_1 * (1.0 + sine * sine);
        sum += towards * (-(haze + air) * d / cosine).exp() * camera.air_transmittance(height, t);
    }
    source.intensity_cd / d * width * sum
}

/// Cornette-Shanks phase function (deck paper eq. 10 over 4 pi) of haze, 1/sr, as in the sky's first order.
fn haze_phase(cosine: f32) -> f32 {
    let f = HAZE_ASYMMETRY;
    let d = 1.0 + f * f - 2.0 * f * cosine;
    0.079_577_47 * 1.5 * (1.0 - f * f) / (2.0 + f * f) * (1.0 + cosine * cosine) / (d * d.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(haze_per_m: f32, air_per_m: f32) -> Camera {
        Camera {
            right: [1.0, 0.0, 0.0],
            width_px: 64.0,
            up: [0.0, 0.0, 0.5],
            height_px: 32.0,
            forward: [0.0, 1.0, 0.0],
            eye_m: 1_000.0,
            earth_m: 6_371_000.0,
            exposure: 1.0,
            haze_per_m,
            air_per_m,
        }
    }

    fn light(position_m: [f32; 3], width_m: f32) -> Source {
        Source { position_m, intensity_cd: 1e8, width_m, node: 0, pad0: 0.0, pad1: 0.0 }
    }

    #[test]
    fn thin_air_has_the_closed_form() {
        // Molecules so thin that they absorb nothing: L = I beta / d times the integral of 3 / 16 pi (1 + sin^2) over the
        // angle, which is 3 / 16 pi (3 a / 2 - sin 2a / 4).
        let air = 1e-12;
        let camera = camera(0.0, air);
        for (position, pixel) in
            [([300.0, 2_000.0, 1_000.0], Vec3::Y), ([0.0, 5_000.0, 3_000.0], Vec3::new(0.1, 1.0, 0.2))]
        {
            let (source, direction) = (light(position, 1.0), pixel.normalize());
            let away = Vec3::from(position) - Vec3::new(0.0, 0.0, camera.eye_m);
            let nearest = away.dot(direction);
            let d = (away - direction * nearest).length();
            let end = 40_000.0;
            let antiderivative = |a: f32| 1.5 * a - 0.25 * (2.0 * a).sin();
            let angle = |t: f32| ((t - nearest) / d).atan();
            let spread = antiderivative(angle(end)) - antiderivative(angle(0.0));
            let density = (-(1_000.0 + 0.5 * (direction.z * nearest).max(0.0)) / AIR_SCALE_M).exp();
            let closed = 1e8 * air * density / d * 0.059_683_1 * spread;
            let found = scattered(&camera, direction, end, &source, STEPS);
            // The closed form takes the air's density where half of the light is; and a dozen steps.
            assert!((found / closed - 1.0).abs() < 0.12, "{found} {closed}");
        }
    }

    #[test]
    fn a_dozen_steps_are_near_many() {
        for haze in [1e-5, 7.5e-5, 3e-4, 3e-3] {
            let camera = camera(haze, 1.2e-5);
            for east in [0.0, 20.0, 200.0, 1_500.0, -4_000.0] {
                for (north, up) in [(500.0, 900.0), (2_000.0, 1_500.0), (20_000.0, 2_000.0), (-800.0, 1_000.0)] {
                    let source = light([east, north, up], 40.0);
                    let at = |steps| scattered(&camera, Vec3::Y, 60_000.0, &source, steps);
                    let (few, many) = (at(STEPS), at(4_000));
                    // The forward peak of the haze is 15 degrees wide, as a step is: 7 % where the light is nearly in the
                    // ray; where haze is thick over the distance to the light, the exponential along a step counts too.
                    let tolerance = if haze * north.abs() > 5.0 { 0.25 } else { 0.08 };
                    assert!((few - many).abs() <= tolerance * many + 1e-12, "{haze} {east} {north}: {few} {many}");
                }
            }
        }
    }

    #[test]
    fn light_grows_towards_the_source_and_is_finite_in_it() {
        let camera = camera(7.5e-5, 1.2e-5);
        let source = light([0.0, 3_000.0, 1_000.0], 50.0);
        let mut before = 0.0;
        for k in (0..40).rev() {
            let direction = Vec3::new(0.01 * k as f32, 1.0, 0.0).normalize();
            let here = luminance(&camera, &[source], &[1.0], direction);
            assert!(here > before && here.is_finite(), "{k}: {here} {before}");
            before = here;
        }
        assert_eq!(luminance(&camera, &[source], &[0.0], Vec3::Y), 0.0, "behind thick cloud there is none");
        let at_the_eye = light([0.0, 0.0, 1_000.0], 0.5);
        assert!(luminance(&camera, &[at_the_eye], &[1.0], Vec3::Y).is_finite());
    }
}
