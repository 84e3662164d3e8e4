//! Extrapolation: true to the velocity everywhere on Earth, and no further than it says.

use super::*;

fn message(latitude_deg: f64, longitude_deg: f64, yaw_deg: f64, velocity: [f64; 3]) -> Ownship {
    Ownship {
        latitude_deg,
        longitude_deg,
        altitude_m: 3_000.0,
        yaw_deg,
        pitch_deg: 3.0,
        roll_deg: -10.0,
        velocity_ned_mps: Some(velocity),
        host_frame: 7,
    }
}

#[test]
fn it_moves_by_velocity_times_time() {
    for (latitude_deg, longitude_deg) in [(0.0, 0.0), (47.0, 8.0), (-33.0, 179.999_9), (89.9, 12.0), (-89.999, -70.0)] {
        let known = LastKnown::new(&message(latitude_deg, longitude_deg, 30.0, [200.0, 100.0, -10.0]), 50.0).unwrap();
        let (start, end) = (known.at(50.0), known.at(51.5));
        let moved = to_ecef(&end.position) - to_ecef(&start.position);
        let local = enu(&start.position).transpose() * moved;
        // 335 m on a globe of 6.4e6 m: the ground falls away by 9 mm, and heights scale the way by 5e-4 of 9 mm.
        assert!((local - DVec3::new(150.0, 300.0, 15.0)).length() < 0.012, "{latitude_deg} {longitude_deg}: {local}");
        assert!((end.position.altitude_m - 3_015.0).abs() < 1e-9);
    }
}

#[test]
fn it_holds_after_the_limit_and_never_looks_back() {
    let known = LastKnown::new(&message(47.0, 8.0, 0.0, [200.0, 0.0, 0.0]), 50.0).unwrap();
    assert_ne!(known.at(51.9), known.at(52.0));
    assert_eq!(known.at(50.0 + limits::EXTRAPOLATION_LIMIT_S), known.at(1000.0));
    assert_eq!(known.at(40.0), known.at(50.0));
    let still = LastKnown::new(&Ownship { velocity_ned_mps: None, ..message(47.0, 8.0, 0.0, [0.0; 3]) }, 50.0).unwrap();
    assert_eq!(still.at(50.0), still.at(60.0));
    assert_eq!(still.at(60.0).position.latitude_rad, 47.0_f64.to_radians());
}

#[test]
fn across_the_pole_it_goes_on_straight_and_comes_out_southbound() {
    // 100 m short of the pole on the meridian of 20 E, flying north at 200 m/s, nose up 3 degrees, left wing down 10.
    let short_deg = (100.0 / 6_399_593.6_f64).to_degrees();
    let known = LastKnown::new(&message(90.0 - short_deg, 20.0, 0.0, [200.0, 0.0, 0.0]), 0.0).unwrap();
    let (before, after) = (known.at(0.0), known.at(1.0));
    assert!(
        (after.position.longitude_rad.to_degrees() + 160.0).abs() < 1e-6,
        "{}",
        after.position.longitude_rad.to_degrees()
    );
    assert!((after.attitude.yaw_rad.abs() - std::f64::consts::PI).abs() < 1e-9, "now flying south");
    for (a, b) in
        [(before.attitude.pitch_rad, after.attitude.pitch_rad), (before.attitude.roll_rad, after.attitude.roll_rad)]
    {
        assert!((a - b).abs() < 1e-9);
    }
    // In space it hardly turns: by the angle that it flew, 200 m of 6.4e6.
    let body = |state: &OwnshipState| ecef_from_body(&state.position, &state.attitude);
    let turned = (body(&before).transpose() * body(&after)).x_axis.angle_between(DVec3::X);
    assert!(turned < 4e-5, "{turned}");
}

#[test]
fn it_moves_evenly_through_pole_and_meridian() {
    for (latitude_deg, longitude_deg, velocity) in
        [(89.999_5, 20.0, [250.0, 3.0, 0.0]), (10.0, 179.999_5, [0.0, 250.0, 0.0]), (90.0, 0.0, [250.0, 0.0, 0.0])]
    {
        let known = LastKnown::new(&message(latitude_deg, longitude_deg, 10.0, velocity), 0.0).unwrap();
        let speed = DVec3::from_array(velocity).length();
        let mut before = known.at(0.0);
        for k in 1..=200 {
            let now = known.at(f64::from(k) * 0.01);
            let step_m = (to_ecef(&now.position) - to_ecef(&before.position)).length();
            // At 3000 m the radius is 4.7e-4 larger than where the level motion is taken: none of it, to 1e-6 m.
            assert!((step_m - speed * 0.01).abs() < 1e-5, "step {k}: {step_m}");
            before = now;
        }
    }
}

#[test]
fn nonsense_is_refused() {
    let good = message(47.0, 8.0, 0.0, [0.0; 3]);
    for (bad, field) in [
        (Ownship { latitude_deg: 91.0, ..good }, "latitude_deg"),
        (Ownship { longitude_deg: 180.1, ..good }, "longitude_deg"),
        (Ownship { altitude_m: f64::NAN, ..good }, "altitude_m"),
        (Ownship { yaw_deg: f64::INFINITY, ..good }, "yaw_deg"),
        (Ownship { pitch_deg: 90.1, ..good }, "pitch_deg"),
        (Ownship { roll_deg: -361.0, ..good }, "roll_deg"),
        (Ownship { velocity_ned_mps: Some([0.0, f64::NAN, 0.0]), ..good }, "velocity_ned_mps[1]"),
    ] {
        assert_eq!(LastKnown::new(&bad, 0.0).unwrap_err().field, field);
    }
}
