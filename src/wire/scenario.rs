//! Scenarios: a JSON file of control messages with times becomes a timeline, or every complaint about it.

use super::control::decode::message_of;
use super::control::family::encode_command;
use super::control::{Message, PROTOCOL};
use super::json::{self, Complaint, Node, Problem, Rule, Size};
use super::{limits, schema};
use crate::world::World;
use crate::world::command::Command;
use crate::world::event::Refused;
use crate::world::timeline::{TimedCommand, Timeline};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::borrow::Cow;
use std::sync::LazyLock;

const SIZE: Size = Size { bytes: limits::SCENARIO_BYTES, values: limits::SCENARIO_VALUES };

static RULE: LazyLock<Rule> = LazyLock::new(|| schema::rule(&schema::scenario()));

/// A scenario inside a message: its JSON, which has passed the check of the message.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Document(Value);

impl JsonSchema for Document {
    fn schema_name() -> Cow<'static, str> {
        "Scenario".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        Schema::try_from(schema::scenario_in(generator)).unwrap_or_default()
    }
}

/// Reads a scenario file.
///
/// # Errors
/// Everything that is wrong with it, in the order of the file (up to [`limits::COMPLAINTS`]).
pub fn parse(text: &str) -> Result<Timeline, Vec<Complaint>> {
    let parsed = json::parse(text, SIZE).map_err(|problem| vec![problem.in_text(text)])?;
    let mut problems = parsed.problems;
    problems.extend(RULE.check(&parsed.root));
    let ordered = if problems.is_empty() {
        timeline_of(parsed.root.to_value(), &mut |refused| {
            problems.push(Problem { offset: parsed.root.nearest(&refused.field).offset, refused });
        })
    } else {
        problems.extend(contradictions(&parsed.root, &problems));
        None
    };
    if let Some(Ordered { timeline, places }) = ordered.as_ref().filter(|_| problems.is_empty()) {
        for (index, refused) in World::validate(timeline) {
            let field = match places.get(index) {
                Some(place) => format!("entries[{place}].{}", refused.field),
                None => refused.field,
            };
            let offset = parsed.root.nearest(&field).offset;
            problems.push(Problem { offset, refused: Refused { field, ..refused } });
        }
    }
    match ordered {
        Some(ordered) if problems.is_empty() => Ok(ordered.timeline),
        _ => {
            problems.sort_by_key(|problem| problem.offset);
            problems.truncate(limits::COMPLAINTS);
            Err(problems.into_iter().map(|problem| problem.in_text(text)).collect())
        }
    }
}

/// The timeline of a document that has passed the check.
///
/// # Errors
/// The first contradiction between its fields.
pub fn timeline(document: Document) -> Result<Timeline, Refused> {
    let mut first = None;
    let ordered = timeline_of(document.0, &mut |refused| {
        first.get_or_insert(refused);
    });
    match (first, ordered) {
        (None, Some(ordered)) => Ok(ordered.timeline),
        (Some(refused), _) => Err(refused),
        (None, None) => Err(Refused::new("entries", "not given", "a list", "no scenario")),
    }
}

/// The document of a timeline.
pub fn document(timeline: &Timeline) -> Document {
    let entry = |entry: &TimedCommand| {
        let (name, mut value) = encode_command(&entry.command);
        if let Some(fields) = value.as_object_mut() {
            fields.insert("type".into(), name.into());
            fields.insert("at".into(), entry.at_s.into());
        }
        value
    };
    Document(json!({
        "type": "scenario",
        "protocol": PROTOCOL,
        "name": timeline.name,
        "description": timeline.description,
        "duration_s": timeline.duration_s,
        "entries": timeline.entries.iter().map(entry).collect::<Vec<_>>(),
    }))
}

/// The text of a scenario file.
pub fn print(timeline: &Timeline) -> String {
    format!("{:#}\n", document(timeline).0)
}

/// A timeline, and for each of its entries the place that it had in the file.
struct Ordered {
    timeline: Timeline,
    places: Vec<usize>,
}

/// The timeline of a checked value; what contradicts itself is told to `complain` and left out.
fn timeline_of(value: Value, complain: &mut dyn FnMut(Refused)) -> Option<Ordered> {
    let Value::Object(mut fields) = value else { return None };
    let text = |value: Option<&Value>| value.and_then(Value::as_str).unwrap_or_default().to_owned();
    let (name, description) = (text(fields.get("name")), text(fields.get("description")));
    let duration_s = fields.get("duration_s").and_then(Value::as_f64)?;
    let Some(Value::Array(values)) = fields.remove("entries") else { return None };
    let mut entries = Vec::with_capacity(values.len());
    for (index, value) in values.into_iter().enumerate() {
        let at_s = value.get("at").and_then(Value::as_f64)?;
        if duration_s > 0.0 && at_s > duration_s {
            let why = "the entry comes after the scenario's end";
            complain(Refused::new(format!("entries[{index}].at"), at_s, format!("0 to {duration_s}"), why));
        }
        match command(value) {
            Ok(command) => entries.push((index, TimedCommand { at_s, command })),
            Err(refused) => complain(Refused { field: format!("entries[{index}].{}", refused.field), ..refused }),
        }
    }
    // Stable: entries of one time keep the order of the file.
    entries.sort_by(|(_, a), (_, b)| a.at_s.total_cmp(&b.at_s));
    let (places, entries) = entries.into_iter().unzip();
    Some(Ordered { timeline: Timeline { name, description, duration_s, entries }, places })
}

/// Contradictions in those entries that the check found nothing wrong with, so that they are told together with the rest.
fn contradictions(root: &Node, known: &[Problem]) -> Vec<Problem> {
    let entries = root.member("entries").and_then(Node::elements).unwrap_or_default();
    let mut found = Vec::new();
    for (index, node) in entries.iter().enumerate() {
        let path = format!("entries[{index}]");
        let is_inside = |problem: &Problem| problem.refused.field.starts_with(&path);
        if found.len() + known.len() >= limits::COMPLAINTS {
            break;
        }
        if known.iter().any(is_inside) {
            continue;
        }
        if let Err(refused) = command(node.to_value()) {
            let offset = node.nearest(&refused.field).offset;
            found.push(Problem { offset, refused: Refused { field: format!("{path}.{}", refused.field), ..refused } });
        }
    }
    found
}

fn command(entry: Value) -> Result<Command, Refused> {
    match message_of(entry)? {
        Message::Command(command) => Ok(command),
        _ => Err(Refused::new("type", "another message", "one that changes the world", "not for scenarios")),
    }
}

#[cfg(test)]
mod tests;
