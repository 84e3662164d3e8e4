//! Mathematics that knows no weather: seeded random numbers, periodic noise, directions on the sphere, error metrics.

pub mod hash;
pub mod metrics;
pub mod noise;
pub mod sphere;
