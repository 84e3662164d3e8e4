//! Local axes: east-north-up and north-east-down at a point, body axes of the ownship, and the Earth's local curvature.

use super::wgs84::{ECCENTRICITY_SQUARED, SEMI_MAJOR_M};
use super::{Attitude, Geodetic};
use glam::{DMat3, DVec3};

/// Columns east, north and up (normal to the ellipsoid) in ECEF axes: takes local ENU components to ECEF components.
///
/// At a pole the longitude of the point says where east and north are, so the axes never vanish.
pub fn enu(point: &Geodetic) -> DMat3 {
    let (sin_lat, cos_lat) = point.latitude_rad.sin_cos();
    let (sin_lon, cos_lon) = point.longitude_rad.sin_cos();
    DMat3::from_cols(
        DVec3::new(-sin_lon, cos_lon, 0.0),
        DVec3::new(-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat),
        DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat),
    )
}

/// NED components to ENU components, and ENU to NED: the same exchange of axes, its own inverse.
pub const ENU_NED: DMat3 =
    DMat3::from_cols(DVec3::new(0.0, 1.0, 0.0), DVec3::new(1.0, 0.0, 0.0), DVec3::new(0.0, 0.0, -1.0));

/// Takes body components (forward, right, down) to NED components: yaw about down, then pitch, then roll.
pub fn ned_from_body(attitude: &Attitude) -> DMat3 {
    DMat3::from_rotation_z(attitude.yaw_rad)
        * DMat3::from_rotation_y(attitude.pitch_rad)
        * DMat3::from_rotation_x(attitude.roll_rad)
}

/// The attitude of a rotation from body to NED; at a pitch of 90 degrees, where only yaw minus roll counts, roll is 0.
pub fn attitude_of(ned_from_body: &DMat3) -> Attitude {
    let forward = ned_from_body.x_axis;
    let level = forward.x.hypot(forward.y);
    let pitch_rad = (-forward.z).atan2(level);
    if level < 1e-12 {
        let right = ned_from_body.y_axis;
        return Attitude { yaw_rad: (-right.x).atan2(right.y), pitch_rad, roll_rad: 0.0 };
    }
    Attitude {
        yaw_rad: forward.y.atan2(forward.x),
        pitch_rad,
        roll_rad: ned_from_body.y_axis.z.atan2(ned_from_body.z_axis.z),
    }
}

/// Takes body components to ECEF components for a body at `position`.
pub fn ecef_from_body(position: &Geodetic, attitude: &Attitude) -> DMat3 {
    enu(position) * ENU_NED * ned_from_body(attitude)
}

/// Radii of curvature of the ellipsoid at a latitude, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curvature {
    /// Along the meridian, M.
    pub meridian_m: f64,
    /// Across the meridian, N (prime vertical).
    pub prime_vertical_m: f64,
}

impl Curvature {
    /// The radii at a geodetic latitude.
    pub fn at(latitude_rad: f64) -> Self {
        let sin_lat = latitude_rad.sin();
        let squared = 1.0 - ECCENTRICITY_SQUARED * sin_lat * sin_lat;
        let prime_vertical_m = SEMI_MAJOR_M / squared.sqrt();
        Self { meridian_m: prime_vertical_m * (1.0 - ECCENTRICITY_SQUARED) / squared, prime_vertical_m }
    }

    /// Gaussian mean sqrt(M N): the sphere that fits best in all directions.
    pub fn mean_m(&self) -> f64 {
        (self.meridian_m * self.prime_vertical_m).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geo::wgs84::to_ecef;

    #[test]
    fn axes_are_a_right_handed_frame_that_follows_the_ground() {
        for latitude_rad in [-std::f64::consts::FRAC_PI_2, -0.7, 0.0, 1.2, std::f64::consts::FRAC_PI_2] {
            for longitude_rad in [-std::f64::consts::PI, -1.0, 0.0, 3.0] {
                let axes = enu(&Geodetic { latitude_rad, longitude_rad, altitude_m: 0.0 });
                assert!((axes.determinant() - 1.0).abs() < 1e-14);
                let up = to_ecef(&Geodetic { latitude_rad, longitude_rad, altitude_m: 1000.0 })
                    - to_ecef(&Geodetic { latitude_rad, longitude_rad, altitude_m: 0.0 });
                // 1000 m out of 6e6 m in f64 leaves 1e-12 of the direction.
                assert!((up.normalize() - axes.z_axis).length() < 1e-11);
            }
        }
        let axes = enu(&Geodetic { latitude_rad: 0.0, longitude_rad: 0.0, altitude_m: 0.0 });
        assert_eq!((axes.x_axis, axes.y_axis, axes.z_axis), (DVec3::Y, DVec3::Z, DVec3::X));
    }

    #[test]
    fn attitude_says_what_the_words_say() {
        let half = std::f64::consts::FRAC_PI_2;
        let east = ned_from_body(&Attitude { yaw_rad: half, ..Default::default() }) * DVec3::X;
        assert!((east - DVec3::Y).length() < 1e-15, "yaw 90 looks east: {east}");
        let climb = ned_from_body(&Attitude { pitch_rad: 0.3, ..Default::default() }) * DVec3::X;
        assert!(climb.z < 0.0, "nose up points up: {climb}");
        let bank = ned_from_body(&Attitude { roll_rad: 0.3, ..Default::default() }) * DVec3::Y;
        assert!(bank.z > 0.0, "right wing down: {bank}");
        assert_eq!(ENU_NED * ENU_NED, DMat3::IDENTITY);
    }

    #[test]
    fn attitude_there_and_back() {
        for yaw_rad in [-3.0, 0.0, 2.5] {
            for pitch_rad in [-1.5, 0.2, 1.5] {
                for roll_rad in [-3.0, 0.0, 1.0] {
                    let given = Attitude { yaw_rad, pitch_rad, roll_rad };
                    let back = attitude_of(&ned_from_body(&given));
                    for (a, b) in [
                        (given.yaw_rad, back.yaw_rad),
                        (given.pitch_rad, back.pitch_rad),
                        (given.roll_rad, back.roll_rad),
                    ] {
                        assert!((a - b).abs() < 1e-13, "{given:?} {back:?}");
                    }
                }
            }
        }
        // Straight up: the rotation comes back even though yaw and roll cannot be told apart.
        let up = ned_from_body(&Attitude { yaw_rad: 1.0, pitch_rad: std::f64::consts::FRAC_PI_2, roll_rad: 0.4 });
        assert!((ned_from_body(&attitude_of(&up)) - up).abs_diff_eq(DMat3::ZERO, 1e-12));
    }

    #[test]
    fn radii_of_curvature_at_equator_and_pole() {
        // Closed forms: M = b^2/a and N = a at the equator, both a^2/b at the poles.
        let (a, b) = (SEMI_MAJOR_M, crate::geo::wgs84::SEMI_MINOR_M);
        let equator = Curvature::at(0.0);
        assert!((equator.meridian_m - b * b / a).abs() < 1e-6 && (equator.prime_vertical_m - a).abs() < 1e-6);
        let pole = Curvature::at(std::f64::consts::FRAC_PI_2);
        assert!((pole.meridian_m - a * a / b).abs() < 1e-6 && (pole.prime_vertical_m - a * a / b).abs() < 1e-6);
        assert!(equator.meridian_m < equator.mean_m() && equator.mean_m() < a);
    }
}
