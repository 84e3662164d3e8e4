//! Settings: the configuration file checked as a whole, all complaints at once.

mod cigi;
mod ground;
mod scenarios;

pub use cigi::{ByteOrderChoice, CigiSettings};
pub use ground::{NoGround, with_heights};
pub use scenarios::{BUILT_IN_SCENARIOS, built_in, text_of};

use crate::geo::terrain::Terrain;
use crate::wire::control::names::{DeckFormName, LightEncodingName, RelightName};
use crate::wire::json::{self, Complaint, Node, Problem, Rule, Size};
use crate::wire::{limits, schema};
use crate::world::event::Refused;
use crate::world::snapshot::Quality;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::net::SocketAddr;
use std::path::PathBuf;

/// The text of `config/default.json`: what holds where nothing is said, on any machine.
pub const DEFAULT_TEXT: &str = include_str!("../config/default.json");

/// What the server is told before it starts.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Address and port to listen on; beyond this machine only with a token.
    pub listen: SocketAddr,
    /// What every client has to show.
    pub token: Option<String>,
    /// Origins of web pages from elsewhere that may connect, as `https://example.org:8443`.
    pub allowed_origins: Vec<String>,
    /// Whether a client may take the host role from another.
    pub allow_take_over: bool,
    /// Most WebSocket clients at once.
    pub max_clients: u32,
    /// What draws.
    pub executor: ExecutorChoice,
    /// Frames a second while running free, at most 60.
    pub frame_rate_hz: f64,
    /// Interval whose light a frame gathers while running free; `None`: until the next frame.
    pub shutter_s: Option<f64>,
    /// Slices per cloud layer, 1 to 128.
    pub slices: u32,
    /// Pixels of the picture each way to one of the deck, 1 to 4.
    pub deck_scale: u32,
    /// How a GPU draws the deck.
    pub deck_form: DeckFormName,
    /// How the light inside the deck is stored.
    pub light_encoding: LightEncodingName,
    /// How flashes light the clouds.
    pub relight: RelightName,
    /// Ratio between the radii of neighbouring billboard rings, above 1.
    pub ring_ratio: f64,
    /// Most strokes of lightning in any one second that give light, for people sensitive to flicker; `None`: no limit.
    pub flicker_guard_per_s: Option<u32>,
    /// Where the ground is.
    pub terrain: TerrainChoice,
    /// A GeoTIFF or HGT file of heights laid over it.
    pub terrain_file: Option<PathBuf>,
    /// Height of mean sea level above the ellipsoid, from which the file's heights count.
    pub terrain_sea_level_m: f64,
    /// Quality of JPEGs where nobody asks for another, 1 to 100.
    pub jpeg_quality: u8,
    /// Scenario to start with; `None`: a clear day at rest.
    pub scenario: Option<String>,
    /// Folder of the scenarios that may be loaded by name, besides those inside the binary.
    pub scenario_folder: PathBuf,
    /// Frames that wait for one client per subscription.
    pub queue_frames: u32,
    /// Commands that wait for the world.
    pub queue_commands: u32,
    /// MiB that the pictures of lockstep steps may hold until they are written; further steps wait for room.
    pub step_memory_mib: u32,
    /// Seconds after which a client that takes no bytes is cut off.
    pub slow_client_s: f64,
    /// What is logged, as `tracing` filters say it: `info`, `stormdeck=debug`.
    pub log: String,
    /// The CIGI port; `None`: there is none.
    pub cigi: Option<CigiSettings>,
}

/// What draws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ExecutorChoice {
    /// The GPU where an adapter is there, else the reference.
    #[default]
    Auto,
    /// The GPU, or nothing.
    Gpu,
    /// The processor.
    Reference,
}

/// Where the ground is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TerrainChoice {
    /// Made relief: coasts and mountain ranges where they are, hills and valleys made up.
    Procedural,
    /// The bare ellipsoid: height 0 everywhere, at no cost.
    #[default]
    Ellipsoid,
}

impl TerrainChoice {
    /// The ground of this name.
    pub fn terrain(self) -> Terrain {
        match self {
            Self::Procedural => Terrain::procedural(),
            Self::Ellipsoid => Terrain::ELLIPSOID,
        }
    }
}

