//! The published schemas, generated from the message types, and the rules made from them.

use super::control::PROTOCOL;
use super::control::family::{FAMILIES, Family};
use super::control::out::Outbound;
use super::json::Rule;
use super::limits;
use schemars::{JsonSchema, SchemaGenerator};
use serde_json::{Map, Value, json};

/// The schema of what a client sends.
pub fn inbound() -> Value {
    let mut generator = SchemaGenerator::default();
    let seq = json!({
        "description": "Number chosen by the client, echoed in the answer.",
        "type": ["integer", "null"], "format": "uint64", "minimum": 0
    });
    let variants: Vec<Value> =
        FAMILIES.iter().map(|family| variant(family, &mut generator, ("seq", &seq), false)).collect();
    finish(json!({ "description": "A message of a client, by its type.", "oneOf": variants }), generator)
}

/// The schema of what the server sends.
pub fn outbound() -> Value {
    let mut generator = SchemaGenerator::default();
    let reference = generator.subschema_for::<Outbound>().to_value();
    finish(reference, generator)
}

/// The file `protocol/control.schema.json`: both directions.
pub fn control_file() -> Value {
    let (mut inbound, mut outbound) = (inbound(), outbound());
    let mut all = definitions(&mut inbound);
    for (name, definition) in definitions(&mut outbound) {
        all.insert(name, definition);
    }
    all.insert("ClientMessage".into(), inbound);
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": format!("Control messages of {PROTOCOL}"),
        "description": "ClientMessage is what a client sends, Outbound what the server sends. Generated from the Rust types; \
            fields that depend on each other are checked besides.",
        "anyOf": [{ "$ref": "#/$defs/ClientMessage" }, { "$ref": "#/$defs/Outbound" }],
        "$defs": all,
    })
}

/// The schema of a scenario: a file, or the document of a `scenario` message.
pub fn scenario() -> Value {
    let mut generator = SchemaGenerator::default();
    let schema = scenario_in(&mut generator);
    finish(schema, generator)
}

/// The same for a generator that collects definitions.
pub fn scenario_in(generator: &mut SchemaGenerator) -> Value {
    let at = json!({
        "description": "Simulation time at which the message is due, in seconds.", "type": "number",
        "minimum": limits::SIMULATION_TIME_S.min, "maximum": limits::SIMULATION_TIME_S.max
    });
    let entries: Vec<Value> = FAMILIES
        .iter()
        .filter(|family| family.in_scenario)
        .map(|family| variant(family, generator, ("at", &at), true))
        .collect();
    json!({
        "description": "A scenario: messages with their times.",
        "type": "object",
        "additionalProperties": false,
        "required": ["type", "protocol", "name", "duration_s", "entries"],
        "properties": {
            "type": { "const": "scenario", "type": "string" },
            "protocol": { "const": PROTOCOL, "type": "string" },
            "name": {
                "description": "Short name.", "type": "string", "pattern": limits::SCENARIO_NAME_PATTERN,
                "minLength": limits::SCENARIO_NAME_LENGTH.min, "maxLength": limits::SCENARIO_NAME_LENGTH.max
            },
            "description": {
                "description": "One or two sentences for people.", "type": "string",
                "maxLength": limits::DESCRIPTION_LENGTH.max
            },
            "duration_s": {
                "description": "Simulation time at which the scenario ends and the time stops; 0: it never ends.", "type": "number",
                "minimum": limits::SCENARIO_DURATION_S.min, "maximum": limits::SCENARIO_DURATION_S.max
            },
            "entries": {
                "description": "The messages; of the same time in the order of the file.", "type": "array",
                "maxItems": limits::SCENARIO_ENTRIES,
                "items": { "description": "A message and its time.", "oneOf": entries }
            }
        }
    })
}

/// The rule of a schema of ours.
///
/// # Panics
/// The schema has a keyword that the check does not understand: an error of ours, which any message would show; every
/// schema is compiled by a test.
pub fn rule(schema: &Value) -> Rule {
    Rule::from_schema(schema).unwrap_or_else(|error| panic!("the schema of our own types: {error}"))
}

/// A schema as the text of its committed file.
pub fn text(schema: &Value) -> String {
    format!("{schema:#}\n")
}

/// One family's schema with `type` and one field more.
fn variant(family: &Family, generator: &mut SchemaGenerator, extra: (&str, &Value), required: bool) -> Value {
    let mut schema = (family.schema)(generator).to_value();
    add(&mut schema, family.name, extra, required);
    schema
}

fn add(schema: &mut Value, name: &str, (extra, extra_schema): (&str, &Value), required: bool) {
    let Some(map) = schema.as_object_mut() else { return };
    if let Some(variants) = map.get_mut("oneOf").and_then(Value::as_array_mut) {
        for variant in variants {
            add(variant, name, (extra, extra_schema), required);
        }
        // The outer union is told apart by `type`, the inner one by its own tag.
        map.insert("type".into(), "object".into());
        map.insert("properties".into(), json!({ "type": { "const": name, "type": "string" } }));
        map.insert("required".into(), json!(["type"]));
        return;
    }
    let properties = map.entry("properties").or_insert_with(|| json!({}));
    if let Some(properties) = properties.as_object_mut() {
        properties.insert("type".into(), json!({ "const": name, "type": "string" }));
        properties.insert(extra.into(), extra_schema.clone());
    }
    let list = map.entry("required").or_insert_with(|| json!([]));
    if let Some(list) = list.as_array_mut() {
        list.insert(0, "type".into());
        if required {
            list.insert(1, extra.into());
        }
    }
}

fn finish(mut schema: Value, generator: SchemaGenerator) -> Value {
    let definitions: Map<String, Value> = generator.definitions().clone();
    if let Some(map) = schema.as_object_mut() {
        map.insert("$defs".into(), Value::Object(definitions));
    }
    schema
}

fn definitions(schema: &mut Value) -> Map<String, Value> {
    match schema.as_object_mut().and_then(|map| map.remove("$defs")) {
        Some(Value::Object(definitions)) => definitions,
        _ => Map::new(),
    }
}

/// The schema of a type that stands alone (the settings).
pub fn of<T: JsonSchema>() -> Value {
    schemars::schema_for!(T).to_value()
}

/// Compares a committed file with what the types say now; with `UPDATE_SCHEMA=1` writes it first.
#[cfg(test)]
pub(crate) fn committed(path: &str, schema: &Value) {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    if std::env::var_os("UPDATE_SCHEMA").is_some_and(|value| value == "1") {
        std::fs::write(&file, text(schema)).expect(path);
    }
    let found = std::fs::read_to_string(&file).unwrap_or_default();
    assert!(found == text(schema), "{path} is not what the types say; run: UPDATE_SCHEMA=1 cargo test schema");
}

#[cfg(test)]
mod tests;
