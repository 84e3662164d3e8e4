//! Fields that change the picture: drawn by the reference executor, very small, compared as the client gets them.

use serde_json::{Value, json};
use stormdeck::frame::Pixels;
use stormdeck::plan::{Output, plan};
use stormdeck::reference::ReferenceExecutor;
use stormdeck::wire::control::{self, Message};
use stormdeck::world::World;
use stormdeck::world::snapshot::Quality;

/// One field: two conversations that differ in it alone, and when one looks.
pub struct Case {
    pub field: &'static str,
    plain: Vec<Value>,
    changed: Vec<Value>,
    at_s: f64,
}

/// What a client sees of one view: name, size, the host's frame number, pixels.
type Seen = (String, [u32; 2], u32, Vec<u8>);

/// Values of 8 bits by which some pixel has to change: more than the last bit, which dithering and rounding may move.
const VISIBLE: u8 = 3;
/// A moment of the storm at which flashes of all kinds shine.
const STORMY_S: f64 = 40.5;

#[test]
fn changing_a_field_changes_the_picture() {
    let mut executor = ReferenceExecutor::new();
    let mut idle = Vec::new();
    let mut last: Option<(Case, Vec<Seen>)> = None;
    for case in cases() {
        // Neighbours share their plain conversation.
        let kept = last.take().filter(|(before, _)| (&before.plain, before.at_s) == (&case.plain, case.at_s));
        let plain = kept.map_or_else(|| play(&mut executor, &case.plain, case.at_s), |(_, seen)| seen);
        let changed = play(&mut executor, &case.changed, case.at_s);
        if !differ(&plain, &changed) {
            idle.push((case.field, case.changed.last().unwrap().to_string()));
        }
        last = Some((case, plain));
    }
    assert!(idle.is_empty(), "these change nothing: {idle:#?}");
}

#[test]
fn equal_messages_give_equal_pictures() {
    let messages = [base("weather"), base("ownship")];
    let [a, b] = [0, 1].map(|_| play(&mut ReferenceExecutor::new(), &messages, 5.0));
    assert_eq!(a, b);
    assert!(!differ(&a, &b));
}

fn differ(a: &[Seen], b: &[Seen]) -> bool {
    let same_frame = |a: &Seen, b: &Seen| (&a.0, a.1, a.2) == (&b.0, b.1, b.2);
    let pixels = |a: &Seen, b: &Seen| a.3.iter().zip(&b.3).any(|(a, b)| a.abs_diff(*b) >= VISIBLE);
    a.len() != b.len() || a.iter().zip(b).any(|(a, b)| !same_frame(a, b) || pixels(a, b))
}

/// Messages at time 0, then the pictures at a time.
fn play(executor: &mut ReferenceExecutor, messages: &[Value], at_s: f64) -> Vec<Seen> {
    let mut world = World::new();
    let quality = Quality { slices: 8, deck_scale: 1, ring_ratio: 4.0, ..world.peek(0.0).quality };
    world.set_quality(quality);
    let small = json!({"type": "view", "action": "change", "name": "main", "size_px": [32, 18]});
    for message in std::iter::once(&small).chain(messages) {
        let decoded = control::decode(&message.to_string()).unwrap_or_else(|refused| panic!("{message}: {refused:?}"));
        let Message::Command(command) = decoded.message else { panic!("{message} changes no world") };
        world.apply(command).unwrap_or_else(|refused| panic!("{message}: {refused:?}"));
    }
    world.advance_to(at_s);
    let snapshot = world.snapshot(1.0 / 30.0);
    let frame = |view| {
        let plan = plan(&snapshot, view, Output::Srgb8);
        let Pixels::Srgb8(bytes) = executor.draw(&plan) else { panic!("a picture for a screen was asked for") };
        (view.name.clone(), plan.size_px, snapshot.host_frame, bytes)
    };
    snapshot.views.iter().map(frame).collect()
}

