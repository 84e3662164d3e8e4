//! The globe in f64: WGS84, local frames, charts for cloud textures, coast, terrain, cities, stars, sun and moon.

pub mod celestial;
pub mod charts;
pub mod cities;
pub mod coast;
pub mod frames;
pub mod raster;
pub mod stars;
pub mod terrain;
pub mod wgs84;

/// A point on or above the WGS84 ellipsoid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geodetic {
    /// Geodetic latitude, -pi/2 to pi/2.
    pub latitude_rad: f64,
    /// Longitude, -pi to pi.
    pub longitude_rad: f64,
    /// Height above the ellipsoid.
    pub altitude_m: f64,
}

/// Attitude as the aerospace sequence yaw, pitch, roll (about down, right, forward) against north-east-down axes or a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Attitude {
    /// Clockwise seen from above, 0 is north (or the body's nose).
    pub yaw_rad: f64,
    /// Nose up.
    pub pitch_rad: f64,
    /// Right wing down.
    pub roll_rad: f64,
}
