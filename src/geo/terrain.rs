//! Where the ground is: one height function that is drawn, asked for heights and looked through alike.

mod ranges;
mod relief;
mod towns;

use super::Geodetic;
use super::coast::shore_m;
use super::frames::enu;
use super::wgs84::{from_ecef, to_ecef};
use glam::DVec3;
use std::fmt;
use std::sync::Arc;

/// Lowest height that the pictures can show, above the ellipsoid.
pub const LOWEST_M: f64 = -500.0;
/// Highest height that the pictures can show: above Mount Everest.
pub const HIGHEST_M: f64 = 9_000.0;
/// Half the way over which a normal is taken: a tenth of the shortest hill.
const NORMAL_REACH_M: f64 = 10.0;

/// A source of heights. Pure: the same place has the same height, on every thread and machine.
pub trait Heights: fmt::Debug + Send + Sync {
    /// Height of the ground (of the surface, over water) above the ellipsoid at a place in radians, from
    /// [`LOWEST_M`] to [`HIGHEST_M`]; what is shorter than `spacing_m` from crest to crest may be left out. 0: all there is.
    fn height_m(&self, latitude_rad: f64, longitude_rad: f64, spacing_m: f64) -> f64;

    /// How rough the ground is around a place.
    fn roughness(&self, _latitude_rad: f64, _longitude_rad: f64) -> Roughness {
        Roughness::UNKNOWN
    }
}

/// What a walk along a line must know of the ground to miss nothing that stands in its way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roughness {
    /// Width of the thinnest crest.
    pub grain_m: f64,
    /// No slope is steeper: rise over run.
    pub steepest: f64,
    /// Over this way from the place the two hold.
    pub reach_m: f64,
}

impl Roughness {
    /// Walls, and crests of a hill's finest folds: the walk goes in its shortest steps.
    pub const UNKNOWN: Self = Self { grain_m: 80.0, steepest: 1e6, reach_m: f64::INFINITY };
    /// The bare ellipsoid.
    const LEVEL: Self = Self { grain_m: 80.0, steepest: 0.0, reach_m: f64::INFINITY };
}

/// The ground of the whole Earth: the bare ellipsoid, or a source of heights. Two are equal if they share their source.
#[derive(Clone, Default)]
pub struct Terrain(Option<Arc<dyn Heights>>);

impl Terrain {
    /// The ellipsoid itself: height 0 everywhere.
    pub const ELLIPSOID: Self = Self(None);

    /// Made hills and mountains: coasts and mountain ranges where they are, the rest made up (see [`relief`]).
    pub fn procedural() -> Self {
        Self(Some(relief::shared()))
    }

    /// The ground of another source.
    pub fn of(heights: Arc<dyn Heights>) -> Self {
        Self(Some(heights))
    }

    /// Whether this is the bare ellipsoid, which needs no work at all.
    pub fn is_ellipsoid(&self) -> bool {
        self.0.is_none()
    }

    /// Height above the ellipsoid below or above a place (whose own altitude does not matter).
    pub fn height_m(&self, place: &Geodetic) -> f64 {
        self.smoothed_height_m(place.latitude_rad, place.longitude_rad, 0.0)
    }

    /// The same without what is shorter than `spacing_m`: for coarse pictures of it.
    pub fn smoothed_height_m(&self, latitude_rad: f64, longitude_rad: f64, spacing_m: f64) -> f64 {
        let Some(heights) = &self.0 else { return 0.0 };
        let height_m = heights.height_m(latitude_rad, longitude_rad, spacing_m);
        // A source is not trusted with the pictures: what is no number is sea level.
        if height_m.is_finite() { height_m.clamp(LOWEST_M, HIGHEST_M) } else { 0.0 }
    }

    /// How rough the ground is around a place.
    pub fn roughness(&self, place: &Geodetic) -> Roughness {
        self.0.as_ref().map_or(Roughness::LEVEL, |heights| heights.roughness(place.latitude_rad, place.longitude_rad))
    }

    /// Unit normal of the ground (east, north, up) at a place, by central differences over 20 m; at a pole too.
    pub fn normal(&self, place: &Geodetic) -> DVec3 {
        if self.is_ellipsoid() {
            return DVec3::Z;
        }
        // Steps over the plane that touches the ellipsoid, since degrees of longitude shrink to nothing at a pole.
        let foot = Geodetic { altitude_m: 0.0, ..*place };
        let (axes, origin) = (enu(&foot), to_ecef(&foot));
        let at = |step: DVec3| self.height_m(&from_ecef(origin + step * NORMAL_REACH_M));
        let per_m = 0.5 / NORMAL_REACH_M;
        let east = (at(axes.x_axis) - at(-axes.x_axis)) * per_m;
        let north = (at(axes.y_axis) - at(-axes.y_axis)) * per_m;
        DVec3::new(-east, -north, 1.0).normalize()
    }

    /// Whether there is land at a place, by the coastline.
    pub fn is_land(place: &Geodetic) -> bool {
        shore_m(place.latitude_rad, place.longitude_rad) > 0.0
    }
}

impl PartialEq for Terrain {
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (None, None) => true,
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }
}

impl fmt::Debug for Terrain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            None => f.write_str("Ellipsoid"),
            Some(heights) => heights.fmt(f),
        }
    }
}

#[cfg(test)]
mod tests;
