//! The coastline: how far a place is from the shore, and on which side of it.
//!
//! *What it is.* Natural Earth's land at 1:10 million (`data/coast.bin`; see `data/README.md`), rings of points.
//! *How we compute it.* Distances on a grid by handing the nearest edge on from node to node; land by counting the edges
//! between the south pole and the place along its meridian, so that neither pole nor 180th meridian is a special case.
//! *How we store it.* In blocks of one degree with nodes every hundredth (1.1 km), made when first asked for; for coarse
//! pictures in blocks of eight degrees.
//! *How we read it back.* Bilinear; close to the shore made wiggles add the bays that the table is too coarse for.

mod block;
mod rings;

use crate::numeric::noise::spatial as noise;
use block::{Block, NODES};
use glam::DVec3;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

/// Distances are kept up to this: beyond it is only land or sea.
pub const REACH_M: f64 = 25_000.0;
/// The same in blocks for coarse pictures.
const COARSE_REACH_M: f64 = 100_000.0;
/// Degrees between the nodes of a block, fine and coarse.
const STEP_DEG: [f64; 2] = [0.01, 0.08];
/// Spacing from which on the coarse blocks are fine enough.
const COARSE_FROM_M: f64 = 3_000.0;
/// Blocks kept at once (41 KiB each).
const KEPT: usize = 512;
/// Bays and headlands that are made up: their size, and how far they move the shore.
const WIGGLES: [(f64, f64); 3] = [(1_900.0, 150.0), (700.0, 70.0), (260.0, 28.0)];

/// Distance from the shore in metres, above 0 on land, below 0 at sea, no farther than [`REACH_M`], for a place in radians.
pub fn shore_m(latitude_rad: f64, longitude_rad: f64) -> f64 {
    coarse_shore_m(latitude_rad, longitude_rad, 0.0)
}

/// The same as seen at a spacing: without the bays that are finer than it.
pub fn coarse_shore_m(latitude_rad: f64, longitude_rad: f64, spacing_m: f64) -> f64 {
    let level = usize::from(spacing_m >= COARSE_FROM_M);
    let latitude_deg = latitude_rad.to_degrees().clamp(-90.0, 90.0);
    let longitude_deg = (longitude_rad.to_degrees() + 180.0).rem_euclid(360.0) - 180.0;
    let charted = charted_m(level, latitude_deg, longitude_deg);
    let mut found = charted;
    for (size_m, moved_m) in WIGGLES {
        // Only near the shore, and only what the spacing can show.
        let there = (1.0 - charted.abs() / 3_000.0).clamp(0.0, 1.0)
            * (size_m / (2.0 * spacing_m.max(1.0)) - 1.0).clamp(0.0, 1.0);
        if there > 0.0 {
            let (sin_lat, cos_lat) = latitude_rad.sin_cos();
            let (sin_lon, cos_lon) = longitude_rad.sin_cos();
            let up = DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat);
            found += there * moved_m * noise(up * (6_371_000.0 / size_m), 71);
        }
    }
    found
}

fn charted_m(level: usize, latitude_deg: f64, longitude_deg: f64) -> f64 {
    let step = STEP_DEG[level];
    let size = step * (NODES - 1) as f64;
    let column = (((longitude_deg + 180.0) / size) as i32).min((360.0 / size).ceil() as i32 - 1);
    let row = (((latitude_deg + 90.0) / size) as i32).min((180.0 / size).ceil() as i32 - 1);
    let x = (longitude_deg + 180.0 - f64::from(column) * size) / step;
    let y = (latitude_deg + 90.0 - f64::from(row) * size) / step;
    f64::from(block(level, column, row).at(x, y))
}

/// A block: from those kept, or made. Which ones are kept changes no number.
fn block(level: usize, column: i32, row: i32) -> Arc<Block> {
    type Entry = ((usize, i32, i32), Arc<Block>);
    static BLOCKS: Mutex<VecDeque<Entry>> = Mutex::new(VecDeque::new());
    thread_local! {
        // Neighbouring places ask for the same block: the lock is taken where that changes.
        static LAST: RefCell<Option<Entry>> = const { RefCell::new(None) };
    }
    let key = (level, column, row);
    let last = LAST.with_borrow(|last| last.as_ref().filter(|(k, _)| *k == key).map(|(_, block)| block.clone()));
    if let Some(block) = last {
        return block;
    }
    let look = || {
        let mut kept = BLOCKS.lock().unwrap_or_else(PoisonError::into_inner);
        let found = kept.iter().position(|(k, _)| *k == key).and_then(|at| kept.remove(at));
        found.map(|entry| {
            kept.push_front(entry.clone());
            entry.1
        })
    };
    let found = look().unwrap_or_else(|| {
        let reach_m = if level == 0 { REACH_M } else { COARSE_REACH_M };
        let made = Arc::new(Block::new(rings::shared(), STEP_DEG[level], column, row, reach_m));
        // Two threads may have made it at once: the same bytes.
        let mut kept = BLOCKS.lock().unwrap_or_else(PoisonError::into_inner);
        kept.push_front((key, made.clone()));
        kept.truncate(KEPT);
        made
    });
    LAST.set(Some((key, found.clone())));
    found
}

#[cfg(test)]
mod tests;
