//! Junk: random bytes and bent samples never panic, and what is accepted can be shown and encoded again.

use super::*;

fn survives(bytes: &[u8], counts: &mut [u32; 2]) {
    let outcomes = std::iter::once(decode(bytes))
        .chain(Version::ALL.iter().flat_map(|v| ByteOrder::ALL.iter().map(|order| decode_packets(bytes, *v, *order))));
    for outcome in outcomes {
        match outcome {
            Ok(message) => {
                counts[0] += 1;
                let again = encode(&message).expect("what was read fits its bits");
                let skipped: usize = message.skipped.iter().map(|skipped| skipped.size).sum();
                // A text that came without its closing NUL gets one, which may take eight bytes more.
                assert!(again.len() + skipped <= bytes.len() + 8 * message.packets.len());
            }
            Err(rejected) => {
                counts[1] += 1;
                assert!(!rejected.to_string().is_empty());
            }
        }
    }
}

#[test]
fn random_and_bent_bytes_are_decoded_or_rejected() {
    let mut dice = Dice(7);
    let mut counts = [0; 2];
    let firsts: Vec<Vec<u8>> = Version::ALL
        .iter()
        .flat_map(|version| ByteOrder::ALL.iter().map(|order| super::first(*version, *order)))
        .collect();
    for round in 0..20_000 {
        let mut bytes: Vec<u8> = Vec::new();
        if round % 4 > 0 {
            bytes.extend(&firsts[dice.below(4)]);
        }
        if round % 4 > 1 {
            let layout = LAYOUTS[dice.below(LAYOUTS.len())];
            let (version, order) = (Version::ALL[dice.below(2)], ByteOrder::ALL[dice.below(2)]);
            if let Some(packet) = random_packet(layout, version, &mut dice) {
                bytes.extend(encode_packet(&packet, version, order).expect("in range"));
            }
        }
        if round % 4 != 2 {
            let length = dice.below(64);
            bytes.extend((0..length).map(|_| dice.roll() as u8));
        }
        for _ in 0..dice.below(3) {
            let at = dice.below(bytes.len());
            if let Some(byte) = bytes.get_mut(at) {
                *byte ^= 1 << dice.below(8);
            }
        }
        survives(&bytes, &mut counts);
    }
    assert!(counts.iter().all(|count| *count > 5_000), "accepted and rejected: {counts:?}");
}

#[test]
fn json_that_is_not_a_message_is_refused_with_its_place() {
    let packet = |fields: &str| {
        format!(r#"{{"version":"3.3","byte_order":"big","packets":[{{"packet":"View Control","fields":{fields}}}]}}"#)
    };
    for (text, complaint) in [
        ("", "the text: not JSON"),
        ("[]", "the text: not an object"),
        (r#"{"byte_order":"big","packets":[]}"#, r#"version: must be one of "3.3", "4.0""#),
        (r#"{"version":"4.0","byte_order":"middle","packets":[]}"#, r#"byte_order: must be one of "little", "big""#),
        (r#"{"version":"4.0","byte_order":"big"}"#, "packets: must be a list"),
        (
            r#"{"version":"4.0","byte_order":"big","packets":[{}]}"#,
            "packets[0]: needs `packet`, a name, or `packet_id`",
        ),
        (
            r#"{"version":"3.3","byte_order":"big","packets":[{"packet":"Entity Position"}]}"#,
            "packets[0]: CIGI 3.3 has no packet Entity Position",
        ),
        (
            r#"{"version":"3.3","byte_order":"big","packets":[{"packet":"View Control","packet_id":2}]}"#,
            "packets[0]: CIGI 3.3 has no packet View Control 2",
        ),
        (&packet(r#"{"group_id":256}"#), "packets[0].fields.group_id: 256 is not a whole number from 0 to 255"),
        (&packet(r#"{"yaw_enable":2}"#), "packets[0].fields.yaw_enable: 2 is not a whole number from 0 to 1"),
        (&packet(r#"{"yaw":1e39}"#), "packets[0].fields.yaw: 1000000000000000000000000000000000000000 is beyond"),
        (&packet(r#"{"yaw":"north"}"#), r#"packets[0].fields.yaw: "north" is not a number"#),
        (&packet(r#"{"jaw":1}"#), "packets[0].fields.jaw: View Control has no such field"),
        (&packet("7"), "packets[0].fields: must be an object"),
    ] {
        let refused = json::encode_json(text).expect_err(text).to_string();
        assert!(refused.starts_with(complaint), "{text}: {refused}");
    }
    assert!(json::encode_json(&packet("{}")).is_ok());
}

#[test]
fn hexadecimal_digits_come_with_or_without_decoration() {
    assert_eq!(json::from_hex("0x01 18\n03:ff"), Some(vec![1, 0x18, 3, 0xff]));
    assert_eq!(json::from_hex(""), Some(vec![]));
    for wrong in ["0", "0g", "1 2", "--"] {
        assert_eq!(json::from_hex(wrong).filter(|_| wrong != "1 2"), None, "{wrong}");
    }
    assert_eq!(json::from_hex(&"00".repeat(65_508)), None, "more than a datagram has");
    assert_eq!(json::to_hex(&[0, 0xab]), "00ab");
}
