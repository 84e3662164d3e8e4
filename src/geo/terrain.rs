//! Where the ground is: one height function that is drawn, asked for heights and looked through alike.

mod ranges;
mod relief;
mod towns;

use super::Geodetic;
use super::coast::shore_m;
use super::frames::Curvature;
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

    /// Unit normal of the ground (east, north, up) at a place, by central differences over 20 m.
    pub fn normal(&self, place: &Geodetic) -> DVec3 {
        if self.is_ellipsoid() {
            return DVec3::Z;
        }
        let curvature = Curvature::at(place.latitude_rad);
        let north_rad = NORMAL_REACH_M / curvature.meridian_m;
        // At a pole a step east is a step of any size.
        let east_rad = NORMAL_REACH_M / (curvature.prime_vertical_m * place.latitude_rad.cos()).max(1.0);
        let at =
            |north: f64, east: f64| self.smoothed_height_m(place.latitude_rad + north, place.longitude_rad + east, 0.0);
        let per_m = 0.5 / NORMAL_REACH_M;
        let east = (at(0.0, east_rad) - at(0.0, -east_rad)) * per_m;
        let north = (at(north_rad, 0.0) - at(-north_rad, 0.0)) * per_m;
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
