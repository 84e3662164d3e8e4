//! What the settings pin: defaults, every complaint at once, the token rule, the scenarios inside the binary.

use super::file::defaults;
use super::*;
use crate::wire::control::out::SkyOut;
use crate::wire::json::Rule;
use crate::wire::json::parse;
use crate::wire::scenario;
use crate::wire::{limits, schema};
use crate::world::World;
use crate::world::command::{Command, ScenarioEdit};
use std::sync::Arc;

fn paths(text: &str) -> Vec<String> {
    Settings::parse(text).expect_err(text).into_iter().map(|complaint| complaint.path).collect()
}

#[test]
fn the_defaults_are_the_file_and_nothing_given_means_the_defaults() {
    let file = Settings::parse(DEFAULT_TEXT);
    assert_eq!(Settings::parse("{}"), file);
    assert_eq!(file, Ok(Settings::default()));
    let given = defaults();
    let schema = file_schema();
    let fields = schema["properties"].as_object().expect("fields");
    assert_eq!(given.keys().collect::<Vec<_>>(), fields.keys().collect::<Vec<_>>(), "each field has its default");
}

#[test]
fn the_committed_schema_of_the_settings_is_current_and_can_be_checked_by() {
    let schema = file_schema();
    crate::wire::schema::committed("config/settings.schema.json", &schema);
    assert_eq!(Rule::from_schema(&schema).err(), None);
}

#[test]
fn each_field_reaches_the_settings() {
    let mut other = serde_json::json!({
        "listen": "[::1]:9000", "token": "correct-horse", "allowed_origins": ["https://example.org:8443"],
        "allow_take_over": true, "max_clients": 3, "executor": "reference", "frame_rate_hz": 59.5, "shutter_s": 0.01, "slices": 7, "deck_scale": 3, "deck_form": "instanced",
        "light_encoding": "harmonics", "relight": "single", "flicker_guard_per_s": 3, "terrain": "procedural", "terrain_file": "N47E008.hgt", "terrain_sea_level_m": 48,
        "ring_ratio": 1.55, "jpeg_quality": 1, "scenario": null, "scenario_folder": "elsewhere", "queue_frames": 5,
        "queue_commands": 99, "step_memory_mib": 77, "slow_client_s": 2.5, "log": "stormdeck=debug",
        "cigi_listen": "127.0.0.1:8004", "cigi_host": null, "cigi_reply_port": null, "cigi_allow": [], "cigi_multicast": null,
        "cigi_synchronous": true, "cigi_byte_order": "big", "cigi_rate_hz": 50, "cigi_silence_s": 1,
        "cigi_host_chooses_database": true, "cigi_sea_level_m": 40, "cigi_seed": 2, "cigi_size_px": [800, 600]
    });
    // The macro takes no more.
    other["basis_memory_mib"] = 99.into();
    other["basis_cache"] = "tables".into();
    other["basis_cache_mib"] = 99.into();
    let fields = other.as_object().expect("an object");
    assert_eq!(fields.len(), defaults().len(), "each field is tried");
    // Those of the CIGI port are tried beside it: without an address to listen on they say nothing.
    for (name, value) in fields.iter().filter(|(name, _)| !name.starts_with("cigi_") || *name == "cigi_listen") {
        let text = serde_json::json!({ (name): value }).to_string();
        let settings = Settings::parse(&text).expect(&text);
        assert_ne!(settings, Settings::default(), "{name}");
    }
}

#[test]
fn every_problem_is_told_at_once_with_its_path_and_line() {
    let text = "{\n \"listen\": \"nowhere\",\n \"slices\": 0,\n \"colour\": 1,\n \"executor\": \"magic\",\n \
                \"frame_rate_hz\": 61,\n \"allowed_origins\": [\"https://a.b\", \"a.b/c\"],\n \"log\": 5,\n \"slices\": 3\n}";
    let complaints = Settings::parse(text).expect_err("much is wrong");
    let places: Vec<_> = complaints.iter().map(|c| (c.path.as_str(), c.line)).collect();
    assert_eq!(
        places,
        [
            ("listen", 2),
            ("slices", 3),
            ("colour", 4),
            ("executor", 5),
            ("frame_rate_hz", 6),
            ("allowed_origins[1]", 7),
            ("log", 8),
            ("slices", 9)
        ]
    );
    assert_eq!(
        complaints[1].to_string(),
        "line 3, column 12: slices: out of range: Slices per cloud layer (found 0; allowed: a whole number, 1 to 512)"
    );
}

#[test]
fn both_ends_of_every_range_hold() {
    let schema = file_schema();
    let fields = schema["properties"].as_object().expect("fields");
    let mut tried = 0;
    for (name, field) in fields {
        let (Some(min), Some(max)) = (field["minimum"].as_f64(), field["maximum"].as_f64()) else { continue };
        for (value, good) in [(min, true), (max, true), (min - 1.0, false), (max + 1.0, false)] {
            let text = format!("{{\"{name}\": {value}}}");
            assert_eq!(Settings::parse(&text).is_ok(), good, "{text}");
        }
        tried += 1;
    }
    assert!(tried >= 9, "only {tried} fields with a range were tried");
}

