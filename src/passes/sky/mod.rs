//! The sky: light scattered by the air, sun, moon, and the floor of the night sky.
//!
//! The scattered light of a moment is tabulated over the directions (see [`table`]); the table also gives the haze that
//! lies over ground and clouds, so that everything fades into the sky that is behind it. Stars are points (see [`stars`]).

pub mod atmosphere;
mod inscatter;
pub mod lamps;
pub mod multiple;
pub mod shade;
pub mod stars;
pub mod table;
pub mod twin;

use bytemuck::{Pod, Zeroable};

/// Where the table's halves meet and what shines by itself. Parameters; twin of `Sky` in `common.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Sky {
    /// Towards the sun (east, north, up).
    pub sun_direction: [f32; 3],
    /// Cosine of the sun's angular radius.
    pub sun_cosine: f32,
    /// Luminance of the sun's disc as seen through the air, cd/m2.
    pub sun_luminance: [f32; 3],
    /// Upward component of the direction to the geometric horizon.
    pub horizon: f32,
    /// Towards the moon.
    pub moon_direction: [f32; 3],
    /// Cosine of the moon's angular radius.
    pub moon_cosine: f32,
    /// Luminance of the lit part of the moon's disc as seen through the air, cd/m2.
    pub moon_luminance: [f32; 3],
    /// Factor from the table's stored values to cd/m2.
    pub table_scale: f32,
}

/// How rays are turned into the catalogue's axes, and how a star is spread. Parameters; twin of `Stars` in `sky.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Stars {
    /// The catalogue's first axis in east, north, up.
    pub x: [f32; 3],
    /// 1 over twice the square of the spread, 1/rad2.
    pub sharpness: f32,
    /// The second axis.
    pub y: [f32; 3],
    /// Luminance in the middle of a star over its illuminance, 1/sr.
    pub strength: f32,
    /// The third axis.
    pub z: [f32; 3],
    /// Pads to 16 bytes.
    pub pad0: f32,
}
