//! The fields of all messages of a client, read from the published schema.

use serde_json::Value;
use std::collections::BTreeSet;

/// Paths such as `weather.layers[].base_m` or `view.create.size_px`: the type of the message, its second word where it has
/// one, and the field. Tags are no fields: they say which message it is.
pub fn published() -> BTreeSet<String> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/protocol/control.schema.json");
    let schema: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let definitions = &schema["$defs"];
    let mut found = BTreeSet::new();
    walk(definitions, &definitions["ClientMessage"], "", &mut found);
    found
}

/// Types of messages with their second word, as in the paths.
pub fn messages(fields: &BTreeSet<String>) -> BTreeSet<&str> {
    fields.iter().filter_map(|field| field.strip_suffix(".seq")).collect()
}

fn walk(definitions: &Value, node: &Value, path: &str, found: &mut BTreeSet<String>) {
    if let Some(name) = node["$ref"].as_str().and_then(|name| name.strip_prefix("#/$defs/")) {
        walk(definitions, &definitions[name], path, found);
    }
    let mut path = path.to_owned();
    if let Some(properties) = node["properties"].as_object() {
        for tag in ["type", "action", "what"] {
            // Inside a document, `type` is the same word again.
            if let Some(word) = properties.get(tag).and_then(|tag| tag["const"].as_str())
                && !path.contains(".document")
                && path.rsplit('.').next() != Some(word)
            {
                path = if path.is_empty() { word.to_owned() } else { format!("{path}.{word}") };
            }
        }
        for (name, below) in properties.iter().filter(|(_, below)| below.get("const").is_none()) {
            let field = format!("{path}.{name}");
            found.insert(field.clone());
            // The messages inside a document are those that are walked by themselves.
            if !field.contains(".document.entries") {
                walk(definitions, below, &field, found);
            }
        }
    }
    if let Some(items) = node.get("items") {
        walk(definitions, items, &format!("{path}[]"), found);
    }
    for group in ["oneOf", "anyOf", "allOf"] {
        for choice in node[group].as_array().into_iter().flatten() {
            walk(definitions, choice, &path, found);
        }
    }
}
