//! Frames: formats, rates, repeats, and clients that are slow, stuck or gone.

use crate::harness::{Server, Talker};
use serde_json::json;
use std::collections::BTreeSet;

async fn ownship(host: &mut Talker, host_frame: u32) {
    host.acked(json!({"type": "ownship", "latitude_deg": 50.0, "longitude_deg": f64::from(host_frame) * 0.01,
        "altitude_m": 1000.0, "yaw_deg": 0.0, "pitch_deg": 0.0, "roll_deg": 0.0, "host_frame": host_frame}))
        .await;
}

#[tokio::test(flavor = "multi_thread")]
async fn each_format_is_what_was_asked_for() {
    let server = Server::start().await;
    let mut host = server.host().await;
    host.subscribe("main", "raw").await;
    let raw = host.frame().await;
    assert_eq!((raw.header.width_px, raw.header.height_px, raw.picture.len()), (32, 16, 32 * 16 * 4));
    host.subscribe("main", "png").await;
    let png = host.frame_that("a PNG", |frame| frame.picture.starts_with(b"\x89PNG")).await;
    let decoder = png::Decoder::new(std::io::Cursor::new(png.picture));
    assert_eq!(decoder.read_info().unwrap().info().size(), (32, 16));
    host.acked(json!({"type": "subscribe", "view": "main", "format": "jpeg", "quality": 95})).await;
    let fine = host.frame_that("a JPEG", |frame| frame.picture.starts_with(b"\xff\xd8")).await;
    let mut decoder = zune_jpeg::JpegDecoder::new(zune_jpeg::zune_core::bytestream::ZCursor::new(fine.picture));
    decoder.decode().unwrap();
    assert_eq!(decoder.dimensions(), Some((32, 16)));
    host.acked(json!({"type": "unsubscribe", "view": "main"})).await;
    let drawn = server.control.submitted();
    host.acked(json!({"type": "weather", "visibility_m": 5000.0})).await;
    let state = host.ask(json!({"type": "query", "what": "state"})).await;
    assert_eq!(state["weather"]["visibility_m"], 5000.0);
    // A frame may have been on its way; from then on nobody wants one.
    assert!(server.control.submitted() <= drawn + 2);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn numbers_rise_by_one_and_host_frames_come_back() {
    let server = Server::start().await;
    let mut host = server.host().await;
    host.subscribe("main", "raw").await;
    for host_frame in 1..=5 {
        ownship(&mut host, host_frame).await;
        host.frame_that("the host's frame", |frame| frame.header.host_frame == host_frame).await;
    }
    let first = host.frame().await.header;
    for expected in first.frame + 1..first.frame + 10 {
        let next = host.frame().await.header;
        assert_eq!(next.frame, expected);
        assert!(next.simulation_time_s >= first.simulation_time_s);
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn nothing_changed_gives_the_same_picture_under_a_new_number_and_draws_nothing() {
    let server = Server::start().await;
    let mut host = server.host().await;
    host.acked(json!({"type": "scenario", "action": "pause"})).await;
    host.acked(json!({"type": "time", "rate": 0.0})).await;
    host.subscribe("main", "raw").await;
    let first = host.frame_that("a repeated frame", |frame| frame.header.repeated).await;
    let drawn = server.control.submitted();
    for _ in 0..5 {
        let next = host.frame().await;
        assert!(next.header.repeated && next.picture == first.picture);
    }
    assert_eq!(server.control.submitted(), drawn);
    ownship(&mut host, 9).await;
    let changed = host.frame_that("a drawn frame", |frame| !frame.header.repeated).await;
    assert_eq!(changed.header.host_frame, 9);
    assert_ne!(changed.picture, first.picture);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
pub async fn each_client_gets_its_own_rate() {
    let server = Server::start().await;
    let mut host = server.host().await;
    host.subscribe("main", "raw").await;
    let mut slow = server.watcher().await;
    slow.acked(json!({"type": "subscribe", "view": "main", "format": "raw", "max_rate_hz": 4.0})).await;
    let mut last = slow.frame().await.header;
    for _ in 0..5 {
        let next = slow.frame().await.header;
        // At most four a second, each up to a quarter of a period early.
        assert!(next.stamps.snapshot_us - last.stamps.snapshot_us >= 180_000, "{last:?} {next:?}");
        last = next;
    }
    let mut fast = 0;
    while host.frame().await.header.frame < last.frame {
        fast += 1;
    }
    assert!(fast > 10, "the fast client was held back to {fast} frames");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn one_who_wants_few_frames_holds_nobody_back() {
    let server = Server::start().await;
    let mut host = server.host().await;
    // One frame in a hundred seconds: longer than the guard.
    host.acked(json!({"type": "subscribe", "view": "main", "format": "raw", "max_rate_hz": 0.01})).await;
    host.frame().await;
    let mut watcher = server.watcher().await;
    watcher.subscribe("main", "raw").await;
    for _ in 0..5 {
        watcher.frame().await;
    }
    assert!(host.frames.is_empty());
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_client_that_never_reads_harms_nobody() {
    let server = Server::start().await;
    let mut host = server.host().await;
    // A megabyte a frame fills the buffers of the system soon.
    host.acked(json!({"type": "view", "action": "change", "name": "main", "size_px": [512, 512]})).await;
    let mut stuck = server.watcher().await;
    stuck.subscribe("main", "raw").await;
    let mut readers = Vec::new();
    for _ in 0..9 {
        let mut reader = server.watcher().await;
        reader.subscribe("main", "jpeg").await;
        readers.push(tokio::spawn(async move {
            let first = reader.frame().await.header.frame;
            let mut numbers = BTreeSet::from([first]);
            while numbers.len() < 60 {
                numbers.insert(reader.frame().await.header.frame);
            }
            reader
        }));
    }
    let dropped = "stormdeck_frames_dropped_total{view=\"main\"}";
    server.until_metric(dropped, |dropped| dropped > 0.0).await;
    let mut kept = Vec::new();
    for reader in readers {
        kept.push(reader.await.unwrap());
    }
    // Telemetry tells the one that reads again what it missed; frames that waited are the newest.
    let telemetry = loop {
        let telemetry = stuck.event("telemetry").await;
        if telemetry["subscriptions"][0]["dropped"].as_u64().unwrap_or(0) > 0 {
            break telemetry;
        }
    };
    assert_eq!(telemetry["subscriptions"].as_array().unwrap().len(), 1, "its own only: {telemetry}");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
pub async fn a_client_that_asked_for_it_is_disconnected_when_slow() {
    let server = Server::start().await;
    let mut host = server.host().await;
    host.acked(json!({"type": "view", "action": "change", "name": "main", "size_px": [1024, 1024]})).await;
    let mut slow = server.watcher().await;
    slow.acked(json!({"type": "subscribe", "view": "main", "format": "raw", "when_slow": "disconnect"})).await;
    server.until_metric("stormdeck_frames_dropped_total{view=\"main\"}", |dropped| dropped > 0.0).await;
    let reason = slow.end().await;
    assert!(reason.is_some_and(|reason| reason.contains("slow")));
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_client_that_vanishes_in_mid_frame_is_forgotten() {
    let server = Server::start().await;
    let mut host = server.host().await;
    host.acked(json!({"type": "view", "action": "change", "name": "main", "size_px": [1024, 1024]})).await;
    for _ in 0..5 {
        let mut watcher = server.watcher().await;
        watcher.subscribe("main", "raw").await;
        server.until_metric("stormdeck_client_queue_frames", |queued| queued > 0.0).await;
        // Dropped without a goodbye, with a frame half in its socket.
        drop(watcher);
    }
    server.until_metric("stormdeck_clients", |clients| clients == 1.0).await;
    server.until_metric("stormdeck_client_queue_frames", |queued| queued == 0.0).await;
    host.subscribe("main", "jpeg").await;
    host.frame().await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_view_that_is_removed_ends_its_subscriptions_and_views_do_not_share_frames() {
    let server = Server::start().await;
    let mut host = server.host().await;
    host.acked(json!({"type": "view", "action": "create", "name": "tail", "size_px": [48, 24]})).await;
    host.subscribe("main", "raw").await;
    host.subscribe("tail", "raw").await;
    for (view, bytes) in [("main", 32 * 16 * 4), ("tail", 48 * 24 * 4), ("main", 32 * 16 * 4), ("tail", 48 * 24 * 4)] {
        let frame = host.frame_that(view, |frame| frame.header.view == view).await;
        assert_eq!(frame.picture.len(), bytes, "{view}");
    }
    host.acked(json!({"type": "view", "action": "remove", "name": "tail"})).await;
    host.refused(json!({"type": "unsubscribe", "view": "tail"}), "view").await;
    host.frame_that("main", |frame| frame.header.view == "main").await;
    server.stop().await;
}

/// Nobody watches a view that is not there: its subscriptions would be asked for, and never get a frame.
async fn no_subscription_to(view: &str, watcher: &mut Talker) {
    let numbers = watcher.ask(json!({"type": "query", "what": "statistics"})).await;
    let subscriptions = numbers["subscriptions"].as_array().unwrap();
    assert!(subscriptions.iter().all(|one| one["view"] != view), "{numbers}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_view_that_a_scenario_removes_or_replaces_ends_its_subscriptions() {
    let server = Server::start().await;
    let mut host = server.host().await;
    let mut watcher = server.watcher().await;
    let document = json!({"type": "scenario", "protocol": "stormdeck.v1", "name": "short", "duration_s": 60, "entries": [
        {"at": 0, "type": "view", "action": "create", "name": "tail", "size_px": [48, 24]},
        {"at": 30, "type": "view", "action": "remove", "name": "tail"}]});
    host.acked(json!({"type": "scenario", "action": "load", "document": document})).await;
    watcher.subscribe("tail", "raw").await;
    watcher.subscribe("main", "raw").await;
    host.ask(json!({"type": "step", "to_s": 31.0})).await;
    no_subscription_to("tail", &mut watcher).await;
    watcher.refused(json!({"type": "unsubscribe", "view": "tail"}), "view").await;
    host.acked(json!({"type": "view", "action": "create", "name": "wing"})).await;
    watcher.subscribe("wing", "raw").await;
    host.acked(json!({"type": "scenario", "action": "seek", "at_s": 0.0})).await;
    no_subscription_to("wing", &mut watcher).await;
    watcher.acked(json!({"type": "unsubscribe", "view": "main"})).await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn no_subscription_begins_behind_the_back_of_a_removal() {
    let server = Server::start().await;
    let mut host = server.host().await;
    let mut watcher = server.watcher().await;
    for _ in 0..200 {
        host.acked(json!({"type": "view", "action": "create", "name": "tail", "size_px": [48, 24]})).await;
        let subscribe = watcher.say(json!({"type": "subscribe", "view": "tail", "format": "raw"})).await;
        let removed = host.say(json!({"type": "view", "action": "remove", "name": "tail"})).await;
        // Acknowledged or refused, as it came first or last: either way nothing is left.
        watcher.answer(subscribe).await;
        host.answer(removed).await;
        no_subscription_to("tail", &mut watcher).await;
    }
    server.stop().await;
}
