//! The world as a whole: all or nothing, time in any steps, scenarios, and that every field of every command counts.

use super::command::*;
use super::*;
use crate::clouds::CloudKind;
use std::sync::Arc;

fn layer(base_m: f64) -> LayerSpec {
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

fn layers(list: Vec<LayerSpec>, transition_s: f64) -> Command {
    Command::Weather(WeatherEdit { layers: Some(list), transition_s, ..Default::default() })
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
}

#[test]
fn time_may_go_in_any_steps() {
    let mut whole = World::new();
    whole.apply(Command::Scenario(ScenarioEdit::Load(Arc::new(demo())))).unwrap();
    let mut split = whole.clone();
    whole.advance_to(10.0);
    for t in [3.0, 7.0, 6.0, f64::NAN, 10.0] {
        split.advance_to(t);
    }
    assert_eq!(whole.snapshot(0.1), split.snapshot(0.1));
}

fn demo() -> Timeline {
    let at = |at_s, command| TimedCommand { at_s, command };
    Timeline {
        name: "demo".into(),
        duration_s: 60.0,
        entries: vec![
            at(0.0, layers(vec![layer(1000.0)], 0.0)),
            at(4.0, layers(vec![layer(1500.0), layer(4000.0)], 20.0)),
            at(9.0, layers(vec![layer(1200.0)], 5.0)),
        ],
        ..Default::default()
    }
}
