//! Who may import whom, and who may name which outside crate. Code under `#[cfg(test)]` is subject to the same walls.

use super::files::Source;
use super::paths::{Named, module_of, named};
use std::collections::{BTreeMap, BTreeSet};

/// The groups from the ground up. A group may import those of earlier rows, and those of its own row without circles.
const ROWS: &[&[&str]] = &[
    &["units", "bytes", "frame", "geo", "numeric"],
    &["clouds", "lightning", "scattering"],
    &["passes"],
    &["world"],
    &["plan", "outputs", "wire"],
    &["gpu", "reference", "encode"],
    &["settings"],
    &["serve"],
    &["report"],
    &["cli"],
];

/// Outside crates that only these groups may name.
const CRATES: &[(&[&str], &[&str])] = &[
    (&["wgpu", "naga"], &["gpu"]),
    (&["tokio", "tokio_util", "axum", "tungstenite", "tokio_tungstenite"], &["serve"]),
    (&["serde", "serde_json", "schemars"], &["wire", "settings", "report", "cli"]),
    (&["clap"], &["cli"]),
];

/// Paths that some groups must not name, and why.
const FORBIDDEN: &[(&[&str], &[&str], &str)] = &[
    (&["clouds", "lightning", "scattering", "numeric", "geo"], &["std", "time"], "it knows no clock"),
    (&["plan", "outputs"], &["crate", "world", "World"], "it reads a Snapshot, never the World"),
];

/// The name by which `main.rs` and tests reach the library.
const LIBRARY: &str = "stormdeck";

/// Every edge and name that the walls forbid.
pub fn complaints(sources: &[Source]) -> Vec<String> {
    let mut complaints = Vec::new();
    let mut edges: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for source in sources.iter().filter(|s| s.path.ends_with(".rs")) {
        let group = group_of(&source.path);
        if group == "lib" {
            complaints.extend(
                named(source)
                    .iter()
                    .map(|n| format!("{}:{}: lib.rs declares modules and re-exports nothing", source.path, n.line)),
            );
            continue;
        }
        let Some(row) = row_of(&group) else {
            complaints.push(format!(
                "{}: group `{group}` has no place in the order of tests/architecture/walls.rs",
                source.path
            ));
            continue;
        };
        for name in named(source) {
            if let Some(why) = refused(&group, &name) {
                complaints.push(format!("{}:{}: `{}`: {why}", source.path, name.line, name.segments.join("::")));
            }
            let Some(target) = target(&name).filter(|t| *t != group) else { continue };
            match row_of(target) {
                Some(other) if other > row => complaints.push(format!(
                    "{}:{}: `{group}` must not import `{target}`, which stands to its right",
                    source.path, name.line
                )),
                Some(other) if other == row => {
                    edges.entry(group.clone()).or_default().insert(target.to_owned());
                }
                _ => {}
            }
        }
    }
    complaints.extend(circles(&edges));
    complaints
}

/// The group of a file: its first folder, or its name at the top; `main.rs` belongs to the command line.
fn group_of(path: &str) -> String {
    match path {
        "src/lib.rs" => "lib".to_owned(),
        "src/main.rs" => "cli".to_owned(),
        _ => module_of(path).into_iter().next().unwrap_or_default(),
    }
}

fn row_of(group: &str) -> Option<usize> {
    ROWS.iter().position(|row| row.contains(&group))
}

/// The group that a path leads to.
fn target(name: &Named) -> Option<&str> {
    let inside = matches!(name.segments.first().map(String::as_str), Some("crate" | LIBRARY));
    name.segments.get(1).filter(|_| inside).map(String::as_str)
}

fn refused(group: &str, name: &Named) -> Option<String> {
    let first = name.segments.first()?;
    for (crates, owners) in CRATES {
        if crates.contains(&first.as_str()) && !owners.contains(&group) {
            return Some(format!("only {} may name {first}", owners.join(", ")));
        }
    }
    if target(name) == Some("*") {
        return Some("a glob of the crate root hides what is imported".to_owned());
    }
    FORBIDDEN
        .iter()
        .find(|(groups, path, _)| groups.contains(&group) && name.segments.starts_with(&path.map_owned()))
        .map(|(_, _, why)| format!("`{group}`: {why}"))
}

