//! The host's side of a connection: what is sent when, and what arrives handed to the watch.

use super::part::{Part, Tick};
use super::watch::{Arrived, Watch};
use super::{Options, PATIENCE};
use crate::cli::Failure;
use crate::cli::progress::Progress;
use crate::serve::client::{Client, Incoming};
use crate::wire::control::out::{Outbound, StateMessage, Welcome};
use crate::wire::control::{self, Hello, Inbound, Message, Query, Role, Subscription, WhenSlow};
use crate::wire::{frames, limits};
use crate::world::command::{Command, ScenarioEdit, StrikeRequest, ViewAction};
use crate::world::timeline::Timeline;
use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A connection that has been welcomed.
struct Session {
    client: Client,
    watch: Watch,
    began: Instant,
    seq: u64,
    /// Names of the views that the server has.
    views: BTreeSet<String>,
    /// The server's simulation time at the scenario's start.
    offset_s: f64,
}

/// Plays the part; the watch has seen everything.
pub(super) async fn play(options: &Options, mut part: Part) -> Result<Watch, Failure> {
    let client = Client::connect(&options.to, options.token.as_deref()).await?;
    let mut session = Session {
        client,
        watch: Watch::new(options.lockstep),
        began: Instant::now(),
        seq: 0,
        views: BTreeSet::new(),
        offset_s: 0.0,
    };
    let welcome = session.greet(options).await?;
    println!("connected to stormdeck {}, drawn by {}", welcome.server, welcome.executor);
    let views = session.prepare(options, &mut part).await?;
    let progress = Progress::new("host", part.ticks() as usize);
    let start = Instant::now();
    let mut done = 0;
    while let Some(tick) = part.next() {
        let time_s = tick.time_s;
        session.tick(tick, options).await?;
        if options.lockstep {
            session.step(time_s + part.interval_s()).await?;
        } else {
            session.listen_until(start + Duration::from_secs_f64(time_s + part.interval_s())).await?;
        }
        done += 1;
        progress.show(done);
    }
    session.settle(&views).await?;
    session.watch.end(&views);
    let Session { client, watch, .. } = session;
    client.close().await;
    Ok(watch)
}

impl Session {
    async fn greet(&mut self, options: &Options) -> Result<Welcome, Failure> {
        let name = Some("stormdeck host".to_owned());
        let hello = Hello { role: Role::Host, name, take_over: false, token: options.token.clone() };
        self.send(Message::Hello(hello)).await?;
        match self.await_control(|message| matches!(message, Outbound::Welcome(_) | Outbound::Refused(_))).await? {
            Outbound::Welcome(welcome) => Ok(welcome),
            Outbound::Refused(r) => Err(Failure::Run(format!("the server refused: {} ({})", r.why, r.limit))),
            _ => Err(Failure::Run("the server did not greet".to_owned())),
        }
    }

    /// Empties the server's world, makes the scenario's starting state, and subscribes to every view.
    async fn prepare(&mut self, options: &Options, part: &mut Part) -> Result<Vec<String>, Failure> {
        let duration_s = limits::SCENARIO_DURATION_S.max;
        let empty = Timeline { name: "empty".to_owned(), duration_s, ..Timeline::default() };
        self.command(Command::Scenario(ScenarioEdit::Load(Arc::new(empty)))).await?;
        // An earlier host may have left the time standing.
        let clock = if options.lockstep { ScenarioEdit::Pause } else { ScenarioEdit::Play };
        self.command(Command::Scenario(clock)).await?;
        self.views = self.state().await?.views.into_iter().map(|view| view.name).collect();
        for command in part.start() {
            self.command(command).await?;
        }
        let state = self.state().await?;
        self.offset_s = state.simulation_time_s;
        for view in &state.views {
            self.watch.expect_size(&view.name, view.size_px);
            self.subscribe(&view.name, options).await?;
        }
        Ok(state.views.into_iter().map(|view| view.name).collect())
    }

    async fn subscribe(&mut self, view: &str, options: &Options) -> Result<(), Failure> {
        let (max_rate_hz, when_slow) = (limits::FRAME_RATE_HZ.max, WhenSlow::DropOldest);
        let format = options.format;
        let wish = Subscription { view: view.to_owned(), format, max_rate_hz, quality: None, when_slow };
        self.send_watched(Message::Subscribe(wish), "subscribe").await?;
        Ok(())
    }

    /// Sends what is due, then the ownship.
    async fn tick(&mut self, tick: Tick, options: &Options) -> Result<(), Failure> {
        for command in tick.due {
            let made = match &command {
                Command::View(edit) if !self.views.contains(&edit.name) => Some(edit.name.clone()),
                _ => None,
            };
            self.command(command).await?;
            if let Some(view) = made {
                self.subscribe(&view, options).await?;
            }
        }
        self.watch.sent_ownship(tick.ownship.host_frame, self.began.elapsed());
        self.command(Command::Ownship(tick.ownship)).await
    }

