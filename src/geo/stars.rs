//! The stars that the eye can see, from a catalogue (`data/stars.bin`): 3,232 to magnitude 5.6.

use super::celestial::mean_sidereal_time_rad;
use glam::{DMat3, DVec3};

/// Bytes of an entry, and before the first.
const ENTRY: usize = 6;
const HEADER: usize = 8;
/// Illuminance by a star of magnitude 0 outside the air (Allen 1973: 2.54e-6 lux).
const MAGNITUDE_ZERO_LUX: f64 = 2.54e-6;

/// A star.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Star {
    /// Unit vector towards it, equator and equinox of J2000.
    pub direction: DVec3,
    /// Illuminance by it outside the air, lux.
    pub illuminance_lux: f64,
    /// Colour index B-V: 0 is white, 1.5 orange.
    pub colour: f64,
}

/// All stars, the brightest first.
pub fn all() -> impl Iterator<Item = Star> {
    let bytes = include_bytes!("../../data/stars.bin");
    bytes[HEADER..].chunks_exact(ENTRY).map(|entry| {
        let number = |at: usize| f64::from(u16::from_le_bytes([entry[at], entry[at + 1]]));
        let right_ascension = number(0) / 65_536.0 * std::f64::consts::TAU;
        let declination = (number(2) / 65_535.0 - 0.5) * std::f64::consts::PI;
        let magnitude = f64::from(entry[4]) / 30.0 - 2.0;
        let (sin_dec, cos_dec) = declination.sin_cos();
        let (sin_ra, cos_ra) = right_ascension.sin_cos();
        Star {
            direction: DVec3::new(cos_dec * cos_ra, cos_dec * sin_ra, sin_dec),
            illuminance_lux: MAGNITUDE_ZERO_LUX * 10f64.powf(-0.4 * magnitude),
            colour: f64::from(entry[5]) / 100.0 - 0.5,
        }
    })
}

/// Turns directions of the catalogue into ECEF axes at a moment in seconds since 1970-01-01T00:00:00 UTC: the Earth's turning
/// and precession in right ascension and declination to the first order (Meeus chapter 21: 0.01 degree for this century).
pub fn earth_from_stars(utc_s: f64) -> DMat3 {
    let centuries = (utc_s - 946_728_000.0) / (86_400.0 * 36_525.0);
    let angle = |arc_seconds: f64| (arc_seconds * centuries / 3_600.0).to_radians();
    // Meeus eq. 21.3: zeta, z and theta, the first terms.
    let (zeta, z, theta) = (angle(2_306.218_1), angle(2_306.218_1), angle(2_004.310_9));
    let precession = DMat3::from_rotation_z(z) * DMat3::from_rotation_y(-theta) * DMat3::from_rotation_z(zeta);
    DMat3::from_rotation_z(-mean_sidereal_time_rad(utc_s)) * precession
}

#[cfg(test)]
mod tests {
    use super::*;

    fn degrees(direction: DVec3) -> (f64, f64) {
        (direction.y.atan2(direction.x).to_degrees().rem_euclid(360.0), direction.z.asin().to_degrees())
    }

    #[test]
    fn the_brightest_stars_are_those_of_the_sky() {
        let stars: Vec<Star> = all().collect();
        assert_eq!(stars.len(), 3_232);
        // Sirius, Canopus: right ascension and declination (J2000), magnitudes -1.44 and -0.62 of the catalogue.
        for (star, right_ascension, declination, magnitude) in
            [(stars[0], 101.287, -16.716, -1.44), (stars[1], 95.988, -52.696, -0.62)]
        {
            let (ra, dec) = degrees(star.direction);
            // Sixteen bits of a turn are 0.0055 degree; magnitudes are told to a thirtieth.
            assert!((ra - right_ascension).abs() < 0.006 && (dec - declination).abs() < 0.003, "{ra} {dec}");
            let found = -2.5 * (star.illuminance_lux / MAGNITUDE_ZERO_LUX).log10();
            assert!((found - magnitude).abs() < 0.02, "{found}");
        }
        assert!(stars.windows(2).all(|pair| pair[0].illuminance_lux >= pair[1].illuminance_lux));
    }

    #[test]
    fn the_pole_star_stands_over_the_pole_and_the_sky_turns_westwards() {
        let utc_s = 1_782_032_400.0;
        let turned = |hours: f64| earth_from_stars(utc_s + 3_600.0 * hours);
        let polaris = DVec3::new(f64::cos(0.6624) * 0.0128, f64::sin(0.6624) * 0.0128, 0.99992).normalize();
        assert!((turned(0.0) * polaris).z.asin().to_degrees() > 89.2);
        // Meeus example 21.b: alpha Ursae Minoris' declination grows; theta Persei, example 21.b: 41.0499, 49.2285 (2000)
        // to 41.5472, 49.3485 in 2028.87, proper motion of 28.9 years left out (0.0001 degree).
        let direction = |ra: f64, dec: f64| {
            let (ra, dec) = (ra.to_radians(), dec.to_radians());
            DVec3::new(dec.cos() * ra.cos(), dec.cos() * ra.sin(), dec.sin())
        };
        let then_s = 946_728_000.0 + 0.288_670_5 * 36_525.0 * 86_400.0;
        let sidereal = DMat3::from_rotation_z(mean_sidereal_time_rad(then_s));
        let (ra, dec) = degrees(sidereal * earth_from_stars(then_s) * direction(41.0540, 49.2277));
        assert!((ra - 41.5472).abs() < 0.006 && (dec - 49.3485).abs() < 0.003, "{ra} {dec}");
        // After a sidereal day all is as before: 0.004 degree are left by the rounding of its length.
        let day = turned(23.934_469_6) * DVec3::X - turned(0.0) * DVec3::X;
        assert!(day.length() < 1e-5, "{day}");
        let (first, later) = (degrees(turned(0.0) * DVec3::X).0, degrees(turned(1.0) * DVec3::X).0);
        assert!(((first - later).rem_euclid(360.0) - 15.041).abs() < 0.001);
    }
}
