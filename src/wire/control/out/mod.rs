//! What the server says: answers, events and telemetry as JSON texts.

mod answer;
mod event;
mod state;
mod statistics;

pub use answer::{AerosolOut, ConditionsMessage, HeightsMessage, HiderName, SightMessage};
pub use event::EventMessage;
pub use state::{FlashOut, LayerOut, OwnshipOut, Player, RegionOut, SkyOut, StateMessage, ViewOut, WeatherOut};
pub use statistics::{DelayStatistics, Statistics, SubscriptionStatistics, TableStatistics, Telemetry, ViewStatistics};

use super::{Format, PROTOCOL, Role};
use crate::plan::FramePlan;
use crate::world::event::Refused;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A message of the server. `seq` is the number of the client's message that it answers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Outbound {
    /// Answers `hello`.
    Welcome(Welcome),
    /// A message was carried out.
    Ack(Ack),
    /// A message was refused; nothing has changed.
    Refused(Refusal),
    /// Something happened.
    Event(EventMessage),
    /// Answers `query` for the state.
    State(Box<StateMessage>),
    /// Answers `query` for a plan.
    Plan(PlanMessage),
    /// Answers `query` for statistics.
    Statistics(Statistics),
    /// Answers `query` for heights.
    Heights(HeightsMessage),
    /// Answers `query` for a line of sight, segment or vector.
    LineOfSight(SightMessage),
    /// Answers `query` for the weather at a point.
    Conditions(ConditionsMessage),
    /// A lockstep step is done: every subscriber's copy of its frames has been written.
    Stepped(Stepped),
    /// Told about once a second to every client that subscribed to anything.
    Telemetry(Telemetry),
}

/// Answers `hello`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Welcome {
    /// Number of the `hello`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seq: Option<u64>,
    /// Protocol spoken: `stormdeck.v1`.
    pub protocol: String,
    /// Version of the server.
    pub server: String,
    /// Number of this client.
    pub client: u64,
    /// Role given.
    pub role: Role,
    /// Executor and adapter that draw.
    pub executor: String,
    /// Frames a second that the server aims at while running free.
    pub frame_rate_hz: f64,
    /// Names of the views.
    pub views: Vec<String>,
}

impl Welcome {
    /// A welcome with this protocol and this version of the server.
    pub fn new(
        seq: Option<u64>,
        client: u64,
        role: Role,
        executor: &str,
        frame_rate_hz: f64,
        views: Vec<String>,
    ) -> Self {
        let (protocol, server) = (PROTOCOL.to_owned(), env!("CARGO_PKG_VERSION").to_owned());
        Self { seq, protocol, server, client, role, executor: executor.to_owned(), frame_rate_hz, views }
    }
}

/// A message was carried out.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Ack {
    /// Number of the message.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seq: Option<u64>,
    /// Number given to the flash, when the message was a `strike`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flash: Option<u64>,
}

/// A message was refused.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Refusal {
    /// Number of the message, where it could be read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seq: Option<u64>,
    /// Path of the field, as in `layers[2].base_m`.
    pub field: String,
    /// The value given, shortened if long.
    pub value: String,
    /// What is allowed.
    pub limit: String,
    /// The reason in words.
    pub why: String,
    /// Refusals that were not sent since the one before, because too many came in a second.
    #[serde(default)]
    pub unsent: u64,
}

impl Refusal {
    /// The message for a refusal.
    pub fn new(seq: Option<u64>, refused: Refused, unsent: u64) -> Self {
        let Refused { field, value, limit, why } = refused;
        Self { seq, field, value, limit, why, unsent }
    }
}

/// The plan of a view's frame, one line a pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PlanMessage {
    /// Number of the `query`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seq: Option<u64>,
    /// The view's name.
    pub view: String,
    /// Width of the picture.
    pub width_px: u32,
    /// Height of the picture.
    pub height_px: u32,
    /// The passes in order.
    pub passes: Vec<PassOut>,
}

/// One pass of a plan.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct PassOut {
    /// Name of the pass.
    pub pass: String,
    /// Whether it runs.
    pub kept: bool,
    /// The sentence that explains it.
    pub why: String,
}

impl PlanMessage {
    /// The message for a plan.
    pub fn new(seq: Option<u64>, view: &str, plan: &FramePlan) -> Self {
        let pass = |note: &crate::plan::PassNote| PassOut {
            pass: note.pass.to_owned(),
            kept: note.kept,
            why: note.why.clone(),
        };
        let [width_px, height_px] = plan.size_px;
        Self { seq, view: view.to_owned(), width_px, height_px, passes: plan.notes.iter().map(pass).collect() }
    }
}

/// A lockstep step is done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Stepped {
    /// Number of the `step`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seq: Option<u64>,
    /// Simulation time reached.
    pub simulation_time_s: f64,
    /// The frame of each view, by name.
    pub frames: Vec<SteppedFrame>,
}

/// One frame of a lockstep step.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct SteppedFrame {
    /// The view's name.
    pub view: String,
    /// Number of the frame.
    pub frame: u64,
    /// Formats in which it was sent, and to how many clients in all.
    pub formats: Vec<Format>,
    /// Copies written.
    pub copies: u32,
}

#[cfg(test)]
mod tests;
