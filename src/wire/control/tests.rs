//! What the decoder pins: every field of every message reaches the command, and everything out of range is refused with
//! its path.

mod random;
mod refusals;

use super::{Inbound, Message, decode, encode_inbound};
use serde_json::{Value, json};

/// One full message of each kind.
fn examples() -> Vec<Value> {
    let layer = json!({
        "cloud_type": "cumulus", "base_m": 900, "thickness_m": 1500, "coverage": 0.6, "density": 1.2,
        "wind_speed_mps": 8, "wind_from_deg": 270
    });
    let region = json!({
        "name": "cell-1", "latitude_deg": 47.2, "longitude_deg": 8.5, "size_east_m": 20000, "size_north_m": 30000,
        "corner_radius_m": 5000, "rotation_deg": 30, "transition_m": 4000
    });
    vec![
        json!({ "type": "hello", "protocol": "stormdeck.v1", "role": "host", "name": "sim", "take_over": true,
            "token": "secret-token" }),
        json!({ "type": "ownship", "latitude_deg": 47.1, "longitude_deg": 8.2, "altitude_m": 1200.5, "yaw_deg": 90,
            "pitch_deg": 2, "roll_deg": -10, "velocity_ned_mps": [1, 60, -2], "host_frame": 77 }),
        json!({ "type": "weather", "region": region, "layers": [layer],
            "changes": [{ "index": 0, "cloud_type": "stratus", "base_m": 800, "thickness_m": 300, "coverage": 0.9,
                "density": 2, "wind_speed_mps": 5, "wind_from_deg": 10 }],
            "visibility_m": 20000, "transition_s": 30 }),
        json!({ "type": "remove_region", "name": "cell-1", "transition_s": 20 }),
        json!({ "type": "time", "utc": "2026-06-21T11:30:00Z", "rate": 2 }),
        json!({ "type": "view", "action": "create", "name": "left", "size_px": [640, 360], "field_of_view_deg": 50,
            "offset_m": [1, -2, 3], "yaw_deg": -60, "pitch_deg": 5, "roll_deg": 1, "exposure_ev100": 13.5 }),
        json!({ "type": "view", "action": "change", "name": "left", "size_px": [320, 200], "field_of_view_deg": 51,
            "offset_m": [2, -3, 4], "yaw_deg": -61, "pitch_deg": 6, "roll_deg": 2, "exposure_ev100": "automatic" }),
        json!({ "type": "view", "action": "remove", "name": "left" }),
        json!({ "type": "strike", "latitude_deg": 47, "longitude_deg": 8.1, "altitude_m": 3000, "at_s": 12.5,
            "flash_type": "cloud_to_ground", "polarity": "positive", "strokes": [
                { "delay_s": 0, "peak_current_ka": 30, "continuing_s": 0.2, "ground_point_m": [10, -20] },
                { "delay_s": 0.06, "peak_current_ka": 12 }], "leader": true, "seed": 5 }),
        json!({ "type": "strike", "latitude_deg": 47, "longitude_deg": 8.1, "at_s": "now", "flash_type": "intra_cloud",
            "peak_current_ka": 25, "strokes": "sample", "seed": 6 }),
        json!({ "type": "storm", "name": "cell-2", "latitude_deg": 47.5, "longitude_deg": 8.5, "size_east_m": 9000,
            "size_north_m": 8000, "corner_radius_m": 3000, "rotation_deg": 15, "altitude_m": 5000, "flashes_per_minute": 6,
            "inside_share": 0.8, "positive_share": 0.2, "current_factor": 1.5, "seed": 3 }),
        json!({ "type": "remove_storm", "name": "cell-2" }),
        json!({ "type": "scenario", "action": "load", "name": "clear-day" }),
        json!({ "type": "scenario", "action": "load", "document": { "type": "scenario", "protocol": "stormdeck.v1",
            "name": "tiny", "description": "Small.", "duration_s": 60, "entries": [
                { "at": 5, "type": "time", "rate": 3 }, { "at": 9, "type": "view", "action": "remove", "name": "a" }] } }),
        json!({ "type": "scenario", "action": "play" }),
        json!({ "type": "scenario", "action": "pause" }),
        json!({ "type": "scenario", "action": "seek", "at_s": 30 }),
        json!({ "type": "scenario", "action": "speed", "factor": 4 }),
        json!({ "type": "subscribe", "view": "main", "format": "jpeg", "max_rate_hz": 30, "quality": 80,
            "when_slow": "drop_newest" }),
        json!({ "type": "unsubscribe", "view": "main" }),
        json!({ "type": "step", "to_s": 1.5 }),
        json!({ "type": "query", "what": "state" }),
        json!({ "type": "query", "what": "plan", "view": "main" }),
        json!({ "type": "query", "what": "statistics" }),
        json!({ "type": "query", "what": "heights", "latitude_deg": 47, "longitude_deg": 8, "altitude_m": 900 }),
        json!({ "type": "query", "what": "line_of_sight_segment", "ground": false, "cloud": false, "cloud_opacity": 0.25,
            "from": { "latitude_deg": 47, "longitude_deg": 8, "altitude_m": 900 },
            "to": { "latitude_deg": 47.1, "longitude_deg": 8.1, "altitude_m": 3000 } }),
        json!({ "type": "query", "what": "line_of_sight_vector", "ground": false, "cloud": false, "cloud_opacity": 0.25,
            "from": { "latitude_deg": 47, "longitude_deg": 8, "altitude_m": 900 }, "azimuth_deg": 30,
            "elevation_deg": 20, "minimum_m": 100, "maximum_m": 50000 }),
        json!({ "type": "query", "what": "conditions", "latitude_deg": 47, "longitude_deg": 8, "altitude_m": 900 }),
    ]
}

