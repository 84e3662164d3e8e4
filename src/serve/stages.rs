//! Where the time between a host's message and the frame that shows it goes: durations of each stage of the flow.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

/// A stage of the flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// A host's message read from its socket until its meaning is known.
    Decode,
    /// From there until the world has taken it.
    Apply,
    /// From there until the next snapshot is taken: the beat of the frames.
    Wait,
    /// The plan of one picture.
    Plan,
    /// From handing the plan to the executor until the picture is drawn.
    Passes,
    /// The drawn picture into main memory.
    ReadBack,
    /// From there until the bytes of the format are there, the queue in front of the encoder included.
    Encode,
    /// From there until the bytes are given to the socket.
    Send,
    /// From reading a message to the bytes of the first frame that shows it.
    Whole,
}

impl Stage {
    /// All, in the order of the flow.
    pub const ALL: [Self; 9] = [
        Self::Decode,
        Self::Apply,
        Self::Wait,
        Self::Plan,
        Self::Passes,
        Self::ReadBack,
        Self::Encode,
        Self::Send,
        Self::Whole,
    ];

    /// As people write it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Decode => "decode",
            Self::Apply => "apply",
            Self::Wait => "wait",
            Self::Plan => "plan",
            Self::Passes => "passes",
            Self::ReadBack => "read back",
            Self::Encode => "encode",
            Self::Send => "send",
            Self::Whole => "datagram to encoded frame",
        }
    }
}

/// How many durations of each stage are kept: the newest.
const KEPT: usize = 4_096;

/// Durations of all stages, which several threads add to.
#[derive(Debug, Default)]
pub struct Stages {
    kept: [Mutex<VecDeque<u64>>; Stage::ALL.len()],
    /// The newest message of which a frame has been encoded.
    shown_us: AtomicU64,
}

impl Stages {
    /// A stage took so long.
    pub(super) fn add_us(&self, stage: Stage, duration_us: u64) {
        let mut kept = self.of(stage);
        if kept.len() == KEPT {
            kept.pop_front();
        }
        kept.push_back(duration_us);
    }

    /// A frame is encoded: it counts for the whole way if it is the first that shows its message. 0: it shows none.
    pub(super) fn encoded(&self, received_us: u64, encoded_us: u64) {
        if received_us > self.shown_us.fetch_max(received_us, Relaxed) {
            self.add_us(Stage::Whole, encoded_us.saturating_sub(received_us));
        }
    }

    /// The newest durations of a stage in microseconds, oldest first.
    pub fn newest_us(&self, stage: Stage) -> Vec<u64> {
        self.of(stage).iter().copied().collect()
    }

    /// Forgets what was measured so far.
    pub fn clear(&self) {
        Stage::ALL.into_iter().for_each(|stage| self.of(stage).clear());
    }

    fn of(&self, stage: Stage) -> std::sync::MutexGuard<'_, VecDeque<u64>> {
        self.kept[stage as usize].lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_are_kept_and_a_message_counts_once() {
        let stages = Stages::default();
        (0..KEPT as u64 + 3).for_each(|us| stages.add_us(Stage::Plan, us));
        let kept = stages.newest_us(Stage::Plan);
        assert_eq!((kept.len(), kept[0], stages.newest_us(Stage::Send).len()), (KEPT, 3, 0));
        // No message, a message, another frame of it, an older one, a newer one.
        for (received_us, encoded_us) in [(0, 50), (100, 130), (100, 150), (90, 160), (200, 260)] {
            stages.encoded(received_us, encoded_us);
        }
        assert_eq!(stages.newest_us(Stage::Whole), [30, 60]);
        stages.clear();
        assert!(Stage::ALL.into_iter().all(|stage| stages.newest_us(stage).is_empty()));
    }
}
