//! The conversation with one CIGI host: what a datagram does, and what goes back with each frame.

mod peer;
mod world;

use super::super::app::App;
use super::super::stages::Stage;
use super::CLIENT;
use super::counters::Counters;
use super::link::{Link, Mode};
use super::outbox::Outbox;
use super::questions::Questions;
use crate::settings::CigiSettings;
use crate::wire::cigi::message::opening;
use crate::wire::cigi::packets::{EventNotification, IgControl, ImageGeneratorMessage, Packet};
use crate::wire::cigi::scene::{EVENT_STRIKE_MISSED, EVENT_STRIKE_SHOWN, Moment, Scene};
use crate::wire::cigi::{Direction, Version, decode, others};
use crate::world::event::{Event, Refused};
use crate::world::storms::is_of_storm;
use peer::{Peer, convention};
use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::sync::Arc;
use tokio::sync::oneshot;
use tokio::task::JoinHandle;

/// Microseconds between two lines of the log about what goes wrong.
const LOG_EVERY_US: u64 = 1_000_000;
/// Characters of a message to the host's operator: CIGI 3.3 has no room for more.
const MESSAGE_CHARS: usize = 99;
/// Message id of a refusal.
const MESSAGE_REFUSED: u16 = 1;

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
    /// Synchronous operation: the picture of the frame before, and whether the host has answered since.
    drawing: Option<oneshot::Receiver<()>>,
    answered: bool,
    logged_us: u64,
}

impl Session {
    pub(super) fn new(app: Arc<App>, settings: CigiSettings) -> Self {
        let counters = Arc::clone(&app.metrics.cigi);
        let link = Link::new(settings.host_chooses_database);
        let scene = Scene::new(convention(&settings, &app.terrain));
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
            drawing: None,
            answered: true,
            logged_us: 0,
        }
    }

    /// Takes a datagram. Returns how many packets were in it.
    pub(super) async fn datagram(&mut self, bytes: &[u8], from: SocketAddr) -> usize {
        let now_us = self.app.metrics.now_us();
        if !self.may_speak(from) {
            Counters::one(&self.counters.strangers);
            return 0;
        }
        let decoded = opening(bytes).and_then(|opening| decode(bytes).map(|message| (opening, message)));
        let (opening, message) = match decoded {
            Ok((opening, message)) if opening.direction == Direction::HostToIg => (opening, message),
            Ok(_) => {
                Counters::one(&self.counters.rejected);
                self.log(now_us, || format!("{from}: a Start of Frame, which is ours to send"));
                return 0;
            }
            Err(rejected) => {
                Counters::one(&self.counters.rejected);
                self.log(now_us, || format!("{from}: {rejected}"));
                return 0;
            }
        };
        let Some(Packet::IgControl(control)) = message.packets.first() else { return 0 };
        if self.peer.is_none() && !self.welcome(from, opening).await {
            Counters::one(&self.counters.strangers);
            return message.packets.len();
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
            let consequences = self.scene.take(&message, &self.moment(control));
            let decoded_us = self.app.metrics.now_us();
            self.app.metrics.stages.add_us(Stage::Decode, decoded_us.saturating_sub(now_us));
            self.follow(consequences, now_us).await;
            let applied_us = self.app.metrics.now_us();
            self.app.metrics.stages.add_us(Stage::Apply, applied_us.saturating_sub(decoded_us));
            self.app.set_air(self.scene.air());
        }
        message.packets.len() + message.skipped.len()
    }

    /// Takes an event of the world.
    pub(super) fn event(&mut self, event: &Event) {
        // A storm's flash has no number of the host's.
        let (asked, event_id, frame) = match event {
            Event::StrikeShown { id, frame, current_ka, .. } => {
                let asked = if is_of_storm(*id) { Some((0, *current_ka as f32)) } else { self.strikes.remove(id) };
                (asked, EVENT_STRIKE_SHOWN, *frame as u32)
            }
            Event::StrikeMissed { id } => (self.strikes.remove(id), EVENT_STRIKE_MISSED, u32::MAX),
            // CIGI has no packet for it.
            Event::Thunder { .. } | Event::State(_) => return,
        };
        let Some((strike_id, current_ka)) = asked else { return };
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

    fn moment(&self, control: &IgControl) -> Moment {
        Moment {
            host_frame: control.host_frame_number,
            timestamp: control.timestamp_valid.then_some(control.timestamp),
            extrapolate: control.extrapolation_interpolation_enable,
            now_s: self.app.metrics.simulation_time_s(),
        }
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
