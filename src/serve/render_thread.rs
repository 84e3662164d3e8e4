//! The render thread: owns the executor, the only one to touch it; snapshots in, finished frames out in order.

mod faults;

use super::backoff::Backoff;
use super::inbox::{Inbox, Posted, Work};
use super::metrics::Metrics;
use super::pacer::Pacer;
use super::ring::{Ring, Slot};
use super::stages::Stage;
use super::step::StepGuard;
use super::strikes::Strikes;
use crate::frame::{Frame, LatencyStamps, Pixels};
use crate::outputs::lit;
use crate::plan::executor::{Executor, Fault};
use crate::plan::{FramePlan, Output, plan};
use crate::world::snapshot::Snapshot;
use faults::{Failing, panic_text};
use std::collections::{BTreeMap, BTreeSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::time::Duration;
use tokio::sync::mpsc;

/// Makes an executor: the first one, and another after a device was lost. Called on the render thread, which owns what
/// it makes, so executors need not be `Send`.
pub type ExecutorFactory = Box<dyn FnMut() -> Result<Box<dyn Executor>, Fault> + Send>;

/// A frame on its way out, or the news that one was lost.
pub(super) enum Rendered {
    /// A picture.
    Frame {
        frame: Arc<Frame>,
        /// What it shows.
        snapshot: Arc<Snapshot>,
        /// The step that waits for its copies.
        guard: Option<Arc<StepGuard>>,
    },
    /// One frame fewer will show this snapshot: a fault ate it, or its round is planned and no more will follow.
    Lost(Arc<Snapshot>),
    /// A view cannot be drawn now: nobody should wait for it.
    Failing {
        view: String,
        why: String,
        /// Everybody is to be told: it has just failed, and is not drawn again for so long.
        pause: Option<Duration>,
    },
}

/// How long the thread sleeps at most while pictures are under way and there is room for more.
const POLL: Duration = Duration::from_millis(1);

/// What is remembered of a view between its frames.
struct Track {
    number: u64,
    last_plan: Option<Arc<FramePlan>>,
    last_pixels: Option<Arc<Pixels>>,
    /// Something was still being made for them: the same plan is drawn again.
    provisional: bool,
    pacer: Pacer,
    failing: Option<Failing>,
}

pub(super) struct RenderThread {
    factory: ExecutorFactory,
    executor: Option<Box<dyn Executor>>,
    inbox: Arc<Inbox>,
    metrics: Arc<Metrics>,
    strikes: Arc<Strikes>,
    out: mpsc::Sender<Rendered>,
    tracks: BTreeMap<String, Track>,
    ring: Ring,
    /// Losses of the device without a picture in between.
    losses: Backoff,
    logged: BTreeSet<String>,
}

impl RenderThread {
    /// Makes the first executor.
    ///
    /// # Errors
    /// The factory's fault: there is nothing to draw with.
    pub(super) fn new(
        mut factory: ExecutorFactory,
        inbox: Arc<Inbox>,
        metrics: Arc<Metrics>,
        strikes: Arc<Strikes>,
        out: mpsc::Sender<Rendered>,
    ) -> Result<Self, Fault> {
        let executor = factory()?;
        metrics.set_executor(executor.describe());
        metrics.set_tables(executor.tables());
        tracing::info!(executor = executor.describe(), depth = executor.depth(), "drawing");
        Ok(Self {
            factory,
            executor: Some(executor),
            inbox,
            metrics,
            strikes,
            out,
            tracks: BTreeMap::new(),
            ring: Ring::default(),
            losses: Backoff::default(),
            logged: BTreeSet::new(),
        })
    }

    /// Draws until the inbox stops or nobody takes frames any more.
    pub(super) fn run(mut self) {
        loop {
            if self.executor.is_none() && !self.remake() {
                break;
            }
            let depth = self.depth();
            let limit = if self.ring.is_empty() { None } else { Some(POLL) };
            let room = self.ring.drawing() < depth;
            // While running free, at most one round waits behind the one being drawn: more would only be older.
            let work = if room { self.inbox.take(limit, self.ring.rounds() < 2) } else { Work::Nothing };
            match work {
                Work::Stop => break,
                Work::Nothing if self.inbox.stopped() => break,
                Work::Nothing => {}
                Work::Free(posted, wanted) => {
                    self.round(&posted, None, &wanted);
                    self.release(posted);
                }
                Work::Step(posted, guard) => {
                    let all = posted.snapshot.views.iter().map(|view| (view.name.clone(), f64::INFINITY)).collect();
                    self.round(&posted, Some(&guard), &all);
                    guard.all_submitted();
                    self.release(posted);
                }
            }
            let wait = self.ring.drawing() >= self.depth();
            self.collect(wait);
            if !self.emit() {
                break;
            }
        }
    }

    fn depth(&self) -> usize {
        self.executor.as_ref().map_or(1, |executor| executor.depth().max(1))
    }

    /// Plans and submits every wanted view of one snapshot.
    fn round(&mut self, posted: &Posted, guard: Option<&Arc<StepGuard>>, wanted: &BTreeMap<String, f64>) {
        let snapshot = &posted.snapshot;
        self.tracks.retain(|name, _| snapshot.views.iter().any(|view| view.name == *name));
        self.ring.begin_round();
        for view in &snapshot.views {
            let Some(rate_hz) = wanted.get(&view.name) else { continue };
            if guard.is_none() && !self.due(&view.name, *rate_hz, posted.snapshot_us) {
                continue;
            }
            if let Some(why) = self.left_alone(view) {
                if let Some(guard) = guard {
                    guard.fail(&why);
                }
                // A closed channel is noticed by the next frame.
                let _closed = self.out.blocking_send(Rendered::Failing { view: view.name.clone(), why, pause: None });
                continue;
            }
            let begin_us = self.metrics.now_us();
            let planned = catch_unwind(AssertUnwindSafe(|| plan(snapshot, view, Output::Srgb8)));
            self.metrics.stages.add_us(Stage::Plan, self.metrics.now_us().saturating_sub(begin_us));
            let plan = match planned {
                // Only a step waits for what its pictures need: running free nothing may hold up a frame.
                Ok(plan) => Arc::new(FramePlan { waits: guard.is_some(), ..plan }),
                Err(panic) => {
                    let why = format!("planning panicked: {}", panic_text(panic.as_ref()));
                    self.note_fault(&why);
                    let why = self.view_failed(&view.name, view.size_px, &why);
                    if let Some(guard) = guard {
                        guard.fail(&why);
                    }
                    continue;
                }
            };
            let track = self.track(&view.name);
            let repeats = !track.provisional && track.last_plan.as_ref() == Some(&plan);
            track.last_plan = Some(Arc::clone(&plan));
            lit(snapshot).for_each(|id| self.strikes.taken(id));
            let slot = Slot::new(view.name.clone(), plan, posted.clone(), guard.cloned(), repeats);
            let ticket = self.ring.push(slot);
            if !repeats {
                self.submit(ticket);
            }
        }
    }

    /// The inbox held the flashes of this snapshot until its frames were under way.
    fn release(&mut self, posted: Posted) {
        if lit(&posted.snapshot).next().is_some() {
            // A closed channel is noticed by the next frame.
            let _closed = self.out.blocking_send(Rendered::Lost(posted.snapshot));
        }
    }

    fn due(&mut self, view: &str, rate_hz: f64, now_us: u64) -> bool {
        let pacer = &mut self.track(view).pacer;
        pacer.set_rate(rate_hz);
        pacer.due(now_us)
    }

    fn track(&mut self, view: &str) -> &mut Track {
        self.tracks.entry(view.to_owned()).or_insert_with(|| Track {
            number: 0,
            last_plan: None,
            last_pixels: None,
            provisional: false,
            pacer: Pacer::new(60.0),
            failing: None,
        })
    }

    /// Gives one slot to the executor, first making room in its ring.
    fn submit(&mut self, ticket: u64) {
        while self.ring.drawing() >= self.depth() && self.executor.is_some() {
            self.collect(true);
            if !self.emit() {
                return;
            }
        }
        let now_us = self.metrics.now_us();
        let Some(slot) = self.ring.slot_mut(ticket) else { return };
        let Some(executor) = self.executor.as_mut() else { return };
        slot.submitted_us = now_us;
        slot.drawing = true;
        let plan = Arc::clone(&slot.plan);
        let result = catch_unwind(AssertUnwindSafe(|| executor.submit(ticket, &plan)));
        match result {
            Ok(Ok(())) => {}
            Ok(Err(Fault::DeviceLost(why))) => self.lose_device(&why),
            Ok(Err(fault)) => {
                let why = fault.to_string();
                self.note_fault(&why);
                self.give_up(ticket, &why);
                if let Fault::Rejected(_) = fault {
                    // What it holds of the refused picture is broken; the other pictures are drawn by the next one.
                    self.drop_executor();
                }
            }
            Err(panic) => self.lose_device(&format!("drawing panicked: {}", panic_text(panic.as_ref()))),
        }
    }

    fn collect(&mut self, wait: bool) {
        if self.ring.drawing() == 0 {
            return;
        }
        let Some(executor) = self.executor.as_mut() else { return };
        match catch_unwind(AssertUnwindSafe(|| executor.collect(wait))) {
            Ok(Ok(finished)) => {
                self.metrics.gpu_objects.store(executor.object_count() as u64, Relaxed);
                let now_us = self.metrics.now_us();
                if !finished.is_empty() {
                    self.losses = Backoff::default();
                }
                for picture in finished {
                    if let Some(slot) = self.ring.slot_mut(picture.ticket) {
                        slot.drawing = false;
                        slot.finished_us = now_us;
                        let read_back_us = picture.read_back.as_micros() as u64;
                        let drawing_us = now_us.saturating_sub(slot.submitted_us + read_back_us);
                        self.metrics.stages.add_us(Stage::Passes, drawing_us);
                        self.metrics.stages.add_us(Stage::ReadBack, read_back_us);
                        slot.pixels = Some(Arc::new(picture.pixels));
                        slot.provisional = picture.provisional;
                    }
                }
            }
            Ok(Err(Fault::DeviceLost(why) | Fault::Rejected(why))) => self.lose_device(&why),
            Ok(Err(fault)) => {
                let why = fault.to_string();
                self.note_fault(&why);
                for ticket in self.ring.drawing_tickets() {
                    self.give_up(ticket, &why);
                }
            }
            Err(panic) => self.lose_device(&format!("drawing panicked: {}", panic_text(panic.as_ref()))),
        }
    }

    /// Hands finished frames out, oldest first. False when nobody takes them any more.
    fn emit(&mut self) -> bool {
        while let Some(slot) = self.ring.pop_ready() {
            let rendered = self.finish(slot);
            if self.out.blocking_send(rendered).is_err() {
                return false;
            }
        }
        true
    }

    fn finish(&mut self, slot: Slot) -> Rendered {
        let snapshot = Arc::clone(&slot.posted.snapshot);
        let repeated = slot.repeats && slot.pixels.is_none();
        let last_pixels = self.tracks.get(&slot.view).and_then(|track| track.last_pixels.clone());
        let Some(pixels) = slot.pixels.or(if repeated { last_pixels } else { None }) else {
            return Rendered::Lost(snapshot);
        };
        let size_px = slot.plan.size_px;
        let track = self.track(&slot.view);
        track.number += 1;
        track.last_pixels = Some(Arc::clone(&pixels));
        if !repeated {
            track.failing = None;
            track.provisional = slot.provisional;
        }
        let provisional = track.provisional;
        let number = track.number;
        let now_us = self.metrics.now_us();
        let stamps = LatencyStamps {
            received_us: slot.posted.received_us,
            snapshot_us: slot.posted.snapshot_us,
            submitted_us: if repeated { now_us } else { slot.submitted_us },
            finished_us: if repeated { now_us } else { slot.finished_us },
        };
        self.measure(&slot.view, &stamps, repeated);
        if let Some(guard) = &slot.guard {
            guard.frame(&slot.view, number);
        }
        let frame = Arc::new(Frame {
            view: slot.view,
            number,
            host_frame: snapshot.host_frame,
            simulation_time_s: snapshot.simulation_time_s,
            width: size_px[0],
            height: size_px[1],
            pixels,
            provisional: provisional || snapshot.provisional(),
            repeated,
            stamps,
        });
        Rendered::Frame { frame, snapshot, guard: slot.guard }
    }

    fn measure(&self, view: &str, stamps: &LatencyStamps, repeated: bool) {
        self.metrics.count(view, |counts| counts.frame(stamps, repeated));
        if !repeated {
            self.metrics.render.add_us(stamps.finished_us.saturating_sub(stamps.submitted_us));
        }
    }
}
