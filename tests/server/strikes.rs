//! Strikes: the answer names the flash, an event names the first frame that shows it, or says that none did.

use crate::harness::Server;
use serde_json::{Value, json};

fn strike(more: Value) -> Value {
    let mut message = json!({"type": "strike", "latitude_deg": 47.1, "longitude_deg": 8.1,
        "flash_type": "cloud_to_ground", "peak_current_ka": 30.0, "seed": 5});
    if let (Some(message), Some(more)) = (message.as_object_mut(), more.as_object()) {
        message.extend(more.clone());
    }
    message
}

#[tokio::test(flavor = "multi_thread")]
async fn the_event_names_the_first_frame_that_shows_it() {
    let server = Server::start().await;
    let mut host = server.host().await;
    let mut watcher = server.watcher().await;
    host.ask(json!({"type": "step", "to_s": 10.0})).await;
    host.subscribe("main", "raw").await;
    let flash = host.acked(strike(json!({}))).await["flash"].clone();
    assert!(flash.is_u64(), "{flash}");
    let stepped = host.ask(json!({"type": "step", "to_s": 10.1})).await;
    let shown = host.event("strike_shown").await;
    assert_eq!((&shown["flash"], &shown["view"]), (&flash, &json!("main")));
    assert_eq!(shown["frame"], stepped["frames"][0]["frame"]);
    assert_eq!(shown["simulation_time_s"], 10.1);
    assert_eq!(watcher.event("strike_shown").await["flash"], flash, "watchers are told, too");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn thunder_is_told_with_the_times_of_its_pieces() {
    let server = Server::start().await;
    let mut host = server.host().await;
    host.ask(json!({"type": "step", "to_s": 10.0})).await;
    let at = json!({"type": "ownship", "latitude_deg": 47.1, "longitude_deg": 8.12, "altitude_m": 2.0, "yaw_deg": 0,
        "pitch_deg": 0, "roll_deg": 0});
    host.acked(at).await;
    let flash = host.acked(strike(json!({"at_s": 10.05}))).await["flash"].clone();
    // Beyond hearing: 111 km away.
    host.acked(strike(json!({"at_s": 10.05, "latitude_deg": 48.1}))).await;
    host.ask(json!({"type": "step", "to_s": 10.1})).await;
    let thunder = host.event("thunder").await;
    assert_eq!((&thunder["flash"], &thunder["longitude_deg"]), (&flash, &json!(8.12)));
    let pieces = thunder["pieces"].as_array().unwrap();
    assert!((2..=24).contains(&pieces.len()), "{pieces:?}");
    let number = |piece: &Value, field: &str| piece[field].as_f64().unwrap();
    assert!(pieces.windows(2).all(|pair| number(&pair[0], "at_s") < number(&pair[1], "at_s")));
    // The ground point is 1518 m to the west; the channel above it bends towards the listener and away by some hundred metres.
    let first = &pieces[0];
    let after_s = number(first, "at_s") - 10.05;
    assert!((2.5..5.0).contains(&after_s), "{first}");
    for piece in pieces {
        assert!((60.0..150.0).contains(&number(piece, "level_db")), "{piece}");
        assert!((1_000.0..25_000.0).contains(&number(piece, "distance_m")), "{piece}");
        assert!(number(piece, "at_s") <= number(&thunder, "end_s"));
    }
    // Thunder is told in the order of the flashes: the next is that of a third, near one.
    let third = host.acked(strike(json!({"at_s": 10.15}))).await["flash"].clone();
    host.ask(json!({"type": "step", "to_s": 10.2})).await;
    assert_eq!(host.event("thunder").await["flash"], third, "the far one is not heard");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn while_running_free_as_well() {
    let server = Server::start().await;
    let mut host = server.host().await;
    host.subscribe("main", "raw").await;
    host.frame().await;
    let flash = host.acked(strike(json!({"at_s": "now"}))).await["flash"].clone();
    let shown = host.event("strike_shown").await;
    assert_eq!(shown["flash"], flash);
    let number = shown["frame"].as_u64().unwrap();
    // The event stands before the frame in the queue.
    let frame = host.frame_that("the frame named", |frame| frame.header.frame >= number).await;
    assert_eq!(frame.header.frame, number);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_flash_that_nobody_could_see_is_reported_as_missed() {
    let server = Server::start().await;
    let mut host = server.host().await;
    let now_s = host.ask(json!({"type": "query", "what": "state"})).await["simulation_time_s"].as_f64().unwrap();
    let flash = host.acked(strike(json!({"at_s": now_s + 0.5}))).await["flash"].clone();
    let missed = host.event("strike_missed").await;
    assert_eq!(missed["flash"], flash, "no view was drawn while it shone");
    server.stop().await;
}
