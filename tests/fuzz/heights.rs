//! Height files: GeoTIFFs of every kind that is read, and HGT tiles written small.

use crate::maker::kinds;
use crate::targets::{Target, words};
use std::sync::Arc;
use stormdeck::geo::Geodetic;
use stormdeck::geo::raster::{Grid, Raster};
use stormdeck::geo::terrain::Terrain;
use stormdeck::wire::heights;

pub const GEOTIFF: Target = Target {
    name: "GeoTIFF height files",
    corpus: || kinds().into_iter().map(|(_, made)| made.bytes()).collect(),
    longest: 4_096,
    inputs: 4_000,
    answer: |input| match heights::decode("a.tif", input) {
        Ok(grid) => seen(grid),
        Err(wrong) => words(&wrong.to_string()),
    },
};

pub const HGT: Target =
    Target { name: "HGT height files", corpus: small_tiles, longest: 4_096, inputs: 4_000, answer: hgt_file };

/// Side of a tile of 3 and of 1 seconds of arc.
const SIDES: [usize; 2] = [1_201, 3_601];

/// A line with a name, then heights, of which a file is made by repeating them.
fn small_tiles() -> Vec<Vec<u8>> {
    let heights: Vec<u8> = (0..300i16).flat_map(|n| (n * 31 % 4_000 - 200).to_be_bytes()).collect();
    let with_voids =
        heights.chunks(2).enumerate().flat_map(|(n, pair)| if n % 7 == 0 { [0x80, 0] } else { [pair[0], pair[1]] });
    vec![
        [b"N47E008.hgt\n".as_slice(), &heights].concat(),
        [b"s03w078.HGT\n".as_slice(), &with_voids.collect::<Vec<u8>>()].concat(),
    ]
}

/// As it is, which is never long enough, and now and then repeated to the length of a tile of 3, seldom of 1 second.
fn hgt_file(input: &[u8]) -> String {
    let end = input.iter().position(|byte| *byte == b'\n').unwrap_or(input.len()).min(24);
    let (name, heights) = (String::from_utf8_lossy(&input[..end]), &input[(end + 1).min(input.len())..]);
    let roll = input.iter().fold(0u32, |sum, byte| sum.wrapping_mul(31).wrapping_add(u32::from(*byte)));
    let side = match roll {
        roll if roll % 2_000 == 7 => SIDES[1],
        roll if roll % 50 == 3 => SIDES[0],
        _ => 0,
    };
    let bytes: Vec<u8> = match side {
        0 => heights.to_vec(),
        side => heights.iter().copied().cycle().take(2 * side * side).collect(),
    };
    match heights::decode(&name, &bytes) {
        Ok(grid) => {
            assert_eq!((grid.columns, grid.heights_m.len()), (side, side * side));
            seen(grid)
        }
        // Without the name that it begins with: each would be an answer of its own.
        Err(wrong) => words(wrong.to_string().rsplit(':').next().unwrap_or_default()),
    }
}

/// What a grid is like as ground: finite wherever it is asked, at any spacing.
fn seen(grid: Grid) -> String {
    assert!(grid.columns >= 2 && grid.heights_m.len().is_multiple_of(grid.columns));
    let holes = grid.heights_m.iter().any(|height_m| height_m.is_nan());
    let known = grid.heights_m.iter().any(|height_m| !height_m.is_nan());
    let rows = grid.heights_m.len() / grid.columns;
    let (north_deg, west_deg) = (grid.north_deg, grid.west_deg);
    let size_deg = [rows as f64 * grid.step_south_deg, grid.columns as f64 * grid.step_east_deg];
    let ground = Terrain::of(Arc::new(Raster::new(grid, 48.0, Terrain::ELLIPSOID)));
    for share in [-0.01, 0.0, 0.013, 0.3, 0.5, 0.999, 1.0, 1.01] {
        let latitude_rad = (north_deg - share * size_deg[0]).clamp(-90.0, 90.0).to_radians();
        let longitude_rad = (west_deg + (1.0 - share) * size_deg[1]).to_radians();
        for spacing_m in [0.0, 100.0, 1e4, 1e7] {
            assert!(ground.smoothed_height_m(latitude_rad, longitude_rad, spacing_m).is_finite());
        }
        let place = Geodetic { latitude_rad, longitude_rad, altitude_m: 0.0 };
        let (normal, rough) = (ground.normal(&place), ground.roughness(&place));
        assert!(normal.is_finite() && rough.grain_m > 0.0 && rough.steepest >= 0.0, "{normal} {rough:?}");
    }
    format!("a grid, holes {holes}, known {known}")
}
