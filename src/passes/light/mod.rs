//! Sunlight and skylight inside a deck, precomputed into the 256 x 256 x 32 texture (deck paper 3.2).
//!
//! *What it is.* For each voxel four shares of the light outside: red, the directional light after multiple forward
//! scattering; green, its diffuse part; blue, skylight; alpha, light from below. All for one typical theta of the layer and
//! one direction of the light.
//!
//! *How we compute it.* Optical depths by recurrence from slice to slice (eq. 7 for the exponent): downwards along the
//! light and from the zenith, upwards likewise. With them
//! - forward scattering: `exp(-(1 - b) tau)`, the exact factor of a slice (eq. 5-7 in their bounded form; the printed
//!   recurrence `e^-t + b t` gains energy for large t), b the share scattered into the forward cone;
//! - diffuse light: Eddington's solution of a conservative slab, `4 pi J = F (2 + 3 (1 - g) tau_below)` with the net flux
//!   `F = E mu T`, `T = ((2/3 + mu) + (2/3 - mu) e^(-tau/mu)) / (4/3 + (1 - g) tau)`, which at optical depths 5, 10, 20
//!   and 40 transmits 0.80, 0.59, 0.38 and 0.23 of vertical light (Monte Carlo: 0.77, 0.58, 0.38, 0.23);
//! - light of sky and ground: the same for even, diffuse light from one side, which keeps the white furnace: a cloud in an
//!   even light is not to be seen.
//!
//! *How we store it.* Square roots in 8 bits: dark values keep relative precision. *How we read it back.* Trilinear, squared.

pub mod twin;

use bytemuck::{Pod, Zeroable};

/// Asymmetry of the droplets' phase function.
pub const ASYMMETRY: f32 = 0.85;
/// Share of scattered light that stays in the forward cone (eq. 4: F gamma / 4 pi as an exact cone fraction).
pub const FORWARD_SHARE: f32 = 0.55;
/// Stored diffuse values are shares of this many times the light outside over 4 pi.
pub const DIFFUSE_RANGE: f32 = 5.0;

/// Parameters of one light volume. Parameters; twin of `Light` in `light.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Light {
    /// Towards the light in the axes of the volume (x, y, up); up is at least 0.07.
    pub direction: [f32; 3],
    /// Threshold theta.
    pub theta: f32,
    /// Horizontal size of a voxel.
    pub voxel_m: f32,
    /// Height of a voxel.
    pub voxel_height_m: f32,
    /// Extinction where the cloud is whole, 1/m.
    pub extinction_per_m: f32,
    /// 1 over the shape value from edge to whole.
    pub inverse_edge: f32,
    /// Straight pieces of the light's path through one slice.
    pub pieces: u32,
    /// Pads to 16 bytes.
    pub pad0: u32,
    /// Pads to 16 bytes.
    pub pad1: u32,
    /// Pads to 16 bytes.
    pub pad2: u32,
}
