//! The decoders, each as a function from bytes to an answer in words, with what its corpus begins with.

use std::collections::BTreeSet;
use std::sync::{Arc, OnceLock};
use stormdeck::frame::LatencyStamps;
use stormdeck::geo::raster::{Grid, Raster};
use stormdeck::geo::terrain::Terrain;
use stormdeck::report::Bounds;
use stormdeck::scattering::basis::{Basis, Content, Recipe};
use stormdeck::scattering::compress::{Packing, Width};
use stormdeck::scattering::file;
use stormdeck::scattering::lights::Lights;
use stormdeck::scattering::medium::Medium;
use stormdeck::scattering::ordinates::Params;
use stormdeck::serve::Known;
use stormdeck::settings::Settings;
use stormdeck::wire::cigi::layout::Value;
use stormdeck::wire::cigi::packets::Packet;
use stormdeck::wire::cigi::scene::{Consequence, Convention, Moment, Scene};
use stormdeck::wire::cigi::{ByteOrder, Version, decode, decode_packets, encode, json};
use stormdeck::wire::{control, frames, scenario};
use stormdeck::world::{Command, World};

/// A decoder.
pub struct Target {
    pub name: &'static str,
    /// What bending begins with.
    pub corpus: fn() -> Vec<Vec<u8>>,
    /// Longest input.
    pub longest: usize,
    /// Inputs of a run without a word.
    pub inputs: u64,
    /// Decodes, checks what must hold of any input, and says what came of it.
    pub answer: fn(&[u8]) -> String,
}

pub const CIGI_MESSAGES: Target =
    Target { name: "cigi messages", corpus: cigi_samples, longest: 2_048, inputs: 4_000, answer: cigi_message };
pub const CIGI_SCENE: Target = Target {
    name: "cigi scene",
    corpus: cigi_host_messages,
    longest: 2_048,
    inputs: 4_000,
    answer: |input| cigi_scene(input, &Terrain::ELLIPSOID),
};
pub const CIGI_TERRAIN: Target = Target {
    name: "cigi scene over mountains",
    corpus: cigi_host_messages,
    longest: 2_048,
    // Lines of sight are walked.
    inputs: 400,
    answer: |input| cigi_scene(input, mountains()),
};
pub const CIGI_JSON: Target =
    Target { name: "cigi json", corpus: cigi_texts, longest: 8_192, inputs: 4_000, answer: cigi_text };
pub const CONTROL: Target = Target {
    name: "control messages",
    corpus: || lines(include_str!("corpus/control.jsonl")),
    longest: 8_192,
    inputs: 4_000,
    answer: |input| match control::decode(&String::from_utf8_lossy(input)) {
        Ok(inbound) => kind(&format!("{:?}", inbound.message)),
        Err((_, refused)) => words(&refused.to_string()),
    },
};
pub const SCENARIO: Target = Target {
    name: "scenario files",
    corpus: || vec![include_bytes!("../../config/scenarios/night-storm.json").to_vec()],
    longest: 16_384,
    inputs: 4_000,
    answer: |input| match scenario::parse(&String::from_utf8_lossy(input)) {
        Ok(_) => "a scenario".to_owned(),
        Err(complaints) => complaints.first().map_or_else(String::new, |complaint| words(&complaint.to_string())),
    },
};
pub const SETTINGS: Target = Target {
    name: "settings files",
    corpus: || {
        vec![include_bytes!("../../config/default.json").to_vec(), include_bytes!("../../config/cigi.json").to_vec()]
    },
    longest: 8_192,
    inputs: 4_000,
    answer: |input| match Settings::parse(&String::from_utf8_lossy(input)) {
        Ok(_) => "settings".to_owned(),
        Err(complaints) => complaints.first().map_or_else(String::new, |complaint| words(&complaint.to_string())),
    },
};
pub const FRAMES: Target = Target {
    name: "frame messages",
    corpus: || vec![frame()],
    longest: 4_096,
    inputs: 4_000,
    answer: |input| match frames::decode_message(input) {
        Ok(_) => "a frame".to_owned(),
        Err(error) => words(&error.to_string()),
    },
};

pub const BOUNDS: Target = Target {
    name: "files of bounds",
    corpus: || vec![include_bytes!("../../benches/bounds.json").to_vec()],
    longest: 8_192,
    inputs: 4_000,
    answer: |input| match Bounds::parse(&String::from_utf8_lossy(input)) {
        Ok(_) => "bounds".to_owned(),
        Err(why) => words(&why),
    },
};
pub const BASIS: Target =
    Target { name: "basis files", corpus: || vec![basis()], longest: 16_384, inputs: 4_000, answer: basis_file };

/// A baked basis of two lights in a tiny cloud.
fn basis() -> Vec<u8> {
    let medium = Medium { cells: [3, 2, 2], spacing_m: [100.0; 3], extinction_per_m: vec![0.01; 12], periodic: false };
    let lights = Lights::even([2, 1, 1], medium.size_m(), 2.0, false).expect("lights");
    let packing = Packing { threshold: 1e-3, width: Width::F16 };
    let params = Params { rays: 64, ..Params::default() };
    let recipe = Recipe { medium, params, lights, content: Content::Total, packing };
    file::write(&Basis::bake(recipe).expect("a basis"))
}

