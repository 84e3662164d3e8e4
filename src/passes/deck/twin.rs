//! Twin of `deck.wgsl`: walks the crossings of a ray with slices and rings from near to far.

use super::field::{Sample, Textures, phase, sample, source};
use super::{Layer, RING_SHARE};
use crate::clouds::slices::shells;
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
    /// Heights of the shells between groups of slices over the sphere, lowest first.
    pub slices: Vec<f32>,
    /// What its look-ups read.
    pub textures: Textures<'a>,
}

impl<'a> Prepared<'a> {
    /// A layer with `slices` slices.
    pub fn new(layer: &'a Layer, slices: u32, textures: Textures<'a>) -> Self {
        let slices = shells(slices, layer.thickness_m).into_iter().map(|h| layer.base_m + h).collect();
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
        // Infinite where the leg does not meet the layer.
        if from >= to {
            return;
        }
        self.merge(prepared, down, from, to, gathered);
    }

    /// Slabs between slices and between rings, from one range to another, in the order of their far ends.
    fn merge(&self, prepared: &Prepared, down: bool, from: f32, to: f32, gathered: &mut Gathered) {
        let layer = prepared.layer;
        let count = prepared.slices.len();
        let slack = 1e-4 * to;
        let slice_t = |i: usize| {
            if i >= count {
                return f32::INFINITY;
            }
            let (falling, rising) =
                self.camera.crossings(self.direction.z, prepared.slices[if down { count - 1 - i } else { i }]);
            let t = if down { falling } else { rising };
            if t >= from - slack && t <= to + slack { t } else { f32::INFINITY }
        };
        // The first slice whose crossing lies on this leg.
        let mut i = (0..count).find(|i| slice_t(*i).is_finite()).unwrap_or(count);
        let ratio = layer.ring_ratio;
        let ring_t = |k: i32| {
            let radius = layer.ring_first_m * ratio.powi(k);
            if radius > layer.ring_last_m * 1.0001 { f32::INFINITY } else { radius / self.flat.max(1e-4) }
        };
        let mut k = ((from * self.flat / layer.ring_first_m).max(1e-6).ln() / ratio.ln()).ceil().max(0.0) as i32;
        let mut slabs = End { t: from, margin: None };
        let mut rings = End { t: from, margin: None };
        // What is left beyond the last ring belongs to the slabs.
        let ring_before_end = |k: i32| if ring_t(k) < to { ring_t(k) } else { f32::INFINITY };
        let (mut next_slice, mut next_ring) = (slice_t(i), ring_before_end(k));
        loop {
            if next_slice.is_infinite() && next_ring.is_infinite() {
                break;
            }
            if next_slice <= next_ring {
                self.segment(prepared, &mut slabs, next_slice, false, gathered);
                i += 1;
                next_slice = slice_t(i);
            } else {
                self.segment(prepared, &mut rings, next_ring, true, gathered);
                k += 1;
                next_ring = ring_before_end(k);
            }
            if gathered.transmittance < OPAQUE {
                return;
            }
        }
        // From the last ring to where the ray leaves the layer.
        self.segment(prepared, &mut rings, to, true, gathered);
    }

