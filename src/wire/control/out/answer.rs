//! Answers to the questions that ask the world itself: heights, lines of sight, the weather at a point.

use super::super::question::PointJson;
use crate::geo::Geodetic;
use crate::outputs::conditions::Conditions;
use crate::outputs::ground::HatHot;
use crate::outputs::sight::{Hider, Sight};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Height above the ground, and of the ground, below a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HeightsMessage {
    /// Number of the `query`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seq: Option<u64>,
    /// Height of the point above the ground.
    pub height_above_ground_m: f64,
    /// The ground below (or above) the point.
    pub ground: PointJson,
    /// Direction of the ground's normal from true north, clockwise; 0 where it is vertical.
    pub normal_azimuth_deg: f64,
    /// Its elevation; 90 is vertical.
    pub normal_elevation_deg: f64,
    /// What the ground is made of: the code that CIGI hosts are told.
    pub material: u32,
}

/// What a line of sight meets.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SightMessage {
    /// Number of the `query`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seq: Option<u64>,
    /// What hides the rest of the line; null: nothing up to its end.
    pub hidden_by: Option<HiderName>,
    /// From the source to what hides, or to the end.
    pub range_m: f64,
    /// That point.
    pub at: PointJson,
    /// Opacity of the clouds up to that point, 0 (clear) to 1.
    pub opacity: f64,
}

/// What can hide.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum HiderName {
    /// The ground.
    Ground,
    /// Cloud whose opacity reaches what was asked.
    Cloud,
}

/// The weather at a point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ConditionsMessage {
    /// Number of the `query`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seq: Option<u64>,
    /// Meteorological visibility in what is drawn there: cloud and haze.
    pub visibility_m: f64,
    /// Temperature.
    pub temperature_c: f64,
    /// Relative humidity.
    pub humidity_percent: f64,
    /// Pressure.
    pub pressure_hpa: f64,
    /// Horizontal wind.
    pub wind_speed_mps: f64,
    /// Direction that it comes from, from true north, clockwise.
    pub wind_from_deg: f64,
    /// Upward wind.
    pub updraft_mps: f64,
    /// Aerosols of the weather layers of a CIGI host that are there.
    pub aerosols: Vec<AerosolOut>,
}

/// The aerosol of one layer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AerosolOut {
    /// The CIGI host's number for the layer.
    pub layer: u8,
    /// Concentration.
    pub concentration_g_per_m3: f64,
}

impl HeightsMessage {
    /// The message for an answer about `point`.
    pub fn new(seq: Option<u64>, point: &Geodetic, found: &HatHot) -> Self {
        Self {
            seq,
            height_above_ground_m: found.hat_m,
            ground: PointJson::from(&Geodetic { altitude_m: found.hot_m, ..*point }),
            normal_azimuth_deg: found.normal_azimuth_deg,
            normal_elevation_deg: found.normal_elevation_deg,
            material: found.material,
        }
    }
}

impl SightMessage {
    /// The message for an answer.
    pub fn new(seq: Option<u64>, found: &Sight) -> Self {
        let hidden_by = found.hider.map(|hider| match hider {
            Hider::Ground => HiderName::Ground,
            Hider::Cloud => HiderName::Cloud,
        });
        Self { seq, hidden_by, range_m: found.range_m, at: PointJson::from(&found.point), opacity: found.opacity }
    }
}

impl ConditionsMessage {
    /// The message for an answer.
    pub fn new(seq: Option<u64>, found: &Conditions) -> Self {
        let aerosol = |(layer, concentration_g_per_m3): &(u8, f64)| AerosolOut {
            layer: *layer,
            concentration_g_per_m3: *concentration_g_per_m3,
        };
        Self {
            seq,
            visibility_m: found.visibility_m,
            temperature_c: found.air.temperature_c,
            humidity_percent: found.air.humidity_percent,
            pressure_hpa: found.air.pressure_hpa,
            wind_speed_mps: found.air.wind_speed_mps,
            wind_from_deg: found.air.wind_from_deg,
            updraft_mps: found.air.updraft_mps,
            aerosols: found.aerosols.iter().map(aerosol).collect(),
        }
    }
}
