//! `ownship`: where the ownship is.

use crate::wire::limits;
use crate::world::command::Ownship;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Position, attitude and motion of the ownship. Only the host may send it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OwnshipMessage {
    /// WGS84 geodetic latitude.
    #[schemars(range(min = limits::LATITUDE_DEG.min, max = limits::LATITUDE_DEG.max))]
    pub latitude_deg: f64,
    /// WGS84 longitude.
    #[schemars(range(min = limits::LONGITUDE_DEG.min, max = limits::LONGITUDE_DEG.max))]
    pub longitude_deg: f64,
    /// Height above the WGS84 ellipsoid.
    #[schemars(range(min = limits::ALTITUDE_M.min, max = limits::ALTITUDE_M.max))]
    pub altitude_m: f64,
    /// Heading of the nose from true north, clockwise seen from above.
    #[schemars(range(min = limits::YAW_DEG.min, max = limits::YAW_DEG.max))]
    pub yaw_deg: f64,
    /// Nose above the horizon.
    #[schemars(range(min = limits::PITCH_DEG.min, max = limits::PITCH_DEG.max))]
    pub pitch_deg: f64,
    /// Right wing down.
    #[schemars(range(min = limits::ROLL_DEG.min, max = limits::ROLL_DEG.max))]
    pub roll_deg: f64,
    /// Velocity over ground, north, east and down, for extrapolation; without it the ownship stands still between messages.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(inner(range(min = limits::VELOCITY_MPS.min, max = limits::VELOCITY_MPS.max)))]
    pub velocity_ned_mps: Option<[f64; 3]>,
    /// The host's own frame number, echoed in every frame that shows this message.
    #[serde(default)]
    #[schemars(range(max = u32::MAX))]
    pub host_frame: u32,
}

impl From<OwnshipMessage> for Ownship {
    fn from(message: OwnshipMessage) -> Self {
        let OwnshipMessage {
            latitude_deg,
            longitude_deg,
            altitude_m,
            yaw_deg,
            pitch_deg,
            roll_deg,
            velocity_ned_mps,
            host_frame,
        } = message;
        Self { latitude_deg, longitude_deg, altitude_m, yaw_deg, pitch_deg, roll_deg, velocity_ned_mps, host_frame }
    }
}

impl From<&Ownship> for OwnshipMessage {
    fn from(ownship: &Ownship) -> Self {
        let Ownship {
            latitude_deg,
            longitude_deg,
            altitude_m,
            yaw_deg,
            pitch_deg,
            roll_deg,
            velocity_ned_mps,
            host_frame,
        } = *ownship;
        Self { latitude_deg, longitude_deg, altitude_m, yaw_deg, pitch_deg, roll_deg, velocity_ned_mps, host_frame }
    }
}
