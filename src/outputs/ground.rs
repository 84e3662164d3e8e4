//! The ground that is drawn: its height, its slope and what it is made of, and where a ray meets it.

use crate::geo::Geodetic;
use crate::geo::terrain::{HIGHEST_M, LOWEST_M, Terrain};
use crate::geo::wgs84::{FLATTENING, SEMI_MAJOR_M, from_ecef};
use glam::DVec3;

/// Material code of land.
pub const MATERIAL_GROUND: u32 = 1;
/// Material code of the sea.
pub const MATERIAL_WATER: u32 = 2;
/// Material code of cloud.
pub const MATERIAL_CLOUD: u32 = 3;

/// Shortest step along a ray over terrain, and its growth with the range: at 20 km it is 30 m.
const STEP_M: f64 = 10.0;
const STEP_GROWTH: f64 = 0.001;
/// Share of the height over the ground that a step may go: slopes steeper than 1 in 1 are rare and short.
const SAFE_SHARE: f64 = 0.7;
/// Halvings of the step that went into the ground.
const HALVINGS: u32 = 40;
/// A point so near to the ground stands on it: positions are rounded to some nanometres on the way through ECEF, and heights
/// that hosts were told to millimetres.
pub const ON_GROUND_M: f64 = 0.05;
/// A ray that has not met the ground so far has gone past it: more than the horizon of a space station.
const FARTHEST_M: f64 = 3_000_000.0;

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
pub fn hat_hot(terrain: &Terrain, point: &Geodetic) -> Option<HatHot> {
    let somewhere = point.latitude_rad.abs() <= std::f64::consts::FRAC_PI_2
        && point.longitude_rad.is_finite()
        && point.altitude_m.is_finite();
    if !somewhere {
        return None;
    }
    let hot_m = terrain.height_m(point);
    let normal = terrain.normal(point);
    // Level ground: the normal is the vertical, which has no azimuth.
    let level = normal.z >= 1.0;
    Some(HatHot {
        hat_m: point.altitude_m - hot_m,
        hot_m,
        normal_azimuth_deg: if level { 0.0 } else { normal.x.atan2(normal.y).to_degrees().rem_euclid(360.0) },
        normal_elevation_deg: if level { 90.0 } else { normal.z.asin().to_degrees() },
        material: if Terrain::is_land(point) { MATERIAL_GROUND } else { MATERIAL_WATER },
    })
}

/// Range at which a ray (ECEF, unit direction) enters the ground, looked for up to `to_m`; `None`: it does not, or begins
/// below it.
pub fn hit_m(terrain: &Terrain, from: DVec3, direction: DVec3, to_m: f64) -> Option<f64> {
    if terrain.is_ellipsoid() {
        return ellipsoid_hit_m(from, direction, 0.0);
    }
    let clearance_m = |range_m: f64| {
        let place = from_ecef(from + direction * range_m);
        (place.altitude_m - terrain.height_m(&place), place.altitude_m)
    };
    // Nothing is higher than the highest ground.
    let altitude_m = from_ecef(from).altitude_m;
    let mut at_m = if altitude_m > HIGHEST_M { ellipsoid_hit_m(from, direction, HIGHEST_M)? } else { 0.0 };
    let mut clear_m = clearance_m(at_m).0;
    if clear_m < -ON_GROUND_M {
        return None;
    }
    clear_m = clear_m.max(0.0);
    let end_m = to_m.min(at_m + FARTHEST_M);
    while at_m < end_m {
        let next_m = at_m + (SAFE_SHARE * clear_m).max(STEP_M + STEP_GROWTH * at_m);
        let (next_clear_m, next_altitude_m) = clearance_m(next_m);
        if next_clear_m < 0.0 {
            let (mut above_m, mut below_m) = (at_m, next_m);
            for _ in 0..HALVINGS {
                let middle_m = 0.5 * (above_m + below_m);
                if clearance_m(middle_m).0 < 0.0 { below_m = middle_m } else { above_m = middle_m }
            }
            return Some(below_m);
        }
        let rising = next_altitude_m > HIGHEST_M;
        if rising || next_altitude_m < LOWEST_M {
            return None;
        }
        (at_m, clear_m) = (next_m, next_clear_m);
    }
    None
}

