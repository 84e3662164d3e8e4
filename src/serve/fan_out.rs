//! Frames from the render thread to everybody who wants them: each encoded once per format, each client's copy queued.
//!
//! Nothing here waits for a client. Encodings of a few frames run side by side on the blocking pool and go out in order;
//! when the pool is behind, the bounded channel holds the render thread back, which then draws fewer frames.

use super::hub::{Ask, Client, Hub, Picture};
use super::metrics::Metrics;
use super::queue::{Copy, POLICY, Pushed};
use super::render_thread::Rendered;
use super::stages::Stage;
use super::step::StepGuard;
use super::strikes::Strikes;
use crate::encode;
use crate::frame::{Frame, Pixels};
use crate::outputs::{self, lit};
use crate::wire::control::out::{EventMessage, Outbound};
use crate::wire::control::{Format, WhenSlow};
use crate::world::event::Event;
use crate::world::snapshot::Snapshot;
use axum::body::Bytes;
use futures_util::StreamExt;
use futures_util::future::join_all;
use futures_util::stream::FuturesOrdered;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use tokio::sync::{OnceCell, mpsc};
use tokio_util::sync::CancellationToken;

/// Frames whose encodings may run at the same time.
const SIDE_BY_SIDE: usize = 4;

type Encoded = Arc<OnceCell<Result<Bytes, String>>>;

/// The encodings of one picture; kept while frames repeat it.
struct Cached {
    pixels: Arc<Pixels>,
    formats: BTreeMap<encode::Format, Encoded>,
}

struct Recipient {
    client: Arc<Client>,
    format: encode::Format,
    wire_format: Format,
    when_slow: WhenSlow,
    last_of_step: bool,
}

/// A frame with everything that will leave the server because of it.
struct Parcel {
    frame: Arc<Frame>,
    guard: Option<Arc<StepGuard>>,
    recipients: Vec<Recipient>,
    asks: Vec<Ask>,
    encoded: BTreeMap<encode::Format, Result<Bytes, String>>,
    encoded_us: u64,
}

pub(super) struct FanOut {
    hub: Arc<Hub>,
    metrics: Arc<Metrics>,
    strikes: Arc<Strikes>,
    /// Encodings of each view's newest picture.
    cache: BTreeMap<String, Cached>,
}

impl FanOut {
    pub(super) fn new(hub: Arc<Hub>, metrics: Arc<Metrics>, strikes: Arc<Strikes>) -> Self {
        Self { hub, metrics, strikes, cache: BTreeMap::new() }
    }

    /// Runs until the render thread is gone or the server stops.
    pub(super) async fn run(mut self, mut frames: mpsc::Receiver<Rendered>, stop: CancellationToken) {
        let mut encoding = FuturesOrdered::new();
        loop {
            tokio::select! {
                () = stop.cancelled() => break,
                Some(parcel) = encoding.next(), if !encoding.is_empty() => {
                    self.metrics.encoding.store(encoding.len() as u64, Relaxed);
                    self.deliver(parcel);
                }
                rendered = frames.recv(), if encoding.len() < SIDE_BY_SIDE => match rendered {
                    None => break,
                    Some(Rendered::Lost(snapshot)) => {
                        lit(&snapshot).filter(|id| self.strikes.lost(*id)).for_each(|id| missed(&self.hub, id));
                    }
                    Some(Rendered::Failing { view, why, pause }) => {
                        for ask in self.hub.answered(&view, u64::MAX) {
                            // A requester that has gone away needs no answer.
                            let _gone = ask.reply.send(Err(why.clone()));
                        }
                        if let Some(pause) = pause {
                            let what = format!("{why}; it is tried again in {} s", pause.as_secs_f64());
                            self.hub.broadcast(&Outbound::Event(EventMessage::Fault { what }));
                        }
                    }
                    Some(Rendered::Frame { frame, snapshot, guard }) => {
                        for id in lit(&snapshot).filter(|id| self.strikes.shown(*id)) {
                            self.hub.tell(&outputs::shown(&snapshot, id, &frame.view, frame.number));
                        }
                        self.hub.retain_views(|name| snapshot.views.iter().any(|view| view.name == name));
                        self.cache.retain(|name, _| snapshot.views.iter().any(|view| view.name == *name));
                        self.hub.set_newest(&frame);
                        encoding.push_back(self.pack(frame, &snapshot, guard));
                        self.metrics.encoding.store(encoding.len() as u64, Relaxed);
                    }
                },
            }
        }
    }

