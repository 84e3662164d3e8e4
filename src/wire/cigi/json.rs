//! Messages as JSON and back: `{version, byte_order, packets: [{packet, packet_id, size, fields}], skipped, error}`.
//!
//! Bits and counts are whole numbers. An `f32` is shown as the exact `f64` of the same value. NaN and infinities, which
//! JSON does not have, are the texts "NaN", "Infinity" and "-Infinity". `skipped` counts the packets that are not
//! understood; `skipped_packets` keeps their bytes, so that a whole message comes back from its JSON byte for byte (but
//! for reserved bytes, which are sent as 0).

use super::layout::{Kind, Place, Value};
use super::message::{Message, encode_packet};
use super::packets::{LAYOUTS, Packet};
use super::{ByteOrder, Version};
use crate::wire::limits::{CIGI_JSON_PACKETS, CIGI_MESSAGE_BYTES};
use serde_json::{Map, Number, Value as Json, json};

/// Why a JSON text is not a message.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{path}: {why}")]
pub struct Wrong {
    /// Where, as in `packets[2].fields.yaw`.
    pub path: String,
    /// What is wrong, with value and limit.
    pub why: String,
}

fn wrong<T>(path: impl Into<String>, why: impl Into<String>) -> Result<T, Wrong> {
    Err(Wrong { path: path.into(), why: why.into() })
}

/// A decoded message as JSON; `bytes` is what it was decoded from.
pub fn show(message: &Message, bytes: &[u8]) -> Json {
    let packets: Vec<Json> = message.packets.iter().map(|packet| show_packet(packet, message)).collect();
    let skipped: Vec<Json> = message
        .skipped
        .iter()
        .map(|skipped| {
            let raw = bytes.get(skipped.offset..skipped.offset + skipped.size).unwrap_or_default();
            json!({
                "packet": super::others::name_of(message.version, skipped.packet_id),
                "packet_id": skipped.packet_id,
                "size": skipped.size,
                "before": skipped.index,
                "hex": to_hex(raw),
            })
        })
        .collect();
    let mut shown = json!({
        "version": message.version.name(),
        "byte_order": message.byte_order.name(),
        "packets": packets,
        "skipped": message.skipped.len(),
        "error": null,
    });
    if !skipped.is_empty() {
        shown["skipped_packets"] = skipped.into();
    }
    shown
}

/// What is shown of bytes that were rejected. Version and byte order stand there as far as they are known.
pub fn show_rejected(known: Option<(Version, ByteOrder)>, error: &str) -> Json {
    json!({
        "version": known.map(|(version, _)| version.name()),
        "byte_order": known.map(|(_, order)| order.name()),
        "packets": [],
        "skipped": 0,
        "error": error,
    })
}

fn show_packet(packet: &Packet, message: &Message) -> Json {
    let layout = packet.layout();
    let mut fields = Map::new();
    for (index, _, _, name) in layout.placed(message.version) {
        if let Some(value) = packet.field(index) {
            fields.insert(name.to_owned(), show_value(&value));
        }
    }
    let size = encode_packet(packet, message.version, message.byte_order).map_or(0, |bytes| bytes.len());
    json!({
        "packet": layout.name_in(message.version),
        "packet_id": layout.framing(message.version).map(|framing| framing.id),
        "size": size,
        "fields": fields,
    })
}

fn show_value(value: &Value) -> Json {
    let real = |number: f64| match Number::from_f64(number) {
        Some(number) => Json::Number(number),
        None if number.is_nan() => "NaN".into(),
        None if number > 0.0 => "Infinity".into(),
        None => "-Infinity".into(),
    };
    match value {
        Value::Whole(number) => (*number).into(),
        Value::Single(number) => real(f64::from(*number)),
        Value::Double(number) => real(*number),
        Value::Text(text) => text.as_str().into(),
    }
}

/// The bytes of a message that is given as JSON. Fields that are not given have their defaults, `version` and
/// `byte_order` are needed, and sizes follow from the packets.
///
/// # Errors
/// [`Wrong`]: the first thing that is not right.
pub fn encode_json(text: &str) -> Result<Vec<u8>, Wrong> {
    let Json::Object(given) = serde_json::from_str(text).or_else(|e| wrong("the text", format!("not JSON: {e}")))?
    else {
        return wrong("the text", "not an object");
    };
    let version = one_of("version", given.get("version"), &Version::ALL, Version::name)?;
    let byte_order = one_of("byte_order", given.get("byte_order"), &ByteOrder::ALL, ByteOrder::name)?;
    let packets = list("packets", given.get("packets"))?;
    let skipped = match given.get("skipped_packets") {
        None | Some(Json::Null) => &[][..],
        list_given => list("skipped_packets", list_given)?,
    };
    let mut skipped: Vec<(u64, Vec<u8>)> = skipped.iter().enumerate().map(read_skipped).collect::<Result<_, _>>()?;
    skipped.reverse();
    let mut bytes = Vec::new();
    for index in 0..=packets.len() {
        while let Some((_, raw)) = skipped.pop_if(|(before, _)| *before <= index as u64) {
            bytes.extend(raw);
        }
        if let Some(packet) = packets.get(index) {
            let path = format!("packets[{index}]");
            let packet = read_packet(&path, packet, version)?;
            let encoded = encode_packet(&packet, version, byte_order);
            bytes.extend(encoded.or_else(|e| wrong(path, e.to_string()))?);
        }
    }
    if bytes.len() > CIGI_MESSAGE_BYTES {
        return wrong("packets", format!("{} bytes, at most {CIGI_MESSAGE_BYTES}", bytes.len()));
    }
    Ok(bytes)
}

