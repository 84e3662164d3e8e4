//! GeoTIFFs of heights in degrees of latitude and longitude (OGC 19-008r4): one band, north up.

use super::{NoHeights, check_size, wrong};
use crate::geo::raster::Grid;
use crate::wire::limits::HEIGHT_SAMPLES;
use std::io::Cursor;
use tiff::TiffError;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

/// Keys of the GeoKeyDirectory (OGC 19-008r4, annex B): what the coordinates are, and whether a sample is an area or a point.
const MODEL_TYPE: u32 = 1024;
const RASTER_TYPE: u32 = 1025;
const GEODETIC_CRS: u32 = 2048;
/// `MODEL_TYPE` of latitudes and longitudes.
const GEOGRAPHIC: u32 = 2;
/// `RASTER_TYPE` of samples that are points; else they are areas, which begin half a step earlier.
const POINT: u32 = 2;
/// WGS 84, and the national systems that lie within a metre or two of it: ETRS89 and NAD83.
const CLOSE_TO_WGS84: [u32; 3] = [4326, 4258, 4269];
/// Units, where a file names them: degrees and metres.
const ANGULAR_UNITS: (u32, u32) = (2054, 9102);
const VERTICAL_UNITS: (u32, u32) = (4099, 9001);
/// Samples of all tiles over those of the picture at most: tiles reach beyond its edges.
const PADDING: u64 = 4;
/// Heights of this planet's land, with room to spare; what lies beyond is a mark for a height that is not known.
const LAND_M: std::ops::RangeInclusive<f64> = -1_000.0..=9_100.0;
/// Longest value of a tag in bytes: the keys of a file have some hundreds.
const TAG_BYTES: usize = 64 * 1024;

type Tiff<'a> = Decoder<Cursor<&'a [u8]>>;

/// Reads the first image of a file.
pub fn decode(bytes: &[u8]) -> Result<Grid, NoHeights> {
    let failed = |error: TiffError| NoHeights::Tiff(error.to_string());
    let mut limits = Limits::default();
    limits.decoding_buffer_size = 8 * HEIGHT_SAMPLES;
    limits.intermediate_buffer_size = 8 * HEIGHT_SAMPLES;
    limits.ifd_value_size = TAG_BYTES;
    let mut tiff = Decoder::new(Cursor::new(bytes)).map_err(failed)?.with_limits(limits);
    let (columns, rows) = tiff.dimensions().map_err(failed)?;
    check_size(columns as usize, rows as usize)?;
    check_tiles([columns, rows], tiff.chunk_dimensions())?;
    let keys = Keys::of(&mut tiff)?;
    let (west_deg, north_deg, step_east_deg, step_south_deg) = place(&mut tiff, &keys)?;
    let void = void(&mut tiff);
    let height = |sample: f64| match void {
        // The mark is written as text; in the file it has been rounded.
        Some(void) if sample == void || sample == f64::from(void as f32) => f32::NAN,
        _ if LAND_M.contains(&sample) => sample as f32,
        // No height on this planet: not known, whatever the file calls it.
        _ => f32::NAN,
    };
    let heights_m = heights(tiff.read_image().map_err(failed)?, height)?;
    if heights_m.len() != columns as usize * rows as usize {
        let limit = format!("one height for each of {columns} x {rows}");
        return Err(wrong("the number of values", heights_m.len(), limit));
    }
    Ok(Grid { north_deg, west_deg, step_south_deg, step_east_deg, columns: columns as usize, heights_m })
}

/// Tiles are unpacked whole: a small picture must not have huge ones.
fn check_tiles(picture: [u32; 2], (width, height): (u32, u32)) -> Result<(), NoHeights> {
    let side = |length: u32, tile: u32| u64::from(length.div_ceil(tile.max(1))) * u64::from(tile);
    let all = side(picture[0], width).saturating_mul(side(picture[1], height));
    if width == 0 || height == 0 || all > PADDING * HEIGHT_SAMPLES as u64 {
        let limit = format!("1 x 1 to {} samples in all tiles together", PADDING * HEIGHT_SAMPLES as u64);
        return Err(wrong("the tiles' size", format!("{width} x {height}"), limit));
    }
    Ok(())
}

/// The keys that matter.
struct Keys {
    point: bool,
}

