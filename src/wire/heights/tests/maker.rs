//! Makes GeoTIFFs of 16-bit heights for tests: strips or tiles, TIFF or BigTIFF, both byte orders, packed in any way that is read.

use std::collections::BTreeMap;
use std::io::Cursor;
use tiff::decoder::Decoder;
use tiff::encoder::{Compression, DeflateLevel, TiffEncoder, colortype::Gray8};
use tiff::tags::Tag;

/// A file to be made.
#[derive(Clone)]
pub struct Maker {
    /// Most significant bytes first.
    pub big_endian: bool,
    /// BigTIFF.
    pub big: bool,
    /// Width and height of a tile; `None`: strips of one row.
    pub tile: Option<[usize; 2]>,
    /// How samples are packed.
    pub compression: Compression,
    /// Each sample but a row's first as the difference from the one before.
    pub differences: bool,
    /// A strip or tile that the file leaves out, as GDAL's sparse files do.
    pub left_out: Option<usize>,
    /// Tags beside or instead of the usual ones: number, type, values.
    pub tags: Vec<(u16, u16, Vec<u64>)>,
    /// Samples in a row.
    pub columns: usize,
    /// Heights, rows from the north.
    pub heights_m: Vec<i16>,
}

impl Maker {
    /// A plain file of 20 x 18 heights from 8 E 47 N, half and a quarter of a degree apart, -9999 where nothing is known.
    pub fn plain() -> Self {
        let mut heights_m: Vec<i16> = (0..360).map(|n| (n * 37 % 4_500) - 300).collect();
        heights_m[25] = -9_999;
        Self {
            big_endian: false,
            big: false,
            tile: None,
            compression: Compression::Uncompressed,
            differences: false,
            left_out: None,
            tags: Vec::new(),
            columns: 20,
            heights_m,
        }
    }

    /// The file.
    pub fn bytes(&self) -> Vec<u8> {
        let chunks = self.chunks();
        let wide = if self.big { 8 } else { 4 };
        let doubles = |list: &[f64]| list.iter().map(|number| number.to_bits()).collect::<Vec<u64>>();
        let compression = match self.compression {
            Compression::Uncompressed => 1,
            Compression::Lzw => 5,
            Compression::Deflate(_) => 8,
            Compression::Packbits => 32_773,
        };
        let lengths: Vec<u64> = chunks.iter().map(|chunk| chunk.len() as u64).collect();
        let rows = (self.heights_m.len() / self.columns) as u64;
        let mut tags: BTreeMap<u16, (u16, Vec<u64>)> = BTreeMap::from([
            (256, (4, vec![self.columns as u64])),
            (257, (3, vec![rows])),
            (258, (3, vec![16])),
            (259, (3, vec![compression])),
            (262, (3, vec![1])),
            (277, (3, vec![1])),
            (317, (3, vec![1 + u64::from(self.differences)])),
            (339, (3, vec![2])),
            (33_550, (12, doubles(&[0.5, 0.25, 0.0]))),
            (33_922, (12, doubles(&[0.0, 0.0, 0.0, 8.0, 47.0, 0.0]))),
            (34_735, (3, vec![1, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326])),
            (42_113, (2, "-9999\0".bytes().map(u64::from).collect())),
        ]);
        let (offsets, counts) = match self.tile {
            Some([width, height]) => {
                tags.extend([(322, (3, vec![width as u64])), (323, (3, vec![height as u64]))]);
                (324, 325)
            }
            None => {
                tags.insert(278, (3, vec![1]));
                (273, 279)
            }
        };
        tags.extend([(offsets, (4, vec![0; chunks.len()])), (counts, (4, lengths.clone()))]);
        tags.extend(self.tags.iter().map(|(tag, kind, values)| (*tag, (*kind, values.clone()))));
        // Header, directory, values that do not fit into it, samples.
        let header = if self.big { 16 } else { 8 };
        let directory = if self.big { 8 + 20 * tags.len() + 8 } else { 2 + 12 * tags.len() + 4 };
        let beside = |(kind, values): &(u16, Vec<u64>)| Some(values.len() * size_of(*kind)).filter(|size| *size > wide);
        let mut samples_at = header + directory + tags.values().filter_map(beside).sum::<usize>();
        let asked = self.tags.iter().any(|(tag, ..)| *tag == offsets);
        if let Some((_, places)) = tags.get_mut(&offsets).filter(|_| !asked) {
            for (place, chunk) in places.iter_mut().zip(&chunks) {
                *place = if chunk.is_empty() { 0 } else { samples_at as u64 };
                samples_at += chunk.len();
            }
        }
        let put = |value: u64, size: usize| self.put(value, size);
        let mut bytes = if self.big_endian { b"MM".to_vec() } else { b"II".to_vec() };
        match self.big {
            true => bytes.extend([put(43, 2), put(8, 2), put(0, 2), put(16, 8), put(tags.len() as u64, 8)].concat()),
            false => bytes.extend([put(42, 2), put(8, 4), put(tags.len() as u64, 2)].concat()),
        }
        let mut values_at = header + directory;
        let mut values = Vec::new();
        for (tag, entry) in &tags {
            let (kind, list) = entry;
            bytes.extend([put((*tag).into(), 2), put((*kind).into(), 2), put(list.len() as u64, wide)].concat());
            let mut value: Vec<u8> = list.iter().flat_map(|number| put(*number, size_of(*kind))).collect();
            if let Some(size) = beside(entry) {
                bytes.extend(put(values_at as u64, wide));
                values_at += size;
                values.append(&mut value);
            } else {
                value.resize(wide, 0);
                bytes.append(&mut value);
            }
        }
        bytes.extend(put(0, wide));
        [bytes, values, chunks.concat()].concat()
    }

