//! The ground that is drawn: its height, its slope and what it is made of, and where a ray meets it.

use crate::geo::Geodetic;
use crate::geo::terrain::{HIGHEST_M, LOWEST_M, Terrain};
use crate::geo::wgs84::{FLATTENING, SEMI_MAJOR_M, from_ecef};
use glam::DVec3;

/// Material code of land.
pub const MATERIAL_LAND: u32 = 1;
/// Material code of the sea.
pub const MATERIAL_WATER: u32 = 2;
/// Material code of cloud.
pub const MATERIAL_CLOUD: u32 = 3;

/// What the surface of the ground is made of at a place.
pub fn material(place: &Geodetic) -> u32 {
    if Terrain::is_land(place) { MATERIAL_LAND } else { MATERIAL_WATER }
}

/// Shortest step along a ray near the ground, of the width of the thinnest crest.
const STEP_SHARE: f64 = 0.125;
/// Most of the shortest steps on a way: a longer way has longer ones.
const MOST_STEPS: f64 = 200_000.0;
/// Halvings of the step that went into the ground.
const HALVINGS: u32 = 40;
/// A point so near to the ground stands on it: positions are rounded to some nanometres on the way through ECEF, and heights
/// that hosts were told to millimetres.
pub const ON_GROUND_M: f64 = 0.05;
/// A ray that has not met the ground so far has gone past it: more than the horizon of a space station.
const FARTHEST_M: f64 = 3_000_000.0;

/// Which surfaces count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Surfaces {
    /// Land.
    pub land: bool,
    /// The sea.
    pub water: bool,
}

impl Surfaces {
    /// Both.
    pub const ALL: Self = Self { land: true, water: true };
    /// None.
    pub const NONE: Self = Self { land: false, water: false };

    fn count(self, place: &Geodetic) -> bool {
        match material(place) {
            MATERIAL_WATER => self.water,
            _ => self.land,
        }
    }
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
        material: material(point),
    })
}

