//! At most so many a second: which frames of a stream are due for somebody who wants fewer.

/// Keeps a stream to a rate, without drift and without bursts after a pause.
#[derive(Clone, Debug)]
pub(super) struct Pacer {
    period_us: f64,
    slot_us: f64,
}

impl Pacer {
    /// `rate_hz`: positive; infinite takes every frame.
    pub(super) fn new(rate_hz: f64) -> Self {
        Self { period_us: 1e6 / rate_hz, slot_us: f64::NEG_INFINITY }
    }

    /// Another rate from now on.
    pub(super) fn set_rate(&mut self, rate_hz: f64) {
        self.period_us = 1e6 / rate_hz;
    }

    /// Whether a frame taken at `now_us` is due. Taking it makes the next one due a period later.
    ///
    /// A frame is taken up to a quarter of a period early: the ticks of the server jitter, and a tick that comes a hair
    /// early must not halve the rate.
    pub(super) fn due(&mut self, now_us: u64) -> bool {
        let (now_us, next_us) = (now_us as f64, self.slot_us + self.period_us);
        if now_us + 0.25 * self.period_us < next_us {
            return false;
        }
        // Within a period of its slot the stream keeps its beat; after a longer gap the beat starts anew.
        self.slot_us = if now_us - next_us > self.period_us { now_us } else { next_us };
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixty_a_second_become_ten_or_twenty_five() {
        for (rate_hz, expected) in [(10.0, 100), (25.0, 250), (f64::INFINITY, 600)] {
            let mut pacer = Pacer::new(rate_hz);
            let taken = (0..600_u64).filter(|tick| pacer.due(tick * 1_000_000 / 60)).count();
            // One more: the stream may run a quarter of a period ahead of its beat, and then stays there.
            assert!((expected..=expected + 1).contains(&taken), "{rate_hz}: {taken}");
        }
    }

    #[test]
    fn jitter_at_the_same_rate_loses_nothing() {
        let mut pacer = Pacer::new(60.0);
        let jitter = |tick: u64| tick * 16_667 + [0, 2_000, 0, 3_500][(tick % 4) as usize] + 5_000;
        assert_eq!((0..600).filter(|tick| pacer.due(jitter(*tick))).count(), 600);
    }

    #[test]
    fn a_pause_is_not_made_up_for() {
        let mut pacer = Pacer::new(10.0);
        assert!(pacer.due(0));
        let after = (0..60).filter(|tick| pacer.due(100_000_000 + tick * 16_667)).count();
        // Ten in a second, and one for being a quarter of a period ahead.
        assert!((10..=11).contains(&after), "{after}");
    }

    #[test]
    fn a_faster_rate_holds_at_once() {
        let mut pacer = Pacer::new(0.01);
        assert!(pacer.due(0) && !pacer.due(1_000_000));
        pacer.set_rate(10.0);
        assert!(pacer.due(1_000_000));
    }
}
