//! Which layers are shaded by higher ones, and the light that they have between those shadows.

use super::illuminance::Illuminance;
use super::shadow::{LayerShadow, caster_above};
use super::{LayerPlan, PassNote};
use crate::passes::deck::Layer;
use crate::passes::shadow::mean::mean_through;
use crate::passes::shadow::shade;
use glam::Vec3;

/// Below this share of the diffuse light the source's makes no shade that could be seen.
const LEAST_SHARE: f32 = 2e-3;
/// Higher layers that let through all but this share, or no more than it, need no map: their light is even.
const EVEN: f32 = 5e-3;

/// Gives each layer that higher ones shade the parameters of its map, and the source's light as it is between their
/// shadows; what they stop of it beyond the columns' estimate is scattered and comes down as diffuse light, so that the mean
/// stays.
pub fn cast(light: &Illuminance, layers: &mut [LayerPlan], notes: &mut Vec<PassNote>) {
    let mut shaded = 0;
    for lower in 0..layers.len() {
        let top_m = layers[lower].layer.base_m + layers[lower].layer.thickness_m;
        let own = layers[lower].layer;
        // A region's layers are shaded by its own; those around the regions also by what towers in these.
        let near = |higher: &usize| *higher != lower && [0, layers[*higher].layer.region].contains(&own.region);
        let casters: Vec<LayerShadow> =
            (0..layers.len()).filter(near).filter_map(|higher| caster_above(higher, &layers[higher], top_m)).collect();
        let through = through(own.region, layers, &casters);
        let column = own.region as usize;
        let clear_lux = light.columns[column].top.direct_lux * light.reddening(column, top_m.into());
        let mu = light.source.z.max(0.0);
        let seen = casters.iter().any(|c| layers[c.layer].layer.region != own.region) || through < 1.0 - EVEN;
        let lit = clear_lux.y * mu * through.max(EVEN) > LEAST_SHARE * own.sky_lux[1] * 4.0 * std::f32::consts::PI;
        if casters.is_empty() || !seen || through < EVEN || !lit {
            continue;
        }
        shaded += 1;
        layers[lower].layer = between_shadows(&own, clear_lux, through * mu, mu, top_m);
        let map = &layers[lower].layer;
        let map = casters.into_iter().map(|mut caster| {
            (caster.shadow.at_m, caster.shadow.near_m, caster.shadow.span) =
                (map.shade_height_m, map.shade_near_m, map.shade_span);
            caster
        });
        layers[lower].shade = map.collect();
    }
    let why = match shaded {
        0 => "no layer is shaded by a higher one, or there is too little light for it".to_owned(),
        n => format!("{n} layers are shaded by higher ones"),
    };
    notes.push(PassNote { pass: "shade", kept: shaded > 0, why });
}

/// A layer with the light between the shadows of higher ones, and where their map lies.
fn between_shadows(own: &Layer, clear_lux: Vec3, level: f32, mu: f32, top_m: f32) -> Layer {
    let stopped = (Vec3::from(own.light_lux) * mu - clear_lux * level) * 0.079_577_47;
    let sky = Vec3::from(own.sky_lux);
    Layer {
        light_lux: clear_lux.into(),
        sky_lux: (sky + stopped).max(0.5 * sky).into(),
        shade_height_m: top_m,
        shade_near_m: shade::NEAR_M,
        shade_span: shade::span(own.extent_m),
        ..*own
    }
}

/// Share of the light that the casters of one weather let through on the whole; they lie at random to each other.
fn through(region: u32, layers: &[LayerPlan], casters: &[LayerShadow]) -> f32 {
    let own = casters.iter().filter(|caster| layers[caster.layer].layer.region == region);
    own.map(|caster| {
        let LayerPlan { kind, layer, .. } = &layers[caster.layer];
        mean_through(*kind, &caster.columns[0], layer.theta, layer.patchiness)
    })
    .product()
}

#[cfg(test)]
mod tests;
