//! Strokes: the channels of lightning themselves, as light that lies over the picture.
//!
//! What it is: each stretch of a channel is a straight line of light, laid through a Gaussian of the channel's width or of the
//! pixel's, whichever is wider. How it is computed: a line through a Gaussian has a closed form, whose sum over all pixels is the
//! line's light whatever its length and width; so a channel thinner than a pixel keeps its light, joints do not show, and nothing
//! flickers as it moves. How it is stored: one value a pixel (the colour is one), scaled so that f16 holds it.
//! Clouds hide it as far as the veil says ([`super::veil`]); what lies behind the horizon is not in the plan.

pub mod twin;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// A stretch of a channel in the picture. Parameters; twin of `Segment` in `stroke.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Segment {
    /// One end in pixels from the upper left corner.
    pub from_px: [f32; 2],
    /// The other end.
    pub to_px: [f32; 2],
    /// Luminance times pixels that it covers, cd/m2, as it is behind the air between.
    pub light: f32,
    /// Standard deviation of its profile, pixels.
    pub sigma_px: f32,
    /// Where the first end lies between its node of the veil and the next one.
    pub share_from: f32,
    /// The same of the other end.
    pub share_to: f32,
    /// Its node of the veil; the next one is the other end of what it is part of.
    pub node: u32,
    /// Pads to 8 bytes.
    pub pad: u32,
}

/// How the strokes' image is made. Parameters; twin of `Strokes` in `stroke.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Strokes {
    /// Value of the image for a luminance of 1 cd/m2.
    pub scale: f32,
    /// Pads to 16 bytes.
    pub pad0: f32,
    /// Pads to 16 bytes.
    pub pad1: f32,
    /// Pads to 16 bytes.
    pub pad2: f32,
}

/// Colour of a channel's light: blue-white, as of a black body of 24,000 K; `FLASH_COLOUR` of the shaders.
pub const COLOUR: Vec3 = Vec3::new(0.80, 0.90, 1.25);
/// Narrowest profile in pixels: a Gaussian of this width, taken at pixels' centres, holds its sum to 2 exp(-2 pi^2 sigma^2) =
/// 1.6e-3 wherever it lies.
pub const NARROWEST_PX: f32 = 0.6;
/// Standard deviations beyond which nothing is drawn: 6e-5 of the light lie there.
pub const REACH: f32 = 4.0;
/// A shorter line is taken as a point, pixels: its ends would be told apart by rounding alone.
pub const SHORTEST_PX: f32 = 0.05;
