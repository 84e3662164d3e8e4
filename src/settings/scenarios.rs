//! Scenarios by name: files of the folder in the settings, and those that the binary carries; files read within a bound.

use super::Settings;
use crate::wire::{limits, scenario};
use crate::world::event::Refused;
use crate::world::timeline::Timeline;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The scenarios inside the binary by name: those of `config/scenarios`.
pub const BUILT_IN_SCENARIOS: &[(&str, &str)] = &[
    ("broken-noon-cumulus", include_str!("../../config/scenarios/broken-noon-cumulus.json")),
    ("clear-day", include_str!("../../config/scenarios/clear-day.json")),
    ("night-storm", include_str!("../../config/scenarios/night-storm.json")),
    ("overcast-night-cities", include_str!("../../config/scenarios/overcast-night-cities.json")),
    ("scattered-sunset", include_str!("../../config/scenarios/scattered-sunset.json")),
    ("storm-cell", include_str!("../../config/scenarios/storm-cell.json")),
];

/// The text of the scenario inside the binary with this name.
pub fn built_in(name: &str) -> Option<&'static str> {
    BUILT_IN_SCENARIOS.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

/// The text of a file of at most `most` bytes.
///
/// # Errors
/// The reason in words: not readable, too long, or not UTF-8.
pub fn text_of(path: &Path, most: usize) -> Result<String, String> {
    let unreadable = |error: std::io::Error| format!("cannot be read: {error}");
    let file = File::open(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    // One byte more than allowed tells a file that is too long, however long it is (or never ends).
    file.take(most as u64 + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() > most {
        return Err(format!("longer than {most} bytes"));
    }
    String::from_utf8(bytes).map_err(|error| format!("not UTF-8 from byte {}", error.utf8_error().valid_up_to()))
}

impl Settings {
    /// The scenario of this name: a file of the folder, or one inside the binary where the folder has none.
    ///
    /// # Errors
    /// There is none, it cannot be read, or something is wrong with it.
    pub fn timeline(&self, name: &str) -> Result<Timeline, Refused> {
        let limit = "a scenario of the folder or of the program";
        let refused = |why: String| Refused::new("name", name, limit, why);
        if name.is_empty() || !name.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-') {
            return Err(refused("a name has small letters, digits and - alone".into()));
        }
        let path = self.scenario_folder.join(format!("{name}.json"));
        let text = match built_in(name).filter(|_| !path.exists()) {
            Some(text) => text.to_owned(),
            None => {
                text_of(&path, limits::SCENARIO_BYTES).map_err(|why| refused(format!("{} {why}", path.display())))?
            }
        };
        scenario::parse(&text).map_err(|complaints| {
            let first = complaints.first().map(ToString::to_string).unwrap_or_default();
            refused(format!("{} complaints (stormdeck check lists all), the first: {first}", complaints.len()))
        })
    }
}
