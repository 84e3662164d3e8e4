//! What holds the tables to the facts: sample bytes of an independent implementation, its table of places, random values,
//! truncation and junk. Once wrong elsewhere: the order of words in IG Control 4.0, and bits counted from the wrong end.

use super::layout::{Kind, Layout, Part, Value};
use super::message::{Rejected, decode, decode_packets, encode, encode_packet, opening};
use super::packets::{self, LAYOUTS, Packet};
use super::{ByteOrder, Direction, Message, Version, json, others};
use serde_json::{Value as Json, json};

mod junk;
mod pages;
mod vectors;

/// Numbers that only look random, the same in every run (xorshift64*).
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    fn below(&mut self, most: usize) -> usize {
        (self.roll() >> 11) as usize % most.max(1)
    }
}

/// A packet with random values in all fields of a version.
fn random_packet(layout: &Layout, version: Version, dice: &mut Dice) -> Option<Packet> {
    let mut packet = Packet::blank(version, layout.framing(version)?.id)?;
    for (index, field, place, _) in layout.placed(version) {
        let [least, most] = field.kind.range(place);
        let value = match field.kind {
            Kind::F32 => Value::Single(f32::from_bits(dice.roll() as u32)),
            Kind::F64 => Value::Double(f64::from_bits(dice.roll())),
            Kind::Text => {
                let length = dice.below(100);
                Value::Text((0..length).map(|_| char::from(dice.below(255) as u8 + 1)).collect())
            }
            _ => Value::Whole(least + (dice.roll() % (most - least + 1) as u64) as i64),
        };
        assert!(packet.set_field(index, &value), "{} {} {value:?}", layout.name, field.name);
    }
    Some(packet)
}

#[test]
fn every_packet_comes_back_in_both_versions_and_byte_orders() {
    let mut dice = Dice(1);
    let mut seen = 0;
    for _ in 0..200 {
        for layout in LAYOUTS {
            for version in Version::ALL {
                for byte_order in ByteOrder::ALL {
                    let Some(packet) = random_packet(layout, version, &mut dice) else { continue };
                    let bytes = encode_packet(&packet, version, byte_order).expect("values in range");
                    assert_eq!(bytes.len() % 8, 0, "{}", layout.name);
                    let back = decode_packets(&bytes, version, byte_order).expect("our own packet");
                    assert_eq!(back.packets.len(), 1);
                    // Bytes, not values: NaN is not equal to itself.
                    assert_eq!(encode(&back), Ok(bytes.clone()), "{} {version:?} {byte_order:?}", layout.name);
                    let through_json = json::encode_json(&json::show(&back, &bytes).to_string()).expect("our own JSON");
                    let again = decode_packets(&through_json, version, byte_order).expect("our own packet");
                    // JSON keeps every number but not which NaN it was.
                    assert_eq!(format!("{again:?}"), format!("{back:?}"));
                    seen += 1;
                }
            }
        }
    }
    assert_eq!(seen, 200 * 2 * (25 + 27), "23 and 25 standard packets and two of ours");
}

#[test]
fn the_byte_order_is_that_of_each_number() {
    let packet = Packet::from(packets::EntityControl { entity_id: 0x0102, lat_xoff: 1.0, ..Default::default() });
    let little = encode_packet(&packet, Version::V3, ByteOrder::Little).expect("in range");
    let big = encode_packet(&packet, Version::V3, ByteOrder::Big).expect("in range");
    assert_eq!((&little[2..4], &big[2..4]), (&[2, 1][..], &[1, 2][..]));
    assert_eq!(
        (&little[24..32], &big[24..32]),
        (&[0, 0, 0, 0, 0, 0, 0xf0, 0x3f][..], &[0x3f, 0xf0, 0, 0, 0, 0, 0, 0][..])
    );
}