/// Range at which a ray (ECEF, unit direction) enters ground that counts, looked for up to `to_m`; `None`: it does not, or begins
/// below it. Ground that does not count is looked through, and so is a dip into it by less than [`ON_GROUND_M`].
///
/// A step is as long as the ground, by its steepest slope, needs to rise to the ray; near the ground an eighth of the thinnest
/// crest. So a crest is missed only where the ray dips into it by less than the ground rises over half of such a step.
pub fn hit_m(terrain: &Terrain, counts: Surfaces, from: DVec3, direction: DVec3, to_m: f64) -> Option<f64> {
    if counts == Surfaces::NONE {
        return None;
    }
    let all = counts == Surfaces::ALL;
    if all && terrain.is_ellipsoid() {
        // Into the ground, and not only along it: what stands on it is not hidden by the bulge of some millimetres between.
        let deep_m = ellipsoid_hit_m(from, direction, -ON_GROUND_M).filter(|deep_m| *deep_m <= to_m)?;
        return Some(ellipsoid_hit_m(from, direction, 0.0).unwrap_or(0.0).min(deep_m));
    }
    let place = |range_m: f64| from_ecef(from + direction * range_m);
    let clearance_m = |place: &Geodetic| place.altitude_m - terrain.height_m(place);
    let inside = |place: &Geodetic| clearance_m(place) < 0.0 && (all || counts.count(place));
    // Nothing is higher than the highest ground.
    let mut at_m = match from_ecef(from).altitude_m > HIGHEST_M {
        true => ellipsoid_hit_m(from, direction, HIGHEST_M)?,
        false => 0.0,
    };
    let mut here = place(at_m);
    let mut clear_m = clearance_m(&here);
    if clear_m < -ON_GROUND_M && (all || counts.count(&here)) {
        return None;
    }
    // The last place that was over the ground: dips of less than a hand's breadth may lie behind it.
    let mut open_m = at_m;
    let end_m = to_m.min(at_m + FARTHEST_M);
    let shortest_m = (end_m - at_m) / MOST_STEPS;
    while at_m < end_m {
        let rough = terrain.roughness(&here);
        let step_m = (STEP_SHARE * rough.grain_m).max(shortest_m);
        // What the ray gains on the ground in a metre at the least: it curves upwards over the level.
        let (sin_lat, cos_lat) = here.latitude_rad.sin_cos();
        let up = DVec3::new(cos_lat * here.longitude_rad.cos(), cos_lat * here.longitude_rad.sin(), sin_lat);
        let rise = direction.dot(up).clamp(-1.0, 1.0);
        let closing = rough.steepest * (1.0 - rise * rise).sqrt() - rise;
        let safe_m = if closing > 0.0 { clear_m.max(0.0) / closing } else { f64::INFINITY };
        let next_m = at_m + if clear_m < 0.0 { step_m } else { safe_m.min(rough.reach_m).max(step_m) };
        let next_m = next_m.min(end_m);
        let next = place(next_m);
        let next_clear_m = clearance_m(&next);
        if next_clear_m < -ON_GROUND_M && (all || counts.count(&next)) {
            let (mut above_m, mut below_m) = (open_m, next_m);
            for _ in 0..HALVINGS {
                let middle_m = 0.5 * (above_m + below_m);
                if inside(&place(middle_m)) { below_m = middle_m } else { above_m = middle_m }
            }
            return Some(below_m);
        }
        if next.altitude_m > HIGHEST_M || next.altitude_m < LOWEST_M {
            return None;
        }
        (at_m, here, clear_m) = (next_m, next, next_clear_m);
        if clear_m >= 0.0 {
            open_m = at_m;
        }
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
    use crate::geo::raster::{Grid, Raster};
    use crate::geo::terrain::Heights;
    use crate::geo::wgs84::{MEAN_RADIUS_M, to_ecef};
    use std::sync::Arc;

    fn at(latitude_deg: f64, longitude_deg: f64, altitude_m: f64) -> Geodetic {
        Geodetic { latitude_rad: latitude_deg.to_radians(), longitude_rad: longitude_deg.to_radians(), altitude_m }
    }

    /// Ground that is level, but no ellipsoid by its name.
    #[derive(Debug)]
    struct Level;

    impl Heights for Level {
        fn height_m(&self, _: f64, _: f64, _: f64) -> f64 {
            0.0
        }
    }

    fn flat_hit_m(from: DVec3, direction: DVec3) -> Option<f64> {
        hit_m(&Terrain::ELLIPSOID, Surfaces::ALL, from, direction, f64::INFINITY)
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
                hit_m(&terrain, Surfaces::ALL, to_ecef(&from), direction, 100_000.0)
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
        // Two that stand on the ground, to within rounding: the bulge between hides them from 1.6 km on (s^2 / 8 R = 5 cm).
        let flat = Terrain::of(Arc::new(Level));
        for (north_deg, hidden) in [(1e-5, false), (0.01, false), (0.02, true), (0.9, true)] {
            for altitude in [-1e-9, 0.0, 1e-9] {
                let (a, b) = (to_ecef(&at(47.0, 8.0, altitude)), to_ecef(&at(47.0 + north_deg, 8.0, altitude)));
                for terrain in [&Terrain::ELLIPSOID, &flat] {
                    let found = hit_m(terrain, Surfaces::ALL, a, (b - a).normalize(), (b - a).length());
                    assert_eq!(found.is_some(), hidden, "{north_deg} {altitude} {terrain:?}: {found:?}");
                }
            }
        }
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
        assert_eq!(answer.material, MATERIAL_LAND);
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
            let Some(range) = hit_m(&terrain, Surfaces::ALL, to_ecef(&from), direction, 200_000.0) else { continue };
            met += 1;
            let place = from_ecef(to_ecef(&from) + direction * range);
            // Forty halvings of a step of kilometres; noise in f32 makes the ground rough by some millimetres.
            assert!((place.altitude_m - terrain.height_m(&place)).abs() < 0.01, "{k}: {place:?}");
            // No ground before it: a hundred places on the way are above it.
            let above = (1..100).filter(|i| {
                let place = from_ecef(to_ecef(&from) + direction * (range * f64::from(*i) / 100.0));
                place.altitude_m > terrain.height_m(&place)
            });
            assert_eq!(above.count(), 99, "{k}");
        }
        assert!(met > 40, "{met}");
        let (high, down) = (to_ecef(&at(46.0, 7.6, 400_000.0)), -enu(&at(46.0, 7.6, 0.0)).z_axis);
        let down = hit_m(&terrain, Surfaces::ALL, high, down, f64::INFINITY);
        let height = terrain.height_m(&at(46.0, 7.6, 0.0));
        assert!(down.is_some_and(|down| (down - (400_000.0 - height)).abs() < 0.01), "{down:?} {height}");
    }

    /// Heights of a second of arc with needles of one sample here and there on rolling ground.
    fn needles() -> Terrain {
        let heights_m = (0..400 * 400u32).map(|n| {
            let (row, column) = (n / 400, n % 400);
            let rolling = 40.0 * (0.05 * row as f32).sin() * (0.04 * column as f32).cos();
            let needle = scattered(n).is_multiple_of(97);
            500.0 + rolling + if needle { 25.0 + (scattered(n + 1) % 100) as f32 } else { 0.0 }
        });
        let step = 1.0 / 3_600.0;
        let grid = Grid {
            north_deg: 47.0,
            west_deg: 8.0,
            step_south_deg: step,
            step_east_deg: step,
            columns: 400,
            heights_m: heights_m.collect(),
        };
        Terrain::of(Arc::new(Raster::new(grid, 0.0, Terrain::ELLIPSOID)))
    }

    fn scattered(n: u32) -> u32 {
        (n.wrapping_mul(0x9e37_79b9) ^ 0x5bd1_e995).wrapping_mul(0x85eb_ca6b) >> 9
    }

    #[test]
    fn a_crest_of_one_sample_is_not_missed() {
        let terrain = needles();
        // A degree of 111.2 km in 3,600 samples.
        let (met, mut thin) = (&mut 0, 0);
        for k in 0..120u32 {
            let share = f64::from(scattered(k) % 1_000) / 1_000.0;
            let from = at(46.99 - 0.09 * share, 8.004, 530.0 + 0.9 * f64::from(k % 60));
            let to = at(46.99 - 0.09 * (1.0 - share), 8.105, 560.0 + 0.7 * f64::from(k % 50));
            let (begin, end) = (to_ecef(&from), to_ecef(&to));
            let (way_m, direction) = ((end - begin).length(), (end - begin).normalize());
            let clear_m = |range_m: f64| {
                let place = from_ecef(begin + direction * range_m);
                place.altitude_m - terrain.height_m(&place)
            };
            if clear_m(0.0) < 1.0 {
                continue;
            }
            let found = hit_m(&terrain, Surfaces::ALL, begin, direction, way_m);
            let until_m = found.unwrap_or(way_m);
            // Half of a step of an eighth of 21 m, on slopes of 125 m in 21 m and 31 m: 8 m of depth; found are less in most cases.
            let deepest = (0..(until_m * 4.0) as u32).map(|n| clear_m(0.25 * f64::from(n))).fold(0.0, f64::min);
            assert!(deepest > -8.0, "{k}: ground {deepest} m over the ray before {found:?}");
            thin += u32::from(deepest < -1.0);
            *met += u32::from(found.is_some());
        }
        assert!(*met > 60 && thin <= 2, "{met} met, {thin} dipped by more than a metre");
    }

    #[test]
    fn surfaces_that_do_not_count_are_looked_through() {
        // From 300 m over the sea off Nice down to the sea, and level towards the mountains behind the coast.
        let terrain = Terrain::procedural();
        let from = at(43.55, 7.2, 300.0);
        let origin = to_ecef(&from);
        let axes = enu(&from);
        let (land, water) = (Surfaces { water: false, ..Surfaces::ALL }, Surfaces { land: false, ..Surfaces::ALL });
        for terrain in [Terrain::ELLIPSOID, terrain.clone()] {
            let down = |counts| hit_m(&terrain, counts, origin, -axes.z_axis, 2_000.0);
            assert!(down(Surfaces::ALL).is_some_and(|range| (range - 300.0).abs() < 0.01));
            assert!(down(water).is_some_and(|range| (range - 300.0).abs() < 0.01));
            assert_eq!((down(land), down(Surfaces::NONE)), (None, None));
        }
        let north = |counts, dip: f64| {
            let direction = axes * DVec3::new(0.0, dip.cos(), -dip.sin());
            hit_m(&terrain, counts, origin, direction, 80_000.0).map(|range| from_ecef(origin + direction * range))
        };
        let hit = north(land, 0.0).expect("mountains");
        assert_eq!((material(&hit), north(water, 0.0)), (MATERIAL_LAND, None), "{hit:?}");
        // Downwards into the sea 3 km away: the coast under its surface is what counts of land.
        let (sea, coast) = (north(Surfaces::ALL, 0.1).expect("sea"), north(land, 0.03).expect("the coast"));
        assert!(material(&sea) == MATERIAL_WATER && sea.altitude_m.abs() < 0.01, "{sea:?}");
        assert!(material(&coast) == MATERIAL_LAND && coast.latitude_rad > sea.latitude_rad, "{coast:?}");
    }
}
