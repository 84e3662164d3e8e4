//! What the server's messages pin: every field of a snapshot that a person may ask for changes the state message, in the
//! units that its names say; each event has its message.

use super::*;
use crate::geo::{Attitude, Geodetic};
use crate::passes::relight::Lighting;
use crate::wire::control::{decode_outbound, encode};
use crate::world::World;
use crate::world::command::{Command, Exposure, FlashKind, LayerSpec, Polarity, RegionShape, WeatherEdit};
use crate::world::event::Event;
use crate::world::snapshot::{DeckForm, FlashState, Snapshot};
use glam::DVec3;
use std::sync::Arc;

fn example() -> Snapshot {
    let layer = LayerSpec {
        kind: crate::clouds::CloudKind::Cumulus,
        base_m: 1000.0,
        thickness_m: 500.0,
        coverage: 0.5,
        density: 1.0,
        wind_speed_mps: 5.0,
        wind_from_deg: 200.0,
    };
    let shape = RegionShape {
        name: "cell".into(),
        latitude_deg: 47.0,
        longitude_deg: 8.0,
        size_east_m: 10_000.0,
        size_north_m: 20_000.0,
        corner_radius_m: 1000.0,
        rotation_deg: 10.0,
        transition_m: 500.0,
    };
    let mut world = World::new();
    let edit = |region| WeatherEdit { region, layers: Some(vec![layer]), ..WeatherEdit::default() };
    world.apply(Command::Weather(edit(None))).expect("good weather");
    world.apply(Command::Weather(edit(Some(shape)))).expect("a good region");
    let storm = crate::world::command::StormRequest {
        name: "s".into(),
        latitude_deg: 45.0,
        longitude_deg: 6.0,
        size_east_m: 9000.0,
        size_north_m: 9000.0,
        corner_radius_m: 0.0,
        rotation_deg: 0.0,
        altitude_m: None,
        flashes_per_minute: 0.0,
        inside_share: 0.5,
        positive_share: 0.1,
        current_factor: 1.0,
        seed: 1,
    };
    world.apply(Command::Storm(storm)).expect("a good storm");
    let mut snapshot = world.snapshot(0.02);
    snapshot.flashes.push(FlashState {
        id: 4,
        position: Geodetic { latitude_rad: 0.8, longitude_rad: 0.1, altitude_m: 3000.0 },
        kind: FlashKind::IntraCloud,
        polarity: Polarity::Negative,
        peak_current_ka: 30.0,
        begin_s: 1.0,
        end_s: 2.0,
        intensity_cd: 1e9,
        seed: 1,
        ground_points_m: vec![[0.0; 2]],
        lights: Vec::new(),
        channel: None,
    });
    snapshot
}

fn message(snapshot: &Snapshot) -> StateMessage {
    StateMessage::new(Some(1), snapshot, Player::default())
}

