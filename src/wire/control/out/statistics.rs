//! Statistics and telemetry: counters and rates in plain numbers.

use super::super::Format;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Counters and rates of the whole server.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Statistics {
    /// Number of the `query`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seq: Option<u64>,
    /// Seconds since the server started.
    pub uptime_s: f64,
    /// Executor and adapter that draw.
    pub executor: String,
    /// Clients connected.
    pub clients: u32,
    /// Number of the client that holds the host role.
    pub host: Option<u64>,
    /// Control messages received.
    pub messages: u64,
    /// Control messages refused.
    pub refused: u64,
    /// Faults of the server's own.
    pub faults: u64,
    /// Each view.
    pub views: Vec<ViewStatistics>,
    /// Each subscription.
    pub subscriptions: Vec<SubscriptionStatistics>,
}

/// What a client is told about once a second.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Telemetry {
    /// Simulation time.
    pub simulation_time_s: f64,
    /// Each view.
    pub views: Vec<ViewStatistics>,
    /// This client's own subscriptions.
    pub subscriptions: Vec<SubscriptionStatistics>,
    /// The tables by which flashes light clouds; absent while there are none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tables: Option<TableStatistics>,
}

/// How far the tables are by which flashes light clouds (`relight` `basis` and `hybrid`).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TableStatistics {
    /// Virtual lights that are there.
    pub lights: u64,
    /// Virtual lights that there will be when all are baked.
    pub of: u64,
    /// Whether some are being baked now.
    pub baking: bool,
    /// Virtual lights that were read from the cache and not baked.
    pub read: u64,
}

/// Counters of one view.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ViewStatistics {
    /// The view's name.
    pub view: String,
    /// Frames so far, repeated ones included.
    pub frames: u64,
    /// Frames that were repeated because nothing had changed.
    pub repeated: u64,
    /// Frames in the last second.
    pub rate_hz: f64,
    /// From a host message to the finished picture of the frames of the last seconds; absent without host messages.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub delay: Option<DelayStatistics>,
}

/// Spread of a delay.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DelayStatistics {
    /// Half of the frames were faster.
    pub median_ms: f64,
    /// 99 of 100 frames were faster.
    pub p99_ms: f64,
    /// Frames counted.
    pub frames: u32,
}

/// Counters of one subscription.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SubscriptionStatistics {
    /// Number of the client.
    pub client: u64,
    /// The view's name.
    pub view: String,
    /// Format of its pictures.
    pub format: Format,
    /// Frames written to the socket.
    pub sent: u64,
    /// Frames dropped because the client read too slowly.
    pub dropped: u64,
}
