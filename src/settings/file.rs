//! The settings file as it is written: its fields with their limits, its schema, and what stands where nothing is said.

use super::cigi::ByteOrderChoice;
use super::{DEFAULT_TEXT, ExecutorChoice, TerrainChoice};
use crate::wire::control::names::{DeckFormName, LightEncodingName, RelightName};
use crate::wire::json::{Node, Problem, Rule};
use crate::wire::{limits, schema};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// The file. A field that is not given has the value of `config/default.json`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Settings of stormdeck")]
pub(super) struct SettingsFile {
    /// Address and port to listen on; beyond this machine (not 127.0.0.1 or ::1) only with a token.
    #[schemars(length(min = limits::SETTINGS_TEXT_LENGTH.min, max = limits::SETTINGS_TEXT_LENGTH.max))]
    pub(super) listen: String,
    /// What every client has to show.
    #[schemars(length(min = limits::TOKEN_LENGTH.min, max = limits::TOKEN_LENGTH.max))]
    pub(super) token: Option<String>,
    /// Origins of web pages from elsewhere that may connect, as `https://example.org:8443`.
    #[schemars(length(max = limits::SETTINGS_LIST), inner(length(min = limits::SETTINGS_TEXT_LENGTH.min, max = limits::SETTINGS_TEXT_LENGTH.max)))]
    pub(super) allowed_origins: Vec<String>,
    /// Whether a client may take the host role from another.
    pub(super) allow_take_over: bool,
    /// Most WebSocket clients at once.
    #[schemars(range(min = limits::CLIENTS.min, max = limits::CLIENTS.max))]
    pub(super) max_clients: u32,
    /// What draws.
    pub(super) executor: ExecutorChoice,
    /// Frames a second while running free.
    #[schemars(range(min = limits::SERVER_RATE_HZ.min, max = limits::SERVER_RATE_HZ.max))]
    pub(super) frame_rate_hz: f64,
    /// Interval whose light a frame gathers while running free; without it until the next frame.
    #[schemars(range(min = limits::SHUTTER_S.min, max = limits::SHUTTER_S.max))]
    pub(super) shutter_s: Option<f64>,
    /// Slices per cloud layer.
    #[schemars(range(min = limits::SLICES.min, max = limits::SLICES.max))]
    pub(super) slices: u32,
    /// Pixels of the picture each way to one of the deck: 1 is sharpest, 2 costs a quarter.
    #[schemars(range(min = limits::DECK_SCALE.min, max = limits::DECK_SCALE.max))]
    pub(super) deck_scale: u32,
    /// How a GPU draws the deck: the forms differ in cost, not in what they show.
    pub(super) deck_form: DeckFormName,
    /// How the light inside the deck is stored: the encodings differ in memory and error, not in time.
    pub(super) light_encoding: LightEncodingName,
    /// How flashes light the clouds, from bare points to the reference. Tables (`basis`, `hybrid`) are baked in the background for
    /// each piece of cloud that is struck.
    pub(super) relight: RelightName,
    /// Memory in MiB that tables of virtual lights may take; a flash whose table would be larger is solved instead.
    #[schemars(range(min = limits::BASIS_MEMORY_MIB.min, max = limits::BASIS_MEMORY_MIB.max))]
    pub(super) basis_memory_mib: u32,
    /// Folder that keeps baked tables by content, so that an unchanged cloud is not baked again after a restart; it may be shared
    /// with `stormdeck bake --cache` and `stormdeck render --basis-cache`. Without it tables end with the server.
    #[schemars(length(min = limits::SETTINGS_TEXT_LENGTH.min, max = limits::SETTINGS_TEXT_LENGTH.max))]
    pub(super) basis_cache: Option<String>,
    /// MiB that the tables in that folder may take; those that were not used for longest go first.
    #[schemars(range(min = limits::BASIS_CACHE_MIB.min, max = limits::BASIS_CACHE_MIB.max))]
    pub(super) basis_cache_mib: u32,
    /// Ratio between the radii of neighbouring billboard rings.
    #[schemars(range(min = limits::RING_RATIO.min, max = limits::RING_RATIO.max))]
    pub(super) ring_ratio: f64,
    /// Most strokes of lightning in any one second that give light, for people sensitive to flicker (WCAG 2.3.1: three); those
    /// beyond are left out. Without it there is no limit.
    #[schemars(range(min = limits::GUARD_FLASHES_PER_S.min, max = limits::GUARD_FLASHES_PER_S.max))]
    pub(super) flicker_guard_per_s: Option<u32>,
    /// Where the ground is.
    pub(super) terrain: TerrainChoice,
    /// File of heights that is laid over it: a GeoTIFF in latitudes and longitudes (.tif, .tiff), or an HGT tile as N47E008.hgt.
    #[schemars(length(min = limits::SETTINGS_TEXT_LENGTH.min, max = limits::SETTINGS_TEXT_LENGTH.max))]
    pub(super) terrain_file: Option<String>,
    /// Height of mean sea level above the WGS84 ellipsoid where the file lies: its heights count from there.
    #[schemars(range(min = limits::SEA_LEVEL_M.min, max = limits::SEA_LEVEL_M.max))]
    pub(super) terrain_sea_level_m: f64,
    /// Quality of JPEGs where nobody asks for another.
    #[schemars(range(min = limits::JPEG_QUALITY.min, max = limits::JPEG_QUALITY.max))]
    pub(super) jpeg_quality: u8,
    /// Scenario to start with: a file of the folder or one inside the binary, without `.json`.
    #[schemars(length(min = limits::SCENARIO_NAME_LENGTH.min, max = limits::SCENARIO_NAME_LENGTH.max), regex(pattern = limits::SCENARIO_NAME_PATTERN))]
    pub(super) scenario: Option<String>,
    /// Folder of the scenarios that may be loaded by name, besides those inside the binary.
    #[schemars(length(min = limits::SETTINGS_TEXT_LENGTH.min, max = limits::SETTINGS_TEXT_LENGTH.max))]
    pub(super) scenario_folder: String,
    /// Frames that wait for one client per subscription.
    #[schemars(range(min = limits::QUEUE_FRAMES.min, max = limits::QUEUE_FRAMES.max))]
    pub(super) queue_frames: u32,
    /// Commands that wait for the world.
    #[schemars(range(min = limits::QUEUE_COMMANDS.min, max = limits::QUEUE_COMMANDS.max))]
    pub(super) queue_commands: u32,
    /// MiB that the pictures of lockstep steps may hold until they are written; further steps wait for room.
    #[schemars(range(min = limits::STEP_MEMORY_MIB.min, max = limits::STEP_MEMORY_MIB.max))]
    pub(super) step_memory_mib: u32,
    /// Seconds after which a client that takes no bytes is cut off.
    #[schemars(range(min = limits::SLOW_CLIENT_S.min, max = limits::SLOW_CLIENT_S.max))]
    pub(super) slow_client_s: f64,
    /// What is logged, as `tracing` filters say it: `info`, `stormdeck=debug`.
    #[schemars(length(min = limits::SETTINGS_TEXT_LENGTH.min, max = limits::SETTINGS_TEXT_LENGTH.max))]
    pub(super) log: String,
    /// Address and port on which CIGI hosts are listened to by UDP, as 0.0.0.0:8004; without it there is no CIGI.
    #[schemars(length(min = limits::SETTINGS_TEXT_LENGTH.min, max = limits::SETTINGS_TEXT_LENGTH.max))]
    pub(super) cigi_listen: Option<String>,
    /// Address and port of the CIGI host; without it both are learned from the first valid datagram.
    #[schemars(length(min = limits::SETTINGS_TEXT_LENGTH.min, max = limits::SETTINGS_TEXT_LENGTH.max))]
    pub(super) cigi_host: Option<String>,
    /// Port of a learned CIGI host to which answers go, as 8005; without it the port that it sends from.
    #[schemars(range(min = 1))]
    pub(super) cigi_reply_port: Option<u16>,
    /// Addresses that may be CIGI host; none: any of this machine. Beyond it either these or `cigi_host` have to be given.
    #[schemars(length(max = limits::SETTINGS_LIST), inner(length(min = limits::SETTINGS_TEXT_LENGTH.min, max = limits::SETTINGS_TEXT_LENGTH.max)))]
    pub(super) cigi_allow: Vec<String>,
    /// Multicast group on which CIGI hosts are listened to as well.
    #[schemars(length(min = limits::SETTINGS_TEXT_LENGTH.min, max = limits::SETTINGS_TEXT_LENGTH.max))]
    pub(super) cigi_multicast: Option<String>,
    /// Synchronous operation: the server's frames are the clock, and each waits for its picture.
    pub(super) cigi_synchronous: bool,
    /// Byte order of what is sent to the CIGI host; what it sends is understood in either.
    pub(super) cigi_byte_order: ByteOrderChoice,
    /// Start of Frame messages a second.
    #[schemars(range(min = limits::CIGI_RATE_HZ.min, max = limits::CIGI_RATE_HZ.max))]
    pub(super) cigi_rate_hz: f64,
    /// Seconds of silence after which the CIGI host is taken to be gone.
    #[schemars(range(min = limits::CIGI_SILENCE_S.min, max = limits::CIGI_SILENCE_S.max))]
    pub(super) cigi_silence_s: f64,
    /// Whether the CIGI host chooses the database, of which there is one, number 1; else it is the server's, number 0.
    pub(super) cigi_host_chooses_database: bool,
    /// Height of mean sea level above the WGS84 ellipsoid where CIGI hosts fly: their altitudes count from there.
    #[schemars(range(min = limits::SEA_LEVEL_M.min, max = limits::SEA_LEVEL_M.max))]
    pub(super) cigi_sea_level_m: f64,
    /// Seed of the storms that CIGI hosts ask for.
    pub(super) cigi_seed: u32,
    /// Width and height of the pictures of a CIGI host's views: CIGI has no word for them.
    #[schemars(inner(range(min = limits::SIZE_PX.min, max = limits::SIZE_PX.max)))]
    pub(super) cigi_size_px: [u32; 2],
}

