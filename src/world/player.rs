//! The scenario player: applies a timeline's entries as they become due, and goes back by playing again from the start.

use super::check;
use super::command::Command;
use super::event::Refused;
use super::light;
use super::limits;
use super::snapshot::FlashState;
use super::state::State;
use super::storms::is_of_storm;
use super::timeline::Timeline;
use crate::lightning::guard::FlickerGuard;
use std::collections::BTreeSet;
use std::sync::Arc;

/// A scenario under way, or none.
#[derive(Clone, Debug)]
pub struct Player {
    timeline: Option<Arc<Timeline>>,
    /// The first entry that has not been applied.
    next: usize,
    /// Flashes of the scenario are numbered from here by their entry's index, so that a seek gives them the same numbers.
    first_flash_id: u64,
    playing: bool,
    speed: f64,
    refusals: Vec<(usize, Refused)>,
}

impl Default for Player {
    fn default() -> Self {
        Self { timeline: None, next: 0, first_flash_id: 1, playing: true, speed: 1.0, refusals: Vec::new() }
    }
}

impl Player {
    /// Lets the time of `state` go on, through all entries that become due.
    pub fn advance(&mut self, state: &mut State, to_s: f64) {
        if !to_s.is_finite() {
            return;
        }
        let to_s = to_s.min(self.end_s());
        if let Some(timeline) = self.timeline.clone() {
            while let Some(entry) = timeline.entries.get(self.next).filter(|entry| entry.at_s <= to_s) {
                state.advance(entry.at_s);
                let flash_id = self.first_flash_id + self.next as u64;
                let room = self.refusals.len() < limits::MAX_SCENARIO_REFUSALS;
                match state.apply(&entry.command, Some(flash_id)) {
                    Err(refused) if room => self.refusals.push((self.next, refused)),
                    _ => (),
                }
                self.next += 1;
            }
        }
        state.advance(to_s);
    }

    /// The flashes of which some part lies in `[begin_s, end_s)`, `begin_s` being the time of `state`: those that there are, and
    /// those that the scenario strikes before the shutter closes. A picture shows these although their entries are not due
    /// when it opens, or the light of their first strokes would be lost.
    pub fn flashes(&self, state: &State, [begin_s, end_s]: [f64; 2], guard: Option<FlickerGuard>) -> Vec<FlashState> {
        let memory_s = guard.map_or(0.0, |guard| guard.memory_s());
        let mut ahead;
        let mut ongoing = state.ongoing([begin_s, end_s], memory_s);
        let entries = self.timeline.as_ref().map_or(&[][..], |timeline| &timeline.entries[self.next..]);
        let due =
            || entries.iter().zip(self.next as u64..).take_while(|(entry, _)| entry.at_s < end_s.min(self.end_s()));
        let strikes =
            |command: &Command| matches!(command, Command::Strike(_) | Command::Storm(_) | Command::RemoveStorm { .. });
        if due().any(|(entry, _)| strikes(&entry.command)) {
            ahead = state.clone();
            for (entry, index) in due() {
                ahead.advance(entry.at_s);
                // A refusal is told when the entry becomes due.
                let _told_later = ahead.apply(&entry.command, Some(self.first_flash_id + index));
            }
            // Storms know there what they were before; of the strikes those that are over by then are gone there.
            ongoing.retain(|flash| !is_of_storm(flash.id));
            let known: BTreeSet<u64> = ongoing.iter().map(|flash| flash.id).collect();
            let later = ahead.ongoing([begin_s, end_s], memory_s);
            ongoing.extend(later.into_iter().filter(|flash| !known.contains(&flash.id)));
        }
        ongoing.sort_by_key(|flash| flash.id);
        light::states(&ongoing, begin_s, end_s, guard)
    }

    /// Replaces `state` by the start of a (validated) scenario and plays it at speed 1.
    pub fn load(&mut self, state: &mut State, timeline: Arc<Timeline>) {
        let first_flash_id = state.next_flash_id();
        *self = Self { first_flash_id, timeline: Some(timeline), ..Self::default() };
        self.restart(state, 0.0);
    }

    /// Goes to a time by playing the scenario again from its start; what came from elsewhere in between is gone.
    ///
    /// # Errors
    /// [`Refused`] without a scenario, or for a time outside it.
    pub fn seek(&mut self, state: &mut State, at_s: f64) -> Result<(), Refused> {
        if self.timeline.is_none() {
            return Err(Refused::new("at_s", at_s, "a scenario must be loaded", "nothing to seek in"));
        }
        check::within("at_s", at_s, [0.0, self.end_s()])?;
        self.restart(state, at_s);
        Ok(())
    }

    /// Whether the time runs by itself.
    pub fn playing(&self, now_s: f64) -> bool {
        self.playing && now_s < self.end_s()
    }

    /// Lets the time run or stops it.
    pub fn set_playing(&mut self, playing: bool) {
        self.playing = playing;
    }

    /// Seconds of simulation per second of wall clock.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Sets the speed.
    ///
    /// # Errors
    /// [`Refused`] out of range.
    pub fn set_speed(&mut self, factor: f64) -> Result<(), Refused> {
        check::within("factor", factor, limits::SPEED)?;
        self.speed = factor;
        Ok(())
    }

    /// The scenario.
    pub fn timeline(&self) -> Option<&Timeline> {
        self.timeline.as_deref()
    }

    /// Entries refused since the last call.
    pub fn take_refusals(&mut self) -> Vec<(usize, Refused)> {
        std::mem::take(&mut self.refusals)
    }

    fn end_s(&self) -> f64 {
        let duration_s = self.timeline.as_ref().map_or(0.0, |timeline| timeline.duration_s);
        if duration_s > 0.0 { duration_s } else { limits::SIMULATION_TIME_S[1] }
    }

    fn restart(&mut self, state: &mut State, at_s: f64) {
        let abandoned = state.abandon_flashes();
        let entries = self.timeline.as_ref().map_or(0, |timeline| timeline.entries.len()) as u64;
        let next_flash_id = state.next_flash_id().max(self.first_flash_id + entries);
        *state = State::new(next_flash_id);
        self.next = 0;
        self.refusals.clear();
        self.advance(state, at_s);
        state.inherit(abandoned, next_flash_id);
    }
}

/// Every complaint about a scenario with its entry's index; those about the whole have the number of entries.
pub fn validate(timeline: &Timeline) -> Vec<(usize, Refused)> {
    let mut complaints = Vec::new();
    let whole = timeline.entries.len();
    if let Err(refused) = check::within("duration_s", timeline.duration_s, limits::SIMULATION_TIME_S) {
        complaints.push((whole, refused));
    }
    if let Err(refused) = check::at_most("entries", whole, limits::MAX_TIMELINE_ENTRIES, "entries") {
        complaints.push((whole, refused));
        return complaints;
    }
    let end_s = if timeline.duration_s > 0.0 { timeline.duration_s } else { limits::SIMULATION_TIME_S[1] };
    let mut state = State::new(1);
    for (index, entry) in timeline.entries.iter().enumerate() {
        let time = check::within("at_s", entry.at_s, [0.0, end_s]).and_then(|()| {
            if entry.at_s >= state.now_s() {
                return Ok(());
            }
            let limit = format!("at least {}, the time of the entry before", state.now_s());
            Err(Refused::new("at_s", entry.at_s, limit, "not in rising order"))
        });
        match time {
            Ok(()) => state.advance(entry.at_s),
            Err(refused) => complaints.push((index, refused)),
        }
        if let Err(refused) = state.apply(&entry.command, Some(index as u64 + 1)) {
            complaints.push((index, refused));
        }
    }
    complaints
}
