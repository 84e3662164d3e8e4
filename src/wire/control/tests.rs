//! What the decoder pins: every field of every message reaches the command, and everything out of range is refused with
//! its path.

use super::{Inbound, Message, decode, encode_inbound};
use crate::wire::json::{Size, parse};
use crate::wire::schema;
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
                { "delay_s": 0, "peak_current_ka": 30 }, { "delay_s": 0.06, "peak_current_ka": 12 }], "seed": 5 }),
        json!({ "type": "strike", "latitude_deg": 47, "longitude_deg": 8.1, "at_s": "now", "flash_type": "intra_cloud",
            "peak_current_ka": 25, "strokes": "sample", "seed": 6 }),
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

/// The published limits of the leaf at a path: its schema with the references followed.
fn schema_at<'a>(schema: &'a Value, root: &'a Value, value: &Value, pointer: &str) -> Option<&'a Value> {
    if let Some(reference) = schema.get("$ref").and_then(Value::as_str) {
        return schema_at(root.pointer(&reference[1..])?, root, value, pointer);
    }
    if let Some(branches) = schema.get("oneOf").or(schema.get("anyOf")).and_then(Value::as_array) {
        let fits = |branch: &&Value| match branch.get("properties").and_then(Value::as_object) {
            Some(properties) => properties.iter().all(|(key, property)| match property.get("const") {
                Some(constant) => value.get(key) == Some(constant),
                None => true,
            }),
            None => true,
        };
        return branches.iter().filter(fits).find_map(|branch| schema_at(branch, root, value, pointer));
    }
    let Some(step) = pointer.strip_prefix('/') else {
        let is_number = schema.get("type").is_some_and(|kind| kind.to_string().contains('n') && kind != "boolean");
        return (is_number && schema.get("maximum").is_some()).then_some(schema);
    };
    let (step, rest) = step.split_once('/').map_or((step, String::new()), |(step, rest)| (step, format!("/{rest}")));
    let (inner, inner_value) = match step.parse::<usize>() {
        Ok(index) => (schema.get("items")?, value.get(index)?),
        Err(_) => (schema.get("properties")?.get(step)?, value.get(step)?),
    };
    schema_at(inner, root, inner_value, &rest)
}

#[test]
fn every_number_is_refused_on_both_sides_of_its_range_with_its_path() {
    let root = schema::inbound();
    let mut tried = 0;
    for example in examples() {
        for (path, pointer) in all_leaves(&example) {
            let value = example.pointer(&pointer).expect("a leaf");
            if !value.is_number() || path == "seed" {
                continue;
            }
            let bounds = schema_at(&root, &root, &example, &pointer);
            let bounds = bounds.unwrap_or_else(|| panic!("no published range for {path} of {example}"));
            let [min, max] = ["minimum", "maximum"].map(|key| bounds.get(key).and_then(Value::as_f64).unwrap_or(0.0));
            for outside in [json!(min - 1.0), json!(max + 1.0), json!(max * 2.0 + 2.0)] {
                let (_, refused) = decode(&with(&example, &pointer, outside.clone()).to_string())
                    .expect_err(&format!("{path} = {outside} in {example}"));
                assert_eq!(refused.field, path, "{outside} in {example}");
                assert!(!refused.limit.is_empty() && !refused.value.is_empty() && !refused.why.is_empty());
            }
            let infinite = with(&example, &pointer, json!("@")).to_string().replace("\"@\"", "1e999");
            assert_eq!(decode(&infinite).expect_err(&infinite).1.field, path, "{infinite}");
            tried += 1;
        }
    }
    assert!(tried > 60, "only {tried} numbers were tried");
}

