//! The world as a whole: all or nothing, time in any steps, scenarios, flashes.

use super::command::*;
use super::*;
use crate::clouds::CloudKind;
use crate::passes::relight::Lighting;
use std::sync::Arc;

mod channels;
mod every_field;
mod flashes;

pub(super) fn layer(base_m: f64) -> LayerSpec {
    LayerSpec {
        kind: CloudKind::Cumulus,
        base_m,
        thickness_m: 800.0,
        coverage: 0.5,
        density: 1.0,
        wind_speed_mps: 10.0,
        wind_from_deg: 270.0,
    }
}

pub(super) fn layers(list: Vec<LayerSpec>, transition_s: f64) -> Command {
    Command::Weather(WeatherEdit { layers: Some(list), transition_s, ..Default::default() })
}

pub(super) fn ownship() -> Ownship {
    Ownship {
        latitude_deg: 10.0,
        longitude_deg: 20.0,
        altitude_m: 3_000.0,
        yaw_deg: 40.0,
        pitch_deg: 5.0,
        roll_deg: 6.0,
        velocity_ned_mps: Some([100.0, 50.0, -3.0]),
        host_frame: 9,
    }
}

pub(super) fn region() -> RegionShape {
    RegionShape {
        name: "storm".into(),
        latitude_deg: 10.0,
        longitude_deg: 20.0,
        size_east_m: 30_000.0,
        size_north_m: 20_000.0,
        corner_radius_m: 4_000.0,
        rotation_deg: 15.0,
        transition_m: 5_000.0,
    }
}

pub(super) fn strike() -> StrikeRequest {
    StrikeRequest {
        latitude_deg: 47.1,
        longitude_deg: 8.1,
        altitude_m: Some(3_000.0),
        at_s: None,
        kind: FlashKind::CloudToGround,
        polarity: Polarity::Negative,
        peak_current_ka: None,
        strokes: Strokes::Given(vec![
            StrokeSpec { delay_s: 0.0, peak_current_ka: 25.0, ..Default::default() },
            StrokeSpec { delay_s: 0.05, peak_current_ka: 10.0, ..Default::default() },
        ]),
        leader: false,
        seed: 5,
    }
}

pub(super) fn demo() -> Timeline {
    let at = |at_s, command| TimedCommand { at_s, command };
    let shape = region();
    let thick = LayerChange { index: 0, coverage: Some(0.95), density: Some(2.0), ..Default::default() };
    Timeline {
        name: "demo".into(),
        description: String::new(),
        duration_s: 60.0,
        entries: vec![
            at(0.0, Command::Ownship(ownship())),
            at(0.0, layers(vec![layer(1000.0)], 0.0)),
            at(0.0, Command::View(ViewEdit { name: "left".into(), yaw_deg: Some(-60.0), ..Default::default() })),
            at(1.5, Command::Strike(StrikeRequest { strokes: Strokes::Sample, ..strike() })),
            at(
                2.0,
                Command::Weather(WeatherEdit {
                    region: Some(shape),
                    changes: vec![thick],
                    transition_s: 6.0,
                    ..Default::default()
                }),
            ),
            at(4.0, layers(vec![layer(1500.0), layer(4000.0)], 20.0)),
            at(5.0, Command::Time(TimeEdit { utc_s: None, rate: Some(60.0) })),
            at(9.0, layers(vec![layer(1200.0)], 5.0)),
            at(9.0, Command::Ownship(Ownship { latitude_deg: 11.0, host_frame: 10, ..ownship() })),
            at(9.9, Command::Strike(StrikeRequest { at_s: Some(9.95), ..strike() })),
            at(12.0, Command::RemoveRegion { name: "storm".into(), transition_s: 3.0 }),
            at(20.0, Command::RemoveView { name: "left".into() }),
        ],
    }
}

fn loaded(timeline: Timeline) -> World {
    let mut world = World::new();
    world.apply(Command::Scenario(ScenarioEdit::Load(Arc::new(timeline)))).unwrap();
    world
}

/// A snapshot without its number.
fn picture(world: &World) -> Snapshot {
    Snapshot { number: 0, ..world.peek(1.0 / 60.0) }
}

#[test]
fn a_new_world_is_what_it_says() {
    let snapshot = World::new().snapshot(0.0);
    assert_eq!(snapshot.ownship.position.latitude_rad, 47.0_f64.to_radians());
    assert_eq!(snapshot.ownship.position.longitude_rad, 8.0_f64.to_radians());
    assert_eq!(snapshot.ownship.position.altitude_m, 1500.0);
    assert!(snapshot.weather.layers.is_empty() && snapshot.weather.visibility_m == 40_000.0);
    assert_eq!(
        (snapshot.views.len(), snapshot.views[0].name.as_str(), snapshot.views[0].size_px),
        (1, "main", [640, 360])
    );
    assert_eq!((snapshot.number, snapshot.host_frame, snapshot.simulation_time_s), (1, 0, 0.0));
}

