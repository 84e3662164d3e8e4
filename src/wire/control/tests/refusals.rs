//! What is refused, and with which path.

use super::{all_leaves, decode, decoded, examples, with};
use crate::wire::json::{Size, parse};
use crate::wire::schema;
use serde_json::{Value, json};

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
