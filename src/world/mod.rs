//! The world: the only mutable truth. Commands go in, snapshots come out.

pub mod command;
pub mod event;
pub mod snapshot;
pub mod timeline;
