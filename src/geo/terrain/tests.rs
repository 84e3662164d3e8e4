//! The height function: where it is high, what it never does, and what its slope is.

use super::*;
use crate::geo::frames::Curvature;

fn at(latitude_deg: f64, longitude_deg: f64) -> Geodetic {
    Geodetic { latitude_rad: latitude_deg.to_radians(), longitude_rad: longitude_deg.to_radians(), altitude_m: 0.0 }
}

/// Lowest, mean and highest of a square of half a degree.
fn country(terrain: &Terrain, latitude_deg: f64, longitude_deg: f64) -> [f64; 3] {
    let heights: Vec<f64> = (0..900)
        .map(|k| {
            terrain.height_m(&at(latitude_deg + f64::from(k % 30) / 60.0, longitude_deg + f64::from(k / 30) / 60.0))
        })
        .collect();
    let fold = |f: fn(f64, f64) -> f64| heights.iter().copied().reduce(f).unwrap_or(0.0);
    [fold(f64::min), heights.iter().sum::<f64>() / 900.0, fold(f64::max)]
}

#[test]
fn alps_are_mountains_plains_are_plains_and_the_sea_is_level() {
    let terrain = Terrain::procedural();
    let alps = country(&terrain, 46.2, 7.6);
    assert!(alps[0] > 300.0 && alps[2] > 2_800.0 && alps[2] < 5_500.0, "{alps:?}");
    let himalaya = country(&terrain, 27.9, 86.5);
    assert!(himalaya[2] > 5_500.0 && himalaya[2] <= HIGHEST_M, "{himalaya:?}");
    let plain = country(&terrain, 51.2, 6.5);
    assert!(plain[0] >= 0.0 && plain[2] < 450.0, "{plain:?}");
    assert_eq!(country(&terrain, 0.0, -30.0), [0.0; 3]);
    assert_eq!(Terrain::ELLIPSOID.height_m(&at(46.2, 7.6)), 0.0);
}

#[test]
fn towns_lie_in_valleys() {
    let terrain = Terrain::procedural();
    // Real heights: 375, 574, 262, 553, 1,400, 3,650, 2,240, 3,640, 1,280 m; the made ones stand on plains of 15 to 300 m and on the
    // floors of the ranges, which are good to some hundred metres.
    for (name, latitude, longitude, least_m, most_m) in [
        ("Geneva", 46.20, 6.15, 50.0, 900.0),
        ("Innsbruck", 47.26, 11.39, 200.0, 1_000.0),
        ("Bolzano", 46.49, 11.35, 100.0, 1_000.0),
        ("Grenoble", 45.18, 5.72, 50.0, 900.0),
        ("Kathmandu", 27.71, 85.32, 600.0, 2_200.0),
        ("Lhasa", 29.65, 91.10, 2_500.0, 4_200.0),
        ("Mexico City", 19.43, -99.13, 1_500.0, 2_900.0),
        ("La Paz", -16.50, -68.15, 2_800.0, 4_500.0),
        ("Salt Lake City", 40.76, -111.89, 700.0, 2_000.0),
    ] {
        let height = terrain.height_m(&at(latitude, longitude));
        assert!((least_m..most_m).contains(&height), "{name}: {height}");
        // What is level enough to be lived in: less than 1 in 5 over the middle.
        let slope = terrain.normal(&at(latitude, longitude)).z.acos().tan();
        assert!(slope < 0.2, "{name}: {slope}");
    }
}

#[test]
fn the_ground_is_continuous_everywhere() {
    let terrain = Terrain::procedural();
    // 20 m steps over a coast, through mountains, over the pole, across the 180th meridian.
    for (latitude, longitude, north, east) in [
        (43.45, 7.1, 1.0, 0.3),
        (46.3, 7.9, 0.2, 1.0),
        (47.1, 11.39, 1.0, 0.0),
        (-89.99, 30.0, -1.0, 0.0),
        (67.2, 179.98, 0.0, 1.0),
    ] {
        let step = 20.0 / 111_195.0;
        let mut before = terrain.height_m(&at(latitude, longitude));
        for k in 1..3_000 {
            let (lat, lon) = (latitude + step * north * f64::from(k), longitude + step * east * f64::from(k));
            let (lat, lon) = if lat < -90.0 { (-180.0 - lat, lon + 180.0) } else { (lat, lon) };
            let next = terrain.height_m(&at(lat, lon));
            // Steeper than 70 degrees there is nothing.
            assert!((next - before).abs() < 56.0, "{lat} {lon}: {before} {next}");
            before = next;
        }
    }
}

#[test]
fn the_shore_is_at_sea_level() {
    let terrain = Terrain::procedural();
    let mut met = 0;
    for k in 0..4_000 {
        let place = at(43.3 + 0.0001 * f64::from(k), 6.9);
        let (shore, height) = (shore_m(place.latitude_rad, place.longitude_rad), terrain.height_m(&place));
        assert!(height == 0.0 || Terrain::is_land(&place), "{shore} {height}");
        if (0.0..50.0).contains(&shore) {
            met += 1;
            assert!(height <= 0.5 * shore + 1.0, "{shore} m from the shore it is {height} m high");
        }
    }
    assert!(met > 0);
}

