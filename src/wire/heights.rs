//! Height files: a GeoTIFF or an HGT tile becomes a grid of heights, or says what is wrong with it.

mod geotiff;
mod hgt;
mod picture;
mod tags;

use super::limits::HEIGHT_SAMPLES;
use crate::geo::raster::Grid;

/// Why a file gives no heights.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NoHeights {
    /// Its name ends otherwise.
    #[error("`{0}`: a height file ends in .hgt, .tif or .tiff")]
    Kind(String),
    /// The name of an HGT tile does not say where it lies.
    #[error("`{0}`: an HGT tile is named after its south-west corner, as N47E008.hgt")]
    Corner(String),
    /// An HGT tile of another size.
    #[error("{0} bytes: an HGT tile has 1201 x 1201 or 3601 x 3601 heights of 2 bytes")]
    Length(usize),
    /// Not a TIFF, or one of a kind that is not read.
    #[error("cannot be read as a TIFF: {0}")]
    Tiff(String),
    /// Something is missing or otherwise than can be used.
    #[error("{what} is {value}; {limit}")]
    Field {
        /// What.
        what: &'static str,
        /// Its value.
        value: String,
        /// What is allowed.
        limit: String,
    },
}

/// Reads a height file; the end of its name says how.
///
/// # Errors
/// [`NoHeights`].
pub fn decode(name: &str, bytes: &[u8]) -> Result<Grid, NoHeights> {
    let lower = name.to_ascii_lowercase();
    if let Some(corner) = lower.strip_suffix(".hgt") {
        return hgt::decode(corner, bytes);
    }
    if lower.ends_with(".tif") || lower.ends_with(".tiff") {
        return geotiff::decode(bytes);
    }
    Err(NoHeights::Kind(name.to_owned()))
}

fn wrong(what: &'static str, value: impl ToString, limit: impl Into<String>) -> NoHeights {
    NoHeights::Field { what, value: value.to_string(), limit: limit.into() }
}

/// Checks a size before memory is taken for it.
fn check_size(columns: usize, rows: usize) -> Result<(), NoHeights> {
    let size = format!("{columns} x {rows}");
    if columns < 2 || rows < 2 {
        return Err(wrong("the size", size, "at least 2 x 2 heights"));
    }
    if columns.saturating_mul(rows) > HEIGHT_SAMPLES {
        return Err(wrong("the size", size, format!("at most {HEIGHT_SAMPLES} heights")));
    }
    Ok(())
}

#[cfg(test)]
mod tests;
