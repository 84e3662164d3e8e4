//! Entities by CIGI packets: place, attachment and motion.

use super::*;

#[test]
fn the_ownship_is_entity_0_in_both_versions_above_mean_sea_level() {
    let convention = Convention { sea_level_m: 48.0, ..CONVENTION };
    let mut old = Host::with(convention.clone(), Version::V3);
    old.says([EntityControl { yaw: 271.75, pitch: 3.25, roll: -12.5, ..ownship(47.25, 11.5, 2_000.0) }.into()]);
    let mut new = Host::with(convention, Version::V4);
    let position = EntityPosition {
        yaw: 271.75,
        pitch: 3.25,
        roll: -12.5,
        lat_xoff: 47.25,
        lon_yoff: 11.5,
        alt_zoff: 2_000.0,
        ..Default::default()
    };
    new.says([EntityState { entity_state: 1, ..Default::default() }.into(), position.into()]);
    let (old, new) = (old.sees(), new.sees());
    assert_eq!(old.ownship, new.ownship);
    assert_close([old.ownship.position.altitude_m], [2_048.0], 1e-9);
    // The angles are 32-bit floats with exact values, turned into radians and back.
    assert_close(degrees(&old.ownship.attitude), [-88.25, 3.25, -12.5], 1e-12);
}

#[test]
fn an_attached_entity_goes_with_its_parent_and_carries_a_view() {
    let mut host = Host::new();
    let child = EntityControl {
        entity_id: 7,
        parent_id: 0,
        attach_state: true,
        entity_state: 1,
        lat_xoff: 100.0,
        alt_zoff: -50.0,
        yaw: 90.0,
        ..Default::default()
    };
    let attach = ViewControl { view_id: 3, entity_id: 7, ..Default::default() };
    // Flying east: 100 m ahead is 100 m east, 50 m up, and the child looks south.
    host.says([EntityControl { yaw: 90.0, ..ownship(0.0, 10.0, 1_000.0) }.into(), child.into(), attach.into()]);
    let seen = host.sees();
    let view = seen.views.iter().find(|view| view.name == "view-3").expect("the view");
    let carrier = view.carrier.expect("an entity that is there");
    let east = to_ecef(&carrier.position) - to_ecef(&seen.ownship.position);
    // On the equator at 10 degrees east: up and east as unit vectors.
    let (sin, cos) = 10.0_f64.to_radians().sin_cos();
    assert_close([-sin * east.x + cos * east.y, cos * east.x + sin * east.y, east.z], [100.0, 50.0, 0.0], 1e-6);
    // The horizon there is turned by 100 m of the Earth's circumference: 0.0009 degrees.
    let [yaw, pitch, roll] = degrees(&carrier.attitude);
    assert_close([yaw.rem_euclid(360.0), pitch, roll], [180.0, 0.0, 0.0], 1e-3);
    // The parent moves: the child with it. Then it is destroyed: its view is the ownship's again.
    host.says([ownship(0.0, 10.1, 1_000.0).into()]);
    let moved = host.sees().views.iter().find(|view| view.name == "view-3").and_then(|view| view.carrier);
    assert!((moved.expect("still there").position.longitude_rad - carrier.position.longitude_rad) > 0.001);
    host.says([EntityControl { entity_id: 7, entity_state: 2, ..Default::default() }.into()]);
    assert!(host.sees().views.iter().all(|view| view.carrier.is_none()));
}

#[test]
fn a_circle_of_parents_ends() {
    let mut host = Host::new();
    let attached = |entity_id, parent_id| -> Packet {
        EntityControl { entity_id, parent_id, attach_state: true, entity_state: 1, ..Default::default() }.into()
    };
    host.says([attached(1, 2), attached(2, 1), attached(3, 3), attached(0, 3)]);
    assert_eq!(host.sees().ownship, World::new().peek(0.0).ownship, "nobody knows where these are");
}

#[test]
fn motion_follows_from_positions_and_time_stamps_where_both_flags_are_set() {
    for (global, own, moves) in [(true, true, true), (true, false, false), (false, true, false)] {
        let mut host = Host::new();
        // 100 m/s north: in 16.67 ms so much latitude; the counter wraps around between the two.
        let step_deg = 100.0 * 0.016_67 / 111_132.95;
        for frame in 0..2 {
            host.moment.timestamp = Some((u32::MAX - 100).wrapping_add(frame * 1_667));
            host.moment.extrapolate = global;
            let latitude = 45.0 + step_deg * f64::from(frame);
            let packet =
                EntityControl { linear_extrapolation_interpolation_enable: own, ..ownship(latitude, 8.0, 500.0) };
            host.says([packet.into()]);
        }
        let before = host.sees().ownship.position;
        host.world.advance_to(1.0);
        let after = host.sees().ownship.position;
        let north_m = (after.latitude_rad - before.latitude_rad).to_degrees() * 111_132.95;
        // The length of a degree of latitude at 45 degrees north is rounded to 1e-6 of itself at most 0.1 % away (M at 500 m).
        assert_close([north_m], [if moves { 100.0 } else { 0.0 }], 0.1);
    }
}

#[test]
fn a_clamped_entity_stands_on_the_ground_and_leans_with_it_if_asked_to() {
    let terrain = Terrain::procedural();
    let mut host = Host::with(Convention { terrain: terrain.clone(), sea_level_m: 48.0, ..CONVENTION }, Version::V3);
    // On a mountainside in the Alps.
    let place = Geodetic { latitude_rad: 46.0f64.to_radians(), longitude_rad: 7.6f64.to_radians(), altitude_m: 0.0 };
    let (height_m, normal) = (terrain.height_m(&place), terrain.normal(&place));
    assert!(height_m > 500.0 && normal.z < 0.999, "{height_m} {normal}");
    let mut stands = |ground_ocean_clamp: u8| {
        host.says([EntityControl { ground_ocean_clamp, yaw: 30.0, ..ownship(46.0, 7.6, 3.0) }.into()]);
        host.sees().ownship
    };
    let upright = stands(1);
    assert!((upright.position.altitude_m - height_m - 3.0).abs() < 1e-6, "{upright:?} on {height_m}");
    assert_close(degrees(&upright.attitude), [30.0, 0.0, 0.0], 1e-12);
    let leaning = stands(2);
    assert_eq!(leaning.position, upright.position);
    // Its own up is the ground's normal. The normal is that of a place which lies within rounding of this one.
    let up = -(ENU_NED * ned_from_body(&leaning.attitude)).z_axis;
    assert!((up - normal).length() < 1e-6, "{up} {normal}");
}
