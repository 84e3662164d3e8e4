//! Which frame showed a flash first, or that none did.
//!
//! A flash is *taken* when a snapshot with its light goes to the render thread, *shown* when a frame of that snapshot is
//! out, *lost* when a fault ate the frame. It is missed when it is over and no taken frame can show it any more.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

#[derive(Default)]
struct Track {
    under_way: u32,
    shown: bool,
    ended: bool,
}

/// The flashes that are not settled.
#[derive(Default)]
pub(super) struct Strikes {
    tracks: Mutex<BTreeMap<u64, Track>>,
}

impl Strikes {
    /// A frame that will show this flash is being drawn.
    pub(super) fn taken(&self, id: u64) {
        self.lock().entry(id).or_default().under_way += 1;
    }

    /// A frame that shows this flash is out. True for the first one.
    pub(super) fn shown(&self, id: u64) -> bool {
        let mut tracks = self.lock();
        let Some(track) = tracks.get_mut(&id) else { return false };
        track.under_way = track.under_way.saturating_sub(1);
        let first = !std::mem::replace(&mut track.shown, true);
        if track.ended && track.under_way == 0 {
            tracks.remove(&id);
        }
        first
    }

    /// A frame that would have shown this flash was lost. True when the flash is thereby missed.
    pub(super) fn lost(&self, id: u64) -> bool {
        let mut tracks = self.lock();
        let Some(track) = tracks.get_mut(&id) else { return false };
        track.under_way = track.under_way.saturating_sub(1);
        let settled = track.ended && track.under_way == 0;
        let missed = settled && !track.shown;
        if settled {
            tracks.remove(&id);
        }
        missed
    }

    /// No later snapshot will have this flash's light. True when the flash is thereby missed.
    pub(super) fn ended(&self, id: u64) -> bool {
        let mut tracks = self.lock();
        let track = tracks.entry(id).or_default();
        track.ended = true;
        let settled = track.under_way == 0;
        let missed = settled && !track.shown;
        if settled {
            tracks.remove(&id);
        }
        missed
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<u64, Track>> {
        self.tracks.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shown_once_then_forgotten() {
        let strikes = Strikes::default();
        strikes.taken(7);
        strikes.taken(7);
        assert!(strikes.shown(7));
        assert!(!strikes.ended(7));
        assert!(!strikes.shown(7), "the second frame is not the first");
        assert!(strikes.lock().is_empty(), "nothing is kept for settled flashes");
    }

    #[test]
    fn missed_when_over_without_a_frame() {
        let strikes = Strikes::default();
        assert!(strikes.ended(1), "never taken");
        strikes.taken(2);
        assert!(!strikes.ended(2), "a frame may still come");
        assert!(strikes.lost(2), "it did not");
        assert!(strikes.lock().is_empty());
    }
}
