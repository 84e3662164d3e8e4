//! The samples: bytes packed by the CIGI Class Library, and its table of places.

use super::*;

const LAYOUT: &str = include_str!("layout.json");
const SAMPLES: [&str; 2] = [include_str!("vectors33.json"), include_str!("vectors40.json")];

fn samples() -> Vec<Json> {
    SAMPLES.iter().flat_map(|text| serde_json::from_str::<Vec<Json>>(text).expect("a list of samples")).collect()
}

fn version_of(sample: &Json) -> Version {
    *Version::ALL.iter().find(|version| sample["version"] == version.name()).expect("a version")
}

fn order_of(sample: &Json) -> ByteOrder {
    *ByteOrder::ALL.iter().find(|order| sample["byte_order"] == order.name()).expect("a byte order")
}

fn bytes_of(sample: &Json) -> Vec<u8> {
    json::from_hex(sample["hex"].as_str().expect("bytes")).expect("hexadecimal digits")
}

fn decoded(sample: &Json) -> Result<Message, Rejected> {
    let bytes = bytes_of(sample);
    match sample["kind"] == "message" {
        true => decode(&bytes),
        false => decode_packets(&bytes, version_of(sample), order_of(sample)),
    }
}

/// The packets of a sample as our JSON has them.
fn listed(sample: &Json) -> Vec<Json> {
    match sample["packets"].as_array() {
        Some(packets) => packets.clone(),
        None if sample["kind"] == "packet" => vec![sample.clone()],
        None => Vec::new(),
    }
}

#[test]
fn samples_decode_to_the_values_that_were_packed() {
    let mut values = 0;
    for sample in samples() {
        let message = decoded(&sample).unwrap_or_else(|e| panic!("{}: {e}", sample["name"]));
        assert_eq!((message.version, message.byte_order), (version_of(&sample), order_of(&sample)));
        assert!(message.skipped.is_empty(), "{}", sample["name"]);
        let shown = json::show(&message, &bytes_of(&sample));
        let (ours, theirs) = (shown["packets"].as_array().expect("packets"), listed(&sample));
        assert_eq!(ours.len(), theirs.len(), "{}", sample["name"]);
        for (ours, theirs) in ours.iter().zip(&theirs) {
            assert_eq!((&ours["packet"], &ours["size"]), (&theirs["packet"], &theirs["size"]));
            let (ours, theirs) = (ours["fields"].as_object().expect("fields"), theirs["fields"].as_object());
            let theirs = theirs.expect("fields");
            assert!(ours.keys().all(|name| theirs.contains_key(name)), "{}: {ours:?} {theirs:?}", sample["name"]);
            for (name, value) in theirs {
                let same = match (value.as_f64(), ours[name].as_f64()) {
                    // Single floats are printed with nine digits there and exactly here.
                    (Some(theirs), Some(ours)) => theirs == ours || theirs as f32 == ours as f32,
                    _ => *value == ours[name],
                };
                assert!(same, "{}: {name} is {value}, read as {}", sample["name"], ours[name]);
                values += 1;
            }
        }
    }
    assert!(values > 2_500, "{values} values compared");
}

#[test]
fn samples_are_encoded_byte_for_byte_in_both_byte_orders() {
    let mut passed = [[0; 2]; 2];
    for sample in samples() {
        let bytes = bytes_of(&sample);
        let message = decoded(&sample).unwrap_or_else(|e| panic!("{}: {e}", sample["name"]));
        assert_eq!(encode(&message).as_ref(), Ok(&bytes), "{}", sample["name"]);
        let from_values = json!({
            "version": sample["version"], "byte_order": sample["byte_order"],
            "packets": listed(&sample),
        });
        assert_eq!(json::encode_json(&from_values.to_string()).as_ref(), Ok(&bytes), "{}", sample["name"]);
        let (version, order) = (version_of(&sample) as usize, order_of(&sample) as usize);
        passed[version][order] += 1;
    }
    assert_eq!(passed, [[58, 58], [73, 73]], "samples by version and byte order");
}

