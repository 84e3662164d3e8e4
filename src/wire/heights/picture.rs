//! The samples of a TIFF's first image: which kinds are read, and reading them a strip or a tile at a time.

use super::tags::Tags;
use super::{NoHeights, check_size, wrong};
use crate::wire::limits::{HEIGHT_CHUNKS, HEIGHT_FILE_BYTES, HEIGHT_PADDING, HEIGHT_SAMPLES};
use std::io::Cursor;
use tiff::TiffError;
use tiff::decoder::{Decoder, DecodingResult, Limits};

/// A tag of which only some values are read.
struct Must {
    tag: u16,
    what: &'static str,
    /// What holds where the file does not say it.
    default: Option<u64>,
    values: &'static [u64],
    meaning: &'static str,
}

impl Must {
    const fn one(tag: u16, what: &'static str, meaning: &'static str) -> Self {
        Self { tag, what, default: Some(1), values: &[1], meaning }
    }
}

/// TIFF 6.0, section 8; Adobe's supplement 2 of 2002 (deflate) and 3 of 2005 (differences of floats).
const MUST: [Must; 7] = [
    Must {
        default: None,
        ..Must::one(262, "the photometric interpretation", "1, BlackIsZero: a greater number is higher ground")
    },
    Must::one(277, "the samples per pixel", "1: one band of heights; take one by gdal_translate -b"),
    Must::one(284, "the planar configuration", "1: not planar"),
    Must::one(274, "the orientation", "1: rows from the north, each from the west"),
    Must::one(266, "the order of bits", "1: from the highest bit"),
    Must {
        values: &[1, 5, 8, 32_773, 32_946],
        ..Must::one(259, "the compression", "1 (none), 5 (LZW), 8 or 32946 (deflate), 32773 (PackBits)")
    },
    Must {
        values: &[1, 2, 3],
        ..Must::one(317, "the predictor", "1 (none), 2 (differences) or 3 (differences of floats)")
    },
];
/// Kinds of samples that are read: SampleFormat and BitsPerSample.
const KINDS: [(u64, u64); 8] = [(1, 8), (1, 16), (1, 32), (2, 8), (2, 16), (2, 32), (3, 32), (3, 64)];

/// Bytes that one packed byte may become at most: nothing, LZW (a code of 12 bits stands for 4,096 bytes at most), deflate
/// (RFC 1951: 258 bytes a code of two bits), PackBits (128 of two).
const SPREAD: [(u64, usize); 5] = [(1, 1), (5, 2_731), (8, 1_032), (32_773, 64), (32_946, 1_032)];
/// Bytes that a packed chunk may have beyond twice what it becomes: tables of deflate, codes of LZW.
const SPARE: usize = 4_096;

/// How an image is laid out; checked, so that its samples can be read.
#[derive(Debug)]
pub struct Picture {
    /// Samples in a row.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
    /// Width and height of a strip or tile.
    chunk: [usize; 2],
    tiled: bool,
    /// Where each strip or tile lies in the file, and how long it is; both 0: the file leaves it out (GDAL's sparse files), and
    /// nothing is known there.
    packed: Vec<(usize, usize)>,
    /// Values of the tags that say how samples are packed: bits, compression, predictor, format.
    form: [u64; 4],
}

