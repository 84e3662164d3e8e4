//! Shadows of single clouds on the ground: what each layer lets through on the way from the light to a point of the ground.
//!
//! *What it is.* The transmittance along the light's own, slanted path through a layer, for each place of the 16 km tile and
//! each theta (see [`table`]). Where eq. 19 thresholds a 2D texture, this is the integral of what the threshold leaves.
//! *How it is read.* From a point of the ground the light is followed over the curved Earth to the height at which the path
//! is half-way through the layer; there the charts, the map and the outlines of the regions give place and theta as they do
//! for the deck itself. So shadows follow sun, wind and weather, and are the same for every view.
//! *How they become soft.* The table has coarser levels. The sun's disc makes the edge as wide as the distance to the layer
//! times its diameter; a pixel's footprint on the ground blurs it further. Below a texel (62.5 m) the table is as soft as it is.
//!
//! Lower layers are shaded by higher ones in the same way, through a map of their own (see [`shade`]).
//!
//! Each layer multiplies what the others have left in an image of its own, which the ground reads. Inside a layer the light
//! takes a straight path under the theta of its middle; where two charts are cross-faded, so are their shadows.

pub mod march;
pub mod mean;
pub mod shade;
pub mod table;
pub mod twin;

#[cfg(test)]
mod tests;

use crate::clouds::density;
use crate::passes::light::Light;
use crate::passes::light::grid::LEAST_UP;
use bytemuck::{Pod, Zeroable};

/// Angular diameter of sun and moon, rad.
pub const DISC_RAD: f32 = 0.0093;

/// How a layer's table is read. Parameters; twin of `Shadow` in `shadow.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Shadow {
    /// Height over the sphere at which the light's path is half-way through the layer; above 0.
    pub height_m: f32,
    /// Theta of the table's first entry.
    pub theta_low: f32,
    /// 1 over the step of theta from entry to entry.
    pub inverse_step: f32,
    /// Height over the sphere to which the light is followed from: 0 for the ground, a lower layer's top for its shade.
    pub at_m: f32,
    /// Distance at which the map of a shade is half as fine as in its middle, m.
    pub near_m: f32,
    /// 1 over the logarithm that reaches to the map's rim.
    pub span: f32,
    /// Pads to 16 bytes.
    pub pad0: f32,
    /// Pads to 16 bytes.
    pub pad1: f32,
}

/// What a table is made from; equal parameters and one genus give the same bytes. The threshold is not among them, so that
/// weather that eases makes no table anew.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Columns {
    /// Towards the light in the axes of the volume (x, y, up); up is at least 0.07.
    pub direction: [f32; 3],
    /// Share of the layer's height at which the ground lies, 0 to 1: 0 where the base is above it.
    pub begin: f32,
    /// Top minus base.
    pub thickness_m: f32,
    /// Extinction where the cloud is whole, 1/m.
    pub extinction_per_m: f32,
    /// Shape value from edge to whole.
    pub edge: f32,
    /// Samples of the path for each voxel of its height.
    pub pieces: u32,
    /// Whether nothing lies beside the tile; else it repeats.
    pub bounded: bool,
}

impl Columns {
    /// The columns of a layer above the ground, for light from a direction in a chart's axes: what its light volume is made
    /// from, the direction rounded to a quarter of a degree.
    pub fn new([x, y, up]: [f32; 3], light: &Light, begin: f32) -> Self {
        let step = 0.25f32.to_radians();
        let rounded = |angle: f32| (angle / step).round() * step;
        // Lower light is taken from there: its path through a whole tile would repeat the tile.
        let elevation = rounded(up.clamp(-1.0, 1.0).asin()).max(LEAST_UP);
        let azimuth = rounded(y.atan2(x));
        let direction = [azimuth.cos() * elevation.cos(), azimuth.sin() * elevation.cos(), elevation.sin()];
        let shift = light.voxel_height_m / elevation.tan() / table::TEXEL_M;
        Self {
            direction,
            begin,
            thickness_m: light.voxel_height_m * density::HEIGHT as f32,
            extinction_per_m: light.extinction_per_m,
            edge: 1.0 / light.inverse_edge,
            pieces: (shift.ceil() as u32).clamp(1, 8),
            bounded: light.bounded,
        }
    }

    /// Share of the layer's height at which the light's path through it is half-way.
    pub fn middle(&self) -> f32 {
        0.5 * (self.begin + 1.0)
    }

    /// How the table of these columns is read, for a layer with its base at a height.
    pub fn shadow(&self, base_m: f32, thickness_m: f32) -> Shadow {
        Shadow {
            height_m: (base_m + thickness_m * self.middle()).max(1.0),
            theta_low: table::theta(0, self.edge),
            inverse_step: 1.0 / (table::theta(1, self.edge) - table::theta(0, self.edge)),
            at_m: 0.0,
            near_m: shade::NEAR_M,
            span: 1.0,
            pad0: 0.0,
            pad1: 0.0,
        }
    }
}