/// The file. A field that is not given has the value of `config/default.json`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Settings of stormdeck")]
struct SettingsFile {
    /// Address and port to listen on; beyond this machine (not 127.0.0.1 or ::1) only with a token.
    #[schemars(length(min = limits::SETTINGS_TEXT_LENGTH.min, max = limits::SETTINGS_TEXT_LENGTH.max))]
    listen: String,
    /// What every client has to show.
    #[schemars(length(min = limits::TOKEN_LENGTH.min, max = limits::TOKEN_LENGTH.max))]
    token: Option<String>,
    /// Origins of web pages from elsewhere that may connect, as `https://example.org:8443`.
    #[schemars(length(max = limits::SETTINGS_LIST), inner(length(min = limits::SETTINGS_TEXT_LENGTH.min, max = limits::SETTINGS_TEXT_LENGTH.max)))]
    allowed_origins: Vec<String>,
    /// Whether a client may take the host role from another.
    allow_take_over: bool,
    /// Most WebSocket clients at once.
    #[schemars(range(min = limits::CLIENTS.min, max = limits::CLIENTS.max))]
    max_clients: u32,
    /// What draws.
    executor: ExecutorChoice,
    /// Frames a second while running free.
    #[schemars(range(min = limits::SERVER_RATE_HZ.min, max = limits::SERVER_RATE_HZ.max))]
    frame_rate_hz: f64,
    /// Interval whose light a frame gathers while running free; without it until the next frame.
    #[schemars(range(min = limits::SHUTTER_S.min, max = limits::SHUTTER_S.max))]
    shutter_s: Option<f64>,
    /// Slices per cloud layer.
    #[schemars(range(min = limits::SLICES.min, max = limits::SLICES.max))]
    slices: u32,
    /// Pixels of the picture each way to one of the deck: 1 is sharpest, 2 costs a quarter.
    #[schemars(range(min = limits::DECK_SCALE.min, max = limits::DECK_SCALE.max))]
    deck_scale: u32,
    /// How a GPU draws the deck: the forms differ in cost, not in what they show.
    deck_form: DeckFormName,
    /// How the light inside the deck is stored: the encodings differ in memory and error, not in time.
    light_encoding: LightEncodingName,
    /// How flashes light the clouds, from bare points to the reference: each costs more than the one before.
    relight: RelightName,
    /// Ratio between the radii of neighbouring billboard rings.
    #[schemars(range(min = limits::RING_RATIO.min, max = limits::RING_RATIO.max))]
    ring_ratio: f64,
    /// Most strokes of lightning in any one second that give light, for people sensitive to flicker (WCAG 2.3.1: three); those
    /// beyond are left out. Without it there is no limit.
    #[schemars(range(min = limits::GUARD_FLASHES_PER_S.min, max = limits::GUARD_FLASHES_PER_S.max))]
    flicker_guard_per_s: Option<u32>,
    /// Where the ground is.
    terrain: TerrainChoice,
    /// File of heights that is laid over it: a GeoTIFF in latitudes and longitudes (.tif, .tiff), or an HGT tile as N47E008.hgt.
    #[schemars(length(min = limits::SETTINGS_TEXT_LENGTH.min, max = limits::SETTINGS_TEXT_LENGTH.max))]
    terrain_file: Option<String>,
    /// Height of mean sea level above the WGS84 ellipsoid where the file lies: its heights count from there.
    #[schemars(range(min = limits::SEA_LEVEL_M.min, max = limits::SEA_LEVEL_M.max))]
    terrain_sea_level_m: f64,
    /// Quality of JPEGs where nobody asks for another.
    #[schemars(range(min = limits::JPEG_QUALITY.min, max = limits::JPEG_QUALITY.max))]
    jpeg_quality: u8,
    /// Scenario to start with: a file of the folder or one inside the binary, without `.json`.
    #[schemars(length(min = limits::SCENARIO_NAME_LENGTH.min, max = limits::SCENARIO_NAME_LENGTH.max), regex(pattern = limits::SCENARIO_NAME_PATTERN))]
    scenario: Option<String>,
    /// Folder of the scenarios that may be loaded by name, besides those inside the binary.
    #[schemars(length(min = limits::SETTINGS_TEXT_LENGTH.min, max = limits::SETTINGS_TEXT_LENGTH.max))]
    scenario_folder: String,
    /// Frames that wait for one client per subscription.
    #[schemars(range(min = limits::QUEUE_FRAMES.min, max = limits::QUEUE_FRAMES.max))]
    queue_frames: u32,
    /// Commands that wait for the world.
    #[schemars(range(min = limits::QUEUE_COMMANDS.min, max = limits::QUEUE_COMMANDS.max))]
    queue_commands: u32,
    /// MiB that the pictures of lockstep steps may hold until they are written; further steps wait for room.
    #[schemars(range(min = limits::STEP_MEMORY_MIB.min, max = limits::STEP_MEMORY_MIB.max))]
    step_memory_mib: u32,
    /// Seconds after which a client that takes no bytes is cut off.
    #[schemars(range(min = limits::SLOW_CLIENT_S.min, max = limits::SLOW_CLIENT_S.max))]
    slow_client_s: f64,
    /// What is logged, as `tracing` filters say it: `info`, `stormdeck=debug`.
    #[schemars(length(min = limits::SETTINGS_TEXT_LENGTH.min, max = limits::SETTINGS_TEXT_LENGTH.max))]
    log: String,
    /// Address and port on which CIGI hosts are listened to by UDP, as 0.0.0.0:8004; without it there is no CIGI.
    #[schemars(length(min = limits::SETTINGS_TEXT_LENGTH.min, max = limits::SETTINGS_TEXT_LENGTH.max))]
    cigi_listen: Option<String>,
    /// Address and port of the CIGI host; without it both are learned from the first valid datagram.
    #[schemars(length(min = limits::SETTINGS_TEXT_LENGTH.min, max = limits::SETTINGS_TEXT_LENGTH.max))]
    cigi_host: Option<String>,
    /// Port of a learned CIGI host to which answers go, as 8005; without it the port that it sends from.
    #[schemars(range(min = 1))]
    cigi_reply_port: Option<u16>,
    /// Addresses that may be CIGI host; none: any of this machine. Beyond it either these or `cigi_host` have to be given.
    #[schemars(length(max = limits::SETTINGS_LIST), inner(length(min = limits::SETTINGS_TEXT_LENGTH.min, max = limits::SETTINGS_TEXT_LENGTH.max)))]
    cigi_allow: Vec<String>,
    /// Multicast group on which CIGI hosts are listened to as well.
    #[schemars(length(min = limits::SETTINGS_TEXT_LENGTH.min, max = limits::SETTINGS_TEXT_LENGTH.max))]
    cigi_multicast: Option<String>,
    /// Synchronous operation: the server's frames are the clock, and each waits for its picture.
    cigi_synchronous: bool,
    /// Byte order of what is sent to the CIGI host; what it sends is understood in either.
    cigi_byte_order: ByteOrderChoice,
    /// Start of Frame messages a second.
    #[schemars(range(min = limits::CIGI_RATE_HZ.min, max = limits::CIGI_RATE_HZ.max))]
    cigi_rate_hz: f64,
    /// Seconds of silence after which the CIGI host is taken to be gone.
    #[schemars(range(min = limits::CIGI_SILENCE_S.min, max = limits::CIGI_SILENCE_S.max))]
    cigi_silence_s: f64,
    /// Whether the CIGI host chooses the database, of which there is one, number 1; else it is the server's, number 0.
    cigi_host_chooses_database: bool,
    /// Height of mean sea level above the WGS84 ellipsoid where CIGI hosts fly: their altitudes count from there.
    #[schemars(range(min = limits::SEA_LEVEL_M.min, max = limits::SEA_LEVEL_M.max))]
    cigi_sea_level_m: f64,
    /// Seed of the storms that CIGI hosts ask for.
    cigi_seed: u32,
    /// Width and height of the pictures of a CIGI host's views: CIGI has no word for them.
    #[schemars(inner(range(min = limits::SIZE_PX.min, max = limits::SIZE_PX.max)))]
    cigi_size_px: [u32; 2],
}