    /// Packed samples of each strip or tile.
    fn chunks(&self) -> Vec<Vec<u8>> {
        let (columns, rows) = (self.columns, self.heights_m.len() / self.columns);
        let [width, height] = self.tile.unwrap_or([columns, 1]);
        let mut chunks = Vec::new();
        for top in (0..rows).step_by(height) {
            for left in (0..columns).step_by(width) {
                if self.left_out == Some(chunks.len()) {
                    chunks.push(Vec::new());
                    continue;
                }
                let mut bytes = Vec::new();
                for row in top..top + height {
                    let mut before = 0i16;
                    for column in left..left + width {
                        let inside = row < rows && column < columns;
                        let sample = if inside { self.heights_m[row * columns + column] } else { 0 };
                        let told = if self.differences { sample.wrapping_sub(before) } else { sample };
                        before = sample;
                        bytes.extend(self.put(u64::from(told as u16), 2));
                    }
                }
                chunks.push(packed(&bytes, self.compression));
            }
        }
        chunks
    }

    fn put(&self, value: u64, size: usize) -> Vec<u8> {
        if self.big_endian { value.to_be_bytes()[8 - size..].to_vec() } else { value.to_le_bytes()[..size].to_vec() }
    }
}

fn size_of(kind: u16) -> usize {
    match kind {
        1 | 2 => 1,
        3 => 2,
        4 => 4,
        _ => 8,
    }
}

/// Bytes as the encoder of another file packs them.
fn packed(bytes: &[u8], compression: Compression) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut file).expect("a file").with_compression(compression);
    encoder.write_image::<Gray8>(bytes.len() as u32, 1, bytes).expect("an image");
    let file = file.into_inner();
    let mut decoder = Decoder::new(Cursor::new(&file)).expect("our own file");
    let mut one = |tag: Tag| decoder.get_tag_u64_vec(tag).expect("a tag")[0] as usize;
    let (at, length) = (one(Tag::StripOffsets), one(Tag::StripByteCounts));
    file[at..at + length].to_vec()
}

/// Files of every kind that is read, with what makes each different.
pub fn kinds() -> Vec<(&'static str, Maker)> {
    let plain = Maker::plain;
    vec![
        ("strips", plain()),
        ("big endian", Maker { big_endian: true, ..plain() }),
        ("BigTIFF", Maker { big: true, ..plain() }),
        ("BigTIFF, big endian, tiles", Maker { big: true, big_endian: true, tile: Some([16, 16]), ..plain() }),
        ("tiles", Maker { tile: Some([16, 16]), ..plain() }),
        (
            "deflate",
            Maker { compression: Compression::Deflate(DeflateLevel::Balanced), tile: Some([16, 16]), ..plain() },
        ),
        ("LZW with differences", Maker { compression: Compression::Lzw, differences: true, ..plain() }),
        (
            "LZW in big-endian tiles",
            Maker { compression: Compression::Lzw, big_endian: true, tile: Some([16, 16]), ..plain() },
        ),
        (
            "LZW in tiles with differences",
            Maker { compression: Compression::Lzw, differences: true, tile: Some([16, 16]), ..plain() },
        ),
        ("PackBits", Maker { compression: Compression::Packbits, ..plain() }),
    ]
}
