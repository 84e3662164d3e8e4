//! Light of a flash inside the clouds: transport in grids, its Monte Carlo reference. Knows no clock, no client, no GPU.

pub mod medium;
pub mod monte_carlo;
pub mod phase;
pub mod slab;

mod walk;
