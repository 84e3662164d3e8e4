//! The world: the only mutable truth. Commands go in, snapshots come out.
//!
//! Everything that moves is kept as where it came from and where it goes, and evaluated for a moment: the state at a time
//! depends on the commands and their times alone, never on how often anybody looked or in what steps the time went.

pub mod command;
pub mod event;
pub mod limits;
pub mod regions;
pub mod snapshot;
pub mod storms;
pub mod thunder;
pub mod timeline;

mod check;
mod clock;
mod drift;
mod ease;
pub mod growing;
mod layer;
mod light;
mod ownship;
mod player;
mod state;
mod strikes;
mod views;
mod weather;

pub use command::Command;
pub use event::{Applied, Event, Refused};
pub use snapshot::Snapshot;
pub use timeline::{TimedCommand, Timeline};

use crate::geo::terrain::Terrain;
use crate::lightning::flash::LONGEST_FLASH_S;
use crate::lightning::guard::FlickerGuard;
use crate::passes::light::encoding::Encoding;
use crate::passes::relight::Lighting;
use command::ScenarioEdit;
use growing::Growing;
use player::Player;
use snapshot::{DeckForm, Quality};
use state::State;
use std::sync::Arc;
use thunder::Thunder;

/// The quality of a new world.
pub const DEFAULT_QUALITY: Quality = Quality {
    slices: 32,
    ring_ratio: 4.0,
    deck_scale: 1,
    deck_form: DeckForm::Auto,
    light_encoding: Encoding::Shares8,
    relight: Lighting::Solve,
    basis_memory_mib: 256,
};

/// The world.
#[derive(Clone, Debug)]
pub struct World {
    state: State,
    player: Player,
    quality: Quality,
    guard: Option<FlickerGuard>,
    terrain: Terrain,
    snapshots: u64,
}

impl Default for World {
    fn default() -> Self {
        Self::new()
    }
}

impl World {
    /// Ownship at 47 N 8 E, 1500 m; clear, visibility 40 km; one view "main" of 640 x 360 and 60 degrees;
    /// 2026-06-21T11:30:00Z at rate 1; no scenario, the time running; the ground is the bare ellipsoid.
    pub fn new() -> Self {
        let (quality, terrain) = (DEFAULT_QUALITY, Terrain::ELLIPSOID);
        Self { state: State::new(1), player: Player::default(), quality, terrain, guard: None, snapshots: 0 }
    }

    /// Applies a command at the present simulation time.
    ///
    /// # Errors
    /// [`Refused`], and nothing at all has changed.
    pub fn apply(&mut self, command: Command) -> Result<Applied, Refused> {
        match command {
            Command::Scenario(edit) => self.scenario(edit).map(|()| Applied::Done),
            other => self.state.apply(&other, None),
        }
    }

    /// Lets the simulation time go on to a later moment (an earlier one, or what is no number, is ignored); what the
    /// scenario has in between is applied in order, each entry at its own time. The time stops at the scenario's end and
    /// at the limit of simulation time.
    pub fn advance_to(&mut self, simulation_time_s: f64) {
        self.player.advance(&mut self.state, simulation_time_s);
    }

    /// Simulation time in seconds since the world or the scenario began.
    pub fn simulation_time_s(&self) -> f64 {
        self.state.now_s()
    }

    /// Whether the time runs by itself: not while paused, nor at the scenario's end. (`advance_to` always works.)
    pub fn playing(&self) -> bool {
        self.player.playing(self.state.now_s())
    }

    /// Seconds of simulation per second of wall clock while playing.
    pub fn speed(&self) -> f64 {
        self.player.speed()
    }

    /// The scenario that is loaded.
    pub fn timeline(&self) -> Option<&Timeline> {
        self.player.timeline()
    }

    /// Names of the views, in their order.
    pub fn view_names(&self) -> impl Iterator<Item = &str> {
        self.state.view_names()
    }

    /// Takes a snapshot whose pictures gather the light of `[now, now + shutter_s)`; flashes asked for "now" begin with it.
    /// A shutter interval that is negative or no number is taken as 0: one instant.
    ///
    /// Channels of flashes that have not been grown are grown here, a few milliseconds each.
    pub fn snapshot(&mut self, shutter_s: f64) -> Snapshot {
        self.begin_snapshot();
        self.look(shutter_s, true)
    }

    /// The same without waiting for any channel: flashes whose channel is not there yet light clouds and ground alone, and the
    /// snapshot is provisional ([`Snapshot::provisional`]).
    pub fn snapshot_at_once(&mut self, shutter_s: f64) -> Snapshot {
        self.begin_snapshot();
        self.look(shutter_s, false)
    }

    /// The same without counting it or beginning anything: for an answer to somebody who asks, not for a picture.
    pub fn peek(&self, shutter_s: f64) -> Snapshot {
        self.look(shutter_s, false)
    }

