//! The piece of a layer in which a flash finds its table of virtual lights: at a fixed place of the layer's drifting pattern.
//!
//! What eases or drifts against the pattern is rounded more coarsely than for a solve, so that flashes minutes apart in one cloud share a
//! table; the light moves in its cloud by at most half a kilometre at a region's edge, by nothing elsewhere.

use super::super::eye::Eye;
use super::super::regions::{self, NearRegion};
use super::{below, drawn};
use crate::geo::Geodetic;
use crate::geo::frames::{Curvature, enu};
use crate::geo::wgs84::MEAN_RADIUS_M;
use crate::passes::deck::{Layer, REGIONS, Region};
use crate::passes::relight::patch::{self, STEP_CELLS};
use crate::passes::relight::{Lighting, Point, Request};
use crate::world::snapshot::{FlashState, LayerState, RegionState, Snapshot};
use glam::{DMat3, DQuat, DVec3};
use std::f64::consts::FRAC_PI_2;

/// The middle of a piece is told from a flash in steps of this length, m: what a frame's rounding moves is less.
const PLACE_M: f64 = 10.0;
/// Where a region's outline lies against the pattern, m.
const OUTLINE_M: f32 = 1_000.0;

/// The request of a flash's part about the middle of its piece, and that middle; `drift` is the layer's as the flash began, `region`
/// the one whose layer it is (`None`: the global weather). `None`: the region is not among those near the middle.
pub fn request(
    snapshot: &Snapshot,
    flash: &FlashState,
    points: &[Point],
    (state, region, drift): (&LayerState, Option<&RegionState>, DQuat),
    method: Lighting,
) -> Option<(Request, Eye)> {
    let thickness_m = coarse(state.thickness_m as f32);
    let reach_m = points.iter().flat_map(|p| [p.position_m[0].abs(), p.position_m[1].abs()]).fold(0.0, f32::max);
    let wide_m = patch::wide_m(thickness_m, reach_m);
    let there = middle(flash, drift, f64::from(wide_m) * STEP_CELLS as f64);
    let near = regions::near(snapshot, &there, &mut Vec::new());
    // Regions are numbered by their distance, which is another one from here.
    let column = match region {
        None => 0,
        Some(own) => 1 + near.iter().position(|near| std::ptr::eq(near.state, own))?,
    };
    let layer = Layer { thickness_m, ..about(state, column, &there, &near, drift) };
    let request = Request {
        kind: state.kind,
        earth_m: there.earth_m as f32,
        points: moved(points, flash, &there),
        method,
        patch: Some(patch::window(layer.base_m, thickness_m, wide_m)),
        layer,
    };
    Some((request, there))
}

/// The middle of the piece that holds a flash: its axes are those of the pattern.
fn middle(flash: &FlashState, drift: DQuat, step_m: f64) -> Eye {
    let step = step_m / MEAN_RADIUS_M;
    let fixed = drift.inverse() * below(&flash.position).zenith;
    let (latitude, longitude) = angles(fixed);
    let latitude = ((latitude / step).round() * step).clamp(-FRAC_PI_2, FRAC_PI_2);
    // Rows of latitude have their own steps; next to a pole a row has one piece.
    let around = step / latitude.cos().max(step);
    let longitude = (longitude / around).round() * around;
    let place = Geodetic { latitude_rad: latitude, longitude_rad: longitude, altitude_m: 0.0 };
    let pattern = enu(&place);
    let (latitude_rad, longitude_rad) = angles(drift * pattern.z_axis);
    let mut there = below(&Geodetic { latitude_rad, longitude_rad, altitude_m: 0.0 });
    let up = there.enu.z_axis;
    let east = drift * pattern.x_axis;
    let east = (east - up * east.dot(up)).normalize();
    there.enu = DMat3::from_cols(east, up.cross(east), up);
    // Of the pattern's place, so that it does not change while it drifts.
    there.earth_m = Curvature::at(latitude).mean_m();
    there
}

/// Latitude and longitude of a zenith.
fn angles(zenith: DVec3) -> (f64, f64) {
    (zenith.z.clamp(-1.0, 1.0).asin(), zenith.y.atan2(zenith.x))
}

/// The layer about the middle, in coarse steps.
fn about(state: &LayerState, column: usize, there: &Eye, near: &[NearRegion], drift: DQuat) -> Layer {
    let layer = drawn(state, column, there, near, drift);
    let rounded = |v: f32, step: f32| (v / step).round() * step;
    let mut outline = [Region::default(); REGIONS];
    for (out, from) in outline.iter_mut().zip(&layer.outline).take(near.len()) {
        *out = Region {
            centre_m: from.centre_m.map(|v| rounded(v, OUTLINE_M)),
            rotation: from.rotation.map(|v| rounded(v, 1.0 / 256.0)),
            presence: rounded(from.presence, 1.0 / 16.0),
            ..*from
        };
    }
    Layer {
        base_m: rounded(layer.base_m, 50.0),
        extinction_per_m: coarse(layer.extinction_per_m),
        theta: rounded(layer.theta, 1.0 / 64.0),
        patchiness: rounded(layer.patchiness, 1.0 / 64.0),
        outline,
        ..layer
    }
}

/// In steps of five per cent.
fn coarse(v: f32) -> f32 {
    ((v.ln() * 20.0).round() / 20.0).exp()
}

/// Points around a flash's ground point, around the piece's.
fn moved(points: &[Point], flash: &FlashState, there: &Eye) -> Vec<Point> {
    let own = below(&flash.position);
    let turn = there.enu.transpose() * own.enu;
    let offset = there.enu.transpose() * (own.ground_ecef_m - there.ground_ecef_m);
    let offset = (offset / PLACE_M).round() * PLACE_M;
    let point = |p: &Point| {
        let at = turn * DVec3::from(p.position_m.map(f64::from)) + offset;
        Point { position_m: at.round().as_vec3().into(), share: p.share }
    };
    points.iter().map(point).collect()
}
