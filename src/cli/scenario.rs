//! Scenarios by file or by the name of a built-in one, with everything that is wrong with them.

use super::Failure;
use crate::settings::{self, BUILT_IN_SCENARIOS, built_in};
use crate::wire::{limits, scenario};
use crate::world::timeline::Timeline;
use std::path::Path;

/// The scenario called `name`: a built-in one, or else a file.
///
/// # Errors
/// [`Failure::Input`] with every complaint, each with its line.
pub(super) fn read(name: &str) -> Result<Timeline, Failure> {
    if let Some(text) = built_in(name) {
        return timeline(text).map_err(|complaints| Failure::Input(listed(name, &complaints)));
    }
    if !Path::new(name).exists() && !name.contains(['/', '.']) {
        let known: Vec<&str> = BUILT_IN_SCENARIOS.iter().map(|(name, _)| *name).collect();
        let message = format!("no scenario `{name}`: neither a file nor one of {}", known.join(", "));
        return Err(Failure::Input(message));
    }
    let text = text_of(Path::new(name), limits::SCENARIO_BYTES)?;
    timeline(&text).map_err(|complaints| Failure::Input(listed(name, &complaints)))
}

/// The timeline of a scenario's text, or everything that is wrong with it.
pub(super) fn timeline(text: &str) -> Result<Timeline, Vec<String>> {
    scenario::parse(text).map_err(|complaints| complaints.iter().map(ToString::to_string).collect())
}

/// Complaints about one file, one a line.
pub(super) fn listed(name: &str, complaints: &[String]) -> String {
    let lines: Vec<String> = complaints.iter().map(|complaint| format!("{name}: {complaint}")).collect();
    lines.join("\n")
}

/// The text of a file of at most `most` bytes.
///
/// # Errors
/// [`Failure::Input`]: not readable, too long, or not UTF-8.
pub(super) fn text_of(path: &Path, most: usize) -> Result<String, Failure> {
    settings::text_of(path, most).map_err(|why| Failure::Input(format!("{}: {why}", path.display())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_built_in_scenario_is_right_and_is_a_file_of_config() {
        for (name, text) in BUILT_IN_SCENARIOS {
            assert_eq!(timeline(text).map(|t| t.entries.is_empty()), Ok(false), "{name}");
        }
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/scenarios");
        let files = std::fs::read_dir(folder).expect("the scenarios").count();
        assert_eq!(files, BUILT_IN_SCENARIOS.len(), "a scenario of config/scenarios is not built in");
    }

    #[test]
    fn an_endless_or_binary_file_is_refused() {
        assert!(text_of(Path::new("/dev/zero"), 1000).is_err());
        assert!(text_of(Path::new(env!("CARGO_MANIFEST_DIR")), 1000).is_err(), "a folder");
    }
}
