//! What all requests share, and the routes: one port for WebSocket, pictures, numbers and the page.

use super::access::{Access, Trust};
use super::client_task;
use super::hub::Hub;
use super::metrics::Metrics;
use super::picture;
use super::roles::Roles;
use super::socket::Peer;
use super::world_task::Request;
use crate::geo::terrain::Terrain;
use crate::outputs::air::Air;
use crate::settings::Settings;
use crate::wire::limits;
use crate::world::command::{Command, ScenarioEdit};
use crate::world::event::Refused;
use axum::Router;
use axum::extract::{ConnectInfo, Query, State, WebSocketUpgrade};
use axum::http::{StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{Html, IntoResponse, Response};
use axum::routing::{any, get};
use std::collections::BTreeMap;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::{Semaphore, mpsc, oneshot};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

/// Shared by everything that serves a request.
pub(super) struct App {
    pub(super) settings: Settings,
    pub(super) access: Access,
    pub(super) hub: Arc<Hub>,
    pub(super) metrics: Arc<Metrics>,
    pub(super) roles: Roles,
    /// Turns of those who ask the world, so that questions cannot take all of the processor.
    pub(super) questions: Arc<Semaphore>,
    /// The ground.
    pub(super) terrain: Terrain,
    /// What a CIGI host has said of the air.
    pub(super) air: Mutex<Arc<Air>>,
    pub(super) requests: mpsc::Sender<Request>,
    pub(super) tasks: TaskTracker,
    /// Say goodbye and end.
    pub(super) stop: CancellationToken,
    /// End now.
    pub(super) kill: CancellationToken,
    pub(super) write_timeout: Duration,
}

/// Parameters of a request's query: names and values.
pub(super) type Parameters = Query<BTreeMap<String, String>>;

impl App {
    /// What a CIGI host has said of the air; the standard atmosphere where none speaks.
    pub(super) fn air(&self) -> Arc<Air> {
        Arc::clone(&self.air.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// A CIGI host has said something of the air.
    pub(super) fn set_air(&self, air: Air) {
        *self.air.lock().unwrap_or_else(PoisonError::into_inner) = Arc::new(air);
    }

    /// Asks the world task; waits for room in its queue and for its answer.
    pub(super) async fn ask_world<T>(&self, request: impl FnOnce(oneshot::Sender<T>) -> Request) -> Result<T, Refused> {
        let stopping = || Refused::new("server", "", "a running server", "the server stops");
        let (reply, answer) = oneshot::channel();
        self.requests.send(request(reply)).await.map_err(|_| stopping())?;
        answer.await.map_err(|_| stopping())
    }

    /// The command that loads a scenario of the server's folder.
    pub(super) async fn load_scenario(&self, name: &str) -> Result<Command, Refused> {
        let (settings, name) = (self.settings.clone(), name.to_owned());
        let read = tokio::task::spawn_blocking(move || settings.timeline(&name));
        let timeline = read.await.unwrap_or_else(|error| Err(Refused::new("name", "", "", error.to_string())))?;
        Ok(Command::Scenario(ScenarioEdit::Load(Arc::new(timeline))))
    }
}

/// All routes, each behind the same door.
pub(super) fn router(app: Arc<App>) -> Router {
    Router::new()
        .route("/", get(|| async { ([(header::CACHE_CONTROL, "no-store")], Html(include_str!("page.html"))) }))
        .route("/ws", any(websocket))
        .route("/frame.png", get(picture::png))
        .route("/frame.jpg", get(picture::jpeg))
        .route("/metrics", get(metrics))
        .route("/healthz", get(|| async { "ok\n" }))
        .layer(middleware::from_fn_with_state(Arc::clone(&app), door))
        .with_state(app)
}

async fn door(
    State(app): State<Arc<App>>,
    Query(parameters): Parameters,
    mut request: axum::extract::Request,
    next: Next,
) -> Response {
    let token = parameters.get("token").map(String::as_str);
    let trust = match app.access.judge(request.headers(), token) {
        Ok(trust) => trust,
        Err((status, why)) => {
            app.metrics.turned_away.fetch_add(1, Relaxed);
            tracing::debug!(path = request.uri().path(), %status, why, "request turned away");
            return (status, format!("{why}\n")).into_response();
        }
    };
    // Over a WebSocket the token may also come with `hello`: nothing else is answered before.
    if trust == Trust::Stranger && request.uri().path() != "/ws" {
        let how = [(header::WWW_AUTHENTICATE, "Bearer")];
        return (StatusCode::UNAUTHORIZED, how, "this server wants its token\n").into_response();
    }
    request.extensions_mut().insert(trust);
    next.run(request).await
}

async fn websocket(
    State(app): State<Arc<App>>,
    ConnectInfo(Peer(from)): ConnectInfo<Peer>,
    axum::Extension(trust): axum::Extension<Trust>,
    upgrade: WebSocketUpgrade,
) -> Response {
    let largest_frame = limits::FRAME_PAYLOAD_BYTES as usize + 4096;
    upgrade
        .max_message_size(limits::MESSAGE_BYTES)
        .max_frame_size(limits::MESSAGE_BYTES)
        // One frame at a time is written, and the next only when it is gone: so much and no more may stand here.
        .write_buffer_size(0)
        .max_write_buffer_size(2 * largest_frame)
        .on_failed_upgrade(|error| tracing::debug!(%error, "an upgrade to WebSocket failed"))
        .on_upgrade(move |socket| {
            let tasks = app.tasks.clone();
            tasks.track_future(client_task::serve(app, socket, from, trust == Trust::Trusted))
        })
}

async fn metrics(State(app): State<Arc<App>>) -> Response {
    app.metrics.queued.store(app.hub.queued_frames() as u64, Relaxed);
    app.metrics.step_bytes.store(app.hub.step_bytes(), Relaxed);
    ([(header::CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8")], app.metrics.text()).into_response()
}
