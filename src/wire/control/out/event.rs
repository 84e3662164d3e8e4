//! Events: what happened, told to whom it concerns.

use crate::units::deg;
use crate::world::event::{Event, ThunderPiece};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A piece of thunder.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ThunderJson {
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

impl From<&ThunderPiece> for ThunderJson {
    fn from(piece: &ThunderPiece) -> Self {
        let ThunderPiece { at_s, distance_m, bearing_deg, elevation_deg, level_db } = *piece;
        Self { at_s, distance_m, bearing_deg, elevation_deg, level_db }
    }
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum EventMessage {
    /// A flash is seen for the first time in this frame of this view.
    StrikeShown {
        /// The flash's number, from the `ack` of its `strike`.
        flash: u64,
        /// The view's name.
        view: String,
        /// Number of the first frame of that view that shows it.
        frame: u64,
        /// Simulation time of that frame.
        simulation_time_s: f64,
    },
    /// A flash was over before any view had a frame to show it.
    StrikeMissed {
        /// The flash's number.
        flash: u64,
    },
    /// What the ownship will hear of a flash, told when it begins: where it is within some 25 km.
    Thunder {
        /// The flash's number.
        flash: u64,
        /// WGS84 latitude of the ownship when the flash began: the listener.
        latitude_deg: f64,
        /// WGS84 longitude of the listener.
        longitude_deg: f64,
        /// Height of the listener above the ellipsoid.
        altitude_m: f64,
        /// Simulation time at which the last of it has been heard.
        end_s: f64,
        /// Pieces of it, in the order in which they are heard.
        pieces: Vec<ThunderJson>,
    },
    /// The host role was taken.
    HostTaken {
        /// Number of the client that holds it now.
        client: u64,
    },
    /// The host role is free again.
    HostFree,
    /// Something failed in the server; what it was doing is lost, the connection and the world are not.
    Fault {
        /// What failed.
        what: String,
    },
}

impl EventMessage {
    /// The message for an event of the world; `None` for a state, which has its own message.
    pub fn from_world(event: &Event) -> Option<Self> {
        match event {
            Event::StrikeShown { id, view, frame, simulation_time_s, .. } => Some(Self::StrikeShown {
                flash: *id,
                view: view.clone(),
                frame: *frame,
                simulation_time_s: *simulation_time_s,
            }),
            Event::StrikeMissed { id } => Some(Self::StrikeMissed { flash: *id }),
            Event::Thunder { id, listener, end_s, pieces } => Some(Self::Thunder {
                flash: *id,
                latitude_deg: deg(listener.latitude_rad),
                longitude_deg: deg(listener.longitude_rad),
                altitude_m: listener.altitude_m,
                end_s: *end_s,
                pieces: pieces.iter().map(ThunderJson::from).collect(),
            }),
            Event::State(_) => None,
        }
    }
}