#[test]
fn values_beyond_their_bits_and_versions_are_not_encoded() {
    let mode = Packet::from(packets::IgControl { ig_mode: 4, ..Default::default() });
    let text = encode_packet(&mode, Version::V3, ByteOrder::Little).expect_err("two bits").to_string();
    assert_eq!(text, "IG Control: ig_mode = 4 is not in 0 to 3");
    let animation = Packet::from(packets::AnimationControl::default());
    let text = encode_packet(&animation, Version::V3, ByteOrder::Little).expect_err("4.0 only").to_string();
    assert_eq!(text, "CIGI 3.3 has no Animation Control");
    let message =
        |message: &str| Packet::from(packets::ImageGeneratorMessage { message_id: 0, message: message.into() });
    let longest = "x".repeat(99);
    let bytes = encode_packet(&message(&longest), Version::V3, ByteOrder::Little).expect("just fits");
    assert_eq!(bytes.len(), 104);
    for wrong in [&format!("{longest}x"), "a\0b", "\u{20ac}"] {
        assert!(encode_packet(&message(wrong), Version::V3, ByteOrder::Little).is_err(), "{wrong:?}");
    }
    assert!(encode_packet(&message(&format!("{longest}x")), Version::V4, ByteOrder::Little).is_ok(), "4.0 has room");
}

fn first(version: Version, byte_order: ByteOrder) -> Vec<u8> {
    let [major_version, minor_version] = version.numbers();
    let first = packets::IgControl { major_version, minor_version, ..Default::default() };
    encode_packet(&first.into(), version, byte_order).expect("in range")
}

/// A message of an IG Control and these bytes.
fn message(version: Version, byte_order: ByteOrder, more: &[u8]) -> Vec<u8> {
    [&first(version, byte_order), more].concat()
}

#[test]
fn the_first_packet_tells_version_and_byte_order() {
    for version in Version::ALL {
        for byte_order in ByteOrder::ALL {
            let opens = opening(&first(version, byte_order)).expect("a first packet");
            assert_eq!((opens.version, opens.byte_order, opens.direction), (version, byte_order, Direction::HostToIg));
        }
    }
    let mut first = first(Version::V3, ByteOrder::Little);
    for minor in 0..16 {
        first[4] = minor << 4;
        let expected = if minor == 2 || minor == 3 { Ok(()) } else { Err(Rejected::Version { major: 3, minor }) };
        assert_eq!(opening(&first).map(|_| ()), expected);
    }
    first[4] = 0x30;
    for magic in [[0, 0], [0x80, 0x80], [1, 0]] {
        first[6..8].copy_from_slice(&magic);
        assert_eq!(opening(&first), Err(Rejected::Magic(magic)));
    }
    let mut old = [0; 24];
    old[..3].copy_from_slice(&[1, 16, 3]);
    assert_eq!(opening(&old), Err(Rejected::Version { major: 3, minor: 0 }));
    old[..3].copy_from_slice(&[1, 16, 2]);
    assert_eq!(opening(&old), Err(Rejected::Version { major: 2, minor: 0 }));
    assert!(matches!(opening(&[0x42; 32]), Err(Rejected::NotCigi(_))));
    assert_eq!(opening(&[0x18; 23]), Err(Rejected::Short(23)));
    assert_eq!(opening(&vec![0; 65_508]), Err(Rejected::Long(65_508)));
}

