//! Run time with its spread.

use super::result::TimeSpread;
use std::time::Instant;

/// Does the work `runs` times (at least once) and tells the last outcome and how long each took.
pub fn measure<T>(runs: u32, mut work: impl FnMut() -> T) -> (T, TimeSpread) {
    let mut timed = || {
        let begin = Instant::now();
        let outcome = work();
        (outcome, begin.elapsed().as_secs_f64())
    };
    let (mut outcome, first_s) = timed();
    let mut spread = TimeSpread { median: first_s, min: first_s, max: first_s, runs: 1 };
    let mut times_s = vec![first_s];
    for _ in 1..runs {
        let (next, time_s) = timed();
        outcome = next;
        times_s.push(time_s);
        spread = TimeSpread::of(&times_s).unwrap_or(spread);
    }
    (outcome, spread)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_work_is_done_as_often_as_asked_and_at_least_once() {
        for (runs, times) in [(0, 1), (1, 1), (5, 5)] {
            let mut done = 0;
            let (last, spread) = measure(runs, || {
                done += 1;
                done
            });
            assert_eq!((last, spread.runs), (times, times));
            assert!(spread.min <= spread.median && spread.median <= spread.max);
        }
    }
}
