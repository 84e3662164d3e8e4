//! What we encode is what Wireshark reads: every packet of CIGI 3.3, with values that fill their bits, in both byte orders.

#[path = "tshark/mod.rs"]
mod tshark;

use stormdeck::wire::cigi::layout::{Kind, Value};
use stormdeck::wire::cigi::message::{BYTE_SWAP_MAGIC, encode_packet};
use stormdeck::wire::cigi::packets::{IgControl, LAYOUTS, StartOfFrame};
use stormdeck::wire::cigi::{ByteOrder, Direction, Packet, Version};
use tshark::Way;

/// A packet whose every field has another value; `round` changes them all.
fn filled(layout: &stormdeck::wire::cigi::layout::Layout, round: u64) -> Packet {
    let id = layout.framing(Version::V3).expect("of 3.3").id;
    let mut packet = Packet::blank(Version::V3, id).expect("a packet");
    for (index, field, place, _) in layout.placed(Version::V3) {
        let number = (index as u64 + 1)
            .wrapping_mul(0x9e37_79b9_7f4a_7c15)
            .wrapping_add(round.wrapping_mul(0xd1b5_4a32_d192_ed03));
        let number = number ^ number >> 29;
        let [least, most] = field.kind.range(place);
        let value = match field.kind {
            Kind::F32 => Value::Single((number % 100_000) as f32 / 8.0 - 6_000.0),
            Kind::F64 => Value::Double((number % 100_000_000) as f64 / 64.0 - 700_000.0),
            Kind::Text => Value::Text(format!("Message {}", number % 1_000_000_000)),
            _ => Value::Whole(least + (number % (most - least + 1) as u64) as i64),
        };
        assert!(packet.set_field(index, &value));
    }
    packet
}

#[test]
#[cfg_attr(not(tshark_tests), ignore = "no tshark")]
fn wireshark_reads_what_we_write() {
    let mut datagrams = Vec::new();
    for byte_order in ByteOrder::ALL {
        let encode = |packet: &Packet| encode_packet(packet, Version::V3, byte_order).expect("in range");
        for layout in LAYOUTS.iter().filter(|layout| layout.framing(Version::V3).is_some()) {
            for round in 0..8 {
                let (major_version, minor_version, byte_swap_magic) = (3, 3, BYTE_SWAP_MAGIC);
                let to_server = layout.direction == Direction::HostToIg;
                let packet = filled(layout, round);
                let bytes = match packet {
                    Packet::IgControl(control) => encode(
                        &IgControl {
                            major_version,
                            minor_version,
                            byte_swap_magic,
                            ig_mode: control.ig_mode % 3,
                            ..control
                        }
                        .into(),
                    ),
                    Packet::StartOfFrame(sof) => {
                        encode(&StartOfFrame { major_version, minor_version, byte_swap_magic, ..sof }.into())
                    }
                    other if to_server => {
                        let first = IgControl { major_version, minor_version, byte_swap_magic, ..Default::default() };
                        [encode(&first.into()), encode(&other)].concat()
                    }
                    other => {
                        let first =
                            StartOfFrame { major_version, minor_version, byte_swap_magic, ..Default::default() };
                        [encode(&first.into()), encode(&other)].concat()
                    }
                };
                datagrams.push((if to_server { Way::ToServer } else { Way::ToHost }, bytes));
            }
        }
    }
    let same = tshark::compare("every-packet", &datagrams);
    // 244 fields in 23 packets; 21 of them behind a first packet with 10 or 11 fields; two byte orders, eight rounds.
    assert!(same > 16 * (244 + 21 * 10), "{same} values compared");
}
