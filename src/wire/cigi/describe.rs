//! The packets in words: bit diagrams for the docs of the types, and the tables of `protocol/cigi-3.3.md` and `cigi-4.0.md`.

use super::layout::{Effect, Field, Kind, Layout, Part};
use super::packets::LAYOUTS;
use super::{Direction, Version, others};
use std::fmt::Write as _;

/// Characters for one byte in a diagram; the longest name of a field of one byte has 18.
const BYTE_WIDTH: usize = 19;
/// Bytes in one row.
const ROW_BYTES: usize = 4;

/// What a byte of a packet holds.
#[derive(Clone, Debug, Default, PartialEq)]
struct Cell {
    /// What is written over the bytes that it fills.
    text: String,
    /// Bytes.
    width: usize,
}

/// The bit diagram of a packet in one version: four bytes a row, a bit-field as its letters from the most significant bit,
/// dots where nothing is; then what the letters stand for. Empty if the version does not have the packet.
pub fn diagram(layout: &Layout, version: Version) -> String {
    let Some(framing) = layout.framing(version) else { return String::new() };
    // A text is drawn as if it filled the first eight bytes that it may.
    let text_at =
        layout.placed(version).find(|(_, field, _, _)| field.kind == Kind::Text).map(|(_, _, place, _)| place.byte);
    let length = text_at.map_or(framing.size, |byte| (byte + 1).next_multiple_of(8));
    let mut cells: Vec<Cell> = vec![Cell::default(); length];
    let id = match version {
        Version::V3 => format!("id = {}", framing.id),
        Version::V4 => format!("id = 0x{:04x}", framing.id),
    };
    let size = if framing.largest > framing.size {
        format!("size {}..", framing.size)
    } else {
        format!("size = {}", framing.size)
    };
    match version {
        Version::V3 => {
            cells[0] = Cell { text: id, width: 1 };
            cells[1] = Cell { text: size, width: 1 };
        }
        Version::V4 => {
            cells[0] = Cell { text: size, width: 2 };
            cells[2] = Cell { text: id, width: 2 };
        }
    }
    let mut letters = Vec::new();
    for (_, field, place, name) in layout.placed(version) {
        let (lowest, width) = match place.part {
            Part::Bits { lowest, width } => (lowest, width),
            Part::Disputed { bit } => (bit, 1),
            _ => {
                let width = if field.kind == Kind::Text { length - place.byte } else { field.kind.bytes() };
                cells[place.byte] = Cell { text: name.to_owned(), width };
                continue;
            }
        };
        let letter = char::from(b'a' + (letters.len() % 26) as u8);
        letters.push(format!("{letter} {name}"));
        let cell = &mut cells[place.byte];
        let mut bits: Vec<char> =
            if cell.width == 0 { vec!['.'; 8] } else { cell.text.chars().filter(|c| *c != ' ').collect() };
        for bit in lowest..lowest + width {
            bits[7 - usize::from(bit)] = letter;
        }
        *cell = Cell { text: bits.iter().map(char::to_string).collect::<Vec<_>>().join(" "), width: 1 };
    }
    let mut drawn = format!("CIGI {}\n", version.name());
    let mut byte = 0;
    while byte < length {
        let _ = write!(drawn, "{byte:4} |");
        let row_end = byte + ROW_BYTES;
        while byte < row_end {
            let cell = &cells[byte];
            let (text, width) = if cell.width == 0 { (".", 1) } else { (cell.text.as_str(), cell.width) };
            let here = width.min(row_end - byte);
            let _ = write!(drawn, "{text:^0$}|", here * BYTE_WIDTH - 1);
            // The second half of a 64-bit number is a row of its own.
            if width > here {
                let (next, text) = (row_end, format!("({text})"));
                cells[next] = Cell { text, width: width - here };
            }
            byte += here;
        }
        drawn.push('\n');
    }
    for row in letters.chunks(4) {
        let _ = writeln!(drawn, "     {}", row.join(", "));
    }
    drawn
}

