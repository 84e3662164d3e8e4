//! Messages: answers carry their number, refusals change nothing, and no flood or nonsense ends the conversation.

use crate::harness::{Server, guarded};
use serde_json::{Value, json};
use std::time::Instant;

async fn state(talker: &mut crate::harness::Talker) -> Value {
    talker.ask(json!({"type": "query", "what": "state"})).await
}

#[tokio::test(flavor = "multi_thread")]
async fn the_stages_of_the_flow_count_the_host_alone() {
    let server = Server::start().await;
    let decoded = async || {
        let (_, _, body) = server.http("/metrics", "").await;
        let text = String::from_utf8(body).unwrap();
        text.lines().any(|line| line.starts_with("stormdeck_stage_seconds") && line.contains("stage=\"decode\""))
    };
    let mut watcher = server.watcher().await;
    for _ in 0..20 {
        state(&mut watcher).await;
    }
    assert!(!decoded().await, "a watcher's questions are on no way to a picture");
    server.host().await.acked(json!({"type": "scenario", "action": "pause"})).await;
    assert!(decoded().await);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn what_is_refused_leaves_the_world_as_it_was() {
    let server = Server::start().await;
    let mut host = server.host().await;
    host.acked(json!({"type": "scenario", "action": "pause"})).await;
    let before = state(&mut host).await;
    let layer = json!({"cloud_type": "cumulus", "base_m": 1000.0, "thickness_m": 800.0, "coverage": 0.5,
        "wind_speed_mps": 5.0, "wind_from_deg": 270.0});
    let mut thin = layer.clone();
    thin["thickness_m"] = (-1.0).into();
    let mut over = layer.clone();
    over["base_m"] = 1500.0.into();
    for (message, field) in [
        (
            json!({"type": "ownship", "latitude_deg": 91.0, "longitude_deg": 0.0, "altitude_m": 0.0,
            "yaw_deg": 0.0, "pitch_deg": 0.0, "roll_deg": 0.0}),
            "latitude_deg",
        ),
        (json!({"type": "weather", "layers": [layer, thin]}), "layers[1].thickness_m"),
        (json!({"type": "weather", "layers": [layer, over]}), "layers[1].base_m"),
        (json!({"type": "weather", "visiblity_m": 5000.0}), "visiblity_m"),
        (json!({"type": "view", "action": "remove", "name": "nowhere"}), "name"),
        (json!({"type": "subscribe", "view": "nowhere", "format": "jpeg"}), "view"),
        (json!({"type": "unsubscribe", "view": "main"}), "view"),
        (json!({"type": "query", "what": "plan", "view": "nowhere"}), "view"),
        (json!({"type": "scenario", "action": "load", "name": "not-there"}), "name"),
        (json!({"type": "tempest"}), "type"),
    ] {
        host.refused(message, field).await;
    }
    let after = state(&mut host).await;
    for field in ["ownship", "weather", "views", "regions", "simulation_time_s", "player"] {
        assert_eq!(before[field], after[field], "{field}");
    }
    assert_eq!(server.metric("stormdeck_refusals_total").await, 10.0);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn what_is_no_message_is_refused_and_the_conversation_goes_on() {
    let server = Server::start().await;
    let mut host = server.host().await;
    let deep = "[".repeat(5000);
    let (nan, infinity) =
        ("{\"type\":\"ownship\",\"latitude_deg\":NaN}", "{\"type\":\"weather\",\"visibility_m\":1e999}");
    for nonsense in ["", "{", "null", "[]", "\"hello\"", nan, infinity, deep.as_str()] {
        host.client.send(nonsense).await.unwrap();
        let answer = host.next_answer().await;
        assert_eq!((&answer["type"], &answer["seq"]), (&json!("refused"), &Value::Null), "{nonsense}: {answer}");
    }
    host.acked(json!({"type": "weather", "visibility_m": 5000.0})).await;
    assert_eq!(state(&mut host).await["weather"]["visibility_m"], 5000.0);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_flood_is_refused_once_a_second_and_the_connection_stays() {
    let server = Server::start().await;
    let mut host = server.host().await;
    let begin = Instant::now();
    const FLOOD: u64 = 10_000;
    for sent in 0..FLOOD {
        host.client.send(json!({"type": "query", "what": "nothing"}).to_string()).await.unwrap();
        // Refusals are read now and then, so that the answers cannot hold up the flood.
        while sent % 200 == 0
            && let Ok(Some(_)) = host.client.next_within(std::time::Duration::ZERO).await
        {}
    }
    // The last question may itself be refused as part of the flood: it is asked until it is answered.
    let mut answered = false;
    while !answered {
        host.client.send(json!({"type": "query", "what": "state", "seq": 77}).to_string()).await.unwrap();
        let limit = std::time::Duration::from_millis(200);
        while let Ok(Some(incoming)) = host.client.next_within(limit).await {
            answered |= matches!(incoming, stormdeck::serve::client::Incoming::Text(text)
                if text.contains("\"type\":\"state\""));
        }
        assert!(begin.elapsed() < crate::harness::GUARD, "the flood never ended");
    }
    let seconds = begin.elapsed().as_secs_f64();
    let (refused, unsaid) =
        (server.metric("stormdeck_refusals_total").await, server.metric("stormdeck_flood_dropped_total").await);
    let messages = server.metric("stormdeck_messages_total").await;
    assert!(messages >= FLOOD as f64, "all were read: {messages}");
    // What the bucket let through (its burst of 1000 and 500 a second) was refused one by one as nonsense; of the rest at
    // most one a second was answered.
    let most = 1000.0 + 500.0 * seconds + seconds + 2.0;
    assert!(refused <= most, "{refused} refusals in {seconds} s");
    assert!(unsaid > 0.0, "{refused} refused of {messages}");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_message_that_is_too_long_ends_that_connection_only() {
    let server = Server::start().await;
    let mut host = server.host().await;
    let mut watcher = server.watcher().await;
    let long = format!("{{\"type\":\"{}\"}}", "x".repeat(stormdeck::wire::limits::MESSAGE_BYTES));
    // The server may close while it is still being sent.
    let _closed = watcher.client.send(long).await;
    let reason = watcher.end().await;
    assert!(reason.as_deref().is_none_or(|reason| reason.contains("too long")), "{reason:?}");
    host.acked(json!({"type": "weather", "visibility_m": 5000.0})).await;
    server.until_metric("stormdeck_clients", |clients| clients == 1.0).await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn queries_tell_the_plan_and_the_numbers() {
    let server = Server::start().await;
    let mut host = server.host().await;
    host.subscribe("main", "raw").await;
    host.frame().await;
    let plan = host.ask(json!({"type": "query", "what": "plan", "view": "main"})).await;
    assert_eq!((&plan["type"], &plan["width_px"], &plan["height_px"]), (&json!("plan"), &json!(32), &json!(16)));
    assert!(plan["passes"].is_array());
    let telemetry = host.event("telemetry").await;
    assert_eq!(telemetry["subscriptions"][0]["view"], "main", "{telemetry}");
    let numbers = host.ask(json!({"type": "query", "what": "statistics"})).await;
    assert_eq!((&numbers["clients"], &numbers["faults"]), (&json!(1), &json!(0)), "{numbers}");
    assert_eq!(numbers["subscriptions"][0]["format"], "raw");
    assert!(numbers["views"][0]["frames"].as_u64().unwrap() >= 1, "{numbers}");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_scenario_is_loaded_by_name_or_as_a_document() {
    let folder = std::env::temp_dir().join(format!("stormdeck-scenarios-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let view = json!({"at": 0, "type": "view", "action": "change", "name": "main", "size_px": [32, 16]});
    let scenario = json!({"type": "scenario", "protocol": "stormdeck.v1", "name": "short", "description": "For a test.",
        "duration_s": 30.0, "entries": [view]});
    std::fs::write(folder.join("short.json"), scenario.to_string()).unwrap();
    let server = Server::start_with(|settings| settings.scenario_folder = folder.clone()).await;
    let mut host = server.host().await;
    host.acked(json!({"type": "scenario", "action": "load", "name": "short"})).await;
    assert_eq!(state(&mut host).await["player"]["scenario"], "short");
    let mut document = scenario.clone();
    document["name"] = "inline".into();
    host.acked(json!({"type": "scenario", "action": "load", "document": document})).await;
    host.acked(json!({"type": "scenario", "action": "pause"})).await;
    let player = state(&mut host).await["player"].clone();
    assert_eq!((&player["scenario"], &player["playing"]), (&json!("inline"), &json!(false)));
    guarded("the end", server.stop()).await;
    std::fs::remove_dir_all(&folder).unwrap();
}

#[tokio::test(flavor = "multi_thread")]
async fn a_flood_of_pings_is_a_flood() {
    use tokio::io::AsyncWriteExt;
    let server = Server::start().await;
    let mut flood = tokio::net::TcpStream::connect(server.address).await.unwrap();
    let upgrade = format!(
        "GET /ws HTTP/1.1\r\nHost: {}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
         Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n",
        server.address
    );
    flood.write_all(upgrade.as_bytes()).await.unwrap();
    // An empty ping with a mask of zeros (RFC 6455, 5.2).
    flood.write_all(&[0x89, 0x80, 0, 0, 0, 0].repeat(10_000)).await.unwrap();
    server.until_metric("stormdeck_messages_total", |messages| messages == 10_000.0).await;
    assert!(server.metric("stormdeck_flood_dropped_total").await > 0.0);
    let refused = server.metric("stormdeck_refusals_total").await;
    assert!((1.0..10.0).contains(&refused), "at most one a second: {refused}");
    server.stop().await;
}