/// A whole message of a kind, in which every field is given.
fn base(kind: &str) -> Value {
    match kind {
        "ownship" => json!({"type": "ownship", "latitude_deg": 47.0, "longitude_deg": 8.0, "altitude_m": 1500,
            "yaw_deg": 0, "pitch_deg": 0, "roll_deg": 0, "velocity_ned_mps": [100, 50, -20], "host_frame": 7}),
        "weather" => json!({"type": "weather", "visibility_m": 30_000, "layers": [
            {"cloud_type": "cumulus", "base_m": 2000, "thickness_m": 800, "coverage": 0.5, "density": 1,
                "wind_speed_mps": 10, "wind_from_deg": 250},
            {"cloud_type": "altocumulus", "base_m": 4000, "thickness_m": 400, "coverage": 0.4}]}),
        "region" => json!({"type": "weather", "layers": [], "region": {"name": "cell", "latitude_deg": 47.0,
            "longitude_deg": 8.0, "size_east_m": 4000, "size_north_m": 2000, "corner_radius_m": 200,
            "rotation_deg": 20, "transition_m": 500}}),
        "view" => json!({"type": "view", "action": "create", "name": "second", "size_px": [32, 18],
            "field_of_view_deg": 60, "offset_m": [0, 0, 0], "yaw_deg": 0, "pitch_deg": 0, "roll_deg": 0,
            "landing_light": false, "strobe": false, "exposure_ev100": "automatic"}),
        "strike" => json!({"type": "strike", "latitude_deg": 47.05, "longitude_deg": 8.0, "altitude_m": 2000,
            "at_s": 5.0, "flash_type": "cloud_to_ground", "polarity": "negative", "peak_current_ka": 30,
            "strokes": "sample", "seed": 1}),
        "storm" => json!({"type": "storm", "name": "cell", "latitude_deg": 47.05, "longitude_deg": 8.0,
            "size_east_m": 6000, "size_north_m": 4000, "corner_radius_m": 0, "rotation_deg": 0, "altitude_m": 2000,
            "flashes_per_minute": 600, "inside_share": 0.3, "positive_share": 0, "current_factor": 1, "seed": 1}),
        other => panic!("no message is called {other}"),
    }
}

/// The message with another value at a JSON pointer; null: with the field left out.
fn with(message: &Value, pointer: &str, value: Value) -> Value {
    let mut changed = message.clone();
    let (parent, field) = pointer.rsplit_once('/').unwrap();
    let parent = changed.pointer_mut(parent).unwrap_or_else(|| panic!("{pointer} in {message}"));
    match parent {
        Value::Object(fields) if value.is_null() => {
            fields.remove(field);
        }
        Value::Object(fields) => {
            fields.insert(field.to_owned(), value);
        }
        other => other[field.parse::<usize>().unwrap()] = value,
    }
    changed
}

/// The JSON pointer of a field's path without its message: lists by their first element.
fn pointer(path: &str) -> String {
    format!("/{}", path.replace("[].", "/0/").replace('.', "/"))
}

pub fn cases() -> Vec<Case> {
    [ownship(), weather(), changes(), regions(), time(), views(), strikes(), storms()].into_iter().flatten().collect()
}

fn case(field: &'static str, before: &[Value], plain: Value, changed: Value, at_s: f64) -> Case {
    let all = |last: Value| before.iter().cloned().chain([last]).collect();
    Case { field, plain: all(plain), changed: all(changed), at_s }
}

fn ownship() -> Vec<Case> {
    let message = base("ownship");
    let before = [base("weather")];
    let one = |field: &'static str, at: &str, value: Value| {
        case(field, &before, message.clone(), with(&message, at, value), 1.0)
    };
    vec![
        one("ownship.latitude_deg", "/latitude_deg", json!(47.02)),
        one("ownship.longitude_deg", "/longitude_deg", json!(8.02)),
        one("ownship.altitude_m", "/altitude_m", json!(1300)),
        one("ownship.yaw_deg", "/yaw_deg", json!(20)),
        one("ownship.pitch_deg", "/pitch_deg", json!(10)),
        one("ownship.roll_deg", "/roll_deg", json!(15)),
        one("ownship.velocity_ned_mps", "/velocity_ned_mps/0", json!(1000)),
        one("ownship.velocity_ned_mps", "/velocity_ned_mps/1", json!(1000)),
        one("ownship.velocity_ned_mps", "/velocity_ned_mps/2", json!(300)),
        one("ownship.velocity_ned_mps", "/velocity_ned_mps", json!(null)),
        one("ownship.host_frame", "/host_frame", json!(8)),
    ]
}

