//! Text to message and back.

use super::family::{self, FAMILIES};
use super::out::Outbound;
use super::{Inbound, Message};
use crate::wire::json::{self, Kind, Node, Problem, Rule, Size};
use crate::wire::{limits, schema};
use crate::world::event::Refused;
use serde_json::Value;
use std::sync::LazyLock;

/// How large a control message may be.
const SIZE: Size = Size { bytes: limits::MESSAGE_BYTES, values: limits::MESSAGE_VALUES };

static RULE: LazyLock<Rule> = LazyLock::new(|| schema::rule(&schema::inbound()));

/// Reads a control message.
///
/// # Errors
/// The first thing that is wrong, and the message's `seq` where the JSON could be read.
pub fn decode(text: &str) -> Result<Inbound, (Option<u64>, Refused)> {
    let parsed = json::parse(text, SIZE).map_err(|problem| (None, problem.refused))?;
    let seq = match parsed.root.member("seq").map(|seq| &seq.kind) {
        Some(Kind::Number(seq)) => seq.as_u64(),
        _ => None,
    };
    let problems = parsed.problems.into_iter().chain(RULE.check(&parsed.root));
    if let Some(Problem { refused, .. }) = problems.into_iter().next() {
        return Err((seq, refused));
    }
    message(&parsed.root).map(|message| Inbound { seq, message }).map_err(|refused| (seq, refused))
}

/// The message of a value that has passed the check.
///
/// # Errors
/// Fields that contradict each other.
pub(in crate::wire) fn message(node: &Node) -> Result<Message, Refused> {
    message_of(node.to_value())
}

/// The same of a value without places.
///
/// # Errors
/// Fields that contradict each other.
pub(in crate::wire) fn message_of(mut value: Value) -> Result<Message, Refused> {
    let mut tag = None;
    if let Some(fields) = value.as_object_mut() {
        tag = fields.remove("type");
        fields.remove("seq");
        fields.remove("at");
    }
    let name = tag.as_ref().and_then(Value::as_str).unwrap_or_default();
    match FAMILIES.iter().find(|family| family.name == name) {
        Some(family) => (family.decode)(value),
        None => Err(Refused::new("type", name, "a known type", "unknown message")),
    }
}

/// The text of a client's message.
pub fn encode_inbound(inbound: &Inbound) -> String {
    let (name, mut value) = family::encode(&inbound.message);
    if let Some(fields) = value.as_object_mut() {
        fields.insert("type".into(), name.into());
        if let Some(seq) = inbound.seq {
            fields.insert("seq".into(), seq.into());
        }
    }
    value.to_string()
}

/// The text of a message of the server.
pub fn encode(outbound: &Outbound) -> String {
    // Our own types always have a JSON text; should one not, an empty text says less than a crash costs.
    serde_json::to_string(outbound).unwrap_or_default()
}

/// Reads a message of the server, on a client's side.
///
/// # Errors
/// The text is too large or is no message of this protocol.
pub fn decode_outbound(text: &str) -> Result<Outbound, Refused> {
    // Our own parser, because serde_json's rounds some numbers wrongly in their last bit.
    let size = Size { bytes: limits::SCENARIO_BYTES, values: limits::SCENARIO_VALUES };
    let parsed = json::parse(text, size).map_err(|problem| problem.refused)?;
    if let Some(Problem { refused, .. }) = parsed.problems.into_iter().next() {
        return Err(refused);
    }
    serde_json::from_value(parsed.root.to_value())
        .map_err(|error| Refused::new("", error, "the published schema", "cannot be read"))
}
