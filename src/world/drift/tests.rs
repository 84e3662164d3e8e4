//! Drift: exact after ten years, and without a jump or a kink through every change of wind.

use super::*;

fn point(latitude_deg: f64, longitude_deg: f64) -> Geodetic {
    Geodetic { latitude_rad: latitude_deg.to_radians(), longitude_rad: longitude_deg.to_radians(), altitude_m: 0.0 }
}

fn wind(speed_mps: f64, from_deg: f64) -> Wind {
    Wind { reference: point(47.0, 8.0), height_m: 1_000.0, speed_mps, from_deg }
}

/// The place on the ground to which a pattern point has drifted.
fn ground(drift: &Drift, now_s: f64) -> DVec3 {
    drift.at(now_s) * enu(&point(47.0, 8.0)).z_axis * MEAN_RADIUS_M
}

#[test]
fn the_pattern_goes_where_the_wind_blows_to_at_its_speed() {
    for (from_deg, east, north) in
        [(270.0, 1.0, 0.0), (0.0, 0.0, -1.0), (180.0, 0.0, 1.0), (45.0, -0.5_f64.sqrt(), -0.5_f64.sqrt())]
    {
        let drift = Drift::new(wind(20.0, from_deg), 100.0);
        let moved = (ground(&drift, 110.0) - ground(&drift, 100.0)) / 10.0;
        let axes = enu(&point(47.0, 8.0));
        let scale = MEAN_RADIUS_M / (MEAN_RADIUS_M + 1_000.0);
        let expected = (axes.x_axis * east + axes.y_axis * north) * 20.0 * scale;
        // The 200 m that it goes in 10 s are an arc, which leaves its tangent by half its angle: 1.6e-5 of the speed.
        assert!((moved - expected).length() < 20.0 * 2e-5, "from {from_deg}: {moved} {expected}");
        assert!((moved.length() / (20.0 * scale) - 1.0).abs() < 1e-5);
    }
}

/// a * b mod 2 pi with 128-bit integers: radians in units of 2^-93 (2 pi to 96 bits), exact but for the last unit.
fn angle_by_integers(omega: f64, seconds: i128) -> f64 {
    // omega = m 2^e exactly.
    let bits = omega.to_bits();
    let exponent = ((bits >> 52) & 0x7ff) as i32 - 1075;
    let mantissa = i128::from((bits & ((1 << 52) - 1)) | (1 << 52));
    let product = mantissa * seconds; // exact: 53 + 29 bits
    let shift = 93 + exponent;
    let angle = if shift >= 0 { product << shift } else { product >> -shift };
    // 2 pi = 6.28318530717958647692528676655900577 in units of 2^-93, in three parts that i128 can add.
    let two_pi = two_pi_in_units();
    (angle.rem_euclid(two_pi)) as f64 / 2.0_f64.powi(93)
}

/// Machin's formula in integers: pi = 16 atan(1/5) - 4 atan(1/239).
fn two_pi_in_units() -> i128 {
    let arctan = |x: i128| {
        let (mut power, mut sum, mut k) = ((1_i128 << 120) / x, 0_i128, 1_i128);
        while power != 0 {
            sum += if k % 4 == 1 { power / k } else { -(power / k) };
            power /= x * x;
            k += 2;
        }
        sum
    };
    // 120 bits behind the point, of which the last ten are lost to rounding; down to 93.
    (2 * (16 * (arctan(5) >> 4) - 4 * (arctan(239) >> 4))) >> (120 - 4 - 93)
}

#[test]
fn ten_years_in_one_go_are_exact() {
    let ten_years_s: i128 = 315_576_000;
    for from_deg in [0.0, 77.0, 270.0] {
        let wind = wind(20.0, from_deg);
        let drift = Drift::new(wind, 0.0);
        let turn = wind.angular_velocity();
        let exact = angle_by_integers(turn.length(), ten_years_s);
        let expected = DQuat::from_axis_angle(turn.normalize(), exact) * enu(&point(47.0, 8.0)).z_axis * MEAN_RADIUS_M;
        let error_m = (ground(&drift, ten_years_s as f64) - expected).length();
        // Rounding of omega * t: 990 rad to 1.1e-13, times 6.4e6 m; the axis to 1e-16. Together micrometres.
        assert!(error_m < 1e-4, "from {from_deg}: {error_m} m");
        // Far from trivial: the pattern has gone 157 times round the globe.
        assert!(turn.length() * ten_years_s as f64 > 900.0);
    }
}

#[test]
fn the_integers_know_pi() {
    let two_pi = two_pi_in_units() as f64 / 2.0_f64.powi(93);
    assert_eq!(two_pi, std::f64::consts::TAU);
    assert!((angle_by_integers(1.0, 7) - (7.0 - std::f64::consts::TAU)).abs() < 1e-15);
}

#[test]
fn position_and_velocity_are_continuous_through_every_change() {
    let steady = Drift::new(wind(20.0, 270.0), 0.0);
    let mut drift = steady;
    drift.aim(wind(60.0, 0.0), Span { begin_s: 1000.0, length_s: 600.0 });
    let mut later = drift;
    // An edit in the middle of the transition, from another place.
    later.aim(Wind { reference: point(-30.0, 170.0), ..wind(35.0, 120.0) }, Span { begin_s: 1250.0, length_s: 300.0 });
    let stage = |t: f64| {
        if t < 1000.0 {
            steady
        } else if t < 1250.0 {
            drift
        } else {
            later
        }
    };
    let at = |t: f64| ground(&stage(t), t);
    let step_s = 0.05;
    for moment_s in [1000.0, 1100.0, 1250.0, 1300.0, 1400.0, 1550.0, 1800.0] {
        for k in -20..20 {
            let t = moment_s + f64::from(k) * step_s;
            let before = (at(t) - at(t - step_s)) / step_s;
            let after = (at(t + step_s) - at(t)) / step_s;
            assert!(before.length() < 130.0, "no jump at {t}: {before}");
            // The wind changes by at most 130 m/s in 300 s at 1.5 times the mean rate: 0.65 m/s2 * 0.05 s, and the
            // rounding of positions (1e-9 m / 0.05 s).
            assert!((after - before).length() < 0.05, "no kink at {t}: {}", (after - before).length());
        }
    }
    // The stated derivative is the derivative.
    for t in [1000.0, 1200.0, 1300.0, 1500.0, 1700.0] {
        let slope = at(t + 0.5) - at(t - 0.5);
        let stated = stage(t).turn_at(t).cross(at(t));
        // Central difference over 1 s: the third derivative is below 0.01 m/s3, a 24th of it.
        assert!((slope - stated).length() < 2e-3, "{t}: {slope} {stated}");
    }
}

#[test]
fn at_rest_the_wind_is_said_as_given_and_in_between_it_eases() {
    let mut drift = Drift::new(wind(10.0, 350.0), 0.0);
    drift.aim(wind(10.0, 20.0), Span { begin_s: 10.0, length_s: 10.0 });
    assert_eq!(drift.wind_at(20.0), (10.0, 20.0));
    let (speed, from) = drift.wind_at(15.0);
    // Half way between two winds 30 degrees apart: 5 degrees, cos 15 of the speed.
    assert!((from - 5.0).abs() < 1e-9 && (speed - 10.0 * 15.0_f64.to_radians().cos()).abs() < 1e-9, "{speed} {from}");
    let before = drift;
    drift.aim(wind(10.0, 20.0), Span { begin_s: 15.0, length_s: 100.0 });
    assert_eq!(drift, before, "the same wind again changes nothing");
}