fn decoded(value: &Value) -> Message {
    match decode(&value.to_string()) {
        Ok(Inbound { message, .. }) => message,
        Err((_, refused)) => panic!("{value}: {refused}"),
    }
}

/// The number, text or flag at each path of a value, with the path in the words of a refusal.
fn leaves(value: &Value, path: &str, found: &mut Vec<(String, String)>, pointer: &str) {
    match value {
        Value::Object(map) => {
            for (key, value) in map {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                leaves(value, &path, found, &format!("{pointer}/{key}"));
            }
        }
        Value::Array(list) => {
            for (index, value) in list.iter().enumerate() {
                leaves(value, &format!("{path}[{index}]"), found, &format!("{pointer}/{index}"));
            }
        }
        _ => found.push((path.to_owned(), pointer.to_owned())),
    }
}

fn all_leaves(value: &Value) -> Vec<(String, String)> {
    let mut found = Vec::new();
    leaves(value, "", &mut found, "");
    found
}

fn with(value: &Value, pointer: &str, new: Value) -> Value {
    let mut changed = value.clone();
    *changed.pointer_mut(pointer).expect("a path of this value") = new;
    changed
}

/// Another value that is allowed at the same place.
fn other(value: &Value, path: &str) -> Value {
    let words = [
        ("host", "watcher"),
        ("cumulus", "cirrus"),
        ("stratus", "altostratus"),
        ("cloud_to_ground", "cloud_to_cloud"),
        ("intra_cloud", "cloud_to_ground"),
        ("positive", "negative"),
        ("drop_newest", "disconnect"),
        ("jpeg", "jpeg"),
        ("2026-06-21T11:30:00Z", "2026-06-21T11:30:00.5Z"),
    ];
    match value {
        Value::Number(number) if number.is_f64() => json!(number.as_f64().unwrap_or(0.0) + 0.03125),
        Value::Number(number) => json!(number.as_i64().unwrap_or(0) + if path.ends_with("delay_s") { 0 } else { 1 }),
        Value::String(text) if text == "now" => json!(3),
        Value::String(text) if text == "automatic" => json!(12),
        Value::String(text) if text == "sample" => json!([{ "delay_s": 0, "peak_current_ka": 9 }]),
        Value::String(text) => match words.iter().find(|(from, _)| from == text) {
            Some((_, to)) => json!(to),
            None => json!(format!("{text}-x")),
        },
        Value::Bool(flag) => json!(!flag),
        _ => panic!("no other value for {path}"),
    }
}

#[test]
fn every_message_comes_back_from_its_own_text() {
    for (seq, example) in examples().into_iter().enumerate() {
        let inbound = Inbound { seq: Some(seq as u64), message: decoded(&example) };
        assert_eq!(decode(&encode_inbound(&inbound)), Ok(inbound), "{example}");
    }
}

#[test]
fn every_field_of_every_message_changes_what_is_decoded() {
    // Fields that say which message it is, and those whose one value is fixed.
    let fixed = ["type", "action", "what", "protocol"];
    let mut changed = 0;
    for example in examples() {
        for (path, pointer) in all_leaves(&example) {
            let name = path.rsplit('.').next().unwrap_or_default();
            let value = example.pointer(&pointer).expect("a leaf");
            if fixed.contains(&name) || path == "index" {
                continue;
            }
            let mut text = with(&example, &pointer, other(value, &path));
            match path.as_str() {
                "format" => {
                    text = with(&text, &pointer, json!("png"));
                    text.as_object_mut().map(|map| map.remove("quality"));
                }
                "strokes[0].delay_s" => text = with(&text, &pointer, json!(0.01)),
                "strokes[1].delay_s" => text = with(&text, &pointer, json!(0.07)),
                "strokes" => {
                    text.as_object_mut().map(|map| map.remove("peak_current_ka"));
                }
                _ => {}
            }
            assert_ne!(decoded(&text), decoded(&example), "{path} of {example}");
            changed += 1;
        }
    }
    assert!(changed > 90, "only {changed} fields were tried");
}

#[test]
fn a_field_that_may_be_left_out_changes_what_is_decoded_when_it_is() {
    for example in examples() {
        for key in example.as_object().expect("an object").keys() {
            let mut without = example.clone();
            without.as_object_mut().map(|map| map.remove(key));
            match decode(&without.to_string()) {
                Ok(inbound) => {
                    // Those whose example is the default.
                    let same = inbound.message == decoded(&example);
                    let is_default = example[key] == json!("sample") || example[key] == json!("now");
                    assert_eq!(same, is_default, "{key} of {example}");
                }
                Err((_, refused)) => assert!(!refused.why.is_empty(), "{key} of {example}"),
            }
        }
    }
}
