//! The one task that owns the world: commands in order, time by the wall clock or by the host's steps, snapshots out.

use super::fan_out::missed;
use super::grower::Grower;
use super::hub::Hub;
use super::inbox::{Inbox, Posted};
use super::metrics::Metrics;
use super::roles::ClientId;
use super::stages::Stage;
use super::step::{Outcome, StepGuard};
use super::strikes::Strikes;
use super::thunder::Listener;
use crate::wire::control::out::Player;
use crate::wire::limits;
use crate::world::World;
use crate::world::command::{Command, ScenarioEdit};
use crate::world::event::{Applied, Refused};
use crate::world::snapshot::Snapshot;
use crate::world::storms::is_of_storm;
use std::collections::{BTreeSet, VecDeque};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::time::{Duration, Instant};
use tokio::sync::{mpsc, oneshot};
use tokio::time::MissedTickBehavior;
use tokio_util::sync::CancellationToken;

/// How a step's answer finds its host; must not block.
pub(super) type StepAnswer = Box<dyn FnOnce(Outcome) + Send>;

/// Looks at the world as it is and begins a subscription, or says why not; must not block.
pub(super) type Begin = Box<dyn FnOnce(&Snapshot) -> Result<(), Refused> + Send>;

/// What the world task is asked.
pub(super) enum Request {
    /// A command of the host, read from its socket at `received_us`.
    Apply { command: Command, received_us: u64, reply: oneshot::Sender<Result<Applied, Refused>> },
    /// All commands of one message: no frame shows only some of them.
    ApplyAll { commands: Vec<Command>, received_us: u64, reply: oneshot::Sender<Vec<Result<Applied, Refused>>> },
    /// Lockstep, driven by this client: `answer` is called when the step is done, `reply` at once says whether it was
    /// accepted.
    Step { client: ClientId, to_s: f64, answer: StepAnswer, reply: oneshot::Sender<Result<(), Refused>> },
    /// This client is host no more: if lockstep was its doing, the world runs free again.
    HostGone { client: ClientId, reply: oneshot::Sender<()> },
    /// Begins a subscription if the views of this moment allow it; before any later command can remove the view.
    Subscribe { begin: Begin, reply: oneshot::Sender<Result<(), Refused>> },
    /// The world now.
    State { reply: oneshot::Sender<State> },
}

/// The world at one moment, with its player.
pub(super) struct State {
    pub(super) snapshot: Arc<Snapshot>,
    pub(super) player: Player,
    /// Frames are drawn at steps only.
    pub(super) lockstep: bool,
}

/// Between two looks at the world while nobody wants a picture.
const HEARTBEAT: Duration = Duration::from_millis(100);
/// Free-running intervals that are remembered.
const INTERVALS: usize = 8;

pub(super) struct WorldTask {
    world: World,
    inbox: Arc<Inbox>,
    hub: Arc<Hub>,
    metrics: Arc<Metrics>,
    strikes: Arc<Strikes>,
    listener: Listener,
    grower: Grower,
    rate_hz: f64,
    shutter_s: Option<f64>,
    /// Who drives it, in lockstep.
    lockstep: Option<ClientId>,
    /// Names of the views that there were when anybody looked last.
    views: BTreeSet<String>,
    received_us: u64,
    /// When the world took the newest message, until a snapshot shows it.
    applied_us: Option<u64>,
    /// Up to when the wall clock has been followed.
    followed: Instant,
    /// When the newest free-running snapshot was taken.
    drawn: Instant,
    /// Between the newest free-running snapshots, in seconds of wall clock.
    intervals_s: VecDeque<f64>,
}

impl WorldTask {
    /// `rate_hz`: most snapshots a second while running free. `shutter_s`: how long each gathers light; `None`: as long as
    /// frames are apart.
    pub(super) fn new(
        world: World,
        inbox: Arc<Inbox>,
        hub: Arc<Hub>,
        metrics: Arc<Metrics>,
        strikes: Arc<Strikes>,
        rate_hz: f64,
        shutter_s: Option<f64>,
    ) -> Self {
        let listener = Listener::new(Arc::clone(&hub));
        let (followed, drawn) = (Instant::now(), Instant::now());
        let (lockstep, views, intervals_s) = (None, BTreeSet::new(), VecDeque::new());
        Self {
            world,
            inbox,
            hub,
            metrics,
            strikes,
            listener,
            grower: Grower::default(),
            rate_hz,
            shutter_s,
            lockstep,
            views,
            received_us: 0,
            applied_us: None,
            followed,
            drawn,
            intervals_s,
        }
    }

    /// Applies a command before anybody is connected (the scenario that the server starts with).
    ///
    /// # Errors
    /// The world's refusal.
    pub(super) fn begin_with(&mut self, command: Command) -> Result<(), Refused> {
        self.apply(command).map(|_| ())
    }

