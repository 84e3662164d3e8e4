//! The storms of the world: schedules with a place, from which flashes follow for any moment.
//!
//! A storm that is changed or ended keeps what it was for the flashes that it had begun: each state of it rules from the command
//! that made it to the command that ended it.

use crate::geo::Geodetic;
use crate::geo::frames::{Curvature, enu};
use crate::geo::wgs84::{from_ecef, to_ecef};
use crate::lightning::flash::{Flash, LONGEST_FLASH_S};
use crate::lightning::storm::{Extent, Storm, StormFlash};
use glam::{DVec2, DVec3};
use std::borrow::Cow;

use super::check;
use super::command::{StormRequest, StrikeRequest, Strokes};
use super::event::Refused;
use super::light::Ongoing;
use super::limits;

/// Numbers of storms' flashes begin here, far above those of flashes that are asked for one by one.
const FIRST_ID: u64 = 1 << 52;
/// Bits of the number of a flash within its storm's state: 2^30 seconds of slots.
const NUMBER_BITS: u32 = 37;
/// States of storms that have numbers of their own; then numbers come again.
const STATES: u64 = 1 << 14;
/// No longer stretch of time is looked through for flashes that ended in it.
const LONGEST_LOOK_S: f64 = 60.0;

/// Whether a flash of this number belongs to a storm.
pub fn is_of_storm(id: u64) -> bool {
    id >= FIRST_ID
}

/// One storm between two commands.
#[derive(Clone, Debug)]
struct State {
    number: u64,
    request: StormRequest,
    storm: Storm,
    begin_s: f64,
    /// Infinite while it rages.
    end_s: f64,
}

impl State {
    fn rages(&self) -> bool {
        self.end_s.is_infinite()
    }

    /// Its flashes that begin in `[begin_s, end_s)`.
    fn flashes(&self, begin_s: f64, end_s: f64) -> impl Iterator<Item = StormFlash> + '_ {
        self.storm.flashes(begin_s.max(self.begin_s), end_s.min(self.end_s))
    }
}

/// All storms.
#[derive(Clone, Debug, Default)]
pub(super) struct Storms {
    states: Vec<State>,
    made: u64,
    /// Up to when flashes that ended have been told.
    told_s: f64,
}

impl Storms {
    /// Begins a storm, or changes the one of that name.
    ///
    /// # Errors
    /// [`Refused`], and nothing has changed: a value out of range, a bad name, or too many storms.
    pub fn edit(&mut self, request: &StormRequest, now_s: f64) -> Result<(), Refused> {
        check_request(request)?;
        if self.states.iter().any(|state| state.rages() && state.request == *request) {
            // Said again, it goes on.
            return Ok(());
        }
        let others = self.states.iter().filter(|state| state.rages() && state.request.name != request.name).count();
        check::at_most("storm", others + 1, limits::MAX_STORMS, "storms")?;
        self.end(&request.name, now_s);
        let number = self.made % STATES;
        self.made += 1;
        let (request, storm) = (request.clone(), schedule(request));
        self.states.push(State { number, request, storm, begin_s: now_s, end_s: f64::INFINITY });
        Ok(())
    }

    /// Ends a storm; flashes under way go on to their ends.
    ///
    /// # Errors
    /// [`Refused`] when there is none of that name.
    pub fn remove(&mut self, name: &str, now_s: f64) -> Result<(), Refused> {
        if self.end(name, now_s) {
            return Ok(());
        }
        let there: Vec<&str> = self.raging().map(|request| request.name.as_str()).collect();
        let limit = if there.is_empty() { "there is none".to_owned() } else { format!("one of: {}", there.join(", ")) };
        Err(Refused::new("name", name, limit, "no such storm"))
    }

    /// The storms that rage, in the order in which they began or were changed last.
    pub fn raging(&self) -> impl Iterator<Item = &StormRequest> {
        self.states.iter().filter(|state| state.rages()).map(|state| &state.request)
    }

