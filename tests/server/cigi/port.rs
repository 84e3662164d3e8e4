//! Who may speak to the CIGI port and how: junk, strangers, a second host, datagrams of a thousand packets, groups.

use super::counted;
use super::host::{Host, ownship};
use serde_json::json;
use std::net::SocketAddr;
use stormdeck::wire::cigi::message::encode_packet;
use stormdeck::wire::cigi::packets::*;
use stormdeck::wire::cigi::{ByteOrder, Version};
use tokio::net::UdpSocket;

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

/// A port that nobody has now.
async fn free_port() -> u16 {
    UdpSocket::bind("127.0.0.1:0").await.unwrap().local_addr().unwrap().port()
}

#[tokio::test]
async fn the_first_valid_datagram_of_those_allowed_makes_the_host_until_it_is_silent() {
    let to = SocketAddr::from(([127, 0, 0, 1], free_port().await));
    let mut first = Host::new(Version::V3, ByteOrder::Little).await;
    let server = first
        .server(|settings| {
            (settings.listen, settings.host, settings.silence_s) = (to, None, 1.0);
            settings.allow = vec!["127.0.0.1".parse().unwrap()];
        })
        .await;
    // From an address that is not on the list, and no CIGI from one that is: no host yet.
    let mut stranger = Host::new(Version::V3, ByteOrder::Little).await;
    stranger.socket = UdpSocket::bind("127.0.0.2:0").await.unwrap();
    stranger.server = Some(to);
    stranger.send(1, vec![]).await;
    first.socket.send_to(&[7; 24], to).await.unwrap();
    while counted(&server, "strangers").await + counted(&server, "rejected").await < 2 {}
    // The first that is right: answers go to where it came from.
    first.server = Some(to);
    first.send(1, ownship(Version::V3, 46.5, 900.0)).await;
    first.until_mode(1).await;
    // Another one that is as right meanwhile, in another version: it is not heard, and nobody answers it.
    let mut second = Host::new(Version::V4, ByteOrder::Big).await;
    second.server = Some(to);
    second.send(2, ownship(Version::V4, 40.0, 900.0)).await;
    while counted(&server, "strangers").await < 2 {}
    first.send(1, vec![]).await;
    first.until_mode(1).await;
    let mut nothing = [0; 64];
    assert!(second.socket.try_recv_from(&mut nothing).is_err());
    let state = server.watcher().await.ask(json!({"type": "query", "what": "state"})).await;
    assert_eq!(state["ownship"]["latitude_deg"], 46.5);
    // The host falls silent: after a second the place is free, and the next one is heard in its own version.
    while counted(&server, "messages").await < 3 {
        second.send(2, ownship(Version::V4, 40.0, 900.0)).await;
        tokio::time::sleep(std::time::Duration::from_millis(50)).await;
    }
    let sof = second.until_mode(2).await;
    assert_eq!(sof.major_version, 4);
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
