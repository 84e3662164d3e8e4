//! The host's part of a scenario: which messages go out before which ownship, and where the ownship is.
//!
//! A scenario holds few ownship messages; a real host sends one a frame. So the scenario is played in a world of our own,
//! and the ownship is asked there.

use crate::cli::Failure;
use crate::geo::Geodetic;
use crate::world::World;
use crate::world::command::{Command, Ownship, ScenarioEdit};
use crate::world::timeline::Timeline;
use std::sync::Arc;

/// Shutter of the world of our own; it draws nothing.
const NO_SHUTTER_S: f64 = 0.0;

/// What is sent before one ownship message, and that message.
#[derive(Debug, PartialEq)]
pub(super) struct Tick {
    /// Seconds since the scenario's start.
    pub(super) time_s: f64,
    /// Commands that have become due, in the scenario's order.
    pub(super) due: Vec<Command>,
    /// Where the ownship is now.
    pub(super) ownship: Ownship,
}

/// The scenario, cut into ticks.
pub(super) struct Part {
    timeline: Arc<Timeline>,
    world: World,
    interval_s: f64,
    /// Host frames count on from here; above 0, which says that no ownship has come.
    first_host_frame: u32,
    ticks: u32,
    next_tick: u32,
    next_entry: usize,
}

impl Part {
    /// `rate_hz`: ownship messages per second of simulation; `most`: ends after so many. Host frames count on from
    /// `first_host_frame`.
    pub(super) fn new(
        timeline: Timeline,
        rate_hz: f64,
        most: Option<u32>,
        first_host_frame: u32,
    ) -> Result<Self, Failure> {
        let whole = (timeline.duration_s * rate_hz).ceil().clamp(0.0, f64::from(u32::MAX / 2)) as u32;
        let ticks = most.unwrap_or(whole);
        if ticks == 0 {
            return Err(Failure::Input("the scenario has no end: say how many --frames to send".to_owned()));
        }
        let timeline = Arc::new(timeline);
        let mut world = World::new();
        world
            .apply(Command::Scenario(ScenarioEdit::Load(Arc::clone(&timeline))))
            .map_err(|refused| Failure::Input(refused.to_string()))?;
        let interval_s = 1.0 / rate_hz;
        Ok(Self { timeline, world, interval_s, first_host_frame, ticks, next_tick: 0, next_entry: 0 })
    }

    /// How many ticks there are.
    pub(super) fn ticks(&self) -> u32 {
        self.ticks
    }

    /// Seconds between ticks.
    pub(super) fn interval_s(&self) -> f64 {
        self.interval_s
    }

    /// The commands that make the starting state, without the ownship.
    pub(super) fn start(&mut self) -> Vec<Command> {
        self.due(0.0)
    }

    fn due(&mut self, time_s: f64) -> Vec<Command> {
        let entries = &self.timeline.entries[self.next_entry..];
        let due: Vec<_> = entries.iter().take_while(|entry| entry.at_s <= time_s).map(|e| e.command.clone()).collect();
        self.next_entry += due.len();
        due.into_iter().filter(|command| !matches!(command, Command::Ownship(_))).collect()
    }

    /// The next tick; `None` at the end.
    pub(super) fn next(&mut self) -> Option<Tick> {
        if self.next_tick == self.ticks {
            return None;
        }
        let time_s = f64::from(self.next_tick) * self.interval_s;
        self.next_tick += 1;
        self.world.advance_to(time_s);
        let due = self.due(time_s);
        Some(Tick { time_s, due, ownship: self.ownship(self.first_host_frame + self.next_tick) })
    }

    fn ownship(&self, host_frame: u32) -> Ownship {
        let state = self.world.peek(NO_SHUTTER_S).ownship;
        let Geodetic { latitude_rad, longitude_rad, altitude_m } = state.position;
        let velocity_ned_mps =
            self.timeline.entries[..self.next_entry].iter().rev().find_map(|entry| match &entry.command {
                Command::Ownship(ownship) => Some(ownship.velocity_ned_mps),
                _ => None,
            });
        Ownship {
            latitude_deg: latitude_rad.to_degrees(),
            longitude_deg: longitude_rad.to_degrees(),
            altitude_m,
            yaw_deg: state.attitude.yaw_rad.to_degrees(),
            pitch_deg: state.attitude.pitch_rad.to_degrees(),
            roll_deg: state.attitude.roll_rad.to_degrees(),
            velocity_ned_mps: velocity_ned_mps.flatten(),
            host_frame,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::command::{TimeEdit, WeatherEdit};
    use crate::world::timeline::TimedCommand;

    fn timeline(duration_s: f64) -> Timeline {
        let ownship = Ownship {
            latitude_deg: 10.0,
            longitude_deg: 20.0,
            altitude_m: 1_000.0,
            yaw_deg: 0.0,
            pitch_deg: 0.0,
            roll_deg: 0.0,
            velocity_ned_mps: Some([0.0, 0.0, -10.0]),
            host_frame: 0,
        };
        let entry = |at_s, command| TimedCommand { at_s, command };
        let entries = vec![
            entry(0.0, Command::Time(TimeEdit { utc_s: Some(0.0), rate: None })),
            entry(0.0, Command::Ownship(ownship)),
            entry(0.6, Command::Weather(WeatherEdit { visibility_m: Some(5_000.0), ..WeatherEdit::default() })),
        ];
        Timeline { name: "t".into(), description: String::new(), duration_s, entries }
    }

    #[test]
    fn ticks_carry_what_is_due_and_the_ownship_moves() {
        let mut part = Part::new(timeline(1.0), 4.0, None, 100).expect("a part");
        assert_eq!((part.ticks(), part.start().len()), (4, 1));
        let ticks: Vec<Tick> = std::iter::from_fn(|| part.next()).collect();
        assert_eq!(ticks.iter().map(|t| t.due.len()).collect::<Vec<_>>(), [0, 0, 0, 1]);
        assert_eq!(ticks.iter().map(|t| t.ownship.host_frame).collect::<Vec<_>>(), [101, 102, 103, 104]);
        // 10 m/s upwards; the altitude is carried exactly, the rest of the tolerance is the rounding of f64.
        for tick in &ticks {
            assert!((tick.ownship.altitude_m - (1_000.0 + 10.0 * tick.time_s)).abs() < 1e-6, "{tick:?}");
        }
    }

    #[test]
    fn a_scenario_without_an_end_needs_a_number_of_frames() {
        assert!(Part::new(timeline(0.0), 4.0, None, 0).is_err());
        assert_eq!(Part::new(timeline(0.0), 4.0, Some(9), 0).map(|part| part.ticks()).ok(), Some(9));
    }
}
