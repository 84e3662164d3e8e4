//! Which layers cast shadows on the ground of a picture, and why none do.

use super::{LayerPlan, PassNote};
use crate::passes::common::Camera;
use crate::passes::shadow::mean::mean_through;
use crate::passes::shadow::{Columns, Shadow};
use glam::Vec3;

/// Shadows are drawn at most this many times coarser than the picture, each way.
const COARSEST: u32 = 2;
/// Below this share of the diffuse light at the ground, the source's light makes no shadow that could be seen.
const LEAST_SHARE: f32 = 2e-3;
/// Rays tried each way for one that meets the ground.
const TRIED: u32 = 16;
/// What is shaded may lie above a layer's base by this many parts of its thickness: tables are kept by it.
const BEGIN_STEPS: f32 = 32.0;

/// The shadows of one picture.
#[derive(Clone, Debug, PartialEq)]
pub struct ShadowPlan {
    /// Pixels of the picture each way to one of the shadows' image.
    pub scale: u32,
    /// One for each layer that casts any.
    pub casters: Vec<LayerShadow>,
    /// Share of the light that all of them let through on the whole, by weather: the surroundings', then each region's.
    pub through: Vec<f32>,
}

/// The shadow of one layer.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerShadow {
    /// Index among the plan's layers.
    pub layer: usize,
    /// How its tables are read.
    pub shadow: Shadow,
    /// What they are made from, one for each chart in use; an executor keeps the tables it has made by these.
    pub columns: Vec<Columns>,
}

/// The light on ground that lies between the clouds.
pub struct Light {
    /// Towards the source.
    pub source: Vec3,
    /// Lux on a plane facing it.
    pub direct_lux: f32,
    /// Lux on a horizontal plane from all the rest.
    pub diffuse_lux: f32,
    /// Of each weather in sight, the surroundings' first, how far the surroundings' gives way to it.
    pub gives_way: Vec<f32>,
}

/// The shadows on the ground, if there is anything to see of them. `deck_scale`: that of the deck.
pub fn cast(
    camera: &Camera,
    light: &Light,
    layers: &[LayerPlan],
    deck_scale: u32,
    notes: &mut Vec<PassNote>,
) -> Option<ShadowPlan> {
    let casters: Vec<LayerShadow> = layers.iter().enumerate().filter_map(|(i, layer)| caster(i, layer)).collect();
    let why_not = if casters.is_empty() {
        Some("no layer has cloud between the ground and the light")
    } else if light.direct_lux * light.source.z.max(0.0) <= LEAST_SHARE * light.diffuse_lux {
        Some("neither sun nor moon lights the ground enough for shadows")
    } else if !sees_ground(camera) {
        Some("no ground is in sight")
    } else {
        None
    };
    let why = why_not.map_or_else(|| format!("{} layers cast shadows on the ground", casters.len()), str::to_owned);
    notes.push(PassNote { pass: "shadow", kept: why_not.is_none(), why });
    why_not.is_none().then(|| {
        let own: Vec<f32> = (0..light.gives_way.len()).map(|weather| through(weather, layers, &casters)).collect();
        let through = own.iter().zip(&light.gives_way).map(|(share, away)| share * (own[0] + (1.0 - own[0]) * away));
        let through = through.collect();
        ShadowPlan { scale: deck_scale.min(COARSEST), casters, through }
    })
}

/// Share of the light that the layers of one weather let through on the whole; they lie at random to each other.
fn through(weather: usize, layers: &[LayerPlan], casters: &[LayerShadow]) -> f32 {
    let own = casters.iter().filter(|caster| layers[caster.layer].layer.region as usize == weather);
    own.map(|caster| {
        let LayerPlan { kind, layer, .. } = &layers[caster.layer];
        mean_through(*kind, &caster.columns[0], layer.theta, layer.patchiness)
    })
    .product()
}

fn caster(index: usize, plan: &LayerPlan) -> Option<LayerShadow> {
    caster_above(index, plan, 0.0)
}

/// The shadow of a layer on what lies at a height over the sphere, if any of the layer is above that.
pub fn caster_above(index: usize, plan: &LayerPlan, height_m: f32) -> Option<LayerShadow> {
    let (base_m, thickness_m) = (plan.layer.base_m, plan.layer.thickness_m);
    let begin = (((height_m - base_m) / thickness_m).clamp(0.0, 1.0) * BEGIN_STEPS).round() / BEGIN_STEPS;
    let towards = plan.light.iter().zip(&plan.towards);
    let columns: Vec<Columns> = towards.map(|(light, towards)| Columns::new(*towards, light, begin)).collect();
    let shadow = columns.first()?.shadow(base_m, thickness_m);
    (begin < 1.0).then_some(LayerShadow { layer: index, shadow, columns })
}

/// Whether a ray of the picture meets the ground. The rays tried stand closer than the ground is wide: seen from 400 km it
/// fills 140 degrees.
fn sees_ground(camera: &Camera) -> bool {
    let at = |i: u32, size: f32| i as f32 / TRIED as f32 * size;
    let ray = |i: u32| camera.ray(at(i % (TRIED + 1), camera.width_px), at(i / (TRIED + 1), camera.height_px));
    camera.eye_m > 0.0 && (0..(TRIED + 1).pow(2)).any(|i| camera.crossings(ray(i).z, 0.0).0.is_finite())
}

#[cfg(test)]
mod tests;
