//! A server to test, and clients that talk to it in plain JSON.

use crate::executor::Control;
use serde_json::{Value, json};
use std::collections::VecDeque;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use stormdeck::serve::client::{Client, Incoming};
use stormdeck::serve::{self, ServeError};
use stormdeck::settings::{Settings, TerrainChoice};
use stormdeck::wire::frames::{self, FrameHeader};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::oneshot;
use tokio::task::JoinHandle;

/// A guard against hanging, long enough for a machine that is busy with other tests.
pub const GUARD: Duration = Duration::from_secs(60);

/// Waits for a future, or fails the test.
pub async fn guarded<F: Future>(what: &str, future: F) -> F::Output {
    match tokio::time::timeout(GUARD, future).await {
        Ok(output) => output,
        Err(_) => panic!("nothing came: {what}"),
    }
}

/// A running server.
pub struct Server {
    pub address: SocketAddr,
    pub control: Arc<Control>,
    stop: oneshot::Sender<()>,
    task: JoinHandle<Result<(), ServeError>>,
}

impl Server {
    /// A server with the usual settings.
    pub async fn start() -> Self {
        Self::start_with(|_| {}).await
    }

    /// A server with settings that `change` has changed.
    pub async fn start_with(change: impl FnOnce(&mut Settings)) -> Self {
        let control = Arc::new(Control::default());
        let factory = control.factory();
        Self::start_on(change, control, factory).await
    }

    /// A server with an executor of its own.
    pub async fn start_on(
        change: impl FnOnce(&mut Settings),
        control: Arc<Control>,
        factory: serve::ExecutorFactory,
    ) -> Self {
        let mut settings = settings();
        change(&mut settings);
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let (stop, stopped) = oneshot::channel::<()>();
        let shutdown = async move {
            let _dropped = stopped.await;
        };
        let task = tokio::spawn(serve::run(listener, settings, factory, shutdown));
        Self { address, control, stop, task }
    }

    /// A connection that has said nothing yet.
    pub async fn connect(&self) -> Talker {
        let client = guarded("a connection", Client::connect(&self.address.to_string(), None)).await.unwrap();
        Talker { client, seq: 0, frames: VecDeque::new(), events: VecDeque::new(), answers: VecDeque::new() }
    }

    /// A watcher.
    pub async fn watcher(&self) -> Talker {
        self.greeted(json!({"role": "watcher", "name": "watcher"})).await
    }

    /// The host; the world's only view, `main`, is made small.
    pub async fn host(&self) -> Talker {
        let mut host = self.greeted(json!({"role": "host", "name": "host"})).await;
        host.acked(json!({"type": "view", "action": "change", "name": "main", "size_px": [32, 16]})).await;
        host
    }

    async fn greeted(&self, hello: Value) -> Talker {
        let mut talker = self.connect().await;
        let welcome = talker.hello(hello).await;
        assert_eq!(welcome["type"], "welcome", "{welcome}");
        talker
    }

    /// Sends a whole HTTP request and returns status, head and body. The connection is closed by the server.
    pub async fn http(&self, path: &str, headers: &str) -> (u16, String, Vec<u8>) {
        let request = format!("GET {path} HTTP/1.1\r\nHost: {}\r\n{headers}Connection: close\r\n\r\n", self.address);
        self.raw(&request).await
    }

    /// The same with nothing added.
    pub async fn raw(&self, request: &str) -> (u16, String, Vec<u8>) {
        let mut stream = TcpStream::connect(self.address).await.unwrap();
        stream.write_all(request.as_bytes()).await.unwrap();
        let mut bytes = Vec::new();
        let whole = async {
            loop {
                let split = bytes.windows(4).position(|window| window == b"\r\n\r\n");
                let head = split.map(|split| String::from_utf8(bytes[..split].to_vec()).unwrap());
                if let (Some(split), Some(head)) = (split, head)
                    && bytes.len() >= split + 4 + content_length(&head)
                {
                    return (split, head);
                }
                assert_ne!(stream.read_buf(&mut bytes).await.unwrap(), 0, "the answer breaks off");
            }
        };
        let (split, head) = guarded("an HTTP answer", whole).await;
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        (status, head, bytes[split + 4..].to_vec())
    }

    /// The number of a line of `/metrics`.
    pub async fn metric(&self, name: &str) -> f64 {
        let (status, _, body) = self.http("/metrics", "").await;
        assert_eq!(status, 200);
        let text = String::from_utf8(body).unwrap();
        let line = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '));
        line.map_or(0.0, |value| value.parse().unwrap())
    }

    /// Waits until a metric fulfils a condition.
    pub async fn until_metric(&self, name: &str, fulfils: impl Fn(f64) -> bool) -> f64 {
        guarded(name, async {
            loop {
                let value = self.metric(name).await;
                if fulfils(value) {
                    return value;
                }
                tokio::time::sleep(Duration::from_millis(20)).await;
            }
        })
        .await
    }

    /// Stops it, and expects that it says nothing is wrong.
    pub async fn stop(self) {
        let _gone = self.stop.send(());
        guarded("the end of the server", self.task).await.unwrap().unwrap();
    }

