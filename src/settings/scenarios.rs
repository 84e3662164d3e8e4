//! Scenarios by name: files of the folder in the settings, and those that the binary carries.

use super::Settings;
use crate::wire::{limits, scenario};
use crate::world::event::Refused;
use crate::world::timeline::Timeline;
use std::io::Read;

/// The scenarios inside the binary by name: those of `config/scenarios`.
pub const BUILT_IN_SCENARIOS: &[(&str, &str)] = &[
    ("broken-noon-cumulus", include_str!("../../config/scenarios/broken-noon-cumulus.json")),
    ("clear-day", include_str!("../../config/scenarios/clear-day.json")),
    ("night-storm", include_str!("../../config/scenarios/night-storm.json")),
    ("overcast-night-cities", include_str!("../../config/scenarios/overcast-night-cities.json")),
    ("scattered-sunset", include_str!("../../config/scenarios/scattered-sunset.json")),
];

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
        let mut text = String::new();
        match std::fs::File::open(&path) {
            Ok(file) => {
                // One byte more than allowed tells a file that is too long, however long it is.
                let most = limits::SCENARIO_BYTES as u64 + 1;
                file.take(most)
                    .read_to_string(&mut text)
                    .map_err(|error| refused(format!("{} cannot be read: {error}", path.display())))?;
            }
            Err(error) => match BUILT_IN_SCENARIOS.iter().find(|(known, _)| *known == name) {
                Some((_, built_in)) => text.push_str(built_in),
                None => return Err(refused(format!("{} cannot be opened: {error}", path.display()))),
            },
        }
        scenario::parse(&text).map_err(|complaints| {
            let first = complaints.first().map(ToString::to_string).unwrap_or_default();
            refused(format!("{} complaints (stormdeck check lists all), the first: {first}", complaints.len()))
        })
    }
}
