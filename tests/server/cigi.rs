//! A CIGI host against the server: handshake, modes, answers, strikes and their events, in both versions and byte orders;
//! and what junk, strangers and a second host do not do.

use crate::harness::{Server, guarded};
use crate::tshark::{self, Way};
use serde_json::json;
use std::net::SocketAddr;
use stormdeck::settings::CigiSettings;
use stormdeck::wire::cigi::message::encode_packet;
use stormdeck::wire::cigi::packets::*;
use stormdeck::wire::cigi::{ByteOrder, Version, decode};
use tokio::net::UdpSocket;

/// A host with its own port, of which the server knows.
struct Host {
    socket: UdpSocket,
    server: Option<SocketAddr>,
    version: Version,
    order: ByteOrder,
    frame: u32,
    ig_frame: u32,
    /// Everything that went to and fro.
    traffic: Vec<(Way, Vec<u8>)>,
}

impl Host {
    async fn new(version: Version, order: ByteOrder) -> Self {
        let socket = UdpSocket::bind("127.0.0.1:0").await.unwrap();
        Self { socket, server: None, version, order, frame: 0, ig_frame: 0, traffic: Vec::new() }
    }

    /// A server that knows this host's address.
    async fn server(&self, change: impl FnOnce(&mut CigiSettings)) -> Server {
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

    async fn send(&mut self, ig_mode: u8, packets: Vec<Packet>) {
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
    async fn receive(&mut self) -> (StartOfFrame, Vec<Packet>) {
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
    async fn until_mode(&mut self, mode: u8) -> StartOfFrame {
        loop {
            let (sof, packets) = self.receive().await;
            if sof.ig_mode == mode && sof.last_host_frame_number == self.frame {
                return sof;
            }
            assert!(mode != 0 || packets.is_empty(), "in standby only Start of Frame is sent");
        }
    }

    /// The first answer that `wanted` takes.
    async fn answer<T>(&mut self, wanted: impl Fn(&Packet) -> Option<T>) -> T {
        loop {
            let (_, packets) = self.receive().await;
            if let Some(found) = packets.iter().find_map(&wanted) {
                return found;
            }
        }
    }
}

fn ownship(version: Version, latitude: f64, altitude: f64) -> Vec<Packet> {
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

async fn counted(server: &Server, name: &str) -> u64 {
    let (_, _, body) = server.http("/metrics", "").await;
    let text = String::from_utf8(body).unwrap();
    let line = text.lines().find(|line| line.starts_with(&format!("stormdeck_cigi_{name}_total "))).unwrap_or("x 0");
    line.rsplit(' ').next().and_then(|count| count.parse().ok()).expect("a count")
}

#[tokio::test]
async fn a_session_in_each_version_and_byte_order() {
    for version in Version::ALL {
        for order in ByteOrder::ALL {
            let traffic = session(version, order).await;
            assert!(traffic.len() > 6, "{} datagrams", traffic.len());
        }
    }
}

#[tokio::test]
#[cfg_attr(not(tshark_tests), ignore = "no tshark")]
async fn wireshark_reads_a_session_in_both_directions() {
    for order in ByteOrder::ALL {
        let traffic = session(Version::V3, order).await;
        let same = tshark::compare(&format!("session-{}", order.name()), &traffic);
        assert!(same > 100, "{same} values compared");
    }
}

/// Standby, operation with weather and questions, and standby again. Returns what went to and fro.
async fn session(version: Version, order: ByteOrder) -> Vec<(Way, Vec<u8>)> {
    let mut host = Host::new(version, order).await;
    let server = host.server(|_| {}).await;
    let (sof, _) = host.receive().await;
    assert_eq!((sof.ig_mode, sof.timestamp_valid, sof.database_number), (0, true, 0), "before any message");
    // In standby nothing but the mode counts.
    host.send(0, ownship(version, 40.0, 900.0)).await;
    host.until_mode(0).await;
    host.send(1, vec![]).await;
    let sof = host.until_mode(1).await;
    assert_eq!(sof.major_version, version.numbers()[0]);
    let mut watcher = server.watcher().await;
    let state = watcher.ask(json!({"type": "query", "what": "state"})).await;
    assert_ne!(state["ownship"]["latitude_deg"], 40.0);
    assert_eq!(state["weather"]["layers"], json!([]), "the scenario made room");

    let layer = WeatherControl {
        layer_id: 1,
        weather_enable: true,
        cloud_type: 10,
        coverage: 100.0,
        base_elevation: 1_000.0,
        thickness: 500.0,
        air_temperature: -3.5,
        ..Default::default()
    };
    let mut packets = ownship(version, 46.5, 900.0);
    packets.push(layer.into());
    packets.push(
        HatHotRequest { hat_hot_id: 5, request_type: 2, lat_xoff: 46.0, alt_zoff: 123.5, ..Default::default() }.into(),
    );
    let at = EnvironmentalConditionsRequest {
        request_type: 12,
        request_id: 9,
        latitude: 46.5,
        longitude: 8.5,
        altitude: 1_250.0,
    };
    packets.push(at.into());
    host.send(1, packets).await;
    let mut heights = None;
    let mut conditions = None;
    while heights.is_none() || conditions.is_none() {
        for packet in host.receive().await.1 {
            match packet {
                Packet::HatHotExtendedResponse(answer) => heights = Some(answer),
                Packet::WeatherConditionsResponse(answer) => conditions = Some(answer),
                Packet::AerosolConcentrationResponse(answer) => {
                    assert_eq!((answer.request_id, answer.layer_id), (9, 1))
                }
                other => panic!("{other:?}"),
            }
        }
    }
    let (heights, conditions) = (heights.expect("heights"), conditions.expect("conditions"));
    assert!(heights.valid && heights.hat_hot_id == 5 && (heights.hat - 123.5).abs() < 1e-6 && heights.hot == 0.0);
    assert_eq!(u32::from(heights.host_frame_number_lsn), host.frame & 0xf);
    assert_eq!((conditions.request_id, conditions.air_temperature), (9, -3.5));
    let state = watcher.ask(json!({"type": "query", "what": "state"})).await;
    assert_eq!(state["ownship"]["latitude_deg"], 46.5);
    assert_eq!(state["weather"]["layers"][0]["cloud_type"], "stratus");
    assert_eq!(state["host_frame"], host.frame);

    // Back to standby: everything at its defaults again.
    host.send(0, vec![]).await;
    host.until_mode(0).await;
    let state = watcher.ask(json!({"type": "query", "what": "state"})).await;
    assert_eq!(state["weather"]["layers"], json!([]));
    assert_eq!(counted(&server, "rejected").await, 0);
    server.stop().await;
    host.traffic
}

#[tokio::test]
async fn a_strike_is_answered_by_an_event_that_names_its_frame() {
    let mut host = Host::new(Version::V3, ByteOrder::Little).await;
    let server = host.server(|_| {}).await;
    host.receive().await;
    let mut watcher = server.watcher().await;
    host.send(1, ownship(Version::V3, 46.5, 900.0)).await;
    host.until_mode(1).await;
    watcher.acked(json!({"type": "subscribe", "view": "main", "format": "raw"})).await;
    let strike = Strike {
        strike_id: 77,
        flags: 1,
        return_strokes: 2,
        latitude: 46.6,
        longitude: 8.5,
        altitude: 3_000.0,
        peak_current_ka: -42.5,
        channel_top_altitude: 0.0,
    };
    host.send(1, vec![strike.into()]).await;
    let event = host.answer(|packet| match packet {
        Packet::EventNotification(event) => Some(event.clone()),
        _ => None,
    });
    let event = event.await;
    assert_eq!((event.event_id, event.event_data_1), (0x4c53, 77));
    assert_eq!(f32::from_bits(event.event_data_2), -42.5);
    assert!(event.event_data_3 > 0 && event.event_data_3 < 1_000_000, "a frame number: {}", event.event_data_3);
    server.stop().await;
}

#[tokio::test]
async fn junk_and_strangers_are_counted_and_disturb_nobody() {
    let mut host = Host::new(Version::V4, ByteOrder::Big).await;
    let server = host.server(|_| {}).await;
    host.receive().await;
    host.send(2, ownship(Version::V4, 46.5, 900.0)).await;
    host.until_mode(2).await;
    let to = host.server.expect("known");
    for junk in [&[][..], &[0x42; 100], &[1, 24, 3, 0, 0x10, 0], &[0x18; 24]] {
        host.socket.send_to(junk, to).await.unwrap();
    }
    // A message that is right but for its last byte counts as a whole for nothing.
    let mut bad = encode_packet(
        &IgControl { major_version: 4, ig_mode: 0, ..Default::default() }.into(),
        Version::V4,
        ByteOrder::Big,
    )
    .unwrap();
    bad.push(0);
    host.socket.send_to(&bad, to).await.unwrap();
    // In Debug a refusal is also said in words.
    host.send(2, ownship(Version::V4, f64::NAN, 900.0)).await;
    let said = host.answer(|packet| match packet {
        Packet::ImageGeneratorMessage(said) => Some(said.message.clone()),
        _ => None,
    });
    let said = said.await;
    assert!(said.starts_with("Entity Position.lat_xoff = NaN"), "{said}");
    assert_eq!(host.receive().await.0.ig_mode, 2, "still in Debug");
    assert_eq!(counted(&server, "rejected").await, 5);
    assert_eq!(counted(&server, "refused").await, 1);
    server.stop().await;
}

#[tokio::test]
async fn one_host_at_a_time_by_cigi_or_websocket() {
    let mut first = Host::new(Version::V3, ByteOrder::Little).await;
    let server = first.server(|_| {}).await;
    first.receive().await;
    let mut talker = server.host().await;
    // A WebSocket client steers: the CIGI host is a stranger until it leaves.
    first.send(1, ownship(Version::V3, 46.5, 900.0)).await;
    while counted(&server, "strangers").await == 0 {
        assert_eq!(first.receive().await.0.ig_mode, 0);
    }
    talker
        .acked(json!({"type": "ownship", "latitude_deg": 47.0, "longitude_deg": 8.0, "altitude_m": 500.0,
        "yaw_deg": 0, "pitch_deg": 0, "roll_deg": 0}))
        .await;
    drop(talker);
    loop {
        first.send(1, ownship(Version::V3, 46.5, 900.0)).await;
        if first.receive().await.0.ig_mode == 1 {
            break;
        }
    }
    server.stop().await;
}

#[tokio::test]
async fn synchronous_frames_are_steps_of_the_world_and_a_silent_host_holds_nothing() {
    let mut host = Host::new(Version::V3, ByteOrder::Little).await;
    let server = host.server(|settings| settings.synchronous = true).await;
    host.receive().await;
    host.send(1, ownship(Version::V3, 46.5, 900.0)).await;
    host.until_mode(1).await;
    let mut watcher = server.watcher().await;
    let mut times_s = Vec::new();
    for frame in 0..5 {
        host.send(1, ownship(Version::V3, 46.5 + 0.001 * f64::from(frame), 900.0)).await;
        host.receive().await;
        let state = watcher.ask(json!({"type": "query", "what": "state"})).await;
        times_s.push(state["simulation_time_s"].as_f64().expect("a time"));
    }
    // The clock ran free until the first step; from then on it stands between frames.
    for pair in times_s[1..].windows(2) {
        let steps = (pair[1] - pair[0]) * 60.0;
        assert!((steps - steps.round()).abs() < 1e-6, "whole frames: {times_s:?}");
    }
    assert!(times_s[4] > times_s[1]);
    // Nothing more is said: frames go on, and say that they were missed.
    for _ in 0..5 {
        host.receive().await;
    }
    assert!(counted(&server, "missed_frames").await >= 3);
    server.stop().await;
}

#[tokio::test]
async fn a_datagram_of_a_thousand_packets_is_taken_whole() {
    let mut host = Host::new(Version::V3, ByteOrder::Little).await;
    let server = host.server(|_| {}).await;
    host.receive().await;
    host.send(1, vec![]).await;
    host.until_mode(1).await;
    // 62 kB: as many entities as are kept, the ownship among them, and a hundred more.
    let entity = |entity_id| EntityControl { entity_id, entity_state: 1, lat_xoff: 46.5, ..Default::default() };
    let most = stormdeck::wire::limits::CIGI_ENTITIES as u16;
    host.send(1, (0..most + 100).map(|id| entity(id).into()).collect()).await;
    host.until_mode(1).await;
    let state = server.watcher().await.ask(json!({"type": "query", "what": "state"})).await;
    assert_eq!(state["ownship"]["latitude_deg"], 46.5);
    assert_eq!(counted(&server, "packets").await, u64::from(most) + 100 + 2);
    assert_eq!(counted(&server, "refused").await, 100);
    server.stop().await;
}

#[tokio::test]
async fn a_host_may_speak_to_a_group() {
    const GROUP: &str = "239.255.76.83";
    // The address of ours that speaks to the group.
    let probe = UdpSocket::bind("0.0.0.0:0").await.unwrap();
    probe.connect((GROUP, 9)).await.expect("a network that carries groups");
    let own = probe.local_addr().unwrap().ip();
    let mut host = Host::new(Version::V4, ByteOrder::Little).await;
    host.socket = UdpSocket::bind((own, 0)).await.unwrap();
    let server = host
        .server(|settings| {
            settings.listen = "0.0.0.0:0".parse().unwrap();
            settings.multicast = Some(GROUP.parse().unwrap());
        })
        .await;
    let (sof, _) = host.receive().await;
    assert_eq!(sof.ig_mode, 0);
    let port = host.server.expect("known").port();
    // To the group, and then to the server alone: both are heard.
    host.server = Some(SocketAddr::new(GROUP.parse().unwrap(), port));
    host.send(1, vec![]).await;
    host.until_mode(1).await;
    host.send(2, vec![]).await;
    host.until_mode(2).await;
    server.stop().await;
}

#[tokio::test]
async fn watchers_are_told_of_the_air_that_the_host_has_spoken_of() {
    let mut host = Host::new(Version::V4, ByteOrder::Little).await;
    let server = host.server(|_| {}).await;
    host.receive().await;
    let mut watcher = server.watcher().await;
    let question = json!({"type": "query", "what": "conditions", "latitude_deg": 46.5, "longitude_deg": 8.5,
        "altitude_m": 0});
    assert_eq!(watcher.ask(question.clone()).await["temperature_c"], 15.0, "the standard atmosphere");
    let cold = AtmosphereControl { global_air_temperature: -20.0, global_humidity: 55, ..Default::default() };
    host.send(1, vec![cold.into()]).await;
    host.until_mode(1).await;
    let told = watcher.ask(question.clone()).await;
    assert_eq!((&told["temperature_c"], &told["humidity_percent"]), (&json!(-20.0), &json!(55.0)));
    host.send(0, vec![]).await;
    host.until_mode(0).await;
    assert_eq!(watcher.ask(question).await["temperature_c"], 15.0, "reset");
    server.stop().await;
}
