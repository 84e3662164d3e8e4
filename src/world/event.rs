//! Events and queries: what the world says back. The wire turns them into messages.

use super::snapshot::Snapshot;
use crate::geo::Geodetic;
use std::sync::Arc;

/// A client's mistake: what was wrong, and what would be right. Nothing has changed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{field} = {value}: {why} (limit: {limit})")]
pub struct Refused {
    /// Path of the field, as in `layers[2].base_m`.
    pub field: String,
    /// The value given, shortened if long.
    pub value: String,
    /// What is allowed.
    pub limit: String,
    /// The reason in words.
    pub why: String,
}

impl Refused {
    /// A refusal from its four parts.
    pub fn new(
        field: impl Into<String>,
        value: impl ToString,
        limit: impl Into<String>,
        why: impl Into<String>,
    ) -> Self {
        let mut value = value.to_string();
        if value.chars().count() > 80 {
            value = value.chars().take(77).collect::<String>() + "...";
        }
        Self { field: field.into(), value, limit: limit.into(), why: why.into() }
    }
}

/// What the world did with a command.
#[derive(Clone, Debug, PartialEq)]
pub enum Applied {
    /// Done; nothing more to say.
    Done,
    /// A flash was accepted and has this number; the event that names its first frame follows.
    Flash {
        /// The flash's number.
        id: u64,
    },
}

/// A piece of thunder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThunderPiece {
    /// Simulation time at which it begins to be heard.
    pub at_s: f64,
    /// Distance of its loudest part.
    pub distance_m: f64,
    /// Direction of that from true north, clockwise, 0 to 360.
    pub bearing_deg: f64,
    /// Height of that above the horizontal plane.
    pub elevation_deg: f64,
    /// Sound pressure level in decibels above 20 micropascals, the peaks of its parts added as energies.
    pub level_db: f64,
}

/// Something that happened, told to whom it concerns.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A flash is seen for the first time in this frame of this view.
    StrikeShown {
        /// The flash's number.
        id: u64,
        /// The view's name.
        view: String,
        /// Number of the first frame of that view that shows it.
        frame: u64,
        /// Simulation time of that frame.
        simulation_time_s: f64,
        /// Peak current of its first stroke in kiloamperes, negative for a negative one.
        current_ka: f64,
    },
    /// A flash was over before any view had a frame to show it.
    StrikeMissed {
        /// The flash's number.
        id: u64,
    },
    /// What the ownship will hear of a flash.
    Thunder {
        /// The flash's number.
        id: u64,
        /// Where the ownship was when it began.
        listener: Geodetic,
        /// Simulation time at which the last of it has been heard.
        end_s: f64,
        /// Its pieces in the order in which they are heard, at least one.
        pieces: Vec<ThunderPiece>,
    },
    /// The state asked for.
    State(Arc<Snapshot>),
}
