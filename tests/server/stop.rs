//! The end: everybody is told, every task is gone, whoever is stuck.

use crate::executor::Control;
use crate::harness::{Server, guarded};
use serde_json::json;
use std::sync::Arc;

#[tokio::test(flavor = "multi_thread")]
async fn clients_are_told() {
    let server = Server::start().await;
    let mut host = server.host().await;
    let mut watcher = server.watcher().await;
    watcher.subscribe("main", "raw").await;
    watcher.frame().await;
    server.stop().await;
    assert!(host.end().await.is_some_and(|reason| reason.contains("stops")));
    assert!(watcher.end().await.is_some_and(|reason| reason.contains("stops")));
}

#[tokio::test(flavor = "multi_thread")]
async fn every_task_ends_even_with_stuck_clients_and_half_requests() {
    let alive = tokio::runtime::Handle::current().metrics();
    let before = alive.num_alive_tasks();
    let server = Server::start().await;
    let mut host = server.host().await;
    host.acked(json!({"type": "view", "action": "change", "name": "main", "size_px": [1024, 1024]})).await;
    let mut stuck = server.watcher().await;
    stuck.subscribe("main", "raw").await;
    server.until_metric("stormdeck_frames_dropped_total{view=\"main\"}", |dropped| dropped > 0.0).await;
    // A request whose head never ends.
    let mut half = tokio::net::TcpStream::connect(server.address).await.unwrap();
    tokio::io::AsyncWriteExt::write_all(&mut half, b"GET /frame.png HTTP/1.1\r\nHost: 127").await.unwrap();
    let address = server.address;
    server.stop().await;
    // Their work is done; the last may still be on its way out of the scheduler, which counts it until then.
    guarded("the end of every task", async {
        while alive.num_alive_tasks() > before {
            tokio::task::yield_now().await;
        }
    })
    .await;
    tokio::net::TcpListener::bind(address).await.expect("the port is free again");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_step_under_way_is_answered_or_its_host_told() {
    let control = Arc::new(Control::default());
    let factory = control.factory();
    let server = Server::start_on(|_| {}, Arc::clone(&control), factory).await;
    let mut host = server.host().await;
    control.hold();
    host.say(json!({"type": "step", "to_s": 100.0})).await;
    server.until_metric("stormdeck_steps_waiting", |waiting| waiting == 1.0).await;
    // The picture comes only after the server was told to stop.
    let release = tokio::spawn(async move {
        tokio::time::sleep(std::time::Duration::from_millis(200)).await;
        control.release();
    });
    server.stop().await;
    release.await.unwrap();
    assert!(host.end().await.is_some_and(|reason| reason.contains("stops")));
}