#[test]
fn time_may_go_in_any_steps() {
    for steps in [&[3.0, 7.0, 6.0, f64::NAN, f64::INFINITY, 10.0][..], &[0.1, 0.2, 4.0, 9.0, 9.000_001, 10.0]] {
        let mut whole = loaded(demo());
        let mut split = loaded(demo());
        whole.advance_to(10.0);
        for &t in steps {
            split.advance_to(t);
            split.finished_flashes();
        }
        assert_eq!(picture(&whole), picture(&split));
        assert_eq!(split.simulation_time_s(), 10.0);
    }
}

#[test]
fn looking_changes_nothing_of_a_scenario() {
    let (mut watched, mut alone) = (loaded(demo()), loaded(demo()));
    for k in 0..=600 {
        let t = f64::from(k) / 30.0;
        watched.advance_to(t);
        watched.snapshot(1.0 / 30.0);
    }
    alone.advance_to(20.0);
    assert_eq!(picture(&watched), picture(&alone));
}

#[test]
fn a_seek_is_a_play_through() {
    for at_s in [0.0, 1.5, 1.52, 3.7, 9.0, 9.96, 13.0, 59.0, 60.0] {
        let mut played = loaded(demo());
        played.advance_to(at_s);
        let mut sought = loaded(demo());
        // From ahead and from behind, with something live in between that the seek undoes.
        for before_s in [40.0, 0.5] {
            sought.advance_to(before_s);
            sought.apply(Command::Ownship(Ownship { latitude_deg: -50.0, ..ownship() })).unwrap();
            sought.apply(Command::Strike(strike())).unwrap();
            sought.apply(Command::Scenario(ScenarioEdit::Seek { at_s })).unwrap();
            assert_eq!(sought.simulation_time_s(), at_s);
            assert_eq!(picture(&played), picture(&sought), "at {at_s} from {before_s}");
        }
    }
}

#[test]
fn the_scenario_shows_what_it_says_when_it_says_it() {
    let mut world = loaded(demo());
    let lit = |world: &World| world.peek(1.0 / 60.0).flashes.len();
    world.advance_to(1.49);
    assert_eq!(
        (lit(&world), world.peek(0.0).regions.len()),
        (1, 0),
        "a frame from 1.49 to 1.507 sees the flash at 1.5"
    );
    world.advance_to(1.4);
    assert_eq!(world.simulation_time_s(), 1.49, "never backwards");
    world.advance_to(2.0);
    assert_eq!((world.peek(0.0).regions.len(), world.peek(0.0).regions[0].presence), (1, 0.0));
    world.advance_to(60.5);
    assert_eq!((world.simulation_time_s(), world.playing()), (60.0, false), "the time stops at the end");
    assert_eq!(world.timeline().unwrap().name, "demo");
    assert_eq!(world.peek(0.0).views.len(), 1);
    assert!(world.take_refusals().is_empty());
}

#[test]
fn play_pause_and_speed() {
    let mut world = World::new();
    let mut scenario = |edit| world.apply(Command::Scenario(edit)).map(|_| (world.playing(), world.speed()));
    assert_eq!(scenario(ScenarioEdit::Pause), Ok((false, 1.0)));
    assert_eq!(scenario(ScenarioEdit::Speed { factor: 4.0 }), Ok((false, 4.0)));
    assert_eq!(scenario(ScenarioEdit::Play), Ok((true, 4.0)));
    assert_eq!(scenario(ScenarioEdit::Speed { factor: f64::NAN }).unwrap_err().field, "factor");
    assert_eq!(scenario(ScenarioEdit::Seek { at_s: 1.0 }).unwrap_err().field, "at_s");
    assert_eq!(scenario(ScenarioEdit::Pause), Ok((false, 4.0)));
    let load = ScenarioEdit::Load(Arc::new(demo()));
    assert_eq!(scenario(load), Ok((true, 1.0)), "a new scenario plays");
    assert_eq!(scenario(ScenarioEdit::Seek { at_s: 61.0 }).unwrap_err().limit, "0 to 60");
    assert_eq!(scenario(ScenarioEdit::Seek { at_s: f64::NAN }).unwrap_err().field, "at_s");
}

