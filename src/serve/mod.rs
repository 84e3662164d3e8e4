//! The server, and the client side of its protocol: the only importer of tokio.
//!
//! Who runs what: one task for each client and direction, one *world task* that owns the world, one *render thread* that
//! owns the executor, one *fan-out task* between it and the clients. All channels are bounded. [`run`] ends all of them.

mod access;
mod app;
mod backoff;
mod cigi;
pub mod client;
mod client_task;
mod dispatch;
mod fan_out;
mod flood;
mod grower;
mod hub;
mod inbox;
mod inside;
mod metrics;
mod pacer;
mod picture;
mod queue;
mod render_thread;
mod ring;
mod roles;
mod signals;
mod socket;
mod stages;
mod statistics;
mod step;
mod strikes;
mod thunder;
mod world_task;

pub use cigi::Known;
pub use inside::with_server;
pub use render_thread::ExecutorFactory;
pub use signals::shutdown_signal;
pub use stages::{Stage, Stages};

use crate::geo::terrain::Terrain;
use crate::lightning::guard::FlickerGuard;
use crate::plan::executor::Fault;
use crate::settings::{NoGround, Settings};
use crate::wire::limits;
use crate::world::World;
use crate::world::command::{Command, ScenarioEdit};
use crate::world::event::Refused;
use access::Access;
use app::App;
use fan_out::FanOut;
use hub::Hub;
use inbox::Inbox;
use metrics::Metrics;
use render_thread::{RenderThread, Rendered};
use roles::Roles;
use socket::Doorman;
use std::future::Future;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use strikes::Strikes;
use tokio::net::TcpListener;
use tokio::sync::{Semaphore, mpsc, oneshot};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;
use world_task::WorldTask;

/// Connections beside the WebSocket clients that settings allow: pictures, metrics, pages.
const SPARE_CONNECTIONS: usize = 32;
/// A connection from which nothing arrives for so long is closed; a living WebSocket answers a ping within this.
const IDLE: Duration = Duration::from_secs(60);
/// Finished frames that wait for the fan-out.
const FRAMES_WAITING: usize = 4;
/// For goodbyes at the end.
const GOODBYE: Duration = Duration::from_millis(600);
/// For everything that was told to end at once.
const ENDING: Duration = Duration::from_millis(300);
/// For the picture that is being drawn.
const DRAWING_ENDS: Duration = Duration::from_millis(400);

