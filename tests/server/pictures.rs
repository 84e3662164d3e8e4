//! Pictures, numbers and the page by plain HTTP.

use crate::executor::Control;
use crate::harness::Server;
use serde_json::json;
use std::sync::Arc;
use stormdeck::reference::ReferenceExecutor;

fn png_size(bytes: &[u8]) -> (u32, u32) {
    png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap().info().size()
}

#[tokio::test(flavor = "multi_thread")]
async fn one_request_gives_one_fresh_picture() {
    let server = Server::start().await;
    let mut host = server.host().await;
    host.acked(json!({"type": "view", "action": "create", "name": "tail", "size_px": [48, 24]})).await;
    let (status, head, body) = server.http("/frame.png", "").await;
    assert_eq!(status, 200);
    assert!(head.to_lowercase().contains("content-type: image/png"), "{head}");
    assert_eq!(png_size(&body), (32, 16), "the first view when none is named");
    let (_, _, body) = server.http("/frame.png?view=tail", "").await;
    assert_eq!(png_size(&body), (48, 24));
    let (status, head, body) = server.http("/frame.jpg?view=tail", "").await;
    assert_eq!((status, &body[..2]), (200, &b"\xff\xd8"[..]));
    assert!(head.contains("image/jpeg") && head.contains("stormdeck-view: tail"), "{head}");
    let (status, _, body) = server.http("/frame.png?view=nowhere", "").await;
    assert_eq!(status, 404);
    assert!(String::from_utf8_lossy(&body).contains("main, tail"), "it says which there are");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_picture_asked_for_after_an_ack_shows_the_change() {
    let server = Server::start().await;
    let mut host = server.host().await;
    for size in [16, 64, 24, 80, 32] {
        host.acked(json!({"type": "view", "action": "change", "name": "main", "size_px": [size, 16]})).await;
        let (_, _, body) = server.http("/frame.png", "").await;
        assert_eq!(png_size(&body), (size, 16));
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn without_watchers_nothing_is_drawn() {
    let server = Server::start().await;
    let mut host = server.host().await;
    let before = host.ask(json!({"type": "query", "what": "state"})).await["simulation_time_s"].as_f64().unwrap();
    // Time runs, so a server that drew unasked would have.
    loop {
        let state = host.ask(json!({"type": "query", "what": "state"})).await;
        if state["simulation_time_s"].as_f64().unwrap() > before + 0.3 {
            break;
        }
        tokio::time::sleep(std::time::Duration::from_millis(20)).await;
    }
    assert_eq!(server.control.submitted(), 0);
    server.http("/frame.png", "").await;
    assert!(server.control.submitted() >= 1);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn page_health_and_metrics_answer() {
    let server = Server::start().await;
    let (status, head, body) = server.http("/", "").await;
    assert_eq!(status, 200);
    assert!(head.contains("text/html"), "{head}");
    let page = String::from_utf8(body).unwrap();
    assert!(!page.contains("src=\"http") && !page.contains("@import"), "nothing from outside");
    assert_eq!(server.http("/healthz", "").await.2, b"ok\n");
    assert_eq!(server.http("/nowhere", "").await.0, 404);
    let (_, _, body) = server.http("/metrics", "").await;
    let text = String::from_utf8(body).unwrap();
    for name in [
        "clients",
        "refusals_total",
        "faults_total",
        "client_queue_frames",
        "render_seconds_count",
        "encode_seconds_count",
        "simulation_time_seconds",
    ] {
        assert!(text.contains(&format!("\nstormdeck_{name} ")), "{name} is missing:\n{text}");
    }
    assert!(text.contains("stormdeck_executor_info{executor=\"painter of the tests\"} 1"));
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_reference_executor_draws_what_the_messages_say() {
    let factory: stormdeck::serve::ExecutorFactory = Box::new(|| Ok(Box::new(ReferenceExecutor::new())));
    let server = Server::start_on(|_| {}, Arc::new(Control::default()), factory).await;
    let mut host = server.host().await;
    host.acked(json!({"type": "scenario", "action": "pause"})).await;
    let (status, _, clear) = server.http("/frame.png", "").await;
    assert_eq!((status, png_size(&clear)), (200, (32, 16)));
    let (_, _, again) = server.http("/frame.png", "").await;
    assert!(again == clear, "the same world gives the same bytes");
    host.acked(json!({"type": "time", "utc": "2026-06-21T23:30:00Z", "rate": 0.0})).await;
    let (_, _, night) = server.http("/frame.png", "").await;
    assert!(night != clear, "another time of day is another picture");
    let text = String::from_utf8(server.http("/metrics", "").await.2).unwrap();
    assert!(text.contains("stormdeck_executor_info{executor=\"reference"), "{text}");
    server.stop().await;
}
