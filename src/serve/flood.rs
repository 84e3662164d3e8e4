//! Too many messages: a token bucket for each connection, and a bound on how often it is told so.

use crate::wire::limits;
use std::time::Duration;

/// What to do with a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// Take it.
    Take,
    /// Refuse it, and say so: this many earlier ones were refused without a word.
    Refuse {
        /// Messages refused in silence since the last refusal that was sent.
        unsaid: u64,
    },
    /// Refuse it without a word: a refusal was sent less than a second ago.
    Drop,
}

/// The bucket of one connection. Time is a duration since any fixed moment, given by the caller.
pub(super) struct Bucket {
    per_s: f64,
    burst: f64,
    tokens: f64,
    filled: Duration,
    last_refusal: Option<Duration>,
    unsaid: u64,
}

/// A flood is answered at most this often.
const REFUSAL_EVERY: Duration = Duration::from_millis(1000 / limits::REFUSALS_PER_SECOND as u64);

impl Bucket {
    /// `per_s` messages a second for ever, `burst` at once.
    pub(super) fn new(per_s: f64, burst: f64, now: Duration) -> Self {
        Self { per_s, burst, tokens: burst, filled: now, last_refusal: None, unsaid: 0 }
    }

    /// Judges one message.
    pub(super) fn judge(&mut self, now: Duration) -> Verdict {
        let passed_s = now.saturating_sub(self.filled).as_secs_f64();
        self.filled = now;
        self.tokens = (self.tokens + passed_s * self.per_s).min(self.burst);
        if self.tokens >= 1.0 {
            self.tokens -= 1.0;
            return Verdict::Take;
        }
        if self.last_refusal.is_some_and(|last| now.saturating_sub(last) < REFUSAL_EVERY) {
            self.unsaid += 1;
            return Verdict::Drop;
        }
        self.last_refusal = Some(now);
        Verdict::Refuse { unsaid: std::mem::take(&mut self.unsaid) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_thousand_messages_in_a_second_get_one_refusal_and_the_rest_are_counted() {
        let mut bucket = Bucket::new(100.0, 50.0, Duration::ZERO);
        let verdicts: Vec<Verdict> = (0..10_000).map(|i| bucket.judge(Duration::from_micros(i * 100))).collect();
        let taken = verdicts.iter().filter(|v| **v == Verdict::Take).count();
        let said = verdicts.iter().filter(|v| matches!(v, Verdict::Refuse { .. })).count();
        // The burst of 50 and 100 a second for one second; the first and the last token may fall on either side.
        assert!((148..=150).contains(&taken), "{taken}");
        assert_eq!(said, 1);
        let later = bucket.judge(Duration::from_secs(5));
        assert_eq!(later, Verdict::Take, "the bucket fills again");
    }

    #[test]
    fn the_next_refusal_says_how_many_were_dropped() {
        let mut bucket = Bucket::new(0.0, 1.0, Duration::ZERO);
        assert_eq!(bucket.judge(Duration::ZERO), Verdict::Take);
        assert_eq!(bucket.judge(Duration::ZERO), Verdict::Refuse { unsaid: 0 });
        for _ in 0..7 {
            assert_eq!(bucket.judge(Duration::from_millis(500)), Verdict::Drop);
        }
        assert_eq!(bucket.judge(Duration::from_secs(2)), Verdict::Refuse { unsaid: 7 });
    }
}
