//! What the ownship hears of a flash, from its channels and strokes: worked out beside the world, since it may grow a channel.

use crate::geo::Geodetic;
use crate::geo::frames::enu;
use crate::geo::wgs84::to_ecef;
use crate::lightning::flash::Flash;
use crate::lightning::thunder::air::Air;
use crate::lightning::thunder::heard::heard;
use crate::lightning::thunder::{FARTHEST_M, Rumble, summary};
use glam::DVec3;
use std::sync::Arc;

use super::event::{Event, ThunderPiece};
use super::growing::Growing;

/// Most pieces of one thunder in an event.
const MOST_PIECES: usize = 24;
/// No channel reaches farther from its flash's place.
const REACH_M: f64 = 30_000.0;

/// A flash that has begun, and who listens.
#[derive(Clone, Debug)]
pub struct Thunder {
    /// The flash's number.
    pub flash: u64,
    /// Simulation time at which it began.
    pub begin_s: f64,
    /// Its place, at height 0.
    pub ground: Geodetic,
    /// Where the ownship was when it began.
    pub listener: Geodetic,
    /// Its strokes.
    pub strokes: Flash,
    /// Its channels.
    pub channel: Arc<Growing>,
}

impl Thunder {
    /// Whether any of it may be heard, as far as can be told without its channels.
    pub fn near(&self) -> bool {
        (to_ecef(&self.ground) - to_ecef(&self.listener)).length() < FARTHEST_M + REACH_M
    }

    /// Works it out, growing the channels where nobody has yet: some milliseconds. `None`: nothing is heard.
    pub fn event(&self) -> Option<Event> {
        let channel = self.channel.grow()?;
        let axes = enu(&self.ground);
        let listener_m = axes.transpose() * (to_ecef(&self.listener) - to_ecef(&self.ground));
        let pulses = heard(&channel, &self.strokes, listener_m.to_array(), &Air::default());
        let rumbles = summary(&pulses, MOST_PIECES);
        if rumbles.is_empty() {
            return None;
        }
        let to_listener = enu(&self.listener).transpose() * axes;
        let piece = |rumble: &Rumble| {
            let towards = to_listener * DVec3::from_array(rumble.direction);
            ThunderPiece {
                at_s: self.begin_s + rumble.arrival_s,
                distance_m: rumble.distance_m,
                bearing_deg: towards.x.atan2(towards.y).to_degrees().rem_euclid(360.0),
                elevation_deg: towards.z.clamp(-1.0, 1.0).asin().to_degrees(),
                level_db: rumble.level_db,
            }
        };
        let last_s = pulses.iter().map(|pulse| pulse.arrival_s + pulse.spread_s + pulse.period_s).fold(0.0, f64::max);
        Some(Event::Thunder {
            id: self.flash,
            listener: self.listener,
            end_s: self.begin_s + last_s,
            pieces: rumbles.iter().map(piece).collect(),
        })
    }
}