/// Range at which a ray meets the ellipsoid raised by a height, going down; `None`: it passes or begins below it.
///
/// Along the third axis the ellipsoid is a sphere squeezed by its flattening (to better than a metre so for one raised by
/// 9 km); there the crossing is a quadratic equation, solved in the form that keeps its digits when the roots are far apart.
fn ellipsoid_hit_m(from: DVec3, direction: DVec3, raised_m: f64) -> Option<f64> {
    let (across, along) = (SEMI_MAJOR_M + raised_m, SEMI_MAJOR_M * (1.0 - FLATTENING) + raised_m);
    let squeeze = DVec3::new(1.0, 1.0, across / along) / across;
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

    fn flat_hit_m(from: DVec3, direction: DVec3) -> Option<f64> {
        hit_m(&Terrain::ELLIPSOID, from, direction, f64::INFINITY)
    }

    #[test]
    fn who_stands_on_the_ground_sees_mountains_as_who_stands_just_above_it() {
        let terrain = Terrain::procedural();
        let (mut hidden, mut open) = (0, 0);
        for k in 0..40 {
            let foot = at(46.2 + 0.02 * f64::from(k % 8), 7.5 + 0.05 * f64::from(k / 8), 0.0);
            let foot = Geodetic { altitude_m: terrain.height_m(&foot), ..foot };
            let azimuth = f64::from(k);
            // Steeply enough not to graze the slope on which it stands.
            let local = DVec3::new(0.97 * azimuth.sin(), 0.97 * azimuth.cos(), 0.243);
            let direction = (enu(&foot) * local).normalize();
            let seen = |above_m: f64| {
                let from = Geodetic { altitude_m: foot.altitude_m + above_m, ..foot };
                hit_m(&terrain, to_ecef(&from), direction, 100_000.0)
            };
            let (above, below) = (seen(1e-3), seen(-1e-3));
            match (above, below) {
                (Some(a), Some(b)) => assert!((a - b).abs() < 0.05 * a + 1.0, "{k}: {a} {b}"),
                (None, None) => open += 1,
                other => panic!("{k}: {other:?}"),
            }
            hidden += i32::from(above.is_some());
        }
        assert!(hidden > 3 && open > 3, "{hidden} {open}");
    }

    #[test]
    fn straight_down_is_the_height_and_level_is_the_horizon() {
        for (latitude, height) in [(0.0, 10.0), (47.0, 1_500.0), (-89.99, 12_000.0), (60.0, 400_000.0)] {
            let point = at(latitude, 11.0, height);
            let axes = enu(&point);
            let down = flat_hit_m(to_ecef(&point), -axes.z_axis).expect("the ground is below");
            // The vertical of the point is the normal of the ellipsoid at its foot: exact but for rounding at 6e6 m.
            assert!((down - height).abs() < 1e-6, "{latitude} {height}: {down}");
            assert_eq!(flat_hit_m(to_ecef(&point), axes.x_axis), None, "level and upwards there is nothing");
            // Just above and below the horizon of a sphere: acos(R / (R + h)) below level, to 1 % since it is no sphere.
            let dip = (MEAN_RADIUS_M / (MEAN_RADIUS_M + height)).acos();
            let look = |angle: f64| axes.x_axis * angle.cos() - axes.z_axis * angle.sin();
            assert_eq!(flat_hit_m(to_ecef(&point), look(0.99 * dip)), None);
            assert!(flat_hit_m(to_ecef(&point), look(1.01 * dip)).is_some());
        }
        assert_eq!(flat_hit_m(to_ecef(&at(10.0, 10.0, -5.0)), DVec3::X), None, "from below there is no answer");
    }

    #[test]
    fn heights_are_those_above_the_ellipsoid() {
        let hat_hot = |point: &Geodetic| hat_hot(&Terrain::ELLIPSOID, point);
        let answer = hat_hot(&at(47.0, 8.0, 1_234.5)).expect("a place");
        assert_eq!((answer.hat_m, answer.hot_m, answer.normal_elevation_deg), (1_234.5, 0.0, 90.0));
        assert_eq!(hat_hot(&at(91.0, 8.0, 0.0)), None);
        assert_eq!(hat_hot(&at(47.0, f64::NAN, 0.0)), None);
    }

    #[test]
    fn over_terrain_the_height_is_that_of_the_ground_and_its_slope_is_told() {
        let terrain = Terrain::procedural();
        let point = at(46.25, 7.75, 6_000.0);
        let answer = hat_hot(&terrain, &point).expect("a place");
        assert!((answer.hat_m + answer.hot_m - 6_000.0).abs() < 1e-9 && answer.hot_m > 300.0, "{answer:?}");
        assert_eq!(answer.material, MATERIAL_GROUND);
        // A step of a metre against the slope of the normal: downhill is where the normal leans to.
        let (east, north) = answer.normal_azimuth_deg.to_radians().sin_cos();
        let step = |metres: f64| {
            let axes = enu(&point);
            let moved = from_ecef(
                to_ecef(&Geodetic { altitude_m: 0.0, ..point }) + axes * DVec3::new(east, north, 0.0) * metres,
            );
            terrain.height_m(&moved)
        };
        assert!(step(10.0) < step(-10.0), "{answer:?}");
        assert_eq!(hat_hot(&terrain, &at(56.0, 3.0, 10.0)).expect("a place").material, MATERIAL_WATER);
    }

    #[test]
    fn a_ray_ends_on_the_height_that_is_asked_for() {
        let terrain = Terrain::procedural();
        let mut met = 0;
        for k in 0..60 {
            let from = at(46.0 + 0.02 * f64::from(k), 7.6, 5_500.0);
            let axes = enu(&from);
            let dip = 0.02 + 0.02 * f64::from(k % 20);
            let direction =
                axes * DVec3::new(dip.cos() * f64::from(k).cos(), dip.cos() * f64::from(k).sin(), -dip.sin());
            let Some(range) = hit_m(&terrain, to_ecef(&from), direction, 200_000.0) else { continue };
            met += 1;
            let place = from_ecef(to_ecef(&from) + direction * range);
            // Forty halvings of a step of kilometres; noise in f32 makes the ground rough by some millimetres.
            assert!((place.altitude_m - terrain.height_m(&place)).abs() < 0.01, "{k}: {place:?}");
            // No ground before it: a hundred places on the way are above it, but for crests thinner than a step (1 in 1,000).
            let above = (1..100).filter(|i| {
                let place = from_ecef(to_ecef(&from) + direction * (range * f64::from(*i) / 100.0));
                place.altitude_m > terrain.height_m(&place)
            });
            assert_eq!(above.count(), 99, "{k}");
        }
        assert!(met > 40, "{met}");
        let down = hit_m(&terrain, to_ecef(&at(46.0, 7.6, 400_000.0)), -enu(&at(46.0, 7.6, 0.0)).z_axis, f64::INFINITY);
        let height = terrain.height_m(&at(46.0, 7.6, 0.0));
        assert!(down.is_some_and(|down| (down - (400_000.0 - height)).abs() < 0.01), "{down:?} {height}");
    }
}
