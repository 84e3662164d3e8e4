//! `storm` and `remove_storm`: flashes by a seeded schedule.

use crate::wire::limits;
use crate::world::command::StormRequest;
use crate::world::event::Refused;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A storm over a rounded rectangle of ground: its flashes follow from these fields and the simulation time alone. A storm of a
/// name that is there replaces it. Only the host may send it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StormMessage {
    /// Name by which later messages mean the same storm: letters, digits, `-` and `_`.
    #[schemars(length(min = limits::NAME_LENGTH.min, max = limits::NAME_LENGTH.max), regex(pattern = limits::NAME_PATTERN))]
    pub name: String,
    /// WGS84 latitude of the centre.
    #[schemars(range(min = limits::LATITUDE_DEG.min, max = limits::LATITUDE_DEG.max))]
    pub latitude_deg: f64,
    /// WGS84 longitude of the centre.
    #[schemars(range(min = limits::LONGITUDE_DEG.min, max = limits::LONGITUDE_DEG.max))]
    pub longitude_deg: f64,
    /// Full size towards east, before the rotation.
    #[schemars(range(min = limits::REGION_SIZE_M.min, max = limits::REGION_SIZE_M.max))]
    pub size_east_m: f64,
    /// Full size towards north, before the rotation.
    #[schemars(range(min = limits::REGION_SIZE_M.min, max = limits::REGION_SIZE_M.max))]
    pub size_north_m: f64,
    /// Radius of the rounded corners, at most half the smaller size.
    #[serde(default)]
    #[schemars(range(min = limits::CORNER_RADIUS_M.min, max = limits::CORNER_RADIUS_M.max))]
    pub corner_radius_m: f64,
    /// Rotation, clockwise seen from above.
    #[serde(default)]
    #[schemars(range(min = limits::DIRECTION_DEG.min, max = limits::DIRECTION_DEG.max))]
    pub rotation_deg: f64,
    /// Height of the flashes' light above the ellipsoid; without it in the lowest cloud layer of each flash's place, or 2000 m
    /// when there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::STRIKE_ALTITUDE_M.min, max = limits::STRIKE_ALTITUDE_M.max))]
    pub altitude_m: Option<f64>,
    /// Mean rate; the flashes come in bursts.
    #[serde(default = "usual_rate")]
    #[schemars(range(min = limits::FLASHES_PER_MINUTE.min, max = limits::FLASHES_PER_MINUTE.max))]
    pub flashes_per_minute: f64,
    /// Share of the flashes that do not come to the ground.
    #[serde(default = "usual_inside")]
    #[schemars(range(min = limits::SHARE.min, max = limits::SHARE.max))]
    pub inside_share: f64,
    /// Share of the flashes to ground that are positive.
    #[serde(default = "usual_positive")]
    #[schemars(range(min = limits::SHARE.min, max = limits::SHARE.max))]
    pub positive_share: f64,
    /// Factor on the peak currents of the published distributions.
    #[serde(default = "usual_currents")]
    #[schemars(range(min = limits::CURRENT_FACTOR.min, max = limits::CURRENT_FACTOR.max))]
    pub current_factor: f64,
    /// Seed of the schedule.
    #[serde(default)]
    pub seed: u64,
}

/// Ends a storm; flashes under way go on. Only the host may send it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RemoveStormMessage {
    /// The storm's name.
    #[schemars(length(min = limits::NAME_LENGTH.min, max = limits::NAME_LENGTH.max), regex(pattern = limits::NAME_PATTERN))]
    pub name: String,
}

/// About three a minute and cell.
fn usual_rate() -> f64 {
    3.0
}

/// About three quarters of all flashes do not reach the ground (Rakov and Uman 2003, "Lightning", chapter 1).
fn usual_inside() -> f64 {
    0.75
}

/// About a tenth of the flashes to ground are positive (Rakov and Uman 2003, chapter 5).
fn usual_positive() -> f64 {
    0.1
}

fn usual_currents() -> f64 {
    1.0
}

impl TryFrom<StormMessage> for StormRequest {
    type Error = Refused;

    fn try_from(message: StormMessage) -> Result<Self, Refused> {
        let largest_m = 0.5 * message.size_east_m.min(message.size_north_m);
        if message.corner_radius_m > largest_m {
            let why = "a corner's radius is at most half the storm's smaller size";
            return Err(Refused::new("corner_radius_m", message.corner_radius_m, format!("0 to {largest_m}"), why));
        }
        let StormMessage {
            name,
            latitude_deg,
            longitude_deg,
            size_east_m,
            size_north_m,
            corner_radius_m,
            rotation_deg,
            altitude_m,
            flashes_per_minute,
            inside_share,
            positive_share,
            current_factor,
            seed,
        } = message;
        Ok(Self {
            name,
            latitude_deg,
            longitude_deg,
            size_east_m,
            size_north_m,
            corner_radius_m,
            rotation_deg,
            altitude_m,
            flashes_per_minute,
            inside_share,
            positive_share,
            current_factor,
            seed,
        })
    }
}

impl From<&StormRequest> for StormMessage {
    fn from(request: &StormRequest) -> Self {
        let StormRequest {
            name,
            latitude_deg,
            longitude_deg,
            size_east_m,
            size_north_m,
            corner_radius_m,
            rotation_deg,
            altitude_m,
            flashes_per_minute,
            inside_share,
            positive_share,
            current_factor,
            seed,
        } = request.clone();
        Self {
            name,
            latitude_deg,
            longitude_deg,
            size_east_m,
            size_north_m,
            corner_radius_m,
            rotation_deg,
            altitude_m,
            flashes_per_minute,
            inside_share,
            positive_share,
            current_factor,
            seed,
        }
    }
}
