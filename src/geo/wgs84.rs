//! The WGS84 ellipsoid: geodetic coordinates to Earth-centred, Earth-fixed metres and back.

use super::Geodetic;
use glam::DVec3;

/// Semi-major axis in metres (NGA.STND.0036, defining value).
pub const SEMI_MAJOR_M: f64 = 6_378_137.0;
/// Flattening (NGA.STND.0036, defining value).
pub const FLATTENING: f64 = 1.0 / 298.257_223_563;
/// Semi-minor axis in metres.
pub const SEMI_MINOR_M: f64 = SEMI_MAJOR_M * (1.0 - FLATTENING);
/// First eccentricity squared.
pub const ECCENTRICITY_SQUARED: f64 = FLATTENING * (2.0 - FLATTENING);
/// Mean radius (2a + b) / 3 in metres (IUGG): the sphere on which cloud patterns lie.
pub const MEAN_RADIUS_M: f64 = 6_371_008.8;

/// Earth-centred, Earth-fixed position in metres: x through 0 N 0 E, y through 0 N 90 E, z through the north pole.
pub fn to_ecef(point: &Geodetic) -> DVec3 {
    let (sin_lat, cos_lat) = point.latitude_rad.sin_cos();
    let (sin_lon, cos_lon) = point.longitude_rad.sin_cos();
    let normal_m = SEMI_MAJOR_M / (1.0 - ECCENTRICITY_SQUARED * sin_lat * sin_lat).sqrt();
    let across_m = (normal_m + point.altitude_m) * cos_lat;
    let along_m = (normal_m * (1.0 - ECCENTRICITY_SQUARED) + point.altitude_m) * sin_lat;
    DVec3::new(across_m * cos_lon, across_m * sin_lon, along_m)
}

/// Latitude, longitude and altitude of an ECEF position, better than a micrometre from -10 km to 1000 km.
///
/// Bowring (1976), "Transformation from spatial to geographical coordinates", repeated on the reduced latitude until
/// it stands (the error falls by a factor of more than 1e3 each time). On the axis the longitude is 0.
pub fn from_ecef(position_m: DVec3) -> Geodetic {
    const SECOND_ECCENTRICITY_SQUARED: f64 = ECCENTRICITY_SQUARED / (1.0 - ECCENTRICITY_SQUARED);
    let across_m = position_m.x.hypot(position_m.y);
    let along_m = position_m.z;
    let (mut sin_reduced, mut cos_reduced) = along_m.atan2((1.0 - FLATTENING) * across_m).sin_cos();
    let mut latitude_rad = 0.0;
    for _ in 0..4 {
        latitude_rad = (along_m + SECOND_ECCENTRICITY_SQUARED * SEMI_MINOR_M * sin_reduced.powi(3))
            .atan2(across_m - ECCENTRICITY_SQUARED * SEMI_MAJOR_M * cos_reduced.powi(3));
        let (sin_lat, cos_lat) = latitude_rad.sin_cos();
        (sin_reduced, cos_reduced) = ((1.0 - FLATTENING) * sin_lat).atan2(cos_lat).sin_cos();
    }
    let (sin_lat, cos_lat) = latitude_rad.sin_cos();
    // Not p / cos(lat) - N, which has a pole at the poles.
    let altitude_m =
        across_m * cos_lat + along_m * sin_lat - SEMI_MAJOR_M * (1.0 - ECCENTRICITY_SQUARED * sin_lat * sin_lat).sqrt();
    Geodetic { latitude_rad, longitude_rad: position_m.y.atan2(position_m.x), altitude_m }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(latitude_deg: f64, longitude_deg: f64, altitude_m: f64) -> Geodetic {
        Geodetic { latitude_rad: latitude_deg.to_radians(), longitude_rad: longitude_deg.to_radians(), altitude_m }
    }

    #[test]
    fn published_points() {
        // EPSG Guidance Note 7-2 (IOGP 373-7-2), geographic/geocentric example in the North Sea, printed to a millimetre.
        let north_sea = to_ecef(&at(53.0 + 48.0 / 60.0 + 33.820 / 3600.0, 2.0 + 7.0 / 60.0 + 46.380 / 3600.0, 73.0));
        // The printed seconds are rounded to 0.001" (31 mm), so half of that on each coordinate.
        assert!((north_sea - DVec3::new(3_771_793.968, 140_253.342, 5_124_304.349)).abs().max_element() < 0.016);
        // By definition: the axes themselves.
        assert!((to_ecef(&at(0.0, 0.0, 0.0)) - DVec3::X * 6_378_137.0).length() < 1e-9);
        // NGA.STND.0036: b = 6 356 752.3142 m, printed to a tenth of a millimetre.
        assert!((to_ecef(&at(90.0, 0.0, 0.0)).z - 6_356_752.314_2).abs() < 1e-4);
    }

    #[test]
    fn there_and_back_everywhere() {
        for latitude in [-90.0, -89.999_999, -60.0, -1e-7, 0.0, 30.0, 45.0, 89.9, 89.999_999_9, 90.0] {
            for longitude in [-180.0, -179.999_999, -90.0, 0.0, 8.0, 179.999_999] {
                for altitude in [-10_000.0, 0.0, 12_000.0, 1_000_000.0] {
                    let there = to_ecef(&at(latitude, longitude, altitude));
                    let back = from_ecef(there);
                    // f64 keeps 1e-9 m at this distance; the iteration stands to a few times that.
                    assert!((to_ecef(&back) - there).length() < 1e-8, "{latitude} {longitude} {altitude}");
                    assert!((back.altitude_m - altitude).abs() < 1e-8, "{latitude} {longitude} {altitude}");
                    assert!((back.latitude_rad.to_degrees() - latitude).abs() < 1e-13, "{latitude} {altitude}");
                }
            }
        }
    }

    #[test]
    fn the_poles_have_a_defined_longitude() {
        let pole = from_ecef(DVec3::new(0.0, 0.0, SEMI_MINOR_M + 100.0));
        assert_eq!(pole.longitude_rad, 0.0);
        assert!((pole.latitude_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        assert!((pole.altitude_m - 100.0).abs() < 1e-8);
    }
}
