//! The exposure value: fixed, or a function of the light at the eye and so of the snapshot alone.
//!
//! An automatic exposure has no memory of its own, so that every channel and every repetition shows the same picture. It
//! eases because all that it follows eases: sun, weather, the transitions of regions, the eye's way through a layer.

use super::super::eye::Eye;
use super::super::relight::depth_m;
use super::column::Level;
use crate::passes::relight::Lighting;
use crate::passes::sky::atmosphere::{Air, Luminary};
use crate::passes::sky::multiple::HigherOrders;
use crate::world::command::Exposure;
use crate::world::snapshot::{FlashState, Snapshot};
use glam::{Vec2, Vec3};

/// Share of what is seen that faces the source: the flanks of clouds when the sun is low, which are then the brightest thing in
/// the picture. By the level ground alone evenings were washed out.
const FACING_METERED: f32 = 0.6;
/// The same of the glow around a source that stands on the horizon, where a pilot looks: towards a low sun sky and haze are as
/// bright as sunlit cloud at noon, and evenings were white. Falls with the fourth power of what the height leaves.
const GLOW_METERED: f32 = 2.0;
/// Share of what the sky sends from the source's side beyond an even sky's light that counts once the source has set: by the level
/// ground alone the bright side of a twilight was white.
const TWILIGHT_METERED: f32 = 0.5;
/// Share of a flash's light that the exposure answers to: a whole answer would turn the night black around it, none
/// would leave a white picture without shape.
const FLASH_METERED: f32 = 0.3;
/// The same of its light on a cloud that it lights from [`LIT_CLOUD_M`] away: luminance does not fall with the distance from
/// the eye as illuminance does, and a storm far away would have no shape.
const CLOUD_METERED: f32 = 0.045;
const LIT_CLOUD_M: f32 = 3_000.0;
/// The same where light is scattered many times in the cloud, which keeps it near the channel and sends all of it out: by
/// eye, in pictures of overcast from 4 and 10 km. Deeper in a cloud than [`NEAR_FACE_M`] less in proportion: the light comes
/// out over more of its face, which calls for the square, but breaks out of gaps brighter.
const SCATTERED_METERED: f32 = 0.15;
const NEAR_FACE_M: f32 = 400.0;
/// Beyond this distance storms count less and less, m: they fill less and less of the picture.
const STORMS_COUNT_M: f32 = 60_000.0;

/// The exposure value at ISO 100, given the light at the eye, the cosine of its source against the zenith, and how much more light
/// than that of an even sky comes from the source's side.
pub fn ev100(asked: Exposure, at_eye: &Level, mu: f32, bright_side_lux: f32, snapshot: &Snapshot, eye: &Eye) -> f32 {
    match asked {
        Exposure::Ev100(ev) => ev as f32,
        Exposure::Automatic => {
            let facing =
                FACING_METERED + (1.0 - FACING_METERED) * mu + GLOW_METERED * (1.0 - mu.clamp(0.0, 1.0)).powi(4);
            let steady_lux = at_eye.direct_lux.y * facing + at_eye.diffuse_lux.y + TWILIGHT_METERED * bright_side_lux;
            automatic_ev(steady_lux + flash_lux(snapshot, eye))
        }
    }
}

/// How much more light of the clear sky a plane has that stands upright and faces the brighter luminary than half of what a level one has,
/// which is its part of an even sky; twice that, lux.
pub fn bright_side_lux(air: &Air, higher: &HigherOrders, height_m: f32, lights: &[Luminary; 2]) -> f32 {
    let lights: Vec<Luminary> = lights.iter().filter(|l| l.illuminance_lux != Vec3::ZERO).copied().collect();
    let Some(brightest) = lights.iter().max_by(|a, b| {
        let strength = |l: &Luminary| l.illuminance_lux.y * (8.0 * l.direction.z.min(0.0)).exp();
        strength(a).total_cmp(&strength(b))
    }) else {
        return 0.0;
    };
    let towards = Vec2::new(brightest.direction.x, brightest.direction.y).normalize_or(Vec2::Y);
    let (rows, columns) = (5, 8);
    let (mut upright, mut level) = (0.0, 0.0);
    for row in 0..rows {
        // Even in height over the horizon, where a twilight has its light.
        let up = ((row as f32 + 0.5) / rows as f32).powi(2);
        let flat = (1.0 - up * up).sqrt();
        let solid = 2.0 * up.sqrt() / rows as f32 * (std::f32::consts::TAU / columns as f32);
        for column in 0..columns {
            let (sin, cos) = ((column as f32 + 0.5) / columns as f32 * std::f32::consts::TAU).sin_cos();
            let azimuth = Vec2::new(towards.x * cos - towards.y * sin, towards.x * sin + towards.y * cos) * flat;
            let seen = air.inscatter(higher, height_m, azimuth.extend(up), &lights, 12).0.y;
            upright += seen * (cos * flat).max(0.0) * solid;
            level += seen * up * solid;
        }
    }
    (2.0 * upright - level).max(0.0)
}

/// What the exposure answers to of the flashes of the shutter interval, lux: at the eye, clouds in between not counted, and on
/// clouds beside them.
fn flash_lux(snapshot: &Snapshot, eye: &Eye) -> f32 {
    let metered = |f: &FlashState| match snapshot.quality.relight {
        Lighting::Point | Lighting::Single => CLOUD_METERED,
        Lighting::Basis | Lighting::Hybrid | Lighting::Solve | Lighting::Reference => {
            SCATTERED_METERED * NEAR_FACE_M / (depth_m(snapshot, f) as f32).max(NEAR_FACE_M)
        }
    };
    let at = |f: &FlashState| {
        let away_m = (eye.place(&f.position) - Vec3::new(0.0, 0.0, eye.height_m as f32)).length();
        let at_eye = FLASH_METERED / (away_m * away_m).max(1e6);
        let far = away_m / STORMS_COUNT_M;
        let on_cloud = metered(f) / (LIT_CLOUD_M * LIT_CLOUD_M) / (1.0 + far * far);
        f.intensity_cd as f32 * (at_eye + on_cloud)
    };
    snapshot.flashes.iter().filter(|f| f.intensity_cd > 0.0).map(at).sum()
}

/// Exposure for 1e5 lux, of which it is the power -0.8.
pub const FULL_LUX_EXPOSURE: f32 = 1.0 / (1.2 * 19_483.9);

/// Exposure value for an illuminance: by day such that a cloud in full sun (an albedo of 0.8) is near white, lagging behind at
/// night as eyes do.
fn automatic_ev(lux: f32) -> f32 {
    (14.25 + 0.80 * (lux.max(1e-6) / 1e5).log2()).clamp(-2.0, 15.5)
}
