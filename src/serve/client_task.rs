//! One WebSocket client: a task that reads its messages in order, and one that writes its queue.

use super::app::App;
use super::dispatch::{Session, Verdict};
use super::flood::{Bucket, Verdict as Flood};
use super::hub::Client;
use super::queue::{AWAY, Copy, Item, POLICY, TOO_BIG};
use super::stages::Stage;
use crate::wire::control;
use crate::wire::control::out::{Outbound, Refusal};
use crate::wire::frames::{self, FrameError, FrameHeader};
use crate::wire::limits;
use crate::world::event::Refused;
use axum::extract::ws::{CloseFrame, Message, WebSocket};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::time::{Duration, Instant};
use tokio_tungstenite::tungstenite::{self, error::ProtocolError};
use tokio_util::sync::CancellationToken;

/// Between two pings: a client that is there answers, one that vanished falls silent and is closed by the socket's rule.
const PING_EVERY: Duration = Duration::from_secs(15);
/// For the close frame at the end.
const LAST_WORDS: Duration = Duration::from_millis(300);
/// For a `hello` with the token, when the request had none.
const HELLO_WITHIN: Duration = Duration::from_secs(5);

/// Serves one client until either side ends. `trusted`: the request carried the token, or none is needed.
pub(super) async fn serve(app: Arc<App>, socket: WebSocket, from: SocketAddr, trusted: bool) {
    let (mut sink, stream) = socket.split();
    let Some(client) = app.hub.join(app.settings.max_clients as usize) else {
        let frame = CloseFrame { code: POLICY, reason: "too many clients".into() };
        let _closed = tokio::time::timeout(LAST_WORDS, sink.send(Message::Close(Some(frame)))).await;
        tracing::warn!(%from, "client refused: too many");
        return;
    };
    let ended = CancellationToken::new();
    let _ends_writer = ended.clone().drop_guard();
    app.tasks.spawn(write(Arc::clone(&app), Arc::clone(&client), sink, ended.clone()));
    tracing::info!(client = client.id, %from, "client connected");
    let mut session = Session::new(Arc::clone(&app), Arc::clone(&client), trusted);
    let why = read(&app, &mut session, stream, &ended).await;
    let was_host = session.end().await;
    app.hub.leave(&client);
    let read = session.messages();
    let clients = app.metrics.clients.load(Relaxed);
    tracing::info!(client = client.id, name = session.name(), was_host, messages = read, why, clients, "client left");
}

/// Reads until the end; says why it ended.
async fn read(
    app: &App,
    session: &mut Session,
    mut stream: SplitStream<WebSocket>,
    ended: &CancellationToken,
) -> &'static str {
    let begin = Instant::now();
    let mut bucket =
        Bucket::new(f64::from(limits::MESSAGES_PER_SECOND), f64::from(limits::MESSAGE_BURST), begin.elapsed());
    loop {
        let client = session.client();
        let hello_late = async {
            match session.trusted() {
                true => std::future::pending().await,
                false => tokio::time::sleep_until((begin + HELLO_WITHIN).into()).await,
            }
        };
        let next = async {
            client.queue.room().await;
            stream.next().await
        };
        let message = tokio::select! {
            () = app.stop.cancelled() => {
                // The goodbye is the writer's to send.
                ended.cancelled().await;
                return "the server stops";
            }
            () = ended.cancelled() => return "its connection could not be written to",
            () = hello_late => {
                client.queue.close_with(POLICY, "no hello with the token");
                ended.cancelled().await;
                return "no hello with the token";
            }
            message = next => message,
        };
        let message = match message {
            None => return "it went away",
            Some(Ok(Message::Close(_))) => return "it said goodbye",
            Some(Ok(message @ (Message::Text(_) | Message::Binary(_) | Message::Ping(_) | Message::Pong(_)))) => {
                message
            }
            Some(Err(error)) => {
                let (code, why) = judge(&error);
                client.queue.close_with(code, why);
                ended.cancelled().await;
                return why;
            }
        };
        app.metrics.messages.fetch_add(1, Relaxed);
        match bucket.judge(begin.elapsed()) {
            Flood::Take => {}
            Flood::Drop => {
                app.metrics.unsaid.fetch_add(1, Relaxed);
                continue;
            }
            Flood::Refuse { unsaid } => {
                let limit = format!("{} messages a second", limits::MESSAGES_PER_SECOND);
                let refused = Refused::new("message", "", limit, "too many messages; nothing in this one was read");
                refuse(app, &client, None, refused, unsaid);
                continue;
            }
        }
        let text = match message {
            Message::Text(text) => text,
            // The socket answers pings by itself; here they only count.
            Message::Ping(_) | Message::Pong(_) | Message::Close(_) => continue,
            Message::Binary(_) => {
                let refused = Refused::new("message", "binary", "text", "control messages are JSON texts");
                refuse(app, &client, None, refused, 0);
                continue;
            }
        };
        if let Verdict::End(why) = session.handle(&text).await {
            client.queue.close_with(POLICY, why);
            ended.cancelled().await;
            return why;
        }
    }
}

