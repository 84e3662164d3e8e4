//! A flash as geometry and time: channels by four methods, strokes, photometry.

pub mod branches;
pub mod channel;
mod charges;
pub mod dbm;
pub mod error;
pub mod field;
pub mod flash;
mod frontier;
pub mod grid;
pub mod grow;
pub mod guard;
pub mod laplacian;
pub mod photometry;
pub mod random;
pub mod rational;
pub mod reed_wyvill;
pub mod scene;
pub mod shape;
pub mod statistics;
pub mod storm;
pub mod strike;
pub mod tables;
pub mod thunder;
pub mod tortuosity;
mod urn;
mod walls;
pub mod waypoints;
