//! What a host has said of the air beside clouds and haze: temperature, humidity, pressure, winds and aerosols, for answers.

use crate::world::command::RegionShape;

/// Temperature of the International Standard Atmosphere at mean sea level (ISO 2533).
pub const STANDARD_TEMPERATURE_C: f64 = 15.0;
/// Its pressure at mean sea level (ISO 2533).
pub const STANDARD_PRESSURE_HPA: f64 = 1013.25;

/// Air as a layer has it, or as it is everywhere at mean sea level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AirMass {
    /// Degrees Celsius.
    pub temperature_c: f64,
    /// Per cent.
    pub humidity_percent: f64,
    /// Hectopascal.
    pub pressure_hpa: f64,
    /// Horizontal wind.
    pub wind_speed_mps: f64,
    /// Upward wind.
    pub updraft_mps: f64,
    /// Direction that the wind comes from, clockwise from true north.
    pub wind_from_deg: f64,
}

impl Default for AirMass {
    fn default() -> Self {
        Self {
            temperature_c: STANDARD_TEMPERATURE_C,
            humidity_percent: 0.0,
            pressure_hpa: STANDARD_PRESSURE_HPA,
            wind_speed_mps: 0.0,
            updraft_mps: 0.0,
            wind_from_deg: 0.0,
        }
    }
}

/// A layer of other air than everywhere.
#[derive(Clone, Debug, PartialEq)]
pub struct AirLayer {
    /// The host's number for it.
    pub layer_id: u8,
    /// The region that has it; `None`: it is everywhere.
    pub region: Option<RegionShape>,
    /// Whether its region keeps the weather around it beside its own.
    pub merges: bool,
    /// The same for aerosols.
    pub merges_aerosol: bool,
    /// Height of its base above the ellipsoid.
    pub base_m: f64,
    /// Height of its top.
    pub top_m: f64,
    /// Over this distance below the base it goes over into the air around.
    pub below_m: f64,
    /// The same above the top.
    pub above_m: f64,
    /// Its air.
    pub air: AirMass,
    /// Visibility in it, where it is no cloud (those are drawn, and asked as they are drawn); `None`: as around.
    pub visibility_m: Option<f64>,
    /// Aerosol in g/m3.
    pub aerosol_g_per_m3: f64,
}

/// All that was said.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Air {
    /// Everywhere, at mean sea level; the standard atmosphere with height from there.
    pub global: AirMass,
    /// Height of mean sea level above the ellipsoid.
    pub sea_level_m: f64,
    /// Layers, in the order in which they count: a later one over an earlier one.
    pub layers: Vec<AirLayer>,
}
