//! What one client says, message by message: who may, what it does, and the answer with the message's own number.

use super::app::App;
use super::client_task::refuse;
use super::hub::Client;
use super::roles::{Claim, ClientId};
use super::stages::Stage;
use super::statistics;
use super::step::{Outcome, StepFrame};
use super::world_task::{Request, State};
use crate::outputs;
use crate::outputs::air::Air;
use crate::wire::control::out::{
    Ack, ConditionsMessage, EventMessage, HeightsMessage, Outbound, PlanMessage, SightMessage, StateMessage, Stepped,
    SteppedFrame, Welcome,
};
use crate::wire::control::{self, Hello, Message, Query, Role, Subscription};
use crate::wire::limits;
use crate::world::command::Command;
use crate::world::event::{Applied, Refused};
use crate::world::snapshot::Snapshot;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use tokio::sync::oneshot;

/// Whether the conversation goes on.
pub(super) enum Verdict {
    Go,
    /// The connection is closed for this reason.
    End(&'static str),
}

/// The conversation with one client.
pub(super) struct Session {
    app: Arc<App>,
    client: Arc<Client>,
    trusted: bool,
    greeted: bool,
    name: String,
    messages: u64,
}

impl Session {
    pub(super) fn new(app: Arc<App>, client: Arc<Client>, trusted: bool) -> Self {
        let name = format!("client-{}", client.id);
        Self { app, client, trusted, greeted: false, name, messages: 0 }
    }

    pub(super) fn client(&self) -> Arc<Client> {
        Arc::clone(&self.client)
    }