    /// The flashes that began in `[begin_s, end_s)`; `altitude_m` gives the height of those that do not say one.
    pub fn begun(&self, begin_s: f64, end_s: f64, altitude_m: impl Fn(&Geodetic) -> f64) -> Vec<Ongoing<'static>> {
        let one = |state: &State, drawn: StormFlash| {
            let place = place(&state.request, drawn.place_m);
            let altitude_m = state.request.altitude_m.unwrap_or_else(|| altitude_m(&place));
            let [lowest, highest] = limits::PEAK_CURRENT_KA;
            let current_ka = drawn.peak_current_ka.clamp(lowest, highest);
            Ongoing {
                id: FIRST_ID + (state.number << NUMBER_BITS) + drawn.number,
                position: Geodetic { altitude_m, ..place },
                kind: drawn.kind,
                polarity: drawn.polarity,
                seed: drawn.seed,
                begin_s: drawn.at_s,
                flash: Cow::Owned(Flash::sample(drawn.kind, drawn.polarity, Some(current_ka), false, drawn.seed)),
            }
        };
        self.states.iter().flat_map(|state| state.flashes(begin_s, end_s).map(move |drawn| one(state, drawn))).collect()
    }

    /// Numbers of the flashes that ended since the last call (of the last minute and, after a longer pause, of those under way
    /// when it began).
    pub fn take_finished(&mut self, now_s: f64) -> Vec<u64> {
        let told_s = self.told_s;
        self.told_s = now_s.max(told_s);
        if now_s <= told_s || self.states.is_empty() {
            return Vec::new();
        }
        let mut stretches = vec![[told_s - LONGEST_FLASH_S, now_s]];
        if now_s - told_s > LONGEST_LOOK_S {
            // A picture's shutter is open for a second at most: what was seen had begun by then.
            stretches = vec![[told_s - LONGEST_FLASH_S, told_s + 1.0], [now_s - LONGEST_LOOK_S, now_s]];
        }
        let ended = |flash: &Ongoing<'_>| flash.end_s() > told_s && flash.end_s() <= now_s;
        let all = stretches.into_iter().flat_map(|[begin_s, end_s]| self.begun(begin_s, end_s, |_| 0.0));
        let finished = all.filter(ended).map(|flash| flash.id).collect();
        self.states.retain(|state| state.end_s + LONGEST_FLASH_S > now_s);
        finished
    }

    /// Begins to tell of flashes at this moment: for a world that replaces another.
    pub fn tell_from(&mut self, now_s: f64) {
        self.told_s = now_s;
    }

    /// Numbers of the flashes under way at a moment.
    pub fn under_way(&self, now_s: f64) -> Vec<u64> {
        let begun = self.begun(now_s - LONGEST_FLASH_S, now_s + 1.0, |_| 0.0);
        begun.iter().filter(|flash| flash.end_s() > now_s).map(|flash| flash.id).collect()
    }

    fn end(&mut self, name: &str, now_s: f64) -> bool {
        let Some(at) = self.states.iter().position(|state| state.rages() && state.request.name == name) else {
            return false;
        };
        self.states[at].end_s = now_s;
        // A state without flashes under way is not kept, or a storm that follows an aircraft would leave thousands.
        if self.states[at].flashes(now_s - LONGEST_FLASH_S, now_s).next().is_none() {
            self.states.remove(at);
        }
        true
    }
}

/// The strike that a storm's flash of this number would be, now.
pub fn strike(request: &StormRequest, number: u64) -> StrikeRequest {
    let drawn = schedule(request).flash(number);
    let place = place(request, drawn.place_m);
    StrikeRequest {
        latitude_deg: place.latitude_rad.to_degrees(),
        longitude_deg: place.longitude_rad.to_degrees(),
        altitude_m: request.altitude_m,
        at_s: None,
        kind: drawn.kind,
        polarity: drawn.polarity,
        peak_current_ka: Some(drawn.peak_current_ka.clamp(limits::PEAK_CURRENT_KA[0], limits::PEAK_CURRENT_KA[1])),
        strokes: Strokes::Sample,
        leader: false,
        seed: drawn.seed,
    }
}

fn schedule(request: &StormRequest) -> Storm {
    // Storms of one seed and different names must not flash together (FNV-1a).
    let name = request
        .name
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3));
    Storm {
        extent: Extent {
            size_east_m: request.size_east_m,
            size_north_m: request.size_north_m,
            corner_radius_m: request.corner_radius_m,
            rotation_deg: request.rotation_deg,
        },
        flashes_per_minute: request.flashes_per_minute,
        inside_share: request.inside_share,
        positive_share: request.positive_share,
        current_factor: request.current_factor,
        seed: request.seed ^ name,
    }
}

/// A place east and north of a storm's centre, at height 0: along the great circle, so that it is right for a thousand kilometres.
fn place(request: &StormRequest, [east_m, north_m]: [f64; 2]) -> Geodetic {
    let centre = Geodetic {
        latitude_rad: request.latitude_deg.to_radians(),
        longitude_rad: request.longitude_deg.to_radians(),
        altitude_m: 0.0,
    };
    let local = DVec2::new(east_m, north_m);
    let radius_m = Curvature::at(centre.latitude_rad).mean_m();
    let angle = local.length() / radius_m;
    let flat = local.normalize_or_zero() * angle.sin();
    let up = enu(&centre) * DVec3::new(flat.x, flat.y, angle.cos());
    let sphere = from_ecef(to_ecef(&centre) + (up - enu(&centre).z_axis) * radius_m);
    Geodetic { altitude_m: 0.0, ..sphere }
}

fn check_request(request: &StormRequest) -> Result<(), Refused> {
    check::name("name", &request.name)?;
    for (field, value, limit) in [
        ("latitude_deg", request.latitude_deg, limits::LATITUDE_DEG),
        ("longitude_deg", request.longitude_deg, limits::LONGITUDE_DEG),
        ("size_east_m", request.size_east_m, limits::REGION_SIZE_M),
        ("size_north_m", request.size_north_m, limits::REGION_SIZE_M),
        ("rotation_deg", request.rotation_deg, limits::TURN_DEG),
        ("flashes_per_minute", request.flashes_per_minute, limits::FLASHES_PER_MINUTE),
        ("inside_share", request.inside_share, limits::SHARE),
        ("positive_share", request.positive_share, limits::SHARE),
        ("current_factor", request.current_factor, limits::CURRENT_FACTOR),
    ] {
        check::within(field, value, limit)?;
    }
    if let Some(altitude_m) = request.altitude_m {
        check::within("altitude_m", altitude_m, limits::STRIKE_ALTITUDE_M)?;
    }
    let most_m = request.size_east_m.min(request.size_north_m) / 2.0;
    check::within("corner_radius_m", request.corner_radius_m, [0.0, most_m])
}

#[cfg(test)]
mod tests;
