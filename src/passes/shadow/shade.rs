//! Shade of higher layers on a lower one: a map around the eye of what they let through, at the height of the lower one's top.
//!
//! The light is parallel: from any point of the layer it is followed up to that height, so that one map serves all
//! heights of the layer. It is made for a picture's eye, finest below it: coordinates are the logarithm of the distance.

use super::twin::Caster;
use crate::passes::common::stereographic;
use crate::passes::deck::Layer;
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// Texels across.
pub const WIDTH: usize = 256;
/// Distance at which a texel is twice as wide as in the middle, m.
pub const NEAR_M: f32 = 1_500.0;
/// Slant of the light's way at most, as a sine: what is lit flatter is taken from there.
const LEAST_SINE: f32 = 0.05;

/// 1 over the logarithm that reaches from the middle to a distance at the rim.
pub fn span(extent_m: f32) -> f32 {
    1.0 / (1.0 + extent_m / NEAR_M).ln()
}

/// The map of a layer: shares of the light, row by row.
pub fn map(layer: &Layer, casters: &[Caster], earth_m: f32) -> Vec<f32> {
    (0..WIDTH * WIDTH)
        .into_par_iter()
        .map(|i| {
            let at = Vec2::new((i % WIDTH) as f32 + 0.5, (i / WIDTH) as f32 + 0.5) * (2.0 / WIDTH as f32) - 1.0;
            let share = at.length();
            let distance_m = layer.shade_near_m * ((share / layer.shade_span).exp() - 1.0);
            // Stereographic coordinates as a tangent of half the angle at the Earth's centre.
            let tangent = at * (distance_m / (share.max(1e-6) * 2.0 * earth_m));
            let fall = 2.0 / (1.0 + tangent.length_squared());
            let radius = earth_m + layer.shade_height_m;
            let p = (tangent * (fall * radius)).extend(layer.shade_height_m - radius * fall * tangent.length_squared());
            let texel_m = (distance_m + layer.shade_near_m) * (2.0 / (WIDTH as f32 * layer.shade_span));
            casters.iter().map(|c| c.through_at(earth_m, p, layer.shade_height_m, texel_m)).product()
        })
        .collect()
}

/// Share of the light that reaches a point of the layer at a height over the sphere, by its map.
pub fn at(layer: &Layer, map: &[f32], earth_m: f32, p: Vec3, height_m: f32) -> f32 {
    let light = Vec3::from(layer.light_direction);
    let radius = earth_m + height_m;
    let sine = (p + Vec3::new(0.0, 0.0, earth_m)).dot(light) / radius;
    let away_m = (layer.shade_height_m - height_m) / sine.max(LEAST_SINE);
    let z = stereographic(p, earth_m, radius) + Vec2::new(light.x, light.y) * away_m;
    let distance_m = z.length();
    let share = (1.0 + distance_m / layer.shade_near_m).ln() * layer.shade_span;
    let place = (z * (share / distance_m.max(1e-3)) * 0.5 + 0.5) * WIDTH as f32 - 0.5;
    let (low, f) = (place.floor(), place - place.floor());
    let texel = |dx: i32, dy: i32| {
        let clamped = |v: f32, d: i32| (v as i32 + d).clamp(0, WIDTH as i32 - 1) as usize;
        map[clamped(low.x, dx) + clamped(low.y, dy) * WIDTH]
    };
    let row = |dy: i32| texel(0, dy) + (texel(1, dy) - texel(0, dy)) * f.x;
    row(0) + (row(1) - row(0)) * f.y
}
