//! Sun and moon from UTC: Meeus, "Astronomical Algorithms" (2nd edition), to about 0.01 degree (sun) and 0.02 degree (moon).

use glam::{DMat3, DVec3};

/// Metres in one astronomical unit (IAU 2012 resolution B2).
pub const ASTRONOMICAL_UNIT_M: f64 = 149_597_870_700.0;
/// Terrestrial time minus UTC in seconds: 32.184 + 37 leap seconds, as since 2017. One value for all years: 70 s either
/// way (1900 to 2100) move the moon by 0.01 degree.
pub const TERRESTRIAL_MINUS_UTC_S: f64 = 69.184;

const J2000_UNIX_S: f64 = 946_728_000.0;
const DAY_S: f64 = 86_400.0;
const CENTURY_DAYS: f64 = 36_525.0;

/// Where the sun and moon stand, from the Earth's centre in ECEF axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunAndMoon {
    /// Position of the sun in metres.
    pub sun_m: DVec3,
    /// Position of the moon in metres.
    pub moon_m: DVec3,
    /// Lit share of the moon's disc, 0 (new) to 1 (full), seen from the Earth's centre.
    pub moon_lit_fraction: f64,
}

/// Sun and moon at a moment given in seconds since 1970-01-01T00:00:00 UTC.
pub fn sun_and_moon(utc_s: f64) -> SunAndMoon {
    let centuries = (utc_s + TERRESTRIAL_MINUS_UTC_S - J2000_UNIX_S) / (DAY_S * CENTURY_DAYS);
    let nutation = Nutation::at(centuries);
    let sun = sun_ecliptic(centuries);
    let moon = moon_ecliptic(centuries);
    // Equator and equinox of date, then the Earth's turning: sidereal time is the angle from the equinox to Greenwich.
    let earth_from_ecliptic = DMat3::from_rotation_z(-apparent_sidereal_time_rad(utc_s, &nutation))
        * DMat3::from_rotation_x(nutation.true_obliquity_rad);
    let apparent = |place: &Ecliptic, aberration_rad: f64| {
        let longitude_rad = place.longitude_rad + nutation.longitude_rad + aberration_rad;
        let (sin_lon, cos_lon) = longitude_rad.sin_cos();
        let (sin_lat, cos_lat) = place.latitude_rad.sin_cos();
        earth_from_ecliptic * DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat) * place.distance_m
    };
    // Meeus chapter 25: aberration of the sun, -20.4898" / R.
    let aberration_rad = -(20.4898 / 3600.0_f64).to_radians() * ASTRONOMICAL_UNIT_M / sun.distance_m;
    SunAndMoon {
        sun_m: apparent(&sun, aberration_rad),
        moon_m: apparent(&moon, 0.0),
        moon_lit_fraction: lit_fraction(&sun, &moon),
    }
}

/// Greenwich mean sidereal time in radians, 0 to 2 pi (Meeus eq. 12.4; UT1 is taken for UTC, 0.9 s or 0.004 degree).
pub fn mean_sidereal_time_rad(utc_s: f64) -> f64 {
    let days = (utc_s - J2000_UNIX_S) / DAY_S;
    let t = days / CENTURY_DAYS;
    let degrees = 280.460_618_37 + 360.985_647_366_29 * days + t * t * (0.000_387_933 - t / 38_710_000.0);
    degrees.rem_euclid(360.0).to_radians()
}

fn apparent_sidereal_time_rad(utc_s: f64, nutation: &Nutation) -> f64 {
    mean_sidereal_time_rad(utc_s) + nutation.longitude_rad * nutation.true_obliquity_rad.cos()
}

struct Ecliptic {
    longitude_rad: f64,
    latitude_rad: f64,
    distance_m: f64,
}

struct Nutation {
    longitude_rad: f64,
    true_obliquity_rad: f64,
}

impl Nutation {
    /// Meeus chapter 22, low accuracy (0.5" in longitude, 0.1" in obliquity), and eq. 22.2 for the mean obliquity.
    fn at(t: f64) -> Self {
        let node = (125.044_52 - 1_934.136_261 * t).to_radians();
        let sun = (280.466_5 + 36_000.769_8 * t).to_radians();
        let moon = (218.316_5 + 481_267.881_3 * t).to_radians();
        let arc = |seconds: f64| (seconds / 3600.0).to_radians();
        let longitude_rad =
            arc(-17.20 * node.sin() - 1.32 * (2.0 * sun).sin() - 0.23 * (2.0 * moon).sin() + 0.21 * (2.0 * node).sin());
        let obliquity = arc(84_381.448 - 46.815 * t - 0.000_59 * t * t + 0.001_813 * t * t * t);
        let change =
            arc(9.20 * node.cos() + 0.57 * (2.0 * sun).cos() + 0.10 * (2.0 * moon).cos() - 0.09 * (2.0 * node).cos());
        Self { longitude_rad, true_obliquity_rad: obliquity + change }
    }
}

