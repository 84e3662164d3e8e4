//! The tags of a TIFF's first image, read by ourselves before the reader of pictures sees the file.
//!
//! That reader takes memory for a tag as the file asks for it, and adds up numbers of the file before it checks them; it gets
//! nothing but packed samples. Here no memory is taken for what does not lie in the file, every tag has a limit, and a file with
//! a tag that cannot be meant is refused (TIFF 6.0, sections 2 and 8; BigTIFF as the Library of Congress describes it, fdd000328).

use super::{NoHeights, wrong};
use crate::wire::limits::{HEIGHT_CHUNKS, HEIGHT_TAG_BYTES, HEIGHT_TAGS};
use std::collections::BTreeMap;

/// Tags with a number for each strip or tile: StripOffsets, StripByteCounts, TileOffsets, TileByteCounts.
const OF_CHUNKS: [u16; 4] = [273, 279, 324, 325];

/// Tags of an image; what they say is read when asked for.
pub struct Tags<'a> {
    bytes: &'a [u8],
    big_endian: bool,
    found: BTreeMap<u16, Found>,
}

/// Where the values of a tag lie in the file: all of them do.
#[derive(Clone, Copy)]
struct Found {
    kind: u16,
    count: usize,
    at: usize,
}

/// Bytes of one value; `None`: no type of TIFF or BigTIFF.
fn size_of(kind: u16) -> Option<u64> {
    Some(match kind {
        1 | 2 | 6 | 7 => 1,
        3 | 8 => 2,
        4 | 9 | 11 | 13 => 4,
        5 | 10 | 12 | 16 | 17 | 18 => 8,
        _ => return None,
    })
}

impl<'a> Tags<'a> {
    /// Finds the tags of the first image.
    ///
    /// # Errors
    /// [`NoHeights`]: no TIFF, one that ends too early, or a tag that is too long, of no known type, or there twice.
    pub fn of(bytes: &'a [u8]) -> Result<Self, NoHeights> {
        let big_endian = match bytes.get(..2) {
            Some(b"II") => false,
            Some(b"MM") => true,
            _ => return Err(wrong("the first two bytes", "others", "II or MM, as a TIFF begins")),
        };
        let mut tags = Self { bytes, big_endian, found: BTreeMap::new() };
        let (directory, big) = match tags.number(2, 2)? {
            42 => (tags.number(4, 4)?, false),
            43 if (tags.number(4, 2)?, tags.number(6, 2)?) == (8, 0) => (tags.number(8, 8)?, true),
            other => return Err(wrong("the TIFF's version", other, "42 (TIFF) or 43 (BigTIFF)")),
        };
        let directory = usize::try_from(directory).map_err(|_| early())?;
        // Count, then for each tag its number, type, count and value or place of the values; BigTIFF has wider ones.
        let (count_bytes, wide) = if big { (8, 8) } else { (2, 4) };
        let count = tags.number(directory, count_bytes)?;
        if count > HEIGHT_TAGS {
            return Err(wrong("the number of tags", count, format!("at most {HEIGHT_TAGS}")));
        }
        let first = directory + count_bytes;
        for entry in (0..count as usize).map(|index| first.saturating_add(index * (4 + 2 * wide))) {
            let tag = tags.number(entry, 2)? as u16;
            let found = tags.entry(entry, wide)?;
            if tags.found.insert(tag, found).is_some() {
                return Err(wrong("a TIFF's tag", format!("{tag}, twice"), "each tag once"));
            }
        }
        Ok(tags)
    }

    /// Where the values of the tag at this place of the directory lie, checked.
    fn entry(&self, at: usize, wide: usize) -> Result<Found, NoHeights> {
        let (tag, kind) = (self.number(at, 2)? as u16, self.number(at.saturating_add(2), 2)? as u16);
        let count = self.number(at.saturating_add(4), wide)?;
        let Some(size) = size_of(kind) else {
            return Err(wrong("the type of a TIFF's tag", format!("{kind} (tag {tag})"), "1 to 13, or 16 to 18"));
        };
        let length = count.saturating_mul(size);
        let most = if OF_CHUNKS.contains(&tag) { size * HEIGHT_CHUNKS as u64 } else { HEIGHT_TAG_BYTES };
        if length > most {
            return Err(wrong("the length of a TIFF's tag", format!("{length} (tag {tag})"), format!("{most} bytes")));
        }
        let value = at.saturating_add(4 + wide);
        let place = if length <= wide as u64 { value as u64 } else { self.number(value, wide)? };
        let end = place.checked_add(length).filter(|end| *end <= self.bytes.len() as u64);
        end.ok_or_else(early)?;
        Ok(Found { kind, count: count as usize, at: place as usize })
    }

    /// A whole number of the file.
    fn number(&self, at: usize, size: usize) -> Result<u64, NoHeights> {
        let end = at.checked_add(size).ok_or_else(early)?;
        let bytes = self.bytes.get(at..end).ok_or_else(early)?;
        let all = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        Ok(if self.big_endian { bytes.iter().fold(0, all) } else { bytes.iter().rev().fold(0, all) })
    }

    /// Whole numbers of a tag; `None`: it is not there, or has other values.
    pub fn wholes(&self, tag: u16) -> Option<Vec<u64>> {
        let found = self.found.get(&tag).filter(|found| matches!(found.kind, 1 | 3 | 4 | 13 | 16 | 18))?;
        let size = size_of(found.kind)? as usize;
        (0..found.count).map(|index| self.number(found.at + index * size, size).ok()).collect()
    }