/// Why the server could not run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServeError {
    /// There is nothing to draw with.
    #[error(transparent)]
    Executor(#[from] Fault),
    /// The scenario to start with is not there or wrong.
    #[error("the scenario to start with: {0}")]
    Scenario(Refused),
    /// The file of heights cannot be the ground.
    #[error("the ground: {0}")]
    Ground(#[from] NoGround),
    /// The system refused a socket or a thread.
    #[error("the server cannot run: {0}")]
    System(#[from] std::io::Error),
    /// A thread of the server died before it served.
    #[error("the drawing thread died before its first frame")]
    Died,
}

/// Serves on `listener` until `shutdown` is done; then every task has ended.
///
/// `executor_factory` is called on the render thread, once now and again whenever a device is lost. Ends within two seconds
/// of `shutdown`; only a picture that takes longer than that to draw can keep its thread for the rest of the process.
///
/// # Errors
/// [`ServeError`]: no executor, a wrong scenario to start with, or the system refused something. Nothing a client does.
pub async fn run(
    listener: TcpListener,
    settings: Settings,
    executor_factory: ExecutorFactory,
    shutdown: impl Future<Output = ()>,
) -> Result<(), ServeError> {
    run_measured(listener, settings, executor_factory, shutdown, Arc::default()).await
}

/// As [`run`], adding the durations of each stage to `stages`.
async fn run_measured(
    listener: TcpListener,
    settings: Settings,
    executor_factory: ExecutorFactory,
    shutdown: impl Future<Output = ()>,
    stages: Arc<Stages>,
) -> Result<(), ServeError> {
    let address = listener.local_addr()?;
    let (stop, kill, tasks) = (CancellationToken::new(), CancellationToken::new(), TaskTracker::new());
    // Whatever way this function is left, nothing stays behind.
    let _guards = (stop.clone().drop_guard(), kill.clone().drop_guard());
    let metrics = Arc::new(Metrics::new(stages));
    let strikes = Arc::new(Strikes::default());
    let inbox = Arc::new(Inbox::new(Arc::clone(&strikes), u64::from(settings.step_memory_mib) << 20));
    let _stops_drawing = StopOnDrop(Arc::clone(&inbox));
    let hub = Arc::new(Hub::new(Arc::clone(&inbox), Arc::clone(&metrics), settings.queue_frames as usize));

    let cigi_port = match settings.cigi.clone() {
        Some(settings) => Some((cigi::bind(&settings).await?, settings, hub.listen(cigi::EVENTS_WAITING))),
        None => None,
    };
    // Read before anybody is let in: a file of heights may be large.
    let grounds = settings.clone();
    let terrain = tokio::task::spawn_blocking(move || grounds.ground()).await.map_err(std::io::Error::other)??;
    let cigi_address = cigi_port.as_ref().and_then(|(socket, ..)| socket.local_addr().ok());
    let mut world = WorldTask::new(
        new_world(&settings, terrain.clone()),
        Arc::clone(&inbox),
        Arc::clone(&hub),
        Arc::clone(&metrics),
        Arc::clone(&strikes),
        settings.frame_rate_hz,
        settings.shutter_s,
    );
    if let Some(name) = &settings.scenario {
        let timeline = settings.timeline(name).map_err(ServeError::Scenario)?;
        let load = Command::Scenario(ScenarioEdit::Load(Arc::new(timeline)));
        world.begin_with(load).map_err(ServeError::Scenario)?;
    }

    let (frames, finished) = mpsc::channel(FRAMES_WAITING);
    let drawing = start_drawing(executor_factory, &inbox, &metrics, &strikes, frames).await?;

    let (requests, asked) = mpsc::channel(settings.queue_commands as usize);
    tasks.spawn(world.run(asked, stop.clone()));
    let fan_out = FanOut::new(Arc::clone(&hub), Arc::clone(&metrics), strikes);
    tasks.spawn(fan_out.run(finished, stop.clone()));
    let app = Arc::new(App {
        access: Access::new(settings.token.clone(), settings.allowed_origins.clone(), address.ip()),
        write_timeout: Duration::from_secs_f64(settings.slow_client_s),
        settings,
        hub,
        metrics,
        roles: Roles::default(),
        questions: Arc::new(Semaphore::new(limits::QUESTIONS_AT_ONCE)),
        air: Default::default(),
        terrain,
        requests,
        tasks: tasks.clone(),
        stop: stop.clone(),
        kill: kill.clone(),
    });
    if let Some((socket, settings, events)) = cigi_port {
        tasks.spawn(cigi::run(socket, settings, Arc::clone(&app), events, stop.clone()));
    }
    tasks.spawn(statistics::telemetry(Arc::clone(&app)));

    let connections = app.settings.max_clients as usize + SPARE_CONNECTIONS;
    let doorman = Doorman::new(listener, connections, IDLE, kill.clone());
    let service = app::router(app).into_make_service_with_connect_info::<socket::Peer>();
    let serving = axum::serve(doorman, service).with_graceful_shutdown(stop.clone().cancelled_owned());
    let mut serving = tokio::spawn(serving.into_future());
    if let Some(address) = cigi_address {
        tracing::info!(%address, "listening for CIGI hosts");
    }
    tracing::info!(
        page = %format_args!("http://{address}/"),
        websocket = %format_args!("ws://{address}/ws"),
        "listening"
    );

    tokio::select! {
        () = shutdown => {}
        ended = &mut serving => tracing::error!(?ended, "the listener ended"),
    }
    stop.cancel();
    inbox.stop();
    tasks.close();
    // First the goodbyes, then whatever is left is cut off.
    let _late = tokio::time::timeout(GOODBYE, tasks.wait()).await;
    kill.cancel();
    let _late = tokio::time::timeout(ENDING, tasks.wait()).await;
    if !serving.is_finished() && tokio::time::timeout(ENDING, &mut serving).await.is_err() {
        serving.abort();
    }
    join(drawing).await;
    tracing::info!("stopped");
    Ok(())
}

fn new_world(settings: &Settings, terrain: Terrain) -> World {
    let mut world = World::new();
    world.set_quality(settings.quality());
    world.set_flicker_guard(settings.flicker_guard_per_s.map(FlickerGuard::new));
    world.set_terrain(terrain);
    world
}

/// Starts the render thread; it makes its executor itself, because executors may be bound to their thread.
async fn start_drawing(
    factory: ExecutorFactory,
    inbox: &Arc<Inbox>,
    metrics: &Arc<Metrics>,
    strikes: &Arc<Strikes>,
    frames: mpsc::Sender<Rendered>,
) -> Result<JoinHandle<()>, ServeError> {
    let (inbox, metrics, strikes) = (Arc::clone(inbox), Arc::clone(metrics), Arc::clone(strikes));
    let (tell, told) = oneshot::channel();
    let thread = std::thread::Builder::new().name("render".to_owned()).spawn(move || {
        match RenderThread::new(factory, inbox, metrics, strikes, frames) {
            Ok(thread) => {
                // Nobody listens any more when the server was dropped meanwhile; the inbox then says stop.
                let _gone = tell.send(Ok(()));
                thread.run();
            }
            Err(fault) => {
                let _gone = tell.send(Err(fault));
            }
        }
    })?;
    told.await.map_err(|_| ServeError::Died)??;
    Ok(thread)
}

/// Waits for the render thread, as long as the two seconds of an orderly end allow.
async fn join(thread: JoinHandle<()>) {
    // By the clock, not by the number of looks: on a busy machine a sleep lasts longer than was asked for.
    let end = Instant::now() + DRAWING_ENDS;
    while !thread.is_finished() && Instant::now() < end {
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    if thread.is_finished() {
        if thread.join().is_err() {
            tracing::error!("fault: the render thread panicked");
        }
        return;
    }
    tracing::warn!("the picture being drawn takes longer than the stop may: its thread is left to the system");
}

struct StopOnDrop(Arc<Inbox>);

impl Drop for StopOnDrop {
    fn drop(&mut self) {
        self.0.stop();
    }
}

/// Runs a future to its end on a runtime of its own: the door for verbs that know no tokio.
///
/// # Errors
/// The runtime's threads could not be started.
pub fn block_on<F: Future>(future: F) -> std::io::Result<F::Output> {
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build()?;
    let output = runtime.block_on(future);
    // A drawing thread or an encoding that is still busy must not hold the process.
    runtime.shutdown_timeout(Duration::from_millis(200));
    Ok(output)
}

/// Binds the address of the settings and serves until Ctrl-C or SIGTERM.
///
/// # Errors
/// As [`run`], and the port may be taken.
pub fn run_until_signal(settings: Settings, executor_factory: ExecutorFactory) -> Result<(), ServeError> {
    block_on(async {
        let listener = TcpListener::bind(settings.listen).await.map_err(|error| {
            let text = format!("{} cannot be listened on: {error}", settings.listen);
            std::io::Error::new(error.kind(), text)
        })?;
        run(listener, settings, executor_factory, shutdown_signal()).await
    })?
}
