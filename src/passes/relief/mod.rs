//! Where rays meet the ground: heights around the eye, and the range to them for each pixel.
//!
//! The one height function of the house (`geo::terrain`) is put on grids around the eye ([`window`]): levels of doubling
//! spacing that lie still on the ground, so that nothing moves while the eye flies. Between the levels it is a matter of the
//! distance alone. Rays are followed over the grids once a pixel; the ground, the deck and the shadows read the range.
//!
//! `field.wgsl` reads the grids and stands before this pass and the ground's; its twin is [`field`].

pub mod field;
pub mod twin;
pub mod window;

use bytemuck::{Pod, Zeroable};

/// Levels of a window.
pub const LEVELS: usize = 8;

/// How the grids lie around the eye. Parameters; twin of `Relief` in `field.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Relief {
    /// Complex factor `a` of the chart that the grids lie in (see `geo::charts`).
    pub a: [f32; 2],
    /// Complex factor `c`, 1/m.
    pub c: [f32; 2],
    /// Factors on the eye's stereographic coordinate, east and north: the Earth is no sphere.
    pub stretch: [f32; 2],
    /// Spacing of the first level's nodes.
    pub spacing_m: f32,
    /// No ground of the window is higher.
    pub highest_m: f32,
    /// For each level: where the eye is, in nodes (east, north in the chart), the spacing in metres, and the metres of one
    /// unit of its distances from the shore.
    pub level: [[f32; 4]; 8],
}
