//! Sun and moon against printed values: Meeus' worked examples, the USNO's dates of seasons, and two total eclipses.

use super::*;
use crate::geo::Geodetic;
use crate::geo::wgs84::to_ecef;

/// Days from J2000 to centuries.
fn centuries(julian_day: f64) -> f64 {
    (julian_day - 2_451_545.0) / CENTURY_DAYS
}

fn utc(text: &str) -> f64 {
    text.parse::<jiff::Timestamp>().unwrap().as_millisecond() as f64 / 1000.0
}

#[test]
fn sidereal_time_of_meeus_example_12() {
    // 1987 April 10, 0h UT: 13h 10m 46.3668s; and 19:21:00 UT: 8h 34m 57.0896s. The days are held to 1e-11 of a day.
    let midnight = mean_sidereal_time_rad(utc("1987-04-10T00:00:00Z")).to_degrees();
    assert!((midnight - (13.0 + 10.0 / 60.0 + 46.3668 / 3600.0) * 15.0).abs() < 1e-6, "{midnight}");
    let evening = mean_sidereal_time_rad(utc("1987-04-10T19:21:00Z")).to_degrees();
    assert!((evening - 128.737_873_4).abs() < 1e-6, "{evening}");
}

#[test]
fn sun_of_meeus_example_25a() {
    // 1992 October 13, 0h TD: true longitude 199.90987, radius 0.99766 (same method, so to the last printed digit).
    let sun = sun_ecliptic(centuries(2_448_908.5));
    assert!((sun.longitude_rad.to_degrees() - 199.909_87).abs() < 1e-5, "{}", sun.longitude_rad.to_degrees());
    assert!((sun.distance_m / ASTRONOMICAL_UNIT_M - 0.997_66).abs() < 1e-5);
}

#[test]
fn moon_of_meeus_examples_47a_and_48a() {
    // 1992 April 12, 0h TD: 133.162655, -3.229126, 368409.7 km; lit share 0.6786.
    let t = centuries(2_448_724.5);
    let moon = moon_ecliptic(t);
    // The terms left out are below 0.0036 degree each in longitude; together a few of them.
    assert!((moon.longitude_rad.to_degrees() - 133.162_655).abs() < 0.012, "{}", moon.longitude_rad.to_degrees());
    assert!((moon.latitude_rad.to_degrees() + 3.229_126).abs() < 0.006, "{}", moon.latitude_rad.to_degrees());
    assert!((moon.distance_m - 368_409_700.0).abs() < 60_000.0, "{}", moon.distance_m);
    let lit = lit_fraction(&sun_ecliptic(t), &moon);
    // 0.012 degree of elongation is 1e-4 of the lit share.
    assert!((lit - 0.6786).abs() < 2e-4, "{lit}");
}

#[test]
fn nutation_of_meeus_example_22a() {
    // 1987 April 10, 0h TD: -3.788" in longitude, true obliquity 23 26' 36.850"; the short series is good to 0.5" and 0.1".
    let nutation = Nutation::at(centuries(2_446_895.5));
    assert!((nutation.longitude_rad.to_degrees() * 3600.0 + 3.788).abs() < 0.5);
    let printed = 23.0 + 26.0 / 60.0 + 36.850 / 3600.0;
    assert!((nutation.true_obliquity_rad.to_degrees() - printed).abs() * 3600.0 < 0.1);
}

#[test]
fn seasons_of_2026() {
    // USNO, "Earth's Seasons" for 2026, to the minute. The sun's longitude is good to 0.01 degree, and so are the
    // declinations at the equinoxes (times 0.4).
    let declination = |text: &str| (sun_and_moon(utc(text)).sun_m.normalize().z).asin().to_degrees();
    for equinox in ["2026-03-20T14:46:00Z", "2026-09-23T00:05:00Z"] {
        assert!(declination(equinox).abs() < 0.004, "{equinox}: {}", declination(equinox));
    }
    // At the solstices the declination is the obliquity of date, 23.436 degrees.
    assert!((declination("2026-06-21T08:24:00Z") - 23.436).abs() < 0.003);
    assert!((declination("2026-12-21T20:50:00Z") + 23.436).abs() < 0.003);
}

#[test]
fn total_eclipses_stand_over_their_printed_place() {
    // NASA, "Five Millennium Canon of Solar Eclipses" (Espenak and Meeus), greatest eclipse: time and place.
    for (time, latitude_deg, longitude_deg) in [
        ("2024-04-08T18:17:16Z", 25.3, -104.1),
        ("2026-08-12T17:45:51Z", 65.2, -25.2),
        ("1999-08-11T11:03:04Z", 45.1, 24.3),
    ] {
        let place = Geodetic {
            latitude_rad: f64::to_radians(latitude_deg),
            longitude_rad: f64::to_radians(longitude_deg),
            altitude_m: 0.0,
        };
        let eye = to_ecef(&place);
        let sky = sun_and_moon(utc(time));
        let apart = (sky.sun_m - eye).angle_between(sky.moon_m - eye).to_degrees();
        // 0.02 degree of our moon, 0.01 of our sun, 0.05 degree of printed place seen with the moon's parallax (0.001).
        assert!(apart < 0.03, "{time}: {apart}");
        assert!(sky.moon_lit_fraction < 1e-3, "{time}: {}", sky.moon_lit_fraction);
    }
}

#[test]
fn a_lunar_eclipse_is_a_full_moon_against_the_sun() {
    // NASA, "Five Millennium Canon of Lunar Eclipses": 2026 March 3, greatest at 11:33:37 UT, gamma 0.3765.
    let sky = sun_and_moon(utc("2026-03-03T11:33:37Z"));
    let off = std::f64::consts::PI - sky.sun_m.angle_between(sky.moon_m);
    // Gamma: distance of the moon's centre from the shadow's axis in equatorial radii of the Earth.
    let gamma = off.sin() * sky.moon_m.length() / 6_378_137.0;
    // 0.02 degree of the moon is 0.02 of the Earth's radius.
    assert!((gamma - 0.3765).abs() < 0.02, "{gamma}");
    assert!(sky.moon_lit_fraction > 0.999_9);
}

#[test]
fn the_sun_is_overhead_where_and_when_it_should_be() {
    // Noon at the meridian of Greenwich within the equation of time: 2026-06-21 is +1.8 min slow (Astronomical Almanac).
    let sky = sun_and_moon(utc("2026-06-21T12:00:00Z"));
    let longitude = sky.sun_m.y.atan2(sky.sun_m.x).to_degrees();
    // 1.8 minutes of time are 0.45 degree; printed to a tenth of a minute (0.025 degree).
    assert!((longitude - 0.45).abs() < 0.05, "{longitude}");
}