/// Meeus chapter 25, low accuracy: true geometric longitude of the sun, mean equinox of date.
fn sun_ecliptic(t: f64) -> Ecliptic {
    let mean_longitude = 280.466_46 + t * (36_000.769_83 + 0.000_303_2 * t);
    let anomaly = (357.529_11 + t * (35_999.050_29 - 0.000_153_7 * t)).to_radians();
    let eccentricity = 0.016_708_634 - t * (0.000_042_037 + 0.000_000_126_7 * t);
    let centre = (1.914_602 - t * (0.004_817 + 0.000_014 * t)) * anomaly.sin()
        + (0.019_993 - 0.000_101 * t) * (2.0 * anomaly).sin()
        + 0.000_289 * (3.0 * anomaly).sin();
    let true_anomaly = anomaly + centre.to_radians();
    let radius = 1.000_001_018 * (1.0 - eccentricity * eccentricity) / (1.0 + eccentricity * true_anomaly.cos());
    Ecliptic {
        longitude_rad: (mean_longitude + centre).rem_euclid(360.0).to_radians(),
        latitude_rad: 0.0,
        distance_m: radius * ASTRONOMICAL_UNIT_M,
    }
}

/// Multiples of D, M, M', F; longitude in 1e-6 degree; distance in metres (Meeus table 47.A, terms of 0.0036 degree and more).
const MOON_LONGITUDE: [([f64; 4], f64, f64); 27] = [
    ([0.0, 0.0, 1.0, 0.0], 6_288_774.0, -20_905_355.0),
    ([2.0, 0.0, -1.0, 0.0], 1_274_027.0, -3_699_111.0),
    ([2.0, 0.0, 0.0, 0.0], 658_314.0, -2_955_968.0),
    ([0.0, 0.0, 2.0, 0.0], 213_618.0, -569_925.0),
    ([0.0, 1.0, 0.0, 0.0], -185_116.0, 48_888.0),
    ([0.0, 0.0, 0.0, 2.0], -114_332.0, -3_149.0),
    ([2.0, 0.0, -2.0, 0.0], 58_793.0, 246_158.0),
    ([2.0, -1.0, -1.0, 0.0], 57_066.0, -152_138.0),
    ([2.0, 0.0, 1.0, 0.0], 53_322.0, -170_733.0),
    ([2.0, -1.0, 0.0, 0.0], 45_758.0, -204_586.0),
    ([0.0, 1.0, -1.0, 0.0], -40_923.0, -129_620.0),
    ([1.0, 0.0, 0.0, 0.0], -34_720.0, 108_743.0),
    ([0.0, 1.0, 1.0, 0.0], -30_383.0, 104_755.0),
    ([2.0, 0.0, 0.0, -2.0], 15_327.0, 10_321.0),
    ([0.0, 0.0, 1.0, 2.0], -12_528.0, 0.0),
    ([0.0, 0.0, 1.0, -2.0], 10_980.0, 79_661.0),
    ([4.0, 0.0, -1.0, 0.0], 10_675.0, -34_782.0),
    ([0.0, 0.0, 3.0, 0.0], 10_034.0, -23_210.0),
    ([4.0, 0.0, -2.0, 0.0], 8_548.0, -21_636.0),
    ([2.0, 1.0, -1.0, 0.0], -7_888.0, 24_208.0),
    ([2.0, 1.0, 0.0, 0.0], -6_766.0, 30_824.0),
    ([1.0, 0.0, -1.0, 0.0], -5_163.0, -8_379.0),
    ([1.0, 1.0, 0.0, 0.0], 4_987.0, -16_675.0),
    ([2.0, -1.0, 1.0, 0.0], 4_036.0, -12_831.0),
    ([2.0, 0.0, 2.0, 0.0], 3_994.0, -10_445.0),
    ([4.0, 0.0, 0.0, 0.0], 3_861.0, -11_650.0),
    ([2.0, 0.0, -3.0, 0.0], 3_665.0, 14_403.0),
];

