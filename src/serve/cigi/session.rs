//! The conversation with one CIGI host: whose datagrams count, what they do, and what goes back with each frame.

use super::super::app::App;
use super::super::roles::Claim;
use super::super::step::Outcome;
use super::super::world_task::Request;
use super::answers::{Known, Questions};
use super::counters::Counters;
use super::link::{Link, Mode};
use super::outbox::Outbox;
use crate::settings::CigiSettings;
use crate::wire::cigi::message::{Opening, opening};
use crate::wire::cigi::packets::{EventNotification, IgControl, ImageGeneratorMessage, Packet};
use crate::wire::cigi::scene::{Consequence, Convention, EVENT_STRIKE_MISSED, EVENT_STRIKE_SHOWN, Moment, Scene};
use crate::wire::cigi::{Direction, Version, decode, others};
use crate::wire::control::out::{EventMessage, Outbound};
use crate::world::Timeline;
use crate::world::command::{Command, ScenarioEdit, StrikeRequest};
use crate::world::event::{Applied, Event, Refused};
use std::collections::BTreeMap;
use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use tokio::sync::oneshot;
use tokio::task::JoinHandle;

/// Storms are asked for their flashes so far ahead, so that each begins at its own time.
const STORM_AHEAD_S: f64 = 0.5;
/// Strikes whose host numbers are remembered until they are seen.
const STRIKES_REMEMBERED: usize = 1_024;
/// Microseconds between two lines of the log about what goes wrong.
const LOG_EVERY_US: u64 = 1_000_000;
/// Characters of a message to the host's operator: CIGI 3.3 has no room for more.
const MESSAGE_CHARS: usize = 99;
/// Message id of a refusal.
const MESSAGE_REFUSED: u16 = 1;

/// A host that is listened to.
struct Peer {
    from: SocketAddr,
    opening: Opening,
    heard_us: u64,
}

/// Everything that belongs to the CIGI port.
pub(super) struct Session {
    app: Arc<App>,
    settings: CigiSettings,
    counters: Arc<Counters>,
    peer: Option<Peer>,
    link: Link,
    scene: Scene,
    questions: Questions,
    outbox: Outbox,
    /// Answers that are being worked out, and the Start of Frame that they wait for.
    working: Option<JoinHandle<Vec<Packet>>>,
    /// What is being worked out was asked before everything was forgotten: no answer to anybody.
    stale: bool,
    /// The host's number and the current of each flash that nobody has seen yet.
    strikes: BTreeMap<u64, (u16, f32)>,
    storms_until_s: f64,
    /// Synchronous operation: the picture of the frame before, and whether the host has answered since.
    drawing: Option<oneshot::Receiver<()>>,
    answered: bool,
    logged_us: u64,
}

impl Session {
    pub(super) fn new(app: Arc<App>, settings: CigiSettings) -> Self {
        let counters = Arc::clone(&app.metrics.cigi);
        let link = Link::new(settings.host_chooses_database);
        let scene = Scene::new(convention(&settings));
        Self {
            app,
            settings,
            counters,
            peer: None,
            link,
            scene,
            questions: Questions::default(),
            outbox: Outbox::default(),
            working: None,
            stale: false,
            strikes: BTreeMap::new(),
            storms_until_s: 0.0,
            drawing: None,
            answered: true,
            logged_us: 0,
        }
    }

