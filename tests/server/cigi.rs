//! A CIGI host against the server: handshake, modes, answers, strikes and their events, in both versions and byte orders.

use crate::harness::Server;
use crate::tshark::{self, Way};
use host::{Host, ownship};
use serde_json::json;
use stormdeck::wire::cigi::packets::*;
use stormdeck::wire::cigi::{ByteOrder, Version};

#[path = "cigi/host.rs"]
mod host;
#[path = "cigi/port.rs"]
mod port;

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
