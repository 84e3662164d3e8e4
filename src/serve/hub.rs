//! Who watches what: the clients, their subscriptions, and the HTTP requests that wait for a picture.

use super::inbox::Inbox;
use super::metrics::Metrics;
use super::pacer::Pacer;
use super::queue::Queue;
use super::roles::ClientId;
use crate::encode;
use crate::frame::Frame;
use crate::wire::control::out::{EventMessage, Outbound, SubscriptionStatistics};
use crate::wire::control::{self, Format, Subscription, WhenSlow};
use crate::world::event::Event;
use axum::body::Bytes;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::{mpsc, oneshot};

/// One connected client, as the rest of the server sees it.
pub(super) struct Client {
    pub(super) id: ClientId,
    pub(super) queue: Queue,
    subscriptions: Mutex<BTreeMap<String, Taking>>,
}

/// One subscription and its counts.
pub(super) struct Taking {
    pub(super) format: encode::Format,
    pub(super) wire_format: Format,
    pub(super) when_slow: WhenSlow,
    pub(super) max_rate_hz: f64,
    pub(super) pacer: Pacer,
    /// Has not had its first frame, which comes at once whatever the rate.
    pub(super) fresh: bool,
    pub(super) sent: u64,
    pub(super) dropped: u64,
}

impl Client {
    pub(super) fn new(id: ClientId, frames_per_view: usize) -> Self {
        Self { id, queue: Queue::new(frames_per_view), subscriptions: Mutex::default() }
    }

    pub(super) fn subscriptions(&self) -> MutexGuard<'_, BTreeMap<String, Taking>> {
        lock(&self.subscriptions)
    }

    /// This client's subscriptions in numbers.
    pub(super) fn statistics(&self) -> Vec<SubscriptionStatistics> {
        let one = |(view, taking): (&String, &Taking)| SubscriptionStatistics {
            client: self.id,
            view: view.clone(),
            format: taking.wire_format,
            sent: taking.sent,
            dropped: taking.dropped,
        };
        self.subscriptions().iter().map(one).collect()
    }
}

/// An HTTP request that waits for a picture.
pub(super) struct Ask {
    pub(super) view: String,
    pub(super) format: encode::Format,
    /// A frame of a snapshot from before this moment is not fresh.
    pub(super) since_us: u64,
    pub(super) reply: oneshot::Sender<Result<Picture, String>>,
}

/// An answer to an HTTP request.
pub(super) struct Picture {
    pub(super) frame: Arc<Frame>,
    /// The frame in the format asked for.
    pub(super) bytes: Bytes,
}

/// All who watch.
pub(super) struct Hub {
    clients: Mutex<BTreeMap<ClientId, Arc<Client>>>,
    asks: Mutex<Vec<Ask>>,
    newest: Mutex<BTreeMap<String, Arc<Frame>>>,
    next_client: AtomicU64,
    /// Who hears of the world's events beside the clients.
    listener: Mutex<Option<mpsc::Sender<Event>>>,
    inbox: Arc<Inbox>,
    metrics: Arc<Metrics>,
    frames_per_view: usize,
}

impl Hub {
    /// `frames_per_view`: frames that may wait for one subscription.
    pub(super) fn new(inbox: Arc<Inbox>, metrics: Arc<Metrics>, frames_per_view: usize) -> Self {
        Self {
            clients: Mutex::default(),
            asks: Mutex::default(),
            newest: Mutex::default(),
            next_client: AtomicU64::new(1),
            listener: Mutex::default(),
            inbox,
            metrics,
            frames_per_view,
        }
    }

    /// A new client; `None` when there are `most` already.
    pub(super) fn join(&self, most: usize) -> Option<Arc<Client>> {
        let mut clients = lock(&self.clients);
        if clients.len() >= most {
            return None;
        }
        let client = Arc::new(Client::new(self.next_client.fetch_add(1, Relaxed), self.frames_per_view));
        clients.insert(client.id, Arc::clone(&client));
        self.metrics.clients.store(clients.len() as u64, Relaxed);
        Some(client)
    }

    pub(super) fn leave(&self, client: &Client) {
        let mut clients = lock(&self.clients);
        clients.remove(&client.id);
        self.metrics.clients.store(clients.len() as u64, Relaxed);
        drop(clients);
        client.subscriptions().clear();
        client.queue.abandon();
        self.wanted_changed();
    }

    pub(super) fn clients(&self) -> Vec<Arc<Client>> {
        lock(&self.clients).values().cloned().collect()
    }

