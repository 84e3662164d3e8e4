//! The instances of a layer, sorted from near to far, without those that no ray is carried by.
//!
//! Around the eye lie annuli between ring radii. Within one, the shells that a rising ray meets come from low to high,
//! those that a falling ray meets from high to low, then the piece to where the ray leaves the layer, then the ring that
//! ends the annulus. A shell below the eye is met falling up to the point where the ray touches it, and beyond rising;
//! these far parts are drawn after everything else of their layer and of the layers below.

use super::twin::ring_weight;
use super::{CAP, DOWN, Instance, Layer, RING, SLAB};
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
    let ratio = layer.ring_ratio;
    let (mut found, mut inner, mut outer) = (Instances::default(), 0.0, layer.ring_first_m);
    while inner < layer.extent_m {
        view.annulus(&shells, inner, outer.min(layer.extent_m), &mut found);
        if outer <= layer.ring_last_m * 1.0001 {
            found.near.extend(view.ring(inner, outer));
        }
        inner = outer;
        // Beyond the rings only the order within an annulus matters: wider ones will do.
        outer *= if outer > layer.ring_last_m { ratio * ratio } else { ratio };
    }
    found
}

impl View<'_> {
    fn annulus(&self, shells: &[f32], inner: f32, outer: f32, found: &mut Instances) {
        let last = shells.len() - 1;
        for pair in shells.windows(2) {
            let (low, high) = (pair[0], pair[1]);
            let touch = self.touch_m(high);
            if high > self.eye_m {
                found.near.extend(self.piece(SLAB, low, high, inner, outer));
            } else if outer > touch {
                found.far.extend(self.piece(SLAB, low, high, inner.max(touch), outer));
            }
        }
        for pair in shells.windows(2).rev() {
            let (low, high) = (pair[0], pair[1]);
            if low < self.eye_m && inner < self.touch_m(low) {
                found.near.extend(self.piece(SLAB | DOWN, high, low, inner, outer.min(self.touch_m(low))));
            }
        }
        if shells[last] > self.eye_m {
            found.near.extend(self.cap(CAP, shells[0], shells[last], inner, outer));
        }
        if shells[0] < self.eye_m {
            let end = outer.min(self.touch_m(shells[0]));
            if inner < end {
                found.near.extend(self.cap(CAP | DOWN, shells[last], shells[0], inner, end));
            }
        }
    }

    /// Distance at which a ray touches a shell below the eye; 0 for shells above it.
    fn touch_m(&self, height_m: f32) -> f32 {
        ((self.eye_m - height_m) * (2.0 * self.earth_m + self.eye_m + height_m)).max(0.0).sqrt()
    }

    /// A slab's piece, unless rings carry every ray there.
    fn piece(&self, kind: u32, near_m: f32, far_m: f32, inner_m: f32, outer_m: f32) -> Option<Instance> {
        let middle = 0.5 * (near_m + far_m);
        let carried = |distance: f32| [near_m, middle, far_m].iter().any(|h| self.weight(*h, distance) < 1.0);
        (carried(inner_m) || carried(outer_m)).then_some(Instance { kind, near_m, far_m, inner_m, outer_m })
    }

    /// The piece to where rays leave the layer, if rings carry any there.
    fn cap(&self, kind: u32, near_m: f32, far_m: f32, inner_m: f32, outer_m: f32) -> Option<Instance> {
        let carried = (0..=4).any(|i| {
            let distance = inner_m + (outer_m - inner_m) * i as f32 / 4.0;
            self.weight_before(far_m, distance, inner_m) > 0.0
        });
        carried.then_some(Instance { kind, near_m, far_m, inner_m, outer_m })
    }

    /// The ring at `outer_m`, as high as it carries anything.
    fn ring(&self, inner_m: f32, outer_m: f32) -> Option<Instance> {
        let step = self.layer.thickness_m / STEPS as f32;
        let at = |i: u32| self.layer.base_m + i as f32 * step;
        let carries = |i: &u32| self.weight_before(at(*i), outer_m, inner_m) > 0.0;
        let first = (0..=STEPS).find(carries)?;
        let last = (0..=STEPS).rev().find(carries)?;
        let (near_m, far_m) = (at(first.saturating_sub(1)), at((last + 1).min(STEPS)));
        Some(Instance { kind: RING, near_m, far_m, inner_m, outer_m })
    }

    /// Weight of the piece of a ray that ends at a height and distance and began at the distance `inner_m`: that of its
    /// middle, as the shader takes it.
    fn weight_before(&self, height_m: f32, distance_m: f32, inner_m: f32) -> f32 {
        let middle = 0.5 * (inner_m + distance_m);
        let rise = self.over_tangent_m(height_m, distance_m) - self.eye_m;
        let z = self.eye_m + rise * middle / distance_m.max(1e-3);
        self.weight(z + middle * middle / (2.0 * self.earth_m), middle)
    }

    /// Share that rings carry of the ray through a height at a distance.
    fn weight(&self, height_m: f32, distance_m: f32) -> f32 {
        let r = self.earth_m + height_m;
        let rise = self.over_tangent_m(height_m, distance_m) - self.eye_m;
        let t = (distance_m * distance_m + rise * rise).sqrt().max(1e-3);
        let sine = (((self.earth_m + self.eye_m) * (rise / t) + t) / r).abs().max(1e-4);
        ring_weight(self.layer, self.layer.spacing_m / sine, t, distance_m)
    }

    /// Height over the eye's tangent plane of a shell at a distance, without cancellation.
    fn over_tangent_m(&self, height_m: f32, distance_m: f32) -> f32 {
        let r = self.earth_m + height_m;
        height_m - distance_m * distance_m / ((r * r - distance_m * distance_m).max(0.0).sqrt() + r)
    }
}
