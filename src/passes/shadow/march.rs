//! The integral that the table stands for: the deck's own field, followed along the light in small steps. Too slow for
//! pictures; tests and the report hold the table against it.

use crate::passes::deck::Layer;
use crate::passes::deck::field::{Textures, margin};
use glam::Vec3;

/// Share, 0 to 1, of the light that a layer lets through to a point of the ground (east, north, height over the tangent
/// plane), by `steps` midpoints (at least 1) between base and top. Without the fine detail near the eye, which shadows
/// do not know.
pub fn through(layer: &Layer, textures: &Textures, earth_m: f32, p: Vec3, steps: u32) -> f32 {
    through_from(layer, textures, earth_m, p, 0.0, steps)
}

/// The same for a point at a height over the sphere.
pub fn through_from(layer: &Layer, textures: &Textures, earth_m: f32, p: Vec3, from_m: f32, steps: u32) -> f32 {
    let light = Vec3::from(layer.light_direction);
    let centre = Vec3::new(0.0, 0.0, earth_m);
    let b = (p + centre).dot(light);
    if b <= 0.0 {
        return 1.0;
    }
    // Distances at which the light's path crosses base and top (see `common::Camera::crossings`).
    let at = |height_m: f32| {
        let above_m = (height_m - from_m).max(0.0);
        let c = above_m * (2.0 * (earth_m + from_m) + above_m);
        c / (b + (b * b + c).sqrt())
    };
    let (begin, end) = (at(layer.base_m), at(layer.base_m + layer.thickness_m));
    let ds = (end - begin) / steps as f32;
    let whole = |k: u32| {
        let s = begin + (k as f32 + 0.5) * ds;
        let q = p + light * s;
        // The height without the cancellation of two radii: half a metre in f32.
        let d = s * (2.0 * b + s);
        let start_m = earth_m + from_m;
        let height_m = from_m + d / ((start_m * start_m + d).sqrt() + start_m);
        (margin(layer, textures, earth_m, q, height_m, f32::MAX) * layer.inverse_edge).clamp(0.0, 1.0)
    };
    (-layer.extinction_per_m * ds * (0..steps).map(whole).sum::<f32>()).exp()
}
