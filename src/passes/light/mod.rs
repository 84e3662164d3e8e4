//! Sunlight and skylight inside a deck, tabulated over the tile, over theta and over the light's direction (deck paper 3.2).
//!
//! *What it is.* For each voxel of a 128 x 128 x 32 volume, for a few thetas ([`Nodes`]) and a few directions ([`grid`]), what
//! the source function of the cloud there is made from (see [`Shares`]): the light that still comes from the source's side,
//! the diffuse light with its net flux, and the sky's. Read at a point with the theta that rules there.
//!
//! *How we compute it* ([`node`]). Optical depths by recurrence from slice to slice (eq. 7 for the exponent): downwards along
//! the light and from the zenith, upwards likewise. With them
//! - forward scattering: `exp(-0.12 tau)`, the exact factor of a slice (eq. 5-7 in their bounded form; the printed recurrence
//!   `e^-t + b t` gains energy for large t), its lobe broader the more of it has been scattered;
//! - diffuse light: Eddington's solution for what leaves that beam, with reduced depths `t = (1 - g) tau`, light on the slab at
//!   the cosine mu and net flux `F = mu T`, `T = ((2/3 + mu) + (2/3 - mu) e^(-t/mu)) / (4/3 + t)`:
//!   `G = 2 (mu - F) - 3 F t + 3 mu^2 (1 - e^(-t/mu))`, which at depth 0 and at the bottom leaves the slab whole;
//! - light of sky and ground: the same for even, diffuse light from one side, which keeps the white furnace: a cloud in an
//!   even light is not to be seen.
//!
//! Flanks that face the light are lit as facets that do (mu goes to 1), tops as level ones.
//!
//! *How it is drawn.* Scattering is so much forward that the source function is nearly the light that arrives:
//! `(G + 3 g F . towards the eye) / 4 pi`. With it a slab sends out what enters it; by `G` alone thick clouds gained light at
//! their tops and kept half of it at their bases.
//!
//! *How we store it* ([`encoding`]): by choice. *How we read it back* ([`volume`]): trilinear, between two thetas.
//!
//! No shader: the tables are made on the processor for both executors, so that they cannot differ between them, and so
//! that those that will be needed next are made ahead while the device draws ([`library`]). They are read in `deck/lit.wgsl`.
//! No twin: `node` and `volume` serve both executors; what is read from them has its twin in `encoding`.

pub mod encoding;
pub mod grid;
pub mod library;
pub mod node;
pub mod volume;

#[cfg(test)]
mod tests;

use crate::clouds::density::TILE_M;
use encoding::Encoding;
use grid::Corner;

/// Asymmetry of the droplets' phase function.
pub const ASYMMETRY: f32 = 0.85;
/// Share of what is scattered that leaves the forward beam. With the lobes of `deck::field::phases` it was chosen so that slabs
/// of depth 5 to 40 send up and down what Monte Carlo says (within 14 % under vertical light).
pub const LEAVING: f32 = 0.12;
/// Factor of the net flux in the source function: 3 g of Eddington's approximation.
pub const FLUX_FACTOR: f32 = 3.0 * ASYMMETRY;
/// Voxels east and north: half as many as the density volume has; light is smoother than cloud.
pub const WIDTH: usize = 128;
/// Voxels upwards for each theta.
pub const HEIGHT: usize = crate::clouds::density::HEIGHT;
/// Width of a voxel.
pub const VOXEL_M: f32 = TILE_M / WIDTH as f32;

/// Thetas of one layer's volumes: whole multiples of a step, so that weather that eases finds most of them made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nodes {
    /// The first, in steps.
    pub first: i32,
    /// How many; at least 1.
    pub count: u32,
    /// Distance between two.
    pub step: f32,
}

impl Nodes {
    /// Nodes at most: a layer whose theta varies more has wider steps.
    pub const MOST: u32 = 8;
    /// Usual distance between two.
    pub const STEP: f32 = 0.12;

    /// Those around every theta from `low` to `low + range`. Below minus the edge all is whole, above 1 nothing is left.
    pub fn around(low: f32, range: f32, edge: f32) -> Self {
        Self::spaced(low, range, edge, Self::STEP.max(range / (Self::MOST - 2) as f32))
    }

    /// The same with a step of one's own, over 0.
    pub fn spaced(low: f32, range: f32, edge: f32, step: f32) -> Self {
        let node = |theta: f32| (theta.clamp(-edge, 1.0) / step) as f64;
        let (first, last) = (node(low).floor() as i32, node(low + range).ceil() as i32);
        Self { first, count: (last - first).max(0) as u32 + 1, step }
    }

    /// Theta of node `k`, counted from the first.
    pub fn theta(&self, k: u32) -> f32 {
        (self.first + k as i32) as f32 * self.step
    }
}

/// What the light volumes of one layer in one chart are made from; equal parameters and one genus give the same bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Directions of the grid around the light's, and their weights.
    pub corners: [Corner; 3],
    /// Thetas.
    pub nodes: Nodes,
    /// Height of a voxel.
    pub voxel_height_m: f32,
    /// Extinction where the cloud is whole, 1/m.
    pub extinction_per_m: f32,
    /// 1 over the shape value from edge to whole.
    pub inverse_edge: f32,
    /// Whether the tile is one cloud with nothing beside it: light does not come out of one side and in at the other.
    pub bounded: bool,
    /// How it is stored.
    pub encoding: Encoding,
}

/// Light in a voxel, for an illuminance of 1 of a plane facing the source and of the level plane by the sky.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shares {
    /// What is left of the forward beam, 0 to 1.
    pub beam: f32,
    /// 4 pi times the mean intensity of diffuse light from the source, 0 to 5.
    pub diffuse: f32,
    /// Net flux through the slab over what enters it, 0 to 1.
    pub through: f32,
    /// 4 pi times the mean intensity by the sky, 0 to 4; by the ground it is 4 less that.
    pub sky: f32,
    /// How far the facet that is lit faces the source: 0 level, 1 facing it.
    pub facing: f32,
}
