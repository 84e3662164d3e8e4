//! Charts: flat coordinates for cloud textures that are fixed to the sphere, nearly true to scale, and without a seam.
//!
//! What: the sphere of radius [`MEAN_RADIUS_M`] is covered by 32 stereographic charts about the vertices of the pentakis
//! dodecahedron (12 vertices and 20 face centres of the icosahedron). Stereographic maps keep angles; with scale 0.976 at
//! the centre each is true to about 2.4 % wherever it has weight. Neighbours are cross-faded over about 10 km: half-way
//! two patterns are drawn into each other, which is neither one's look and costs twice, so the zone is narrow; it is several
//! times wider than a cloud, so that it is no edge.
//!
//! How it is read: around an eye every chart is a Moebius map of the eye's own stereographic coordinate, so that a shader
//! in f32 works with small numbers about the eye and one f64 origin per chart.

use super::wgs84::MEAN_RADIUS_M;
use glam::{DMat3, DQuat, DVec2, DVec3};
use std::sync::LazyLock;

/// Number of charts.
pub const CHARTS: usize = 32;
/// Scale of each chart at its centre: an error of -2.4 % there, +2.4 % at 25 degrees.
pub const CENTRE_SCALE: f64 = 0.976;
/// Most charts that have weight at one point, and most that [`charts_near`] returns.
pub const MOST_AT_ONCE: usize = 3;
/// How far behind the nearest centre, as a difference of cosines, a chart still has weight: neighbours are 37.4 or 41.8
/// degrees apart, which makes the zone of transition between them 10.7 or 9.6 km wide.
pub const BLEND: f64 = 0.000_54;

/// A chart as seen from an eye. All f64; the caller narrows to f32.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChartView {
    /// Which chart, 0 to 31; [`CHARTS`] for one of its own.
    pub chart: usize,
    /// Chart coordinate of the eye's ground point in metres.
    pub origin_m: DVec2,
    /// Complex factor (x real, y imaginary): with z the stereographic coordinate around the eye in metres, `z = 2R (e + i n)
    /// / (|P| + P_up)` for a point P from the Earth's centre with components (e, n, up) in the eye's axes, the chart
    /// coordinate is `origin + a z / (1 - c z)`.
    pub a: DVec2,
    /// The same formula's complex c, in 1/m.
    pub c: DVec2,
    /// Chart centre as (e, n, up) in the eye's axes: the raw weight grows with `dot(w, d)` for the unit direction d of a
    /// point from the Earth's centre in the same axes; [`weights`] is the rule.
    pub w: DVec3,
}

impl ChartView {
    /// Chart coordinate in metres of a point given by its stereographic coordinate around the eye.
    pub fn coordinate_m(&self, z_m: DVec2) -> DVec2 {
        self.origin_m + divide(multiply(self.a, z_m), DVec2::X - multiply(self.c, z_m))
    }
}

/// The stereographic coordinate in metres around the eye of a point with components (e, n, up) from the Earth's centre.
pub fn around_eye_m(point: DVec3) -> DVec2 {
    DVec2::new(point.x, point.y) * (2.0 * MEAN_RADIUS_M / (point.length() + point.z))
}

/// The place (latitude and longitude of its zenith, in radians) at a coordinate of a chart.
pub fn place_of(chart: usize, coordinate_m: DVec2) -> (f64, f64) {
    let w = coordinate_m / (2.0 * MEAN_RADIUS_M * CENTRE_SCALE);
    let squared = w.length_squared();
    let local = DVec3::new(2.0 * w.x, 2.0 * w.y, 1.0 - squared) / (1.0 + squared);
    let zenith = AXES[chart] * local;
    (zenith.z.atan2(zenith.x.hypot(zenith.y)), zenith.y.atan2(zenith.x))
}

/// The coordinate in a chart of the place with this zenith (unit vector, ECEF), metres; far off at the chart's antipode.
pub fn coordinate_of(chart: usize, zenith: DVec3) -> DVec2 {
    let local = AXES[chart].transpose() * zenith;
    DVec2::new(local.x, local.y) * (2.0 * MEAN_RADIUS_M * CENTRE_SCALE / (1.0 + local.z).max(1e-6))
}