    /// Numbers in double precision of a tag; `None`: it is not there, or has other values.
    pub fn doubles(&self, tag: u16) -> Option<Vec<f64>> {
        let found = self.found.get(&tag).filter(|found| found.kind == 12)?;
        (0..found.count).map(|index| self.number(found.at + 8 * index, 8).ok().map(f64::from_bits)).collect()
    }

    /// The text of a tag up to its end mark; `None`: it is not there, or is none.
    pub fn text(&self, tag: u16) -> Option<&'a str> {
        let found = self.found.get(&tag).filter(|found| found.kind == 2)?;
        let bytes = self.bytes.get(found.at..found.at + found.count)?;
        let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
        std::str::from_utf8(&bytes[..end]).ok()
    }

    /// The one whole number of a tag, or what holds where the file does not say it.
    ///
    /// # Errors
    /// [`NoHeights`]: missing with no `default`, several, or no whole number.
    pub fn whole(&self, tag: u16, what: &'static str, default: Option<u64>) -> Result<u64, NoHeights> {
        if !self.found.contains_key(&tag) {
            return default.ok_or_else(|| wrong(what, format!("missing (tag {tag})"), "it is needed"));
        }
        match self.wholes(tag).as_deref() {
            Some([value]) => Ok(*value),
            _ => Err(wrong(what, format!("no single whole number (tag {tag})"), "one")),
        }
    }
}

fn early() -> NoHeights {
    wrong("the TIFF's length", "too short", "the file ends before what its tags name")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A TIFF of these tags and nothing else: number, type, count, and the four bytes of value or place.
    fn tiff(big_endian: bool, entries: &[(u16, u16, u32, u32)]) -> Vec<u8> {
        let two = |value: u16| if big_endian { value.to_be_bytes() } else { value.to_le_bytes() };
        let four = |value: u32| if big_endian { value.to_be_bytes() } else { value.to_le_bytes() };
        let mut bytes = if big_endian { b"MM".to_vec() } else { b"II".to_vec() };
        bytes.extend(two(42));
        bytes.extend(four(8));
        bytes.extend(two(entries.len() as u16));
        for (tag, kind, count, value) in entries {
            bytes.extend([two(*tag), two(*kind)].concat());
            bytes.extend([four(*count), four(*value)].concat());
        }
        bytes.extend([0; 4]);
        bytes
    }

    fn said(bytes: &[u8]) -> String {
        Tags::of(bytes).err().map_or_else(|| "read".to_owned(), |wrong| wrong.to_string())
    }

    #[test]
    fn numbers_are_read_in_both_byte_orders() {
        for big_endian in [false, true] {
            // Two shorts where the header stands (its version is the second), and one long.
            let bytes = tiff(big_endian, &[(256, 4, 1, 70_000), (258, 3, 4, 0)]);
            let tags = Tags::of(&bytes).expect("tags");
            assert_eq!(tags.whole(256, "the width", None).ok(), Some(70_000));
            assert_eq!(tags.wholes(258).map(|list| list[1]), Some(42), "big endian: {big_endian}");
            assert_eq!((tags.wholes(999), tags.doubles(256), tags.text(256)), (None, None, None));
            assert_eq!(tags.whole(999, "it", Some(7)).ok(), Some(7));
            assert!(tags.whole(999, "it", None).is_err() && tags.whole(258, "it", Some(7)).is_err());
        }
    }

    #[test]
    fn what_does_not_lie_in_the_file_takes_no_memory() {
        let whole = tiff(false, &[(256, 4, 1, 4)]);
        assert_eq!(said(&whole), "read");
        for end in 0..whole.len() - 4 {
            assert_ne!(said(&whole[..end]), "read", "{end}");
        }
        // Values that reach beyond the end, by their number or by their place.
        assert!(said(&tiff(false, &[(258, 3, 30, 8)])).starts_with("the TIFF's length is too short"));
        assert!(said(&tiff(false, &[(258, 3, 4, u32::MAX)])).starts_with("the TIFF's length is too short"));
        // 288 MB was what the reader of pictures took for such a tag.
        let long = said(&tiff(false, &[(34_735, 3, 36_000_000, 8)]));
        assert_eq!(long, "the length of a TIFF's tag is 72000000 (tag 34735); 65536 bytes");
        assert!(said(&tiff(false, &[(273, 4, 262_145, 8)])).ends_with("(tag 273); 1048576 bytes"));
        assert!(said(&tiff(false, &[(273, 16, 262_144, 8)])).starts_with("the TIFF's length is too short"));
        assert_eq!(
            said(&tiff(false, &[(256, 14, 1, 4)])),
            "the type of a TIFF's tag is 14 (tag 256); 1 to 13, or 16 to 18"
        );
        assert_eq!(said(&tiff(false, &[(256, 4, 1, 4), (256, 4, 1, 5)])), "a TIFF's tag is 256, twice; each tag once");
        assert_eq!(said(&tiff(false, &vec![(256, 4, 1, 4); 513])), "the number of tags is 513; at most 512");
        assert!(said(b"II\x2b\x00\x08\x00\x00\x00\xff\xff\xff\xff\xff\xff\xff\xff").starts_with("the TIFF's length"));
        assert_eq!(said(b"II\x2c\x00"), "the TIFF's version is 44; 42 (TIFF) or 43 (BigTIFF)");
    }
}