    /// Takes a datagram.
    pub(super) async fn datagram(&mut self, bytes: &[u8], from: SocketAddr) {
        let now_us = self.app.metrics.now_us();
        if !self.may_speak(from) {
            Counters::one(&self.counters.strangers);
            return;
        }
        let decoded = opening(bytes).and_then(|opening| decode(bytes).map(|message| (opening, message)));
        let (opening, message) = match decoded {
            Ok((opening, message)) if opening.direction == Direction::HostToIg => (opening, message),
            Ok(_) => {
                Counters::one(&self.counters.rejected);
                self.log(now_us, || format!("{from}: a Start of Frame, which is ours to send"));
                return;
            }
            Err(rejected) => {
                Counters::one(&self.counters.rejected);
                self.log(now_us, || format!("{from}: {rejected}"));
                return;
            }
        };
        let Some(Packet::IgControl(control)) = message.packets.first() else { return };
        if self.peer.is_none() && !self.welcome(from, opening).await {
            Counters::one(&self.counters.strangers);
            return;
        }
        self.peer = Some(Peer { from, opening, heard_us: now_us });
        Counters::one(&self.counters.messages);
        Counters::add(&self.counters.packets, message.packets.len() as u64);
        Counters::add(&self.counters.skipped, message.skipped.len() as u64);
        if let Some(skipped) = message.skipped.first() {
            let (id, name) = (skipped.packet_id, others::name_of(message.version, skipped.packet_id));
            self.log(now_us, || {
                format!("{from}: {} packets skipped, the first is {id}, {name}", message.skipped.len())
            });
        }
        let heard = self.link.hear(control);
        Counters::add(&self.counters.lost, heard.lost.into());
        Counters::add(&self.counters.late, u64::from(heard.late));
        self.answered |= heard.behind == 0;
        if heard.bad_mode {
            let limit = "0 Reset/Standby, 1 Operate, 2 Debug";
            self.refused(&Refused::new("IG Control.ig_mode", control.ig_mode, limit, "not for a host to ask for"));
        }
        if heard.reset {
            self.reset().await;
        }
        if heard.counts {
            let moment = self.moment(control);
            for consequence in self.scene.take(&message, &moment) {
                self.follow(consequence, now_us).await;
            }
        }
    }

    /// Takes an event of the world.
    pub(super) fn event(&mut self, event: &Event) {
        let (id, event_id, frame) = match event {
            Event::StrikeShown { id, frame, .. } => (id, EVENT_STRIKE_SHOWN, *frame as u32),
            Event::StrikeMissed { id } => (id, EVENT_STRIKE_MISSED, u32::MAX),
            Event::State(_) => return,
        };
        let Some((strike_id, current_ka)) = self.strikes.remove(id) else { return };
        if self.scene.wants(event_id) {
            self.push([EventNotification {
                event_id,
                event_data_1: strike_id.into(),
                event_data_2: current_ka.to_bits(),
                event_data_3: frame,
            }
            .into()]);
        }
    }

    /// Waits for answers that are being worked out; never ends while there are none.
    pub(super) async fn work(&mut self) {
        match &mut self.working {
            None => std::future::pending().await,
            Some(working) => {
                let answers = working.await;
                self.working = None;
                let stale = std::mem::take(&mut self.stale);
                match answers {
                    Ok(_) if stale => {}
                    Ok(answers) => self.push(answers),
                    Err(error) => {
                        self.app.metrics.faults.fetch_add(1, Relaxed);
                        tracing::error!(%error, "fault: answers to the CIGI host could not be worked out");
                    }
                }
            }
        }
    }

    /// Begins a frame: the datagram that goes out with it, and where to.
    pub(super) async fn frame(&mut self, overframing: bool) -> Option<(Vec<u8>, SocketAddr)> {
        let now_us = self.app.metrics.now_us();
        let silent = |peer: &Peer| now_us.saturating_sub(peer.heard_us) as f64 > self.settings.silence_s * 1e6;
        if self.peer.as_ref().is_some_and(silent) {
            Counters::one(&self.counters.silences);
            self.part("the CIGI host fell silent").await;
        }
        let to = self.answer_to()?;
        if self.settings.synchronous && self.peer.is_some() && self.link.mode() != Mode::Standby {
            if self
                .drawing
                .as_mut()
                .is_some_and(|drawing| matches!(drawing.try_recv(), Err(oneshot::error::TryRecvError::Empty)))
            {
                // Frames are as long as their pictures take.
                return None;
            }
            if !std::mem::take(&mut self.answered) {
                Counters::one(&self.counters.missed_frames);
            }
            self.step().await;
        }
        if self.link.mode() != Mode::Standby {
            self.storms(now_us).await;
            self.ask().await;
        }
        let opening = self.peer.as_ref().map(|peer| peer.opening);
        let version = opening.map_or(Version::V3, |opening| opening.version);
        let order = self.settings.byte_order;
        let more = self.outbox.overfull(version, order);
        let sof = self.link.start_of_frame(version, now_us, overframing, more);
        let (bytes, answers) = self.outbox.datagram(sof, version, order);
        Counters::add(&self.counters.answers, answers as u64);
        Some((bytes, to))
    }

