//! What the render thread is given: a snapshot when it asks for one while running free, a bounded queue of steps in lockstep.
//!
//! Running free, a snapshot is taken when the render thread is *hungry* and not before: it is the newest there can be, and
//! none is taken in vain, so that a flash that begins with a picture has one.
//!
//! In lockstep no copy is dropped, so a client that does not read would gather pictures without end. Therefore a step is
//! given out only while what earlier steps hold leaves room for its pixels: the steps wait, as snapshots, which are small.

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
    /// Bytes of pictures that steps hold which have been given out and not answered.
    held_bytes: u64,
    hungry: bool,
    stop: bool,
}

impl Posted {
    /// Bytes of the pixels of all its views.
    fn pixel_bytes(&self) -> u64 {
        self.snapshot.views.iter().map(|view| 4 * u64::from(view.size_px[0]) * u64::from(view.size_px[1])).sum()
    }
}

impl State {
    /// The oldest step, if there is room for its pixels and as much again for what is made of them: JPEGs need far less, and
    /// a second format is counted when it is there. They count as held from now on.
    fn next_step(&mut self, most_bytes: u64) -> Option<(Posted, Arc<StepGuard>)> {
        let bytes = 2 * self.steps.front()?.0.pixel_bytes();
        if self.held_bytes > 0 && self.held_bytes.saturating_add(bytes) > most_bytes {
            return None;
        }
        self.held_bytes += bytes;
        self.steps.pop_front()
    }
}

/// The mailbox between the world task and the render thread.
pub(super) struct Inbox {
    state: Mutex<State>,
    changed: Condvar,
    hunger: Notify,
    wishes: Notify,
    strikes: Arc<Strikes>,
    most_bytes: u64,
}

impl Inbox {
    /// `strikes` is told which flashes a snapshot shows from the moment at which it is posted. `most_bytes`: what the
    /// pictures of steps may hold together; one step alone may hold more.
    pub(super) fn new(strikes: Arc<Strikes>, most_bytes: u64) -> Self {
        let (state, changed) = (Mutex::default(), Condvar::new());
        Self { state, changed, hunger: Notify::new(), wishes: Notify::new(), strikes, most_bytes }
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

    /// The pictures of steps hold so many bytes more.
    pub(super) fn held(&self, bytes: u64) {
        let mut state = self.lock();
        state.held_bytes = state.held_bytes.saturating_add(bytes);
    }

    /// A step is done with: its pictures hold so many bytes no more.
    pub(super) fn freed(&self, bytes: u64) {
        let mut state = self.lock();
        state.held_bytes = state.held_bytes.saturating_sub(bytes);
        drop(state);
        self.changed.notify_one();
    }

    /// What the pictures of steps hold.
    pub(super) fn held_bytes(&self) -> u64 {
        self.lock().held_bytes
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
    pub(super) fn take(self: &Arc<Self>, limit: Option<Duration>, free: bool) -> Work {
        let mut state = self.lock();
        loop {
            if state.stop {
                return Work::Stop;
            }
            // First: it is older than any step that waits.
            if let Some(posted) = state.newest.take() {
                return Work::Free(posted, state.wanted.clone());
            }
            if let Some((posted, guard)) = state.next_step(self.most_bytes) {
                let pixels = posted.pixel_bytes();
                guard.begun(Arc::downgrade(self), 2 * pixels, pixels);
                return Work::Step(posted, guard);
            }
            if free && state.steps.is_empty() && !state.wanted.is_empty() && !state.hungry {
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