impl Keys {
    fn of(tiff: &mut Tiff) -> Result<Self, NoHeights> {
        let missing =
            |error: TiffError| wrong("the GeoTIFF's key directory", format!("missing ({error})"), "it is needed");
        let words = tiff.get_tag_u32_vec(Tag::GeoKeyDirectoryTag).map_err(missing)?;
        // Four words of header, then four a key: id, where the value stands (0: here), how many, the value.
        let key = |id: u32| words.get(4..)?.chunks_exact(4).find(|key| key[0] == id && key[1] == 0).map(|key| key[3]);
        match key(MODEL_TYPE) {
            Some(GEOGRAPHIC) => {}
            other => {
                let value = other.map_or_else(|| "missing".to_owned(), |other| other.to_string());
                let limit = "2, latitudes and longitudes; convert the file: gdalwarp -t_srs EPSG:4326";
                return Err(wrong("the model type", value, limit));
            }
        }
        if let Some(crs) = key(GEODETIC_CRS).filter(|crs| !CLOSE_TO_WGS84.contains(crs)) {
            let limit = "4326 (WGS 84), 4258 (ETRS89) or 4269 (NAD83)";
            return Err(wrong("the coordinate system", format!("EPSG:{crs}"), limit));
        }
        for ((id, right), what) in [(ANGULAR_UNITS, "the unit of angles"), (VERTICAL_UNITS, "the unit of heights")] {
            if let Some(unit) = key(id).filter(|unit| *unit != right) {
                return Err(wrong(what, format!("EPSG:{unit}"), format!("{right} (degrees 9102, metres 9001)")));
            }
        }
        Ok(Self { point: key(RASTER_TYPE) == Some(POINT) })
    }
}

/// Longitude and latitude of the first sample, and the steps.
fn place(tiff: &mut Tiff, keys: &Keys) -> Result<(f64, f64, f64, f64), NoHeights> {
    let mut numbers = |tag: Tag, what: &'static str, count: usize| {
        let found =
            tiff.get_tag_f64_vec(tag).map_err(|error| wrong(what, format!("missing ({error})"), "it is needed"))?;
        let usable = found.len() >= count && found[..count].iter().all(|number| number.is_finite());
        usable.then_some(found).ok_or_else(|| wrong(what, "too short or not finite", format!("{count} numbers")))
    };
    let scale = numbers(Tag::ModelPixelScaleTag, "the pixel scale", 2)?;
    let tie = numbers(Tag::ModelTiepointTag, "the tie point", 6)?;
    let (east, south) = (scale[0], scale[1]);
    for (what, step) in [("the step eastwards", east), ("the step southwards", south)] {
        if !(1e-6..=10.0).contains(&step) {
            return Err(wrong(what, step, "0.000001 to 10 degrees"));
        }
    }
    // A sample that is an area is tied at its corner; its height is that of its middle.
    let half = if keys.point { 0.0 } else { 0.5 };
    let west = tie[3] + (half - tie[0]) * east;
    let mut north = tie[4] - (half - tie[1]) * south;
    // A grid of the globe may miss the pole by rounding.
    if north > 90.0 && north < 90.0 + 1e-6 {
        north = 90.0;
    }
    if !(-90.0..=90.0).contains(&north) || !(-360.0..=360.0).contains(&west) {
        return Err(wrong("the first height", format!("at {north} N {west} E"), "-90 to 90 N, -360 to 360 E"));
    }
    Ok((west, north, east, south))
}

/// The value that stands for a height that is not known, as GDAL writes it.
fn void(tiff: &mut Tiff) -> Option<f64> {
    let text = tiff.get_tag_ascii_string(Tag::GdalNodata).ok()?;
    text.trim_matches(|c: char| c.is_whitespace() || c == '\0').parse().ok()
}

/// The samples as heights, whatever kind of number the file has.
fn heights(read: DecodingResult, height: impl Fn(f64) -> f32) -> Result<Vec<f32>, NoHeights> {
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
        _ => {
            return Err(wrong(
                "the kind of the heights",
                "another",
                "whole numbers of 8 to 32 bits, floats of 32 or 64",
            ));
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn huge_tiles_of_small_pictures_are_refused() {
        check_tiles([1_000, 700], (256, 256)).expect("usual tiles");
        check_tiles([1_000, 700], (1_000, 1)).expect("strips");
        for tiles in [(0x7fff_ffff, 1), (u32::MAX, u32::MAX), (0, 16), (16, 0)] {
            assert!(check_tiles([2, 2], tiles).is_err(), "{tiles:?}");
        }
    }
}
