//! The own ship's landing light and strobes in cloud and haze: what is scattered once towards the eye.
//!
//! *What it is.* Along a ray, the light of a few lamps beside the eye, `I(direction) p(angle) sigma / r^2`, through what lies on both
//! ways. *How it is computed.* A sum over ranges that grow by a fixed ratio from a lamp's distance to where nothing comes back
//! ([`ranges_m`]); at them the plan has looked up the extinction along the view's axis, cloud with its detail and haze, and
//! other rays are taken as alike: so wisps that pass are seen in the beam, in both executors from the same numbers. What is
//! scattered forwards goes on: only `1 - g^2` of the extinction takes light away (delta-M).
//!
//! What is left out: light scattered more than once. On the ground the lamps are a part of [`super::ground`].

pub mod twin;

use bytemuck::{Pod, Zeroable};

/// Lamps at most.
pub const LAMPS: usize = 4;
/// Ranges at which the extinction is known.
pub const LOOKS: usize = 20;
/// The first range, m.
pub const NEAREST_M: f32 = 1.5;
/// Ratio of each range to the one before: the last lies at 400 m.
pub const RATIO: f32 = 1.341_7;
/// Share of extinction that takes light out of its way: 1 - g^2 for droplets of g = 0.85.
pub const TAKEN: f32 = 0.2775;

/// One lamp. Parameters; twin of `Lamp` in `beams.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Lamp {
    /// Place against the eye: east, north, up, m.
    pub position_m: [f32; 3],
    /// Luminous intensity on its axis, cd.
    pub intensity_cd: f32,
    /// Direction in which it shines: east, north, up.
    pub axis: [f32; 3],
    /// 1 over the square of the angle (radians) at which it has fallen to 1/e; 0: it shines all round.
    pub narrowness: f32,
}

/// The lamps of a picture. Parameters; twin of `Beams` in `beams.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Beams {
    /// Lamps in use.
    pub lamps: u32,
    /// Pads to 16 bytes.
    pub pad0: u32,
    /// Pads to 16 bytes.
    pub pad1: u32,
    /// Pads to 16 bytes.
    pub pad2: u32,
    /// The lamps.
    pub lamp: [Lamp; LAMPS],
    /// Extinction at the ranges along the view's axis, 1/m.
    pub extinction_per_m: [f32; LOOKS],
}

/// The ranges, m.
pub fn ranges_m() -> [f32; LOOKS] {
    std::array::from_fn(|k| NEAREST_M * RATIO.powi(k as i32))
}