#[test]
fn validate_names_every_complaint_with_its_entry() {
    let mut timeline = demo();
    timeline.duration_s = 30.0;
    timeline.entries[1].command = layers(vec![layer(1000.0), layer(1100.0)], 0.0);
    timeline.entries[3].at_s = f64::NAN;
    timeline.entries[11].at_s = 31.0;
    timeline.entries.push(TimedCommand { at_s: 5.0, command: Command::RemoveView { name: "nobody".into() } });
    timeline.entries.push(TimedCommand { at_s: 30.0, command: Command::Scenario(ScenarioEdit::Pause) });
    let complaints = World::validate(&timeline);
    let said: Vec<(usize, &str)> = complaints.iter().map(|(index, refused)| (*index, refused.field.as_str())).collect();
    // Without the layer of entry 1 the region of entry 2 has none to change, and so is not there to be removed.
    assert_eq!(
        said,
        [
            (1, "layers[1].base_m"),
            (3, "at_s"),
            (4, "changes[0].index"),
            (10, "name"),
            (11, "at_s"),
            (12, "at_s"),
            (12, "name"),
            (13, "command"),
        ]
    );
    let mut world = World::new();
    let before = picture(&world);
    let refused = world.apply(Command::Scenario(ScenarioEdit::Load(Arc::new(timeline)))).unwrap_err();
    assert_eq!(refused.field, "entries[1].layers[1].base_m");
    assert_eq!(picture(&world), before);
    assert!(World::validate(&demo()).is_empty());
    let endless = Timeline { duration_s: f64::NAN, ..demo() };
    assert_eq!(World::validate(&endless)[0].0, 12);
}

#[test]
fn a_scenario_that_live_commands_contradict_goes_on_and_says_so() {
    let mut world = loaded(demo());
    world.apply(Command::RemoveView { name: "left".into() }).unwrap();
    world.advance_to(30.0);
    let refusals = world.take_refusals();
    assert_eq!((refusals.len(), refusals[0].0, refusals[0].1.field.as_str()), (1, 11, "name"));
    assert!(world.take_refusals().is_empty());
}

#[test]
fn views_have_defaults_limits_and_a_good_bye() {
    let mut world = World::new();
    let view = |name: &str| ViewEdit { name: name.into(), ..Default::default() };
    let a = || ViewEdit { action: ViewAction::Change, ..view("a") };
    world.apply(Command::View(view("b"))).unwrap();
    world.apply(Command::View(view("a"))).unwrap();
    let names: Vec<String> = world.peek(0.0).views.into_iter().map(|v| v.name).collect();
    assert_eq!(names, ["a", "b", "main"]);
    let before = picture(&world);
    for (bad, field) in [
        (ViewEdit { name: "".into(), ..a() }, "name"),
        (ViewEdit { size_px: Some([640, 0]), ..a() }, "size_px[1]"),
        (ViewEdit { size_px: Some([8192, 8192]), ..a() }, "size_px"),
        (ViewEdit { field_of_view_deg: Some(180.0), ..a() }, "field_of_view_deg"),
        (ViewEdit { offset_m: Some([0.0, f64::NAN, 0.0]), ..a() }, "offset_m[1]"),
        (ViewEdit { yaw_deg: Some(f64::NAN), ..a() }, "yaw_deg"),
        (ViewEdit { pitch_deg: Some(91.0), ..a() }, "pitch_deg"),
        (ViewEdit { roll_deg: Some(1e9), ..a() }, "roll_deg"),
        (ViewEdit { exposure: Some(Exposure::Ev100(f64::NAN)), ..a() }, "exposure.ev100"),
    ] {
        assert_eq!(world.apply(Command::View(bad)).unwrap_err().field, field);
    }
    assert!(world.apply(Command::RemoveView { name: "zz".into() }).is_err());
    assert_eq!(picture(&world), before);
    for k in 3..limits::MAX_VIEWS {
        world.apply(Command::View(view(&format!("v{k}")))).unwrap();
    }
    assert_eq!(world.apply(Command::View(view("more"))).unwrap_err().field, "name");
    world.apply(Command::RemoveView { name: "main".into() }).unwrap();
    world.apply(Command::View(view("more"))).unwrap();
}

#[test]
fn quality_is_brought_within_limits() {
    let mut world = World::new();
    let beyond = Quality {
        slices: 1000,
        ring_ratio: 0.0,
        deck_scale: 9,
        deck_form: DeckForm::Marched,
        light_encoding: Encoding::Harmonics,
        relight: Lighting::Single,
        basis_memory_mib: 0,
    };
    world.set_quality(beyond);
    let nearest = Quality {
        slices: limits::SLICES[1],
        ring_ratio: limits::RING_RATIO[0],
        deck_scale: 4,
        basis_memory_mib: limits::BASIS_MEMORY_MIB[0],
        ..beyond
    };
    assert_eq!(world.peek(0.0).quality, nearest);
    let other = Quality { slices: 16, ring_ratio: f64::NAN, deck_scale: 2, ..DEFAULT_QUALITY };
    world.set_quality(other);
    assert_eq!(world.peek(0.0).quality, Quality { ring_ratio: limits::RING_RATIO[0], ..other });
    world.apply(Command::Scenario(ScenarioEdit::Load(Arc::new(demo())))).unwrap();
    assert_eq!(world.peek(0.0).quality.slices, 16, "a scenario does not change what may be spent");
}

#[test]
fn a_shutter_that_is_no_interval_is_an_instant() {
    let mut world = World::new();
    for bad in [-1.0, f64::NAN, 0.0] {
        assert_eq!(world.snapshot(bad).shutter_s, [0.0, 0.0]);
    }
    assert!(world.snapshot(f64::INFINITY).shutter_s[1].is_finite());
}
