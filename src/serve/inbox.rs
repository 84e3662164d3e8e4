//! What the render thread is given: a snapshot when it asks for one while running free, a bounded queue of steps in lockstep.
//!
//! Running free, a snapshot is taken when the render thread is *hungry* and not before: it is the newest there can be, and
//! none is taken in vain, so that a flash that begins with a picture has one.

use super::step::StepGuard;
use super::strikes::Strikes;
use crate::outputs::lit;
use crate::world::snapshot::Snapshot;
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::sync::Notify;

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
    hungry: bool,
    stop: bool,
}

/// The mailbox between the world task and the render thread.
pub(super) struct Inbox {
    state: Mutex<State>,
    changed: Condvar,
    hunger: Notify,
    wishes: Notify,
    strikes: Arc<Strikes>,
}

impl Inbox {
    /// `strikes` is told which flashes a snapshot shows from the moment at which it is posted.
    pub(super) fn new(strikes: Arc<Strikes>) -> Self {
        Self { state: Mutex::default(), changed: Condvar::new(), hunger: Notify::new(), wishes: Notify::new(), strikes }
    }

    /// Waits until the render thread is ready for a snapshot of the free-running time.
    pub(super) async fn hungry(&self) {
        loop {
            let hunger = self.hunger.notified();
            if self.lock().hungry {
                return;
            }
            hunger.await;
        }
    }

    /// Waits until somebody wants something else than before.
    pub(super) async fn wishes_changed(&self) {
        self.wishes.notified().await;
    }

    /// The highest rate at which anybody wants any view; `None` when nobody wants one.
    pub(super) fn fastest_hz(&self) -> Option<f64> {
        self.lock().wanted.values().copied().reduce(f64::max)
    }

    /// Gives the hungry render thread a snapshot.
    pub(super) fn post(&self, posted: Posted) {
        self.hold(&posted);
        let mut state = self.lock();
        state.hungry = false;
        state.newest = Some(posted);
        drop(state);
        self.changed.notify_one();
    }

    /// Queues a step. The caller bounds how many are under way.
    pub(super) fn push_step(&self, posted: Posted, guard: Arc<StepGuard>) {
        self.hold(&posted);
        let mut state = self.lock();
        state.hungry = false;
        state.steps.push_back((posted, guard));
        drop(state);
        self.changed.notify_one();
    }

    /// The views that somebody wants, each with the highest rate wanted.
    pub(super) fn set_wanted(&self, wanted: BTreeMap<String, f64>) {
        self.lock().wanted = wanted;
        self.changed.notify_one();
        self.wishes.notify_one();
    }

    pub(super) fn stop(&self) {
        let mut state = self.lock();
        state.stop = true;
        let dropped = std::mem::take(&mut state.steps);
        drop(state);
        // Outside the lock: steps that will not be drawn answer their host.
        drop(dropped);
        self.changed.notify_all();
    }

    pub(super) fn stopped(&self) -> bool {
        self.lock().stop
    }

    /// Sleeps until the server stops, at most `limit`.
    pub(super) fn pause(&self, limit: Duration) {
        let state = self.lock();
        let _waited = self.changed.wait_timeout_while(state, limit, |state| !state.stop);
    }

    /// The next work; waits for it at most `limit` (`None`: for ever). `free`: whether a free-running round is welcome.
    pub(super) fn take(&self, limit: Option<Duration>, free: bool) -> Work {
        let mut state = self.lock();
        loop {
            if state.stop {
                return Work::Stop;
            }
            // First: it is older than any step that waits.
            if let Some(posted) = state.newest.take() {
                return Work::Free(posted, state.wanted.clone());
            }
            if let Some((posted, guard)) = state.steps.pop_front() {
                return Work::Step(posted, guard);
            }
            if free && !state.wanted.is_empty() && !state.hungry {
                state.hungry = true;
                self.hunger.notify_one();
            }
            state = match limit {
                None => self.changed.wait(state).unwrap_or_else(PoisonError::into_inner),
                Some(limit) => {
                    let waited = self.changed.wait_timeout(state, limit);
                    let (state, waited) = waited.unwrap_or_else(PoisonError::into_inner);
                    if waited.timed_out() {
                        return Work::Nothing;
                    }
                    state
                }
            };
        }
    }

    /// Holds the flashes of a snapshot until its frames are under way: see `RenderThread::release`.
    fn hold(&self, posted: &Posted) {
        lit(&posted.snapshot).for_each(|id| self.strikes.taken(id));
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
