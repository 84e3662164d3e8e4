//! Lines of sight: what a ray meets first, ground or cloud, and how much of the light comes through.

use super::field::Field;
use super::ground::{self, ON_GROUND_M, Surfaces};
use crate::geo::Geodetic;
use crate::geo::frames::enu;
use crate::geo::wgs84::{from_ecef, to_ecef};
use crate::world::snapshot::Snapshot;
use glam::DVec3;

/// Shortest step through cloud: a fine voxel of the density volume has 62 m.
const STEP_M: f64 = 15.0;
/// Most steps; a longer way takes longer ones.
const MOST_STEPS: f64 = 8_000.0;

/// A question.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Source.
    pub from: Geodetic,
    /// Unit direction, ECEF.
    pub direction: DVec3,
    /// What is nearer does not hide.
    pub from_m: f64,
    /// Length.
    pub to_m: f64,
    /// Opacity from 0 to 1 from which cloud hides; `None`: cloud never does.
    pub opaque: Option<f64>,
    /// Which surfaces of the ground hide.
    pub surfaces: Surfaces,
}

/// What hides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hider {
    /// The ground.
    Ground,
    /// Cloud, where its opacity reaches what was asked.
    Cloud,
}

/// An answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// What hides; `None`: nothing up to the end.
    pub hider: Option<Hider>,
    /// From the source to what hides, or to the end.
    pub range_m: f64,
    /// That point.
    pub point: Geodetic,
    /// Opacity of the cloud up to that point, 0 to 1.
    pub opacity: f64,
}

impl Ray {
    /// From point to point.
    pub fn between(from: Geodetic, to: &Geodetic) -> Self {
        let way = to_ecef(to) - to_ecef(&from);
        let direction = way.try_normalize().unwrap_or(DVec3::X);
        Self { from, direction, from_m: 0.0, to_m: way.length(), opaque: None, surfaces: Surfaces::ALL }
    }

    /// From a point in a direction: clockwise from true north, and above level.
    pub fn towards(from: Geodetic, azimuth_rad: f64, elevation_rad: f64, from_m: f64, to_m: f64) -> Self {
        let level = elevation_rad.cos();
        let local = DVec3::new(level * azimuth_rad.sin(), level * azimuth_rad.cos(), elevation_rad.sin());
        Self { from, direction: (enu(&from) * local).normalize(), from_m, to_m, opaque: None, surfaces: Surfaces::ALL }
    }
}

/// Follows a ray.
pub fn sight(snapshot: &Snapshot, ray: &Ray) -> Sight {
    let origin = to_ecef(&ray.from);
    // What is nearer than the range asked for hides nothing: the ground is looked for from there on. A point on the ground is
    // not hidden by the ground that it stands on.
    let from_m = ray.from_m.max(0.0);
    let (begin, direction) = (origin + ray.direction * from_m, ray.direction);
    let ground_m = ground::hit_m(&snapshot.terrain, ray.surfaces, begin, direction, ray.to_m - from_m)
        .map(|hit_m| from_m + hit_m)
        .filter(|hit_m| *hit_m < ray.to_m - ON_GROUND_M);
    let end_m = ground_m.unwrap_or(f64::INFINITY).min(ray.to_m).max(0.0);
    let (cloud_m, opacity) = cloud(snapshot, ray, end_m);
    let (hider, range_m) = match (cloud_m, ground_m) {
        (Some(cloud_m), _) => (Some(Hider::Cloud), cloud_m),
        (None, Some(ground_m)) => (Some(Hider::Ground), ground_m),
        _ => (None, ray.to_m),
    };
    Sight { hider, range_m, point: from_ecef(origin + ray.direction * range_m), opacity }
}

