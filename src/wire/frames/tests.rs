//! What the frame header pins: its bytes, that every byte is checked or carried, and that no bytes at all make it panic.

use super::*;

fn example() -> FrameHeader {
    FrameHeader {
        format: Format::Jpeg,
        provisional: true,
        repeated: false,
        last_of_step: true,
        width_px: 640,
        height_px: 360,
        host_frame: 0x0102_0304,
        frame: 0x1112_1314_1516_1718,
        view: "left-eye_2".into(),
        simulation_time_s: 12.5,
        stamps: LatencyStamps { received_us: 1, snapshot_us: 2, submitted_us: 3, finished_us: 4 },
        encoded_us: 5,
        sent_us: 6,
        dropped: 7,
        payload_bytes: 9,
    }
}

fn changed(field: &str) -> FrameHeader {
    let mut header = example();
    match field {
        "format" => header.format = Format::Png,
        "flags" => header.repeated = true,
        "width_px" => header.width_px += 1,
        "height_px" => header.height_px += 1,
        "host_frame" => header.host_frame = 0xf1f2_f3f4,
        "frame" => header.frame = u64::MAX,
        "view" => header.view = "x".repeat(32),
        "simulation_time_s" => header.simulation_time_s = -0.1,
        "received_us" => header.stamps.received_us = u64::MAX,
        "snapshot_us" => header.stamps.snapshot_us = u64::MAX,
        "submitted_us" => header.stamps.submitted_us = u64::MAX,
        "finished_us" => header.stamps.finished_us = u64::MAX,
        "encoded_us" => header.encoded_us = u64::MAX,
        "sent_us" => header.sent_us = u64::MAX,
        "dropped" => header.dropped = u32::MAX,
        "payload_bytes" => header.payload_bytes = 0x0103_0507,
        _ => {}
    }
    header
}

#[test]
fn each_field_stands_where_the_table_says() {
    let plain = encode_header(&example()).expect("a good header");
    assert_eq!(plain.len(), HEADER_BYTES);
    assert_eq!(plain[..12], *b"SDFR\x01\x00\x80\x00\x02\x00\x05\x00");
    let mut end = 0;
    for &(field, offset, length) in FIELDS {
        assert_eq!(offset, end, "{field} follows the field before");
        end = offset + length;
        let header = changed(field);
        let bytes = encode_header(&header).expect(field);
        let differing: Vec<usize> = (0..HEADER_BYTES).filter(|&k| bytes[k] != plain[k]).collect();
        let constant = ["magic", "version", "header_bytes"].contains(&field);
        assert_eq!(differing.is_empty(), constant, "{field}");
        assert!(differing.iter().all(|k| (offset..end).contains(k)), "{field} changed the bytes {differing:?}");
        assert_eq!(decode_header(&bytes), Ok(header), "{field}");
    }
    assert_eq!(end, HEADER_BYTES);
}

#[test]
fn the_documented_table_is_the_one_of_the_code() {
    let text = include_str!("../../../protocol/frames.md");
    let rows: Vec<(String, usize, usize)> = text
        .lines()
        .filter_map(|line| {
            let mut cells = line.split('|').map(str::trim).skip(1);
            let (offset, length) = (cells.next()?.parse().ok()?, cells.next()?.parse().ok()?);
            let name = cells.nth(1)?.trim_matches('`').to_owned();
            Some((name, offset, length))
        })
        .collect();
    let fields: Vec<(String, usize, usize)> =
        FIELDS.iter().map(|&(name, offset, length)| (name.to_owned(), offset, length)).collect();
    assert_eq!(rows, fields);
}

#[test]
fn a_message_is_header_and_picture() {
    let message = encode_message(&example(), b"picture").expect("a good header");
    let (header, picture) = decode_message(&message).expect("a good message");
    assert_eq!((header, picture), (FrameHeader { payload_bytes: 7, ..example() }, &b"picture"[..]));
    for end in 0..message.len() {
        assert!(decode_message(&message[..end]).is_err(), "cut off at {end}");
    }
    let longer = [&message[..], b"!"].concat();
    assert!(decode_message(&longer).is_err(), "a byte too many");
}

#[test]
fn a_raw_picture_has_the_bytes_of_its_size() {
    let raw = FrameHeader { format: Format::Raw, width_px: 16, height_px: 16, ..example() };
    assert!(encode_message(&raw, &[0; 16 * 16 * 4]).is_ok());
    assert!(encode_message(&raw, &[0; 16 * 16 * 4 - 1]).is_err());
}

#[test]
fn what_no_header_can_hold_is_refused_on_both_ends() {
    let bad = [
        ("view", FrameHeader { view: String::new(), ..example() }),
        ("view", FrameHeader { view: "x".repeat(33), ..example() }),
        ("view", FrameHeader { view: "a/b".into(), ..example() }),
        ("width_px", FrameHeader { width_px: 0, ..example() }),
        ("height_px", FrameHeader { height_px: u32::MAX, ..example() }),
        ("simulation_time_s", FrameHeader { simulation_time_s: f64::NAN, ..example() }),
        ("payload_bytes", FrameHeader { payload_bytes: u32::MAX, ..example() }),
    ];
    for (name, header) in bad {
        assert!(matches!(encode_header(&header), Err(FrameError::Field { field, .. }) if field == name), "{name}");
    }
    let good = encode_header(&example()).expect("a good header");
    let with = |offset: usize, bytes: &[u8]| {
        let mut header = good.clone();
        header[offset..offset + bytes.len()].copy_from_slice(bytes);
        decode_header(&header)
    };
    assert!(matches!(with(0, b"X"), Err(FrameError::Magic(_))));
    assert_eq!(with(4, &[2]), Err(FrameError::Version(2)));
    for (offset, bytes, name) in [
        (6, &[127][..], "header_bytes"),
        (8, &[3], "format"),
        (10, &[8], "flags"),
        (12, &[0, 0, 0, 0], "width_px"),
        (16, &[255, 255, 255, 255], "height_px"),
        (32, &[0], "view"),
        (63, b"x", "view"),
        (71, &[0x7f], "nothing"),
        (70, &[0xf0, 0x7f], "simulation_time_s"),
        (124, &[255, 255, 255, 255], "payload_bytes"),
    ] {
        match with(offset, bytes) {
            Err(FrameError::Field { field, .. }) => assert_eq!(field, name, "offset {offset}"),
            other => assert!(other.is_ok() && name == "nothing", "offset {offset}: {other:?}"),
        }
    }
}

#[test]
fn random_bytes_never_panic() {
    let good = encode_message(&example(), b"123456789").expect("a good header");
    let mut x = 1u64;
    let mut random = || {
        x = x.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (x >> 33) as usize
    };
    let (mut read, mut refused) = (0, 0);
    for round in 0..20_000 {
        let mut bytes = good.clone();
        if round % 2 == 0 {
            bytes = (0..random() % 200).map(|_| random() as u8).collect();
            if bytes.len() > 4 {
                bytes[..4].copy_from_slice(&MAGIC);
            }
        } else {
            for _ in 0..1 + random() % 4 {
                let at = random() % bytes.len();
                bytes[at] = random() as u8;
            }
        }
        match decode_message(&bytes) {
            Ok(_) => read += 1,
            Err(_) => refused += 1,
        }
    }
    assert!(read > 1000 && refused > 10_000, "{read} were read and {refused} refused: the test reaches both");
}
