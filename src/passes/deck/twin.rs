//! Twin of `deck.wgsl`: walks the crossings of a ray with slices and rings from near to far.

use super::Layer;
use super::field::{Textures, phase, sample, source};
use crate::clouds::slices::heights;
use crate::passes::common::{Camera, smoothstep};
use glam::Vec3;

/// Where the walk stops: what is behind adds less than this share.
pub const OPAQUE: f32 = 0.004;

/// What a ray has gathered: luminance towards the eye, and how much of what is behind still passes.
#[derive(Clone, Copy, Debug)]
pub struct Gathered {
    /// cd/m2 per colour.
    pub luminance: Vec3,
    /// 0 to 1.
    pub transmittance: f32,
}

/// One layer ready to be walked.
pub struct Prepared<'a> {
    /// Parameters.
    pub layer: &'a Layer,
    /// Heights of the slices over the sphere, lowest first.
    pub slices: Vec<f32>,
    /// What its look-ups read.
    pub textures: Textures<'a>,
}

impl<'a> Prepared<'a> {
    /// A layer with `slices` slices.
    pub fn new(layer: &'a Layer, slices: u32, textures: Textures<'a>) -> Self {
        let slices = heights(slices, layer.thickness_m).into_iter().map(|h| layer.base_m + h).collect();
        Self { layer, slices, textures }
    }
}

/// One ray.
struct Ray<'a> {
    camera: &'a Camera,
    direction: Vec3,
    /// Horizontal share of the direction.
    flat: f32,
    /// Range at which the ground (or the end of sight) stops it.
    end_m: f32,
    /// Luminance of the air behind, per unit of what the air hides.
    air: Vec3,
}

/// Walks all layers (lowest base first) along a ray that ends at `end_m`; `air` is the luminance of an infinite column
/// of air along it.
pub fn walk(camera: &Camera, layers: &[Prepared], direction: Vec3, end_m: f32, air: Vec3) -> Gathered {
    let flat = (1.0 - direction.z * direction.z).max(0.0).sqrt();
    let ray = Ray { camera, direction, flat, end_m, air };
    let mut gathered = Gathered { luminance: Vec3::ZERO, transmittance: 1.0 };
    // Downwards from the eye: the highest layer below it first. Upwards, also past the lowest point: the lowest first.
    for layer in layers.iter().rev().filter(|l| l.layer.base_m < camera.eye_m) {
        ray.leg(layer, true, &mut gathered);
    }
    for layer in layers {
        ray.leg(layer, false, &mut gathered);
    }
    gathered
}

