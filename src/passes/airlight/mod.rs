//! Light of lightning that the air scatters: the glow in haze around a channel, once scattered.
//!
//! What it is: along a ray, the light of a point that haze and molecules scatter once towards the eye, integrated over the ray
//! with the air's density by height. How it is computed: the angle at which the ray's points are seen from the light takes the
//! place of the range (ds / r^2 = d angle / d), which leaves a smooth integrand without the pole of 1 / r^2 (Kulla and Fajardo
//! 2012, "Importance sampling techniques for path tracing in participating media", 4.1), and a dozen even steps do. A channel is
//! a few such lights, each as wide as the part that it stands for. How it is stored: one value a pixel of a coarse image, since
//! it has no edge anywhere.
//!
//! What is left out: light scattered more than once, and shadows of clouds in the haze; each light counts as far as the
//! veil shows it.

pub mod twin;

use bytemuck::{Pod, Zeroable};

/// A light that stands for a part of a channel. Parameters; twin of `Source` in `airlight.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Source {
    /// East, north, height over the tangent plane at the eye's ground point, m.
    pub position_m: [f32; 3],
    /// Luminous intensity, cd.
    pub intensity_cd: f32,
    /// Half the width of the part that it stands for, m: a ray passes it no nearer than this.
    pub width_m: f32,
    /// Its node of the veil.
    pub node: u32,
    /// Pads to 16 bytes.
    pub pad0: f32,
    /// Pads to 16 bytes.
    pub pad1: f32,
}

/// How the image is made. Parameters; twin of `Airlight` in `airlight.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Airlight {
    /// Value of the image for a luminance of 1 cd/m2.
    pub scale: f32,
    /// Number of lights.
    pub sources: u32,
    /// Pads to 16 bytes.
    pub pad0: f32,
    /// Pads to 16 bytes.
    pub pad1: f32,
}

/// Steps of the integral.
pub const STEPS: u32 = 12;
/// Beyond this range along a ray air is too thin, or too far, to count, m.
pub const FARTHEST_M: f32 = 150_000.0;
/// Lights of all channels of one picture at most.
pub const MOST_SOURCES: usize = 32;
