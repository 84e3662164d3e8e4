//! The ground of the settings: a file of heights laid over made relief or over the bare ellipsoid.

use crate::geo::raster::Raster;
use crate::geo::terrain::Terrain;
use crate::wire::heights;
use crate::wire::limits::HEIGHT_FILE_BYTES;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

/// Why a file of heights cannot be the ground.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{path}: {why}")]
pub struct NoGround {
    /// The file.
    pub path: String,
    /// What is wrong with it.
    pub why: String,
}

/// The heights of a file, which count from mean sea level, over another ground.
///
/// # Errors
/// [`NoGround`]: the file is not there, too long, or no file of heights.
pub fn with_heights(around: Terrain, file: &Path, sea_level_m: f64) -> Result<Terrain, NoGround> {
    let failed = |why: String| NoGround { path: file.display().to_string(), why };
    let opened = std::fs::File::open(file).map_err(|error| failed(error.to_string()))?;
    let mut bytes = Vec::new();
    // One byte more than is allowed shows that there are too many, whatever the system says of the length.
    opened.take(HEIGHT_FILE_BYTES as u64 + 1).read_to_end(&mut bytes).map_err(|error| failed(error.to_string()))?;
    if bytes.len() > HEIGHT_FILE_BYTES {
        return Err(failed(format!("longer than {HEIGHT_FILE_BYTES} bytes")));
    }
    let name = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let grid = heights::decode(&name, &bytes).map_err(|wrong| failed(wrong.to_string()))?;
    Ok(Terrain::of(Arc::new(Raster::new(grid, sea_level_m, around))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geo::Geodetic;

    #[test]
    fn a_tile_becomes_the_ground_and_what_is_wrong_is_told_with_its_path() {
        let folder = std::env::temp_dir().join(format!("stormdeck-ground-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let tile = folder.join("N47E008.hgt");
        let heights: Vec<u8> = (0..1_201 * 1_201).flat_map(|_| 700i16.to_be_bytes()).collect();
        std::fs::write(&tile, &heights).expect("a file");
        let ground = with_heights(Terrain::ELLIPSOID, &tile, 48.0).expect("a ground");
        let at = |latitude_deg: f64| Geodetic {
            latitude_rad: latitude_deg.to_radians(),
            longitude_rad: 8.5f64.to_radians(),
            altitude_m: 0.0,
        };
        assert_eq!((ground.height_m(&at(47.5)), ground.height_m(&at(46.5))), (748.0, 0.0));
        let short = folder.join("N46E008.hgt");
        std::fs::write(&short, &heights[1..]).expect("a file");
        for (file, why) in [(short, "an HGT tile has"), (folder.join("none.tif"), "os error 2"), (folder.clone(), "")] {
            let wrong = with_heights(Terrain::ELLIPSOID, &file, 0.0).expect_err("no ground");
            assert!(wrong.path == file.display().to_string() && wrong.why.contains(why), "{wrong}");
        }
        let _gone = std::fs::remove_dir_all(&folder);
    }
}
