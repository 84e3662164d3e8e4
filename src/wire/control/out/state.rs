//! The state message: a snapshot and the player, in the units that people use.

mod convert;

use super::super::names::{CloudType, DeckFormName, FlashType, LightEncodingName, PolarityName, RelightName};
use super::super::view::ExposureJson;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The world at one moment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StateMessage {
    /// Number of the `query`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seq: Option<u64>,
    /// Number of the snapshot, rising.
    pub snapshot: u64,
    /// Frame number of the newest ownship message; 0 before the first.
    pub host_frame: u32,
    /// Simulation time.
    pub simulation_time_s: f64,
    /// Begin and end of the interval whose light a frame gathers.
    pub shutter_s: [f64; 2],
    /// Instant, RFC 3339.
    pub utc: String,
    /// Where the ownship is now.
    pub ownship: OwnshipOut,
    /// The global weather as it is now (in the middle of a transition: between old and new).
    pub weather: WeatherOut,
    /// Regions in the order in which they were made.
    pub regions: Vec<RegionOut>,
    /// The views, by name.
    pub views: Vec<ViewOut>,
    /// The storms that rage.
    pub storms: Vec<super::super::storm::StormMessage>,
    /// Flashes that shine or will soon, those of storms among them.
    pub flashes: Vec<FlashOut>,
    /// Sun and moon, seen from the ownship.
    pub sky: SkyOut,
    /// Slices per cloud layer.
    pub slices: u32,
    /// Pixels of the picture each way to one of the deck.
    pub deck_scale: u32,
    /// How a GPU draws the deck.
    pub deck_form: DeckFormName,
    /// How the light inside the deck is stored.
    pub light_encoding: LightEncodingName,
    /// How flashes light the clouds.
    pub relight: RelightName,
    /// Ratio between the radii of neighbouring billboard rings.
    pub ring_ratio: f64,
    /// The scenario player.
    pub player: Player,
}

/// Where the ownship is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OwnshipOut {
    /// WGS84 latitude.
    pub latitude_deg: f64,
    /// WGS84 longitude.
    pub longitude_deg: f64,
    /// Height above the ellipsoid.
    pub altitude_m: f64,
    /// Heading from true north.
    pub yaw_deg: f64,
    /// Nose up.
    pub pitch_deg: f64,
    /// Right wing down.
    pub roll_deg: f64,
}

/// Weather as it is now.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WeatherOut {
    /// Layers, lowest base first.
    pub layers: Vec<LayerOut>,
    /// Meteorological visibility at the ground.
    pub visibility_m: f64,
}

/// A layer as it is now.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LayerOut {
    /// Cloud type.
    pub cloud_type: CloudType,
    /// Base above the ellipsoid.
    pub base_m: f64,
    /// Top minus base.
    pub thickness_m: f64,
    /// Share of the sky hidden, 0 to 1.
    pub coverage: f64,
    /// Factor on the type's usual extinction.
    pub density: f64,
    /// Wind speed.
    pub wind_speed_mps: f64,
    /// Direction that the wind comes from.
    pub wind_from_deg: f64,
}

/// A region as it is now.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RegionOut {
    /// Outline.
    pub shape: super::super::region::RegionJson,
    /// Its own weather.
    pub weather: WeatherOut,
    /// 0 (not there) to 1 (fully there).
    pub presence: f64,
}

/// A view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ViewOut {
    /// Name.
    pub name: String,
    /// Width and height in pixels.
    pub size_px: [u32; 2],
    /// Horizontal field of view.
    pub field_of_view_deg: f64,
    /// Eye point in body axes, forward, right, down.
    pub offset_m: [f64; 3],
    /// Yaw against the body.
    pub yaw_deg: f64,
    /// Pitch against the body.
    pub pitch_deg: f64,
    /// Roll against the body.
    pub roll_deg: f64,
    /// Whether the own ship's landing lights shine.
    #[serde(default)]
    pub landing_light: bool,
    /// Whether its strobes flash.
    #[serde(default)]
    pub strobe: bool,
    /// Exposure value at ISO 100, or `"automatic"`.
    pub exposure_ev100: ExposureJson,
}

/// A flash.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FlashOut {
    /// Number.
    pub flash: u64,
    /// WGS84 latitude of the centre of its light.
    pub latitude_deg: f64,
    /// WGS84 longitude.
    pub longitude_deg: f64,
    /// Height above the ellipsoid.
    pub altitude_m: f64,
    /// Type.
    pub flash_type: FlashType,
    /// Polarity.
    pub polarity: PolarityName,
    /// Simulation time at which it begins.
    pub begin_s: f64,
    /// Simulation time at which its last light ends.
    pub end_s: f64,
    /// Mean luminous intensity over the shutter interval.
    pub intensity_cd: f64,
    /// The ground point of each of its channels, metres east and north of its place; one of `[0, 0]` for a flash that does not
    /// come to the ground.
    pub ground_points_m: Vec<[f64; 2]>,
}

/// Sun and moon, seen from the ownship (without refraction).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SkyOut {
    /// Height of the sun above the horizontal plane.
    pub sun_elevation_deg: f64,
    /// Direction of the sun from true north.
    pub sun_azimuth_deg: f64,
    /// Height of the moon above the horizontal plane.
    pub moon_elevation_deg: f64,
    /// Direction of the moon from true north.
    pub moon_azimuth_deg: f64,
    /// Lit share of the moon's disc, 0 to 1.
    pub moon_lit_fraction: f64,
}

/// The scenario player.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Player {
    /// Name of the scenario loaded.
    pub scenario: Option<String>,
    /// What its author says about it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// Whether time runs.
    pub playing: bool,
    /// Seconds of simulation per second of wall clock.
    pub speed: f64,
    /// Simulation time at which the scenario ends.
    pub duration_s: Option<f64>,
}