/// What a failure to read means: close code and reason.
fn judge(error: &axum::Error) -> (u16, &'static str) {
    let cause = std::error::Error::source(error).and_then(|source| source.downcast_ref::<tungstenite::Error>());
    match cause {
        Some(tungstenite::Error::Capacity(_)) => (TOO_BIG, "its message was too long"),
        Some(tungstenite::Error::Utf8(_)) => (POLICY, "its message was no text"),
        Some(tungstenite::Error::Io(_)) => (POLICY, "its connection broke or fell silent"),
        Some(tungstenite::Error::Protocol(ProtocolError::ResetWithoutClosingHandshake)) => {
            (POLICY, "it vanished without a goodbye")
        }
        _ => (POLICY, "it broke the WebSocket protocol"),
    }
}

/// Answers with a refusal.
pub(super) fn refuse(app: &App, client: &Client, seq: Option<u64>, refused: Refused, unsent: u64) {
    app.metrics.refusals.fetch_add(1, Relaxed);
    client.queue.push_answer(control::encode(&Outbound::Refused(Refusal::new(seq, refused, unsent))));
}

/// Writes the queue until the connection ends, then gives up what is left.
async fn write(app: Arc<App>, client: Arc<Client>, mut sink: SplitSink<WebSocket, Message>, ended: CancellationToken) {
    let mut ping = tokio::time::interval(PING_EVERY);
    let close = loop {
        let item = tokio::select! {
            () = app.stop.cancelled() => break Some((AWAY, "the server stops".to_owned())),
            () = ended.cancelled() => break None,
            _ = ping.tick() => None,
            item = client.queue.next() => Some(item),
        };
        let (message, copy) = match item {
            None => (Message::Ping(axum::body::Bytes::new()), None),
            Some(Item::Text(text)) => (Message::Text(text.into()), None),
            Some(Item::Frame(copy)) if !still_wanted(&client, &copy) => continue,
            Some(Item::Frame(copy)) => match message(&app, &client, &copy) {
                Ok(bytes) => (Message::Binary(bytes.into()), Some(copy)),
                Err(error) => {
                    app.metrics.faults.fetch_add(1, Relaxed);
                    tracing::error!(client = client.id, %error, "fault: a frame has no header");
                    break Some((POLICY, "a frame could not be written".to_owned()));
                }
            },
            Some(Item::Close(code, reason)) => break Some((code, reason)),
        };
        let written = tokio::select! {
            written = tokio::time::timeout(app.write_timeout, sink.send(message)) => written,
            () = app.kill.cancelled() => break None,
            () = ended.cancelled() => break None,
        };
        match written {
            Ok(Ok(())) => {}
            Ok(Err(_)) => break None,
            Err(_) => {
                let waited_s = app.write_timeout.as_secs_f64();
                tracing::warn!(client = client.id, waited_s, "slow client disconnected: it does not read");
                app.metrics.disconnected.fetch_add(1, Relaxed);
                break None;
            }
        }
        if let Some(copy) = copy {
            if !copy.frame.repeated {
                app.metrics.stages.add_us(Stage::Send, app.metrics.now_us().saturating_sub(copy.encoded_us));
            }
            app.metrics.count(&copy.frame.view, |counts| counts.sent += 1);
            if let Some(taking) = client.subscriptions().get_mut(&copy.frame.view) {
                taking.sent += 1;
            }
            if let Some(guard) = &copy.guard {
                guard.written(&copy.frame.view, copy.format);
            }
        }
    };
    // From here on nothing waits for this client any more.
    ended.cancel();
    client.queue.abandon();
    if let Some((code, reason)) = close {
        let frame = CloseFrame { code, reason: reason.into() };
        let _closed = tokio::time::timeout(LAST_WORDS, sink.send(Message::Close(Some(frame)))).await;
    }
}

/// Not after `unsubscribe`, nor in the format of a subscription that was replaced.
fn still_wanted(client: &Client, copy: &Copy) -> bool {
    client.subscriptions().get(&copy.frame.view).is_some_and(|taking| taking.wire_format == copy.format)
}

/// The bytes of one copy: the header is this client's own.
fn message(app: &App, client: &Client, copy: &Copy) -> Result<Vec<u8>, FrameError> {
    let Copy { frame, picture, .. } = copy;
    let dropped = client.subscriptions().get(&frame.view).map_or(0, |taking| taking.dropped);
    let header = FrameHeader {
        format: copy.format,
        provisional: frame.provisional,
        repeated: frame.repeated,
        last_of_step: copy.last_of_step,
        width_px: frame.width,
        height_px: frame.height,
        host_frame: frame.host_frame,
        frame: frame.number,
        view: frame.view.clone(),
        simulation_time_s: frame.simulation_time_s,
        stamps: frame.stamps,
        encoded_us: copy.encoded_us,
        sent_us: app.metrics.now_us(),
        dropped: dropped.try_into().unwrap_or(u32::MAX),
        payload_bytes: picture.len().try_into().unwrap_or(u32::MAX),
    };
    frames::encode_message(&header, picture)
}