    /// Begins or replaces a subscription. `default_quality`: of a JPEG without one.
    pub(super) fn subscribe(&self, client: &Client, wish: &Subscription, default_quality: u8) {
        let format = match wish.format {
            Format::Raw => encode::Format::Raw,
            Format::Png => encode::Format::Png,
            Format::Jpeg => encode::Format::Jpeg { quality: wish.quality.unwrap_or(default_quality) },
        };
        let taking = Taking {
            format,
            wire_format: wish.format,
            when_slow: wish.when_slow,
            max_rate_hz: wish.max_rate_hz,
            pacer: Pacer::new(wish.max_rate_hz),
            fresh: true,
            sent: 0,
            dropped: 0,
        };
        client.subscriptions().insert(wish.view.clone(), taking);
        self.wanted_changed();
    }

    /// Ends a subscription. False: there was none.
    pub(super) fn unsubscribe(&self, client: &Client, view: &str) -> bool {
        let had = client.subscriptions().remove(view).is_some();
        self.wanted_changed();
        had
    }

    /// Ends everybody's subscriptions to a view that was removed.
    pub(super) fn end_view(&self, view: &str) {
        for client in self.clients() {
            client.subscriptions().remove(view);
        }
        self.wanted_changed();
    }

    /// Waits for the next fresh picture of a view.
    pub(super) fn ask(&self, view: &str, format: encode::Format) -> oneshot::Receiver<Result<Picture, String>> {
        let (reply, answer) = oneshot::channel();
        let ask = Ask { view: view.to_owned(), format, since_us: self.metrics.now_us(), reply };
        let mut asks = lock(&self.asks);
        asks.retain(|ask| !ask.reply.is_closed());
        asks.push(ask);
        drop(asks);
        self.wanted_changed();
        answer
    }

    /// The requests that a frame of this view and this age answers.
    pub(super) fn answered(&self, view: &str, snapshot_us: u64) -> Vec<Ask> {
        let mut asks = lock(&self.asks);
        let (answered, waiting): (Vec<Ask>, Vec<Ask>) =
            asks.drain(..).partition(|ask| ask.view == view && ask.since_us <= snapshot_us);
        *asks = waiting;
        drop(asks);
        if !answered.is_empty() {
            self.wanted_changed();
        }
        answered
    }

    /// The events of the world as values, for one listener inside the server; at most so many wait.
    pub(super) fn listen(&self, waiting: usize) -> mpsc::Receiver<Event> {
        let (listener, events) = mpsc::channel(waiting);
        *lock(&self.listener) = Some(listener);
        events
    }

    /// Tells everybody what happened in the world.
    pub(super) fn tell(&self, event: &Event) {
        // The listener answers a CIGI host, which hears no thunder: a storm's must not push out what it waits for.
        if !matches!(event, Event::Thunder { .. })
            && let Some(listener) = &*lock(&self.listener)
            && listener.try_send(event.clone()).is_err()
        {
            self.metrics.events_dropped.fetch_add(1, Relaxed);
        }
        if let Some(message) = EventMessage::from_world(event) {
            self.broadcast(&Outbound::Event(message));
        }
    }

    /// Tells everybody.
    pub(super) fn broadcast(&self, message: &Outbound) {
        let text = control::encode(message);
        for client in self.clients() {
            if !client.queue.push_event(text.clone()) {
                self.metrics.events_dropped.fetch_add(1, Relaxed);
            }
        }
    }

    /// The newest frame of a view, for requests in lockstep, where nothing is drawn between steps.
    pub(super) fn newest(&self, view: &str) -> Option<Arc<Frame>> {
        lock(&self.newest).get(view).cloned()
    }

    pub(super) fn set_newest(&self, frame: &Arc<Frame>) {
        lock(&self.newest).insert(frame.view.clone(), Arc::clone(frame));
    }

    /// Forgets everything about views that are gone.
    pub(super) fn retain_views(&self, exists: impl Fn(&str) -> bool) {
        lock(&self.newest).retain(|name, _| exists(name));
        self.metrics.retain_views(exists);
    }

    /// Frames waiting for clients, all together.
    pub(super) fn queued_frames(&self) -> usize {
        self.clients().iter().map(|client| client.queue.frames()).sum()
    }

    /// What the pictures of steps hold until their copies are written.
    pub(super) fn step_bytes(&self) -> u64 {
        self.inbox.held_bytes()
    }

    /// Tells the render thread which views somebody wants, and how often at most.
    pub(super) fn wanted_changed(&self) {
        let mut wanted: BTreeMap<String, f64> = BTreeMap::new();
        let mut want = |view: &str, rate_hz: f64| {
            let fastest = wanted.entry(view.to_owned()).or_insert(rate_hz);
            *fastest = fastest.max(rate_hz);
        };
        for client in self.clients() {
            client.subscriptions().iter().for_each(|(view, taking)| {
                want(view, if taking.fresh { f64::INFINITY } else { taking.max_rate_hz });
            });
        }
        let mut asks = lock(&self.asks);
        asks.retain(|ask| !ask.reply.is_closed());
        asks.iter().for_each(|ask| want(&ask.view, f64::INFINITY));
        drop(asks);
        self.inbox.set_wanted(wanted);
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
