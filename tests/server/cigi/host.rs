//! A CIGI host for tests: its own port, its frame numbers, and everything that went to and fro.

use crate::harness::{Server, guarded};
use crate::tshark::Way;
use std::net::SocketAddr;
use stormdeck::settings::CigiSettings;
use stormdeck::wire::cigi::message::encode_packet;
use stormdeck::wire::cigi::packets::*;
use stormdeck::wire::cigi::{ByteOrder, Version, decode};
use tokio::net::UdpSocket;

/// A host with its own port, of which the server knows.
pub struct Host {
    pub socket: UdpSocket,
    /// Where it is, once it has spoken.
    pub server: Option<SocketAddr>,
    version: Version,
    order: ByteOrder,
    pub frame: u32,
    ig_frame: u32,
    /// Everything that went to and fro.
    pub traffic: Vec<(Way, Vec<u8>)>,
}

impl Host {
    pub async fn new(version: Version, order: ByteOrder) -> Self {
        let socket = UdpSocket::bind("127.0.0.1:0").await.unwrap();
        Self { socket, server: None, version, order, frame: 0, ig_frame: 0, traffic: Vec::new() }
    }

    /// A server that knows this host's address.
    pub async fn server(&self, change: impl FnOnce(&mut CigiSettings)) -> Server {
        let mut cigi = CigiSettings {
            listen: "127.0.0.1:0".parse().unwrap(),
            host: Some(self.socket.local_addr().unwrap()),
            reply_port: None,
            allow: Vec::new(),
            multicast: None,
            synchronous: false,
            byte_order: self.order,
            rate_hz: 60.0,
            silence_s: 60.0,
            host_chooses_database: false,
            sea_level_m: 0.0,
            seed: 1,
            size_px: [64, 36],
        };
        change(&mut cigi);
        Server::start_with(|settings| settings.cigi = Some(cigi)).await
    }

    pub async fn send(&mut self, ig_mode: u8, packets: Vec<Packet>) {
        self.frame += 1;
        let [major_version, minor_version] = self.version.numbers();
        let control = IgControl {
            major_version,
            minor_version,
            ig_mode,
            host_frame_number: self.frame,
            last_ig_frame_number: self.ig_frame,
            ..Default::default()
        };
        let packets = std::iter::once(Packet::from(control)).chain(packets);
        let bytes: Vec<u8> =
            packets.flat_map(|packet| encode_packet(&packet, self.version, self.order).expect("in range")).collect();
        self.traffic.push((Way::ToServer, bytes.clone()));
        self.socket.send_to(&bytes, self.server.expect("a Start of Frame has come")).await.unwrap();
    }

    /// The next message of the server.
    pub async fn receive(&mut self) -> (StartOfFrame, Vec<Packet>) {
        let mut bytes = [0; 2048];
        let (length, from) = guarded("a Start of Frame", self.socket.recv_from(&mut bytes)).await.unwrap();
        self.server = Some(from);
        self.traffic.push((Way::ToHost, bytes[..length].to_vec()));
        let message = decode(&bytes[..length]).expect("a message as the standard says");
        let mut packets = message.packets.into_iter();
        let Some(Packet::StartOfFrame(sof)) = packets.next() else { panic!("no Start of Frame") };
        assert_eq!(sof.ig_frame_number, if self.ig_frame == 0 { sof.ig_frame_number } else { self.ig_frame + 1 });
        self.ig_frame = sof.ig_frame_number;
        (sof, packets.collect())
    }

    /// Messages until the server's mode is this one and it has heard our newest message.
    pub async fn until_mode(&mut self, mode: u8) -> StartOfFrame {
        loop {
            let (sof, packets) = self.receive().await;
            if sof.ig_mode == mode && sof.last_host_frame_number == self.frame {
                return sof;
            }
            assert!(mode != 0 || packets.is_empty(), "in standby only Start of Frame is sent");
        }
    }

    /// The first answer that `wanted` takes.
    pub async fn answer<T>(&mut self, wanted: impl Fn(&Packet) -> Option<T>) -> T {
        loop {
            let (_, packets) = self.receive().await;
            if let Some(found) = packets.iter().find_map(&wanted) {
                return found;
            }
        }
    }
}

/// The ownship at a latitude, 8.5 E, in a version's own packets.
pub fn ownship(version: Version, latitude: f64, altitude: f64) -> Vec<Packet> {
    let (lat_xoff, lon_yoff, alt_zoff) = (latitude, 8.5, altitude);
    match version {
        Version::V3 => {
            vec![EntityControl { entity_state: 1, lat_xoff, lon_yoff, alt_zoff, ..Default::default() }.into()]
        }
        Version::V4 => vec![
            EntityState { entity_state: 1, ..Default::default() }.into(),
            EntityPosition { lat_xoff, lon_yoff, alt_zoff, ..Default::default() }.into(),
        ],
    }
}
