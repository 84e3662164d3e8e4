//! What a scenario file pins: order, every complaint at once with line and path, and the way back to a text.

use super::*;
use crate::world::command::{Strokes, TimeEdit};

fn file(entries: &[&str]) -> String {
    format!(
        "{{\"type\": \"scenario\", \"protocol\": \"stormdeck.v1\", \"name\": \"test\", \"description\": \"d\", \
         \"duration_s\": 60, \"entries\": [\n{}\n]}}",
        entries.join(",\n")
    )
}

fn complaints(text: &str) -> Vec<(String, usize)> {
    parse(text).expect_err(text).into_iter().map(|complaint| (complaint.path, complaint.line)).collect()
}

#[test]
fn entries_stand_in_the_order_of_their_times_and_those_of_one_time_in_the_order_of_the_file() {
    let text = file(&[
        r#"{"at": 9, "type": "time", "rate": 1}"#,
        r#"{"at": 0, "type": "time", "rate": 2}"#,
        r#"{"at": 9, "type": "time", "rate": 3}"#,
        r#"{"at": 4.5, "type": "time", "rate": 4}"#,
    ]);
    let timeline = parse(&text).expect("a good scenario");
    let found: Vec<(f64, Option<f64>)> = timeline
        .entries
        .iter()
        .map(|entry| match entry.command {
            Command::Time(TimeEdit { rate, .. }) => (entry.at_s, rate),
            _ => (entry.at_s, None),
        })
        .collect();
    assert_eq!(found, [(0.0, Some(2.0)), (4.5, Some(4.0)), (9.0, Some(1.0)), (9.0, Some(3.0))]);
    let Timeline { name, description, duration_s, .. } = timeline;
    assert_eq!((name.as_str(), description.as_str(), duration_s), ("test", "d", 60.0));
}

#[test]
fn every_complaint_is_told_at_once_with_its_path_and_line() {
    let text = file(&[
        r#"{"at": 0, "type": "time", "rate": 1}"#,
        r#"{"at": -1, "type": "time", "rate": 1, "colour": 2}"#,
        r#"{"at": 1, "type": "weather", "layers": [{"cloud_type": "cumulus", "base_m": 1e6, "thickness_m": 1e999, "coverage": 1}]}"#,
        r#"{"at": 1, "type": "weather", "layers": [{"cloud_type": "cumulus", "base_m": 900, "thickness_m": 500}]}"#,
        r#"{"at": 1, "type": "subscribe", "view": "main", "format": "png"}"#,
        r#"{"type": "time", "rate": 1}"#,
        r#"{"at": 1, "type": "time", "rate": 1, "seq": 4}"#,
    ]);
    let expected = [
        ("entries[1].at", 3),
        ("entries[1].colour", 3),
        ("entries[2].layers[0].base_m", 4),
        ("entries[2].layers[0].thickness_m", 4),
        ("entries[3].layers[0].coverage", 5),
        ("entries[4].type", 6),
        ("entries[5].at", 7),
        ("entries[6].seq", 8),
    ];
    assert_eq!(complaints(&text), expected.map(|(path, line)| (path.to_owned(), line)));
}

