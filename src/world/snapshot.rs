//! A snapshot: everything that a picture or an answer depends on, at one moment, never changed after it was taken.

use crate::clouds::CloudKind;
use crate::geo::terrain::Terrain;
use crate::geo::{Attitude, Geodetic};
use crate::lightning::flash::Light;
use crate::lightning::strike::StrikeChannel;
use crate::passes::light::encoding::Encoding;
use crate::passes::relight::Lighting;
use glam::{DQuat, DVec3};
use std::sync::Arc;

use super::command::{Exposure, FlashKind, Frustum, Polarity, RegionShape, StormRequest};

/// The world at one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Rises by one for each snapshot taken.
    pub number: u64,
    /// Frame number of the newest ownship message; 0 before the first.
    pub host_frame: u32,
    /// Simulation time in seconds since the session or scenario began.
    pub simulation_time_s: f64,
    /// The interval of simulation time whose light a frame of this snapshot gathers, `[begin, end)`.
    pub shutter_s: [f64; 2],
    /// Seconds since 1970-01-01T00:00:00 UTC.
    pub utc_s: f64,
    /// The ownship, extrapolated to this moment.
    pub ownship: OwnshipState,
    /// Global weather.
    pub weather: WeatherState,
    /// Regions with their own weather, in the order in which they were made.
    pub regions: Vec<RegionState>,
    /// The views, by name.
    pub views: Vec<ViewState>,
    /// The storms that rage, in the order in which they began or were changed last.
    pub storms: Vec<StormRequest>,
    /// Flashes of which some part lies in the shutter interval, in the order of their numbers.
    pub flashes: Vec<FlashState>,
    /// Sun and moon.
    pub sky: SkyState,
    /// What may be spent.
    pub quality: Quality,
    /// Where the ground is.
    pub terrain: Terrain,
}

impl Snapshot {
    /// Whether something that a picture of it would show is still being made, so that another picture of the same moment may
    /// differ.
    pub fn provisional(&self) -> bool {
        self.flashes.iter().any(|flash| !flash.lights.is_empty() && flash.channel.is_none())
    }
}

/// Where the ownship is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OwnshipState {
    /// Position.
    pub position: Geodetic,
    /// Attitude against the local north-east-down axes.
    pub attitude: Attitude,
}

/// Weather, global or of one region.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WeatherState {
    /// Layers, lowest base first.
    pub layers: Vec<LayerState>,
    /// Meteorological visibility at the ground (5 % contrast).
    pub visibility_m: f64,
}

/// One cloud layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerState {
    /// Cloud type.
    pub kind: CloudKind,
    /// Height of the base above the ellipsoid.
    pub base_m: f64,
    /// Top minus base.
    pub thickness_m: f64,
    /// Share of the sky hidden, 0 to 1.
    pub coverage: f64,
    /// Factor on the type's usual extinction.
    pub density: f64,
    /// Wind speed.
    pub wind_speed_mps: f64,
    /// Direction that the wind comes from, from true north, clockwise.
    pub wind_from_deg: f64,
    /// Where the wind has carried the pattern: the rotation about the Earth's centre (ECEF axes) that brings the
    /// pattern from where it was when the layer appeared to where it is now. A wind is a rigid rotation, so it has no seam anywhere.
    pub drift: DQuat,
}

/// A region and its weather.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionState {
    /// Outline.
    pub shape: RegionShape,
    /// Its own weather.
    pub weather: WeatherState,
    /// 0 (not there) to 1 (fully there): eases when a region is made or removed.
    pub presence: f64,
    /// While its clouds turn from storm cells into others, or back: how far the weather around gives way to them, 0 to 1. `None`:
    /// as its clouds are (see [`RegionState::gives_way`]).
    pub turning: Option<f64>,
}

impl RegionState {
    /// How far the weather around gives way to the region's: all, but for storm cells, which stand in it.
    pub fn gives_way(&self) -> f64 {
        self.turning.unwrap_or(if self.stands_in() { 0.0 } else { 1.0 })
    }

    /// Whether its clouds are storm cells alone: then the weather around goes on, and they stand in it.
    pub fn stands_in(&self) -> bool {
        !self.weather.layers.is_empty() && self.weather.layers.iter().all(|layer| layer.kind == CloudKind::StormCell)
    }
}