/// The charts that have weight anywhere within `extent_m` of the eye (up to 1000 km), nearest first, at most 3.
///
/// `eye_ecef_unit` is the eye's direction on the sphere and its axis "up" (the zenith, if zeniths stand for places); `east` is made
/// perpendicular to it, and north to both. `north` only decides the sense. `drift` is the rotation that has carried the
/// pattern; the charts are fixed to the pattern.
pub fn charts_near(eye_ecef_unit: DVec3, east: DVec3, north: DVec3, drift: DQuat, extent_m: f64) -> Vec<ChartView> {
    let up = eye_ecef_unit.normalize();
    let east = (east - up * east.dot(up)).normalize();
    let across = up.cross(east);
    let north = if across.dot(north) < 0.0 { -across } else { across };
    let undo = drift.inverse();
    let eye_axes = DMat3::from_cols(undo * east, undo * north, undo * up);
    let reach_rad = extent_m / MEAN_RADIUS_M;

    let seen: Vec<DVec3> = AXES.iter().map(|axes| eye_axes.transpose() * axes.z_axis).collect();
    // Over a disc about the eye, dot(w_i - w_j, d) is at most |w_i - w_j| cos(angle - reach).
    let may_lead = |i: usize, j: usize| {
        let gap = seen[i] - seen[j];
        let angle = (gap.z / gap.length()).clamp(-1.0, 1.0).acos();
        gap.length() * (angle - reach_rad).max(0.0).cos() > -BLEND
    };
    let mut near: Vec<usize> = (0..CHARTS).filter(|&i| (0..CHARTS).all(|j| i == j || may_lead(i, j))).collect();
    near.sort_by(|&i, &j| seen[j].z.total_cmp(&seen[i].z));
    near.truncate(MOST_AT_ONCE);
    near.into_iter().map(|chart| view(chart, &AXES[chart], CENTRE_SCALE, &eye_axes)).collect()
}

/// A chart of one's own, true to scale at its centre: `axes` are its x, its y and its centre (orthonormal), `eye_axes` east, north and
/// up at the eye, both in one frame. Its number is [`CHARTS`].
pub fn chart_about(axes: &DMat3, eye_axes: &DMat3) -> ChartView {
    view(CHARTS, axes, 1.0, eye_axes)
}

/// The blending rule: weights of the charts in a direction d (unit, eye's axes), in the order of `views`.
///
/// raw_i = max(0, BLEND + dot(w_i, d) - max_j dot(w_j, d)); weight_i = raw_i / sum of raw. They are continuous, add up to 1,
/// and within the extent the charts that are not listed have none.
pub fn weights(views: &[ChartView], d: DVec3) -> Vec<f64> {
    let nearness: Vec<f64> = views.iter().map(|view| view.w.dot(d)).collect();
    blend(&nearness)
}

fn blend(nearness: &[f64]) -> Vec<f64> {
    let most = nearness.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let raw: Vec<f64> = nearness.iter().map(|near| (BLEND + near - most).max(0.0)).collect();
    let sum: f64 = raw.iter().sum();
    raw.into_iter().map(|r| r / sum).collect()
}

/// A rotation of the sphere is the Moebius map (alpha z + beta) / (-conj(beta) z + conj(alpha)) of its stereographic
/// coordinate z = tan(angle / 2) (Needham, "Visual Complex Analysis", chapter 6), here with alpha = w + i z and
/// beta = y - i x of the quaternion; drawn out about z = 0 it has the form of [`ChartView`].
fn view(chart: usize, axes: &DMat3, scale: f64, eye_axes: &DMat3) -> ChartView {
    let turn = DQuat::from_mat3(&(axes.transpose() * *eye_axes)).normalize();
    let alpha_bar = DVec2::new(turn.w, -turn.z);
    let beta = DVec2::new(turn.y, -turn.x);
    let beta_bar = DVec2::new(turn.y, turn.x);
    ChartView {
        chart,
        origin_m: divide(beta, alpha_bar) * (2.0 * MEAN_RADIUS_M * scale),
        a: divide(DVec2::X, multiply(alpha_bar, alpha_bar)) * scale,
        c: divide(beta_bar, alpha_bar) / (2.0 * MEAN_RADIUS_M),
        w: eye_axes.transpose() * axes.z_axis,
    }
}

fn multiply(a: DVec2, b: DVec2) -> DVec2 {
    DVec2::new(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x)
}

fn divide(a: DVec2, b: DVec2) -> DVec2 {
    multiply(a, DVec2::new(b.x, -b.y)) / b.length_squared()
}

/// Axes of each chart (x, y, centre) in the axes of the pattern: first the vertices of the icosahedron, then its faces.
static AXES: LazyLock<[DMat3; CHARTS]> = LazyLock::new(|| {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let signs = [1.0, -1.0];
    let mut centres = Vec::with_capacity(CHARTS);
    let turned = |v: DVec3, by: usize| match by {
        0 => v,
        1 => DVec3::new(v.z, v.x, v.y),
        _ => DVec3::new(v.y, v.z, v.x),
    };
    for by in 0..3 {
        for (s, t) in signs.iter().flat_map(|&s| signs.map(|t| (s, t))) {
            centres.push(turned(DVec3::new(0.0, s, t * golden), by));
        }
    }
    for (s, t) in signs.iter().flat_map(|&s| signs.map(|t| (s, t))) {
        centres.extend(signs.map(|u| DVec3::new(s, t, u)));
    }
    for by in 0..3 {
        for (s, t) in signs.iter().flat_map(|&s| signs.map(|t| (s, t))) {
            centres.push(turned(DVec3::new(0.0, s * golden, t / golden), by));
        }
    }
    std::array::from_fn(|chart| {
        let centre = centres[chart].normalize();
        let (x, y) = centre.any_orthonormal_pair();
        DMat3::from_cols(x, y, centre)
    })
});

#[cfg(test)]
mod tests;