fn one_of<T: Copy>(path: &str, given: Option<&Json>, all: &[T], name: impl Fn(T) -> &'static str) -> Result<T, Wrong> {
    let found = all.iter().find(|one| given.and_then(Json::as_str) == Some(name(**one)));
    let names: Vec<&str> = all.iter().map(|one| name(*one)).collect();
    found.copied().map_or_else(|| wrong(path, format!("must be one of \"{}\"", names.join("\", \""))), Ok)
}

fn list<'a>(path: &str, given: Option<&'a Json>) -> Result<&'a [Json], Wrong> {
    match given {
        Some(Json::Array(list)) if list.len() <= CIGI_JSON_PACKETS => Ok(list),
        Some(Json::Array(list)) => wrong(path, format!("{} packets, at most {CIGI_JSON_PACKETS}", list.len())),
        _ => wrong(path, "must be a list"),
    }
}

fn read_skipped((index, given): (usize, &Json)) -> Result<(u64, Vec<u8>), Wrong> {
    let path = format!("skipped_packets[{index}]");
    match (given["before"].as_u64(), given["hex"].as_str().and_then(from_hex)) {
        (Some(before), Some(bytes)) => Ok((before, bytes)),
        _ => wrong(path, "needs `before`, a count of packets, and `hex`, its bytes"),
    }
}

fn read_packet(path: &str, given: &Json, version: Version) -> Result<Packet, Wrong> {
    let name = given["packet"].as_str();
    let id = given["packet_id"].as_u64();
    if name.is_none() && id.is_none() {
        return wrong(path, "needs `packet`, a name, or `packet_id`");
    }
    let found = LAYOUTS.iter().find(|layout| {
        layout.framing(version).is_some_and(|framing| {
            name.is_none_or(|name| name == layout.name_in(version)) && id.is_none_or(|id| id == u64::from(framing.id))
        })
    });
    let Some(mut packet) = found.and_then(|layout| Packet::blank(version, layout.framing(version)?.id)) else {
        let what = format!("{} {}", name.unwrap_or_default(), id.map(|id| id.to_string()).unwrap_or_default());
        return wrong(path, format!("CIGI {} has no packet {}", version.name(), what.trim()));
    };
    let layout = packet.layout();
    let no_fields = Map::new();
    let fields = match given.get("fields") {
        None => &no_fields,
        Some(Json::Object(fields)) => fields,
        Some(_) => return wrong(format!("{path}.fields"), "must be an object"),
    };
    let [major, minor] = version.numbers();
    for (index, field, place, name) in layout.placed(version) {
        let value = match (fields.get(name), name) {
            (Some(value), _) => read_value(&format!("{path}.fields.{name}"), value, field.kind, place)?,
            (None, "major_version") => Value::Whole(major.into()),
            (None, "minor_version") => Value::Whole(minor.into()),
            (None, _) => continue,
        };
        if !packet.set_field(index, &value) {
            return wrong(format!("{path}.fields.{name}"), "does not fit its type");
        }
    }
    match fields.keys().find(|key| layout.placed(version).all(|(_, _, _, name)| name != key.as_str())) {
        Some(unknown) => wrong(format!("{path}.fields.{unknown}"), format!("{} has no such field", layout.name)),
        None => Ok(packet),
    }
}

fn read_value(path: &str, given: &Json, kind: Kind, place: Place) -> Result<Value, Wrong> {
    match kind {
        Kind::Text => match given.as_str() {
            Some(text) => Ok(Value::Text(text.to_owned())),
            None => wrong(path, format!("{given} is not a text")),
        },
        Kind::F32 | Kind::F64 => {
            let number = match given.as_str() {
                Some("NaN") => Some(f64::NAN),
                Some("Infinity") => Some(f64::INFINITY),
                Some("-Infinity") => Some(f64::NEG_INFINITY),
                _ => given.as_f64(),
            };
            match (number, kind) {
                (Some(number), Kind::F64) => Ok(Value::Double(number)),
                (Some(number), _) if number.is_finite() && !(number as f32).is_finite() => {
                    wrong(path, format!("{number} is beyond the range of a 32-bit float"))
                }
                (Some(number), _) => Ok(Value::Single(number as f32)),
                (None, _) => wrong(path, format!("{given} is not a number")),
            }
        }
        _ => {
            let [least, most] = kind.range(place);
            let number = given.as_bool().map(i64::from).or_else(|| given.as_i64());
            match number.filter(|number| (least..=most).contains(number)) {
                Some(number) => Ok(Value::Whole(number)),
                None => wrong(path, format!("{given} is not a whole number from {least} to {most}")),
            }
        }
    }
}

/// Bytes as hexadecimal digits.
pub fn to_hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Bytes from hexadecimal digits, with or without spaces, line ends, colons or a leading `0x`; `None`: not such a text, or
/// more than a message has.
pub fn from_hex(text: &str) -> Option<Vec<u8>> {
    let text = text.trim();
    let text = text.strip_prefix("0x").unwrap_or(text);
    let mut digits = text.chars().filter(|c| !c.is_whitespace() && *c != ':');
    let mut bytes = Vec::new();
    while let Some(high) = digits.next() {
        let (high, low) = (high.to_digit(16)?, digits.next()?.to_digit(16)?);
        bytes.push(u8::try_from(high << 4 | low).ok()?);
        if bytes.len() > CIGI_MESSAGE_BYTES {
            return None;
        }
    }
    Some(bytes)
}