    /// Channels that are still to be grown, each given out once: whoever takes them may grow them on any thread.
    pub fn take_growing(&self) -> Vec<Arc<Growing>> {
        self.state.take_growing()
    }

    fn begin_snapshot(&mut self) {
        self.snapshots += 1;
        self.state.begin_strikes();
    }

    /// `wait`: channels that are not there yet are grown first.
    fn look(&self, shutter_s: f64, wait: bool) -> Snapshot {
        let shutter_s = if shutter_s > 0.0 { shutter_s.min(limits::SIMULATION_TIME_S[1]) } else { 0.0 };
        let mut snapshot = self.state.snapshot(self.snapshots, shutter_s, self.quality, self.terrain.clone());
        snapshot.flashes = self.player.flashes(&self.state, snapshot.shutter_s, self.guard);
        let giving = snapshot.flashes.iter_mut().filter(|flash| !flash.lights.is_empty());
        let giving: Vec<_> = giving.map(|flash| (self.state.channel(flash), flash)).collect();
        if wait {
            growing::grow_all(giving.iter().map(|(channel, _)| channel));
        }
        for (channel, flash) in giving {
            flash.channel = channel.grown();
        }
        snapshot
    }

    /// Sets what may be spent on a picture; out of range is brought to the nearest limit, what is no number changes nothing.
    pub fn set_quality(&mut self, quality: Quality) {
        let [low, high] = limits::RING_RATIO;
        if !quality.ring_ratio.is_nan() {
            self.quality.ring_ratio = quality.ring_ratio.clamp(low, high);
        }
        self.quality.deck_scale = quality.deck_scale.clamp(limits::DECK_SCALE[0], limits::DECK_SCALE[1]);
        self.quality.deck_form = quality.deck_form;
        self.quality.light_encoding = quality.light_encoding;
        self.quality.relight = quality.relight;
        self.quality.basis_memory_mib =
            quality.basis_memory_mib.clamp(limits::BASIS_MEMORY_MIB[0], limits::BASIS_MEMORY_MIB[1]);
        self.quality.slices = quality.slices.clamp(limits::SLICES[0], limits::SLICES[1]);
    }

    /// Limits strokes in any one second, of all flashes together; those that are too many give no light. `None`: no limit.
    pub fn set_flicker_guard(&mut self, guard: Option<FlickerGuard>) {
        self.guard = guard;
    }

    /// The flashes that have begun since the last call, with the ownship as their listener: for whoever tells their thunder. One
    /// that began and ended in a single leap of the time may be missing.
    pub fn take_thunder(&mut self) -> Vec<Thunder> {
        self.state.take_thunder()
    }

    /// Sets where the ground is.
    pub fn set_terrain(&mut self, terrain: Terrain) {
        self.terrain = terrain;
    }

    /// Numbers of the flashes that have ended since the last call, whether anybody saw them or not.
    pub fn finished_flashes(&mut self) -> Vec<u64> {
        // A stroke is judged by those before it, and its current may flow on for as long as a flash lasts.
        let kept_s = self.guard.map_or(0.0, |guard| guard.memory_s() + LONGEST_FLASH_S);
        self.state.take_finished_flashes(kept_s)
    }

    /// Scenario entries (by index) that were refused when they became due, since the last call: a scenario is checked when
    /// it is loaded, so only commands from elsewhere in the meantime can cause one.
    pub fn take_refusals(&mut self) -> Vec<(usize, Refused)> {
        self.player.take_refusals()
    }

    /// Plays a scenario into a world of its own and returns every complaint with its entry's index (complaints about the
    /// scenario as a whole have the number of entries as their index).
    pub fn validate(timeline: &Timeline) -> Vec<(usize, Refused)> {
        player::validate(timeline)
    }

    fn scenario(&mut self, edit: ScenarioEdit) -> Result<(), Refused> {
        match edit {
            ScenarioEdit::Load(timeline) => {
                if let Some((index, refused)) = player::validate(&timeline).into_iter().next() {
                    let entries = timeline.entries.len();
                    let field =
                        if index < entries { format!("entries[{index}].{}", refused.field) } else { refused.field };
                    return Err(Refused { field, ..refused });
                }
                self.player.load(&mut self.state, timeline);
                Ok(())
            }
            ScenarioEdit::Play => {
                self.player.set_playing(true);
                Ok(())
            }
            ScenarioEdit::Pause => {
                self.player.set_playing(false);
                Ok(())
            }
            ScenarioEdit::Seek { at_s } => self.player.seek(&mut self.state, at_s),
            ScenarioEdit::Speed { factor } => self.player.set_speed(factor),
        }
    }
}

#[cfg(test)]
pub(crate) mod testing;
#[cfg(test)]
mod tests;
