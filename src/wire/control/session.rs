//! `hello`, `subscribe`, `unsubscribe`, `step` and `query`: what a client says about itself and asks for.

use super::question::{PointJson, SegmentQuery, VectorQuery};
use super::{Hello, PROTOCOL, Query, Subscription};
use crate::wire::limits;
use crate::world::event::Refused;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Introduces the client: the first message of a connection.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HelloMessage {
    /// Version of the protocol that the client speaks: `stormdeck.v1`.
    #[schemars(length(min = 1, max = limits::NAME_LENGTH.max))]
    pub protocol: String,
    /// Role wanted.
    pub role: Role,
    /// Name for the log, and for those who are refused because it holds the host role.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = limits::NAME_LENGTH.min, max = limits::NAME_LENGTH.max))]
    pub name: Option<String>,
    /// Takes the host role from its holder, where the server's settings allow it.
    #[serde(default)]
    pub take_over: bool,
    /// Access token, where the server wants one and it was not in the HTTP request.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = limits::TOKEN_LENGTH.max))]
    pub token: Option<String>,
}

/// What a client may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// May change the world; one client at a time.
    Host,
    /// May look and ask.
    Watcher,
}

/// Asks for the frames of a view; replaces an earlier subscription to it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SubscribeMessage {
    /// The view's name.
    #[schemars(length(min = limits::NAME_LENGTH.min, max = limits::NAME_LENGTH.max), regex(pattern = limits::NAME_PATTERN))]
    pub view: String,
    /// Format of the pictures.
    pub format: Format,
    /// At most so many frames a second.
    #[serde(default = "full_rate_hz")]
    #[schemars(range(min = limits::FRAME_RATE_HZ.min, max = limits::FRAME_RATE_HZ.max))]
    pub max_rate_hz: f64,
    /// Quality of the JPEG; without it the server's setting.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::JPEG_QUALITY.min, max = limits::JPEG_QUALITY.max))]
    pub quality: Option<u8>,
    /// What happens when the client reads too slowly.
    #[serde(default)]
    pub when_slow: WhenSlow,
}

/// Format of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Format {
    /// `width * height * 4` bytes RGBA (sRGB-encoded), top row first.
    Raw,
    /// PNG.
    Png,
    /// JPEG.
    Jpeg,
}

/// What happens when a client's queue of frames is full. Lockstep frames are never dropped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WhenSlow {
    /// The oldest waiting frame makes place for the new one.
    #[default]
    DropOldest,
    /// The new frame is dropped.
    DropNewest,
    /// The connection is closed.
    Disconnect,
}

/// Ends the subscription to a view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UnsubscribeMessage {
    /// The view's name.
    #[schemars(length(min = limits::NAME_LENGTH.min, max = limits::NAME_LENGTH.max), regex(pattern = limits::NAME_PATTERN))]
    pub view: String,
}

/// Lockstep: advances to a simulation time and renders exactly one frame of each view. Only the host may send it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StepMessage {
    /// Simulation time to go to; not before the present one.
    #[schemars(range(min = limits::SIMULATION_TIME_S.min, max = limits::SIMULATION_TIME_S.max))]
    pub to_s: f64,
}

/// Asks without changing anything.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "what", rename_all = "snake_case")]
pub enum QueryMessage {
    /// The state of the world.
    State(Nothing),
    /// The plan of a view's next frame.
    Plan(PlanQuery),
    /// Counters and rates of the server.
    Statistics(Nothing),
    /// Height above the ground, and of the ground, at a point.
    Heights(PointJson),
    /// What hides one point from another.
    LineOfSightSegment(SegmentQuery),
    /// What a ray meets first.
    LineOfSightVector(VectorQuery),
    /// The weather at a point.
    Conditions(PointJson),
}

/// No more fields.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Nothing {}

/// Of which view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanQuery {
    /// The view's name.
    #[schemars(length(min = limits::NAME_LENGTH.min, max = limits::NAME_LENGTH.max), regex(pattern = limits::NAME_PATTERN))]
    pub view: String,
}

fn full_rate_hz() -> f64 {
    limits::FRAME_RATE_HZ.max
}

impl TryFrom<HelloMessage> for Hello {
    type Error = Refused;

    fn try_from(message: HelloMessage) -> Result<Self, Refused> {
        if message.protocol != PROTOCOL {
            return Err(Refused::new("protocol", message.protocol, PROTOCOL, "this server speaks no other protocol"));
        }
        let HelloMessage { role, name, take_over, token, .. } = message;
        Ok(Self { role, name, take_over, token })
    }
}

impl From<&Hello> for HelloMessage {
    fn from(hello: &Hello) -> Self {
        let Hello { role, name, take_over, token } = hello.clone();
        Self { protocol: PROTOCOL.to_owned(), role, name, take_over, token }
    }
}

impl TryFrom<SubscribeMessage> for Subscription {
    type Error = Refused;

    fn try_from(message: SubscribeMessage) -> Result<Self, Refused> {
        let SubscribeMessage { view, format, max_rate_hz, quality, when_slow } = message;
        match quality {
            Some(quality) if format != Format::Jpeg => {
                Err(Refused::new("quality", quality, "only with format jpeg", "the other formats lose nothing"))
            }
            _ => Ok(Self { view, format, max_rate_hz, quality, when_slow }),
        }
    }
}

impl From<&Subscription> for SubscribeMessage {
    fn from(subscription: &Subscription) -> Self {
        let Subscription { view, format, max_rate_hz, quality, when_slow } = subscription.clone();
        Self { view, format, max_rate_hz, quality, when_slow }
    }
}

impl From<QueryMessage> for Query {
    fn from(message: QueryMessage) -> Self {
        match message {
            QueryMessage::State(Nothing {}) => Self::State,
            QueryMessage::Plan(PlanQuery { view }) => Self::Plan { view },
            QueryMessage::Statistics(Nothing {}) => Self::Statistics,
            QueryMessage::Heights(point) => Self::Heights(point),
            QueryMessage::LineOfSightSegment(line) => Self::LineOfSightSegment(line),
            QueryMessage::LineOfSightVector(ray) => Self::LineOfSightVector(ray),
            QueryMessage::Conditions(point) => Self::Conditions(point),
        }
    }
}

impl From<&Query> for QueryMessage {
    fn from(query: &Query) -> Self {
        match query {
            Query::State => Self::State(Nothing {}),
            Query::Plan { view } => Self::Plan(PlanQuery { view: view.clone() }),
            Query::Statistics => Self::Statistics(Nothing {}),
            Query::Heights(point) => Self::Heights(*point),
            Query::LineOfSightSegment(line) => Self::LineOfSightSegment(*line),
            Query::LineOfSightVector(ray) => Self::LineOfSightVector(*ray),
            Query::Conditions(point) => Self::Conditions(*point),
        }
    }
}
