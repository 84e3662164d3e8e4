//! Our own failures: a lost device, a panic, a picture that cannot be drawn. The server says so and goes on.

use crate::executor::{Control, Trouble};
use crate::harness::{Server, guarded};
use serde_json::json;
use std::sync::Arc;
use stormdeck::plan::executor::Fault;
use stormdeck::serve::ServeError;

#[tokio::test(flavor = "multi_thread")]
async fn a_lost_device_is_replaced_while_running_free() {
    let server = Server::start().await;
    let mut host = server.host().await;
    host.subscribe("main", "raw").await;
    host.frame().await;
    for trouble in [Trouble::DeviceLost, Trouble::Panic] {
        server.control.trouble(0, trouble);
        server.control.fail_to_make(1);
        let made = server.control.made();
        host.acked(json!({"type": "ownship", "latitude_deg": 50.0, "longitude_deg": 8.0, "altitude_m": 1000.0,
            "yaw_deg": made, "pitch_deg": 0.0, "roll_deg": 0.0, "host_frame": 70 + made}))
            .await;
        host.frame_that("a frame after the loss", |frame| u64::from(frame.header.host_frame) == 70 + made).await;
        assert_eq!(server.control.made(), made + 1, "{trouble:?}");
    }
    assert_eq!(server.metric("stormdeck_executors_remade_total").await, 2.0);
    assert_eq!(server.metric("stormdeck_faults_total").await, 4.0, "two losses, two executors that could not be made");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_lost_device_loses_no_step() {
    let server = Server::start().await;
    let mut host = server.host().await;
    host.subscribe("main", "raw").await;
    let begin = host.ask(json!({"type": "step", "to_s": 10.0})).await;
    let first = begin["frames"][0]["frame"].as_u64().unwrap();
    host.frames.clear();
    server.control.trouble(2, Trouble::DeviceLost);
    server.control.trouble(5, Trouble::Panic);
    let mut steps = Vec::new();
    for step in 1..=10_u32 {
        // The sky turns with the time, so every step is drawn and none repeated.
        steps.push(host.say(json!({"type": "step", "to_s": 10.0 + 600.0 * f64::from(step)})).await);
    }
    for (step, seq) in (1..).zip(steps) {
        let stepped = guarded("a step", host.answer(seq)).await;
        assert_eq!(stepped["type"], "stepped", "{stepped}");
        let frame = host.frames.pop_front().expect("its frame").header;
        assert_eq!((frame.frame, frame.simulation_time_s), (first + step, 10.0 + 600.0 * step as f64));
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_picture_that_cannot_be_drawn_is_said_and_the_next_one_is() {
    let server = Server::start().await;
    let mut host = server.host().await;
    host.subscribe("main", "raw").await;
    host.ask(json!({"type": "step", "to_s": 10.0})).await;
    server.control.trouble(0, Trouble::Unsupported);
    let failed = host.ask(json!({"type": "step", "to_s": 1000.0})).await;
    assert_eq!(failed["type"], "refused", "{failed}");
    assert!(failed["why"].as_str().unwrap().contains("fault"), "{failed}");
    let stepped = host.ask(json!({"type": "step", "to_s": 2000.0})).await;
    assert_eq!(stepped["type"], "stepped", "{stepped}");
    assert_eq!(server.metric("stormdeck_faults_total").await, 1.0);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_view_that_always_fails_is_left_alone_and_told_while_the_others_are_drawn() {
    let server = Server::start().await;
    let mut host = server.host().await;
    server.control.reject([48, 24]);
    host.acked(json!({"type": "view", "action": "create", "name": "tail", "size_px": [48, 24]})).await;
    host.subscribe("main", "raw").await;
    host.subscribe("tail", "raw").await;
    let told = host.event("fault").await["what"].as_str().unwrap().to_owned();
    assert!(told.contains("`tail`") && told.contains("too much for the test"), "{told}");
    // The pauses double, so that the executors made grow with the logarithm of the time: 12 are those of a minute and more.
    for _ in 0..60 {
        assert_eq!(host.frame().await.header.view, "main");
    }
    assert!((2..=12).contains(&server.control.made()), "{} executors for 60 frames", server.control.made());
    let (status, _, body) = server.http("/frame.png?view=tail", "").await;
    let body = String::from_utf8_lossy(&body);
    assert!(status == 500 && body.contains("too much for the test"), "{status} {body}");
    let step = host.ask(json!({"type": "step", "to_s": 1000.0})).await;
    assert!(step["type"] == "refused" && step["why"].as_str().unwrap().contains("`tail`"), "{step}");
    // At another size it is tried at once.
    host.acked(json!({"type": "view", "action": "change", "name": "tail", "size_px": [40, 20]})).await;
    let step = host.ask(json!({"type": "step", "to_s": 2000.0})).await;
    assert_eq!((&step["type"], &step["frames"][1]["view"]), (&json!("stepped"), &json!("tail")), "{step}");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn nothing_to_draw_with_is_an_error_at_the_start() {
    let control = Arc::new(Control::default());
    control.fail_to_make(1);
    let factory = control.factory();
    let server = Server::start_on(|_| {}, control, factory).await;
    let error = server.ended().await.unwrap_err();
    assert!(matches!(error, ServeError::Executor(Fault::NoAdapter)), "{error}");
    assert!(error.to_string().contains("deploy/install-vulkan"), "it says what to install: {error}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_wrong_scenario_to_start_with_is_an_error_at_the_start() {
    let control = Arc::new(Control::default());
    let factory = control.factory();
    let server = Server::start_on(|settings| settings.scenario = Some("not-there".into()), control, factory).await;
    let error = server.ended().await.unwrap_err();
    assert!(matches!(error, ServeError::Scenario(_)), "{error}");
}
