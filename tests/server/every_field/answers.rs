//! Fields that change what a client is answered or sent: two conversations with a fresh server each.
//!
//! A conversation is in lockstep, so that it says the same each time it is held: each is held twice, and only a difference
//! that repetition does not make counts.

use crate::harness::{Server, Talker};
use serde_json::{Value, json};
use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};

/// One field: two conversations that differ in it alone.
pub struct Case {
    pub field: &'static str,
    plain: Vec<Value>,
    changed: Vec<Value>,
}

#[tokio::test(flavor = "multi_thread")]
async fn changing_a_field_changes_an_answer() {
    let mut idle = Vec::new();
    for case in cases() {
        let (plain, again, changed) = tokio::join!(talk(&case.plain), talk(&case.plain), talk(&case.changed));
        assert_eq!(plain, again, "{}: a conversation that cannot be repeated proves nothing", case.field);
        if plain == changed {
            idle.push((case.field, plain));
        }
    }
    assert!(idle.is_empty(), "these change no answer: {idle:#?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn every_answer_carries_the_number_of_its_message() {
    for (message, body) in numbered() {
        let server = Server::start().await;
        let mut host = server.host().await;
        for number in [4_711u64, 815] {
            let mut body = body.clone();
            body["seq"] = number.into();
            host.client.send(body.to_string()).await.unwrap();
            let answer = host.next_answer().await;
            assert_eq!(answer["seq"], number, "{message}: {answer}");
        }
        server.stop().await;
    }
}

/// Every message once, for its number; a refusal answers as well.
pub fn numbered() -> Vec<(&'static str, Value)> {
    let place = json!({"type": "strike", "latitude_deg": 47, "longitude_deg": 8, "flash_type": "intra_cloud"});
    let at = json!({"type": "ownship", "latitude_deg": 47, "longitude_deg": 8, "altitude_m": 900, "yaw_deg": 0,
        "pitch_deg": 0, "roll_deg": 0});
    vec![
        ("hello", json!({"type": "hello", "protocol": "stormdeck.v1", "role": "host"})),
        ("ownship", at),
        ("weather", json!({"type": "weather", "visibility_m": 9000})),
        ("remove_region", json!({"type": "remove_region", "name": "cell", "transition_s": 0})),
        ("time", json!({"type": "time", "rate": 1})),
        ("view.create", json!({"type": "view", "action": "create", "name": "v"})),
        ("view.change", json!({"type": "view", "action": "change", "name": "main"})),
        ("view.remove", json!({"type": "view", "action": "remove", "name": "main"})),
        ("strike", place),
        (
            "storm",
            json!({"type": "storm", "name": "cell", "latitude_deg": 47, "longitude_deg": 8, "size_east_m": 9000,
            "size_north_m": 9000}),
        ),
        ("remove_storm", json!({"type": "remove_storm", "name": "cell"})),
        ("scenario.load", json!({"type": "scenario", "action": "load", "document": document()})),
        ("scenario.play", json!({"type": "scenario", "action": "play"})),
        ("scenario.pause", json!({"type": "scenario", "action": "pause"})),
        ("scenario.seek", json!({"type": "scenario", "action": "seek", "at_s": 1})),
        ("scenario.speed", json!({"type": "scenario", "action": "speed", "factor": 2})),
        ("subscribe", json!({"type": "subscribe", "view": "main", "format": "raw"})),
        ("unsubscribe", json!({"type": "unsubscribe", "view": "main"})),
        ("step", json!({"type": "step", "to_s": 1000})),
        ("query.state", json!({"type": "query", "what": "state"})),
        ("query.plan", json!({"type": "query", "what": "plan", "view": "main"})),
        ("query.statistics", json!({"type": "query", "what": "statistics"})),
        ("query.heights", heights()),
        ("query.line_of_sight_segment", segment()),
        ("query.line_of_sight_vector", ray()),
        ("query.conditions", at_a_place("conditions", 47.0, 8.0, 1_000.0)),
    ]
}

fn document() -> Value {
    json!({"type": "scenario", "protocol": "stormdeck.v1", "name": "one", "description": "The first.", "duration_s": 60,
        "entries": [{"at": 20, "type": "weather", "visibility_m": 9000}]})
}

/// A conversation: messages, each of the client that its `client` names (0 is the host), in order. All is answered
/// before the next is said. What is said back, and what is sent in frames, without what differs from run to run.
async fn talk(messages: &[Value]) -> Vec<Value> {
    let server = Server::start_with(|settings| {
        settings.allow_take_over = true;
        settings.token = Some("correct-horse".into());
    })
    .await;
    let mut talkers: Vec<Talker> = Vec::new();
    let mut said = Vec::new();
    for message in messages {
        let mut message = message.clone();
        let client = message.as_object_mut().unwrap().remove("client").map_or(0, |c| c.as_u64().unwrap() as usize);
        while talkers.len() <= client {
            talkers.push(server.connect().await);
        }
        let talker = &mut talkers[client];
        said.push(lasting(talker.ask(message).await));
        for frame in talker.frames.drain(..) {
            let mut hasher = DefaultHasher::new();
            frame.picture.hash(&mut hasher);
            let header = &frame.header;
            said.push(json!({"view": header.view, "at_s": header.simulation_time_s, "picture": hasher.finish()}));
        }
    }
    drop(talkers);
    server.stop().await;
    said
}

/// An answer without counts and times of the wall clock.
fn lasting(mut answer: Value) -> Value {
    match &mut answer {
        Value::Object(fields) => {
            fields.retain(|name, value| {
                let changing = ["snapshot", "frame", "uptime_s", "messages", "rate_hz", "repeated", "client", "host"];
                let count = name == "frames" && value.is_number();
                !count && !changing.contains(&name.as_str())
            });
            fields.values_mut().for_each(|value| *value = lasting(value.take()));
        }
        Value::Array(items) => items.iter_mut().for_each(|item| *item = lasting(item.take())),
        _ => {}
    }
    answer
}

fn hello(client: u64, role: &str, name: &str) -> Value {
    json!({"client": client, "type": "hello", "protocol": "stormdeck.v1", "role": role, "name": name,
        "token": "correct-horse"})
}

/// With another value of one field.
fn with(message: &Value, field: &str, value: Value) -> Value {
    let mut changed = message.clone();
    changed[field] = value;
    changed
}

pub fn cases() -> Vec<Case> {
    [sessions(), pictures(), questions(), scenarios()].into_iter().flatten().collect()
}

/// A case whose conversations have the same beginning and end around the message that differs.
fn case(field: &'static str, before: &[Value], plain: Value, changed: Value, after: &[Value]) -> Case {
    let all = |middle: Value| before.iter().cloned().chain([middle]).chain(after.iter().cloned()).collect();
    Case { field, plain: all(plain), changed: all(changed) }
}

fn sessions() -> Vec<Case> {
    let first = hello(0, "host", "first");
    let second = hello(1, "host", "second");
    let edit = json!({"client": 1, "type": "weather", "visibility_m": 9000});
    let watching = hello(1, "watcher", "second");
    vec![
        case("hello.protocol", &[], first.clone(), with(&first, "protocol", json!("stormdeck.v2")), &[]),
        case("hello.role", &[], first.clone(), with(&first, "role", json!("watcher")), &[]),
        // A name is told to those who are refused because of its bearer.
        case("hello.name", &[], first.clone(), with(&first, "name", json!("other")), &[watching, edit]),
        case(
            "hello.take_over",
            std::slice::from_ref(&first),
            second.clone(),
            with(&second, "take_over", json!(true)),
            &[],
        ),
        case("hello.token", &[], first.clone(), with(&first, "token", json!("wrong-horse")), &[]),
    ]
}

/// The host in lockstep, with two small views of different size.
fn stepping() -> Vec<Value> {
    vec![
        hello(0, "host", "host"),
        json!({"type": "step", "to_s": 1000}),
        json!({"type": "time", "rate": 0}),
        json!({"type": "view", "action": "change", "name": "main", "size_px": [32, 16]}),
        json!({"type": "view", "action": "create", "name": "tail", "size_px": [16, 32]}),
    ]
}

fn pictures() -> Vec<Case> {
    let before = stepping();
    let step = json!({"type": "step", "to_s": 1010});
    let wish = json!({"type": "subscribe", "view": "main", "format": "jpeg", "quality": 90});
    let raw = json!({"type": "subscribe", "view": "main", "format": "raw"});
    let one = |field, changed: Value| case(field, &before, wish.clone(), changed, std::slice::from_ref(&step));
    let both: Vec<Value> = before.iter().cloned().chain([wish.clone(), with(&raw, "view", json!("tail"))]).collect();
    let leave = json!({"type": "unsubscribe", "view": "main"});
    vec![
        one("subscribe.view", with(&wish, "view", json!("tail"))),
        one("subscribe.quality", with(&wish, "quality", json!(20))),
        case("subscribe.format", &before, raw.clone(), with(&raw, "format", json!("png")), std::slice::from_ref(&step)),
        case(
            "unsubscribe.view",
            &both,
            leave.clone(),
            with(&leave, "view", json!("tail")),
            std::slice::from_ref(&step),
        ),
        case("step.to_s", &before, step.clone(), with(&step, "to_s", json!(1020)), &[]),
    ]
}

fn at_a_place(what: &str, latitude_deg: f64, longitude_deg: f64, altitude_m: f64) -> Value {
    json!({"type": "query", "what": what, "latitude_deg": latitude_deg, "longitude_deg": longitude_deg,
        "altitude_m": altitude_m})
}

fn heights() -> Value {
    at_a_place("heights", 47.0, 8.0, 900.0)
}

/// From above a closed deck of stratus down to the ground.
fn segment() -> Value {
    json!({"type": "query", "what": "line_of_sight_segment",
        "from": {"latitude_deg": 47.0, "longitude_deg": 8.0, "altitude_m": 3000.0},
        "to": {"latitude_deg": 47.01, "longitude_deg": 8.01, "altitude_m": -100.0}})
}

/// The same as a ray.
fn ray() -> Value {
    json!({"type": "query", "what": "line_of_sight_vector", "azimuth_deg": 30, "elevation_deg": -60, "maximum_m": 9000,
        "from": {"latitude_deg": 47.0, "longitude_deg": 8.0, "altitude_m": 3000.0}})
}

fn questions() -> Vec<Case> {
    let plan = json!({"type": "query", "what": "plan", "view": "main"});
    let strike = |east_m: f64| {
        json!({"type": "strike", "latitude_deg": 47, "longitude_deg": 8, "flash_type": "cloud_to_ground",
            "strokes": [{"delay_s": 0, "peak_current_ka": 20, "ground_point_m": [east_m, 0]}]})
    };
    let state = [json!({"type": "query", "what": "state"})];
    let mut cases = vec![
        case("query.plan.view", &stepping(), plan.clone(), with(&plan, "view", json!("tail")), &[]),
        case("strike.strokes[].ground_point_m", &stepping(), strike(0.0), strike(900.0), &state),
    ];
    let layer = json!({"cloud_type": "stratus", "base_m": 800, "thickness_m": 500, "coverage": 1});
    let overcast = [
        hello(0, "host", "host"),
        json!({"type": "step", "to_s": 1000}),
        json!({"type": "weather", "layers": [layer], "visibility_m": 20000}),
        // Hazier around the place that is asked for.
        json!({"type": "weather", "visibility_m": 2000, "region": {"name": "haze", "latitude_deg": 47, "longitude_deg": 8,
            "size_east_m": 20000, "size_north_m": 20000}}),
    ];
    let mut one = |field, plain: Value, path: &str, value: Value| {
        let mut changed = plain.clone();
        // A field that was left out is put in.
        match plain.pointer(path) {
            Some(_) => *changed.pointer_mut(path).unwrap() = value,
            None => changed[&path[1..]] = value,
        }
        cases.push(case(field, &overcast, plain, changed, &[]));
    };
    one("query.heights.latitude_deg", heights(), "/latitude_deg", json!(46.5));
    one("query.heights.longitude_deg", heights(), "/longitude_deg", json!(8.5));
    one("query.heights.altitude_m", heights(), "/altitude_m", json!(901));
    // Without cloud the line ends at the ground.
    let mut down = segment();
    down["cloud"] = json!(false);
    let elsewhere = json!({"latitude_deg": 47.2, "longitude_deg": 8.2, "altitude_m": 2500});
    one("query.line_of_sight_segment.from", down.clone(), "/from", elsewhere.clone());
    one("query.line_of_sight_segment.to", down.clone(), "/to", elsewhere.clone());
    one("query.line_of_sight_segment.from.latitude_deg", down.clone(), "/from/latitude_deg", json!(47.1));
    one("query.line_of_sight_segment.from.longitude_deg", down.clone(), "/from/longitude_deg", json!(8.1));
    one("query.line_of_sight_segment.from.altitude_m", down.clone(), "/from/altitude_m", json!(2900));
    one("query.line_of_sight_segment.to.latitude_deg", down.clone(), "/to/latitude_deg", json!(47.1));
    one("query.line_of_sight_segment.to.longitude_deg", down.clone(), "/to/longitude_deg", json!(8.1));
    one("query.line_of_sight_segment.to.altitude_m", down.clone(), "/to/altitude_m", json!(-200));
    one("query.line_of_sight_segment.ground", down, "/ground", json!(false));
    one("query.line_of_sight_segment.cloud", segment(), "/cloud", json!(false));
    one("query.line_of_sight_segment.cloud_opacity", segment(), "/cloud_opacity", json!(0.9));
    let mut down = ray();
    down["cloud"] = json!(false);
    one("query.line_of_sight_vector.from", down.clone(), "/from", elsewhere);
    one("query.line_of_sight_vector.from.latitude_deg", down.clone(), "/from/latitude_deg", json!(47.1));
    one("query.line_of_sight_vector.from.longitude_deg", down.clone(), "/from/longitude_deg", json!(8.1));
    one("query.line_of_sight_vector.from.altitude_m", down.clone(), "/from/altitude_m", json!(2900));
    one("query.line_of_sight_vector.azimuth_deg", down.clone(), "/azimuth_deg", json!(40));
    one("query.line_of_sight_vector.elevation_deg", down.clone(), "/elevation_deg", json!(-70));
    one("query.line_of_sight_vector.minimum_m", down.clone(), "/minimum_m", json!(5000));
    one("query.line_of_sight_vector.maximum_m", down.clone(), "/maximum_m", json!(1000));
    one("query.line_of_sight_vector.ground", down, "/ground", json!(false));
    one("query.line_of_sight_vector.cloud", ray(), "/cloud", json!(false));
    one("query.line_of_sight_vector.cloud_opacity", ray(), "/cloud_opacity", json!(0.9));
    let there = at_a_place("conditions", 47.0, 8.0, 300.0);
    one("query.conditions.latitude_deg", there.clone(), "/latitude_deg", json!(48));
    one("query.conditions.longitude_deg", there.clone(), "/longitude_deg", json!(9.5));
    one("query.conditions.altitude_m", there, "/altitude_m", json!(500));
    cases
}

fn scenarios() -> Vec<Case> {
    let host = [hello(0, "host", "host")];
    let step = json!({"type": "step", "to_s": 30});
    let state = json!({"type": "query", "what": "state"});
    let after = [step, state.clone()];
    let load = json!({"type": "scenario", "action": "load", "document": document()});
    let document_case = |field: &'static str, changed: Value| {
        case(field, &host, load.clone(), with(&load, "document", changed), &after)
    };
    let field = |name: &str, value| with(&document(), name, value);
    let mut later = document();
    later["entries"][0]["at"] = json!(40);
    let named = |name| json!({"type": "scenario", "action": "load", "name": name});
    let stopped = [host[0].clone(), load.clone(), json!({"type": "step", "to_s": 10})];
    let seek = |at_s: f64| json!({"type": "scenario", "action": "seek", "at_s": at_s});
    let speed = |factor: f64| json!({"type": "scenario", "action": "speed", "factor": factor});
    vec![
        case("scenario.load.name", &host, named("clear-day"), named("night-storm"), &after),
        document_case(
            "scenario.load.document",
            json!({"type": "scenario", "protocol": "stormdeck.v1", "name": "one",
            "description": "The first.", "duration_s": 60, "entries": []}),
        ),
        document_case("scenario.load.document.name", field("name", json!("two"))),
        document_case("scenario.load.document.description", field("description", json!("The second."))),
        document_case("scenario.load.document.duration_s", field("duration_s", json!(50))),
        document_case("scenario.load.document.entries", later),
        case("scenario.seek.at_s", &stopped, seek(25.0), seek(15.0), std::slice::from_ref(&state)),
        case("scenario.speed.factor", &stopped, speed(2.0), speed(3.0), std::slice::from_ref(&state)),
    ]
}
