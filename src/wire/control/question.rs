//! The questions of `query` that ask the world itself: heights, lines of sight, the weather at a point.

use crate::geo::Geodetic;
use crate::outputs::ground::Surfaces;
use crate::outputs::sight::Ray;
use crate::wire::limits;
use crate::world::event::Refused;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointJson {
    /// WGS84 latitude.
    #[schemars(range(min = limits::LATITUDE_DEG.min, max = limits::LATITUDE_DEG.max))]
    pub latitude_deg: f64,
    /// WGS84 longitude.
    #[schemars(range(min = limits::LONGITUDE_DEG.min, max = limits::LONGITUDE_DEG.max))]
    pub longitude_deg: f64,
    /// Height above the ellipsoid.
    #[schemars(range(min = limits::ALTITUDE_M.min, max = limits::ALTITUDE_M.max))]
    pub altitude_m: f64,
}

/// What hides one point from another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SegmentQuery {
    /// The point that is looked from.
    pub from: PointJson,
    /// The point that is looked at, at most 1000 km away.
    pub to: PointJson,
    /// Whether the ground hides.
    #[serde(default = "yes")]
    pub ground: bool,
    /// Whether cloud hides.
    #[serde(default = "yes")]
    pub cloud: bool,
    /// Opacity from which cloud hides.
    #[serde(default = "half")]
    #[schemars(range(min = limits::OPACITY.min, max = limits::OPACITY.max))]
    pub cloud_opacity: f64,
}

/// What a ray meets first.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VectorQuery {
    /// The point that is looked from.
    pub from: PointJson,
    /// Direction of the ray from true north, clockwise.
    #[schemars(range(min = limits::YAW_DEG.min, max = limits::YAW_DEG.max))]
    pub azimuth_deg: f64,
    /// Elevation of the ray.
    #[schemars(range(min = limits::PITCH_DEG.min, max = limits::PITCH_DEG.max))]
    pub elevation_deg: f64,
    /// What is nearer does not hide.
    #[serde(default)]
    #[schemars(range(min = limits::SIGHT_RANGE_M.min, max = limits::SIGHT_RANGE_M.max))]
    pub minimum_m: f64,
    /// Length of the ray.
    #[schemars(range(min = limits::SIGHT_RANGE_M.min, max = limits::SIGHT_RANGE_M.max))]
    pub maximum_m: f64,
    /// Whether the ground hides.
    #[serde(default = "yes")]
    pub ground: bool,
    /// Whether cloud hides.
    #[serde(default = "yes")]
    pub cloud: bool,
    /// Opacity from which cloud hides.
    #[serde(default = "half")]
    #[schemars(range(min = limits::OPACITY.min, max = limits::OPACITY.max))]
    pub cloud_opacity: f64,
}

fn yes() -> bool {
    true
}

fn half() -> f64 {
    0.5
}

/// The surfaces that hide where the ground does.
fn surfaces(ground: bool) -> Surfaces {
    if ground { Surfaces::ALL } else { Surfaces::NONE }
}

impl PointJson {
    /// The point.
    pub fn geodetic(&self) -> Geodetic {
        Geodetic {
            latitude_rad: self.latitude_deg.to_radians(),
            longitude_rad: self.longitude_deg.to_radians(),
            altitude_m: self.altitude_m,
        }
    }
}

impl From<&Geodetic> for PointJson {
    fn from(point: &Geodetic) -> Self {
        Self {
            latitude_deg: point.latitude_rad.to_degrees(),
            longitude_deg: point.longitude_rad.to_degrees(),
            altitude_m: point.altitude_m,
        }
    }
}

impl SegmentQuery {
    /// The ray that is followed.
    ///
    /// # Errors
    /// [`Refused`]: the points are too far apart.
    pub fn ray(&self) -> Result<Ray, Refused> {
        let ray = Ray::between(self.from.geodetic(), &self.to.geodetic());
        if ray.to_m > limits::SIGHT_RANGE_M.max {
            let limit = format!("at most {} m away", limits::SIGHT_RANGE_M.max);
            return Err(Refused::new("to", ray.to_m, limit, "no line of sight is followed so far"));
        }
        Ok(Ray { surfaces: surfaces(self.ground), opaque: self.cloud.then_some(self.cloud_opacity), ..ray })
    }
}

impl VectorQuery {
    /// The ray that is followed.
    ///
    /// # Errors
    /// [`Refused`]: it ends before it begins.
    pub fn ray(&self) -> Result<Ray, Refused> {
        if self.maximum_m <= self.minimum_m {
            let limit = format!("more than minimum_m, {}", self.minimum_m);
            return Err(Refused::new("maximum_m", self.maximum_m, limit, "the ray has no length"));
        }
        let (azimuth_rad, elevation_rad) = (self.azimuth_deg.to_radians(), self.elevation_deg.to_radians());
        let ray = Ray::towards(self.from.geodetic(), azimuth_rad, elevation_rad, self.minimum_m, self.maximum_m);
        Ok(Ray { surfaces: surfaces(self.ground), opaque: self.cloud.then_some(self.cloud_opacity), ..ray })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HERE: PointJson = PointJson { latitude_deg: 47.0, longitude_deg: 8.0, altitude_m: 900.0 };

    #[test]
    fn a_line_that_is_too_long_or_has_no_length_is_refused_with_its_field() {
        let mut line = SegmentQuery { from: HERE, to: HERE, ground: true, cloud: false, cloud_opacity: 0.5 };
        // 8.9 degrees along a meridian are 989 km, 9.1 are 1011 km (111.1 km a degree there); the chord is 1 km shorter.
        line.to.latitude_deg = 47.0 - 8.9;
        assert!(line.ray().is_ok_and(|ray| ray.surfaces == Surfaces::ALL && ray.opaque.is_none()));
        line.to.latitude_deg = 47.0 - 9.1;
        assert_eq!(line.ray().expect_err("too far").field, "to");
        let mut ray = VectorQuery {
            from: HERE,
            azimuth_deg: 90.0,
            elevation_deg: 0.0,
            minimum_m: 10.0,
            maximum_m: 20.0,
            ground: false,
            cloud: true,
            cloud_opacity: 0.25,
        };
        let followed = ray.ray().expect("a ray");
        assert_eq!((followed.from_m, followed.to_m, followed.opaque), (10.0, 20.0, Some(0.25)));
        assert_eq!(followed.surfaces, Surfaces::NONE);
        // At 8 E, east is (-sin 8, cos 8, 0) in ECEF; rounding alone.
        let east = glam::DVec3::new(-8f64.to_radians().sin(), 8f64.to_radians().cos(), 0.0);
        assert!((followed.direction - east).length() < 1e-12, "{followed:?}");
        ray.maximum_m = 10.0;
        assert_eq!(ray.ray().expect_err("no length").field, "maximum_m");
    }
}
