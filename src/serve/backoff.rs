//! How long to leave alone what has just failed: at first not at all, then twice as long each time, up to a limit.

/// After the second failure in a row, in microseconds.
const FIRST_US: u64 = 500_000;
/// At most, however often it has failed.
const MOST_US: u64 = 30_000_000;

/// Failures in a row, and when to try again. Times are microseconds since any fixed moment, given by the caller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Backoff {
    failures: u32,
    until_us: u64,
}

impl Backoff {
    /// It failed (again). Returns the pause before the next try.
    pub(super) fn failed(&mut self, now_us: u64) -> u64 {
        let pause_us = match self.failures {
            0 => 0,
            before => FIRST_US.checked_shl(before - 1).unwrap_or(MOST_US).min(MOST_US),
        };
        // Beyond this the pause is the longest anyway, and the shift stays within a u64.
        self.failures = (self.failures + 1).min(32);
        self.until_us = now_us.saturating_add(pause_us);
        pause_us
    }

    /// What is left of the pause.
    pub(super) fn left_us(&self, now_us: u64) -> u64 {
        self.until_us.saturating_sub(now_us)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_failure_is_forgiven_and_the_pauses_double_up_to_the_limit() {
        let mut backoff = Backoff::default();
        assert_eq!(backoff.left_us(7), 0);
        let pauses: Vec<u64> = (0..10).map(|_| backoff.failed(1_000)).collect();
        assert_eq!(pauses[..5], [0, 500_000, 1_000_000, 2_000_000, 4_000_000]);
        assert_eq!(pauses[7..], [MOST_US; 3]);
        assert_eq!((backoff.left_us(2_000), backoff.left_us(MOST_US + 1_000)), (MOST_US - 1_000, 0));
        (0..100).for_each(|_| assert_eq!(backoff.failed(0), MOST_US));
    }
}