#[test]
fn what_the_world_would_refuse_is_told_at_the_entry_s_place_in_the_file() {
    let layer =
        |base_m: f64| format!(r#"{{"cloud_type": "cumulus", "base_m": {base_m}, "thickness_m": 500, "coverage": 1}}"#);
    let overlapping = format!(r#"{{"at": 2, "type": "weather", "layers": [{}, {}]}}"#, layer(1000.0), layer(1200.0));
    let text = file(&[
        r#"{"at": 5, "type": "view", "action": "remove", "name": "nowhere"}"#,
        &overlapping,
        r#"{"at": 1, "type": "weather", "changes": [{"index": 3, "base_m": 4}]}"#,
        r#"{"at": 61, "type": "time", "rate": 1}"#,
    ]);
    // The time after the end is found first; what the world says is told when the rest is in order.
    assert_eq!(complaints(&text), [("entries[3].at".to_owned(), 5)]);
    let text = text.replace("\"at\": 61", "\"at\": 60");
    let found = complaints(&text);
    let places: Vec<(&str, usize)> = found.iter().map(|(path, line)| (&path[..10], *line)).collect();
    assert_eq!(places, [("entries[0]", 2), ("entries[1]", 3), ("entries[2]", 4)], "{found:?}");
}

#[test]
fn a_scenario_that_never_ends_may_have_an_entry_at_any_time() {
    let text =
        file(&[r#"{"at": 100000, "type": "time", "rate": 1}"#]).replace("\"duration_s\": 60", "\"duration_s\": 0");
    assert_eq!(parse(&text).map(|timeline| timeline.entries.len()), Ok(1));
}

#[test]
fn what_is_no_scenario_is_told() {
    for (text, path, line) in [
        ("", "", 1),
        ("{}\n{}", "", 2),
        ("[]", "", 1),
        ("{\n\"type\": \"weather\"}", "type", 2),
        ("{\"entries\": 3\n}", "entries", 1),
        ("{\"entries\": [{\"at\": 1,\n \"type\": }]}", "entries[0].type", 2),
    ] {
        let found = complaints(text);
        assert!(found.contains(&(path.to_owned(), line)), "{text:?}: {found:?}");
    }
    let wrong_version = file(&[]).replace("stormdeck.v1", "stormdeck.v2");
    assert_eq!(complaints(&wrong_version), [("protocol".to_owned(), 1)]);
}

#[test]
fn the_number_of_complaints_is_bounded() {
    let bad = vec![r#"{"at": -1, "type": "dance"}"#; 500];
    assert_eq!(complaints(&file(&bad)).len(), limits::COMPLAINTS);
}

#[test]
fn a_timeline_comes_back_from_its_own_text() {
    let text = file(&[
        r#"{"at": 0, "type": "ownship", "latitude_deg": 47.123456789, "longitude_deg": -8.1, "altitude_m": 0.1, "yaw_deg": 1, "pitch_deg": 2, "roll_deg": 3, "velocity_ned_mps": [0.1, 0.2, 0.3]}"#,
        r#"{"at": 0.1, "type": "weather", "region": {"name": "a", "latitude_deg": 1, "longitude_deg": 2, "size_east_m": 1000, "size_north_m": 1000}, "layers": [], "transition_s": 3}"#,
        r#"{"at": 0.2, "type": "remove_region", "name": "a", "transition_s": 1}"#,
        r#"{"at": 0.2, "type": "storm", "name": "s", "latitude_deg": 1, "longitude_deg": 2, "size_east_m": 9000, "size_north_m": 9000}"#,
        r#"{"at": 0.2, "type": "remove_storm", "name": "s"}"#,
        r#"{"at": 0.3, "type": "time", "utc": "2026-05-10T11:25:00.123456Z"}"#,
        r#"{"at": 0.4, "type": "view", "action": "create", "name": "b", "exposure_ev100": 9.5}"#,
        r#"{"at": 0.5, "type": "view", "action": "remove", "name": "b"}"#,
        r#"{"at": 0.6, "type": "strike", "latitude_deg": 1, "longitude_deg": 2, "flash_type": "intra_cloud", "strokes": [{"delay_s": 0, "peak_current_ka": 3}], "seed": 18446744073709551615}"#,
    ]);
    let timeline = parse(&text).expect("a good scenario");
    assert_eq!(timeline.entries.len(), 9);
    let strike = timeline.entries.iter().find_map(|entry| match &entry.command {
        Command::Strike(request) => Some(request),
        _ => None,
    });
    assert!(
        strike.is_some_and(|s| s.seed == u64::MAX && matches!(&s.strokes, Strokes::Given(given) if given.len() == 1))
    );
    assert_eq!(parse(&print(&timeline)), Ok(timeline));
}
