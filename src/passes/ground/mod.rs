//! The ground: land and sea under sun, sky and clouds.
//!
//! Where there is land and how it rises comes from the relief (see [`super::relief`]); what grows on it is made up: fields in
//! blocks, woods, meadows, rock and snow by height and slope, from near to far. The source's light is what reaches the ground between the clouds, times what the
//! shadows of clouds (see [`super::shadow`]) and of hills (see [`hills`]) leave of it; where the former are left out, what the layers let through on the whole.

pub mod glow;
pub mod hills;
pub mod lamps;
pub mod lights;
pub mod twin;

use crate::passes::beams::{LAMPS, Lamp};
use crate::passes::common::{CHARTS, Chart};
use crate::passes::deck::{FLASHES, Flash};
use bytemuck::{Pod, Zeroable};

/// Period of the fields: 32 blocks of 2048 m.
pub const FIELDS_TILE_M: f32 = 65_536.0;

/// Light on the ground and where its textures lie. Parameters; twin of `Ground` in `ground.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Ground {
    /// Illuminance of a plane facing the light, lux per colour.
    pub light_lux: [f32; 3],
    /// Number of flashes in use.
    pub flashes: u32,
    /// Direction towards the light.
    pub light_direction: [f32; 3],
    /// Luminance of a city's core seen from above at night, cd/m2; 0 by day.
    pub city_luminance: f32,
    /// Illuminance by sky and clouds, lux per colour.
    pub sky_lux: [f32; 3],
    /// Number of charts in use.
    pub charts: u32,
    /// Height above which snow lies.
    pub snow_m: f32,
    /// Distance from the shore where no grids tell it: far above 0 on land, far below at sea.
    pub shore_m: f32,
    /// What a city's clouds send down of its light: lux where the luminance of lamps around is that of a core.
    pub glow_lux: f32,
    /// Level of the grids that is as smooth as that light is on the ground.
    pub glow_level: f32,
    /// [`Ground::light_lux`] above the layers that ground may reach through.
    pub above_light_lux: [f32; 3],
    /// Base of the lowest of them; ground below has what comes through them.
    pub sheet_base_m: f32,
    /// [`Ground::sky_lux`] above them.
    pub above_sky_lux: [f32; 3],
    /// Top of the highest of them; far above all ground where there are none.
    pub sheet_top_m: f32,
    /// Lamps of the own ship that light the ground.
    pub lamps: u32,
    /// 1: the source stands so low that hills shade each other.
    pub hills: u32,
    /// Pads to 16 bytes.
    pub pad0: u32,
    /// Pads to 16 bytes.
    pub pad1: u32,
    /// The lamps.
    pub lamp: [Lamp; LAMPS],
    /// Charts of the ground's textures: `map_origin` at the map's own scale, `tile_origin_m` in periods of [`FIELDS_TILE_M`].
    pub chart: [Chart; CHARTS],
    /// The flashes.
    pub flash: [Flash; FLASHES],
}