    /// Gives back what a host has taken.
    pub(super) async fn end(&mut self) {
        self.part("the server stops").await;
    }

    /// Whether a datagram from there counts.
    fn may_speak(&self, from: SocketAddr) -> bool {
        let (host, allow) = (self.settings.host.map(|host| host.ip()), &self.settings.allow);
        let known = self.peer.as_ref().is_none_or(|peer| match host {
            // The address is fixed; the port that it sends from is its own business.
            Some(_) => true,
            None => peer.from == from,
        });
        known
            && host.is_none_or(|host| same(host, from.ip()))
            && (allow.is_empty() || allow.iter().any(|ip| same(*ip, from.ip())))
    }

    /// Where answers go.
    fn answer_to(&self) -> Option<SocketAddr> {
        let learned = self.peer.as_ref().map(|peer| match self.settings.reply_port {
            Some(port) => SocketAddr::new(peer.from.ip(), port),
            None => peer.from,
        });
        self.settings.host.or(learned)
    }

    /// Takes a new host in, unless somebody else steers the world.
    async fn welcome(&mut self, from: SocketAddr, opening: Opening) -> bool {
        let name = format!("CIGI host {from}");
        if let Claim::Held(holder) = self.app.roles.claim(super::CLIENT, &name, false) {
            let now_us = self.app.metrics.now_us();
            self.log(now_us, || format!("{from} speaks CIGI, but {holder} is host"));
            return false;
        }
        let (version, order) = (opening.version.name(), opening.byte_order.name());
        tracing::info!(%from, version, order, "a CIGI host speaks");
        self.app.metrics.hosts.store(1, Relaxed);
        self.app.hub.broadcast(&Outbound::Event(EventMessage::HostTaken { client: super::CLIENT }));
        self.reset().await;
        true
    }

    /// Forgets the host.
    async fn part(&mut self, why: &str) {
        let Some(peer) = self.peer.take() else { return };
        tracing::info!(from = %peer.from, why, "the CIGI host is gone");
        self.link.part();
        self.forget();
        let _stopping = self.app.ask_world(|reply| Request::HostGone { client: super::CLIENT, reply }).await;
        if self.app.roles.release(super::CLIENT) {
            self.app.metrics.hosts.store(0, Relaxed);
            self.app.hub.broadcast(&Outbound::Event(EventMessage::HostFree));
        }
    }

    /// Returns everything to its defaults.
    async fn reset(&mut self) {
        self.forget();
        let empty = Timeline { name: "cigi".to_owned(), ..Timeline::default() };
        let _done = self.apply(Command::Scenario(ScenarioEdit::Load(Arc::new(empty))), 0).await;
    }

    fn forget(&mut self) {
        self.scene = Scene::new(convention(&self.settings));
        self.questions.clear();
        self.outbox.clear();
        self.strikes.clear();
        // A job cannot be cancelled: the next begins when it has ended, so that a host that comes and goes piles up none.
        self.stale = self.working.is_some();
        (self.drawing, self.answered, self.storms_until_s) = (None, true, 0.0);
    }

    fn moment(&self, control: &IgControl) -> Moment {
        Moment {
            host_frame: control.host_frame_number,
            timestamp: control.timestamp_valid.then_some(control.timestamp),
            extrapolate: control.extrapolation_interpolation_enable,
            now_s: self.app.metrics.simulation_time_s(),
        }
    }

    async fn follow(&mut self, consequence: Consequence, received_us: u64) {
        match consequence {
            Consequence::Command(command) => {
                if let Err(refused) = self.apply(command, received_us).await {
                    self.refused(&refused);
                }
            }
            Consequence::Strike { strike_id, request } => self.strike(strike_id, request, received_us).await,
            Consequence::Question(question) => {
                if !self.questions.ask(question) {
                    let limit = "questions that are answered";
                    self.refused(&Refused::new("request", "", limit, "too many questions at once"));
                }
            }
            Consequence::Refused(refused) => self.refused(&refused),
        }
    }

