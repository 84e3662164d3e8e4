//! stormdeck: a headless visual-system server for flight simulators.
//!
//! The flow goes one way: `bytes -> Command -> World -> Snapshot -> FramePlan -> passes -> Frame -> Encoded -> bytes`.
//! `ARCHITECTURE.md` has the map of the modules and the invariants that `tests/architecture.rs` enforces.

pub mod bytes;
pub mod cli;
pub mod clouds;
pub mod encode;
pub mod frame;
pub mod geo;
pub mod gpu;
pub mod lightning;
pub mod numeric;
pub mod outputs;
pub mod passes;
pub mod plan;
pub mod reference;
pub mod report;
pub mod scattering;
pub mod serve;
pub mod settings;
pub mod units;
pub mod wire;
pub mod world;