/// Multiples of D, M, M', F; latitude in 1e-6 degree (Meeus table 47.B, terms of 0.0018 degree and more).
const MOON_LATITUDE: [([f64; 4], f64); 18] = [
    ([0.0, 0.0, 0.0, 1.0], 5_128_122.0),
    ([0.0, 0.0, 1.0, 1.0], 280_602.0),
    ([0.0, 0.0, 1.0, -1.0], 277_693.0),
    ([2.0, 0.0, 0.0, -1.0], 173_237.0),
    ([2.0, 0.0, -1.0, 1.0], 55_413.0),
    ([2.0, 0.0, -1.0, -1.0], 46_271.0),
    ([2.0, 0.0, 0.0, 1.0], 32_573.0),
    ([0.0, 0.0, 2.0, 1.0], 17_198.0),
    ([2.0, 0.0, 1.0, -1.0], 9_266.0),
    ([0.0, 0.0, 2.0, -1.0], 8_822.0),
    ([2.0, -1.0, 0.0, -1.0], 8_216.0),
    ([2.0, 0.0, -2.0, -1.0], 4_324.0),
    ([2.0, 0.0, 1.0, 1.0], 4_200.0),
    ([2.0, 1.0, 0.0, -1.0], -3_359.0),
    ([2.0, -1.0, -1.0, 1.0], 2_463.0),
    ([2.0, -1.0, 0.0, 1.0], 2_211.0),
    ([2.0, -1.0, -1.0, -1.0], 2_065.0),
    ([0.0, 1.0, -1.0, -1.0], -1_870.0),
];

/// Meeus chapter 47 with the terms above; mean equinox of date.
fn moon_ecliptic(t: f64) -> Ecliptic {
    let mean_longitude = 218.316_447_7 + t * (481_267.881_234_21 - 0.001_578_6 * t);
    let elongation = 297.850_192_1 + t * (445_267.111_403_4 - 0.001_881_9 * t);
    let sun_anomaly = 357.529_109_2 + t * (35_999.050_290_9 - 0.000_153_6 * t);
    let moon_anomaly = 134.963_396_4 + t * (477_198.867_505_5 + 0.008_741_4 * t);
    let latitude_argument = 93.272_095_0 + t * (483_202.017_523_3 - 0.003_653_9 * t);
    let eccentricity = 1.0 - t * (0.002_516 + 0.000_007_4 * t);
    let argument = |n: &[f64; 4]| {
        (n[0] * elongation + n[1] * sun_anomaly + n[2] * moon_anomaly + n[3] * latitude_argument)
            .rem_euclid(360.0)
            .to_radians()
    };
    let weight = |n: &[f64; 4]| eccentricity.powf(n[1].abs());
    let (mut longitude, mut distance_m, mut latitude) = (0.0, 385_000_560.0, 0.0);
    for (n, sine, cosine) in &MOON_LONGITUDE {
        longitude += weight(n) * sine * argument(n).sin();
        distance_m += weight(n) * cosine * argument(n).cos();
    }
    for (n, sine) in &MOON_LATITUDE {
        latitude += weight(n) * sine * argument(n).sin();
    }
    // Action of Venus, Jupiter and the flattening of the Earth (Meeus p. 338), the largest of them.
    let venus = (119.75 + 131.849 * t).to_radians();
    let mean = mean_longitude.to_radians();
    longitude += 3_958.0 * venus.sin() + 1_962.0 * (mean - latitude_argument.to_radians()).sin();
    latitude += -2_235.0 * mean.sin();
    Ecliptic {
        longitude_rad: (mean_longitude + longitude * 1e-6).rem_euclid(360.0).to_radians(),
        latitude_rad: (latitude * 1e-6).to_radians(),
        distance_m,
    }
}

/// Meeus eq. 48.2 and 48.3 for the phase angle, 48.1 for the lit share.
fn lit_fraction(sun: &Ecliptic, moon: &Ecliptic) -> f64 {
    let elongation = (moon.latitude_rad.cos() * (moon.longitude_rad - sun.longitude_rad).cos()).clamp(-1.0, 1.0).acos();
    let phase = (sun.distance_m * elongation.sin()).atan2(moon.distance_m - sun.distance_m * elongation.cos());
    (1.0 + phase.cos()) / 2.0
}

#[cfg(test)]
mod tests;