    async fn apply(&self, command: Command, received_us: u64) -> Result<Applied, Refused> {
        self.app.ask_world(|reply| Request::Apply { command, received_us, reply }).await?
    }

    async fn strike(&mut self, strike_id: u16, request: StrikeRequest, received_us: u64) {
        let sign = if request.polarity == crate::world::command::Polarity::Positive { 1.0 } else { -1.0 };
        let current_ka = request.peak_current_ka.map_or(0.0, |peak| sign * peak) as f32;
        match self.apply(Command::Strike(request), received_us).await {
            Ok(Applied::Flash { id }) => {
                if self.strikes.len() >= STRIKES_REMEMBERED {
                    self.strikes.pop_first();
                }
                self.strikes.insert(id, (strike_id, current_ka));
            }
            Ok(Applied::Done) => {}
            Err(refused) => self.refused(&refused),
        }
    }

    /// The flashes of the storms for the time ahead.
    async fn storms(&mut self, now_us: u64) {
        let now_s = self.app.metrics.simulation_time_s();
        let (from_s, to_s) = (self.storms_until_s.max(now_s), now_s + STORM_AHEAD_S);
        if to_s <= from_s {
            return;
        }
        self.storms_until_s = to_s;
        for storm in self.scene.storms() {
            for flash in storm.flashes(from_s, to_s) {
                self.strike(0, flash, now_us).await;
            }
        }
    }

    /// Begins to work out the answers that are due, unless the last are not ready yet.
    async fn ask(&mut self) {
        if self.working.is_some() {
            return;
        }
        let due = self.questions.due(self.link.frame().wrapping_add(1), self.scene.entities());
        if due.is_empty() {
            return;
        }
        let Ok(state) = self.app.ask_world(|reply| Request::State { reply }).await else { return };
        let known = Known {
            snapshot: state.snapshot,
            entities: self.scene.entities().clone(),
            air: self.scene.air(),
            host_frame_number_lsn: (self.link.host_frame() & 0xf) as u8,
        };
        // A line of sight through a deck takes a while: not on a thread that serves sockets.
        self.working = Some(tokio::task::spawn_blocking(move || due.iter().flat_map(|q| known.answer(q)).collect()));
    }

    /// Synchronous operation: the picture of the frame that ends.
    async fn step(&mut self) {
        let to_s = self.app.metrics.simulation_time_s() + 1.0 / self.settings.rate_hz;
        let (tell, drawn) = oneshot::channel();
        let answer = Box::new(move |_: Outcome| {
            let _gone = tell.send(());
        });
        let client = super::CLIENT;
        let asked = self.app.ask_world(|reply| Request::Step { client, to_s, answer, reply }).await;
        if let Ok(Err(refused)) | Err(refused) = asked {
            self.refused(&refused);
        }
        self.drawing = Some(drawn);
    }

    /// Counts a refusal; in Debug the host's operator reads it.
    fn refused(&mut self, refused: &Refused) {
        Counters::one(&self.counters.refused);
        let text = refused.to_string();
        let now_us = self.app.metrics.now_us();
        self.log(now_us, || text.clone());
        if self.link.mode() == Mode::Debug {
            let latin = text.chars().filter(|c| u8::try_from(*c).is_ok() && *c != '\0');
            let message = latin.take(MESSAGE_CHARS).collect();
            self.push([ImageGeneratorMessage { message_id: MESSAGE_REFUSED, message }.into()]);
        }
    }

    fn push(&mut self, answers: impl IntoIterator<Item = Packet>) {
        let dropped = self.outbox.push(answers);
        Counters::add(&self.counters.answers_dropped, dropped as u64);
    }

    /// One line a second at most: a flood must not fill the log.
    fn log(&mut self, now_us: u64, what: impl FnOnce() -> String) {
        if now_us >= self.logged_us + LOG_EVERY_US {
            self.logged_us = now_us;
            tracing::warn!(what = what(), "CIGI");
        }
    }
}

fn convention(settings: &CigiSettings) -> Convention {
    Convention { sea_level_m: settings.sea_level_m, seed: settings.seed }
}

/// Whether two addresses are the same, however an IPv4 one is written.
fn same(a: IpAddr, b: IpAddr) -> bool {
    a.to_canonical() == b.to_canonical()
}