/// Where cloud reaches the opacity asked, and the opacity there or at the end.
fn cloud(snapshot: &Snapshot, ray: &Ray, end_m: f64) -> (Option<f64>, f64) {
    let field = Field::around(snapshot, &ray.from);
    let Some([low_m, high_m]) = field.cloud_heights_m() else { return (None, 0.0) };
    let direction = (enu(&ray.from).transpose() * ray.direction).as_vec3();
    let inside = |range_m: f64| {
        let height_m = field.height_m(direction, range_m as f32);
        (low_m..=high_m).contains(&height_m)
    };
    let begin_m = ray.from_m.clamp(0.0, end_m);
    let step_m = ((end_m - begin_m) / MOST_STEPS).max(STEP_M);
    let mut depth = 0.0;
    let mut at_m = begin_m;
    while at_m < end_m {
        let length_m = step_m.min(end_m - at_m);
        let middle_m = at_m + 0.5 * length_m;
        if inside(middle_m) {
            let more = f64::from(field.cloud_per_m(direction, middle_m as f32)) * length_m;
            if let Some(opaque) = ray.opaque {
                let enough = -(1.0 - opaque.clamp(0.0, 1.0 - 1e-6)).ln();
                // Any cloud at all, for an opacity of 0.
                if more > 0.0 && depth + more >= enough {
                    let share = ((enough - depth) / more).clamp(0.0, 1.0);
                    return (Some(at_m + share * length_m), opaque);
                }
            }
            depth += more;
        }
        at_m += length_m;
    }
    (None, 1.0 - (-depth).exp())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clouds::CloudKind;
    use crate::geo::terrain::{Heights, Terrain};
    use crate::outputs::air::Air;
    use crate::outputs::conditions::conditions;
    use crate::plan::scenes::{clear_day, layer, place};
    use std::sync::Arc;

    /// A closed deck of stratus, so dense that it is whole all through, and a ray straight up through it.
    fn overcast() -> (Snapshot, Geodetic) {
        let mut snapshot = clear_day();
        let from = place(47.0, 8.0, 200.0);
        snapshot.weather.layers = vec![layer(CloudKind::Stratus, 1_000.0, 400.0)];
        snapshot.weather.layers[0].coverage = 1.0;
        (snapshot, from)
    }

    fn up(from: &Geodetic) -> Ray {
        Ray { direction: enu(from).z_axis, ..Ray::between(*from, &Geodetic { altitude_m: 3_000.0, ..*from }) }
    }

    /// Two walls north of 47 degrees: 400 m high 3 km away and 3,000 m high 20 km away, each a kilometre thick.
    #[derive(Debug)]
    struct Walls;

    impl Heights for Walls {
        fn height_m(&self, latitude_rad: f64, _: f64, _: f64) -> f64 {
            let north_m = (latitude_rad - 47f64.to_radians()) * 6_367_000.0;
            let within = |begin_m: f64| (begin_m..begin_m + 1_000.0).contains(&north_m);
            if within(3_000.0) { 400.0 } else { 3_000.0 * f64::from(u8::from(within(20_000.0))) }
        }
    }

    #[test]
    fn the_ground_is_looked_for_beyond_the_least_range_and_does_not_hide_what_stands_on_it() {
        let snapshot = Snapshot { terrain: Terrain::of(Arc::new(Walls)), ..clear_day() };
        let from = place(47.0, 8.0, 200.0);
        let north = |from_m: f64| sight(&snapshot, &Ray::towards(from, 0.0, 0.001, from_m, 50_000.0));
        // Steps of ten metres and more may end inside a wall; halving finds its face. A degree is not quite 111.13 km here.
        for (from_m, wall_m) in [(0.0, 3_000.0), (2_000.0, 3_000.0), (5_000.0, 20_000.0)] {
            let seen = north(from_m);
            assert_eq!(seen.hider, Some(Hider::Ground), "{from_m}");
            assert!((seen.range_m - wall_m).abs() < 0.003 * wall_m, "{from_m}: {}", seen.range_m);
        }
        assert_eq!(north(30_000.0).hider, None);
        // Standing before the first wall, on its foot, on its top and behind it.
        let hider = |latitude_m: f64, altitude_m: f64| {
            let to = place(47.0 + (latitude_m / 6_367_000.0_f64).to_degrees(), 8.0, altitude_m);
            sight(&snapshot, &Ray::between(from, &to)).hider
        };
        assert_eq!(hider(2_000.0, 0.0), None);
        assert_eq!(hider(2_990.0, 0.0), None);
        assert_eq!(hider(6_000.0, 0.0), Some(Hider::Ground));
        // From the ground, by a thousandth of a millimetre below it: the wall still hides.
        let foot = place(47.0, 8.0, -1e-6);
        let behind = place(47.09, 8.0, 100.0);
        assert_eq!(sight(&snapshot, &Ray::between(foot, &behind)).hider, Some(Hider::Ground));
    }

    #[test]
    fn a_slab_transmits_what_its_extinction_says() {
        let (snapshot, from) = overcast();
        let sigma = f64::from(CloudKind::Stratus.appearance().extinction_per_m) * snapshot.weather.layers[0].density;
        // The same field, asked point by point on the way up every metre: what the slab is made of, whatever its edges are.
        let field = Field::around(&snapshot, &from);
        let depth: f64 = (0..2_800).map(|m| f64::from(field.cloud_per_m(glam::Vec3::Z, m as f32 + 0.5))).sum();
        assert!(depth > 0.5 * sigma * 400.0 && depth <= sigma * 400.0 * 1.000_1, "{depth} of {}", sigma * 400.0);
        let seen = sight(&snapshot, &up(&from));
        assert_eq!(seen.hider, None);
        // Steps of 15 m against 1 m: each of the slab's two soft edges is off by less than a step of its extinction.
        let expected = -(1.0 - seen.opacity).ln();
        assert!((expected - depth).abs() < 15.0 * sigma, "{expected} {depth}");
        // Half hidden: after ln 2 of optical depth, a little above the base.
        let half = sight(&snapshot, &Ray { opaque: Some(0.5), ..up(&from) });
        assert_eq!(half.hider, Some(Hider::Cloud));
        let mut sum = 0.0;
        let met = (0..2_800).find(|m| {
            sum += f64::from(field.cloud_per_m(glam::Vec3::Z, *m as f32 + 0.5));
            sum >= std::f64::consts::LN_2
        });
        let met_m = f64::from(met.expect("dense enough"));
        assert!((half.range_m - met_m).abs() < 15.0 && half.opacity == 0.5, "{half:?} {met_m}");
        // Visibility inside: 2.996 / extinction of what is there.
        let inside = Geodetic { altitude_m: 1_200.0, ..from };
        let found = conditions(&snapshot, &Air::default(), &inside).visibility_m;
        let there = f64::from(Field::around(&snapshot, &inside).cloud_per_m(glam::Vec3::Z, 0.0));
        assert!(there > 0.0 && found <= 2.996 / there, "{found} {there}");
    }

    #[test]
    fn the_ground_hides_what_is_behind_the_horizon() {
        let mut snapshot = clear_day();
        snapshot.weather.layers.clear();
        let from = place(47.0, 8.0, 100.0);
        // 10 km away at 100 m: visible. 100 km away at 100 m: the straight line is x (100 - x) / 2R lower after x km, which is
        // 100 m after 15.0 km (R 6371 km; the ellipsoid's radius there differs by up to 0.5 %).
        assert_eq!(sight(&snapshot, &Ray::between(from, &place(47.09, 8.0, 100.0))).hider, None);
        let far = sight(&snapshot, &Ray::between(from, &place(47.9, 8.0, 100.0)));
        assert_eq!(far.hider, Some(Hider::Ground));
        assert!((14_850.0..15_150.0).contains(&far.range_m) && far.point.altitude_m.abs() < 1e-3, "{far:?}");
        let through = Ray { surfaces: Surfaces::NONE, ..Ray::between(from, &place(47.9, 8.0, 100.0)) };
        assert_eq!(sight(&snapshot, &through).hider, None);
        let down = Ray { direction: -enu(&from).z_axis, to_m: 50.0, ..up(&from) };
        assert_eq!(sight(&snapshot, &down).hider, None, "it ends before the ground");
        assert!((sight(&snapshot, &Ray { to_m: 500.0, ..down }).range_m - 100.0).abs() < 1e-6);
        assert_eq!(sight(&snapshot, &Ray { to_m: 500.0, from_m: 200.0, ..down }).hider, None, "nearer than asked");
    }
}
