//! Origin, Host and token at the door.

use crate::harness::{Server, guarded};
use serde_json::json;
use stormdeck::serve::client::Client;

const UPGRADE: &str = "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
    Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";

fn upgrade(host: &str, origin: &str) -> String {
    format!("GET /ws HTTP/1.1\r\nHost: {host}\r\nOrigin: {origin}\r\n{UPGRADE}\r\n")
}

#[tokio::test(flavor = "multi_thread")]
async fn a_page_from_elsewhere_cannot_connect() {
    let server = Server::start().await;
    let host = server.address.to_string();
    let (status, _, body) = server.raw(&upgrade(&host, "http://evil.example")).await;
    assert_eq!(status, 403, "{}", String::from_utf8_lossy(&body));
    let rebound = upgrade("evil.example", "http://evil.example");
    assert_eq!(server.raw(&rebound).await.0, 403, "a foreign name that points here");
    let (status, ..) = server.http("/frame.png", "Origin: http://evil.example\r\n").await;
    assert_eq!(status, 403);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_token_guards_every_endpoint() {
    let server = Server::start_with(|settings| settings.token = Some("correct-horse".into())).await;
    for path in ["/", "/frame.png", "/frame.jpg", "/metrics", "/healthz"] {
        assert_eq!(server.http(path, "").await.0, 401, "{path}");
        assert_eq!(server.http(&format!("{path}?token=correct-horsf"), "").await.0, 401, "{path}");
        assert_eq!(server.http(&format!("{path}?token=correct-horse"), "").await.0, 200, "{path}");
        assert_eq!(server.http(path, "Authorization: Bearer correct-horse\r\n").await.0, 200, "{path}");
    }
    let wrong = guarded("an answer", Client::connect(&server.address.to_string(), Some("wrong"))).await;
    assert!(wrong.is_err_and(|error| error.to_string().contains("token")));
    let right = guarded("an answer", Client::connect(&server.address.to_string(), Some("correct-horse"))).await;
    right.unwrap().close().await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn over_a_websocket_the_token_may_come_with_hello_and_nothing_before() {
    let server = Server::start_with(|settings| settings.token = Some("correct-horse".into())).await;
    let mut stranger = server.connect().await;
    let welcome = stranger.hello(json!({"role": "watcher", "token": "correct-horse"})).await;
    assert_eq!(welcome["type"], "welcome", "{welcome}");
    for first in [
        json!({"type": "hello", "protocol": "stormdeck.v1", "role": "host", "token": "wrong-horse"}),
        json!({"type": "hello", "protocol": "stormdeck.v1", "role": "host"}),
        json!({"type": "query", "what": "state"}),
    ] {
        let mut stranger = server.connect().await;
        let answer = stranger.ask(first).await;
        assert_eq!(answer["type"], "refused", "{answer}");
        assert!(stranger.end().await.unwrap_or_default().contains("token"));
    }
    server.stop().await;
}
