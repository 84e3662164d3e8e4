//! The ground that is drawn: the WGS 84 ellipsoid itself. Its height function stands here, for whoever asks for heights.

use crate::geo::Geodetic;
use crate::geo::wgs84::{FLATTENING, SEMI_MAJOR_M};
use glam::DVec3;

/// Material code of the ground.
pub const MATERIAL_GROUND: u32 = 1;
/// Material code of cloud.
pub const MATERIAL_CLOUD: u32 = 3;

/// Height of the ground above the ellipsoid.
pub fn height_m(_place: &Geodetic) -> f64 {
    0.0
}

/// Height above and of the terrain at a point, and the terrain's normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HatHot {
    /// Height of the point above the terrain.
    pub hat_m: f64,
    /// Height of the terrain above the ellipsoid.
    pub hot_m: f64,
    /// Direction of the normal, clockwise from true north.
    pub normal_azimuth_deg: f64,
    /// Its elevation.
    pub normal_elevation_deg: f64,
    /// What the terrain is made of.
    pub material: u32,
}

/// Answers a question for heights; `None`: the point is nowhere (beyond the poles, or no number).
pub fn hat_hot(point: &Geodetic) -> Option<HatHot> {
    let somewhere = point.latitude_rad.abs() <= std::f64::consts::FRAC_PI_2
        && point.longitude_rad.is_finite()
        && point.altitude_m.is_finite();
    let hot_m = height_m(point);
    somewhere.then_some(HatHot {
        hat_m: point.altitude_m - hot_m,
        hot_m,
        // Level ground: the normal is the vertical, which has no azimuth.
        normal_azimuth_deg: 0.0,
        normal_elevation_deg: 90.0,
        material: MATERIAL_GROUND,
    })
}

/// Range at which a ray (ECEF, unit direction) enters the ground; `None`: it passes or begins below it.
///
/// Along the third axis the ellipsoid is a sphere squeezed by its flattening; there the crossing is a quadratic equation,
/// solved in the form that keeps its digits when the two roots are far apart.
pub fn hit_m(from: DVec3, direction: DVec3) -> Option<f64> {
    let squeeze = DVec3::new(1.0, 1.0, 1.0 / (1.0 - FLATTENING)) / SEMI_MAJOR_M;
    let (o, d) = (from * squeeze, direction * squeeze);
    let (a, b, c) = (d.length_squared(), o.dot(d), o.length_squared() - 1.0);
    let disc = b * b - a * c;
    // Outside and coming nearer.
    (c >= 0.0 && b < 0.0 && disc >= 0.0).then(|| c / (disc.sqrt() - b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geo::frames::enu;
    use crate::geo::wgs84::{MEAN_RADIUS_M, to_ecef};

    fn at(latitude_deg: f64, longitude_deg: f64, altitude_m: f64) -> Geodetic {
        Geodetic { latitude_rad: latitude_deg.to_radians(), longitude_rad: longitude_deg.to_radians(), altitude_m }
    }

    #[test]
    fn straight_down_is_the_height_and_level_is_the_horizon() {
        for (latitude, height) in [(0.0, 10.0), (47.0, 1_500.0), (-89.99, 12_000.0), (60.0, 400_000.0)] {
            let point = at(latitude, 11.0, height);
            let axes = enu(&point);
            let down = hit_m(to_ecef(&point), -axes.z_axis).expect("the ground is below");
            // The vertical of the point is the normal of the ellipsoid at its foot: exact but for rounding at 6e6 m.
            assert!((down - height).abs() < 1e-6, "{latitude} {height}: {down}");
            assert_eq!(hit_m(to_ecef(&point), axes.x_axis), None, "level and upwards there is nothing");
            // Just above and below the horizon of a sphere: acos(R / (R + h)) below level, to 1 % since it is no sphere.
            let dip = (MEAN_RADIUS_M / (MEAN_RADIUS_M + height)).acos();
            let look = |angle: f64| axes.x_axis * angle.cos() - axes.z_axis * angle.sin();
            assert_eq!(hit_m(to_ecef(&point), look(0.99 * dip)), None);
            assert!(hit_m(to_ecef(&point), look(1.01 * dip)).is_some());
        }
        assert_eq!(hit_m(to_ecef(&at(10.0, 10.0, -5.0)), DVec3::X), None, "from below there is no answer");
    }

    #[test]
    fn heights_are_those_above_the_ellipsoid() {
        let answer = hat_hot(&at(47.0, 8.0, 1_234.5)).expect("a place");
        assert_eq!((answer.hat_m, answer.hot_m, answer.normal_elevation_deg), (1_234.5, 0.0, 90.0));
        assert_eq!(hat_hot(&at(91.0, 8.0, 0.0)), None);
        assert_eq!(hat_hot(&at(47.0, f64::NAN, 0.0)), None);
    }
}
