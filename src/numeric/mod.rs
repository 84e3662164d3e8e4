//! Mathematics that knows no weather: seeded random numbers, periodic noise, directions on the sphere, error metrics, exact
//! elementary functions, Laplace's equation.

pub mod exact;
pub mod haar;
pub mod hash;
pub mod metrics;
pub mod noise;
pub mod poisson;
pub mod sphere;
pub mod vector;
