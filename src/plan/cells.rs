//! Storm cells: where a bounded volume lies in its region, and the spheres that bound what regions have of cloud.

use super::eye::Eye;
use super::regions::{NearRegion, outline};
use crate::clouds::density::TILE_M;
use crate::clouds::{CloudKind, warp};
use crate::geo::Geodetic;
use crate::geo::charts::{BLEND, ChartView, chart_about};
use crate::geo::frames::enu;
use crate::geo::wgs84::MEAN_RADIUS_M;
use crate::passes::common::{CHARTS, Chart};
use crate::passes::deck::{REGIONS, Region};
use crate::world::command::RegionShape;
use crate::world::snapshot::LayerState;
use glam::{DMat3, DVec2};

/// Share of a cell's square over which its outline ends: nothing of the cell is there.
const RIM_SHARE: f64 = 0.01;
/// Regions wider than this have no bound that would leave out a ray, m.
const WIDEST_BOUND_M: f64 = 300_000.0;

/// Where one cell lies.
pub struct Cell {
    /// The square that it fills, its first axis downwind; it fits into the region.
    square: RegionShape,
}

impl Cell {
    /// The cell that a layer of a region is, if it is one.
    pub fn of(layer: &LayerState, shape: &RegionShape) -> Option<Self> {
        if layer.kind != CloudKind::StormCell {
            return None;
        }
        let side_m = shape.size_east_m.min(shape.size_north_m);
        let square = RegionShape {
            size_east_m: side_m,
            size_north_m: side_m,
            corner_radius_m: 0.0,
            // From east at 0, clockwise; the wind blows from north at 0.
            rotation_deg: layer.wind_from_deg + 90.0,
            transition_m: RIM_SHARE * side_m,
            ..shape.clone()
        };
        Some(Self { square })
    }

    /// Factor from metres on the ground to those of the tile.
    pub fn scale(&self) -> f32 {
        TILE_M / self.square.size_east_m as f32
    }

    /// Its outline around the eye.
    pub fn outline(&self, presence: f32, eye: &Eye) -> Region {
        outline(&self.square, f64::from(presence), eye).0
    }

    /// Its one chart: the tile is the square.
    pub fn charts(&self, eye: &Eye) -> (Vec<ChartView>, [Chart; CHARTS]) {
        let centre = enu(&Geodetic {
            latitude_rad: self.square.latitude_deg.to_radians(),
            longitude_rad: self.square.longitude_deg.to_radians(),
            altitude_m: 0.0,
        });
        let (sin, cos) = self.square.rotation_deg.to_radians().sin_cos();
        let (east, north) = (centre.x_axis, centre.y_axis);
        let axes = DMat3::from_cols(east * cos - north * sin, east * sin + north * cos, centre.z_axis);
        let view = chart_about(&axes, &eye.enu);
        let scale = f64::from(self.scale());
        let to_mean_sphere = MEAN_RADIUS_M / eye.earth_m;
        let origin = (view.origin_m * scale + 0.5 * f64::from(TILE_M)).as_vec2();
        let mut charts = [Chart::UNUSED; CHARTS];
        charts[0] = Chart {
            tile_origin_m: origin.into(),
            map_origin: [0.0; 2],
            a: (view.a * (to_mean_sphere * scale)).as_vec2().into(),
            c: (view.c * to_mean_sphere).as_vec2().into(),
            w: view.w.as_vec3().into(),
            zone: BLEND as f32,
            warp: warp::NONE,
        };
        (vec![view], charts)
    }
}

/// The outlines of all regions in sight for a layer of one of them (counted from 1; 0: the surroundings): a cell's own is its
/// square, and cells that stand in the weather around take nothing away from it.
pub fn outlines(regions: &[NearRegion], column: usize, layer: &LayerState, eye: &Eye) -> [Region; REGIONS] {
    let mut found = [Region::default(); REGIONS];
    for (i, (slot, near)) in found.iter_mut().zip(regions).enumerate() {
        let own = column == i + 1;
        *slot = near.outline;
        if own && let Some(cell) = Cell::of(layer, &near.state.shape) {
            *slot = cell.outline(near.outline.presence, eye);
        } else if !own {
            slot.presence *= near.state.gives_way() as f32;
        }
    }
    found
}

/// A sphere around all that a region has of a layer: its middle (east, north, height over the tangent plane) and its radius, m; 0 where
/// there is no bound.
pub fn bound(near: &NearRegion, layer: &LayerState, eye: &Eye) -> ([f32; 3], f32) {
    let shape = &near.state.shape;
    let core = DVec2::new(shape.size_east_m, shape.size_north_m) * 0.5 - shape.corner_radius_m;
    let beside_m = core.length() + shape.corner_radius_m + shape.transition_m;
    if beside_m > WIDEST_BOUND_M {
        return ([0.0; 3], 0.0);
    }
    let middle = Geodetic {
        latitude_rad: shape.latitude_deg.to_radians(),
        longitude_rad: shape.longitude_deg.to_radians(),
        altitude_m: layer.base_m + 0.5 * layer.thickness_m,
    };
    let middle_m = eye.place(&middle);
    // Outlines are measured around the eye, where a length is up to a thousandth too long in sight; and they lie on a sphere that
    // has the mean of the ellipsoid's two radii at the eye, which differ from it by 0.34 % at the most.
    let radius_m = 1.01 * DVec2::new(beside_m, 0.5 * layer.thickness_m).length() as f32 + 0.004 * middle_m.length();
    (middle_m.into(), radius_m)
}

#[cfg(test)]
mod tests;
