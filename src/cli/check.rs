//! `stormdeck check`: what is wrong with settings and scenario files, all of it, with line and path.

use super::Failure;
use super::scenario::{listed, text_of, timeline};
use crate::settings::Settings;
use crate::wire::json::{self, Kind, Node, Size};
use crate::wire::limits;
use std::path::{Path, PathBuf};

/// Checks settings and scenario files and tells everything that is wrong with them, with line and path.
#[derive(Debug, clap::Args)]
pub(super) struct Options {
    /// Settings or scenario files (JSON).
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
}

/// Checks every file; one that is wrong does not keep the others from being checked.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let mut wrong = Vec::new();
    for path in &options.files {
        match check(path) {
            Ok(what) => println!("{}: {what}", path.display()),
            Err(Failure::Input(complaints) | Failure::Run(complaints)) => wrong.push(complaints),
        }
    }
    if wrong.is_empty() { Ok(()) } else { Err(Failure::Input(format!("not right:\n{}", wrong.join("\n")))) }
}

/// What a file is, in a few words, when it is right.
fn check(path: &Path) -> Result<String, Failure> {
    let name = path.display().to_string();
    let text = text_of(path, limits::SCENARIO_BYTES)?;
    let complaints = match is_scenario(&text) {
        true => match timeline(&text) {
            Ok(t) => {
                return Ok(format!("scenario \"{}\", {} entries, {} s", t.name, t.entries.len(), t.duration_s));
            }
            Err(complaints) => complaints,
        },
        false => match Settings::parse(&text) {
            Ok(settings) => match settings.ground() {
                Ok(_) => return Ok("settings".to_owned()),
                Err(wrong) => vec![format!("terrain_file: {wrong}")],
            },
            Err(complaints) => complaints.iter().map(ToString::to_string).collect(),
        },
    };
    Err(Failure::Input(listed(&name, &complaints)))
}

/// A scenario says so by its type, or at least has entries; everything else is checked as settings. Read by our own reader,
/// to which a wrong number is a complaint and not the end; what is no JSON at all is the same complaint either way.
fn is_scenario(text: &str) -> bool {
    let size = Size { bytes: limits::SCENARIO_BYTES, values: limits::SCENARIO_VALUES };
    let Ok(parsed) = json::parse(text, size) else { return true };
    let says_so = |node: &Node| matches!(&node.kind, Kind::Text(word) if word == "scenario");
    parsed.root.member("type").is_some_and(says_so) || parsed.root.member("entries").is_some()
}