#[test]
fn wrong_types_unknown_fields_and_missing_fields_are_refused_with_their_paths() {
    for example in examples() {
        for (path, pointer) in all_leaves(&example) {
            let wrong = with(&example, &pointer, json!({ "what": "is this" })).to_string();
            assert_eq!(decode(&wrong).expect_err(&wrong).1.field, path, "{wrong}");
        }
        let mut unknown = example.clone();
        unknown.as_object_mut().map(|map| map.insert("colour".into(), json!(1)));
        assert_eq!(decode(&unknown.to_string()).expect_err("an unknown field").1.field, "colour");
    }
    for (text, field) in [
        ("{}", "type"),
        (r#"{"type":"dance"}"#, "type"),
        (r#"{"type":7}"#, "type"),
        ("[]", ""),
        ("7", ""),
        (r#"{"type":"ownship","latitude_deg":1}"#, "altitude_m"),
        (r#"{"type":"view","name":"a"}"#, "action"),
        (r#"{"type":"view","action":"dance","name":"a"}"#, "action"),
        (r#"{"type":"step"}"#, "to_s"),
        (r#"{"type":"step","to_s":1,"seq":-1}"#, "seq"),
        (r#"{"type":"step","to_s":1,"seq":"a"}"#, "seq"),
        (r#"{"type":"step","to_s":1,"to_s":2}"#, "to_s"),
        (r#"{"type":"unsubscribe","view":"../etc"}"#, "view"),
        (r#"{"type":"scenario","action":"load","name":"../etc"}"#, "name"),
    ] {
        assert_eq!(decode(text).expect_err(text).1.field, field, "{text}");
    }
}

#[test]
fn what_contradicts_itself_is_refused() {
    let layer = r#""cloud_type":"cumulus","base_m":900,"thickness_m":500"#;
    let strike = r#""type":"strike","latitude_deg":1,"longitude_deg":1,"flash_type":"intra_cloud""#;
    for (text, field) in [
        (format!(r#"{{"type":"weather","layers":[{{{layer},"coverage":0.5,"coverage_eighths":4}}]}}"#), "layers[0].coverage_eighths"),
        (format!(r#"{{"type":"weather","layers":[{{{layer}}}]}}"#), "layers[0].coverage"),
        (r#"{"type":"weather","changes":[{"index":0,"coverage":0.5,"coverage_eighths":4}]}"#.into(), "changes[0].coverage_eighths"),
        (r#"{"type":"weather","transition_s":4}"#.into(), "layers"),
        (r#"{"type":"weather","region":{"name":"a","latitude_deg":1,"longitude_deg":1,"size_east_m":1000,"size_north_m":2000,"corner_radius_m":501}}"#.into(), "region.corner_radius_m"),
        (r#"{"type":"time"}"#.into(), "utc"),
        (r#"{"type":"time","utc":"noon"}"#.into(), "utc"),
        (r#"{"type":"hello","protocol":"stormdeck.v2","role":"host"}"#.into(), "protocol"),
        (r#"{"type":"subscribe","view":"main","format":"png","quality":80}"#.into(), "quality"),
        (format!(r#"{{{strike},"peak_current_ka":3,"strokes":[{{"delay_s":0,"peak_current_ka":3}}]}}"#), "peak_current_ka"),
        (format!(r#"{{{strike},"strokes":[{{"delay_s":1,"peak_current_ka":3}},{{"delay_s":1,"peak_current_ka":3}}]}}"#), "strokes[1].delay_s"),
        (r#"{"type":"scenario","action":"load"}"#.into(), "name"),
    ] {
        assert_eq!(decode(&text).expect_err(&text).1.field, field, "{text}");
    }
}

#[test]
fn coverage_in_eighths_is_the_same_coverage() {
    let text = |coverage: &str| {
        format!(
            r#"{{"type":"weather","layers":[{{"cloud_type":"cumulus","base_m":900,"thickness_m":500,{coverage}}}]}}"#
        )
    };
    assert_eq!(decode(&text(r#""coverage_eighths":5"#)), decode(&text(r#""coverage":0.625"#)));
}

#[test]
fn the_number_of_a_message_is_recovered_for_its_refusal() {
    let seq = |text: &str| decode(text).expect_err(text).0;
    assert_eq!(seq(r#"{"type":"step","to_s":-1,"seq":9}"#), Some(9));
    assert_eq!(seq(r#"{"type":"dance","seq":18446744073709551615}"#), Some(u64::MAX));
    assert_eq!(seq(r#"{"seq":4,"type":"step","to_s":1,"to_s":1}"#), Some(4));
    assert_eq!(seq(r#"{"seq":4,"type":"step","to_s":"#), None, "not readable");
    assert_eq!(decode(r#"{"type":"step","to_s":1,"seq":null}"#).map(|inbound| inbound.seq), Ok(None));
}

/// Counter-based random numbers (splitmix64): the same sequence in each run.
fn random(counter: &mut u64) -> u64 {
    *counter = counter.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut x = *counter;
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[test]
fn random_and_mutated_texts_are_refused_or_decoded_and_never_panic() {
    let mut counter = 1;
    let alphabet = b"{}[]\",:\\0123456789.eE+-ntfu \x00\xc3\xa9type";
    let mut refused = 0;
    for _ in 0..3000 {
        let length = random(&mut counter) % 60;
        let bytes: Vec<u8> = (0..length).map(|_| alphabet[random(&mut counter) as usize % alphabet.len()]).collect();
        refused += usize::from(decode(&String::from_utf8_lossy(&bytes)).is_err());
    }
    for example in examples() {
        let text = example.to_string();
        for _ in 0..300 {
            let mut bytes = text.clone().into_bytes();
            for _ in 0..1 + random(&mut counter) % 3 {
                let at = random(&mut counter) as usize % bytes.len();
                match random(&mut counter) % 3 {
                    0 => bytes[at] = alphabet[random(&mut counter) as usize % alphabet.len()],
                    1 => bytes.truncate(at.max(1)),
                    _ => bytes.insert(at, alphabet[random(&mut counter) as usize % alphabet.len()]),
                }
            }
            refused += usize::from(decode(&String::from_utf8_lossy(&bytes)).is_err());
        }
        for end in 0..text.len() {
            assert!(decode(&text[..end]).is_err(), "{}", &text[..end]);
        }
    }
    assert!(refused > 5000, "only {refused} were refused");
}

#[test]
fn every_example_validates_with_each_optional_field_absent_or_null() {
    for example in examples() {
        let parsed = parse(&example.to_string(), Size { bytes: 10_000, values: 1000 }).expect("JSON");
        assert_eq!(schema::rule(&schema::inbound()).check(&parsed.root), [], "{example}");
        let mut with_null = example.clone();
        with_null["seq"] = Value::Null;
        assert_eq!(decoded(&with_null), decoded(&example));
    }
}