#[test]
fn no_part_of_a_sample_is_taken_for_the_whole() {
    for sample in samples() {
        let bytes = bytes_of(&sample);
        for length in 0..bytes.len() {
            let part = &bytes[..length];
            if let Ok(message) = decode(part) {
                assert_eq!(encode(&message).map(|bytes| bytes.len()), Ok(length), "{} {length}", sample["name"]);
                assert!(length % 8 == 0 && length >= 24);
            }
            match decode_packets(part, version_of(&sample), order_of(&sample)) {
                Ok(message) => assert_eq!(encode(&message).as_deref(), Ok(part), "{} {length}", sample["name"]),
                Err(rejected) => assert!(!rejected.to_string().is_empty()),
            }
            if sample["kind"] == "packet" && length > 0 {
                let cut = decode_packets(part, version_of(&sample), order_of(&sample));
                assert!(cut.is_err(), "{} cut to {length} bytes", sample["name"]);
            }
        }
    }
}

#[test]
fn places_are_those_of_the_table_of_facts() {
    let facts: Json = serde_json::from_str(LAYOUT).expect("the table");
    let mut compared = 0;
    for version in Version::ALL {
        let packets = facts[version.name()].as_object().expect("packets");
        let ours: Vec<&&Layout> = LAYOUTS.iter().filter(|layout| layout.framing(version).is_some()).collect();
        assert_eq!(ours.len(), packets.len() + 2, "all packets, and two of ours");
        for (name, fact) in packets {
            let layout = ours.iter().find(|layout| layout.name == name).unwrap_or_else(|| panic!("no {name}"));
            let framing = layout.framing(version).expect("filtered");
            assert_eq!(fact["id"], framing.id, "{name}");
            assert_eq!(fact["size"].as_u64().unwrap_or(8), framing.size as u64, "{name}");
            let from_host = layout.direction == Direction::HostToIg;
            assert_eq!(fact["direction"], if from_host { "host_to_ig" } else { "ig_to_host" }, "{name}");
            let mut theirs: Vec<Json> = fact["fields"].as_array().expect("fields").clone();
            let mut ours: Vec<Json> = layout
                .placed(version)
                .map(|(_, field, place, name)| {
                    let kind = match (place.part, field.kind) {
                        (Part::Bits { lowest, width: 1 }, _) => format!("b{lowest}"),
                        (Part::Bits { lowest, width }, _) => format!("b{lowest}:{width}"),
                        (Part::Disputed { bit }, _) => format!("b{bit}"),
                        (_, Kind::Text) => "str".to_owned(),
                        (_, Kind::I8) => "s8".to_owned(),
                        (_, kind) => format!("{kind:?}").to_lowercase(),
                    };
                    json!([name, place.byte, kind])
                })
                .collect();
            theirs.sort_by_key(Json::to_string);
            ours.sort_by_key(Json::to_string);
            assert_eq!(ours, theirs, "{name} of CIGI {}", version.name());
            compared += ours.len();
        }
    }
    assert_eq!(compared, 244 + 262);
}

#[test]
fn no_two_fields_share_a_bit() {
    for layout in LAYOUTS {
        for version in Version::ALL {
            let Some(framing) = layout.framing(version) else { continue };
            let mut taken = vec![0_u8; framing.size];
            taken[..version.header_bytes()].fill(0xff);
            for (_, field, place, name) in layout.placed(version) {
                let (bytes, mask) = match place.part {
                    Part::Bits { lowest, width } => (1, (0xff_u8 >> (8 - width)) << lowest),
                    Part::Disputed { bit } => (2, 1 << bit),
                    _ => (field.kind.bytes(), 0xff),
                };
                assert!(bytes == 0 || place.byte % bytes == 0, "{} {name} is not aligned", layout.name);
                for byte in &mut taken[place.byte..place.byte + bytes] {
                    assert_eq!(*byte & mask, 0, "{} {name}", layout.name);
                    *byte |= mask;
                }
            }
        }
    }
}