fn weather() -> Vec<Case> {
    let message = base("weather");
    let one = |field: &'static str, value: Value| {
        let changed = with(&message, &pointer(field.strip_prefix("weather.").unwrap()), value);
        case(field, &[base("ownship")], message.clone(), changed, 30.0)
    };
    let mut found = vec![
        one("weather.layers", json!([])),
        one("weather.layers[].cloud_type", json!("stratus")),
        one("weather.layers[].base_m", json!(1700)),
        one("weather.layers[].thickness_m", json!(1800)),
        one("weather.layers[].coverage", json!(0.8)),
        one("weather.layers[].density", json!(0.2)),
        one("weather.layers[].wind_speed_mps", json!(40)),
        one("weather.layers[].wind_from_deg", json!(90)),
        one("weather.visibility_m", json!(3_000)),
    ];
    let eighths = with(&with(&message, "/layers/0/coverage", json!(null)), "/layers/0/coverage_eighths", json!(2));
    let more = with(&eighths, "/layers/0/coverage_eighths", json!(7));
    found.push(case("weather.layers[].coverage_eighths", &[], eighths, more, 30.0));
    let easing = with(&message, "/transition_s", json!(60));
    found.push(case("weather.transition_s", &[], easing.clone(), with(&easing, "/transition_s", json!(10)), 30.0));
    found
}

fn changes() -> Vec<Case> {
    let before = [base("ownship"), base("weather")];
    let changing = |field: &str, value: &Value| json!({"type": "weather", "changes": [{"index": 0, (field): value}]});
    let one = |field: &'static str, value: Value| {
        let idle = json!({"type": "weather", "changes": [{"index": 0}]});
        let name = field.rsplit('.').next().unwrap();
        case(field, &before, idle, changing(name, &value), 30.0)
    };
    let dense = changing("density", &json!(0.1));
    let plain = json!({"type": "weather", "visibility_m": 30_000});
    vec![
        case("weather.changes", &before, plain.clone(), with(&plain, "/changes", dense["changes"].clone()), 30.0),
        case("weather.changes[].index", &before, dense.clone(), with(&dense, "/changes/0/index", json!(1)), 30.0),
        one("weather.changes[].cloud_type", json!("stratus")),
        one("weather.changes[].base_m", json!(1700)),
        one("weather.changes[].thickness_m", json!(1800)),
        one("weather.changes[].coverage", json!(0.8)),
        one("weather.changes[].coverage_eighths", json!(8)),
        one("weather.changes[].density", json!(0.2)),
        one("weather.changes[].wind_speed_mps", json!(40)),
        one("weather.changes[].wind_from_deg", json!(90)),
    ]
}

/// A hole in an overcast below the eye.
fn regions() -> Vec<Case> {
    let above = json!({"type": "ownship", "latitude_deg": 47.0, "longitude_deg": 8.0, "altitude_m": 5000,
        "yaw_deg": 0, "pitch_deg": -90, "roll_deg": 0});
    let overcast = json!({"type": "weather", "layers": [
        {"cloud_type": "stratus", "base_m": 500, "thickness_m": 500, "coverage": 1}]});
    let before = [above.clone(), overcast.clone()];
    let hole = base("region");
    let one = |field: &'static str, value: Value| {
        let changed = with(&hole, &pointer(field.strip_prefix("weather.").unwrap()), value);
        case(field, &before, hole.clone(), changed, 1.0)
    };
    // A name says which region is meant: the same one moves, another one is made.
    let elsewhere = with(&hole, "/region/latitude_deg", json!(47.5));
    let named = [above.clone(), overcast.clone(), elsewhere.clone()];
    let second = with(&elsewhere, "/region/name", json!("other"));
    let both = [above, overcast, hole.clone(), second];
    let remove = |name, transition_s: f64| json!({"type": "remove_region", "name": name, "transition_s": transition_s});
    vec![
        case("weather.region", &before, hole.clone(), with(&hole, "/region", json!(null)), 1.0),
        case("weather.region.name", &named, elsewhere.clone(), with(&hole, "/region/name", json!("other")), 1.0),
        one("weather.region.latitude_deg", json!(47.01)),
        one("weather.region.longitude_deg", json!(8.01)),
        one("weather.region.size_east_m", json!(2000)),
        one("weather.region.size_north_m", json!(3000)),
        one("weather.region.corner_radius_m", json!(1000)),
        one("weather.region.rotation_deg", json!(80)),
        one("weather.region.transition_m", json!(3000)),
        case("remove_region.name", &both, remove("cell", 0.0), remove("other", 0.0), 1.0),
        case("remove_region.transition_s", &both, remove("cell", 10.0), remove("cell", 100.0), 5.0),
    ]
}

