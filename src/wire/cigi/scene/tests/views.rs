//! Views by CIGI packets, alone and in groups; and the sky.

use super::*;

#[test]
fn views_turn_shift_and_take_any_frustum() {
    let mut host = Host::new();
    let control = ViewControl {
        x_offset_enable: true,
        x_offset: 2.0,
        z_offset_enable: true,
        z_offset: -1.5,
        yaw_enable: true,
        yaw: 350.0,
        // Does not count, and may therefore be anything.
        pitch: f32::NAN,
        ..Default::default()
    };
    let define = ViewDefinition {
        left_enable: true,
        left: -10.0,
        right_enable: true,
        right: 40.0,
        near: f32::NAN,
        mirror_mode: 1,
        ..Default::default()
    };
    host.says([control.into(), define.into()]);
    let seen = host.sees();
    let view = &seen.views[0];
    assert_eq!((view.name.as_str(), view.offset_m, view.mirror), ("main", [2.0, 0.0, -1.5], [true, false]));
    assert_close(degrees(&view.attitude), [-10.0, 0.0, 0.0], 1e-12);
    let frustum = view.frustum.expect("sides");
    // The sides that were not given are those of 60 degrees at 16 by 9: atan(tan 30 * 9 / 16) = 17.998 degrees.
    assert_close(
        [frustum.left_deg, frustum.right_deg, frustum.top_deg, frustum.bottom_deg],
        [-10.0, 40.0, 17.998, -17.998],
        1e-3,
    );
    // A side that is not enabled goes back to the default; an axis that is not keeps its value.
    host.says([
        ViewDefinition::default().into(),
        ViewControl { y_offset_enable: true, y_offset: 5.0, ..Default::default() }.into(),
    ]);
    let seen = host.sees();
    assert_eq!((seen.views[0].offset_m, seen.views[0].mirror), ([2.0, 5.0, -1.5], [false; 2]));
    assert_close([seen.views[0].frustum.expect("sides").right_deg], [30.0], 0.0);
}

#[test]
fn a_group_moves_all_its_views_and_those_that_join() {
    let mut host = Host::new();
    let define = |view_id, group_id| -> Packet { ViewDefinition { view_id, group_id, ..Default::default() }.into() };
    let turn = |yaw| -> Packet { ViewControl { group_id: 4, yaw_enable: true, yaw, ..Default::default() }.into() };
    host.says([define(1, 4), define(2, 4), define(3, 5), turn(30.0), define(6, 4)]);
    let yaw = |host: &Host, name: &str| {
        let seen = host.sees();
        let view = seen.views.iter().find(|view| view.name == name).expect("a view");
        view.attitude.yaw_rad.to_degrees().round()
    };
    assert_eq!(
        ["view-1", "view-2", "view-3", "view-6", "main"].map(|name| yaw(&host, name)),
        [30.0, 30.0, 0.0, 30.0, 0.0]
    );
}

#[test]
fn the_celestial_sphere_sets_time_and_lights_and_repeats_are_no_news() {
    let mut host = Host::new();
    let evening = CelestialSphereControl {
        hour: 18,
        minute: 45,
        date: 7_142_025,
        date_time_valid: true,
        continuous_time_of_day_enable: true,
        sun_enable: true,
        star_field_enable: true,
        star_field_intensity: 80.0,
        ..Default::default()
    };
    assert_eq!(host.says([evening.clone().into()]), 2);
    let seen = host.sees();
    // 2025-07-14T18:45:00Z, by `date -u -d ... +%s`.
    assert_eq!(seen.utc_s, 1_752_518_700.0);
    assert_eq!((seen.sky.sun_shines, seen.sky.moon_shines), (true, false));
    assert_close([seen.sky.starlight], [0.8], 1e-7);
    host.world.advance_to(10.0);
    assert_eq!(host.says([evening.clone().into()]), 0, "nothing new");
    assert_eq!(host.sees().utc_s, 1_752_518_710.0, "and the time runs on");
    host.says([CelestialSphereControl { continuous_time_of_day_enable: false, ..evening.clone() }.into()]);
    host.world.advance_to(20.0);
    assert_eq!(host.sees().utc_s, 1_752_518_710.0, "it stands");
    for wrong in [
        CelestialSphereControl { date: 13_012_025, ..evening.clone() },
        CelestialSphereControl { date: 2_302_025, ..evening.clone() },
        CelestialSphereControl { hour: 24, ..evening.clone() },
        CelestialSphereControl { seconds: 60.0, ..evening },
    ] {
        host.says([wrong.into()]);
    }
    assert_eq!(host.refused.len(), 4);
}

#[test]
fn a_component_of_a_view_switches_the_own_ships_lights() {
    let mut host = Host::new();
    let lights = |state: u8| ComponentControl {
        component_class: 1,
        component_id: 0x4f4c,
        component_state: state,
        ..Default::default()
    };
    for (state, expected) in [(3, [true, true]), (1, [true, false]), (2, [false, true]), (0, [false, false])] {
        host.says([lights(state).into()]);
        let own = host.sees().views[0].lights;
        assert_eq!([own.landing, own.strobe], expected, "{state}");
    }
    let short =
        ShortComponentControl { component_class: 1, component_id: 0x4f4c, component_state: 1, ..Default::default() };
    host.says([short.into()]);
    assert!(host.sees().views[0].lights.landing);
    // A component of another class is something else.
    host.says([ComponentControl { component_class: 13, ..lights(0) }.into()]);
    assert!(host.sees().views[0].lights.landing);
}
