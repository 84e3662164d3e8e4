//! The clock: UTC as a function of simulation time.

use super::check;
use super::command::TimeEdit;
use super::event::Refused;
use super::limits;

/// UTC of a new world: 2026-06-21T11:30:00Z.
pub const DEFAULT_UTC_S: f64 = 1_782_041_400.0;

/// UTC runs from a known pair of times at a rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    utc_s: f64,
    simulation_time_s: f64,
    rate: f64,
}

impl Default for Clock {
    fn default() -> Self {
        Self { utc_s: DEFAULT_UTC_S, simulation_time_s: 0.0, rate: 1.0 }
    }
}

impl Clock {
    /// Seconds since 1970-01-01T00:00:00 UTC.
    pub fn utc_s(&self, now_s: f64) -> f64 {
        self.utc_s + (now_s - self.simulation_time_s) * self.rate
    }

    /// Sets what is given; the rest goes on from where it is.
    ///
    /// # Errors
    /// [`Refused`] for a value out of range.
    pub fn edit(&mut self, edit: &TimeEdit, now_s: f64) -> Result<(), Refused> {
        let utc_s = edit.utc_s.unwrap_or_else(|| self.utc_s(now_s));
        let rate = edit.rate.unwrap_or(self.rate);
        if edit.utc_s.is_some() {
            check::within("utc_s", utc_s, limits::UTC_S)?;
        }
        check::within("rate", rate, limits::TIME_RATE)?;
        *self = Self { utc_s, simulation_time_s: now_s, rate };
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_what_it_says() {
        let printed: jiff::Timestamp = "2026-06-21T11:30:00Z".parse().unwrap();
        assert_eq!(Clock::default().utc_s(0.0), printed.as_second() as f64);
    }

    #[test]
    fn what_is_not_given_goes_on() {
        let mut clock = Clock::default();
        clock.edit(&TimeEdit { utc_s: None, rate: Some(60.0) }, 100.0).unwrap();
        assert_eq!(clock.utc_s(100.0), DEFAULT_UTC_S + 100.0, "a new rate keeps the time");
        assert_eq!(clock.utc_s(101.0), DEFAULT_UTC_S + 160.0);
        clock.edit(&TimeEdit { utc_s: Some(1e9), rate: None }, 200.0).unwrap();
        assert_eq!(clock.utc_s(200.0), 1e9);
        assert_eq!(clock.utc_s(201.0), 1e9 + 60.0, "a new time keeps the rate");
        clock.edit(&TimeEdit { utc_s: None, rate: Some(0.0) }, 300.0).unwrap();
        assert_eq!(clock.utc_s(300.0), clock.utc_s(1e6), "rate 0 stops the sun");
    }

    #[test]
    fn nonsense_is_refused_and_changes_nothing() {
        let mut clock = Clock::default();
        let before = clock;
        for (utc_s, rate) in
            [(Some(f64::NAN), None), (Some(1e12), None), (None, Some(-1e6)), (Some(0.0), Some(f64::INFINITY))]
        {
            assert!(clock.edit(&TimeEdit { utc_s, rate }, 1.0).is_err());
            assert_eq!(clock, before);
        }
    }
}
