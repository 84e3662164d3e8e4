//! Light that the air scatters towards the eye: the first order along the ray, the higher ones from [`super::multiple`].
//!
//! Haze scatters so much forwards that about half of it goes on as if nothing had happened: on its way to the point and from
//! there to the eye light loses the rest alone (delta-M, Wiscombe 1977), while what the first order sends to the eye has the
//! whole phase function (Nakajima and Tanaka 1988), but its peak fades the more haze has been passed, since each further
//! scattering spreads it. By Beer's law with all of the haze a sky of 5 km visibility was 40 % too
//! dark against Monte Carlo of all orders (`stormdeck report sky`), with all of the peak up to twice too bright next to a low sun.

use super::atmosphere::{Air, HAZE_ALBEDO, HAZE_ASYMMETRY, Luminary, Medium, RAYLEIGH_PER_M, path};
use super::multiple::HigherOrders;
use super::shade::Shade;
use crate::passes::common::{AIR_SCALE_M, HAZE_SCALE_M};
use glam::Vec3;

/// How fast the forward peak of the first order fades with the depth of what goes on forwards: it is spread by each further scattering
/// (Nakajima and Tanaka 1988 correct it for that; this one number stands for it, from Monte Carlo).
const PEAK_FADES: f32 = 0.5;
/// Asymmetry of what is left of the phase function without its peak (delta-M of Henyey and Greenstein).
const REST: f32 = HAZE_ASYMMETRY / (1.0 + HAZE_ASYMMETRY);
/// Share of the haze's extinction that goes on forwards: g^2 of what is scattered.
const FORWARD: f32 = HAZE_ALBEDO * HAZE_ASYMMETRY * HAZE_ASYMMETRY;

/// Clouds above a ray, and how far it is followed.
#[derive(Clone, Copy, Debug)]
pub struct Under<'a> {
    /// What they leave of the light; `None`: a clear sky.
    pub shade: Option<&'a Shade>,
    /// Range at which the stretch ends, m, if neither ground nor space comes before.
    pub end_m: f32,
}

impl Default for Under<'_> {
    fn default() -> Self {
        Self { shade: None, end_m: f32::INFINITY }
    }
}

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
        self.inscatter_under(higher, eye_m, direction, lights, steps, &Under::default())
    }

    /// As [`Air::inscatter`] with clouds that take of the light, over a stretch of the ray.
    pub fn inscatter_under(
        &self,
        higher: &HigherOrders,
        eye_m: f32,
        direction: Vec3,
        lights: &[Luminary],
        steps: u32,
        under: &Under,
    ) -> (Vec3, Vec3) {
        let [begin, end] = path(eye_m, direction.z).0;
        let end = end.min(under.end_m);
        let scaled = Air { haze_per_m: self.haze_per_m * (1.0 - FORWARD) };
        let (mut light, mut reaching, mut passed) = (Vec3::ZERO, Vec3::ONE, Vec3::ONE);
        let (mut before, mut depth) = (begin, 0.0);
        for step in 0..steps {
            let share = (step + 1) as f32 / steps as f32;
            let t = begin + (end - begin) * share * share;
            let (mid, ds) = (0.5 * (t + before), t - before);
            before = t;
            let height = Medium::along(eye_m, direction, direction, mid).height_m;
            let rayleigh = RAYLEIGH_PER_M * (-height / AIR_SCALE_M).exp();
            let haze = self.haze_per_m * (-height / HAZE_SCALE_M).exp();
            let clear = rayleigh + Medium::ozone_per_m(height);
            let extinction = clear + Vec3::splat((1.0 - FORWARD) * haze);
            let through = (-extinction * ds).exp();
            let (shown, diffuse) = under.shade.map_or((1.0, Vec3::ONE), |shade| shade.at(height));
            depth += 0.5 * haze * ds;
            let mut source = Vec3::ZERO;
            for l in lights {
                let up = Medium::along(eye_m, direction, l.direction, mid).up;
                let lit = scaled.transmittance(height, up) * l.illuminance_lux * shown;
                let cos = direction.dot(l.direction);
                let peak = (-PEAK_FADES * FORWARD * (depth + self.haze_depth(height, up))).exp();
                let smooth = (1.0 - HAZE_ASYMMETRY * HAZE_ASYMMETRY) * haze_phase(cos, REST);
                let phase = smooth + (haze_phase(cos, HAZE_ASYMMETRY) - smooth) * peak;
                let single = rayleigh * (0.059_683 * (1.0 + cos * cos)) + Vec3::splat(HAZE_ALBEDO * haze * phase);
                let further = higher.luminance(height, up) * l.illuminance_lux * diffuse;
                source += lit * single + further * (rayleigh + Vec3::splat((HAZE_ALBEDO - FORWARD) * haze));
            }
            light += reaching * source * ((Vec3::ONE - through) / extinction.max(Vec3::splat(1e-12)));
            depth += 0.5 * haze * ds;
            reaching *= through;
            passed *= (-(clear + Vec3::splat(haze)) * ds).exp();
        }
        (light, passed)
    }
}

/// Cornette-Shanks phase function (deck paper eq. 10 over 4 pi) of an asymmetry, 1/sr.
fn haze_phase(cos: f32, f: f32) -> f32 {
    let shape = 1.5 * (1.0 - f * f) / (2.0 + f * f) * (1.0 + cos * cos) / (1.0 + f * f - 2.0 * f * cos).powf(1.5);
    shape * 0.079_577_47
}