impl Picture {
    /// What the tags say of the picture.
    ///
    /// # Errors
    /// [`NoHeights`]: too large or too small, of a kind that is not read, or with numbers that do not fit each other.
    pub fn of(tags: &Tags) -> Result<Self, NoHeights> {
        let [columns, rows] = [(256, "the width"), (257, "the height")].map(|(tag, what)| tags.whole(tag, what, None));
        let size = |size: u64| usize::try_from(size).unwrap_or(usize::MAX);
        let (columns, rows) = (size(columns?), size(rows?));
        check_size(columns, rows)?;
        for must in MUST {
            let value = tags.whole(must.tag, must.what, must.default)?;
            if !must.values.contains(&value) {
                return Err(wrong(must.what, value, must.meaning));
            }
        }
        let form =
            [(258, "the bits of a sample"), (259, "the compression"), (317, "the predictor"), (339, "the format")];
        let form = form.map(|(tag, what)| tags.whole(tag, what, Some(1)));
        let [bits, compression, predictor, format] = form;
        let form = [bits?, compression?, predictor?, format?];
        if !KINDS.contains(&(form[3], form[0])) {
            let value = format!("format {}, {} bits", form[3], form[0]);
            return Err(wrong("the kind of the heights", value, "whole numbers of 8 to 32 bits, floats of 32 or 64"));
        }
        let strips = tags.wholes(273).zip(tags.wholes(279));
        let tiles = tags.wholes(324).zip(tags.wholes(325));
        let tiled = tiles.is_some();
        let (chunk, (offsets, lengths)) = match (strips, tiles) {
            (Some(strips), None) => {
                let lines = size(tags.whole(278, "the rows of a strip", Some(rows as u64))?);
                ([columns, lines.min(rows)], strips)
            }
            (None, Some(tiles)) => {
                let [width, height] =
                    [(322, "a tile's width"), (323, "a tile's height")].map(|(tag, what)| tags.whole(tag, what, None));
                ([size(width?), size(height?)], tiles)
            }
            _ => return Err(wrong("the places of the samples", "missing, or there twice", "strips or tiles")),
        };
        check_tiles([columns, rows], chunk)?;
        let chunks = columns.div_ceil(chunk[0]) * rows.div_ceil(chunk[1]);
        if offsets.len() != chunks || lengths.len() != chunks || chunks > HEIGHT_CHUNKS {
            let value = format!("{} with {} lengths", offsets.len(), lengths.len());
            return Err(wrong("the number of strips or tiles", value, format!("{chunks}, at most {HEIGHT_CHUNKS}")));
        }
        let packed: Vec<_> = offsets.into_iter().zip(lengths).map(|(at, length)| (size(at), size(length))).collect();
        if packed.iter().all(|packed| *packed == (0, 0)) {
            return Err(wrong("the number of strips or tiles with heights", 0, "at least 1"));
        }
        Ok(Self { columns, rows, chunk, tiled, packed, form })
    }

    /// Reads the samples of the file that the tags are of, as heights.
    ///
    /// # Errors
    /// [`NoHeights`]: a strip or tile reaches beyond the file's end, is too short, or cannot be unpacked.
    pub fn heights(&self, bytes: &[u8], height: impl Fn(f64) -> f32) -> Result<Vec<f32>, NoHeights> {
        let [wide, high] = self.chunk;
        let across = self.columns.div_ceil(wide);
        let big_endian = bytes.starts_with(b"MM");
        let mut heights_m = vec![f32::NAN; self.columns * self.rows];
        for (index, &(from, length)) in self.packed.iter().enumerate().filter(|(_, packed)| **packed != (0, 0)) {
            let (left, top) = (index % across * wide, index / across * high);
            let (width, lines) = (wide.min(self.columns - left), high.min(self.rows - top));
            // A tile is whole also at the edges, a strip ends with the picture.
            let stored = if self.tiled { high } else { lines };
            let beyond = || wrong("a strip or tile", format!("{length} bytes at {from}"), "it must lie in the file");
            let packed = from.checked_add(length).and_then(|end| bytes.get(from..end)).ok_or_else(beyond)?;
            let unpacked = wide * stored * (self.form[0] as usize / 8);
            let spread =
                SPREAD.iter().find(|(compression, _)| *compression == self.form[1]).map_or(1, |(_, spread)| *spread);
            if length.saturating_mul(spread) < unpacked {
                let limit = format!("{unpacked} bytes cannot be packed into so few");
                return Err(wrong("the length of a strip or tile", length, limit));
            }
            // What no compression needs is not copied: many chunks may name the same long piece of the file.
            let packed = &packed[..length.min(2 * unpacked + SPARE)];
            let alone = alone([wide, stored], self.form, packed, big_endian);
            let chunk = samples(read(&alone)?, &height)?;
            if chunk.len() != wide * stored {
                return Err(wrong("the samples of a strip or tile", chunk.len(), format!("{wide} x {stored}")));
            }
            for (line, row) in chunk.chunks_exact(wide).take(lines).enumerate() {
                let at = (top + line) * self.columns + left;
                heights_m[at..at + width].copy_from_slice(&row[..width]);
            }
        }
        Ok(heights_m)
    }
}