    pub(super) async fn run(mut self, mut requests: mpsc::Receiver<Request>, stop: CancellationToken) {
        let mut heartbeat = tokio::time::interval(HEARTBEAT);
        heartbeat.set_missed_tick_behavior(MissedTickBehavior::Delay);
        self.followed = Instant::now();
        // Where the beat of free-running snapshots stands.
        let mut beat = tokio::time::Instant::now();
        let (inbox, most_hz) = (Arc::clone(&self.inbox), self.rate_hz);
        loop {
            let hungry = async {
                loop {
                    let due = beat + period(&inbox, most_hz);
                    tokio::select! {
                        () = tokio::time::sleep_until(due) => break,
                        () = inbox.wishes_changed() => {}
                    }
                }
                inbox.hungry().await;
            };
            tokio::select! {
                () = stop.cancelled() => break,
                request = requests.recv() => match request {
                    None => break,
                    Some(request) => self.handle(request),
                },
                () = hungry, if self.lockstep.is_none() => {
                    // On the beat while it is kept; a new beat from now on when the drawing could not keep it.
                    let (now, period) = (tokio::time::Instant::now(), period(&inbox, most_hz));
                    beat = if now > beat + 2 * period { now } else { beat + period };
                    self.draw_free();
                }
                _ = heartbeat.tick() => self.follow(),
            }
        }
        self.inbox.stop();
    }

    fn handle(&mut self, request: Request) {
        self.follow();
        // Whoever asked may be gone by now; what was asked counts all the same.
        match request {
            Request::Apply { command, received_us, reply } => {
                let result = self.apply(command);
                self.grow();
                if result.is_ok() {
                    self.taken(received_us);
                }
                let _gone = reply.send(result);
            }
            Request::ApplyAll { commands, received_us, reply } => {
                let results: Vec<_> = commands.into_iter().map(|command| self.apply(command)).collect();
                self.grow();
                if results.iter().any(Result::is_ok) {
                    self.taken(received_us);
                }
                let _gone = reply.send(results);
            }
            Request::Step { client, to_s, answer, reply } => {
                let _gone = reply.send(self.step(client, to_s, answer));
            }
            Request::HostGone { client, reply } => {
                if self.lockstep == Some(client) {
                    self.run_free("its host is gone");
                }
                let _gone = reply.send(());
            }
            Request::Subscribe { begin, reply } => {
                let _gone = reply.send(begin(&self.world.peek(self.free_shutter_s())));
            }
            Request::State { reply } => {
                let snapshot = Arc::new(self.world.peek(self.free_shutter_s()));
                let _gone = reply.send(State { snapshot, player: self.player(), lockstep: self.lockstep.is_some() });
            }
        }
    }

    /// The world has taken something that was read at this time.
    fn taken(&mut self, received_us: u64) {
        self.received_us = received_us;
        self.applied_us = Some(self.metrics.now_us());
    }

    fn apply(&mut self, command: Command) -> Result<Applied, Refused> {
        let scenario = match &command {
            Command::Scenario(edit) => Some(edit.clone()),
            _ => None,
        };
        let applied = self.world.apply(command)?;
        match scenario {
            Some(ScenarioEdit::Load(timeline)) => {
                tracing::info!(scenario = timeline.name, duration_s = timeline.duration_s, "scenario loaded");
            }
            Some(ScenarioEdit::Play) if self.lockstep.is_some() => self.run_free("asked to play"),
            _ => {}
        }
        self.settle();
        Ok(applied)
    }

    /// Ends lockstep: from now on time goes on by itself, if it is not paused. Steps that wait are drawn first.
    fn run_free(&mut self, why: &str) {
        self.lockstep = None;
        self.intervals_s.clear();
        tracing::info!(why, "running free again");
    }

    /// Lets simulation time follow the wall clock while running free.
    fn follow(&mut self) {
        let passed_s = self.followed.elapsed().as_secs_f64();
        self.followed += Duration::from_secs_f64(passed_s);
        if self.lockstep.is_none() && self.world.playing() {
            self.world.advance_to(self.world.simulation_time_s() + passed_s * self.world.speed());
        }
        self.settle();
    }

    fn draw_free(&mut self) {
        self.follow();
        let interval_s = self.drawn.elapsed().as_secs_f64();
        self.drawn = Instant::now();
        if interval_s > limits::SHUTTER_S.max {
            // A pause in which nobody wanted a picture, not a rate.
            self.intervals_s.clear();
        } else {
            self.intervals_s.push_back(interval_s);
        }
        if self.intervals_s.len() > INTERVALS {
            self.intervals_s.pop_front();
        }
        let shutter_s = self.free_shutter_s();
        let snapshot = self.world.snapshot_at_once(shutter_s);
        self.grow();
        let posted = self.posted(snapshot);
        self.inbox.post(posted);
    }

