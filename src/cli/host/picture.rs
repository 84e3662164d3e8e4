//! Width and height of an encoded picture, read from its own header: what was sent, not what was promised.

/// Width and height of a PNG: the first chunk is IHDR (PNG specification, 11.2.2). `None`: this is no PNG.
pub(super) fn png_size(bytes: &[u8]) -> Option<[u32; 2]> {
    let header = bytes.strip_prefix(b"\x89PNG\r\n\x1a\n")?;
    if header.get(4..8)? != b"IHDR" {
        return None;
    }
    Some([big_endian(header.get(8..12)?), big_endian(header.get(12..16)?)])
}

/// Width and height of a JPEG: its frame header, SOF0 to SOF15 (ITU-T T.81, B.2.2). `None`: this is no JPEG, or it is cut off.
pub(super) fn jpeg_size(bytes: &[u8]) -> Option<[u32; 2]> {
    let mut rest = bytes.strip_prefix(b"\xff\xd8")?;
    if !bytes.ends_with(b"\xff\xd9") {
        return None;
    }
    loop {
        let [0xff, marker, ..] = *rest else { return None };
        let length = big_endian(rest.get(2..4)?) as usize;
        // 0xC4, 0xC8 and 0xCC are tables, not frame headers.
        if (0xc0..=0xcf).contains(&marker) && ![0xc4, 0xc8, 0xcc].contains(&marker) {
            return Some([big_endian(rest.get(7..9)?), big_endian(rest.get(5..7)?)]);
        }
        rest = rest.get(2 + length..)?;
    }
}

/// A number of up to four bytes, the highest first.
fn big_endian(bytes: &[u8]) -> u32 {
    bytes.iter().fold(0, |number, &byte| number << 8 | u32::from(byte))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::{Format, encode_pixels};
    use crate::frame::Pixels;

    fn picture(format: Format) -> Vec<u8> {
        encode_pixels(&Pixels::Srgb8(vec![100; 300 * 17 * 4]), 300, 17, format).expect("a picture")
    }

    #[test]
    fn sizes_are_those_of_the_encoder() {
        assert_eq!(png_size(&picture(Format::Png)), Some([300, 17]));
        assert_eq!(jpeg_size(&picture(Format::Jpeg { quality: 80 })), Some([300, 17]));
    }

    #[test]
    fn a_damaged_picture_has_no_size_and_never_panics() {
        let (png, jpeg) = (picture(Format::Png), picture(Format::Jpeg { quality: 80 }));
        assert_eq!(png_size(&jpeg), None);
        assert_eq!(jpeg_size(&png), None);
        for end in 0..jpeg.len() {
            assert_eq!(jpeg_size(&jpeg[..end]), None, "cut off after {end} bytes");
        }
        for end in 0..24 {
            assert_eq!(png_size(&png[..end]), None, "cut off after {end} bytes");
        }
    }
}
