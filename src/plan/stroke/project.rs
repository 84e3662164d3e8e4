//! From places around the eye to pixels: projection, near plane, horizon, and what lies beside the picture.

use crate::passes::common::Camera;
use glam::{DVec2, DVec3};

/// What is nearer along the axis is not drawn, m.
const NEAR_M: f64 = 0.5;
/// How far the sphere that stands for the Earth may lie over a channel's foot, m: the ellipsoid differs from it.
const SUNK_M: f64 = 4.0;
/// What lies farther beside the picture than this share of its size gives nothing but glow, which is left out.
const BESIDE: f64 = 0.05;

/// A point in the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub at_px: DVec2,
    pub range_m: f64,
    /// Upward component of its direction.
    pub up: f64,
    /// Solid angle of a pixel there.
    pub pixel_sr: f64,
}

/// The camera in double precision.
pub(super) struct Projection {
    pub eye: DVec3,
    /// Angle of a pixel in the middle of the picture.
    pub pixel_rad: f64,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Right, up and forward by each other: what a direction must be multiplied with to have its parts.
    inverse: [DVec3; 3],
    volume: f64,
    size_px: DVec2,
    earth_m: f64,
}

impl Projection {
    pub fn new(camera: &Camera) -> Self {
        let axis = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let (right, up, forward) = (axis(camera.right), axis(camera.up), axis(camera.forward));
        let volume = right.dot(up.cross(forward));
        let inverse = [up.cross(forward), forward.cross(right), right.cross(up)].map(|v| v / volume);
        let size_px = DVec2::new(camera.width_px.into(), camera.height_px.into());
        Self {
            eye: DVec3::new(0.0, 0.0, camera.eye_m.into()),
            pixel_rad: 2.0 * up.length() / size_px.y,
            right,
            up,
            forward,
            inverse,
            volume,
            size_px,
            earth_m: camera.earth_m.into(),
        }
    }

    /// The part of a piece that is before the near plane and not behind the horizon, as shares of the whole that it is part of;
    /// `shares` are those of its ends.
    pub fn in_sight(&self, [a, b]: [DVec3; 2], shares: [f64; 2]) -> Option<[f64; 2]> {
        let (mut low, mut high) = (0.0, 1.0);
        let depth = |p: DVec3| (p - self.eye).dot(self.inverse[2]) - NEAR_M;
        for [at_a, at_b] in [[depth(a), depth(b)], [self.clearance_m(a), self.clearance_m(b)]] {
            if at_a < 0.0 && at_b < 0.0 {
                return None;
            }
            let crossing = at_a / (at_a - at_b);
            if at_a < 0.0 {
                low = f64::max(low, crossing);
            }
            if at_b < 0.0 {
                high = f64::min(high, crossing);
            }
        }
        let of = |share: f64| shares[0] + (shares[1] - shares[0]) * share;
        (low < high).then(|| [of(low), of(high)])
    }

    /// How far the line of sight to a point passes over the ground, or over the point where that lies in it, m.
    fn clearance_m(&self, p: DVec3) -> f64 {
        let centre = DVec3::new(0.0, 0.0, -self.earth_m);
        let (eye, way) = (self.eye - centre, p - self.eye);
        let share = (-eye.dot(way) / way.length_squared().max(1e-6)).clamp(0.0, 1.0);
        let lowest_m = (eye + way * share).length();
        lowest_m - self.earth_m.min((p - centre).length()) + SUNK_M
    }

    /// Both ends in the picture; none where the piece lies beside it.
    pub fn seen(&self, a: DVec3, b: DVec3) -> Option<[Seen; 2]> {
        let [a, b] = [self.point(a), self.point(b)];
        let margin = self.size_px * BESIDE + 8.0;
        let (low, high) = (a.at_px.min(b.at_px), a.at_px.max(b.at_px));
        let beside = high.cmplt(-margin).any() || low.cmpgt(self.size_px + margin).any();
        (!beside && low.is_finite() && high.is_finite()).then_some([a, b])
    }

    fn point(&self, p: DVec3) -> Seen {
        let away = p - self.eye;
        let [x, y, depth] = self.inverse.map(|axis| axis.dot(away));
        let depth = depth.max(0.5 * NEAR_M);
        let (x, y) = (x / depth, y / depth);
        let at_px = DVec2::new(0.5 * (x + 1.0), 0.5 * (1.0 - y)) * self.size_px;
        let direction = self.forward + self.right * x + self.up * y;
        // A pixel's area on the plane one axis away, seen from the eye under its slant.
        let area = 4.0 * self.volume.abs() / (self.size_px.x * self.size_px.y);
        let pixel_sr = area / direction.length().powi(3);
        let range_m = away.length().max(1e-3);
        Seen { at_px, range_m, up: away.z / range_m, pixel_sr }
    }
}

/// Distance of a point from the piece between two.
pub(super) fn distance_to_line(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let way = b - a;
    let share = ((p - a).dot(way) / way.length_squared().max(1e-9)).clamp(0.0, 1.0);
    p.distance(a + way * share)
}
