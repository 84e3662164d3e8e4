//! The committed schemas are those of the types, and every example of the protocol's page is a message.

use super::*;
use crate::wire::control::{decode, decode_outbound, encode};
use crate::wire::scenario;
use std::collections::BTreeSet;

const PAGE: &str = include_str!("../../../protocol/README.md");

#[test]
fn the_committed_schema_of_the_control_messages_is_current() {
    committed("protocol/control.schema.json", &control_file());
}

#[test]
fn every_schema_that_is_checked_by_can_be_made_a_rule() {
    for schema in [inbound(), super::scenario()] {
        assert_eq!(Rule::from_schema(&schema).err(), None);
    }
}

#[test]
fn every_reference_of_the_published_file_leads_somewhere() {
    let file = control_file();
    let text = text(&file);
    let references: BTreeSet<&str> =
        text.split("\"$ref\": \"#").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    assert!(references.len() > 20, "only {} references were found", references.len());
    for reference in references {
        assert!(file.pointer(reference).is_some(), "{reference}");
    }
}

/// The lines of all examples of one kind.
fn examples(kind: &str) -> Vec<&'static str> {
    let mut lines = Vec::new();
    for block in PAGE.split("```json ").skip(1) {
        let (head, rest) = block.split_once('\n').expect("a block has lines");
        let (body, _) = rest.split_once("```").expect("a block ends");
        if head == kind {
            lines.extend(body.lines());
        }
    }
    lines
}

#[test]
fn every_example_of_the_page_is_a_message_and_each_family_has_one() {
    let mut seen = BTreeSet::new();
    for line in examples("client") {
        if let Err((_, refused)) = decode(line) {
            panic!("{line}: {refused}");
        }
        let value: Value = serde_json::from_str(line).expect(line);
        seen.insert(value["type"].as_str().unwrap_or_default().to_owned());
    }
    let families: BTreeSet<String> = FAMILIES.iter().map(|family| family.name.to_owned()).collect();
    assert_eq!(seen, families);
}

#[test]
fn every_answer_of_the_page_is_what_the_server_would_write_and_each_kind_is_there() {
    let mut seen = BTreeSet::new();
    for line in examples("server") {
        let message = decode_outbound(line).unwrap_or_else(|refused| panic!("{line}: {refused}"));
        let (written, shown): (Value, Value) =
            (serde_json::from_str(&encode(&message)).expect("our own text"), serde_json::from_str(line).expect(line));
        let difference = difference(&shown, &written);
        assert_eq!(difference, None, "{line}");
        seen.insert(shown["type"].as_str().unwrap_or_default().to_owned());
    }
    let schema = outbound();
    let kinds: BTreeSet<String> = schema["$defs"]["Outbound"]["oneOf"]
        .as_array()
        .expect("a union")
        .iter()
        .filter_map(|branch| Some(branch["properties"]["type"]["const"].as_str()?.to_owned()))
        .collect();
    assert_eq!(seen, kinds);
}

/// Where two values differ; numbers are compared by value (1 and 1.0 are the same).
fn difference(a: &Value, b: &Value) -> Option<String> {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            let keys: BTreeSet<&String> = a.keys().chain(b.keys()).collect();
            keys.into_iter().find_map(|key| match (a.get(key), b.get(key)) {
                (Some(a), Some(b)) => difference(a, b).map(|rest| format!("{key}.{rest}")),
                _ => Some(key.clone()),
            })
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            a.iter().zip(b).enumerate().find_map(|(k, (a, b))| difference(a, b).map(|rest| format!("[{k}].{rest}")))
        }
        (Value::Number(a), Value::Number(b)) if a.as_f64() == b.as_f64() => None,
        _ if a == b => None,
        _ => Some(format!("{a} and {b}")),
    }
}

#[test]
fn every_scenario_of_the_page_is_one() {
    let texts = examples("scenario");
    assert!(!texts.is_empty());
    for text in texts {
        assert!(scenario::parse(text).is_ok_and(|timeline| !timeline.entries.is_empty()), "{text}");
    }
}

#[test]
fn no_block_of_the_page_escapes_the_tests() {
    for block in PAGE.split("```").skip(1).step_by(2) {
        let kind = block.lines().next().unwrap_or_default();
        assert!(["json client", "json server", "json scenario"].contains(&kind), "a block of kind {kind:?}");
    }
}
