//! The veil: how much of the light of places in the sky comes to the eye through the clouds between.
//!
//! A channel in or behind cloud glows through it as far as the cloud is thin. The deck's own picture does not tell how far away
//! its cloud is, so each place is asked for by itself: a walk from the eye to it through each layer, for a few hundred places
//! of a channel and not for each pixel. The depth adds up whatever the order of the layers.

pub mod twin;

use bytemuck::{Pod, Zeroable};

/// A place, and what comes through from it. Parameters and result; twin of `Node` in `common.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Node {
    /// East, north, height over the tangent plane at the eye's ground point, m.
    pub position_m: [f32; 3],
    /// Share of its light that the layers walked so far let through; 1 to begin with.
    pub passed: f32,
}
