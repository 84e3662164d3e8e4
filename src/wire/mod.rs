//! The wire: bytes to commands and events to bytes, and nothing but bytes. Pure: no socket, no clock.

pub mod cigi;
pub mod control;
pub mod frames;
pub mod heights;
pub mod json;
pub mod limits;
pub mod scenario;
pub mod schema;
