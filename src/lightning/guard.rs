//! A limit on flicker, for operators whose pilots may be sensitive to it.
//!
//! WCAG 2.2, success criterion 2.3.1 (after the broadcasters' rules, ITU-R BT.1702): nothing flashes more than three times in any
//! one second, a flash being a pair of opposing changes of luminance. Each stroke is such a pair: light comes within
//! microseconds and only falls after it, so that strokes let through are the only rises there are.
//!
//! Time is cut into slots; the first stroke of a slot passes, the others do not. What passes depends on nothing later, so that
//! nothing already seen is taken back, and on no earlier slot, so that it can be worked out for any moment by itself. With
//! slots of 1 / (n - 1) s no window of one second touches more than n of them.

use std::collections::{BTreeMap, BTreeSet};

/// Strokes in any one second: what the guard may be set to.
pub const FLASHES_PER_S: [u32; 2] = [2, 30];

/// A limit on strokes in any one second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FlickerGuard {
    flashes_per_s: u32,
}

impl FlickerGuard {
    /// At most so many strokes in any one second, brought into [`FLASHES_PER_S`].
    pub fn new(flashes_per_s: u32) -> Self {
        Self { flashes_per_s: flashes_per_s.clamp(FLASHES_PER_S[0], FLASHES_PER_S[1]) }
    }

    /// How long before an interval strokes must be known to decide on those in it.
    pub fn memory_s(&self) -> f64 {
        1.0 / f64::from(self.flashes_per_s - 1)
    }

    /// Which strokes pass, by flash and number: of `(time, flash, number)` in any order, the first of each slot.
    pub fn passed(&self, strokes: impl Iterator<Item = (f64, u64, usize)>) -> BTreeSet<(u64, usize)> {
        let mut first: BTreeMap<i64, (f64, u64, usize)> = BTreeMap::new();
        for stroke in strokes {
            let slot = (stroke.0 * f64::from(self.flashes_per_s - 1)).floor() as i64;
            let held = first.entry(slot).or_insert(stroke);
            // Of strokes of one moment that of the flash with the lower number.
            if (stroke.0, stroke.1, stroke.2) < *held {
                *held = stroke;
            }
        }
        first.into_values().map(|(_, flash, number)| (flash, number)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lightning::random::Stream;

    /// Times of 600 strokes in 30 s, of flashes of three.
    fn storm() -> Vec<(f64, u64, usize)> {
        let mut stream = Stream::new(3, 0);
        (0..600).map(|n| (30.0 * stream.unit(), n as u64 / 3, n % 3)).collect()
    }

    #[test]
    fn no_second_has_more_than_the_limit_and_few_are_empty() {
        for limit in [2, 3, 10] {
            let guard = FlickerGuard::new(limit);
            let strokes = storm();
            let passed = guard.passed(strokes.iter().copied());
            let mut times: Vec<f64> =
                strokes.iter().filter(|s| passed.contains(&(s.1, s.2))).map(|stroke| stroke.0).collect();
            times.sort_by(f64::total_cmp);
            for window in times.windows(limit as usize + 1) {
                assert!(window[limit as usize] - window[0] >= 1.0, "{limit}: {window:?}");
            }
            // 20 strokes a second: slots of half a second and less nearly all have one.
            assert!(times.len() as f64 > 0.8 * 30.0 * f64::from(limit - 1), "{limit}: {}", times.len());
        }
    }

    #[test]
    fn what_comes_later_takes_nothing_back_and_what_is_long_past_does_not_matter() {
        let guard = FlickerGuard::new(3);
        let strokes = storm();
        let all = guard.passed(strokes.iter().copied());
        for now_s in [3.1, 9.99, 17.4] {
            let early = guard.passed(strokes.iter().copied().filter(|stroke| stroke.0 <= now_s));
            let late = guard.passed(strokes.iter().copied().filter(|stroke| stroke.0 > now_s - guard.memory_s()));
            for stroke in &strokes {
                let key = (stroke.1, stroke.2);
                if stroke.0 <= now_s {
                    assert_eq!(early.contains(&key), all.contains(&key));
                } else {
                    assert_eq!(late.contains(&key), all.contains(&key));
                }
            }
        }
    }
}