    /// Sends a command of the scenario, fitted to this server: its clock, and the views that it has.
    async fn command(&mut self, command: Command) -> Result<(), Failure> {
        let (what, command) = match command {
            Command::Ownship(_) => ("ownship", command),
            Command::Weather(_) => ("weather", command),
            Command::RemoveRegion { .. } => ("region", command),
            Command::Time(_) => ("time", command),
            Command::Entity { .. } => ("entity", command),
            Command::Sky(_) => ("sky", command),
            Command::Scenario(_) => ("scenario", command),
            Command::View(mut edit) => {
                edit.action =
                    if self.views.insert(edit.name.clone()) { ViewAction::Create } else { ViewAction::Change };
                if edit.action == ViewAction::Create {
                    self.watch.made(&edit.name);
                }
                if let Some(size_px) = edit.size_px {
                    self.watch.expect_size(&edit.name, size_px);
                }
                ("view", Command::View(edit))
            }
            Command::Storm(_) => ("storm", command),
            Command::RemoveStorm { .. } => ("remove_storm", command),
            Command::RemoveView { ref name } => {
                self.views.remove(name);
                ("view", command)
            }
            Command::Strike(request) => {
                let at_s = request.at_s.map(|at_s| at_s + self.offset_s);
                ("strike", Command::Strike(StrikeRequest { at_s, ..request }))
            }
        };
        self.send_watched(Message::Command(command), what).await?;
        Ok(())
    }

    async fn step(&mut self, to_s: f64) -> Result<(), Failure> {
        let seq = self.send_watched(Message::Step { to_s: self.offset_s + to_s }, "step").await?;
        let is_answer = |message: &Outbound| match message {
            Outbound::Stepped(stepped) => stepped.seq == Some(seq),
            Outbound::Refused(refused) => refused.seq == Some(seq),
            _ => false,
        };
        self.await_control(is_answer).await.map(drop)
    }

    async fn state(&mut self) -> Result<StateMessage, Failure> {
        self.send(Message::Query(Query::State)).await?;
        match self.await_control(|message| matches!(message, Outbound::State(_))).await? {
            Outbound::State(state) => Ok(*state),
            _ => Err(Failure::Run("the server did not tell its state".to_owned())),
        }
    }

    /// Waits until every message is answered and every view has a frame, as long as something still comes.
    async fn settle(&mut self, views: &[String]) -> Result<(), Failure> {
        let end = Instant::now() + PATIENCE;
        while !(self.watch.all_answered() && self.watch.fewest_frames(views) > 0) && Instant::now() < end {
            self.listen_until(Instant::now() + Duration::from_millis(50)).await?;
        }
        Ok(())
    }

    async fn send_watched(&mut self, message: Message, what: &'static str) -> Result<u64, Failure> {
        self.watch.sent(self.seq + 1, what);
        self.send(message).await
    }

    async fn send(&mut self, message: Message) -> Result<u64, Failure> {
        self.seq += 1;
        self.client.send(control::encode_inbound(&Inbound { seq: Some(self.seq), message })).await?;
        Ok(self.seq)
    }

    /// Hands what arrives to the watch until a moment.
    async fn listen_until(&mut self, moment: Instant) -> Result<(), Failure> {
        loop {
            let left = moment.saturating_duration_since(Instant::now());
            match self.client.next_within(left).await? {
                Some(incoming) => drop(self.take(incoming)?),
                None => return Ok(()),
            }
        }
    }

    /// Hands what arrives to the watch until a control message is the one waited for.
    async fn await_control(&mut self, is_it: impl Fn(&Outbound) -> bool) -> Result<Outbound, Failure> {
        let end = Instant::now() + PATIENCE;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let Some(incoming) = self.client.next_within(left).await? else {
                return Err(Failure::Run(format!("the server gave no answer for {} s", PATIENCE.as_secs())));
            };
            if let Some(message) = self.take(incoming)?.filter(|message| is_it(message)) {
                return Ok(message);
            }
        }
    }

    /// One thing that arrived; a control message is handed back.
    fn take(&mut self, incoming: Incoming) -> Result<Option<Outbound>, Failure> {
        match incoming {
            Incoming::Text(text) => match control::decode_outbound(&text) {
                Ok(message) => {
                    self.watch.control(&message);
                    Ok(Some(message))
                }
                Err(refused) => {
                    self.watch.complain(format!("a message that cannot be read: {refused}"));
                    Ok(None)
                }
            },
            Incoming::Frame(bytes) => {
                self.frame(&bytes);
                Ok(None)
            }
            Incoming::Closed(reason) => {
                let why = reason.filter(|r| !r.is_empty()).unwrap_or_else(|| "no reason given".to_owned());
                Err(Failure::Run(format!("the server closed the connection: {why}")))
            }
        }
    }

    fn frame(&mut self, bytes: &[u8]) {
        let now = self.began.elapsed();
        match frames::decode_message(bytes) {
            Ok((header, picture)) => {
                let received_us = header.stamps.received_us;
                let server_delay =
                    (received_us > 0).then(|| Duration::from_micros(header.sent_us.saturating_sub(received_us)));
                let arrived = Arrived {
                    view: &header.view,
                    number: header.frame,
                    host_frame: header.host_frame,
                    simulation_time_s: header.simulation_time_s,
                    size_px: [header.width_px, header.height_px],
                    format: header.format,
                    dropped: header.dropped,
                    picture,
                    server_delay,
                };
                self.watch.frame(&arrived, now);
            }
            Err(error) => self.watch.complain(format!("a frame that cannot be read: {error}")),
        }
    }
}