/// A strip or tile as a file of its own, with a header of ours: the reader of pictures sees no tag of the file, and unpacks a
/// chunk in one piece (version 0.11 fails at LZW tiles that reach beyond the picture, which it reads row by row).
fn alone(size: [usize; 2], form: [u64; 4], packed: &[u8], big_endian: bool) -> Vec<u8> {
    let [bits, compression, predictor, format] = form.map(|value| value as u32);
    let [width, height] = size.map(|side| side as u32);
    const TAGS: usize = 11;
    let header = 8 + 2 + 12 * TAGS + 4;
    let tags: [(u16, u32); TAGS] = [
        (256, width),
        (257, height),
        (258, bits),
        (259, compression),
        (262, 1),
        (273, header as u32),
        (277, 1),
        (278, height),
        (279, packed.len() as u32),
        (317, predictor),
        (339, format),
    ];
    let two = |value: u16| if big_endian { value.to_be_bytes() } else { value.to_le_bytes() };
    let four = |value: u32| if big_endian { value.to_be_bytes() } else { value.to_le_bytes() };
    let mut file = Vec::with_capacity(header + packed.len());
    file.extend(if big_endian { b"MM" } else { b"II" });
    file.extend(two(42));
    file.extend(four(8));
    file.extend(two(TAGS as u16));
    for (tag, value) in tags {
        // One number of 32 bits.
        file.extend([two(tag), two(4)].concat());
        file.extend([four(1), four(value)].concat());
    }
    file.extend(four(0));
    file.extend(packed);
    file
}

fn read(file: &[u8]) -> Result<DecodingResult, NoHeights> {
    let failed = |error: TiffError| NoHeights::Tiff(error.to_string());
    let mut limits = Limits::default();
    limits.decoding_buffer_size = 8 * HEIGHT_SAMPLES;
    limits.intermediate_buffer_size = HEIGHT_FILE_BYTES;
    Decoder::new(Cursor::new(file)).map_err(failed)?.with_limits(limits).read_image().map_err(failed)
}

/// Tiles are unpacked whole: a small picture must not have huge ones.
fn check_tiles(picture: [usize; 2], tile: [usize; 2]) -> Result<(), NoHeights> {
    let side = |length: usize, tile: usize| (length.div_ceil(tile.max(1)) as u64).saturating_mul(tile as u64);
    let all = side(picture[0], tile[0]).saturating_mul(side(picture[1], tile[1]));
    let most = HEIGHT_PADDING * HEIGHT_SAMPLES as u64;
    if tile.contains(&0) || all > most || tile[0].saturating_mul(tile[1]) > HEIGHT_SAMPLES {
        let value = format!("{} x {}", tile[0], tile[1]);
        return Err(wrong("the tiles' size", value, format!("1 x 1 to {HEIGHT_SAMPLES} samples, {most} in all tiles")));
    }
    Ok(())
}

/// Samples as heights, whatever kind of number the file has.
fn samples(read: DecodingResult, height: impl Fn(f64) -> f32) -> Result<Vec<f32>, NoHeights> {
    fn all<T: Into<f64>>(list: Vec<T>, height: impl Fn(f64) -> f32) -> Vec<f32> {
        list.into_iter().map(|sample| height(sample.into())).collect()
    }
    Ok(match read {
        DecodingResult::U8(list) => all(list, height),
        DecodingResult::I8(list) => all(list, height),
        DecodingResult::U16(list) => all(list, height),
        DecodingResult::I16(list) => all(list, height),
        DecodingResult::U32(list) => all(list, height),
        DecodingResult::I32(list) => all(list, height),
        DecodingResult::F32(list) => all(list, height),
        DecodingResult::F64(list) => all(list, height),
        _ => return Err(wrong("the kind of the heights", "another", "one that the tags name")),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn huge_tiles_of_small_pictures_are_refused() {
        check_tiles([1_000, 700], [256, 256]).expect("usual tiles");
        check_tiles([1_000, 700], [1_000, 1]).expect("strips");
        for tiles in [[0x7fff_ffff, 1], [u32::MAX as usize; 2], [usize::MAX; 2], [0, 16], [16, 0]] {
            assert!(check_tiles([2, 2], tiles).is_err(), "{tiles:?}");
        }
    }
}
