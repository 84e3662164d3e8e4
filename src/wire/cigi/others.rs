//! The packets of the standards that are passed over: names for the log and for the pages of `protocol/`, and why.

use super::Version;

/// A standard packet without a layout here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Other {
    /// Id in CIGI 3.3.
    pub v3: Option<u16>,
    /// Id in CIGI 4.0.
    pub v4: Option<u16>,
    /// Name.
    pub name: &'static str,
    /// Why it has no effect.
    pub reason: &'static str,
}

const NO_MODELS: &str = "no models, parts or animations are drawn";
const NO_SEA: &str = "the sea is flat and glitters as in a wind of 5 m/s";
const NO_SURFACE: &str = "the ground has one look in all weathers";
const NO_SENSOR: &str = "the eye is the only sensor";
const NO_COLLISION: &str = "nothing is there to collide with; heights are asked for by HAT/HOT";
const NO_SYMBOLS: &str = "nothing is laid over the picture";
const NO_ANSWER: &str = "an answer to a request that is not understood";

const fn other(v3: i32, v4: i32, name: &'static str, reason: &'static str) -> Other {
    const fn id(id: i32) -> Option<u16> {
        if id < 0 { None } else { Some(id as u16) }
    }
    Other { v3: id(v3), v4: id(v4), name, reason }
}

/// All of them, host to image generator first; -1: the version does not have it.
pub const OTHERS: &[Other] = &[
    other(3, 2, "Conformal Clamped Entity Control", "the eye is placed by Entity Control or Entity Position"),
    other(6, 5, "Articulated Part Control", NO_MODELS),
    other(7, 6, "Short Articulated Part Control", NO_MODELS),
    other(8, 7, "Rate Control (4.0: Velocity Control)", "motion between messages follows from the positions sent"),
    other(-1, 0x13, "Acceleration Control", "motion between messages follows from the positions sent"),
    other(13, 0x0c, "Maritime Surface Conditions Control", NO_SEA),
    other(14, 0x0d, "Wave Control", NO_SEA),
    other(15, 0x0e, "Terrestrial Surface Conditions Control", NO_SURFACE),
    other(17, 0x10, "Sensor Control", NO_SENSOR),
    other(18, 0x11, "Motion Tracker Control", "no tracker is connected to the server"),
    other(19, 0x12, "Earth Reference Model Definition", "the Earth is WGS 84, and Start of Frame says so"),
    other(20, -1, "Trajectory Definition", NO_MODELS),
    other(22, 0x15, "Collision Detection Segment Definition", NO_COLLISION),
    other(23, 0x16, "Collision Detection Volume Definition", NO_COLLISION),
    other(27, 0x1a, "Position Request", "the host knows where it put the eye; no parts are drawn"),
    other(29, 0x1c, "Symbol Surface Definition", NO_SYMBOLS),
    other(30, 0x1d, "Symbol Text Definition", NO_SYMBOLS),
    other(31, 0x1e, "Symbol Circle Definition", NO_SYMBOLS),
    other(32, 0x1f, "Symbol Line Definition (4.0: Symbol Polygon Definition)", NO_SYMBOLS),
    other(33, 0x20, "Symbol Clone", NO_SYMBOLS),
    other(34, 0x21, "Symbol Control", NO_SYMBOLS),
    other(35, 0x22, "Short Symbol Control", NO_SYMBOLS),
    other(-1, 0x23, "Symbol Textured Circle Definition", NO_SYMBOLS),
    other(-1, 0x24, "Symbol Textured Polygon Definition", NO_SYMBOLS),
    other(106, 0x0ffb, "Sensor Response", NO_ANSWER),
    other(107, 0x0ffa, "Sensor Extended Response", NO_ANSWER),
    other(108, 0x0ff9, "Position Response", NO_ANSWER),
    other(111, 0x0ff6, "Maritime Surface Conditions Response", NO_SEA),
    other(112, 0x0ff5, "Terrestrial Surface Conditions Response", NO_SURFACE),
    other(113, 0x0ff4, "Collision Detection Segment Notification", NO_ANSWER),
    other(114, 0x0ff3, "Collision Detection Volume Notification", NO_ANSWER),
    other(115, 0x0ff2, "Animation Stop Notification", NO_ANSWER),
];

/// Whether an id is left to users: 201 to 255 in CIGI 3.3; 0x1000 to 0x7fff (registered) and 0x8000 to 0xfffe (local) in 4.0.
pub fn is_user_defined(version: Version, packet_id: u16) -> bool {
    match version {
        Version::V3 => (201..=255).contains(&packet_id),
        Version::V4 => (0x1000..=0xfffe).contains(&packet_id),
    }
}

/// Whether a packet of this name stands first in a message, and only there.
pub fn opens_a_message(name: &str) -> bool {
    matches!(name, "IG Control" | "Start of Frame")
}

/// What a skipped packet is, for people.
pub fn name_of(version: Version, packet_id: u16) -> &'static str {
    if is_user_defined(version, packet_id) {
        return "a user-defined packet";
    }
    let id = |other: &Other| match version {
        Version::V3 => other.v3,
        Version::V4 => other.v4,
    };
    OTHERS.iter().find(|other| id(other) == Some(packet_id)).map_or("a packet of no known kind", |other| other.name)
}