#[test]
fn beyond_this_machine_a_token_is_needed() {
    assert_eq!(paths(r#"{"listen": "0.0.0.0:80"}"#), ["token"]);
    assert_eq!(paths(r#"{"listen": "[::]:80"}"#), ["token"]);
    assert_eq!(paths(r#"{"listen": "192.168.1.4:80", "token": "short"}"#), ["token"]);
    assert!(Settings::parse(r#"{"listen": "0.0.0.0:80", "token": "correct-horse"}"#).is_ok());
    assert!(Settings::parse(r#"{"listen": "127.0.0.2:80"}"#).is_ok());
}

#[test]
fn what_is_no_settings_file_is_told() {
    for text in ["", "[]", "null", "{", "{\"listen\": 1e999}", "{} {}"] {
        assert!(!paths(text).is_empty(), "{text}");
    }
    assert_eq!(paths(&" ".repeat(limits::SETTINGS_BYTES + 1)), [""]);
}

#[test]
fn the_start_scenario_is_inside_the_binary_and_no_name_leaves_the_folder() {
    let settings = Settings { scenario_folder: "no/such/folder".into(), ..Settings::default() };
    let name = settings.scenario.clone().expect("a start scenario");
    assert_eq!(settings.timeline(&name).map(|timeline| timeline.name), Ok(name));
    for bad in ["", "..", "../default", "a/b", "A", "nothing-of-this-name"] {
        assert_eq!(settings.timeline(bad).map_err(|refused| refused.field), Err("name".to_owned()), "{bad}");
    }
}

#[test]
fn the_folder_and_the_binary_have_the_same_scenarios_and_each_has_the_name_of_its_file() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("config/scenarios");
    let mut found: Vec<String> = std::fs::read_dir(folder)
        .expect("the folder of the repository")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().trim_end_matches(".json").to_owned())
        .collect();
    found.sort();
    let known: Vec<&str> = BUILT_IN_SCENARIOS.iter().map(|(name, _)| *name).collect();
    assert_eq!(found, known);
    for (name, text) in BUILT_IN_SCENARIOS {
        match scenario::parse(text) {
            Ok(timeline) => assert_eq!(timeline.name, *name),
            Err(complaints) => panic!("{name}: {}", complaints[0]),
        }
    }
}

/// Height of the sun in degrees at begin and end of a scenario inside the binary.
fn sun_elevations_deg(name: &str) -> [f64; 2] {
    let timeline = Settings::default().timeline(name).expect(name);
    let end_s = timeline.duration_s;
    let mut world = World::new();
    world.apply(Command::Scenario(ScenarioEdit::Load(Arc::new(timeline)))).expect(name);
    [0.0, end_s].map(|at_s| {
        world.advance_to(at_s);
        let snapshot = world.snapshot(0.02);
        SkyOut::seen_from(&snapshot.ownship.position, &snapshot.sky).sun_elevation_deg
    })
}

#[test]
fn the_sun_stands_where_the_names_of_the_scenarios_say() {
    for (name, low_deg, high_deg) in [
        ("clear-day", 40.0, 70.0),
        ("broken-noon-cumulus", 58.0, 62.0),
        ("scattered-sunset", 1.5, 4.0),
        ("storm-cell", 1.0, 5.0),
        // Below -18 degrees the sky has no light of the sun.
        ("overcast-night-cities", -90.0, -18.0),
        ("night-storm", -90.0, -18.0),
    ] {
        for elevation_deg in sun_elevations_deg(name) {
            assert!((low_deg..high_deg).contains(&elevation_deg), "{name}: the sun at {elevation_deg} degrees");
        }
    }
}

#[test]
fn random_bytes_never_panic() {
    let mut x = 7u64;
    for _ in 0..2000 {
        let mut bytes = DEFAULT_TEXT.as_bytes().to_vec();
        for _ in 0..3 {
            x = x.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let at = (x >> 33) as usize % bytes.len();
            bytes[at] = (x >> 25) as u8;
        }
        let text = String::from_utf8_lossy(&bytes).into_owned();
        if let Err(complaints) = Settings::parse(&text) {
            assert!(complaints.iter().all(|complaint| complaint.line >= 1 && !complaint.why.is_empty()));
        }
        let size = Size { bytes: limits::SETTINGS_BYTES, values: 100 };
        assert!(parse(&text, size).is_ok_and(|parsed| parsed.problems.is_empty()) || Settings::parse(&text).is_err());
    }
}

#[test]
fn the_committed_schema_is_current_and_can_be_checked_by() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("config/settings.schema.json");
    let now = schema::text(&file_schema());
    if std::env::var_os("UPDATE_SCHEMA").is_some_and(|value| value == "1") {
        std::fs::write(&path, &now).expect("a schema that can be written");
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        found == now,
        "config/settings.schema.json is not what the types say; run: UPDATE_SCHEMA=1 cargo test schema"
    );
    assert_eq!(Rule::from_schema(&file_schema()).err(), None);
}
