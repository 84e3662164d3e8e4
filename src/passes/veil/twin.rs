//! Twin of `veil.wgsl`.

use crate::passes::common::Camera;
use crate::passes::deck::field::margin;
use crate::passes::deck::twin::{Prepared, mean_clamped};
use glam::Vec3;

/// Steps through one piece of a layer at most.
const STEPS: f32 = 192.0;
/// Growth of a step with the range.
const GROWTH: f32 = 0.006;
/// Optical depth at which nothing comes through any more.
const DARK: f32 = 12.0;

/// Share of the light of a place that a layer lets through to the eye.
pub fn passed(camera: &Camera, prepared: &Prepared, position_m: Vec3) -> f32 {
    let layer = prepared.layer;
    let away = position_m - Vec3::new(0.0, 0.0, camera.eye_m);
    let range = away.length();
    let direction = away / range.max(1e-3);
    let flat = (1.0 - direction.z * direction.z).max(0.0).sqrt();
    let end = range.min(layer.extent_m / flat.max(1e-3));
    let top_m = layer.base_m + layer.thickness_m;
    let (top_falling, top_rising) = camera.crossings(direction.z, top_m);
    let (base_falling, base_rising) = camera.crossings(direction.z, layer.base_m);
    let (above, over) = (camera.eye_m > top_m, camera.eye_m > layer.base_m);
    if above && top_falling.is_infinite() {
        return 1.0;
    }
    // Under the top from `top_in` to `top_rising`; below the base from `base_in` to `base_out`.
    let top_in = if above { top_falling } else { 0.0 };
    let base_in = if over { base_falling } else { 0.0 };
    let base_out = if over && base_falling.is_infinite() { f32::INFINITY } else { base_rising };
    let walk = Walk { camera, prepared, direction };
    let mut depth = walk.depth(top_in, end.min(top_rising).min(base_in));
    if base_out.is_finite() {
        depth += walk.depth(top_in.max(base_out), end.min(top_rising));
    }
    (-depth).exp()
}

struct Walk<'a> {
    camera: &'a Camera,
    prepared: &'a Prepared<'a>,
    direction: Vec3,
}

impl Walk<'_> {
    /// Optical depth of the layer's cloud between two ranges.
    fn depth(&self, from: f32, to: f32) -> f32 {
        if from >= to {
            return 0.0;
        }
        let layer = self.prepared.layer;
        let least = ((to - from) / STEPS).max(0.01);
        let (mut depth, mut at, mut near) = (0.0, from, self.look(from));
        while at < to && depth < DARK {
            let step = (layer.step_m + GROWTH * at).max(least) + layer.reach_m * (-near).max(0.0);
            let end = to.min(at + step);
            let far = self.look(end);
            let whole = mean_clamped(near * layer.inverse_edge, far * layer.inverse_edge);
            depth += layer.extinction_per_m * (end - at) * whole;
            (near, at) = (far, end);
        }
        depth
    }

    fn look(&self, t: f32) -> f32 {
        let (camera, prepared) = (self.camera, self.prepared);
        let p = self.direction * t + Vec3::new(0.0, 0.0, camera.eye_m);
        let height = camera.height_at(self.direction.z, t);
        margin(prepared.layer, &prepared.textures, camera.earth_m, p, height, t)
    }
}
