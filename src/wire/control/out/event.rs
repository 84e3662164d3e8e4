//! Events: what happened, told to whom it concerns.

use crate::world::event::Event;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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
            Event::State(_) => None,
        }
    }
}