impl Default for Settings {
    /// The settings of `config/default.json`.
    fn default() -> Self {
        // The text is part of the program, and a test reads it.
        Self::parse(DEFAULT_TEXT).unwrap_or_else(|complaints| panic!("config/default.json: {complaints:?}"))
    }
}

impl Settings {
    /// Reads a settings file.
    ///
    /// # Errors
    /// Everything that is wrong with it, in the order of the file.
    pub fn parse(text: &str) -> Result<Self, Vec<Complaint>> {
        let size = Size { bytes: limits::SETTINGS_BYTES, values: limits::MESSAGE_VALUES };
        let parsed = json::parse(text, size).map_err(|problem| vec![problem.in_text(text)])?;
        let mut problems = parsed.problems;
        problems.extend(rule().check(&parsed.root));
        // Fields that the check found wrong take their defaults, so that the others can be judged together.
        let file = overlaid(&parsed.root, &problems);
        let settings = file.and_then(|file| {
            Self::from_file(file, &mut |refused| {
                // A field that is wrong in itself stood in with its default: nothing follows from that.
                if problems.iter().all(|problem| problem.refused.field != refused.field) {
                    problems.push(Problem { offset: parsed.root.nearest(&refused.field).offset, refused });
                }
            })
        });
        match settings {
            Some(settings) if problems.is_empty() => Ok(settings),
            _ => {
                problems.sort_by_key(|problem| problem.offset);
                Err(problems.into_iter().map(|problem| problem.in_text(text)).collect())
            }
        }
    }