fn time() -> Vec<Case> {
    let before = [base("ownship"), base("weather")];
    let message = json!({"type": "time", "utc": "2026-06-21T11:30:00Z", "rate": 1});
    let one = |field, at: &str, value| case(field, &before, message.clone(), with(&message, at, value), 30.0);
    vec![one("time.utc", "/utc", json!("2026-06-21T18:30:00Z")), one("time.rate", "/rate", json!(900))]
}

fn views() -> Vec<Case> {
    let before = [base("ownship"), base("weather")];
    let made = [base("ownship"), base("weather"), base("view")];
    let mut found = Vec::new();
    for (create, change, at, value) in [
        ("view.create.size_px", "view.change.size_px", "/size_px/0", json!(40)),
        ("view.create.size_px", "view.change.size_px", "/size_px/1", json!(20)),
        ("view.create.field_of_view_deg", "view.change.field_of_view_deg", "/field_of_view_deg", json!(90)),
        ("view.create.offset_m", "view.change.offset_m", "/offset_m/0", json!(900)),
        ("view.create.offset_m", "view.change.offset_m", "/offset_m/1", json!(900)),
        ("view.create.offset_m", "view.change.offset_m", "/offset_m/2", json!(900)),
        ("view.create.yaw_deg", "view.change.yaw_deg", "/yaw_deg", json!(30)),
        ("view.create.pitch_deg", "view.change.pitch_deg", "/pitch_deg", json!(20)),
        ("view.create.roll_deg", "view.change.roll_deg", "/roll_deg", json!(30)),
        ("view.create.exposure_ev100", "view.change.exposure_ev100", "/exposure_ev100", json!(12)),
        ("view.create.name", "", "/name", json!("third")),
    ] {
        let changed = with(&base("view"), at, value);
        found.push(case(create, &before, base("view"), changed.clone(), 1.0));
        if !change.is_empty() {
            let again = |message: Value| with(&message, "/action", json!("change"));
            found.push(case(change, &made, again(base("view")), again(changed), 1.0));
        }
    }
    // Lights are seen in fog by night; at this time a strobe flashes.
    let night = json!({"type": "time", "utc": "2026-01-18T00:00:00Z"});
    let fog = json!({"type": "weather", "visibility_m": 200});
    for (create, change, at) in [
        ("view.create.landing_light", "view.change.landing_light", "/landing_light"),
        ("view.create.strobe", "view.change.strobe", "/strobe"),
    ] {
        let dark = [
            json!({"type": "ownship", "latitude_deg": 47.0, "longitude_deg": 8.0, "altitude_m": 200,
            "yaw_deg": 0, "pitch_deg": 0, "roll_deg": 0}),
            night.clone(),
            fog.clone(),
        ];
        let changed = with(&base("view"), at, json!(true));
        found.push(case(create, &dark, base("view"), changed.clone(), 1.25));
        let again = |message: Value| with(&message, "/action", json!("change"));
        let made = [&dark[..], &[base("view")]].concat();
        found.push(case(change, &made, again(base("view")), again(changed), 1.25));
    }
    let wide = |name| json!({"type": "view", "action": "change", "name": name, "field_of_view_deg": 90});
    let remove = |name| json!({"type": "view", "action": "remove", "name": name});
    found.push(case("view.change.name", &made, wide("main"), wide("second"), 1.0));
    found.push(case("view.remove.name", &made, remove("main"), remove("second"), 1.0));
    found
}

/// Where flashes are seen well.
fn overcast_night() -> [Value; 3] {
    let night = json!({"type": "time", "utc": "2026-01-18T00:00:00Z"});
    let overcast = json!({"type": "weather", "layers": [
        {"cloud_type": "stratocumulus", "base_m": 1800, "thickness_m": 1500, "coverage": 0.9}]});
    [base("ownship"), night, overcast]
}

