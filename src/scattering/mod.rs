//! Light of a flash inside the clouds: transport in grids, its Monte Carlo reference. Knows no clock, no client, no GPU.

pub mod angles;
pub mod balance;
pub mod basis;
pub mod compress;
pub mod deck;
pub mod direct;
pub mod file;
pub mod krylov;
pub mod lanes;
pub mod lights;
pub mod medium;
pub mod monte_carlo;
pub mod ordinates;
pub mod phase;
pub mod relight;
pub mod slab;
pub mod view;
pub mod walk;

mod diffusion;
mod operator;
mod path;
mod rays;
mod reconstruct;
mod surface;
