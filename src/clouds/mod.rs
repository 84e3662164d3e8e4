//! A deck as numbers: genera, density, coverage, light, rings and slices. Knows no clock, no client and no GPU.

pub mod cell;
pub mod clearance;
pub mod coverage;
pub mod density;
pub mod detail;
pub mod kind;
pub mod modulation;
pub mod slices;
pub mod warp;

#[cfg(test)]
mod tests;

pub use kind::{Appearance, CloudKind};