/// Reads a basis as it is, and once more with checksums that are right again, so that what they guard is reached.
fn basis_file(input: &[u8]) -> String {
    let mut said = BTreeSet::new();
    for bytes in [input.to_vec(), with_checksums(input)] {
        for torn in [false, true] {
            match file::scan(&bytes, torn) {
                Ok(contents) => {
                    assert!(contents.sound_bytes <= bytes.len());
                    said.insert(format!("{} blocks", contents.blocks.len()));
                }
                Err(error) => {
                    said.insert(words(&error.to_string()));
                }
            }
        }
        if let Ok(basis) = file::read(&bytes) {
            assert_eq!(file::read(&file::write(&basis)).as_ref(), Ok(&basis), "what is read can be written");
        }
    }
    said.into_iter().collect::<Vec<_>>().join("; ")
}

/// The same bytes with the checksums of the header and of each block put right, as far as their lengths lead.
fn with_checksums(input: &[u8]) -> Vec<u8> {
    let mut bytes = input.to_vec();
    let length = |bytes: &[u8], at: usize| {
        Some(u32::from_le_bytes(bytes.get(at..at.checked_add(4)?)?.try_into().ok()?) as usize)
    };
    // Magic, version, length, body, checksum; then blocks of number, length, checksum and body.
    let Some(end) = length(&bytes, 12).and_then(|body| body.checked_add(16)) else { return bytes };
    if end.checked_add(8).is_none_or(|next| next > bytes.len()) {
        return bytes;
    }
    let sum = file::hash(&bytes[16..end], 0);
    bytes[end..end + 8].copy_from_slice(&sum.to_le_bytes());
    let mut at = end + 8;
    while let (Some(light), Some(body)) = (length(&bytes, at), length(&bytes, at + 4)) {
        let (from, Some(until)) = (at + 16, (at + 16).checked_add(body)) else { break };
        if until > bytes.len() {
            break;
        }
        let sum = file::hash(&bytes[from..until], light as u64);
        bytes[at + 8..from].copy_from_slice(&sum.to_le_bytes());
        at = until;
    }
    bytes
}

/// A frame of 16 x 16 pixels.
fn frame() -> Vec<u8> {
    let stamps = LatencyStamps { received_us: 1, snapshot_us: 2, submitted_us: 3, finished_us: 4 };
    let header = frames::FrameHeader {
        format: control::Format::Raw,
        provisional: false,
        repeated: false,
        last_of_step: false,
        width_px: 16,
        height_px: 16,
        host_frame: 5,
        frame: 6,
        view: "main".to_owned(),
        simulation_time_s: 1.5,
        stamps,
        encoded_us: 7,
        sent_us: 8,
        dropped: 0,
        payload_bytes: 1_024,
    };
    frames::encode_message(&header, &[9; 1_024]).expect("a frame")
}

/// The sample messages and packets of the CIGI Class Library.
fn cigi_samples() -> Vec<Vec<u8>> {
    let texts = [
        include_str!("../../src/wire/cigi/tests/vectors33.json"),
        include_str!("../../src/wire/cigi/tests/vectors40.json"),
    ];
    let samples = texts.iter().flat_map(|text| serde_json::from_str::<Vec<serde_json::Value>>(text).expect("samples"));
    samples.filter_map(|sample| json::from_hex(sample["hex"].as_str()?)).collect()
}

/// Messages of a host: each sample packet of one behind an IG Control.
fn cigi_host_messages() -> Vec<Vec<u8>> {
    let samples = cigi_samples();
    let whole: Vec<Vec<u8>> = samples.iter().filter(|bytes| decode(bytes).is_ok()).cloned().collect();
    let firsts: Vec<&Vec<u8>> = whole.iter().filter(|bytes| bytes.len() == 24).collect();
    let behind = samples.iter().flat_map(|packet| firsts.iter().map(move |first| [first.as_slice(), packet].concat()));
    let host = behind.filter(|bytes| decode(bytes).is_ok_and(|message| message.packets.len() == 2));
    let mut messages: Vec<Vec<u8>> = host.collect();
    // One for each sample and version is enough to begin with.
    messages.sort();
    messages.dedup_by(|a, b| a[24..] == b[24..]);
    messages.extend(whole);
    messages
}

fn cigi_texts() -> Vec<Vec<u8>> {
    let messages = cigi_samples().into_iter().filter_map(|bytes| Some((decode(&bytes).ok()?, bytes)));
    messages.map(|(message, bytes)| json::show(&message, &bytes).to_string().into_bytes()).collect()
}