    /// Decides who gets this frame, and begins to encode it for them.
    fn pack(
        &mut self,
        frame: Arc<Frame>,
        snapshot: &Snapshot,
        guard: Option<Arc<StepGuard>>,
    ) -> impl Future<Output = Parcel> + use<> {
        let (mut recipients, mut first_frames) = (Vec::new(), false);
        for client in self.hub.clients() {
            let mut subscriptions = client.subscriptions();
            let Some(taking) = subscriptions.get_mut(&frame.view) else { continue };
            // In lockstep every subscriber gets every frame: its rate is the host's.
            if guard.is_some() || taking.pacer.due(frame.stamps.snapshot_us) {
                first_frames |= std::mem::take(&mut taking.fresh);
                let (format, wire_format, when_slow) = (taking.format, taking.wire_format, taking.when_slow);
                let last = snapshot.views.iter().rev().find(|view| subscriptions.contains_key(&view.name));
                let last_of_step = guard.is_some() && last.is_some_and(|view| view.name == frame.view);
                drop(subscriptions);
                recipients.push(Recipient { client, format, wire_format, when_slow, last_of_step });
            }
        }
        if first_frames {
            self.hub.wanted_changed();
        }
        let asks = self.hub.answered(&frame.view, frame.stamps.snapshot_us);
        let formats: BTreeSet<encode::Format> =
            recipients.iter().map(|to| to.format).chain(asks.iter().map(|ask| ask.format)).collect();
        let cells: Vec<_> = formats.iter().map(|format| (*format, self.cell(&frame, *format))).collect();
        let metrics = Arc::clone(&self.metrics);
        async move {
            let all = cells.iter().map(|(format, cell)| encode_once(cell, &frame, *format, &metrics));
            let encoded = formats.into_iter().zip(join_all(all).await).collect();
            let encoded_us = metrics.now_us();
            if !frame.repeated && !recipients.is_empty() {
                metrics.stages.add_us(Stage::Encode, encoded_us.saturating_sub(frame.stamps.finished_us));
                metrics.stages.encoded(frame.stamps.received_us, encoded_us);
            }
            Parcel { frame, guard, recipients, asks, encoded, encoded_us }
        }
    }

    /// The place of one encoding, shared with the frames that repeat the picture.
    fn cell(&mut self, frame: &Frame, format: encode::Format) -> Encoded {
        let fresh = || Cached { pixels: Arc::clone(&frame.pixels), formats: BTreeMap::new() };
        let cached = self.cache.entry(frame.view.clone()).or_insert_with(fresh);
        if !Arc::ptr_eq(&cached.pixels, &frame.pixels) {
            *cached = fresh();
        }
        Arc::clone(cached.formats.entry(format).or_default())
    }

    fn deliver(&self, parcel: Parcel) {
        let Parcel { frame, guard, recipients, asks, encoded, encoded_us } = parcel;
        for ask in asks {
            if let Some(result) = encoded.get(&ask.format) {
                // A requester that has gone away needs no answer.
                let picture = result.clone().map(|bytes| Picture { frame: Arc::clone(&frame), bytes });
                let _gone = ask.reply.send(picture);
            }
        }
        if let Some(guard) = &guard {
            let taken: BTreeSet<encode::Format> = recipients.iter().map(|to| to.format).collect();
            let bytes =
                taken.iter().filter_map(|format| encoded.get(format)?.as_ref().ok()).map(|bytes| bytes.len() as u64);
            guard.holds(bytes.sum());
        }
        for Recipient { client, format, wire_format, when_slow, last_of_step } in recipients {
            let Some(Ok(picture)) = encoded.get(&format) else { continue };
            let (frame, picture, guard) = (Arc::clone(&frame), picture.clone(), guard.clone());
            let view = frame.view.clone();
            let copy = Copy { frame, picture, format: wire_format, encoded_us, last_of_step, guard };
            match client.queue.push_frame(copy, when_slow) {
                Pushed::Queued => {}
                Pushed::Dropped => {
                    self.metrics.count(&view, |counts| counts.dropped += 1);
                    if let Some(taking) = client.subscriptions().get_mut(&view) {
                        taking.dropped += 1;
                    }
                }
                Pushed::Disconnecting => self.metrics.count(&view, |counts| counts.dropped += 1),
            }
        }
        for (format, result) in &encoded {
            if let Err(why) = result {
                self.metrics.faults.fetch_add(1, Relaxed);
                tracing::error!(?format, view = frame.view, why, "fault: a frame could not be encoded");
                self.hub.clients().iter().for_each(|client| {
                    if client.subscriptions().get(&frame.view).is_some_and(|taking| taking.format == *format) {
                        client.queue.close_with(POLICY, "this view cannot be encoded in the format subscribed to");
                    }
                });
            }
        }
    }
}

/// Tells everybody that a flash was over before a frame could show it.
pub(super) fn missed(hub: &Hub, id: u64) {
    hub.tell(&Event::StrikeMissed { id });
}

/// Encodes on the blocking pool, unless it has been done for this picture.
async fn encode_once(
    cell: &Encoded,
    frame: &Arc<Frame>,
    format: encode::Format,
    metrics: &Arc<Metrics>,
) -> Result<Bytes, String> {
    cell.get_or_init(|| async {
        let (frame, metrics) = (Arc::clone(frame), Arc::clone(metrics));
        let task = tokio::task::spawn_blocking(move || {
            let begin_us = metrics.now_us();
            let result = encode::encode(&frame, format);
            metrics.encode.add_us(metrics.now_us().saturating_sub(begin_us));
            metrics.encodings.fetch_add(1, Relaxed);
            result.map(Bytes::from).map_err(|error| error.to_string())
        });
        task.await.unwrap_or_else(|error| Err(error.to_string()))
    })
    .await
    .clone()
}
