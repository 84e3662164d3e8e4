//! Control messages: JSON texts of the protocol `stormdeck.v1`, one file a message family.

pub(in crate::wire) mod decode;
pub(in crate::wire) mod family;
mod instant;
pub mod names;
pub mod out;
pub mod ownship;
pub mod question;
pub mod region;
pub mod scenario;
pub mod session;
pub mod storm;
pub mod strike;
pub mod time;
pub mod view;
pub mod weather;

pub use decode::{decode, decode_outbound, encode, encode_inbound};
pub use out::Outbound;
pub use question::{PointJson, SegmentQuery, VectorQuery};
pub use session::{Format, Role, WhenSlow};

use crate::world::command::Command;

/// The version of the control protocol that `hello` has to name.
pub const PROTOCOL: &str = "stormdeck.v1";

/// A decoded message of a client.
#[derive(Clone, Debug, PartialEq)]
pub struct Inbound {
    /// Number given by the client, echoed in the answer.
    pub seq: Option<u64>,
    /// What it says.
    pub message: Message,
}

/// What a client can say.
#[derive(Clone, Debug, PartialEq)]
pub enum Message {
    /// Introduces the client: the first message of a connection.
    Hello(Hello),
    /// Changes the world (only the host's are taken).
    Command(Command),
    /// Loads a scenario of the server's folder by its name without `.json`; resolved by the server.
    LoadScenario {
        /// Name: small letters, digits and `-`.
        name: String,
    },
    /// Asks for the frames of a view; replaces an earlier subscription to it.
    Subscribe(Subscription),
    /// Ends the subscription to a view.
    Unsubscribe {
        /// The view's name.
        view: String,
    },
    /// Lockstep: advances to a simulation time and renders exactly one frame of each view.
    Step {
        /// Simulation time to go to.
        to_s: f64,
    },
    /// Asks without changing anything.
    Query(Query),
}

/// Who a client is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Hello {
    /// Role wanted.
    pub role: Role,
    /// Name for the log, and for those who are refused because it holds the host role.
    pub name: Option<String>,
    /// Takes the host role from its holder, where the server's settings allow it.
    pub take_over: bool,
    /// Access token, where the server wants one and it was not in the HTTP request.
    pub token: Option<String>,
}

/// A wish for frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Subscription {
    /// The view's name.
    pub view: String,
    /// Format of the pictures.
    pub format: Format,
    /// At most so many frames a second.
    pub max_rate_hz: f64,
    /// Quality 1-100 for JPEG; `None`: the server's setting.
    pub quality: Option<u8>,
    /// What happens when the client reads too slowly.
    pub when_slow: WhenSlow,
}

/// A question.
#[derive(Clone, Debug, PartialEq)]
pub enum Query {
    /// The state of the world.
    State,
    /// The plan of a view's next frame.
    Plan {
        /// The view's name.
        view: String,
    },
    /// Counters and rates of the server.
    Statistics,
    /// Height above the ground, and of the ground, at a point.
    Heights(PointJson),
    /// What hides one point from another.
    LineOfSightSegment(SegmentQuery),
    /// What a ray meets first.
    LineOfSightVector(VectorQuery),
    /// The weather at a point.
    Conditions(PointJson),
}

#[cfg(test)]
mod tests;