/// A storm so fierce that there is light at any moment; looked at in one in which all of it counts.
fn storms() -> Vec<Case> {
    let before = overcast_night();
    let storm = base("storm");
    let one = |field: &'static str, at: &str, value: Value| {
        case(field, &before, storm.clone(), with(&storm, at, value), STORMY_S)
    };
    let other = with(&storm, "/name", json!("other"));
    let both: Vec<Value> = before.iter().chain([&storm, &other]).cloned().collect();
    let remove = |name| json!({"type": "remove_storm", "name": name});
    vec![
        one("storm.name", "/name", json!("other")),
        one("storm.latitude_deg", "/latitude_deg", json!(47.08)),
        one("storm.longitude_deg", "/longitude_deg", json!(8.05)),
        one("storm.size_east_m", "/size_east_m", json!(15_000)),
        one("storm.size_north_m", "/size_north_m", json!(12_000)),
        one("storm.corner_radius_m", "/corner_radius_m", json!(2_000)),
        one("storm.rotation_deg", "/rotation_deg", json!(70)),
        one("storm.altitude_m", "/altitude_m", json!(300)),
        one("storm.altitude_m", "/altitude_m", json!(null)),
        one("storm.flashes_per_minute", "/flashes_per_minute", json!(60)),
        one("storm.inside_share", "/inside_share", json!(1)),
        one("storm.positive_share", "/positive_share", json!(1)),
        one("storm.current_factor", "/current_factor", json!(4)),
        one("storm.seed", "/seed", json!(2)),
        case("remove_storm.name", &both, remove("cell"), remove("other"), STORMY_S),
    ]
}

/// A flash in an overcast night; looked at when it begins.
fn strikes() -> Vec<Case> {
    let before = overcast_night();
    let message = base("strike");
    let one = |field: &'static str, at: &str, value: Value| {
        case(field, &before, message.clone(), with(&message, at, value), 5.0)
    };
    let drawn = with(&message, "/peak_current_ka", json!(null));
    let listed = with(&drawn, "/strokes", json!([{"delay_s": 0.0, "peak_current_ka": 30}]));
    // A weak stroke, beside which a continuing current shows.
    let weak = with(&drawn, "/strokes", json!([{"delay_s": 0.0, "peak_current_ka": 1, "continuing_s": 0}]));
    let stroke = |field: &'static str, at: &str, value: Value| {
        case(field, &before, listed.clone(), with(&listed, at, value), 5.0)
    };
    let late = with(&message, "/at_s", json!(5.03));
    vec![
        one("strike.latitude_deg", "/latitude_deg", json!(47.1)),
        one("strike.longitude_deg", "/longitude_deg", json!(8.05)),
        one("strike.altitude_m", "/altitude_m", json!(300)),
        one("strike.altitude_m", "/altitude_m", json!(null)),
        one("strike.at_s", "/at_s", json!(6.0)),
        case("strike.at_s", &before, with(&message, "/at_s", json!(6.0)), with(&message, "/at_s", json!("now")), 5.0),
        one("strike.flash_type", "/flash_type", json!("intra_cloud")),
        one("strike.flash_type", "/flash_type", json!("cloud_to_cloud")),
        one("strike.polarity", "/polarity", json!("positive")),
        one("strike.peak_current_ka", "/peak_current_ka", json!(120)),
        case("strike.seed", &before, drawn.clone(), with(&drawn, "/seed", json!(2)), 5.0),
        // Much weaker than what is drawn by lot: the exposure follows a flash, and hides a little of a difference.
        case("strike.strokes", &before, drawn, weak.clone(), 5.0),
        // After the picture's interval.
        stroke("strike.strokes[].delay_s", "/strokes/0/delay_s", json!(0.2)),
        stroke("strike.strokes[].peak_current_ka", "/strokes/0/peak_current_ka", json!(90)),
        case(
            "strike.strokes[].continuing_s",
            &before,
            weak.clone(),
            with(&weak, "/strokes/0/continuing_s", json!(1.0)),
            5.0,
        ),
        // A leader takes longer than what is left of the interval, so that the stroke is not in it.
        case("strike.leader", &before, late.clone(), with(&late, "/leader", json!(true)), 5.0),
    ]
}
