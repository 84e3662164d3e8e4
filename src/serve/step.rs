//! A step of lockstep under way: answered when its last frame copy has been written, or can no longer be.
//!
//! The guard is shared by everything that still works for the step: the job, its frames, their encodings, the copies in the
//! clients' queues. When the last of them is gone (written, or given up because its client left), the answer goes out. So
//! a client that vanishes cannot hold a step, and no path can forget to report. The same guard carries what the step's
//! pictures hold of memory, so that the inbox knows when there is room for the next step.

use super::inbox::Inbox;
use crate::wire::control::Format;
use std::collections::BTreeSet;
use std::sync::{Mutex, MutexGuard, PoisonError, Weak};

/// What became of a step.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Outcome {
    /// One frame for each view.
    Drawn(Vec<StepFrame>),
    /// It could not be drawn.
    Failed(String),
}

/// A frame of a step, and who has it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct StepFrame {
    pub(super) view: String,
    pub(super) number: u64,
    /// Formats that were written to at least one client.
    pub(super) formats: BTreeSet<Format>,
    /// Copies written.
    pub(super) copies: u32,
}

struct Progress {
    frames: Vec<StepFrame>,
    all_submitted: bool,
    failure: Option<String>,
}

type Answer = Box<dyn FnOnce(Outcome) + Send>;

/// What a step's pictures hold of memory until the last copy is gone, and who keeps the sum.
#[derive(Default)]
struct Debt {
    inbox: Weak<Inbox>,
    bytes: u64,
    /// Of these, not used by an encoding yet.
    spare: u64,
}

/// Answers when dropped.
pub(super) struct StepGuard {
    progress: Mutex<Progress>,
    answer: Mutex<Option<Answer>>,
    debt: Mutex<Debt>,
}

impl StepGuard {
    /// `answer` is called once, when the last share of the guard is gone; it must not block.
    pub(super) fn new(answer: impl FnOnce(Outcome) + Send + 'static) -> Self {
        Self {
            progress: Mutex::new(Progress { frames: Vec::new(), all_submitted: false, failure: None }),
            answer: Mutex::new(Some(Box::new(answer))),
            debt: Mutex::default(),
        }
    }

    /// The inbox has given this step out, and counts so many bytes as held; `spare` of them are for its encodings.
    pub(super) fn begun(&self, inbox: Weak<Inbox>, bytes: u64, spare: u64) {
        *self.debt.lock().unwrap_or_else(PoisonError::into_inner) = Debt { inbox, bytes, spare };
    }

    /// A picture of this step has been encoded for somebody in so many bytes.
    pub(super) fn holds(&self, bytes: u64) {
        let mut debt = self.debt.lock().unwrap_or_else(PoisonError::into_inner);
        let foreseen = bytes.min(debt.spare);
        let more = bytes - foreseen;
        debt.spare -= foreseen;
        debt.bytes += more;
        let inbox = debt.inbox.upgrade();
        drop(debt);
        if let Some(inbox) = inbox {
            inbox.held(more);
        }
    }

    /// A frame of this step is out.
    pub(super) fn frame(&self, view: &str, number: u64) {
        let frame = StepFrame { view: view.to_owned(), number, formats: BTreeSet::new(), copies: 0 };
        self.lock().frames.push(frame);
    }

    /// A copy of that frame has been written to a client's socket.
    pub(super) fn written(&self, view: &str, format: Format) {
        if let Some(frame) = self.lock().frames.iter_mut().find(|frame| frame.view == view) {
            frame.formats.insert(format);
            frame.copies += 1;
        }
    }

    /// Every view of the step has been given to the executor.
    pub(super) fn all_submitted(&self) {
        self.lock().all_submitted = true;
    }

    /// A frame of this step cannot be drawn.
    pub(super) fn fail(&self, why: &str) {
        self.lock().failure.get_or_insert_with(|| why.to_owned());
    }

    fn lock(&self) -> MutexGuard<'_, Progress> {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for StepGuard {
    fn drop(&mut self) {
        let debt = self.debt.get_mut().unwrap_or_else(PoisonError::into_inner);
        if let Some(inbox) = debt.inbox.upgrade() {
            inbox.freed(debt.bytes);
        }
        let progress = self.progress.get_mut().unwrap_or_else(PoisonError::into_inner);
        let outcome = match progress.failure.take() {
            Some(why) => Outcome::Failed(why),
            None if !progress.all_submitted => Outcome::Failed("the server stops".into()),
            None => Outcome::Drawn(std::mem::take(&mut progress.frames)),
        };
        if let Some(answer) = self.answer.get_mut().unwrap_or_else(PoisonError::into_inner).take() {
            answer(outcome);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Arc, mpsc};

    #[test]
    fn answers_once_when_the_last_copy_is_gone() {
        let (sender, answers) = mpsc::sync_channel(4);
        let guard = Arc::new(StepGuard::new(move |outcome| sender.send(outcome).unwrap()));
        let copy = Arc::clone(&guard);
        guard.frame("nose", 3);
        guard.all_submitted();
        guard.written("nose", Format::Raw);
        guard.written("nose", Format::Raw);
        drop(guard);
        assert!(answers.try_recv().is_err(), "a copy is still in a queue");
        drop(copy);
        let formats = BTreeSet::from([Format::Raw]);
        let frame = StepFrame { view: "nose".into(), number: 3, formats, copies: 2 };
        assert_eq!(answers.try_recv(), Ok(Outcome::Drawn(vec![frame])));
        assert!(answers.try_recv().is_err());
    }

    #[test]
    fn an_unfinished_step_is_not_reported_as_drawn() {
        let (sender, answers) = mpsc::sync_channel(4);
        let second = sender.clone();
        drop(StepGuard::new(move |outcome| sender.send(outcome).unwrap()));
        assert!(matches!(answers.recv(), Ok(Outcome::Failed(_))));
        let guard = StepGuard::new(move |outcome| second.send(outcome).unwrap());
        guard.all_submitted();
        guard.fail("no memory");
        drop(guard);
        assert_eq!(answers.recv(), Ok(Outcome::Failed("no memory".into())));
    }
}