    fn step(&mut self, client: ClientId, to_s: f64, answer: StepAnswer) -> Result<(), Refused> {
        let now_s = self.world.simulation_time_s();
        // The wire lets no NaN through; were there one, it would be no step.
        if to_s < now_s || to_s.is_nan() {
            return Err(Refused::new("to_s", to_s, format!("at least {now_s}"), "a step cannot go back in time"));
        }
        let end_s = self.world.timeline().map_or(0.0, |timeline| timeline.duration_s);
        if end_s > 0.0 && to_s > end_s {
            return Err(Refused::new("to_s", to_s, format!("at most {end_s}"), "the scenario ends there"));
        }
        if self.metrics.steps_waiting.load(Relaxed) >= limits::STEPS_WAITING as u64 {
            let limit = format!("{} steps", limits::STEPS_WAITING);
            return Err(Refused::new("to_s", to_s, limit, "too many steps are waiting: await `stepped`"));
        }
        if self.lockstep.replace(client).is_none() {
            tracing::info!(client, "lockstep: time moves by the host's steps");
        }
        self.metrics.steps_waiting.fetch_add(1, Relaxed);
        let metrics = Arc::clone(&self.metrics);
        let guard = Arc::new(StepGuard::new(move |outcome| {
            metrics.steps_waiting.fetch_sub(1, Relaxed);
            metrics.steps.fetch_add(1, Relaxed);
            answer(outcome);
        }));
        self.world.advance_to(to_s);
        self.settle();
        // The next step is taken to be as long as this one: with equal steps no light is lost and none counted twice.
        let shutter_s = if to_s > now_s { to_s - now_s } else { 1.0 / self.rate_hz };
        let shutter_s = self.shutter_s.unwrap_or(shutter_s).clamp(limits::SHUTTER_S.min, limits::SHUTTER_S.max);
        // Waits for the channels that its flashes show.
        let snapshot = self.world.snapshot(shutter_s);
        let posted = self.posted(snapshot);
        self.inbox.push_step(posted, guard);
        Ok(())
    }

    fn posted(&mut self, snapshot: Snapshot) -> Posted {
        let (snapshot, snapshot_us) = (Arc::new(snapshot), self.metrics.now_us());
        if let Some(applied_us) = self.applied_us.take() {
            self.metrics.stages.add_us(Stage::Wait, snapshot_us.saturating_sub(applied_us));
        }
        Posted { snapshot, received_us: self.received_us, snapshot_us }
    }

    /// Has the channels of new flashes grown beside the world and the renderer.
    fn grow(&self) {
        self.grower.grow(self.world.take_growing());
    }

    /// Until the next snapshot, most likely: the longest of the newest intervals, so that no light falls between frames.
    fn free_shutter_s(&self) -> f64 {
        if let Some(shutter_s) = self.shutter_s {
            return shutter_s;
        }
        let longest_s = self.intervals_s.iter().copied().fold(1.0 / self.rate_hz, f64::max);
        (longest_s * self.world.speed()).clamp(limits::SHUTTER_S.min, limits::SHUTTER_S.max)
    }

    /// Tells of flashes that ended unseen, and of scenario entries that could not be carried out; ends the subscriptions to
    /// views that are gone, whoever removed them.
    fn settle(&mut self) {
        let views = self.world.view_names();
        if !views.eq(self.views.iter().map(String::as_str)) {
            let present: BTreeSet<String> = self.world.view_names().map(str::to_owned).collect();
            self.views.difference(&present).for_each(|view| self.hub.end_view(view));
            self.views = present;
        }
        self.metrics.set_simulation_time(self.world.simulation_time_s());
        self.listener.hear(self.world.take_thunder());
        for id in self.world.finished_flashes() {
            // Nobody asked for a storm's flash: that nobody saw it is no news.
            if self.strikes.ended(id) && !is_of_storm(id) {
                missed(&self.hub, id);
            }
        }
        for (entry, refused) in self.world.take_refusals() {
            tracing::warn!(entry, %refused, "an entry of the scenario was refused");
        }
    }

    fn player(&self) -> Player {
        let timeline = self.world.timeline();
        Player {
            scenario: timeline.map(|timeline| timeline.name.clone()),
            description: timeline.map(|timeline| timeline.description.clone()).filter(|text| !text.is_empty()),
            playing: self.world.playing() && self.lockstep.is_none(),
            speed: self.world.speed(),
            duration_s: timeline.map(|timeline| timeline.duration_s),
        }
    }
}

/// Between two free-running snapshots: as often as anybody wants one, and the server may.
fn period(inbox: &Inbox, most_hz: f64) -> Duration {
    Duration::from_secs_f64(1.0 / inbox.fastest_hz().map_or(most_hz, |wanted_hz| wanted_hz.min(most_hz)))
}
