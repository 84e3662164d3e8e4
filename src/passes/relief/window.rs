//! Heights and distances from the shore on grids around the eye, made on the CPU for both executors.
//!
//! *What it is.* For each level [`WIDTH`] x [`WIDTH`] nodes, twice as far apart as those of the level before.
//! *How we compute it.* From the height function, node by node, without what is finer than the spacing.
//! *How we store it.* Nodes lie at whole multiples of the spacing in one chart of the globe, so that they stand on the ground
//! while the eye flies; they are made in tiles and kept. A node is 32 bits: 16 of height, 16 of distance from the shore.
//! *How we read it back.* Bilinear, between two levels by the distance from the eye: see [`super::field`].

use super::LEVELS;
use crate::geo::charts::place_of;
use crate::geo::coast::coarse_shore_m;
use crate::geo::terrain::{HIGHEST_M, LOWEST_M, Terrain};
use glam::DVec2;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Nodes of a tile each way.
pub const TILE: usize = 32;
/// Tiles of a level each way.
pub const TILES: usize = 12;
/// Nodes of a level each way.
pub const WIDTH: usize = TILE * TILES;
/// Tiles before the one that the eye is in.
const BEFORE: i32 = TILES as i32 / 2;
/// Metres of one unit of height.
pub const HEIGHT_UNIT_M: f64 = (HIGHEST_M - LOWEST_M) / 65_535.0;

/// What a window is made from; equal ones give the same bytes.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// Where the ground is.
    pub terrain: Terrain,
    /// Which chart the grids lie in.
    pub chart: usize,
    /// Spacing of the first level's nodes, in the chart.
    pub spacing_m: f64,
    /// First tile of each level, east and north.
    pub first_tile: [[i32; 2]; LEVELS],
}

impl Window {
    /// The window around a place given in a chart.
    pub fn around(terrain: Terrain, chart: usize, eye_m: DVec2, spacing_m: f64) -> Self {
        let first_tile = std::array::from_fn(|level| {
            let tile_m = spacing_m * (TILE << level) as f64;
            [eye_m.x, eye_m.y].map(|along| (along / tile_m).floor() as i32 - BEFORE)
        });
        Self { terrain, chart, spacing_m, first_tile }
    }

    /// Spacing of a level's nodes.
    pub fn level_spacing_m(&self, level: usize) -> f64 {
        self.spacing_m * (1u32 << level) as f64
    }

    /// Where a place of the chart lies in a level, in nodes.
    pub fn nodes(&self, level: usize, place_m: DVec2) -> DVec2 {
        let [east, north] = self.first_tile[level].map(|tile| f64::from(tile) * TILE as f64);
        place_m / self.level_spacing_m(level) - DVec2::new(east, north)
    }

    /// Metres of one unit of a level's distances from the shore: they reach farther than a node.
    pub fn shore_unit_m(&self, level: usize) -> f64 {
        (2.0 * self.level_spacing_m(level) / 32_000.0).max(0.5)
    }
}

/// The nodes of one tile, rows from the south.
type Tile = Vec<u32>;

/// Which tile: level by its spacing, east, north.
type Key = (u64, i32, i32);

/// Tiles that have been made, and the levels put together from them.
#[derive(Default)]
pub struct Tiles {
    /// Of which terrain and chart.
    of: Option<(Terrain, usize)>,
    tiles: BTreeMap<Key, Arc<Tile>>,
}

impl Tiles {
    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        self.tiles.values().map(|tile| size_of_val(tile.as_slice())).sum()
    }

    /// All nodes of a window, level by level, rows from the south.
    pub fn nodes(&mut self, window: &Window) -> Vec<u32> {
        self.filled(window, tile)
    }

    /// The same of something else than heights: `make` fills a tile (level, then its numbers east and north).
    pub fn filled(&mut self, window: &Window, make: fn(&Window, usize, [i32; 2]) -> Vec<u32>) -> Vec<u32> {
        let of = (window.terrain.clone(), window.chart);
        if self.of.as_ref() != Some(&of) {
            self.tiles.clear();
            self.of = Some(of);
        }
        let keys: Vec<(usize, Key)> = (0..LEVELS).flat_map(|level| keys(window, level)).collect();
        let missing: Vec<_> = keys.iter().filter(|(_, key)| !self.tiles.contains_key(key)).collect();
        let made: Vec<_> =
            missing.par_iter().map(|(level, key)| (*key, Arc::new(make(window, *level, [key.1, key.2])))).collect();
        self.tiles.extend(made);
        let mut nodes = vec![0; LEVELS * WIDTH * WIDTH];
        for (i, (_, key)) in keys.iter().enumerate() {
            let (level, at) = (i / (TILES * TILES), i % (TILES * TILES));
            let corner = level * WIDTH * WIDTH + (at / TILES) * TILE * WIDTH + (at % TILES) * TILE;
            for (row, texels) in self.tiles[key].chunks_exact(TILE).enumerate() {
                nodes[corner + row * WIDTH..][..TILE].copy_from_slice(texels);
            }
        }
        // What lies in the window stays, and as much again of what lay in it before.
        if self.tiles.len() > 2 * keys.len() {
            let wanted: std::collections::BTreeSet<Key> = keys.iter().map(|(_, key)| *key).collect();
            self.tiles.retain(|key, _| wanted.contains(key));
        }
        nodes
    }
}

