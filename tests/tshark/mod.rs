//! Wireshark's `tshark` as a second opinion: datagrams become a capture file, and what it reads from them is compared with
//! what we do. Debian's version knows CIGI up to 3.3.

use serde_json::Value;
use std::path::Path;
use std::process::Command;
use stormdeck::wire::cigi::layout::Value as Ours;
use stormdeck::wire::cigi::{Packet, Version, decode};

/// Where a datagram went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    ToServer,
    ToHost,
}

/// Dissects datagrams of CIGI 3.3 and compares every field of every packet. Returns how many values were the same. Fails
/// where `tshark` is not there: without it, tests that call this are listed as ignored by `cfg(tshark_tests)`.
pub fn compare(name: &str, datagrams: &[(Way, Vec<u8>)]) -> usize {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.pcap"));
    std::fs::write(&file, capture(datagrams)).expect("a file for the capture");
    let tshark = |arguments: &[&str]| {
        let mut command = Command::new("tshark");
        command.arg("-r").arg(&file).args(["-d", "udp.port==8004,cigi"]).args(arguments);
        let output = command.output().expect("tshark (Debian: deploy/install-tshark)");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("UTF-8")
    };
    let malformed = tshark(&["-Y", "_ws.malformed || !cigi"]);
    assert_eq!(malformed, "", "malformed, or no CIGI at all");
    let dissected: Vec<Value> = serde_json::from_str(&tshark(&["-T", "json", "--no-duplicate-keys"])).expect("JSON");
    assert_eq!(dissected.len(), datagrams.len());
    let theirs = dissected.iter().map(|frame| &frame["_source"]["layers"]["cigi"]);
    datagrams.iter().zip(theirs).map(|((_, bytes), theirs)| compare_message(bytes, theirs)).sum()
}

fn compare_message(bytes: &[u8], theirs: &Value) -> usize {
    let message = decode(bytes).expect("what we took or sent");
    // One object a packet; packets of one kind in a message come as a list.
    let objects = theirs.as_object().expect("a dissection").values().flat_map(|value| match value {
        Value::Array(list) => list.clone(),
        other => vec![other.clone()],
    });
    let mut objects: Vec<Value> = objects.filter(|object| object["cigi.packet_id"].is_string()).collect();
    let mut same = 0;
    for packet in &message.packets {
        let id = packet.layout().framing(Version::V3).expect("of 3.3").id.to_string();
        let position = objects.iter().position(|object| object["cigi.packet_id"] == id.as_str());
        let object = objects.remove(position.unwrap_or_else(|| panic!("tshark found no {}", packet.layout().name)));
        same += compare_packet(packet, &object);
    }
    let left: Vec<&Value> = objects.iter().filter(|object| !is_user_defined(object)).collect();
    assert!(left.is_empty(), "tshark found more: {left:?}");
    same
}

fn is_user_defined(object: &Value) -> bool {
    object["cigi.packet_id"].as_str().and_then(|id| id.parse().ok()).is_some_and(|id: u16| id > 200)
}

/// Compares the values of a packet without a table of names: each of ours is one of theirs, and none is left over.
fn compare_packet(packet: &Packet, theirs: &Value) -> usize {
    let layout = packet.layout();
    if layout.name.starts_with("User-Defined") {
        return 0;
    }
    let ours: Vec<_> = layout.placed(Version::V3).collect();
    let listed = theirs.as_object().expect("fields").iter();
    let theirs: Vec<(&String, &str)> = listed
        .filter(|(name, _)| !matches!(name.as_str(), "cigi.packet_id" | "cigi.packet_size"))
        .filter_map(|(name, value)| Some((name, value.as_str()?)))
        .collect();
    assert_eq!(ours.len(), theirs.len(), "{}: {ours:?} {theirs:?}", layout.name);
    // JSON objects have no order: each of our values takes one of theirs that nobody has taken.
    let mut left = theirs.clone();
    for (index, field, _, name) in &ours {
        let ours = packet.field(*index).expect("a field");
        let same = |their_value: &str| match &ours {
            // The magic is shown as it stands in the bytes.
            _ if field.name == "byte_swap_magic" => ["0x8000", "0x0080"].contains(&their_value),
            Ours::Whole(ours) => whole(their_value) == Some(*ours) || words(their_value).contains(ours),
            // Printed with six significant digits.
            Ours::Single(ours) => close(f64::from(*ours), their_value, 1e-5),
            Ours::Double(ours) => close(*ours, their_value, 1e-14),
            Ours::Text(ours) => ours == their_value,
        };
        let found = left.iter().position(|(_, value)| same(value));
        let found = found.unwrap_or_else(|| panic!("{}: {name} is {ours:?}, tshark has {left:?}", layout.name));
        left.remove(found);
    }
    theirs.len()
}

fn whole(text: &str) -> Option<i64> {
    match text.strip_prefix("0x") {
        Some(digits) => i64::from_str_radix(digits, 16).ok(),
        None => text.parse().ok(),
    }
}

/// Words of component and event data are shown byte by byte, as they stand: the number in either byte order.
fn words(text: &str) -> Vec<i64> {
    let bytes: Option<Vec<u8>> = text.split(':').map(|byte| u8::from_str_radix(byte, 16).ok()).collect();
    match bytes.and_then(|bytes| <[u8; 4]>::try_from(bytes).ok()) {
        Some(bytes) => vec![u32::from_le_bytes(bytes).into(), u32::from_be_bytes(bytes).into()],
        None => Vec::new(),
    }
}

fn close(ours: f64, theirs: &str, relative: f64) -> bool {
    theirs.parse::<f64>().is_ok_and(|theirs| (ours - theirs).abs() <= relative * ours.abs().max(1e-30))
}

/// A capture file (pcap, Ethernet) with these datagrams; the host is at port 8005, the server at 8004.
fn capture(datagrams: &[(Way, Vec<u8>)]) -> Vec<u8> {
    let mut file = Vec::new();
    for word in [0xa1b2_c3d4_u32, 0x0004_0002, 0, 0, 65_535, 1] {
        file.extend(word.to_le_bytes());
    }
    for (number, (way, payload)) in datagrams.iter().enumerate() {
        let ports: [u16; 2] = if *way == Way::ToServer { [8005, 8004] } else { [8004, 8005] };
        let (udp, ip) = ((8 + payload.len()) as u16, (28 + payload.len()) as u16);
        let mut frame = vec![0; 12];
        frame.extend([0x08, 0x00, 0x45, 0x00]);
        frame.extend(ip.to_be_bytes());
        // Identification and fragments, life, UDP, no checksum; from and to this machine.
        frame.extend([0, 0, 0, 0, 64, 17, 0, 0, 127, 0, 0, 1, 127, 0, 0, 1]);
        ports.iter().for_each(|port| frame.extend(port.to_be_bytes()));
        frame.extend(udp.to_be_bytes());
        frame.extend([0, 0]);
        frame.extend(payload);
        for word in [number as u32, 0, frame.len() as u32, frame.len() as u32] {
            file.extend(word.to_le_bytes());
        }
        file.extend(frame);
    }
    file
}
