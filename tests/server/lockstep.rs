//! Lockstep: one frame of each view for each step, in order, none lost, none dropped, whoever watches.

use crate::harness::{GUARD, Server};
use serde_json::json;
use stormdeck::wire::limits;

#[tokio::test(flavor = "multi_thread")]
async fn a_step_gives_one_frame_of_each_view_and_then_its_answer() {
    let server = Server::start().await;
    let mut host = server.host().await;
    host.acked(json!({"type": "view", "action": "create", "name": "tail", "size_px": [48, 24]})).await;
    let mut watcher = server.watcher().await;
    let begin = host.ask(json!({"type": "step", "to_s": 1000.0})).await;
    assert_eq!((&begin["type"], &begin["simulation_time_s"]), (&json!("stepped"), &json!(1000.0)), "{begin}");
    assert_eq!(begin["frames"].as_array().unwrap().len(), 2, "also of views that nobody watches: {begin}");
    host.subscribe("main", "raw").await;
    watcher.subscribe("main", "jpeg").await;
    watcher.subscribe("tail", "raw").await;
    let first = begin["frames"][0]["frame"].as_u64().unwrap();
    for step in 1..=20 {
        let to_s = 1000.0 + f64::from(step) * 0.1;
        let stepped = host.ask(json!({"type": "step", "to_s": to_s})).await;
        let frames = stepped["frames"].as_array().unwrap();
        assert_eq!(frames.len(), 2, "{stepped}");
        assert_eq!((&frames[0]["view"], &frames[0]["frame"]), (&json!("main"), &json!(first + step as u64)));
        assert_eq!((&frames[0]["copies"], &frames[0]["formats"]), (&json!(2), &json!(["raw", "jpeg"])), "{stepped}");
        assert_eq!((&frames[1]["view"], &frames[1]["copies"]), (&json!("tail"), &json!(1)));
        // The host's copy had been written before the answer: it is here already.
        let mine = host.frames.pop_front().expect("the frame before the answer").header;
        assert_eq!((mine.frame, mine.simulation_time_s), (first + step as u64, to_s));
        assert!(host.frames.is_empty(), "exactly one");
    }
    let mut tail = Vec::new();
    while tail.len() < 20 {
        let frame = watcher.frame().await.header;
        if frame.view == "tail" {
            tail.push(frame.simulation_time_s);
        }
    }
    assert!(tail.windows(2).all(|pair| pair[1] > pair[0]), "{tail:?}");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn steps_queue_in_order_within_a_limit_and_none_is_lost() {
    let server = Server::start().await;
    let mut host = server.host().await;
    host.subscribe("main", "raw").await;
    host.ask(json!({"type": "step", "to_s": 100.0})).await;
    host.frames.clear();
    server.control.hold();
    let mut waiting = Vec::new();
    for step in 0..limits::STEPS_WAITING {
        let to_s = 101.0 + step as f64;
        waiting.push((host.say(json!({"type": "step", "to_s": to_s})).await, to_s));
        // Commands between steps belong to the step that follows them.
        host.say(json!({"type": "ownship", "latitude_deg": 50.0, "longitude_deg": 8.0, "altitude_m": 1000.0,
            "yaw_deg": 0.0, "pitch_deg": 0.0, "roll_deg": 0.0, "host_frame": step}))
            .await;
    }
    let over = host.refused(json!({"type": "step", "to_s": 5000.0}), "to_s").await;
    assert!(over["limit"].as_str().unwrap().contains("steps"), "{over}");
    server.control.release();
    for (index, (seq, to_s)) in waiting.into_iter().enumerate() {
        let stepped = tokio::time::timeout(GUARD, host.answer(seq)).await.unwrap();
        assert_eq!((&stepped["type"], &stepped["simulation_time_s"]), (&json!("stepped"), &json!(to_s)));
        let frame = host.frames.pop_front().expect("its frame came before").header;
        assert_eq!(frame.simulation_time_s, to_s);
        assert_eq!(frame.host_frame as usize, index.saturating_sub(1), "the ownship message before it");
    }
    let state = host.ask(json!({"type": "query", "what": "state"})).await;
    assert_eq!(state["simulation_time_s"], 100.0 + limits::STEPS_WAITING as f64, "the refused step moved nothing");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_free_clock_stops_until_play() {
    let server = Server::start().await;
    let mut host = server.host().await;
    host.ask(json!({"type": "step", "to_s": 50.0})).await;
    host.refused(json!({"type": "step", "to_s": 49.0}), "to_s").await;
    let mut watcher = server.watcher().await;
    watcher.subscribe("main", "raw").await;
    let stepped = host.ask(json!({"type": "step", "to_s": 50.0})).await;
    assert_eq!(stepped["type"], "stepped", "the same time once more is a frame, too");
    let first = watcher.frame().await.header;
    host.ask(json!({"type": "step", "to_s": 51.0})).await;
    let second = watcher.frame().await.header;
    assert_eq!((first.simulation_time_s, second.simulation_time_s), (50.0, 51.0));
    assert_eq!(second.frame, first.frame + 1, "nothing is drawn between steps");
    let player = host.ask(json!({"type": "query", "what": "state"})).await["player"].clone();
    assert_eq!(player["playing"], false, "{player}");
    host.acked(json!({"type": "scenario", "action": "play"})).await;
    let free = watcher.frame_that("time that runs", |frame| frame.header.simulation_time_s > 51.0).await;
    assert!(free.header.frame > second.frame);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_step_beyond_the_scenarios_end_is_refused() {
    let server = Server::start().await;
    let mut host = server.host().await;
    let short =
        json!({"type": "scenario", "protocol": "stormdeck.v1", "name": "short", "duration_s": 60, "entries": []});
    host.acked(json!({"type": "scenario", "action": "load", "document": short})).await;
    let at_end = host.ask(json!({"type": "step", "to_s": 60.0})).await;
    assert_eq!((&at_end["type"], &at_end["simulation_time_s"]), (&json!("stepped"), &json!(60.0)), "{at_end}");
    // The time stops at the end: a step beyond it would be answered with a time that no picture shows.
    host.refused(json!({"type": "step", "to_s": 60.5}), "to_s").await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_picture_over_http_is_that_of_the_last_step() {
    let server = Server::start().await;
    let mut host = server.host().await;
    let stepped = host.ask(json!({"type": "step", "to_s": 50.0})).await;
    let number = stepped["frames"][0]["frame"].as_u64().unwrap();
    for _ in 0..2 {
        let (status, head, _) = server.http("/frame.png?view=main", "").await;
        assert_eq!(status, 200);
        assert!(head.contains(&format!("stormdeck-frame: {number}\r\n")), "{head}");
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_watcher_that_never_reads_is_disconnected_and_the_step_answered() {
    let server = Server::start_with(|settings| settings.slow_client_s = 0.5).await;
    let mut host = server.host().await;
    host.acked(json!({"type": "view", "action": "change", "name": "main", "size_px": [2048, 2048]})).await;
    let mut stuck = server.watcher().await;
    stuck.subscribe("main", "raw").await;
    // 16 MiB a frame: no buffer of the system takes them all.
    for step in 0..4 {
        let stepped = host.ask(json!({"type": "step", "to_s": 100.0 + f64::from(step)})).await;
        assert_eq!(stepped["type"], "stepped", "{stepped}");
    }
    server.until_metric("stormdeck_disconnected_total", |count| count == 1.0).await;
    host.subscribe("main", "jpeg").await;
    host.ask(json!({"type": "step", "to_s": 200.0})).await;
    assert_eq!(host.frames.len(), 1);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn one_picture_is_encoded_once_however_many_watch() {
    let server = Server::start().await;
    let mut host = server.host().await;
    let mut watchers = Vec::new();
    for _ in 0..6 {
        let mut watcher = server.watcher().await;
        watcher.subscribe("main", "jpeg").await;
        watchers.push(watcher);
    }
    host.ask(json!({"type": "step", "to_s": 50.0})).await;
    let before = server.metric("stormdeck_encodings_total").await;
    let mut drawn = 0;
    for step in 1..=5 {
        let stepped = host.ask(json!({"type": "step", "to_s": 50.0 + f64::from(step)})).await;
        assert_eq!(stepped["frames"][0]["copies"], 6, "{stepped}");
    }
    for watcher in &mut watchers {
        watcher.frame_that("the last step", |frame| frame.header.simulation_time_s == 55.0).await;
    }
    drawn += 5;
    let encoded = server.metric("stormdeck_encodings_total").await - before;
    assert!(encoded <= f64::from(drawn), "{encoded} encodings of {drawn} pictures");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn pictures_that_nobody_reads_fill_no_memory_and_none_is_lost() {
    let server = Server::start_with(|settings| {
        settings.step_memory_mib = 16;
        settings.slow_client_s = 600.0;
    })
    .await;
    let mut host = server.host().await;
    // Pixels and copy of one step are 8 MiB together: two steps fill the memory allowed, and the buffers of the system
    // between server and watcher take one or two more.
    host.acked(json!({"type": "view", "action": "change", "name": "main", "size_px": [1024, 1024]})).await;
    let mut stuck = server.watcher().await;
    host.ask(json!({"type": "step", "to_s": 100.0})).await;
    stuck.subscribe("main", "raw").await;
    const STEPS: u32 = 40;
    let times: Vec<f64> = (1..=STEPS).map(|step| 100.0 + 600.0 * f64::from(step)).collect();
    let mut steps = Vec::new();
    for to_s in &times {
        steps.push(host.say(json!({"type": "step", "to_s": to_s})).await);
    }
    server.until_metric("stormdeck_step_bytes", |bytes| bytes == f64::from(16 << 20)).await;
    for _ in 0..30 {
        let held = server.metric("stormdeck_step_bytes").await;
        assert!(held <= f64::from(16 << 20), "{held} bytes are held");
    }
    assert!(server.control.submitted() < u64::from(STEPS) / 2, "{} drawn", server.control.submitted());
    for to_s in times {
        assert_eq!(stuck.frame().await.header.simulation_time_s, to_s);
    }
    for seq in steps {
        let stepped = tokio::time::timeout(GUARD, host.answer(seq)).await.unwrap();
        assert_eq!((&stepped["type"], &stepped["frames"][0]["copies"]), (&json!("stepped"), &json!(1)), "{stepped}");
    }
    assert_eq!(server.metric("stormdeck_step_bytes").await, 0.0);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn one_step_that_is_larger_than_the_memory_allowed_is_drawn_all_the_same() {
    let server = Server::start_with(|settings| settings.step_memory_mib = 0).await;
    let mut host = server.host().await;
    host.subscribe("main", "raw").await;
    for step in 0..3 {
        let stepped = host.ask(json!({"type": "step", "to_s": 100.0 + f64::from(step)})).await;
        assert_eq!(stepped["type"], "stepped", "{stepped}");
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_free_clock_runs_again_when_the_host_that_stepped_is_gone() {
    let server = Server::start_with(|settings| settings.allow_take_over = true).await;
    let mut watcher = server.watcher().await;
    let mut last_s = 0.0;
    for how in ["goodbye", "vanishes", "steps back", "taken over"] {
        let mut host = server.host().await;
        last_s += 1000.0;
        let stepped = host.ask(json!({"type": "step", "to_s": last_s})).await;
        assert_eq!(stepped["type"], "stepped", "{how}: {stepped}");
        let state = watcher.ask(json!({"type": "query", "what": "state"})).await;
        assert_eq!(
            (&state["simulation_time_s"], &state["player"]["playing"]),
            (&json!(last_s), &json!(false)),
            "{how}"
        );
        watcher.subscribe("main", "raw").await;
        let mut next = None;
        match how {
            "goodbye" => host.client.close().await,
            "vanishes" => drop(host),
            "steps back" => drop(host.hello(json!({"role": "watcher"})).await),
            _ => {
                let mut taker = server.connect().await;
                taker.hello(json!({"role": "host", "take_over": true})).await;
                next = Some((taker, host));
            }
        }
        let free = watcher.frame_that(how, |frame| frame.header.simulation_time_s > last_s).await;
        assert!(free.header.simulation_time_s < last_s + 1000.0, "{how}");
        watcher.acked(json!({"type": "unsubscribe", "view": "main"})).await;
        watcher.frames.clear();
        drop(next);
        server.until_metric("stormdeck_hosts", |hosts| hosts == 0.0).await;
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn steps_that_wait_are_drawn_in_order_before_the_free_run_that_follows_their_host() {
    let server = Server::start().await;
    let mut host = server.host().await;
    host.ask(json!({"type": "step", "to_s": 100.0})).await;
    let mut watcher = server.watcher().await;
    watcher.subscribe("main", "raw").await;
    server.control.hold();
    for step in 1..=10_u32 {
        host.say(json!({"type": "step", "to_s": 100.0 + 600.0 * f64::from(step)})).await;
    }
    server.until_metric("stormdeck_steps_waiting", |waiting| waiting == 10.0).await;
    host.client.close().await;
    watcher.event("host_free").await;
    server.control.release();
    for step in 1..=10_u32 {
        assert_eq!(watcher.frame().await.header.simulation_time_s, 100.0 + 600.0 * f64::from(step));
    }
    watcher.frame_that("the free run", |frame| frame.header.simulation_time_s > 6100.0).await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_world_that_was_paused_is_still_paused_when_the_host_that_stepped_is_gone() {
    let server = Server::start().await;
    let mut host = server.host().await;
    host.acked(json!({"type": "scenario", "action": "pause"})).await;
    host.ask(json!({"type": "step", "to_s": 100.0})).await;
    let mut watcher = server.watcher().await;
    watcher.subscribe("main", "raw").await;
    host.client.close().await;
    for _ in 0..3 {
        assert_eq!(watcher.frame().await.header.simulation_time_s, 100.0);
    }
    server.stop().await;
}