#[test]
fn unknown_user_defined_and_future_packets_are_skipped_by_size_and_counted() {
    for byte_order in ByteOrder::ALL {
        let known = Packet::from(packets::AtmosphereControl { global_humidity: 77, ..Default::default() });
        for (version, others) in [
            (Version::V3, vec![[8, 32], [36, 8], [100, 16], [200, 248], [203, 40], [255, 8]]),
            (Version::V4, vec![[0x07, 32], [0x27, 8], [0x0fef, 16], [0x1000, 24], [0x8003, 4096], [0xfffe, 8]]),
        ] {
            let mut bytes = first(version, byte_order);
            for [id, size] in &others {
                let mut packet = vec![0xaa_u8; *size];
                match (version, byte_order) {
                    (Version::V3, _) => packet[..2].copy_from_slice(&[*id as u8, *size as u8]),
                    (_, ByteOrder::Little) => {
                        packet[..4].copy_from_slice(&[*size as u8, (*size >> 8) as u8, *id as u8, (*id >> 8) as u8]);
                    }
                    (_, ByteOrder::Big) => {
                        packet[..4].copy_from_slice(&[(*size >> 8) as u8, *size as u8, (*id >> 8) as u8, *id as u8]);
                    }
                }
                bytes.extend(packet);
            }
            bytes.extend(encode_packet(&known, version, byte_order).expect("in range"));
            let decoded = decode(&bytes).expect("a message");
            assert_eq!(decoded.packets.len(), 2, "{version:?} {byte_order:?}");
            assert_eq!(decoded.packets[1], known);
            let skipped: Vec<[usize; 2]> =
                decoded.skipped.iter().map(|skipped| [usize::from(skipped.packet_id), skipped.size]).collect();
            assert_eq!(skipped, others);
            let shown = json::show(&decoded, &bytes);
            assert_eq!(shown["skipped"], others.len());
            assert_eq!(json::encode_json(&shown.to_string()).as_ref(), Ok(&bytes), "skipped packets come back too");
        }
    }
    assert_eq!(others::name_of(Version::V3, 8), "Rate Control (4.0: Velocity Control)");
    assert_eq!(others::name_of(Version::V4, 0x8123), "a user-defined packet");
    assert_eq!(others::name_of(Version::V3, 99), "a packet of no known kind");
}

#[test]
fn another_owners_packet_under_our_number_is_skipped() {
    let bytes = message(Version::V3, ByteOrder::Big, &[&[201, 16][..], &[7; 14]].concat());
    let decoded = decode(&bytes).expect("a message");
    assert_eq!((decoded.packets.len(), decoded.skipped.len()), (1, 1));
}

#[test]
fn messages_that_do_not_conform_are_rejected_whole_with_a_reason() {
    let (v3, little) = (Version::V3, ByteOrder::Little);
    let sof = packets::StartOfFrame { major_version: 3, minor_version: 3, ..Default::default() };
    let sof = encode_packet(&sof.into(), v3, little).expect("in range");
    let response = encode_packet(&packets::HatHotResponse::default().into(), v3, little).expect("in range");
    let view = encode_packet(&packets::ViewControl::default().into(), v3, little).expect("in range");
    for (more, reason) in [
        (vec![16], "1 bytes are needed at offset 1, 0 are left"),
        (vec![16, 0, 0, 0, 0, 0, 0, 0], "packet 16 at byte 24: size 0 is not a positive multiple of 8"),
        (vec![16, 12, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], "packet 16 at byte 24: size 12 is not a positive multiple of 8"),
        (vec![16, 32, 0, 0, 0, 0, 0, 0], "packet 16 at byte 24: size 32, but 8 bytes are left"),
        (vec![16, 8, 0, 0, 0, 0, 0, 0], "View Control at byte 24: size 8, must be 32"),
        (first(v3, little), "a second IG Control at byte 24: a message has one, and it comes first"),
        (sof.clone(), "a second Start of Frame at byte 24: a message has one, and it comes first"),
        (response.clone(), "HAT/HOT Response at byte 24: it goes the other way"),
    ] {
        let rejected = decode(&message(v3, little, &more)).expect_err(reason);
        assert_eq!(rejected.to_string(), reason);
    }
    let rejected = decode(&[sof.clone(), view].concat()).expect_err("a host's packet from an image generator");
    assert_eq!(rejected.to_string(), "View Control at byte 24: it goes the other way");
    assert!(decode(&[sof, response].concat()).is_ok());
}
