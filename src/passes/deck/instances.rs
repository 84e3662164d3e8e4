//! The instances of a layer, sorted from near to far, without those that no ray is carried by.
//!
//! Around the eye lie annuli between ring radii. Along a ray rings come first: annulus by annulus the pieces to where the
//! ray leaves the layer, then the ring that ends the annulus. Then the slabs: within an annulus the shells that a rising
//! ray meets from low to high, those that a falling ray meets from high to low. A shell below the eye is met falling up to
//! the point where the ray touches it, and beyond rising; these far parts are drawn after everything else of their layer
//! and of the layers below.

use super::{CAP, DOWN, Instance, Layer, RING, RING_SHARE, RING_SLICES, SLAB};
use crate::clouds::slices;

/// Instances of one layer, near to far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Instances {
    /// What a ray meets before its lowest point, or rising from the eye.
    pub near: Vec<Instance>,
    /// What a ray meets after its lowest point.
    pub far: Vec<Instance>,
}

/// Steps of height at which a ring's weight is looked at.
const STEPS: u32 = 24;

struct View<'a> {
    layer: &'a Layer,
    earth_m: f32,
    eye_m: f32,
}

/// The instances of a layer for an eye.
pub fn instances(layer: &Layer, slices: u32, earth_m: f32, eye_m: f32) -> Instances {
    let view = View { layer, earth_m, eye_m };
    let shells: Vec<f32> = slices::shells(slices, layer.thickness_m).into_iter().map(|h| layer.base_m + h).collect();
    let annuli = view.annuli();
    let mut found = Instances::default();
    for (inner, outer, ring) in &annuli {
        found.near.extend(view.caps(&shells, *inner, *outer));
        if *ring {
            found.near.extend(view.ring(*inner, *outer));
        }
    }
    for (inner, outer, _) in &annuli {
        view.slabs(&shells, *inner, *outer, &mut found);
    }
    found
}