/// The schema of the settings file: no field is required, each has its default.
pub fn file_schema() -> Value {
    let mut schema = schema::of::<SettingsFile>();
    let defaults = defaults();
    if let Some(map) = schema.as_object_mut() {
        map.remove("required");
        if let Some(properties) = map.get_mut("properties").and_then(Value::as_object_mut) {
            for (name, property) in properties {
                if let (Some(property), Some(default)) = (property.as_object_mut(), defaults.get(name)) {
                    property.insert("default".into(), default.clone());
                }
            }
        }
    }
    schema
}

/// What the file is checked against.
pub(super) fn rule() -> Rule {
    schema::rule(&file_schema())
}

/// The fields of `config/default.json`.
pub(super) fn defaults() -> Map<String, Value> {
    match serde_json::from_str(DEFAULT_TEXT) {
        Ok(Value::Object(fields)) => fields,
        // A test reads the text; without it the defaults would be missed at once.
        _ => Map::new(),
    }
}

/// The defaults with those fields of the file over them that no problem is known of.
pub(super) fn overlaid(root: &Node, problems: &[Problem]) -> Option<SettingsFile> {
    let Value::Object(given) = root.to_value() else { return None };
    let is_wrong =
        |name: &str| problems.iter().any(|problem| problem.refused.field.split(['.', '[']).next() == Some(name));
    let mut fields = defaults();
    for (name, value) in given {
        // A null says "not given" only where the default is null; the check has refused the others.
        if fields.contains_key(&name) && !is_wrong(&name) {
            fields.insert(name, value);
        }
    }
    serde_json::from_value(Value::Object(fields)).ok()
}