    pub(super) fn trusted(&self) -> bool {
        self.trusted
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    pub(super) fn messages(&self) -> u64 {
        self.messages
    }

    /// Gives back the host role if this client has it, and tells everybody. True if it had.
    pub(super) async fn end(&self) -> bool {
        let was_host = self.app.roles.release(self.client.id);
        if was_host {
            self.host_gone(self.client.id).await;
            self.app.metrics.hosts.store(0, Relaxed);
            self.app.hub.broadcast(&Outbound::Event(EventMessage::HostFree));
        }
        was_host
    }

    /// Ends lockstep if it was this host's doing: nobody else is bound to step.
    async fn host_gone(&self, client: ClientId) {
        // A server that stops has no lockstep to end.
        let _stopping = self.ask(|reply| Request::HostGone { client, reply }).await;
    }

    /// Takes one message and answers it.
    pub(super) async fn handle(&mut self, text: &str) -> Verdict {
        let received_us = self.app.metrics.now_us();
        self.messages += 1;
        let inbound = match control::decode(text) {
            Ok(inbound) => inbound,
            Err((seq, refused)) => {
                self.refuse(seq, refused);
                // Strangers get one try.
                return if self.trusted { Verdict::Go } else { Verdict::End("no hello with the token") };
            }
        };
        let seq = inbound.seq;
        let result = match inbound.message {
            Message::Hello(hello) => self.hello(seq, hello).await,
            _ if !self.greeted => {
                Err(Refused::new("type", "", "hello first", "the first message of a connection is hello"))
            }
            Message::Command(command) => self.command(seq, command, received_us).await,
            Message::LoadScenario { name } => match self.app.load_scenario(&name).await {
                Ok(command) => self.command(seq, command, received_us).await,
                Err(refused) => Err(refused),
            },
            Message::Subscribe(wish) => self.subscribe(seq, wish).await,
            Message::Unsubscribe { view } => self.unsubscribe(seq, &view),
            Message::Step { to_s } => self.step(seq, to_s).await,
            Message::Query(query) => self.query(seq, query).await,
        };
        if let Err(refused) = result {
            self.refuse(seq, refused);
        }
        if self.trusted { Verdict::Go } else { Verdict::End("no hello with the token") }
    }

    async fn hello(&mut self, seq: Option<u64>, hello: Hello) -> Result<(), Refused> {
        if !self.trusted && !hello.token.as_deref().is_some_and(|token| self.app.access.token_fits(token)) {
            return Err(Refused::new("token", "", "the server's access token", "this server wants its token"));
        }
        self.trusted = true;
        let name = hello.name.unwrap_or_else(|| self.name.clone());
        match hello.role {
            Role::Host => self.become_host(&name, hello.take_over).await?,
            Role::Watcher => {
                self.end().await;
            }
        }
        self.name = name;
        self.greeted = true;
        tracing::info!(client = self.client.id, name = self.name, role = ?hello.role, "hello");
        let state = self.state().await?;
        let views = state.snapshot.views.iter().map(|view| view.name.clone()).collect();
        let executor = self.app.metrics.executor();
        let rate_hz = self.app.settings.frame_rate_hz;
        self.answer(&Outbound::Welcome(Welcome::new(seq, self.client.id, hello.role, &executor, rate_hz, views)));
        Ok(())
    }

    async fn become_host(&self, name: &str, take_over: bool) -> Result<(), Refused> {
        let (id, app) = (self.client.id, &self.app);
        let was_host = app.roles.is_host(id);
        match app.roles.claim(id, name, take_over && app.settings.allow_take_over) {
            Claim::Held(holder) => {
                let why = match (take_over, app.settings.allow_take_over) {
                    (true, false) => "this server's settings do not allow a take-over",
                    (_, true) => "somebody has it; `take_over` takes it",
                    (false, false) => "somebody has it; it is free when that client leaves",
                };
                return Err(Refused::new("role", "host", format!("one host at a time; {holder} is host"), why));
            }
            Claim::TakenFrom(previous) => {
                tracing::warn!(client = id, name, previous, "the host role was taken over");
                self.host_gone(previous).await;
            }
            Claim::Granted => {}
        }
        if !was_host {
            app.metrics.hosts.store(1, Relaxed);
            app.hub.broadcast(&Outbound::Event(EventMessage::HostTaken { client: id }));
        }
        Ok(())
    }

    fn must_be_host(&self) -> Result<(), Refused> {
        if self.app.roles.is_host(self.client.id) {
            return Ok(());
        }
        let holder = self.app.roles.host_name().map_or("nobody is host".to_owned(), |name| format!("{name} is host"));
        let why = "only the host changes the world: say hello with role host when it is free";
        Err(Refused::new("role", "watcher", format!("host; {holder}"), why))
    }

    async fn command(&self, seq: Option<u64>, command: Command, received_us: u64) -> Result<(), Refused> {
        self.must_be_host()?;
        let begin_us = self.app.metrics.now_us();
        let applied = self.ask(|reply| Request::Apply { command, received_us, reply }).await??;
        // The host's commands alone: what watchers ask for is on no way from a host to a picture.
        self.app.metrics.stages.add_us(Stage::Decode, begin_us.saturating_sub(received_us));
        self.app.metrics.stages.add_us(Stage::Apply, self.app.metrics.now_us().saturating_sub(begin_us));
        let flash = match applied {
            Applied::Flash { id } => Some(id),
            Applied::Done => None,
        };
        self.answer(&Outbound::Ack(Ack { seq, flash }));
        Ok(())
    }

    async fn subscribe(&self, seq: Option<u64>, wish: Subscription) -> Result<(), Refused> {
        outputs::view(&self.state().await?.snapshot, &wish.view)?;
        let subscriptions = self.client.subscriptions().len();
        if subscriptions >= limits::SUBSCRIPTIONS && !self.client.subscriptions().contains_key(&wish.view) {
            let limit = format!("{} subscriptions", limits::SUBSCRIPTIONS);
            return Err(Refused::new("view", wish.view, limit, "unsubscribe from another view first"));
        }
        let (app, client) = (Arc::clone(&self.app), Arc::clone(&self.client));
        // In the world task, which ends the subscriptions to a view that it removes: none can begin behind its back.
        let begin = Box::new(move |snapshot: &Snapshot| {
            outputs::view(snapshot, &wish.view)?;
            // The answer stands in the queue before the first frame can.
            client.queue.push_answer(control::encode(&Outbound::Ack(Ack { seq, flash: None })));
            app.hub.subscribe(&client, &wish, app.settings.jpeg_quality);
            Ok(())
        });
        self.ask(|reply| Request::Subscribe { begin, reply }).await?
    }

    fn unsubscribe(&self, seq: Option<u64>, view: &str) -> Result<(), Refused> {
        if !self.app.hub.unsubscribe(&self.client, view) {
            return Err(Refused::new("view", view, "a view subscribed to", "there is no subscription to this view"));
        }
        self.answer(&Outbound::Ack(Ack { seq, flash: None }));
        Ok(())
    }

    async fn step(&self, seq: Option<u64>, to_s: f64) -> Result<(), Refused> {
        self.must_be_host()?;
        let (app, client) = (Arc::clone(&self.app), Arc::clone(&self.client));
        let answer = Box::new(move |outcome| match outcome {
            Outcome::Drawn(frames) => {
                let frames = frames.into_iter().map(stepped_frame).collect();
                let stepped = Stepped { seq, simulation_time_s: to_s, frames };
                client.queue.push_answer(control::encode(&Outbound::Stepped(stepped)));
            }
            Outcome::Failed(why) => refuse(&app, &client, seq, Refused::new("to_s", to_s, "", why), 0),
        });
        let client = self.client.id;
        let accepted = self.ask(|reply| Request::Step { client, to_s, answer, reply }).await?;
        if !self.app.roles.is_host(client) {
            // Taken over while the step was on its way: it must not hold the next host's world in lockstep.
            self.host_gone(client).await;
        }
        accepted
    }

    async fn query(&self, seq: Option<u64>, query: Query) -> Result<(), Refused> {
        let message = match query {
            Query::State => {
                let state = self.state().await?;
                Outbound::State(Box::new(StateMessage::new(seq, &state.snapshot, state.player)))
            }
            Query::Plan { view } => {
                let named = view.clone();
                let plan = self.work_out(move |snapshot, _| outputs::plan_of(snapshot, &named)).await??;
                Outbound::Plan(PlanMessage::new(seq, &view, &plan))
            }
            Query::Statistics => Outbound::Statistics(statistics::statistics(&self.app, seq)),
            Query::Heights(at) => {
                let point = at.geodetic();
                let found =
                    self.work_out(move |snapshot, _| outputs::ground::hat_hot(&snapshot.terrain, &point)).await?;
                let found =
                    found.ok_or_else(|| Refused::new("latitude_deg", at.latitude_deg, "", "there is no ground"))?;
                Outbound::Heights(HeightsMessage::new(seq, &point, &found))
            }
            Query::LineOfSightSegment(line) => {
                let ray = line.ray()?;
                let seen = self.work_out(move |snapshot, _| outputs::sight::sight(snapshot, &ray)).await?;
                Outbound::LineOfSight(SightMessage::new(seq, &seen))
            }
            Query::LineOfSightVector(ray) => {
                let ray = ray.ray()?;
                let seen = self.work_out(move |snapshot, _| outputs::sight::sight(snapshot, &ray)).await?;
                Outbound::LineOfSight(SightMessage::new(seq, &seen))
            }
            Query::Conditions(at) => {
                let point = at.geodetic();
                let conditions =
                    move |snapshot: &Snapshot, air: &Air| outputs::conditions::conditions(snapshot, air, &point);
                let found = self.work_out(conditions).await?;
                Outbound::Conditions(ConditionsMessage::new(seq, &found))
            }
        };
        self.answer(&message);
        Ok(())
    }

    /// Works an answer out from the world as it is now: not on a thread that serves sockets, and few at a time, so that
    /// watchers who ask a lot take no more than a share of the processor.
    async fn work_out<T: Send + 'static>(
        &self,
        work: impl FnOnce(&Snapshot, &Air) -> T + Send + 'static,
    ) -> Result<T, Refused> {
        let failed = |why: String| Refused::new("query", "", "", format!("a fault of the server: {why}"));
        let turn = Arc::clone(&self.app.questions).acquire_owned().await.map_err(|error| failed(error.to_string()))?;
        let (snapshot, air) = (self.state().await?.snapshot, self.app.air());
        let done = tokio::task::spawn_blocking(move || {
            let _turn = turn;
            work(&snapshot, &air)
        });
        done.await.map_err(|error| {
            self.app.metrics.faults.fetch_add(1, Relaxed);
            tracing::error!(%error, "fault: an answer could not be worked out");
            failed(error.to_string())
        })
    }

    async fn state(&self) -> Result<State, Refused> {
        self.ask(|reply| Request::State { reply }).await
    }

    /// Asks the world task; waits for room in its queue and for its answer.
    async fn ask<T>(&self, request: impl FnOnce(oneshot::Sender<T>) -> Request) -> Result<T, Refused> {
        self.app.ask_world(request).await
    }

    fn answer(&self, message: &Outbound) {
        self.client.queue.push_answer(control::encode(message));
    }

    fn refuse(&self, seq: Option<u64>, refused: Refused) {
        refuse(&self.app, &self.client, seq, refused, 0);
    }
}

fn stepped_frame(frame: StepFrame) -> SteppedFrame {
    let StepFrame { view, number, formats, copies } = frame;
    SteppedFrame { view, frame: number, formats: formats.into_iter().collect(), copies }
}
