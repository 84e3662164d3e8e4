//! Grows the channels of flashes on the blocking pool, one after another, so that neither the world nor the renderer waits.

use crate::world::growing::Growing;
use std::collections::VecDeque;
use std::panic::AssertUnwindSafe;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

/// What is still to be grown. At most one thread grows at a time: a thousand strikes in a second take turns on one core.
#[derive(Default)]
pub(super) struct Grower {
    queue: Arc<Mutex<Queue>>,
}

/// As long as the world holds flashes, whose number is limited; one that is over by its turn is passed over.
#[derive(Default)]
struct Queue {
    waiting: VecDeque<Weak<Growing>>,
    at_work: bool,
}

impl Grower {
    /// Grows these after all that came before. Must be called on the runtime; returns at once.
    pub(super) fn grow(&self, fresh: Vec<Arc<Growing>>) {
        if fresh.is_empty() {
            return;
        }
        let mut queue = lock(&self.queue);
        queue.waiting.retain(|growing| growing.strong_count() > 0);
        queue.waiting.extend(fresh.iter().map(Arc::downgrade));
        if !std::mem::replace(&mut queue.at_work, true) {
            let queue = Arc::clone(&self.queue);
            // Ends by itself when the queue is empty.
            tokio::task::spawn_blocking(move || work(&queue));
        }
    }
}

fn work(queue: &Mutex<Queue>) {
    loop {
        let next = {
            let mut queue = lock(queue);
            let next = queue.waiting.pop_front();
            queue.at_work = next.is_some();
            next
        };
        let Some(next) = next else { break };
        if let Some(growing) = next.upgrade() {
            // A fault in one channel must not end the growth of all: that flash stays without one.
            if std::panic::catch_unwind(AssertUnwindSafe(|| growing.grow())).is_err() {
                tracing::error!("a channel could not be grown; its flash is shown without");
            }
        }
    }
}

fn lock(queue: &Mutex<Queue>) -> MutexGuard<'_, Queue> {
    queue.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::World;
    use crate::world::command::{Command, FlashKind, Polarity, StrikeRequest, Strokes};

    fn strike(seed: u64) -> Command {
        Command::Strike(StrikeRequest {
            latitude_deg: 47.0,
            longitude_deg: 8.0,
            altitude_m: Some(3_000.0),
            at_s: None,
            kind: FlashKind::CloudToGround,
            polarity: Polarity::Negative,
            peak_current_ka: None,
            strokes: Strokes::Sample,
            leader: false,
            seed,
        })
    }

    #[tokio::test]
    async fn what_is_taken_is_grown_beside_the_world() {
        let mut world = World::new();
        let grower = Grower::default();
        let accepted = (0..40).filter(|&seed| world.apply(strike(seed)).is_ok()).count();
        let growing = world.take_growing();
        assert_eq!(growing.len(), accepted);
        assert!(world.snapshot_at_once(0.02).provisional(), "nothing is there yet, and nobody waits");
        grower.grow(growing.clone());
        // Growing here as well waits for who is at it, and never makes a second channel.
        let channels: Vec<_> = growing.iter().filter_map(|growing| growing.grow()).collect();
        assert_eq!(channels.len(), accepted);
        let snapshot = world.snapshot_at_once(0.02);
        assert!(!snapshot.provisional());
        for flash in &snapshot.flashes {
            let shown = flash.channel.as_ref().expect("grown");
            assert!(channels.iter().any(|channel| Arc::ptr_eq(channel, shown)), "views share it");
        }
    }
}
