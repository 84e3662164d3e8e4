//! Mathematics that knows no weather: seeded random numbers and periodic noise.

pub mod hash;
pub mod noise;
