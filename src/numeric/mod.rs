//! Mathematics that knows no weather: seeded random numbers, periodic noise, directions on the sphere.

pub mod hash;
pub mod noise;
pub mod sphere;
