//! Twin of `relief.wgsl`: follows a ray over the grids to the ground.

use super::field::{Grids, level, place};
use crate::passes::common::Camera;
use glam::Vec3;

/// Steps at most.
pub const STEPS: u32 = 160;
/// Halvings of the step that went into the ground.
const HALVINGS: u32 = 6;
/// Growth of the shortest step with the range: a node of the level that is read there has as much.
const GROWTH: f32 = 0.008;
/// Share of the height over the ground that a step may go: slopes of 1 in 1.4 and less are never missed.
const SAFE_SHARE: f32 = 1.4;

/// Range at which a ray meets the ground; infinite if it does not.
pub fn range(grids: &Grids, camera: &Camera, direction: Vec3) -> f32 {
    let relief = grids.relief;
    let up = direction.z;
    let clearance = |t: f32| {
        let height = camera.height_at(up, t);
        let p = direction * t + Vec3::new(0.0, 0.0, camera.eye_m);
        let place = place(relief, p, camera.earth_m, camera.earth_m + height);
        height - grids.at(place, level(relief, place, t)).x
    };
    let (falling, rising) = camera.crossings(up, relief.highest_m);
    let sea = camera.crossings(up, 0.0).0;
    let above = camera.eye_m > relief.highest_m;
    // From above the highest ground to the sea, or out through it again; from below to where it is left.
    let begin = if above { falling } else { 0.0 };
    let end = sea.min(rising);
    if begin >= end {
        return sea;
    }
    let mut t = begin;
    let mut clear = clearance(t);
    let mut steps = 0;
    while t < end && steps < STEPS {
        let next = (t + (SAFE_SHARE * clear).max(0.5 * relief.spacing_m + GROWTH * t)).min(end);
        let found = clearance(next);
        if found < 0.0 {
            let (mut over, mut under) = (t, next);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (over + under);
                if clearance(middle) < 0.0 { under = middle } else { over = middle }
            }
            return 0.5 * (over + under);
        }
        (t, clear) = (next, found);
        steps += 1;
    }
    sea
}
