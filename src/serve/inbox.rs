//! What the render thread is given: the newest snapshot while running free, a bounded queue of steps in lockstep.
//!
//! While running free a newer snapshot replaces an older one that nobody has taken. Each snapshot's shutter therefore
//! opens where the last *taken* one closed, so that a flash shorter than a frame is never lost between two frames.

use super::step::StepGuard;
use crate::world::snapshot::Snapshot;
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A snapshot on its way, with the stamps of its past.
#[derive(Clone)]
pub(super) struct Posted {
    pub(super) snapshot: Arc<Snapshot>,
    /// When the newest host message in it was read; 0 before the first.
    pub(super) received_us: u64,
    pub(super) snapshot_us: u64,
}

/// What to do next.
pub(super) enum Work {
    /// Draw these views of the newest snapshot; the number is the highest rate that anybody wants of it.
    Free(Posted, BTreeMap<String, f64>),
    /// Draw every view, once.
    Step(Posted, Arc<StepGuard>),
    /// Nothing came in time.
    Nothing,
    /// End the thread.
    Stop,
}

#[derive(Default)]
struct State {
    newest: Option<Posted>,
    steps: VecDeque<(Posted, Arc<StepGuard>)>,
    wanted: BTreeMap<String, f64>,
    taken_until_s: f64,
    stop: bool,
}

/// The mailbox between the world task and the render thread.
#[derive(Default)]
pub(super) struct Inbox {
    state: Mutex<State>,
    changed: Condvar,
}

impl Inbox {
    /// Replaces the newest snapshot. `make` is given the simulation time up to which light has been gathered.
    pub(super) fn post(&self, make: impl FnOnce(f64) -> Posted) -> Posted {
        let mut state = self.lock();
        let posted = make(state.taken_until_s);
        state.newest = Some(posted.clone());
        drop(state);
        self.changed.notify_one();
        posted
    }

    /// Queues a step. The caller bounds how many are under way.
    pub(super) fn push_step(&self, guard: Arc<StepGuard>, make: impl FnOnce(f64) -> Posted) -> Posted {
        let mut state = self.lock();
        let posted = make(state.taken_until_s);
        // A snapshot of the free-running time before must not be drawn between two steps.
        state.newest = None;
        state.taken_until_s = posted.snapshot.simulation_time_s;
        state.steps.push_back((posted.clone(), guard));
        drop(state);
        self.changed.notify_one();
        posted
    }

    /// The time jumped (scenario loaded, sought): light is gathered from here on.
    pub(super) fn restart_at(&self, simulation_time_s: f64) {
        self.lock().taken_until_s = simulation_time_s;
    }

    /// The views that somebody wants, each with the highest rate wanted.
    pub(super) fn set_wanted(&self, wanted: BTreeMap<String, f64>) {
        self.lock().wanted = wanted;
        self.changed.notify_one();
    }

    pub(super) fn stop(&self) {
        let mut state = self.lock();
        state.stop = true;
        // Steps that will not be drawn give up their guards here, outside of no one's lock but ours.
        let dropped = std::mem::take(&mut state.steps);
        drop(state);
        drop(dropped);
        self.changed.notify_all();
    }

    pub(super) fn stopped(&self) -> bool {
        self.lock().stop
    }

    /// Sleeps until the server stops, at most `limit`.
    pub(super) fn pause(&self, limit: Duration) {
        let state = self.lock();
        let _unused = self.changed.wait_timeout_while(state, limit, |state| !state.stop);
    }

    /// The next work; waits for it at most `limit` (`None`: for ever). `free`: whether a free-running round is welcome.
    pub(super) fn take(&self, limit: Option<Duration>, free: bool) -> Work {
        let mut state = self.lock();
        loop {
            if state.stop {
                return Work::Stop;
            }
            if let Some((posted, guard)) = state.steps.pop_front() {
                return Work::Step(posted, guard);
            }
            if free
                && !state.wanted.is_empty()
                && let Some(posted) = state.newest.take()
            {
                state.taken_until_s = posted.snapshot.simulation_time_s;
                return Work::Free(posted, state.wanted.clone());
            }
            state = match limit {
                None => self.changed.wait(state).unwrap_or_else(PoisonError::into_inner),
                Some(limit) => {
                    let (state, waited) =
                        self.changed.wait_timeout(state, limit).unwrap_or_else(PoisonError::into_inner);
                    if waited.timed_out() {
                        return Work::Nothing;
                    }
                    state
                }
            };
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