impl View<'_> {
    /// Inner and outer radii from the eye to the end of sight, and whether a ring ends the annulus.
    fn annuli(&self) -> Vec<(f32, f32, bool)> {
        let (mut annuli, mut inner) = (Vec::new(), 0.0);
        for k in 0.. {
            if inner >= self.layer.extent_m {
                break;
            }
            let ring = ring_radius(self.layer, k);
            // Beyond the rings only the order within an annulus matters: wide ones will do.
            let outer = ring.unwrap_or(2.0 * inner).min(self.layer.extent_m);
            annuli.push((inner, outer, ring.is_some()));
            inner = outer;
        }
        annuli
    }

    fn slabs(&self, shells: &[f32], inner: f32, outer: f32, found: &mut Instances) {
        for pair in shells.windows(2) {
            let (low, high) = (pair[0], pair[1]);
            let touch = self.touch_m(high);
            if high > self.eye_m {
                found.near.extend(self.slab(SLAB, low, high, inner, outer));
            } else if outer > touch {
                found.far.extend(self.slab(SLAB, low, high, inner.max(touch), outer));
            }
        }
        for pair in shells.windows(2).rev() {
            let (low, high) = (pair[0], pair[1]);
            if low < self.eye_m && inner < self.touch_m(low) {
                found.near.extend(self.slab(SLAB | DOWN, high, low, inner, outer.min(self.touch_m(low))));
            }
        }
    }

    fn caps(&self, shells: &[f32], inner: f32, outer: f32) -> Vec<Instance> {
        let (base, top) = (shells[0], shells[shells.len() - 1]);
        let mut caps = Vec::new();
        if top > self.eye_m {
            caps.extend(self.cap(CAP, base, top, inner, outer));
        }
        let end = outer.min(self.touch_m(base));
        if base < self.eye_m && inner < end {
            caps.extend(self.cap(CAP | DOWN, top, base, inner, end));
        }
        caps
    }

    /// Distance at which a ray touches a shell below the eye; 0 for shells above it.
    fn touch_m(&self, height_m: f32) -> f32 {
        ((self.eye_m - height_m) * (2.0 * self.earth_m + self.eye_m + height_m)).max(0.0).sqrt()
    }

    /// A slab's piece, unless rings carry every ray there.
    fn slab(&self, kind: u32, near_m: f32, far_m: f32, inner_m: f32, outer_m: f32) -> Option<Instance> {
        let middle = 0.5 * (near_m + far_m);
        let left = |distance: f32| [near_m, middle, far_m].iter().any(|h| !self.carried(*h, distance));
        (left(inner_m) || left(outer_m)).then_some(Instance { kind, near_m, far_m, inner_m, outer_m })
    }

    /// The piece to where rays leave the layer, if rings carry any there.
    fn cap(&self, kind: u32, near_m: f32, far_m: f32, inner_m: f32, outer_m: f32) -> Option<Instance> {
        let carried = (0..=4).any(|i| {
            let distance = inner_m + (outer_m - inner_m) * i as f32 / 4.0;
            self.carried_before(far_m, distance, inner_m)
        });
        carried.then_some(Instance { kind, near_m, far_m, inner_m, outer_m })
    }

    /// The ring at `outer_m`, as high as it carries anything.
    fn ring(&self, inner_m: f32, outer_m: f32) -> Option<Instance> {
        let step = self.layer.thickness_m / STEPS as f32;
        let at = |i: u32| self.layer.base_m + i as f32 * step;
        let carries = |i: &u32| self.carried_before(at(*i), outer_m, inner_m);
        let first = (0..=STEPS).find(carries)?;
        let last = (0..=STEPS).rev().find(carries)?;
        let (near_m, far_m) = (at(first.saturating_sub(1)), at((last + 1).min(STEPS)));
        Some(Instance { kind: RING, near_m, far_m, inner_m, outer_m })
    }

    /// Whether rings carry any of the piece of a ray that ends at a height and distance: its beginning, at the distance
    /// `inner_m` or where it enters the layer.
    fn carried_before(&self, height_m: f32, distance_m: f32, inner_m: f32) -> bool {
        let rise = self.over_tangent_m(height_m, distance_m) - self.eye_m;
        let top_m = self.layer.base_m + self.layer.thickness_m;
        let entered = |shell_m: f32| ((shell_m - self.eye_m) / rise * distance_m).clamp(0.0, distance_m);
        let enters = if self.eye_m < self.layer.base_m && rise > 0.0 {
            entered(self.layer.base_m)
        } else if self.eye_m > top_m && rise < 0.0 {
            entered(top_m)
        } else {
            0.0
        };
        let begin = inner_m.max(0.98 * enters);
        let z = self.eye_m + rise * begin / distance_m.max(1e-3);
        self.carried(z + begin * begin / (2.0 * self.earth_m), begin)
    }

    /// Whether rings carry the ray through a height at a distance.
    fn carried(&self, height_m: f32, distance_m: f32) -> bool {
        let r = self.earth_m + height_m;
        let rise = self.over_tangent_m(height_m, distance_m) - self.eye_m;
        let t = (distance_m * distance_m + rise * rise).sqrt().max(1e-3);
        let sine = (((self.earth_m + self.eye_m) * (rise / t) + t) / r).abs().max(1e-4);
        rings_carry(self.layer, self.layer.spacing_m / sine, t, distance_m)
    }

    /// Height over the eye's tangent plane of a shell at a distance, without cancellation.
    fn over_tangent_m(&self, height_m: f32, distance_m: f32) -> f32 {
        let r = self.earth_m + height_m;
        height_m - distance_m * distance_m / ((r * r - distance_m * distance_m).max(0.0).sqrt() + r)
    }
}

/// Radius of ring `k`; the last one lies at the layer's `ring_last_m`.
fn ring_radius(layer: &Layer, k: i32) -> Option<f32> {
    let radius = |k: i32| layer.ring_first_m * layer.ring_ratio.powi(k);
    (k == 0 || radius(k - 1) < layer.ring_last_m).then(|| radius(k).min(layer.ring_last_m))
}

/// Whether rings carry a ray at range `t` and horizontal distance `distance`, where it meets a slice every `slice_ds`:
/// where that is long against the range. Along a ray rings come first, then slabs.
fn rings_carry(layer: &Layer, slice_ds: f32, t: f32, distance: f32) -> bool {
    slice_ds > t * RING_SHARE + RING_SLICES * layer.spacing_m && distance < layer.ring_last_m
}
