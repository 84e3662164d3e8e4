//! What waits to be written to one client: texts and frames, both bounded; nobody who fills it ever waits for the client.

use super::step::StepGuard;
use crate::frame::Frame;
use crate::wire::control::{Format, WhenSlow};
use axum::body::Bytes;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::Notify;

/// Texts that may wait before the client's own messages are no longer read and events are dropped.
const TEXTS: usize = 256;

/// One copy of a frame for one client.
pub(super) struct Copy {
    pub(super) frame: Arc<Frame>,
    /// The picture, shared by all who take this format.
    pub(super) picture: Bytes,
    pub(super) format: Format,
    pub(super) encoded_us: u64,
    /// The last frame that this client gets of a step.
    pub(super) last_of_step: bool,
    /// The step that waits for it: such a copy is never dropped.
    pub(super) guard: Option<Arc<StepGuard>>,
}

/// What to write next.
pub(super) enum Item {
    Text(String),
    Frame(Copy),
    /// Close with this code and reason.
    Close(u16, String),
}

/// What became of a copy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pushed {
    Queued,
    /// This one or an older one was dropped.
    Dropped,
    /// The client asked to be disconnected when slow, and will be.
    Disconnecting,
}

#[derive(Default)]
struct State {
    texts: VecDeque<String>,
    frames: VecDeque<Copy>,
    close: Option<(u16, String)>,
    closed: bool,
}

/// The queue of one client.
pub(super) struct Queue {
    state: Mutex<State>,
    filled: Notify,
    drained: Notify,
    frames_per_view: usize,
}

impl Queue {
    /// `frames_per_view`: free-running frames that may wait for each subscription.
    pub(super) fn new(frames_per_view: usize) -> Self {
        Self {
            state: Mutex::default(),
            filled: Notify::new(),
            drained: Notify::new(),
            frames_per_view: frames_per_view.max(1),
        }
    }

    /// An answer to a message of this client. Bounded because the client's reader waits for [`Queue::room`] first.
    pub(super) fn push_answer(&self, text: String) {
        let mut state = self.lock();
        if !state.closed {
            state.texts.push_back(text);
        }
        drop(state);
        self.filled.notify_one();
    }

    /// Something that nobody asked for. False: the queue is full, it is dropped.
    pub(super) fn push_event(&self, text: String) -> bool {
        let mut state = self.lock();
        let room = state.texts.len() < TEXTS && !state.closed;
        if room {
            state.texts.push_back(text);
        }
        drop(state);
        self.filled.notify_one();
        room
    }

    /// A frame. Copies of a step are always taken: steps under way are bounded, and so are these.
    pub(super) fn push_frame(&self, copy: Copy, when_slow: WhenSlow) -> Pushed {
        let mut state = self.lock();
        if state.closed || state.close.is_some() {
            return Pushed::Disconnecting;
        }
        let droppable = |waiting: &Copy| waiting.guard.is_none() && waiting.frame.view == copy.frame.view;
        let full = copy.guard.is_none()
            && state.frames.iter().filter(|waiting| droppable(waiting)).count() >= self.frames_per_view;
        let pushed = match (full, when_slow) {
            (false, _) => {
                state.frames.push_back(copy);
                Pushed::Queued
            }
            (true, WhenSlow::DropOldest) => {
                if let Some(oldest) = state.frames.iter().position(droppable) {
                    state.frames.remove(oldest);
                }
                state.frames.push_back(copy);
                Pushed::Dropped
            }
            (true, WhenSlow::DropNewest) => Pushed::Dropped,
            (true, WhenSlow::Disconnect) => {
                state.close = Some((POLICY, "too slow, and asked to be disconnected then".to_owned()));
                Pushed::Disconnecting
            }
        };
        drop(state);
        self.filled.notify_one();
        pushed
    }

    /// Ends the connection after the texts that wait.
    pub(super) fn close_with(&self, code: u16, reason: &str) {
        self.lock().close.get_or_insert_with(|| (code, reason.to_owned()));
        self.filled.notify_one();
    }

    /// Nothing will be written any more: gives up what waits, and with it its share of any step.
    pub(super) fn abandon(&self) {
        let mut state = self.lock();
        state.closed = true;
        let frames = std::mem::take(&mut state.frames);
        state.texts.clear();
        drop(state);
        // Outside the lock: the last share of a step answers the host, whose queue this may be.
        drop(frames);
        self.drained.notify_one();
    }

    /// The next thing to write; waits for it.
    pub(super) async fn next(&self) -> Item {
        loop {
            let filled = self.filled.notified();
            if let Some(item) = self.pop() {
                return item;
            }
            filled.await;
        }
    }

    /// Waits until one more text may come.
    pub(super) async fn room(&self) {
        loop {
            let drained = self.drained.notified();
            if self.has_room() {
                return;
            }
            drained.await;
        }
    }