    /// The piece of the ray from the end of the piece before to `t`, as far as slabs or rings carry it there.
    fn segment(&self, prepared: &Prepared, before: &mut End, t: f32, ring: bool, gathered: &mut Gathered) {
        let layer = prepared.layer;
        let ds = t - before.t;
        let middle = 0.5 * (t + before.t);
        let height = self.camera.height_at(self.direction.z, middle);
        let r = self.camera.earth_m;
        let sine = (((r + self.camera.eye_m) * self.direction.z + middle) / (r + height)).abs().max(1e-4);
        let carried = ring_weight(layer, layer.spacing_m / sine, middle, middle * self.flat);
        let share = if ring { carried } else { 1.0 - carried };
        let start = std::mem::replace(before, End { t, margin: None });
        if share <= 0.0 || ds <= 0.0 {
            return;
        }
        let mut near = start.margin.unwrap_or_else(|| self.look(prepared, start.t));
        let mut at = start.t;
        for _ in 0..MOST_STEPS {
            let end = t.min(at + step(layer, &near, at, ds));
            let far = self.look(prepared, end);
            let whole = mean_clamped(near.margin * layer.inverse_edge, far.margin * layer.inverse_edge);
            if whole > 0.0 {
                let deeper = if far.margin > near.margin { &far } else { &near };
                let light = deeper.light(&prepared.textures);
                self.gather(prepared, 0.5 * (at + end), share * (end - at) * whole, light, gathered);
                if gathered.transmittance < OPAQUE {
                    break;
                }
            }
            (near, at) = (far, end);
            if at >= t {
                break;
            }
        }
        before.margin = Some(near);
    }

    fn look(&self, prepared: &Prepared, t: f32) -> Sample {
        let p = self.direction * t + Vec3::new(0.0, 0.0, self.camera.eye_m);
        let height = self.camera.height_at(self.direction.z, t);
        sample(prepared.layer, &prepared.textures, self.camera.earth_m, p, height, t)
    }

    /// Adds cloud of a given path length at full extinction.
    fn gather(&self, prepared: &Prepared, t: f32, path_m: f32, light: Vec3, gathered: &mut Gathered) {
        let layer = prepared.layer;
        let height = self.camera.height_at(self.direction.z, t);
        let alpha = 1.0 - (-layer.extinction_per_m * path_m).exp();
        let p = self.direction * t + Vec3::new(0.0, 0.0, self.camera.eye_m);
        let phase = phase(self.direction.dot(Vec3::from(layer.light_direction)));
        let passed = self.camera.air_transmittance(height, t);
        let seen = source(layer, light, phase, p, height) * passed + self.air * (1.0 - passed);
        gathered.luminance += seen * (alpha * gathered.transmittance);
        gathered.transmittance *= 1.0 - alpha;
    }
}

/// Steps that a piece of the ray is cut into at most.
const MOST_STEPS: u32 = 96;

/// Step from a look: short at the cloud's edge and inside, growing with the range as pixels do; outside as far as the
/// cloud is certain not to reach. Never less than the share of the piece that lets it end within [`MOST_STEPS`].
fn step(layer: &Layer, look: &Sample, t: f32, ds: f32) -> f32 {
    let shortest = (layer.step_m + 0.025 * t).max(ds * (1.0 / MOST_STEPS as f32));
    shortest + layer.reach_m * (-look.margin).max(0.0)
}

/// Where a piece of the ray ended, and what was found there.
struct End {
    t: f32,
    margin: Option<Sample>,
}

/// Mean of clamp(m, 0, 1) while m runs evenly from `a` to `b` (pre-integration: a slab that cloud enters half-way
/// counts half, so that slices do not show as lines).
pub fn mean_clamped(a: f32, b: f32) -> f32 {
    // Antiderivative of clamp: 0, then m^2 / 2, then m - 1/2.
    let sum = |m: f32| {
        let c = m.clamp(0.0, 1.0);
        0.5 * c * c + (m - 1.0).max(0.0)
    };
    if (b - a).abs() < 1e-4 { (0.5 * (a + b)).clamp(0.0, 1.0) } else { (sum(b) - sum(a)) / (b - a) }
}

/// Share of the ray that rings carry: all where they are the finer sampling, none where slices are, and none beyond the
/// last ring.
pub fn ring_weight(layer: &Layer, slice_ds: f32, t: f32, distance: f32) -> f32 {
    let ring_ds = t * RING_SHARE;
    let finer = smoothstep(0.35, 0.65, slice_ds / (slice_ds + ring_ds));
    finer * (1.0 - smoothstep(0.7 * layer.ring_last_m, 0.98 * layer.ring_last_m, distance))
}