    /// Its answer when it ended by itself.
    pub async fn ended(self) -> Result<(), ServeError> {
        guarded("the end of the server", self.task).await.unwrap()
    }
}

fn content_length(head: &str) -> usize {
    let lower = head.to_lowercase();
    let line = lower.lines().find_map(|line| line.strip_prefix("content-length:"));
    line.map_or(0, |length| length.trim().parse().unwrap())
}

fn settings() -> Settings {
    // Over the bare ellipsoid heights are what the tests say.
    Settings { scenario: None, terrain: TerrainChoice::Ellipsoid, ..Settings::default() }
}

/// A frame as a client has it.
#[derive(Clone, Debug)]
pub struct Received {
    pub header: FrameHeader,
    pub picture: Vec<u8>,
}

/// One client: what it said and what it heard.
pub struct Talker {
    pub client: Client,
    seq: u64,
    pub frames: VecDeque<Received>,
    pub events: VecDeque<Value>,
    answers: VecDeque<Value>,
}

impl Talker {
    /// Says hello with these fields; returns the answer.
    pub async fn hello(&mut self, mut hello: Value) -> Value {
        hello["type"] = "hello".into();
        hello["protocol"] = "stormdeck.v1".into();
        self.ask(hello).await
    }

    /// Sends a message with a fresh `seq`, which is returned.
    pub async fn say(&mut self, mut message: Value) -> u64 {
        self.seq += 1;
        message["seq"] = self.seq.into();
        self.client.send(message.to_string()).await.unwrap();
        self.seq
    }

    /// Sends a message and returns the answer to it.
    pub async fn ask(&mut self, message: Value) -> Value {
        let what = message.to_string();
        let seq = self.say(message).await;
        guarded(&what, self.answer(seq)).await
    }

    /// Sends a message that must be acknowledged.
    pub async fn acked(&mut self, message: Value) -> Value {
        let what = message.to_string();
        let answer = self.ask(message).await;
        assert_eq!(answer["type"], "ack", "{what}: {answer}");
        answer
    }

    /// Sends a message that must be refused because of this field.
    pub async fn refused(&mut self, message: Value, field: &str) -> Value {
        let what = message.to_string();
        let answer = self.ask(message).await;
        assert_eq!((&answer["type"], &answer["field"]), (&json!("refused"), &json!(field)), "{what}: {answer}");
        assert!(answer["why"].as_str().is_some_and(|why| !why.is_empty()), "{answer}");
        answer
    }

    pub async fn subscribe(&mut self, view: &str, format: &str) {
        self.acked(json!({"type": "subscribe", "view": view, "format": format})).await;
    }

    /// The answer to the message of this number.
    pub async fn answer(&mut self, seq: u64) -> Value {
        loop {
            if let Some(at) = self.answers.iter().position(|answer| answer["seq"] == seq) {
                return self.answers.remove(at).unwrap();
            }
            self.read_one().await;
        }
    }

    /// The next answer, whatever it answers.
    pub async fn next_answer(&mut self) -> Value {
        guarded("an answer", async {
            loop {
                if let Some(answer) = self.answers.pop_front() {
                    return answer;
                }
                self.read_one().await;
            }
        })
        .await
    }

    /// The next frame.
    pub async fn frame(&mut self) -> Received {
        guarded("a frame", async {
            loop {
                if let Some(frame) = self.frames.pop_front() {
                    return frame;
                }
                self.read_one().await;
            }
        })
        .await
    }

    /// The next frame that fulfils a condition.
    pub async fn frame_that(&mut self, what: &str, fulfils: impl Fn(&Received) -> bool) -> Received {
        guarded(what, async {
            loop {
                let frame = self.frame().await;
                if fulfils(&frame) {
                    return frame;
                }
            }
        })
        .await
    }

    /// The next event of this kind (or telemetry, by that name).
    pub async fn event(&mut self, kind: &str) -> Value {
        guarded(kind, async {
            loop {
                while let Some(event) = self.events.pop_front() {
                    if event["event"] == kind || event["type"] == kind {
                        return event;
                    }
                }
                self.read_one().await;
            }
        })
        .await
    }

    /// Reads until the connection ends; the server's reason.
    pub async fn end(&mut self) -> Option<String> {
        guarded("the end of the connection", async {
            loop {
                match self.client.next().await {
                    Ok(Incoming::Closed(reason)) => return reason,
                    Ok(_) => {}
                    Err(_) => return None,
                }
            }
        })
        .await
    }

    async fn read_one(&mut self) {
        match self.client.next().await.unwrap() {
            Incoming::Text(text) => {
                let message: Value = serde_json::from_str(&text).unwrap();
                match message["type"].as_str().unwrap() {
                    "event" | "telemetry" => self.events.push_back(message),
                    _ => self.answers.push_back(message),
                }
            }
            Incoming::Frame(bytes) => {
                let (header, picture) = frames::decode_message(&bytes).unwrap();
                self.frames.push_back(Received { header, picture: picture.to_vec() });
            }
            Incoming::Closed(reason) => panic!("the server closed the connection: {reason:?}"),
        }
    }
}