    /// The ground, with the file of heights read.
    ///
    /// # Errors
    /// [`NoGround`]: the file cannot be read.
    pub fn ground(&self) -> Result<Terrain, NoGround> {
        let around = self.terrain.terrain();
        match &self.terrain_file {
            Some(file) => with_heights(around, file, self.terrain_sea_level_m),
            None => Ok(around),
        }
    }

    /// What may be spent on a picture.
    pub fn quality(&self) -> Quality {
        Quality {
            slices: self.slices,
            ring_ratio: self.ring_ratio,
            deck_scale: self.deck_scale,
            deck_form: self.deck_form.into(),
            light_encoding: self.light_encoding.into(),
            relight: self.relight.into(),
        }
    }

    /// What contradicts the rules between fields; also to be asked after flags have changed some.
    pub fn contradictions(&self) -> Vec<Refused> {
        let mut found = Vec::new();
        if !self.listen.ip().is_loopback() && self.token.is_none() {
            let (limit, why) =
                ("a token of at least 8 characters", "beyond this machine a token has to guard the server");
            found.push(Refused::new("token", "not given", limit, why));
        }
        found
    }

    fn from_file(file: SettingsFile, complain: &mut dyn FnMut(Refused)) -> Option<Self> {
        for (index, origin) in file.allowed_origins.iter().enumerate() {
            let rest = origin.strip_prefix("https://").or_else(|| origin.strip_prefix("http://"));
            if rest.is_none_or(|host| host.is_empty() || host.contains(['/', '*', ' '])) {
                let why = "not the origin of a page: scheme, host and port, without a path";
                complain(Refused::new(format!("allowed_origins[{index}]"), origin, "as https://example.org:8443", why));
            }
        }
        let listen = match file.listen.parse() {
            Ok(listen) => listen,
            Err(_) => {
                let why = "not an address with a port";
                complain(Refused::new("listen", &file.listen, "as 127.0.0.1:8765 or [::1]:8765", why));
                return None;
            }
        };
        let cigi = cigi::from_file(&file, complain);
        let settings = Self {
            listen,
            token: file.token,
            allowed_origins: file.allowed_origins,
            allow_take_over: file.allow_take_over,
            max_clients: file.max_clients,
            executor: file.executor,
            frame_rate_hz: file.frame_rate_hz,
            shutter_s: file.shutter_s,
            slices: file.slices,
            deck_scale: file.deck_scale,
            deck_form: file.deck_form,
            light_encoding: file.light_encoding,
            relight: file.relight,
            ring_ratio: file.ring_ratio,
            flicker_guard_per_s: file.flicker_guard_per_s,
            terrain: file.terrain,
            terrain_file: file.terrain_file.map(PathBuf::from),
            terrain_sea_level_m: file.terrain_sea_level_m,
            jpeg_quality: file.jpeg_quality,
            scenario: file.scenario,
            scenario_folder: file.scenario_folder.into(),
            queue_frames: file.queue_frames,
            queue_commands: file.queue_commands,
            step_memory_mib: file.step_memory_mib,
            slow_client_s: file.slow_client_s,
            log: file.log,
            cigi,
        };
        settings.contradictions().into_iter().for_each(complain);
        Some(settings)
    }
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

fn rule() -> Rule {
    schema::rule(&file_schema())
}

fn defaults() -> Map<String, Value> {
    match serde_json::from_str(DEFAULT_TEXT) {
        Ok(Value::Object(fields)) => fields,
        // A test reads the text; without it the defaults would be missed at once.
        _ => Map::new(),
    }
}

/// The defaults with those fields of the file over them that no problem is known of.
fn overlaid(root: &Node, problems: &[Problem]) -> Option<SettingsFile> {
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

#[cfg(test)]
mod tests;