/// What is changed, and how.
type Change = (&'static str, fn(&mut Snapshot));

#[test]
fn every_part_of_a_snapshot_is_in_the_state_message() {
    let changes: &[Change] = &[
        ("number", |s| s.number += 1),
        ("host_frame", |s| s.host_frame += 1),
        ("simulation_time_s", |s| s.simulation_time_s += 1.0),
        ("shutter_s", |s| s.shutter_s[1] += 1.0),
        ("utc_s", |s| s.utc_s += 0.001),
        ("ownship position", |s| s.ownship.position.latitude_rad += 0.1),
        ("ownship position", |s| s.ownship.position.longitude_rad += 0.1),
        ("ownship position", |s| s.ownship.position.altitude_m += 1.0),
        ("ownship attitude", |s| s.ownship.attitude.yaw_rad += 0.1),
        ("ownship attitude", |s| s.ownship.attitude.pitch_rad += 0.1),
        ("ownship attitude", |s| s.ownship.attitude.roll_rad += 0.1),
        ("visibility", |s| s.weather.visibility_m += 1.0),
        ("layer kind", |s| s.weather.layers[0].kind = crate::clouds::CloudKind::Cirrus),
        ("layer base", |s| s.weather.layers[0].base_m += 1.0),
        ("layer thickness", |s| s.weather.layers[0].thickness_m += 1.0),
        ("layer coverage", |s| s.weather.layers[0].coverage += 0.1),
        ("layer density", |s| s.weather.layers[0].density += 0.1),
        ("layer wind", |s| s.weather.layers[0].wind_speed_mps += 1.0),
        ("layer wind", |s| s.weather.layers[0].wind_from_deg += 1.0),
        ("layers", |s| s.weather.layers.clear()),
        ("region name", |s| s.regions[0].shape.name.push('x')),
        ("region place", |s| s.regions[0].shape.latitude_deg += 1.0),
        ("region size", |s| s.regions[0].shape.size_north_m += 1.0),
        ("region weather", |s| s.regions[0].weather.visibility_m += 1.0),
        ("region presence", |s| s.regions[0].presence -= 0.5),
        ("view name", |s| s.views[0].name.push('x')),
        ("view size", |s| s.views[0].size_px[1] += 1),
        ("view field of view", |s| s.views[0].field_of_view_deg += 1.0),
        ("view offset", |s| s.views[0].offset_m[2] += 1.0),
        ("view attitude", |s| s.views[0].attitude = Attitude { yaw_rad: 0.2, ..s.views[0].attitude }),
        ("view landing light", |s| s.views[0].lights.landing = true),
        ("view strobe", |s| s.views[0].lights.strobe = true),
        ("view exposure", |s| s.views[0].exposure = Exposure::Ev100(11.0)),
        ("storm", |s| s.storms[0].seed += 1),
        ("storms", |s| s.storms.clear()),
        ("flash id", |s| s.flashes[0].id += 1),
        ("flash place", |s| s.flashes[0].position.altitude_m += 1.0),
        ("flash kind", |s| s.flashes[0].kind = FlashKind::CloudToCloud),
        ("flash polarity", |s| s.flashes[0].polarity = Polarity::Positive),
        ("flash begin", |s| s.flashes[0].begin_s -= 0.5),
        ("flash end", |s| s.flashes[0].end_s += 0.5),
        ("flash intensity", |s| s.flashes[0].intensity_cd *= 2.0),
        ("flash ground points", |s| s.flashes[0].ground_points_m.push([900.0, -300.0])),
        ("sun", |s| s.sky.sun_direction_ecef = DVec3::Z),
        ("moon", |s| s.sky.moon_direction_ecef = DVec3::Z),
        ("moon", |s| s.sky.moon_lit_fraction *= 0.5),
        ("slices", |s| s.quality.slices += 1),
        ("deck scale", |s| s.quality.deck_scale += 1),
        ("deck form", |s| s.quality.deck_form = DeckForm::Instanced),
        ("light encoding", |s| s.quality.light_encoding = crate::passes::light::encoding::Encoding::Paper),
        ("relighting", |s| s.quality.relight = Lighting::Single),
        ("ring ratio", |s| s.quality.ring_ratio += 0.1),
    ];
    let plain = message(&example());
    for (what, change) in changes {
        let mut snapshot = example();
        change(&mut snapshot);
        assert_ne!(message(&snapshot), plain, "{what}");
    }
    let player = Player {
        scenario: Some("a".into()),
        description: Some("b".into()),
        playing: true,
        speed: 2.0,
        duration_s: Some(3.0),
    };
    assert_ne!(StateMessage::new(Some(1), &example(), player), plain);
    assert_ne!(StateMessage::new(None, &example(), Player::default()), plain);
}

#[test]
fn the_state_is_in_the_units_of_its_names() {
    let mut snapshot = example();
    snapshot.utc_s = 946_728_000.0;
    snapshot.ownship.position.latitude_rad = std::f64::consts::FRAC_PI_4;
    snapshot.ownship.attitude.yaw_rad = std::f64::consts::FRAC_PI_2;
    let state = message(&snapshot);
    assert_eq!(state.utc, "2000-01-01T12:00:00Z");
    assert_eq!((state.ownship.latitude_deg, state.ownship.yaw_deg), (45.0, 90.0));
    assert_eq!(state.weather.layers[0].base_m, 1000.0);
}

#[test]
fn each_event_of_the_world_has_its_message() {
    let shown = Event::StrikeShown { id: 3, view: "main".into(), frame: 9, simulation_time_s: 0.5, current_ka: -30.0 };
    let expected = EventMessage::StrikeShown { flash: 3, view: "main".into(), frame: 9, simulation_time_s: 0.5 };
    assert_eq!(EventMessage::from_world(&shown), Some(expected));
    assert_eq!(EventMessage::from_world(&Event::StrikeMissed { id: 4 }), Some(EventMessage::StrikeMissed { flash: 4 }));
    assert_eq!(EventMessage::from_world(&Event::State(Arc::new(example()))), None);
}

#[test]
fn a_state_comes_back_from_its_own_text() {
    let outbound = Outbound::State(Box::new(message(&example())));
    assert_eq!(decode_outbound(&encode(&outbound)), Ok(outbound));
    assert!(decode_outbound("{}").is_err() && decode_outbound(&" ".repeat(5_000_000)).is_err());
}
