//! GeoTIFFs of heights in degrees of latitude and longitude (OGC 19-008r4): one band, north up.

use super::picture::Picture;
use super::tags::Tags;
use super::{NoHeights, wrong};
use crate::geo::raster::Grid;

/// Tags of a GeoTIFF, and GDAL's mark for what is not known.
const PIXEL_SCALE: u16 = 33_550;
const TIE_POINT: u16 = 33_922;
const KEY_DIRECTORY: u16 = 34_735;
const GDAL_NODATA: u16 = 42_113;
/// Keys of the GeoKeyDirectory (OGC 19-008r4, annex B): what the coordinates are, and whether a sample is an area or a point.
const MODEL_TYPE: u64 = 1024;
const RASTER_TYPE: u64 = 1025;
const GEODETIC_CRS: u64 = 2048;
/// `MODEL_TYPE` of latitudes and longitudes.
const GEOGRAPHIC: u64 = 2;
/// `RASTER_TYPE` of samples that are points; else they are areas, which begin half a step earlier.
const POINT: u64 = 2;
/// WGS 84, and the national systems that lie within a metre or two of it: ETRS89 and NAD83.
const CLOSE_TO_WGS84: [u64; 3] = [4326, 4258, 4269];
/// Units, where a file names them: degrees and metres.
const ANGULAR_UNITS: (u64, u64) = (2054, 9102);
const VERTICAL_UNITS: (u64, u64) = (4099, 9001);
/// Heights of this planet's land, with room to spare; what lies beyond is a mark for a height that is not known.
const LAND_M: std::ops::RangeInclusive<f64> = -1_000.0..=9_100.0;

/// Reads the first image of a file.
pub fn decode(bytes: &[u8]) -> Result<Grid, NoHeights> {
    let tags = Tags::of(bytes)?;
    let picture = Picture::of(&tags)?;
    let keys = Keys::of(&tags)?;
    let (west_deg, north_deg, step_east_deg, step_south_deg) = place(&tags, &keys)?;
    let void = void(&tags);
    let height = |sample: f64| match void {
        // The mark is written as text; in the file it has been rounded.
        Some(void) if sample == void || sample == f64::from(void as f32) => f32::NAN,
        _ if LAND_M.contains(&sample) => sample as f32,
        // No height on this planet: not known, whatever the file calls it.
        _ => f32::NAN,
    };
    let heights_m = picture.heights(bytes, height)?;
    Ok(Grid { north_deg, west_deg, step_south_deg, step_east_deg, columns: picture.columns, heights_m })
}

/// The keys that matter.
struct Keys {
    point: bool,
}

impl Keys {
    fn of(tags: &Tags) -> Result<Self, NoHeights> {
        let words = tags
            .wholes(KEY_DIRECTORY)
            .ok_or_else(|| wrong("the GeoTIFF's key directory", "missing", "it is needed (tag 34735)"))?;
        // Four words of header, then four a key: id, where the value stands (0: here), how many, the value.
        let key = |id: u64| words.get(4..)?.chunks_exact(4).find(|key| key[0] == id && key[1] == 0).map(|key| key[3]);
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
fn place(tags: &Tags, keys: &Keys) -> Result<(f64, f64, f64, f64), NoHeights> {
    let numbers = |tag: u16, what: &'static str, count: usize| {
        let found = tags.doubles(tag).ok_or_else(|| wrong(what, format!("missing (tag {tag})"), "it is needed"))?;
        let usable = found.len() >= count && found[..count].iter().all(|number| number.is_finite());
        usable.then_some(found).ok_or_else(|| wrong(what, "too short or not finite", format!("{count} numbers")))
    };
    let scale = numbers(PIXEL_SCALE, "the pixel scale", 2)?;
    let tie = numbers(TIE_POINT, "the tie point", 6)?;
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
fn void(tags: &Tags) -> Option<f64> {
    tags.text(GDAL_NODATA)?.trim().parse().ok()
}