/// `&["a"]` as owned strings, to compare with segments.
trait MapOwned {
    fn map_owned(&self) -> Vec<String>;
}

impl MapOwned for &[&str] {
    fn map_owned(&self) -> Vec<String> {
        self.iter().map(|s| (*s).to_owned()).collect()
    }
}

/// Groups of one row that import each other in a circle.
fn circles(edges: &BTreeMap<String, BTreeSet<String>>) -> Vec<String> {
    let reaches_itself = |start: &String| {
        let mut seen = BTreeSet::new();
        let mut open = vec![start];
        while let Some(group) = open.pop() {
            for next in edges.get(group).into_iter().flatten() {
                if next == start {
                    return true;
                }
                if seen.insert(next) {
                    open.push(next);
                }
            }
        }
        false
    };
    edges.keys().filter(|g| reaches_itself(g)).map(|g| format!("`{g}` imports itself in a circle")).collect()
}

/// The complaints about one made-up file.
#[cfg(test)]
fn about(path: &str, text: &str) -> Vec<String> {
    complaints(&[Source::new(path, text)])
}

#[test]
fn a_forbidden_edge_is_found_however_it_is_written() {
    for (path, text) in [
        ("src/clouds/mod.rs", "use crate::gpu::Ring;"),
        ("src/clouds/mod.rs", "use crate::{geo::Geodetic, world::{snapshot::Snapshot}};"),
        ("src/clouds/deep/er.rs", "use super::super::super::plan::FramePlan;"),
        ("src/world/mod.rs", "fn f() { let x = crate::wire::decode(); }"),
        ("src/world/mod.rs", "#[cfg(test)]\nmod tests { use crate::serve::run; }"),
        ("src/units.rs", "use crate::clouds::CloudKind;"),
        ("src/gpu/mod.rs", "use crate::settings::Settings;"),
        ("src/serve/mod.rs", "pub(in crate) fn f(r: crate::report::Report) {}"),
    ] {
        let found = about(path, text);
        assert!(found.len() == 1 && found[0].contains("to its right"), "{path}: {text}: {found:?}");
    }
    assert_eq!(about("src/cli/mod.rs", "use crate::{geo::Geodetic, serve::run, report::*};"), Vec::<String>::new());
    assert_eq!(about("src/main.rs", "use stormdeck::cli::main;"), Vec::<String>::new());
}

#[test]
fn a_crate_named_by_the_wrong_group_is_found() {
    for (path, text) in [
        ("src/plan/mod.rs", "use wgpu::Limits;"),
        ("src/plan/mod.rs", "fn f() -> ::wgpu::Limits { todo!() }"),
        ("src/encode/mod.rs", "#[tokio::main] fn f() {}"),
        ("src/cli/host.rs", "use tokio_tungstenite::connect_async;"),
        ("src/world/mod.rs", "#[derive(serde::Serialize)] struct A;"),
        ("src/serve/page.rs", "use serde_json::json;"),
        ("src/serve/mod.rs", "#[cfg(test)] mod tests { use serde_json as j; }"),
        ("src/clouds/mod.rs", "use std::{fmt, time::Instant};"),
        ("src/plan/mod.rs", "use crate::world::{World, snapshot::Snapshot};"),
        ("src/cli/mod.rs", "use crate::*;"),
    ] {
        assert_eq!(about(path, text).len(), 1, "{path}: {text}: {:?}", about(path, text));
    }
    assert_eq!(about("src/gpu/mod.rs", "use wgpu::Limits;"), Vec::<String>::new());
    assert_eq!(about("src/plan/mod.rs", "//! wgpu::Limits\nconst A: &str = \"wgpu::Limits\";"), Vec::<String>::new());
}

#[test]
fn circles_unknown_groups_and_re_exports_are_found() {
    let a = Source::new("src/geo/mod.rs", "use crate::numeric::A;");
    let b = Source::new("src/numeric/mod.rs", "use crate::geo::B;");
    assert_eq!(complaints(&[a, b]).len(), 2);
    assert_eq!(about("src/geo/mod.rs", "use crate::numeric::A;"), Vec::<String>::new());
    assert!(about("src/misc/mod.rs", "")[0].contains("no place"));
    assert_eq!(about("src/lib.rs", "pub mod a;\npub use gpu::Ring;").len(), 1);
}
