//! The CIGI port: one host by UDP, its messages into commands, Start of Frame and answers back.
//!
//! One task owns all of it. Datagrams of strangers and of no CIGI are counted and forgotten at the cost of reading their first
//! bytes; nothing waits for a silent host.

mod answers;
pub mod counters;
#[cfg(test)]
mod effects;
mod link;
mod outbox;
mod questions;
mod session;

pub use answers::Known;

use super::app::App;
use crate::settings::CigiSettings;
use crate::wire::limits::CIGI_PACKETS_AT_ONCE;
use crate::world::event::Event;
use counters::Counters;
use session::Session;
use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;
use tokio::net::UdpSocket;
use tokio::sync::mpsc;
use tokio::time::{Instant, MissedTickBehavior};
use tokio_util::sync::CancellationToken;

/// The host role's holder while a CIGI host has it; WebSocket clients count from 1.
pub(super) const CLIENT: super::roles::ClientId = 0;
/// Events that wait for the task.
pub(super) const EVENTS_WAITING: usize = 256;
/// Longest datagram: UDP has no longer ones.
const DATAGRAM_BYTES: usize = 65_536;
/// Datagrams that are read before the clock is looked at again, so that a flood cannot stop the frames.
const AT_ONCE: usize = 64;

/// Binds the port, and joins the multicast group if there is one.
pub(super) async fn bind(settings: &CigiSettings) -> std::io::Result<UdpSocket> {
    let wrong = |error: std::io::Error| {
        std::io::Error::new(error.kind(), format!("the CIGI port {} cannot be had: {error}", settings.listen))
    };
    let socket = UdpSocket::bind(settings.listen).await.map_err(wrong)?;
    match settings.multicast {
        Some(IpAddr::V4(group)) => socket.join_multicast_v4(group, std::net::Ipv4Addr::UNSPECIFIED).map_err(wrong)?,
        Some(IpAddr::V6(group)) => socket.join_multicast_v6(&group, 0).map_err(wrong)?,
        None => {}
    }
    Ok(socket)
}

/// Serves the port until the server stops.
pub(super) async fn run(
    socket: UdpSocket,
    settings: CigiSettings,
    app: Arc<App>,
    mut events: mpsc::Receiver<Event>,
    stop: CancellationToken,
) {
    let counters = Arc::clone(&app.metrics.cigi);
    let period = Duration::from_secs_f64(1.0 / settings.rate_hz);
    let mut session = Session::new(Arc::clone(&app), settings);
    let mut frames = tokio::time::interval(period);
    frames.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut due = Instant::now();
    let mut datagram = vec![0; DATAGRAM_BYTES];
    loop {
        tokio::select! {
            biased;
            () = stop.cancelled() => break,
            at = frames.tick() => {
                // Later than half a frame: the machine is behind.
                let overframing = at.elapsed() > period / 2 || at > due + period / 2;
                due = at + period;
                if let Some((bytes, to)) = session.frame(overframing).await {
                    send(&socket, &bytes, to, &counters).await;
                }
            }
            Some(event) = events.recv() => session.event(&event),
            () = session.work() => {}
            readable = socket.readable() => {
                if let Err(error) = readable {
                    tracing::error!(%error, "fault: the CIGI port is gone");
                    break;
                }
                let mut packets = 0;
                for _ in 0..AT_ONCE {
                    if packets > CIGI_PACKETS_AT_ONCE {
                        break;
                    }
                    match socket.try_recv_from(&mut datagram) {
                        Ok((length, from)) => packets += session.datagram(&datagram[..length], from).await,
                        Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => break,
                        // An earlier answer that nobody took (ICMP): no reason to stop listening.
                        Err(_) => Counters::one(&counters.send_failures),
                    }
                }
            }
        }
    }
    session.end().await;
}

async fn send(socket: &UdpSocket, bytes: &[u8], to: SocketAddr, counters: &Counters) {
    // A full buffer of the system drops this datagram: the next frame comes anyway.
    match socket.try_send_to(bytes, to) {
        Ok(_) => Counters::one(&counters.frames),
        Err(_) => Counters::one(&counters.send_failures),
    }
}
