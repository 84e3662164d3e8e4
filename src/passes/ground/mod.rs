//! The ground: land and sea under sun, sky and clouds.
//!
//! Land and sea come from the large map at continental scale until real coastlines are there; fields and forests vary
//! the land's albedo from near to far. The source's light is what reaches the ground between the clouds, times what the
//! shadows leave of it (see [`super::shadow`]); where these are left out, what the layers let through on the whole.

pub mod twin;

use crate::passes::common::{CHARTS, Chart};
use crate::passes::deck::{FLASHES, Flash};
use bytemuck::{Pod, Zeroable};

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
    /// Luminance of a city's lights seen from above at night, cd/m2; 0 by day.
    pub city_luminance: f32,
    /// Illuminance by sky and clouds, lux per colour.
    pub sky_lux: [f32; 3],
    /// Number of charts in use.
    pub charts: u32,
    /// Charts of the ground's textures: `map_origin` at the map's own scale, `tile_origin_m` unused.
    pub chart: [Chart; CHARTS],
    /// The flashes.
    pub flash: [Flash; FLASHES],
}