fn cigi_message(input: &[u8]) -> String {
    let mut said = BTreeSet::new();
    let alone = Version::ALL
        .iter()
        .flat_map(|version| ByteOrder::ALL.iter().map(|order| decode_packets(input, *version, *order)));
    for outcome in std::iter::once(decode(input)).chain(alone) {
        match outcome {
            Ok(message) => {
                let bytes = encode(&message).expect("what was read fits its bits");
                let skipped: usize = message.skipped.iter().map(|skipped| skipped.size).sum();
                assert!(bytes.len() + skipped <= input.len() + 8 * message.packets.len());
                let again = decode_packets(&bytes, message.version, message.byte_order).expect("our own bytes");
                assert_eq!(encode(&again).as_deref(), Ok(&bytes[..]), "decoding and encoding agree");
                said.extend(message.packets.iter().map(|packet| packet.layout().type_name.to_owned()));
            }
            Err(rejected) => {
                said.insert(words(&rejected.to_string()));
            }
        }
    }
    said.into_iter().collect::<Vec<_>>().join("; ")
}

/// Made mountains with a file of heights over them, where the samples' places are, in which every third height is not known.
fn mountains() -> &'static Terrain {
    static MADE: OnceLock<Terrain> = OnceLock::new();
    MADE.get_or_init(|| {
        let heights_m = (0..60 * 80u16).map(|n| if n % 3 == 0 { f32::NAN } else { f32::from(n % 977) * 3.0 });
        let (step_south_deg, step_east_deg, columns) = (0.02, 0.02, 80);
        let heights_m = heights_m.collect();
        let grid = Grid { north_deg: 47.6, west_deg: 7.4, step_south_deg, step_east_deg, columns, heights_m };
        Terrain::of(Arc::new(Raster::new(grid, 48.0, Terrain::procedural())))
    })
}

/// Every number of an answer is one.
fn finite(answer: &Packet, version: Version) -> bool {
    answer.layout().placed(version).all(|(index, ..)| match answer.field(index) {
        Some(Value::Single(value)) => value.is_finite(),
        Some(Value::Double(value)) => value.is_finite(),
        _ => true,
    })
}

/// What a host says reaches the world only finite and in range, whatever it says, and so do the answers to its questions.
fn cigi_scene(input: &[u8], terrain: &Terrain) -> String {
    let Ok(message) = decode(input) else { return "rejected".to_owned() };
    let mut world = World::new();
    world.set_terrain(terrain.clone());
    let mut scene = Scene::new(Convention { sea_level_m: 0.0, seed: 1, size_px: [640, 360], terrain: terrain.clone() });
    let mut said = BTreeSet::new();
    let mut questions = Vec::new();
    for frame in 0..2 {
        let moment = Moment { host_frame: frame, timestamp: Some(frame * 1_667), extrapolate: true, now_s: 0.0 };
        for consequence in scene.take(&message, &moment) {
            let applied = match consequence {
                Consequence::Command(command) => {
                    said.insert(kind(&format!("{command:?}")));
                    world.apply(command).map(|_| ())
                }
                Consequence::Strike { request, .. } => world.apply(Command::Strike(request)).map(|_| ()),
                Consequence::Question(question) => {
                    questions.push(question);
                    Ok(())
                }
                Consequence::Refused(refused) => Err(refused),
            };
            said.extend(applied.err().map(|refused| words(&refused.field)));
        }
        world.advance_to(0.1 * f64::from(frame));
        let seen = world.peek(0.02);
        let place = seen.ownship.position;
        assert!([place.latitude_rad, place.longitude_rad, place.altitude_m].iter().all(|number| number.is_finite()));
        let layers = seen.weather.layers.iter().chain(seen.regions.iter().flat_map(|region| &region.weather.layers));
        for layer in layers {
            let numbers = [layer.base_m, layer.thickness_m, layer.coverage, layer.density, layer.wind_speed_mps];
            assert!(
                numbers.iter().all(|number| number.is_finite()) && (0.0..=1.0).contains(&layer.coverage),
                "{layer:?}"
            );
        }
        for flash in &seen.flashes {
            assert!(flash.intensity_cd.is_finite() && flash.position.altitude_m.is_finite(), "{flash:?}");
        }
    }
    let (snapshot, entities, air) = (Arc::new(world.peek(0.02)), scene.entities().clone(), scene.air());
    let known = Known { snapshot, entities, air, host_frame_number_lsn: 5 };
    // A message may hold hundreds of questions, which all are alike.
    for question in questions.iter().take(2) {
        for answer in known.answer(question) {
            assert!(finite(&answer, message.version), "{question:?}: {answer:?}");
            said.insert(answer.layout().type_name.to_owned());
        }
    }
    said.into_iter().collect::<Vec<_>>().join("; ")
}

fn cigi_text(input: &[u8]) -> String {
    match json::encode_json(&String::from_utf8_lossy(input)) {
        Ok(_) => "a message".to_owned(),
        Err(wrong) => words(&wrong.to_string()),
    }
}

fn lines(text: &str) -> Vec<Vec<u8>> {
    text.lines().map(|line| line.as_bytes().to_vec()).collect()
}

/// The first word of a value that was printed.
fn kind(printed: &str) -> String {
    printed.chars().take_while(|c| c.is_alphanumeric()).collect()
}

/// An answer without its numbers and quotations, so that alike complaints count as one.
pub fn words(text: &str) -> String {
    text.split_whitespace().filter(|word| word.chars().all(char::is_alphabetic)).take(12).collect::<Vec<_>>().join(" ")
}
