//! Mathematics that knows no weather: noise, grids, error metrics, seeded random numbers.
