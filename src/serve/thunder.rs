//! Works out the thunder of flashes on the blocking pool, one after another, and tells it to all clients.

use super::hub::Hub;
use crate::world::thunder::Thunder;
use std::collections::VecDeque;
use std::panic::AssertUnwindSafe;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Flashes whose thunder waits to be worked out; of more, the oldest go untold.
const MOST_WAITING: usize = 256;

/// At most one thread works at a time, beside the world and the renderer.
pub(super) struct Listener {
    queue: Arc<Mutex<Queue>>,
    hub: Arc<Hub>,
}

#[derive(Default)]
struct Queue {
    waiting: VecDeque<Thunder>,
    at_work: bool,
    /// That it could not keep up has been said; until the queue has been empty.
    behind: bool,
}

impl Listener {
    pub(super) fn new(hub: Arc<Hub>) -> Self {
        Self { queue: Arc::default(), hub }
    }

    /// Tells the thunder of flashes that have begun, where anybody is there to be told. Must be called on the runtime; returns
    /// at once.
    pub(super) fn hear(&self, begun: Vec<Thunder>) {
        if begun.is_empty() || self.hub.clients().is_empty() {
            return;
        }
        let mut queue = lock(&self.queue);
        queue.waiting.extend(begun.into_iter().filter(Thunder::near));
        let too_many = queue.waiting.len().saturating_sub(MOST_WAITING);
        if too_many > 0 {
            queue.waiting.drain(..too_many);
            if !std::mem::replace(&mut queue.behind, true) {
                tracing::warn!("more flashes than their thunder can be worked out for: the oldest are left out");
            }
        }
        if !queue.waiting.is_empty() && !std::mem::replace(&mut queue.at_work, true) {
            let (queue, hub) = (Arc::clone(&self.queue), Arc::clone(&self.hub));
            // Ends by itself when the queue is empty.
            tokio::task::spawn_blocking(move || work(&queue, &hub));
        }
    }
}

fn work(queue: &Mutex<Queue>, hub: &Hub) {
    loop {
        let next = {
            let mut queue = lock(queue);
            let next = queue.waiting.pop_front();
            queue.at_work = next.is_some();
            queue.behind &= next.is_some();
            next
        };
        let Some(next) = next else { break };
        // A fault in one flash must not silence all thunder.
        match std::panic::catch_unwind(AssertUnwindSafe(|| next.event())) {
            Ok(Some(event)) => hub.tell(&event),
            Ok(None) => {}
            Err(_) => tracing::error!("the thunder of a flash could not be worked out"),
        }
    }
}

fn lock(queue: &Mutex<Queue>) -> MutexGuard<'_, Queue> {
    queue.lock().unwrap_or_else(PoisonError::into_inner)
}
