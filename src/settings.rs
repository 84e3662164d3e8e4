//! Settings: the configuration file checked as a whole, all complaints at once.

mod cigi;
mod file;
mod ground;
mod scenarios;

pub use cigi::{ByteOrderChoice, CigiSettings};
pub use file::file_schema;
pub use ground::{NoGround, with_heights};
pub use scenarios::{BUILT_IN_SCENARIOS, built_in, text_of};

use crate::geo::terrain::Terrain;
use crate::wire::control::names::{DeckFormName, LightEncodingName, RelightName};
use crate::wire::json::{self, Complaint, Problem, Size};
use crate::wire::limits;
use crate::world::event::Refused;
use crate::world::snapshot::Quality;
use file::{SettingsFile, overlaid, rule};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
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
    /// Memory in MiB that tables of virtual lights may take.
    pub basis_memory_mib: u32,
    /// Folder that keeps baked tables by content; `None`: they end with the program.
    pub basis_cache: Option<PathBuf>,
    /// MiB that the tables in that folder may take.
    pub basis_cache_mib: u32,
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
            basis_memory_mib: self.basis_memory_mib,
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
            basis_memory_mib: file.basis_memory_mib,
            basis_cache: file.basis_cache.map(PathBuf::from),
            basis_cache_mib: file.basis_cache_mib,
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

#[cfg(test)]
mod tests;