impl Ray<'_> {
    /// One layer on the way down or on the way up.
    fn leg(&self, prepared: &Prepared, down: bool, gathered: &mut Gathered) {
        let (layer, up) = (prepared.layer, self.direction.z);
        if gathered.transmittance < OPAQUE || (down && up >= 0.0) {
            return;
        }
        let r = self.camera.earth_m + self.camera.eye_m;
        let lowest_t = (-r * up).max(0.0);
        let (base, top) = (layer.base_m, layer.base_m + layer.thickness_m);
        let cross = |height: f32| {
            let (falling, rising) = self.camera.crossings(up, height);
            if down { falling } else { rising }
        };
        let eye = self.camera.eye_m;
        let (from, to) = if down {
            // A shell that the ray does not reach turns the leg at the lowest point.
            (if eye > top { cross(top) } else { 0.0 }, cross(base).min(lowest_t))
        } else {
            let begin = cross(base);
            (if begin.is_finite() && (eye < base || up < 0.0) { begin } else { lowest_t }, cross(top))
        };
        let to = to.min(self.end_m).min(layer.extent_m / self.flat.max(1e-3));
        if !(from < to) {
            return;
        }
        self.merge(prepared, down, from, to, gathered);
    }

    /// Crossings with slices and rings between two ranges, in order.
    fn merge(&self, prepared: &Prepared, down: bool, from: f32, to: f32, gathered: &mut Gathered) {
        let layer = prepared.layer;
        let (up, eye) = (self.direction.z, self.camera.eye_m);
        let count = prepared.slices.len();
        let slice_t = |i: usize| {
            let height = prepared.slices[if down { count - 1 - i } else { i }];
            if down && height > eye {
                return -1.0;
            }
            let (falling, rising) = self.camera.crossings(up, height);
            if down { falling } else { rising }
        };
        let ring_radius = |k: i32| layer.ring_first_m * ring_ratio(layer).powi(k);
        let ring_t = |k: i32| {
            let radius = ring_radius(k);
            if radius > layer.ring_last_m * 1.0001 { f32::INFINITY } else { radius / self.flat.max(1e-4) }
        };
        let mut i = 0;
        let mut k =
            ((from * self.flat / layer.ring_first_m).max(1e-6).ln() / ring_ratio(layer).ln()).ceil().max(0.0) as i32;
        let slack = 1e-4 * to;
        let mut next_slice = slice_t(0);
        let mut next_ring = ring_t(k);
        loop {
            while i < count && !(next_slice > 0.0 && next_slice.is_finite() && next_slice >= from - slack) {
                i += 1;
                next_slice = if i < count { slice_t(i) } else { f32::INFINITY };
            }
            if i >= count {
                next_slice = f32::INFINITY;
            }
            if next_slice <= next_ring {
                if next_slice > to + slack {
                    return;
                }
                let height = prepared.slices[if down { count - 1 - i } else { i }];
                self.slice(prepared, height, next_slice, gathered);
                i += 1;
                next_slice = if i < count { slice_t(i) } else { f32::INFINITY };
            } else {
                if next_ring > to {
                    return;
                }
                self.ring(prepared, next_ring, gathered);
                k += 1;
                next_ring = ring_t(k);
            }
            if gathered.transmittance < OPAQUE {
                return;
            }
        }
    }

    fn slice(&self, prepared: &Prepared, height: f32, t: f32, gathered: &mut Gathered) {
        let layer = prepared.layer;
        let r = self.camera.earth_m;
        let sine = (((r + self.camera.eye_m) * self.direction.z + t) / (r + height)).abs().max(1e-4);
        let slice_ds = layer.spacing_m / sine;
        let share = 1.0 - ring_weight(layer, slice_ds, t, t * self.flat);
        // A slice fades as the eye comes near its height: it stands for the path between the eye and itself.
        let near = ((height - self.camera.eye_m).abs() / layer.spacing_m).min(1.0);
        self.gather(prepared, height, t, share * near * slice_ds.min(0.5 * t + layer.spacing_m), gathered);
    }

    fn ring(&self, prepared: &Prepared, t: f32, gathered: &mut Gathered) {
        let layer = prepared.layer;
        let height = self.camera.height_at(self.direction.z, t);
        let r = self.camera.earth_m;
        let sine = (((r + self.camera.eye_m) * self.direction.z + t) / (r + height)).abs().max(1e-4);
        let share = ring_weight(layer, layer.spacing_m / sine, t, t * self.flat);
        self.gather(prepared, height, t, share * t * layer.ring_share, gathered);
    }

    fn gather(&self, prepared: &Prepared, height: f32, t: f32, ds: f32, gathered: &mut Gathered) {
        let layer = prepared.layer;
        if ds <= 0.0 {
            return;
        }
        let p = self.direction * t + Vec3::new(0.0, 0.0, self.camera.eye_m);
        let Some(found) = sample(layer, &prepared.textures, self.camera.earth_m, p, height, t) else { return };
        let alpha = 1.0 - (-layer.extinction_per_m * found.whole * ds).exp();
        let phase = phase(self.direction.dot(Vec3::from(layer.light_direction)));
        let passed = self.camera.air_transmittance(height, t);
        let seen = source(layer, &found, phase, p, height) * passed + self.air * (1.0 - passed);
        gathered.luminance += seen * (alpha * gathered.transmittance);
        gathered.transmittance *= 1.0 - alpha;
    }
}

/// Ratio of neighbouring radii, from the share that a ring stands for: q with (q - 1/q) / 2 = share.
fn ring_ratio(layer: &Layer) -> f32 {
    layer.ring_share + (layer.ring_share * layer.ring_share + 1.0).sqrt()
}

/// Share of the ray that rings carry: all where they are the finer sampling, none where slices are, and none beyond the
/// last ring.
fn ring_weight(layer: &Layer, slice_ds: f32, t: f32, distance: f32) -> f32 {
    let ring_ds = t * layer.ring_share;
    let finer = smoothstep(0.35, 0.65, slice_ds / (slice_ds + ring_ds));
    finer * (1.0 - smoothstep(0.7 * layer.ring_last_m, 0.98 * layer.ring_last_m, distance))
}
