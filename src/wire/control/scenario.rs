//! `scenario`: load, play, pause, seek and speed.

use super::Message;
use super::session::Nothing;
use crate::wire::limits;
use crate::wire::scenario::{self, Document};
use crate::world::command::{Command, ScenarioEdit};
use crate::world::event::Refused;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Works the scenario player. Only the host may send it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "action", rename_all = "snake_case")]
pub enum ScenarioMessage {
    /// Replaces the world by a scenario's start and plays it. Give `name` or `document`, not both.
    Load(LoadFields),
    /// Lets the time run.
    Play(Nothing),
    /// Stops the time.
    Pause(Nothing),
    /// Goes to a simulation time, forwards or backwards.
    Seek(SeekFields),
    /// Seconds of simulation per second of wall clock.
    Speed(SpeedFields),
}

/// Which scenario.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LoadFields {
    /// Name of a file in the server's folder of scenarios, without `.json`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = limits::SCENARIO_NAME_LENGTH.min, max = limits::SCENARIO_NAME_LENGTH.max), regex(pattern = limits::SCENARIO_NAME_PATTERN))]
    pub name: Option<String>,
    /// The scenario itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub document: Option<Document>,
}

/// Where to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SeekFields {
    /// Simulation time.
    #[schemars(range(min = limits::SIMULATION_TIME_S.min, max = limits::SIMULATION_TIME_S.max))]
    pub at_s: f64,
}

/// How fast.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpeedFields {
    /// Seconds of simulation per second of wall clock.
    #[schemars(range(min = limits::SPEED.min, max = limits::SPEED.max))]
    pub factor: f64,
}

impl TryFrom<ScenarioMessage> for Message {
    type Error = Refused;

    fn try_from(message: ScenarioMessage) -> Result<Self, Refused> {
        let edit = match message {
            ScenarioMessage::Load(LoadFields { name: Some(name), document: None }) => {
                return Ok(Self::LoadScenario { name });
            }
            ScenarioMessage::Load(LoadFields { name: None, document: Some(document) }) => {
                let timeline = scenario::timeline(document).map_err(|refused| {
                    let field = format!("document.{}", refused.field);
                    Refused { field, ..refused }
                })?;
                ScenarioEdit::Load(Arc::new(timeline))
            }
            ScenarioMessage::Load(LoadFields { name, .. }) => {
                let value = if name.is_some() { "given twice" } else { "not given" };
                return Err(Refused::new("name", value, "name or document", "a scenario is loaded by one of the two"));
            }
            ScenarioMessage::Play(Nothing {}) => ScenarioEdit::Play,
            ScenarioMessage::Pause(Nothing {}) => ScenarioEdit::Pause,
            ScenarioMessage::Seek(SeekFields { at_s }) => ScenarioEdit::Seek { at_s },
            ScenarioMessage::Speed(SpeedFields { factor }) => ScenarioEdit::Speed { factor },
        };
        Ok(Self::Command(Command::Scenario(edit)))
    }
}

impl From<&ScenarioEdit> for ScenarioMessage {
    fn from(edit: &ScenarioEdit) -> Self {
        match edit {
            ScenarioEdit::Load(timeline) => {
                Self::Load(LoadFields { name: None, document: Some(scenario::document(timeline)) })
            }
            ScenarioEdit::Play => Self::Play(Nothing {}),
            ScenarioEdit::Pause => Self::Pause(Nothing {}),
            ScenarioEdit::Seek { at_s } => Self::Seek(SeekFields { at_s: *at_s }),
            ScenarioEdit::Speed { factor } => Self::Speed(SpeedFields { factor: *factor }),
        }
    }
}
