//! Light that the air scatters towards the eye: the first order along the ray, the higher ones from [`super::multiple`].

use super::atmosphere::{Air, HAZE_ALBEDO, HAZE_ASYMMETRY, Luminary, Medium, RAYLEIGH_PER_M, path};
use super::multiple::HigherOrders;
use crate::passes::common::{AIR_SCALE_M, HAZE_SCALE_M};
use glam::Vec3;

impl Air {
    /// Light scattered into a ray from a height, cd/m2 per colour, and the transmittance of the ray (to the ground or
    /// to space), given what this air scatters more than once, by `steps` steps that grow with the distance from where the ray enters the air.
    pub fn inscatter(
        &self,
        higher: &HigherOrders,
        eye_m: f32,
        direction: Vec3,
        lights: &[Luminary],
        steps: u32,
    ) -> (Vec3, Vec3) {
        let [begin, end] = path(eye_m, direction.z).0;
        let (mut light, mut passed) = (Vec3::ZERO, Vec3::ONE);
        let mut before = begin;
        for step in 0..steps {
            let share = (step + 1) as f32 / steps as f32;
            let t = begin + (end - begin) * share * share;
            let (mid, ds) = (0.5 * (t + before), t - before);
            before = t;
            let height = Medium::along(eye_m, direction, direction, mid).height_m;
            let rayleigh = RAYLEIGH_PER_M * (-height / AIR_SCALE_M).exp();
            let haze = self.haze_per_m * (-height / HAZE_SCALE_M).exp();
            let extinction = rayleigh + Vec3::splat(haze) + Medium::ozone_per_m(height);
            let through = (-extinction * ds).exp();
            let mut source = Vec3::ZERO;
            for l in lights {
                let up = Medium::along(eye_m, direction, l.direction, mid).up;
                let lit = self.transmittance(height, up) * l.illuminance_lux;
                let cos = direction.dot(l.direction);
                let single =
                    rayleigh * (0.059_683 * (1.0 + cos * cos)) + Vec3::splat(HAZE_ALBEDO * haze * haze_phase(cos));
                let further = higher.luminance(height, up) * l.illuminance_lux;
                source += lit * single + further * (rayleigh + Vec3::splat(HAZE_ALBEDO * haze));
            }
            light += passed * source * ((Vec3::ONE - through) / extinction.max(Vec3::splat(1e-12)));
            passed *= through;
        }
        (light, passed)
    }
}

/// Cornette-Shanks phase function (deck paper eq. 10 over 4 pi) of haze, asymmetry 0.76, 1/sr.
fn haze_phase(cos: f32) -> f32 {
    let f = HAZE_ASYMMETRY;
    let shape = 1.5 * (1.0 - f * f) / (2.0 + f * f) * (1.0 + cos * cos) / (1.0 + f * f - 2.0 * f * cos).powf(1.5);
    shape * 0.079_577_47
}