    fn has_room(&self) -> bool {
        let state = self.lock();
        state.texts.len() < TEXTS || state.closed
    }

    /// Frames waiting.
    pub(super) fn frames(&self) -> usize {
        self.lock().frames.len()
    }

    fn pop(&self) -> Option<Item> {
        let mut state = self.lock();
        if let Some(text) = state.texts.pop_front() {
            drop(state);
            self.drained.notify_one();
            return Some(Item::Text(text));
        }
        if let Some((code, reason)) = state.close.clone() {
            return Some(Item::Close(code, reason));
        }
        state.frames.pop_front().map(Item::Frame)
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// WebSocket close code: the client broke a rule (RFC 6455, 7.4.1).
pub(super) const POLICY: u16 = 1008;
/// WebSocket close code: a message is too long.
pub(super) const TOO_BIG: u16 = 1009;
/// WebSocket close code: the server goes away.
pub(super) const AWAY: u16 = 1001;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{LatencyStamps, Pixels};

    fn copy(view: &str, number: u64, guard: Option<Arc<StepGuard>>) -> Copy {
        let frame = Frame {
            view: view.into(),
            number,
            host_frame: 0,
            simulation_time_s: 0.0,
            width: 0,
            height: 0,
            pixels: Arc::new(Pixels::Srgb8(Vec::new())),
            provisional: false,
            repeated: false,
            stamps: LatencyStamps::default(),
        };
        let (frame, picture) = (Arc::new(frame), Bytes::new());
        Copy { frame, picture, format: Format::Raw, encoded_us: 0, last_of_step: false, guard }
    }

    fn waiting(queue: &Queue) -> Vec<(String, u64)> {
        std::iter::from_fn(|| queue.pop())
            .map(|item| match item {
                Item::Frame(copy) => (copy.frame.view.clone(), copy.frame.number),
                Item::Text(text) => (text, 0),
                Item::Close(code, _) => ("closed".into(), code.into()),
            })
            .take(20)
            .collect()
    }

    #[test]
    fn drop_oldest_keeps_the_newest_and_leaves_other_views_alone() {
        let queue = Queue::new(2);
        queue.push_frame(copy("tail", 1, None), WhenSlow::DropOldest);
        let pushed: Vec<_> = (1..=4).map(|n| queue.push_frame(copy("nose", n, None), WhenSlow::DropOldest)).collect();
        assert_eq!(pushed, [Pushed::Queued, Pushed::Queued, Pushed::Dropped, Pushed::Dropped]);
        assert_eq!(waiting(&queue), [("tail".into(), 1), ("nose".into(), 3), ("nose".into(), 4)]);
    }

    #[test]
    fn drop_newest_keeps_the_oldest() {
        let queue = Queue::new(2);
        (1..=4).for_each(|n| {
            queue.push_frame(copy("nose", n, None), WhenSlow::DropNewest);
        });
        assert_eq!(waiting(&queue), [("nose".into(), 1), ("nose".into(), 2)]);
    }

    #[test]
    fn disconnect_closes_after_the_texts() {
        let queue = Queue::new(1);
        queue.push_frame(copy("nose", 1, None), WhenSlow::Disconnect);
        assert_eq!(queue.push_frame(copy("nose", 2, None), WhenSlow::Disconnect), Pushed::Disconnecting);
        queue.push_answer("last words".into());
        let items = waiting(&queue);
        assert_eq!(items[..2], [("last words".into(), 0), ("closed".into(), u64::from(POLICY))]);
    }

    #[test]
    fn copies_of_a_step_are_never_dropped_and_end_their_step_when_abandoned() {
        let (sender, answers) = std::sync::mpsc::sync_channel(1);
        let guard = Arc::new(StepGuard::new(move |outcome| sender.send(outcome).unwrap()));
        guard.all_submitted();
        let queue = Queue::new(1);
        for number in 1..=5 {
            let pushed = queue.push_frame(copy("nose", number, Some(guard.clone())), WhenSlow::DropNewest);
            assert_eq!(pushed, Pushed::Queued);
        }
        queue.push_frame(copy("nose", 6, None), WhenSlow::DropOldest);
        queue.push_frame(copy("nose", 7, None), WhenSlow::DropOldest);
        assert_eq!(queue.frames(), 6, "of the free-running frames one has gone");
        drop(guard);
        assert!(answers.try_recv().is_err());
        queue.abandon();
        assert!(answers.try_recv().is_ok());
    }

    #[test]
    fn events_do_not_pile_up() {
        let queue = Queue::new(1);
        assert_eq!((0..1000).filter(|i| queue.push_event(format!("{i}"))).count(), TEXTS);
    }
}
