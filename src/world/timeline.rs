//! A timeline: a scenario's commands in the order of their times.

use super::command::Command;

/// A scenario: commands in rising order of time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Timeline {
    /// Short name.
    pub name: String,
    /// One or two sentences for people.
    pub description: String,
    /// Simulation time in seconds at which it ends and the time stops; 0: it never ends.
    pub duration_s: f64,
    /// Commands in rising order of simulation time; those at 0 make the starting state.
    pub entries: Vec<TimedCommand>,
}

/// A command and when it is due.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedCommand {
    /// Simulation time in seconds, at least 0.
    pub at_s: f64,
    /// The command.
    pub command: Command,
}
