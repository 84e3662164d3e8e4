//! Packets in, a world out: each test says something as a host would and looks at the snapshot.

use super::super::packets::*;
use super::super::{ByteOrder, Version};
use super::*;
use crate::clouds::CloudKind;
use crate::geo::Attitude;
use crate::geo::wgs84::to_ecef;
use crate::world::World;
use crate::world::command::{Command, FlashKind, Polarity, Strokes};
use crate::world::regions::signed_distance_m;
use crate::world::snapshot::Snapshot;

#[path = "tests/weather.rs"]
mod weather_tests;

const CONVENTION: Convention = Convention { sea_level_m: 0.0, seed: 1 };

/// A host and the world that it speaks to.
struct Host {
    scene: Scene,
    world: World,
    moment: Moment,
    version: Version,
    refused: Vec<Refused>,
    strikes: Vec<(u16, StrikeRequest)>,
    questions: usize,
}

impl Host {
    fn new() -> Self {
        Self::with(CONVENTION, Version::V3)
    }

    fn with(convention: Convention, version: Version) -> Self {
        let moment = Moment { host_frame: 1, timestamp: None, extrapolate: false, now_s: 0.0 };
        let (scene, world) = (Scene::new(convention), World::new());
        Self { scene, world, moment, version, refused: Vec::new(), strikes: Vec::new(), questions: 0 }
    }

    /// Says these packets in one message. Returns how many commands the world took.
    fn says(&mut self, packets: impl IntoIterator<Item = Packet>) -> usize {
        let packets = packets.into_iter().collect();
        let message = Message { version: self.version, byte_order: ByteOrder::Little, packets, skipped: Vec::new() };
        let mut commands = 0;
        for consequence in self.scene.take(&message, &self.moment) {
            match consequence {
                Consequence::Command(command) => {
                    commands += 1;
                    self.refused.extend(self.world.apply(command).err());
                }
                Consequence::Strike { strike_id, request } => {
                    self.refused.extend(self.world.apply(Command::Strike(request.clone())).err());
                    self.strikes.push((strike_id, request));
                }
                Consequence::Question(_) => self.questions += 1,
                Consequence::Refused(refused) => self.refused.push(refused),
            }
        }
        commands
    }

    fn sees(&self) -> Snapshot {
        assert_eq!(self.refused, []);
        self.world.peek(0.02)
    }
}

fn ownship(latitude: f64, longitude: f64, altitude: f64) -> EntityControl {
    EntityControl { entity_state: 1, lat_xoff: latitude, lon_yoff: longitude, alt_zoff: altitude, ..Default::default() }
}

fn cloud(layer_id: u8, cloud_type: u8, base: f32, thickness: f32) -> WeatherControl {
    WeatherControl {
        layer_id,
        cloud_type,
        weather_enable: true,
        coverage: 50.0,
        base_elevation: base,
        thickness,
        ..Default::default()
    }
}

fn degrees(attitude: &Attitude) -> [f64; 3] {
    [attitude.yaw_rad, attitude.pitch_rad, attitude.roll_rad].map(f64::to_degrees)
}

fn assert_close(given: impl IntoIterator<Item = f64>, expected: impl IntoIterator<Item = f64>, tolerance: f64) {
    let (given, expected): (Vec<f64>, Vec<f64>) = (given.into_iter().collect(), expected.into_iter().collect());
    assert_eq!(given.len(), expected.len());
    for (a, b) in given.iter().zip(&expected) {
        assert!((a - b).abs() <= tolerance, "{given:?}, expected {expected:?}");
    }
}

