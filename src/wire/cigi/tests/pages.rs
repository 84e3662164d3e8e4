//! The docs say what the tables say: bit diagrams beside the types, and the pages under `protocol/`.
//!
//! `UPDATE_CIGI=1` writes both from the tables.

use super::super::describe::{diagram, tables};
use super::*;
use std::path::{Path, PathBuf};

const FILES: [&str; 9] = ["component", "entity", "frame", "request", "response", "sky", "strike", "view", "weather"];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn updating() -> bool {
    std::env::var_os("UPDATE_CIGI").is_some()
}

/// What stands in the docs of a type below its first sentence.
fn block(layout: &Layout) -> String {
    let drawn = Version::ALL.map(|version| diagram(layout, version));
    let drawn: Vec<&str> = drawn.iter().map(|text| text.trim_end()).filter(|text| !text.is_empty()).collect();
    format!("```text\n{}\n```", drawn.join("\n\n"))
}

#[test]
fn bit_diagrams_show_the_places() {
    if updating() {
        for file in FILES {
            update(&root().join("src/wire/cigi/packets").join(file).with_extension("rs"));
        }
        return;
    }
    for layout in LAYOUTS {
        let says: Vec<&str> = layout.meaning.lines().map(|line| line.strip_prefix(' ').unwrap_or(line)).collect();
        let (says, block) = (says.join("\n"), block(layout));
        assert!(says.contains(&block), "{}: the diagram must be\n{block}\nand is\n{says}", layout.type_name);
    }
}

/// Writes the diagrams of one file anew.
fn update(path: &Path) {
    let text = std::fs::read_to_string(path).expect("a source file");
    let (mut written, mut docs) = (Vec::new(), Vec::new());
    for line in text.lines() {
        if line.starts_with("    ///") {
            docs.push(line);
            continue;
        }
        if let Some(first) = docs.first().copied() {
            let name = line.split_whitespace().next().unwrap_or_default();
            let layout = LAYOUTS.iter().find(|layout| layout.type_name == name).expect("docs stand before a packet");
            written.push(first.to_owned());
            written.push("    ///".to_owned());
            written.extend(block(layout).lines().map(|line| format!("    /// {line}").trim_end().to_owned()));
            docs.clear();
        }
        written.push(line.to_owned());
    }
    std::fs::write(path, written.join("\n") + "\n").expect("a writable file");
}

#[test]
fn the_pages_have_every_packet_and_field() {
    const MARK: &str =
        "<!-- From here on made from src/wire/cigi/packets by UPDATE_CIGI=1 cargo test --lib cigi -->\n\n";
    for version in Version::ALL {
        let path = root().join(format!("protocol/cigi-{}.md", version.name()));
        let page = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let (text, tables_there) = page.split_once(MARK).expect("the mark that divides the page");
        if updating() {
            std::fs::write(&path, format!("{text}{MARK}{}", tables(version))).expect("a writable page");
            continue;
        }
        let tables = tables(version);
        assert!(tables_there == tables, "{}: UPDATE_CIGI=1 cargo test --lib cigi", path.display());
    }
}

#[test]
fn a_diagram_for_example() {
    let layout = LAYOUTS.iter().find(|layout| layout.type_name == "HatHotRequest").expect("a packet");
    let drawn = diagram(layout, Version::V3);
    assert_eq!(drawn.lines().count(), 1 + 32 / 4 + 1, "{drawn}");
    assert!(drawn.contains("| . . . . . b a a  |"), "bits from the most significant: {drawn}");
    assert!(drawn.contains("a request_type, b coordinate_system"));
    assert_eq!(diagram(layout, Version::V4).lines().count(), 1 + 40 / 4 + 1);
}