/// Which of the own ship's lights shine in a view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OwnLights {
    /// Landing lights.
    pub landing: bool,
    /// Strobes: they flash by simulation time.
    pub strobe: bool,
}

/// One view.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewState {
    /// Name.
    pub name: String,
    /// Width and height in pixels.
    pub size_px: [u32; 2],
    /// Horizontal field of view.
    pub field_of_view_deg: f64,
    /// Eye point in body axes `[forward, right, down]`.
    pub offset_m: [f64; 3],
    /// Attitude against the body.
    pub attitude: Attitude,
    /// The own ship's lights.
    pub lights: OwnLights,
    /// Exposure.
    pub exposure: Exposure,
    /// The sides of the picture, where they are not those of the field of view.
    pub frustum: Option<Frustum>,
    /// Whether the picture is mirrored, left to right and top to bottom.
    pub mirror: [bool; 2],
    /// The entity that is to carry the view; 0 is the ownship.
    pub entity: u16,
    /// Where that entity is; `None`: the ownship carries the view.
    pub carrier: Option<OwnshipState>,
}

/// A flash, with the light that it gives in the shutter interval.
#[derive(Clone, Debug, PartialEq)]
pub struct FlashState {
    /// Number given by the world, rising.
    pub id: u64,
    /// Centre of the light.
    pub position: Geodetic,
    /// Type.
    pub kind: FlashKind,
    /// Polarity.
    pub polarity: Polarity,
    /// Peak current of its first stroke in kiloamperes.
    pub peak_current_ka: f64,
    /// Simulation time at which it begins.
    pub begin_s: f64,
    /// Simulation time at which its last light ends.
    pub end_s: f64,
    /// Mean luminous intensity over the shutter interval in candela (luminous energy in it / its length / 4 pi): that of all
    /// `lights` together.
    pub intensity_cd: f64,
    /// Seed of its channels.
    pub seed: u64,
    /// The ground point of each of its channels, metres east and north of its place; one of `[0, 0]` for a flash that does not
    /// come to the ground.
    pub ground_points_m: Vec<[f64; 2]>,
    /// Which parts of its channels shine in the shutter interval, with their mean luminous flux in lumens.
    pub lights: Vec<Light>,
    /// The geometry of its channels, the same for as long as it lasts; `None` while it is still being grown, and where it gives
    /// no light.
    pub channel: Option<Arc<StrikeChannel>>,
}

/// Sun and moon as directions from the Earth's centre, ECEF axes, unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkyState {
    /// Towards the sun.
    pub sun_direction_ecef: DVec3,
    /// Towards the moon.
    pub moon_direction_ecef: DVec3,
    /// Lit share of the moon's disc, 0 to 1.
    pub moon_lit_fraction: f64,
    /// Whether the sun shines.
    pub sun_shines: bool,
    /// Whether the moon shines.
    pub moon_shines: bool,
    /// Light of the stars, 0 (none) to 1 (as it is).
    pub starlight: f64,
}

/// What may be spent on a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Slices per cloud layer, 1 to 128 (deck paper eq. 12, N).
    pub slices: u32,
    /// Pixels of the picture each way to one of the deck, 1 to 4: 2 quarters the deck's cost and softens its edges by a
    /// pixel (and 3 is taken for it while the eye is inside a layer).
    pub deck_scale: u32,
    /// How a GPU draws the deck.
    pub deck_form: DeckForm,
    /// Ratio between the radii of neighbouring billboard rings (LOD0), above 1; nearer 1 is finer.
    pub ring_ratio: f64,
    /// How the light inside the deck is stored.
    pub light_encoding: Encoding,
    /// How flashes light the clouds.
    pub relight: Lighting,
    /// Memory in MiB that tables of virtual lights may take, for the ways of lighting that have them.
    pub basis_memory_mib: u32,
}

/// How a GPU draws the deck: the same layers, with the same result to within rounding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DeckForm {
    /// Whichever measured faster (`ARCHITECTURE.md` has the figures).
    #[default]
    Auto,
    /// Instanced geometry, near to far in batches with occlusion between them (deck paper 4).
    Instanced,
    /// One walk a pixel, front to back, in a compute pass.
    Marched,
}