#[test]
fn the_ownship_is_entity_0_in_both_versions_above_mean_sea_level() {
    let convention = Convention { sea_level_m: 48.0, ..CONVENTION };
    let mut old = Host::with(convention, Version::V3);
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
fn strikes_by_component_by_packet_and_by_weather() {
    let mut host = Host::new();
    host.moment.now_s = 0.0;
    let words = |value: f64| [(value.to_bits() >> 32) as u32, value.to_bits() as u32];
    let ([data_1, data_2], [data_3, data_4]) = (words(47.269212), words(11.404102));
    let component = ComponentControl {
        component_id: STRIKE_COMPONENT,
        instance_id: 7,
        component_class: 13,
        component_state: 1,
        data_1,
        data_2,
        data_3,
        data_4,
        data_5: 1234.5_f32.to_bits(),
        data_6: (-31.25_f32).to_bits(),
    };
    let packet = Strike {
        strike_id: 8,
        flags: 0,
        return_strokes: 3,
        latitude: 47.0,
        longitude: 191.0,
        altitude: 500.0,
        peak_current_ka: 100.0,
        channel_top_altitude: 8_500.0,
    };
    let timed = TimedStrike { strike_id: 9, flags: 1, delay: 2.5, latitude: 1.0, ..Default::default() };
    host.says([
        ownship(47.0, 8.0, 500.0).into(),
        cloud(1, 6, 1_000.0, 8_000.0).into(),
        component.clone().into(),
        packet.into(),
        timed.into(),
        ShortComponentControl {
            component_id: STRIKE_COMPONENT,
            instance_id: 10,
            component_class: 13,
            component_state: 1,
            data_1: 1,
            data_2: 45.0_f32.to_bits(),
        }
        .into(),
        WeatherControl { layer_id: weather::LIGHTNING_LAYER, weather_enable: true, severity: 2, ..Default::default() }
            .into(),
        // Not ours: another component, and one that is off.
        ComponentControl { component_id: 5, ..component.clone() }.into(),
        ComponentControl { component_state: 0, ..component.clone() }.into(),
    ]);
    assert_eq!(host.refused, []);
    let [a, b, c, d, e] = host.strikes.as_slice() else { panic!("five strikes: {:?}", host.strikes) };
    assert_eq!([a.0, b.0, c.0, d.0, e.0], [7, 8, 9, 10, 0]);
    assert_eq!((a.1.latitude_deg, a.1.longitude_deg, a.1.altitude_m), (47.269212, 11.404102, Some(1234.5)));
    assert_eq!(
        (a.1.polarity, a.1.peak_current_ka, a.1.kind),
        (Polarity::Negative, Some(31.25), FlashKind::CloudToGround)
    );
    assert_eq!((b.1.longitude_deg, b.1.altitude_m, b.1.polarity), (-169.0, Some(4_500.0), Polarity::Positive));
    assert!(
        matches!(&b.1.strokes, Strokes::Given(strokes) if strokes.len() == 3 && strokes[0].peak_current_ka == 100.0)
    );
    assert_eq!((c.1.at_s, c.1.altitude_m, c.1.peak_current_ka), (Some(2.5), None, None));
    assert_eq!((d.1.polarity, d.1.peak_current_ka), (Polarity::Positive, Some(45.0)));
    assert!((d.1.latitude_deg - 47.0).abs() < 0.3 && e.1.altitude_m == Some(5_000.0));
    // Words that are no numbers, and a place where there is nothing.
    host.says([
        ComponentControl { data_1: u32::MAX, ..component.clone() }.into(),
        ComponentControl { data_6: f32::NAN.to_bits(), ..component }.into(),
        WeatherControl { layer_id: 10, weather_enable: true, scope: 1, entity_region_id: 3, ..Default::default() }
            .into(),
    ]);
    assert_eq!((host.refused.len(), host.strikes.len()), (3, 5), "{:?}", host.refused);
}

#[test]
fn events_are_muted_and_wanted_by_component() {
    let mut host = Host::new();
    let event = |component_state| -> Packet {
        let instance_id = EVENT_STRIKE_SHOWN;
        ShortComponentControl { instance_id, component_class: 12, component_state, ..Default::default() }.into()
    };
    assert!(host.scene.wants(EVENT_STRIKE_SHOWN));
    host.says([event(0)]);
    assert!(!host.scene.wants(EVENT_STRIKE_SHOWN) && host.scene.wants(EVENT_STRIKE_MISSED));
    host.says([event(1)]);
    assert!(host.scene.wants(EVENT_STRIKE_SHOWN));
}

#[test]
fn numbers_that_are_none_never_reach_the_world() {
    for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut host = Host::new();
        let before = host.sees();
        let single = wrong as f32;
        let packets: Vec<Packet> = vec![
            ownship(wrong, 8.0, 500.0).into(),
            EntityControl { roll: single, ..ownship(47.0, 8.0, 500.0) }.into(),
            ViewControl { yaw_enable: true, yaw: single, ..Default::default() }.into(),
            ViewDefinition { top_enable: true, top: single, ..Default::default() }.into(),
            CelestialSphereControl { star_field_intensity: single, ..Default::default() }.into(),
            AtmosphereControl { global_visibility_range: single, ..Default::default() }.into(),
            WeatherControl { aerosol_concentration: single, ..cloud(1, 7, 1_000.0, 500.0) }.into(),
            EnvironmentalRegionControl { region_state: 1, size_x: single, ..Default::default() }.into(),
            HatHotRequest { alt_zoff: wrong, ..Default::default() }.into(),
            Strike { altitude: wrong, ..Default::default() }.into(),
            TimedStrike { delay: single, ..Default::default() }.into(),
        ];
        let count = packets.len();
        host.says(packets);
        assert_eq!((host.refused.len(), host.questions), (count, 0), "{:?}", host.refused);
        assert!(host.refused.iter().all(|refused| refused.limit == "a finite number"));
        host.refused.clear();
        assert_eq!(host.sees(), before, "{wrong}");
    }
    // Finite and out of range: the world's own limits hold, and the field is named.
    let mut host = Host::new();
    host.says([EntityControl { pitch: 91.0, ..ownship(47.0, 8.0, 500.0) }.into()]);
    host.says([ownship(47.0, 8.0, 1e9).into()]);
    let fields: Vec<&str> = host.refused.iter().map(|refused| refused.field.as_str()).collect();
    assert_eq!(fields, ["pitch_deg", "altitude_m"]);
}

#[test]
fn what_would_fill_memory_is_refused() {
    let mut host = Host::new();
    let entities = (0..2_000).map(|entity_id| EntityControl { entity_id, ..ownship(47.0, 8.0, 500.0) }.into());
    host.says(entities);
    let regions = (0..300)
        .map(|region_id| EnvironmentalRegionControl { region_id, region_state: 1, ..Default::default() }.into());
    host.says(regions);
    let views = (0..20).map(|view_id| ViewControl { view_id, ..Default::default() }.into());
    host.says(views);
    let layers =
        (0..2_000).map(|id| WeatherControl { scope: 1, entity_region_id: id, ..cloud(1, 7, 1_000.0, 500.0) }.into());
    host.says(layers);
    assert_eq!(
        host.refused.len(),
        (2_000 - 1_024) + (300 - 256) + (20 - 16) + (2_000 - 1_024),
        "{:?}",
        host.refused.first()
    );
}
