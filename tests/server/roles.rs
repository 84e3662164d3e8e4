//! One host at a time; everybody else watches.

use crate::harness::Server;
use serde_json::json;

#[tokio::test(flavor = "multi_thread")]
async fn the_first_message_is_hello() {
    let server = Server::start().await;
    let mut stranger = server.connect().await;
    stranger.refused(json!({"type": "query", "what": "state"}), "type").await;
    let welcome = stranger.hello(json!({"role": "watcher"})).await;
    assert_eq!((&welcome["type"], &welcome["role"]), (&json!("welcome"), &json!("watcher")));
    assert_eq!(welcome["views"], json!(["main"]));
    assert_eq!(welcome["executor"], "painter of the tests");
    let state = stranger.ask(json!({"type": "query", "what": "state"})).await;
    assert_eq!(state["type"], "state");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_watcher_changes_nothing_and_is_told_why() {
    let server = Server::start().await;
    let mut watcher = server.watcher().await;
    let at = json!({"latitude_deg": 1.0, "longitude_deg": 2.0, "altitude_m": 3.0,
        "yaw_deg": 0.0, "pitch_deg": 0.0, "roll_deg": 0.0});
    let mut ownship = at.clone();
    ownship["type"] = "ownship".into();
    let strike = json!({"type": "strike", "latitude_deg": 1.0, "longitude_deg": 2.0, "flash_type": "cloud_to_ground"});
    let before = watcher.ask(json!({"type": "query", "what": "state"})).await;
    for message in [
        ownship,
        strike,
        json!({"type": "weather", "visibility_m": 5000.0}),
        json!({"type": "time", "rate": 2.0}),
        json!({"type": "view", "action": "remove", "name": "main"}),
        json!({"type": "scenario", "action": "pause"}),
        json!({"type": "step", "to_s": 1000.0}),
    ] {
        let refused = watcher.refused(message, "role").await;
        assert!(refused["limit"].as_str().unwrap().contains("nobody is host"), "{refused}");
    }
    let after = watcher.ask(json!({"type": "query", "what": "state"})).await;
    for field in ["ownship", "weather", "views", "flashes", "player"] {
        assert_eq!(before[field], after[field], "{field}");
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn two_hosts_cannot_fight_and_the_role_is_free_when_its_holder_leaves() {
    let server = Server::start().await;
    let first = server.host().await;
    let mut second = server.watcher().await;
    let refused = second.hello(json!({"role": "host", "name": "second"})).await;
    assert_eq!((&refused["type"], &refused["field"]), (&json!("refused"), &json!("role")));
    assert!(refused["limit"].as_str().unwrap().contains("host is host"), "{refused}");
    // Without the setting, asking to take it over changes nothing.
    let refused = second.hello(json!({"role": "host", "name": "second", "take_over": true})).await;
    assert!(refused["why"].as_str().unwrap().contains("settings"), "{refused}");
    first.client.close().await;
    second.event("host_free").await;
    let welcome = second.hello(json!({"role": "host", "name": "second"})).await;
    assert_eq!(welcome["role"], "host", "{welcome}");
    second.acked(json!({"type": "weather", "visibility_m": 5000.0})).await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_take_over_where_the_settings_allow_it_leaves_the_old_host_a_watcher() {
    let server = Server::start_with(|settings| settings.allow_take_over = true).await;
    let mut first = server.host().await;
    let mut second = server.watcher().await;
    let refused = second.hello(json!({"role": "host", "name": "second"})).await;
    assert!(refused["why"].as_str().unwrap().contains("take_over"), "it must be asked for: {refused}");
    let welcome = second.hello(json!({"role": "host", "name": "second", "take_over": true})).await;
    assert_eq!(welcome["role"], "host", "{welcome}");
    let refused = first.refused(json!({"type": "weather", "visibility_m": 5000.0}), "role").await;
    assert!(refused["limit"].as_str().unwrap().contains("second is host"), "{refused}");
    let own = first.event("host_taken").await;
    assert_ne!(own["client"], welcome["client"], "when it became host itself");
    let taken = first.event("host_taken").await;
    assert_eq!(taken["client"], welcome["client"]);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_host_may_step_back_to_watching() {
    let server = Server::start().await;
    let mut first = server.host().await;
    first.hello(json!({"role": "watcher"})).await;
    first.refused(json!({"type": "weather", "visibility_m": 5000.0}), "role").await;
    let _second = server.host().await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn one_client_too_many_is_turned_away_and_there_is_room_again_when_one_leaves() {
    let server = Server::start_with(|settings| settings.max_clients = 1).await;
    let host = server.host().await;
    let reason = server.connect().await.end().await;
    assert!(reason.as_deref().is_some_and(|reason| reason.contains("too many")), "{reason:?}");
    host.client.close().await;
    server.until_metric("stormdeck_clients", |clients| clients == 0.0).await;
    let _next = server.host().await;
    server.stop().await;
}