/// Height that no node exceeds, metres.
pub fn highest_m(nodes: &[u32]) -> f32 {
    let highest = nodes.iter().map(|node| node & 0xffff).max().unwrap_or(0);
    (f64::from(highest) * HEIGHT_UNIT_M + LOWEST_M) as f32 + 1.0
}

/// The tiles of a level, row by row from the south-west.
fn keys(window: &Window, level: usize) -> impl Iterator<Item = (usize, Key)> {
    let [east, north] = window.first_tile[level];
    let spacing = window.level_spacing_m(level).to_bits();
    (0..(TILES * TILES) as i32).map(move |i| (level, (spacing, east + i % TILES as i32, north + i / TILES as i32)))
}

fn tile(window: &Window, level: usize, [east, north]: [i32; 2]) -> Tile {
    let (spacing_m, unit_m) = (window.level_spacing_m(level), window.shore_unit_m(level));
    let node = |i: usize| {
        let at = |tile: i32, k: usize| (f64::from(tile) * TILE as f64 + k as f64) * spacing_m;
        let (latitude_rad, longitude_rad) = place_of(window.chart, DVec2::new(at(east, i % TILE), at(north, i / TILE)));
        let height_m = window.terrain.smoothed_height_m(latitude_rad, longitude_rad, spacing_m);
        packed(height_m, coarse_shore_m(latitude_rad, longitude_rad, spacing_m) / unit_m)
    };
    (0..TILE * TILE).map(node).collect()
}

/// Height and distance from the shore in 32 bits.
fn packed(height_m: f64, shore_units: f64) -> u32 {
    let height = ((height_m - LOWEST_M) / HEIGHT_UNIT_M).round().clamp(0.0, 65_535.0) as u32;
    let shore = (shore_units.round() + 32_768.0).clamp(0.0, 65_535.0) as u32;
    height | shore << 16
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geo::terrain::Heights;

    /// Rises with the latitude, so that a node tells where it is.
    #[derive(Debug)]
    struct Ramp;

    impl Heights for Ramp {
        fn height_m(&self, latitude_rad: f64, _: f64, _: f64) -> f64 {
            4_000.0 + latitude_rad * 2_000.0
        }
    }

    #[test]
    fn nodes_stand_on_the_ground_whatever_the_window() {
        let terrain = Terrain::of(Arc::new(Ramp));
        let eye_m = DVec2::new(123_456.7, -98_765.4);
        let mut tiles = Tiles::default();
        let first = Window::around(terrain.clone(), 3, eye_m, 30.0);
        let before = tiles.nodes(&first);
        // 5 km on, some tiles are new; from scratch the bytes are the same.
        let second = Window::around(terrain, 3, eye_m + DVec2::new(5_000.0, 3_000.0), 30.0);
        let after = tiles.nodes(&second);
        assert_eq!(after, Tiles::default().nodes(&second));
        assert!(before != after, "other tiles");
        for (level, place_m) in [(0, eye_m + DVec2::new(1_000.0, 1_000.0)), (4, eye_m), (7, eye_m)] {
            let at = |window: &Window, nodes: &[u32]| {
                let at = window.nodes(level, place_m).floor().as_usizevec2();
                nodes[level * WIDTH * WIDTH + at.y * WIDTH + at.x]
            };
            assert_eq!(at(&first, &before), at(&second, &after), "{level}");
        }
    }

    #[test]
    fn the_eye_is_in_the_middle_of_every_level() {
        for eye_m in [DVec2::ZERO, DVec2::new(-1e6, 2e6), DVec2::new(959.9, -0.1)] {
            let window = Window::around(Terrain::ELLIPSOID, 0, eye_m, 30.0);
            for level in 0..LEVELS {
                let at = window.nodes(level, eye_m);
                let middle = (BEFORE * TILE as i32) as f64;
                assert!(at.min_element() >= middle && at.max_element() < middle + TILE as f64, "{level}: {at}");
            }
        }
    }
}