/// One line of a table of `protocol/`: the byte, the type, the name, the meaning, and what becomes of it.
fn row(field: &Field, name: &str, byte: usize, part: Part) -> String {
    let kind = match (part, field.kind) {
        (Part::Bits { lowest, width: 1 }, _) => format!("bit {lowest}"),
        (Part::Bits { lowest, width }, _) => format!("bits {lowest}-{}", lowest + width - 1),
        (Part::Disputed { bit }, _) => format!("bit {bit} (disputed)"),
        (_, Kind::Text) => "text".to_owned(),
        (_, kind) => format!("{kind:?}").to_lowercase(),
    };
    let (how, what) = match field.effect {
        Effect::Used(what) => ("used", what),
        Effect::Ignored(why) => ("ignored", why),
        Effect::Sent(what) => ("sent", what),
    };
    // The docs name the field first; the table has a column for that.
    let says = field.meaning.trim().split_once(": ").map_or("", |(_, says)| says).trim_end_matches('.');
    format!("| {byte} | {kind} | `{name}` | {says} | **{how}**: {what} |\n")
}

/// The tables of one version, for its page under `protocol/`.
pub fn tables(version: Version) -> String {
    let mut text = String::new();
    for (direction, title) in
        [(Direction::HostToIg, "Packets from the host"), (Direction::IgToHost, "Packets to the host")]
    {
        let _ = writeln!(text, "## {title}\n");
        for layout in LAYOUTS.iter().filter(|layout| layout.direction == direction) {
            let Some(framing) = layout.framing(version) else { continue };
            let id = match version {
                Version::V3 => framing.id.to_string(),
                Version::V4 => format!("0x{:04x}", framing.id),
            };
            let size = if framing.largest > framing.size {
                format!("{} to {}", framing.size, framing.largest)
            } else {
                framing.size.to_string()
            };
            let meaning = layout.meaning.lines().next().unwrap_or_default().trim();
            let _ = writeln!(text, "### {} (id {id}, {size} bytes)\n\n{meaning}\n", layout.name_in(version));
            text.push_str("| byte | type | field | says | here |\n| --: | --- | --- | --- | --- |\n");
            let mut placed: Vec<_> = layout.placed(version).collect();
            placed.sort_by_key(|(_, _, place, _)| (place.byte, lowest_bit(place.part)));
            for (_, field, place, name) in placed {
                text.push_str(&row(field, name, place.byte, place.part));
            }
            text.push('\n');
        }
    }
    text.push_str(&without_effect(version));
    text.push_str("## Packets that are passed over\n\nThey are skipped by their size and counted.\n\n");
    text.push_str("| id | packet | why |\n| --- | --- | --- |\n");
    for other in others::OTHERS {
        let id = match version {
            Version::V3 => other.v3.map(|id| id.to_string()),
            Version::V4 => other.v4.map(|id| format!("0x{id:04x}")),
        };
        if let Some(id) = id {
            let _ = writeln!(text, "| {id} | {} | {} |", other.name, other.reason);
        }
    }
    let users = match version {
        Version::V3 => "201 to 255, but for ours",
        Version::V4 => "0x1000 to 0xfffe, but for ours",
    };
    let _ = writeln!(text, "| {users} | user-defined | only their owners know what they say |");
    let _ = writeln!(text, "| any other | unknown, or of a later version | skipped, so that the rest still counts |");
    text
}

/// All fields that are accepted and have no effect, by packet and reason.
fn without_effect(version: Version) -> String {
    let mut text = "## Accepted, and without effect\n\n".to_owned();
    text.push_str("Once more in one list. A test changes every field of every packet of the host, alone and in place, and finds that ");
    text.push_str("what is\ndrawn, answered or sent changes with all of them but these.\n\n");
    text.push_str("| packet | fields | why |\n| --- | --- | --- |\n");
    for layout in LAYOUTS.iter().filter(|layout| layout.direction == Direction::HostToIg) {
        let ignored = layout.placed(version).filter_map(|(_, field, _, name)| match field.effect {
            Effect::Ignored(why) => Some((why, name)),
            _ => None,
        });
        let mut by_reason: Vec<(&str, Vec<&str>)> = Vec::new();
        for (why, name) in ignored {
            match by_reason.iter_mut().find(|(reason, _)| *reason == why) {
                Some((_, names)) => names.push(name),
                None => by_reason.push((why, vec![name])),
            }
        }
        for (why, names) in by_reason {
            let _ = writeln!(text, "| {} | `{}` | {why} |", layout.name_in(version), names.join("`, `"));
        }
    }
    text.push('\n');
    text
}

fn lowest_bit(part: Part) -> u8 {
    match part {
        Part::Bits { lowest, .. } => lowest,
        Part::Disputed { bit } => bit,
        _ => 0,
    }
}
