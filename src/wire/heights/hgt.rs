//! HGT tiles of the Shuttle Radar Topography Mission: one degree of latitude and longitude, big-endian 16-bit heights, rows from
//! the north, edges shared with the neighbours.

use super::NoHeights;
use crate::geo::raster::Grid;

/// A height that is not known.
const VOID: i16 = -32_768;

/// Reads a tile; `corner` is its name without the end, in small letters.
pub fn decode(corner: &str, bytes: &[u8]) -> Result<Grid, NoHeights> {
    let (south_deg, west_deg) = place(corner).ok_or_else(|| NoHeights::Corner(corner.to_owned()))?;
    let side: u32 = match bytes.len() {
        2_884_802 => 1_201,
        25_934_402 => 3_601,
        other => return Err(NoHeights::Length(other)),
    };
    let height = |pair: &[u8]| match i16::from_be_bytes([pair[0], pair[1]]) {
        VOID => f32::NAN,
        height_m => f32::from(height_m),
    };
    let step_deg = 1.0 / f64::from(side - 1);
    Ok(Grid {
        north_deg: south_deg + 1.0,
        west_deg,
        step_south_deg: step_deg,
        step_east_deg: step_deg,
        columns: side as usize,
        heights_m: bytes.chunks_exact(2).map(height).collect(),
    })
}

/// Latitude and longitude of `n47e008`.
fn place(corner: &str) -> Option<(f64, f64)> {
    let signed = |text: &str, digits: usize, plus: char, minus: char, most: u32| {
        let mut chars = text.chars();
        let letter = chars.next()?;
        let number = chars.as_str();
        let value: u32 = (number.len() == digits && number.bytes().all(|b| b.is_ascii_digit()))
            .then(|| number.parse().ok())
            .flatten()
            .filter(|value| *value <= most)?;
        match letter {
            _ if letter == plus => Some(f64::from(value)),
            _ if letter == minus => Some(-f64::from(value)),
            _ => None,
        }
    };
    // Only what is ASCII can be cut by bytes.
    let corner = Some(corner).filter(|corner| corner.is_ascii() && corner.len() == 7)?;
    let (latitude, longitude) = corner.split_at(3);
    Some((signed(latitude, 2, 'n', 's', 90)?, signed(longitude, 3, 'e', 'w', 180)?))
}
