//! What a host's packets do to the world, and what is asked of it for the host: commands, strikes, steps, answers.

use super::super::super::step::Outcome;
use super::super::super::world_task::Request;
use super::super::answers::Known;
use super::{CLIENT, Session};
use crate::wire::cigi::scene::Consequence;
use crate::world::command::{Command, Polarity, StrikeRequest};
use crate::world::event::{Applied, Refused};
use std::sync::atomic::Ordering::Relaxed;
use tokio::sync::oneshot;

/// Strikes whose host numbers are remembered until they are seen.
const STRIKES_REMEMBERED: usize = 1_024;

/// What the event of a strike says to the host.
struct Asked {
    strike_id: u16,
    current_ka: f32,
}

impl Asked {
    fn of(strike_id: u16, request: &StrikeRequest) -> Self {
        let sign = if request.polarity == Polarity::Positive { 1.0 } else { -1.0 };
        Self { strike_id, current_ka: request.peak_current_ka.map_or(0.0, |peak| sign * peak) as f32 }
    }
}

impl Session {
    /// Does what a message asks for: all of its commands at once, so that no frame shows only some of them.
    pub(super) async fn follow(&mut self, consequences: Vec<Consequence>, received_us: u64) {
        let mut commands = Vec::new();
        for consequence in consequences {
            match consequence {
                Consequence::Command(command) => commands.push((None, command)),
                Consequence::Strike { strike_id, request } => {
                    commands.push((Some(Asked::of(strike_id, &request)), Command::Strike(request)));
                }
                Consequence::Question(question) => {
                    if !self.questions.ask(question) {
                        let limit = "questions that are answered";
                        self.refused(&Refused::new("request", "", limit, "too many questions at once"));
                    }
                }
                Consequence::Refused(refused) => self.refused(&refused),
            }
        }
        self.apply(commands, received_us).await;
    }

    /// Applies commands together; of a strike the host's number and current are remembered until it is seen.
    async fn apply(&mut self, commands: Vec<(Option<Asked>, Command)>, received_us: u64) {
        if commands.is_empty() {
            return;
        }
        let (asked, commands): (Vec<_>, Vec<_>) = commands.into_iter().unzip();
        let applied = self.app.ask_world(|reply| Request::ApplyAll { commands, received_us, reply }).await;
        // A server that stops applies nothing, and there is nobody to tell.
        for (asked, applied) in asked.into_iter().zip(applied.unwrap_or_default()) {
            match (applied, asked) {
                (Ok(Applied::Flash { id }), Some(asked)) => {
                    if self.strikes.len() >= STRIKES_REMEMBERED {
                        self.strikes.pop_first();
                    }
                    self.strikes.insert(id, (asked.strike_id, asked.current_ka));
                }
                (Ok(_), _) => {}
                (Err(refused), _) => self.refused(&refused),
            }
        }
    }

    /// Begins to work out the answers that are due, unless the last are not ready yet.
    pub(super) async fn ask(&mut self) {
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
    pub(super) async fn step(&mut self) {
        let to_s = self.app.metrics.simulation_time_s() + 1.0 / self.settings.rate_hz;
        let (tell, drawn) = oneshot::channel();
        let answer = Box::new(move |_: Outcome| {
            let _gone = tell.send(());
        });
        let client = CLIENT;
        let asked = self.app.ask_world(|reply| Request::Step { client, to_s, answer, reply }).await;
        if let Ok(Err(refused)) | Err(refused) = asked {
            self.refused(&refused);
        }
        self.drawing = Some(drawn);
    }

    /// Waits for answers that are being worked out; never ends while there are none.
    pub(in super::super) async fn work(&mut self) {
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
}
