//! The part of the horizon that a picture sees, so that the deck's mesh is made for it alone.

use crate::passes::common::Camera;
use bytemuck::{Pod, Zeroable};
use std::f32::consts::{PI, TAU};

/// Widest step of azimuth between two columns of the mesh.
const STEP_RAD: f32 = 0.06;

/// Azimuths of the mesh's columns. Parameters; twin of `Sector` in `deck.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Sector {
    /// Azimuth of the first column, clockwise from north.
    pub first_rad: f32,
    /// Step from column to column.
    pub step_rad: f32,
}

/// The sector of a picture and the number of steps across it.
pub fn sector(camera: &Camera) -> (Sector, u32) {
    let (width, height) = (camera.width_px, camera.height_px);
    let middle = camera.ray(0.5 * width, 0.5 * height);
    // Azimuths run away near the vertical: where it is in the picture or near its edge, take the whole circle.
    let sees_vertical = |up: f32| {
        let v = glam::Vec3::new(0.0, 0.0, up);
        let [forward, right, up] = [camera.forward, camera.right, camera.up].map(glam::Vec3::from);
        let along = |v: glam::Vec3, axis: glam::Vec3| v.dot(axis) / axis.length_squared();
        // In a lopsided frustum `forward` leans from the picture's axis towards its middle.
        let lean = [along(forward, right), along(forward, up)];
        let ahead = v.dot(forward - right * lean[0] - up * lean[1]);
        let inside = |axis, lean: f32| (along(v, axis) - lean * ahead).abs() < 1.05 * ahead;
        ahead > 0.0 && inside(right, lean[0]) && inside(up, lean[1])
    };
    let whole = (Sector { first_rad: 0.0, step_rad: TAU / 105.0 }, 105);
    if sees_vertical(1.0) || sees_vertical(-1.0) {
        return whole;
    }
    let azimuth = |d: glam::Vec3| d.x.atan2(d.y);
    let forward = azimuth(middle);
    let (mut low, mut high) = (0.0f32, 0.0f32);
    for i in 0..=64 {
        let s = i as f32 / 64.0;
        for (x, y) in [(s, 0.0), (s, 1.0), (0.0, s), (1.0, s)] {
            let away = azimuth(camera.ray(x * width, y * height)) - forward;
            let away = (away + PI).rem_euclid(TAU) - PI;
            (low, high) = (low.min(away), high.max(away));
        }
    }
    let span = high - low + 2.0 * STEP_RAD;
    if span > 0.9 * TAU {
        return whole;
    }
    let steps = (span / STEP_RAD).ceil() as u32;
    (Sector { first_rad: forward + low - STEP_RAD, step_rad: span / steps as f32 }, steps)
}