#[test]
fn a_normal_stands_on_the_slope() {
    /// A plane that rises to the north by 1 in 4 and to the east by 1 in 8.
    #[derive(Debug)]
    struct Plane;
    impl Heights for Plane {
        fn height_m(&self, latitude_rad: f64, longitude_rad: f64, _: f64) -> f64 {
            let curvature = Curvature::at(0.7);
            let north_m = (latitude_rad - 0.7) * curvature.meridian_m;
            100.0 + 0.25 * north_m + 0.125 * longitude_rad * curvature.prime_vertical_m * f64::cos(0.7)
        }
    }
    let terrain = Terrain::of(Arc::new(Plane));
    let found = terrain.normal(&Geodetic { latitude_rad: 0.7, longitude_rad: 0.0, altitude_m: 5.0 });
    // Central differences are exact for a plane. In degrees of longitude it is none: 1 m eastwards counts cos(latitude) more after
    // 10 m northwards, by 10 m over the radius.
    assert!((found - DVec3::new(-0.125, -0.25, 1.0).normalize()).length() < 2e-6, "{found}");
    assert_eq!(Terrain::ELLIPSOID.normal(&at(46.2, 7.6)), DVec3::Z);
}

#[test]
fn a_normal_stands_on_the_slope_at_a_pole_too() {
    /// A plane that leans over the poles: it rises by 1 in 5 along the x axis of the Earth.
    #[derive(Debug)]
    struct Leaning;
    impl Heights for Leaning {
        fn height_m(&self, latitude_rad: f64, longitude_rad: f64, _: f64) -> f64 {
            0.2 * to_ecef(&Geodetic { latitude_rad, longitude_rad, altitude_m: 0.0 }).x
        }
    }
    let terrain = Terrain::of(Arc::new(Leaning));
    for latitude in [90.0, 89.999_99, 89.999_9, -89.999_95, -90.0] {
        for longitude in [0.0, 37.0, 180.0, -120.0] {
            let place = at(latitude, longitude);
            let axes = enu(&place);
            let expected = DVec3::new(-0.2 * axes.x_axis.x, -0.2 * axes.y_axis.x, 1.0).normalize();
            let found = terrain.normal(&place);
            // The plane of the pole against that of a place 10 m away: they lean by 2e-6.
            assert!((found - expected).length() < 1e-5, "{latitude} {longitude}: {found} {expected}");
        }
    }
}

#[test]
fn made_ground_is_nowhere_steeper_than_it_says() {
    let terrain = Terrain::procedural();
    let mut steepest = 0.0f64;
    for (latitude, longitude) in
        [(46.2, 7.6), (27.9, 86.5), (-13.2, -72.5), (61.0, -150.5), (43.3, 6.9), (36.6, -118.3)]
    {
        let mut before: Option<(Geodetic, f64)> = None;
        for k in 0..4_000 {
            // 10 m steps north-eastwards.
            let place = at(latitude + 6.4e-5 * f64::from(k), longitude + 9e-5 * f64::from(k));
            let height = terrain.height_m(&place);
            if let Some((last, last_m)) = before {
                let run = (to_ecef(&place) - to_ecef(&last)).length();
                steepest = steepest.max((height - last_m).abs() / run);
            }
            before = Some((place, height));
        }
    }
    let said = terrain.roughness(&at(46.2, 7.6)).steepest;
    assert!(steepest > 0.3 * said && steepest < said, "{steepest} of {said}");
}

#[test]
fn smoothed_heights_are_the_mean_of_what_they_leave_out() {
    let terrain = Terrain::procedural();
    let (mut apart, mut spread) = (0.0, 0.0f64);
    for k in 0..400 {
        let place = at(46.2 + 0.002 * f64::from(k % 20), 7.6 + 0.002 * f64::from(k / 20));
        let coarse = terrain.smoothed_height_m(place.latitude_rad, place.longitude_rad, 2_000.0);
        let off = terrain.height_m(&place) - coarse;
        apart += off / 400.0;
        spread = spread.max(off.abs());
    }
    // What is left out is up to some hundred metres high here and there, its mean a small part of that.
    assert!(spread > 30.0 && apart.abs() < 0.3 * spread, "mean {apart}, at most {spread}");
}

#[test]
fn a_source_that_answers_nonsense_is_sea_level() {
    #[derive(Debug)]
    struct Nonsense(f64);
    impl Heights for Nonsense {
        fn height_m(&self, _: f64, _: f64, _: f64) -> f64 {
            self.0
        }
    }
    let height = |value| Terrain::of(Arc::new(Nonsense(value))).height_m(&at(0.0, 0.0));
    assert_eq!([height(f64::NAN), height(f64::INFINITY), height(1e9), height(-1e9)], [0.0, 0.0, HIGHEST_M, LOWEST_M]);
}
