//! What the render thread does when a view, a picture or the device fails: tells those who wait, tries again later, goes on.

use super::{RenderThread, Rendered};
use crate::serve::backoff::Backoff;
use crate::world::snapshot::ViewState;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::Ordering::Relaxed;
use std::time::Duration;

/// How often a step's frame is tried again on a new executor before the step fails.
const ATTEMPTS: u32 = 3;
/// Faults that are remembered as logged; each is logged once.
const LOGGED: usize = 64;

/// A view that failed when it was drawn last.
pub(super) struct Failing {
    backoff: Backoff,
    why: String,
    /// At another size it is another try.
    size_px: [u32; 2],
}

impl RenderThread {
    /// Why this view is not drawn now, if it failed lately.
    pub(super) fn left_alone(&mut self, view: &ViewState) -> Option<String> {
        let now_us = self.metrics.now_us();
        let track = self.track(&view.name);
        track.failing.take_if(|failing| failing.size_px != view.size_px);
        let failing = track.failing.as_ref().filter(|failing| failing.backoff.left_us(now_us) > 0)?;
        Some(failing.why.clone())
    }

    /// Remembers that a view failed, tells everybody, and returns the reason in words for clients.
    pub(super) fn view_failed(&mut self, view: &str, size_px: [u32; 2], why: &str) -> String {
        let now_us = self.metrics.now_us();
        let why = format!("a fault of the server: view `{view}` cannot be drawn: {why}");
        let fresh = || Failing { backoff: Backoff::default(), why: String::new(), size_px };
        let failing = self.track(view).failing.get_or_insert_with(fresh);
        let pause = Duration::from_micros(failing.backoff.failed(now_us));
        (failing.why, failing.size_px) = (why.clone(), size_px);
        let news = Rendered::Failing { view: view.to_owned(), why: why.clone(), pause: Some(pause) };
        // A closed channel is noticed by the next frame.
        let _closed = self.out.blocking_send(news);
        why
    }

    /// This slot gives no picture, and what repeats it neither.
    pub(super) fn give_up(&mut self, ticket: u64, why: &str) {
        let Some(slot) = self.ring.slot_mut(ticket) else { return };
        slot.drawing = false;
        slot.repeats = false;
        slot.given_up = true;
        let (view, size_px, guard) = (slot.view.clone(), slot.plan.size_px, slot.guard.clone());
        let why = self.view_failed(&view, size_px, why);
        if let Some(guard) = guard {
            guard.fail(&why);
        }
        self.ring.forget_repeats(&view, &why);
        if let Some(track) = self.tracks.get_mut(&view) {
            track.last_plan = None;
            track.last_pixels = None;
        }
    }

    pub(super) fn lose_device(&mut self, why: &str) {
        self.note_fault(&format!("the device is lost, another executor follows: {why}"));
        for ticket in self.ring.drawing_tickets() {
            let Some(slot) = self.ring.slot_mut(ticket) else { continue };
            slot.attempts += 1;
            // A free-running frame is old by the time there is a new device; a step's frame is owed.
            if slot.guard.is_none() || slot.attempts >= ATTEMPTS {
                self.give_up(ticket, &format!("the device was lost: {why}"));
            }
        }
        self.drop_executor();
    }

    /// Ends the executor; what it was drawing will be drawn by the next one.
    pub(super) fn drop_executor(&mut self) {
        self.executor = None;
        self.losses.failed(self.metrics.now_us());
        for track in self.tracks.values_mut() {
            track.last_plan = None;
        }
        for ticket in self.ring.unfinished_tickets() {
            if let Some(slot) = self.ring.slot_mut(ticket) {
                slot.drawing = false;
                // What it repeats may never come.
                slot.repeats = false;
            }
        }
    }

    /// Makes a new executor and submits again what is owed; at once after a first loss, later and later after more of them.
    /// False: the server stops.
    pub(super) fn remake(&mut self) -> bool {
        while self.executor.is_none() {
            if self.inbox.stopped() || !self.emit() {
                return false;
            }
            let pause_us = self.losses.left_us(self.metrics.now_us());
            if pause_us > 0 {
                self.inbox.pause(Duration::from_micros(pause_us));
                continue;
            }
            match catch_unwind(AssertUnwindSafe(|| (self.factory)())) {
                Ok(Ok(executor)) => {
                    self.metrics.executors_remade.fetch_add(1, Relaxed);
                    self.metrics.set_executor(executor.describe());
                    self.metrics.set_tables(executor.tables());
                    tracing::info!(executor = executor.describe(), "drawing again");
                    self.executor = Some(executor);
                    for ticket in self.ring.unfinished_tickets() {
                        self.submit(ticket);
                    }
                }
                Ok(Err(fault)) => {
                    self.note_fault(&fault.to_string());
                    self.losses.failed(self.metrics.now_us());
                }
                Err(panic) => {
                    self.note_fault(&format!("making an executor panicked: {}", panic_text(panic.as_ref())));
                    self.losses.failed(self.metrics.now_us());
                }
            }
        }
        true
    }

    /// Counts a fault and logs it, unless it has been logged before.
    pub(super) fn note_fault(&mut self, what: &str) {
        self.metrics.faults.fetch_add(1, Relaxed);
        if self.logged.contains(what) {
            return;
        }
        tracing::error!(fault = what, "fault");
        if self.logged.len() >= LOGGED {
            self.logged.clear();
        }
        self.logged.insert(what.to_owned());
    }
}

/// What a panic said.
pub(super) fn panic_text(panic: &(dyn std::any::Any + Send)) -> &str {
    panic
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("without a word")
}
