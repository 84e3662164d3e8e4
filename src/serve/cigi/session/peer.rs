//! Who the host is: whose datagrams count, where answers go, and how one host makes room for the next.

use super::super::super::roles::Claim;
use super::super::super::world_task::Request;
use super::{CLIENT, Session};
use crate::geo::terrain::Terrain;
use crate::outputs::air::Air;
use crate::settings::CigiSettings;
use crate::wire::cigi::message::Opening;
use crate::wire::cigi::scene::{Convention, MAIN, Scene};
use crate::wire::control::out::{EventMessage, Outbound};
use crate::world::Timeline;
use crate::world::command::{Command, ScenarioEdit, ViewAction, ViewEdit};
use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

/// A host that is listened to.
pub(super) struct Peer {
    pub(super) from: SocketAddr,
    pub(super) opening: Opening,
    pub(super) heard_us: u64,
}

impl Session {
    /// Whether a datagram from there counts.
    pub(super) fn may_speak(&self, from: SocketAddr) -> bool {
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
    pub(super) fn answer_to(&self) -> Option<SocketAddr> {
        let learned = self.peer.as_ref().map(|peer| match self.settings.reply_port {
            Some(port) => SocketAddr::new(peer.from.ip(), port),
            None => peer.from,
        });
        self.settings.host.or(learned)
    }

    /// Takes a new host in, unless somebody else steers the world.
    pub(super) async fn welcome(&mut self, from: SocketAddr, opening: Opening) -> bool {
        let name = format!("CIGI host {from}");
        if let Claim::Held(holder) = self.app.roles.claim(CLIENT, &name, false) {
            let now_us = self.app.metrics.now_us();
            self.log(now_us, || format!("{from} speaks CIGI, but {holder} is host"));
            return false;
        }
        let (version, order) = (opening.version.name(), opening.byte_order.name());
        tracing::info!(%from, version, order, "a CIGI host speaks");
        self.app.metrics.hosts.store(1, Relaxed);
        self.app.hub.broadcast(&Outbound::Event(EventMessage::HostTaken { client: CLIENT }));
        self.reset().await;
        true
    }

    /// Forgets the host.
    pub(super) async fn part(&mut self, why: &str) {
        let Some(peer) = self.peer.take() else { return };
        tracing::info!(from = %peer.from, why, "the CIGI host is gone");
        self.link.part();
        self.forget();
        let _stopping = self.app.ask_world(|reply| Request::HostGone { client: CLIENT, reply }).await;
        if self.app.roles.release(CLIENT) {
            self.app.metrics.hosts.store(0, Relaxed);
            self.app.hub.broadcast(&Outbound::Event(EventMessage::HostFree));
        }
    }

    /// Returns everything to its defaults.
    pub(super) async fn reset(&mut self) {
        self.forget();
        let empty = Timeline { name: "cigi".to_owned(), ..Timeline::default() };
        let (action, name, size_px) = (ViewAction::Change, MAIN.to_owned(), Some(self.settings.size_px));
        let size = ViewEdit { action, name, size_px, ..ViewEdit::default() };
        let commands = vec![Command::Scenario(ScenarioEdit::Load(Arc::new(empty))), Command::View(size)];
        let _done = self.app.ask_world(|reply| Request::ApplyAll { commands, received_us: 0, reply }).await;
    }

    fn forget(&mut self) {
        self.scene = Scene::new(convention(&self.settings, &self.app.terrain));
        self.questions.clear();
        self.outbox.clear();
        self.strikes.clear();
        self.app.set_air(Air::default());
        // A job cannot be cancelled: the next begins when it has ended, so that a host that comes and goes piles up none.
        self.stale = self.working.is_some();
        (self.drawing, self.answered) = (None, true);
    }
}

pub(super) fn convention(settings: &CigiSettings, terrain: &Terrain) -> Convention {
    let CigiSettings { sea_level_m, seed, size_px, .. } = *settings;
    Convention { sea_level_m, seed, size_px, terrain: terrain.clone() }
}

/// Whether two addresses are the same, however an IPv4 one is written.
fn same(a: IpAddr, b: IpAddr) -> bool {
    a.to_canonical() == b.to_canonical()
}
