//! Where towns are, as a share by place: people live on the floors of valleys, so that made-up mountains keep clear of them.
//!
//! *How we compute it.* Each town has a round of its own, wider for more people; where rounds overlap, what each leaves of the
//! mountains is multiplied. *How we store it.* In blocks of one degree with nodes every fiftieth (2.2 km), made when first asked
//! for. *How we read it back.* Bilinear.

use crate::geo::cities::near;
use glam::DVec3;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

/// Steps of a block each way, one degree in all.
const STEPS: usize = 50;
const NODES: usize = STEPS + 1;
/// Blocks kept at once (10 KiB each).
const KEPT: usize = 512;
/// Radius of the smallest town's round, and how much of a town's own radius comes on top.
const LEAST_M: f64 = 7_000.0;
const RADII: f64 = 1.6;
/// No round is wider: the largest city has a radius of 48 km.
const MOST_M: f64 = LEAST_M + RADII * 48_000.0;
const EARTH_M: f64 = 6_371_000.0;
/// From here on rounds are smaller than what is looked at, and none is told.
const COARSEST_M: f64 = 3_840.0;

/// How much of a place is town, 0 to 1 (1 in the middle of one), as seen at a spacing.
pub fn share(latitude_rad: f64, longitude_rad: f64, spacing_m: f64) -> f64 {
    let seen = (2.0 * (1.0 - spacing_m / COARSEST_M)).clamp(0.0, 1.0);
    if seen <= 0.0 {
        return 0.0;
    }
    let y = (latitude_rad.to_degrees() + 90.0).clamp(0.0, 180.0);
    let x = (longitude_rad.to_degrees() + 180.0).rem_euclid(360.0);
    let (column, row) = ((x as i32).min(359), (y as i32).min(179));
    seen * block(column, row, |block| block.at(x - f64::from(column), y - f64::from(row)))
}

/// Shares of one degree, rows from the south; `None`: no town is near.
struct Block(Option<Vec<f32>>);

impl Block {
    fn new(column: i32, row: i32) -> Self {
        let (south, west) = (f64::from(row) - 90.0, f64::from(column) - 180.0);
        // A block's half diagonal is 79 km at most.
        let towns = near(zenith(south + 0.5, west + 0.5), 79_000.0 + MOST_M);
        let rounds: Vec<_> = towns.iter().map(|town| (town.zenith, LEAST_M + RADII * town.radius_m())).collect();
        if rounds.is_empty() {
            return Self(None);
        }
        let share = |i: usize| {
            let at = |k: usize| k as f64 / STEPS as f64;
            let here = zenith(south + at(i / NODES), west + at(i % NODES));
            let left = rounds.iter().map(|(there, radius_m)| {
                let squared = here.distance_squared(*there) * (EARTH_M * EARTH_M / (radius_m * radius_m));
                let inside = (1.0 - squared).max(0.0);
                1.0 - inside * inside * (3.0 - 2.0 * inside)
            });
            1.0 - left.product::<f64>() as f32
        };
        Self(Some((0..NODES * NODES).map(share).collect()))
    }

    /// Bilinear; coordinates in degrees from the south-west corner.
    fn at(&self, x: f64, y: f64) -> f64 {
        let Some(shares) = &self.0 else { return 0.0 };
        let split = |degrees: f64| {
            let steps = degrees * STEPS as f64;
            let low = (steps as usize).min(STEPS - 1);
            (low, (steps - low as f64).clamp(0.0, 1.0))
        };
        let ((x, fx), (y, fy)) = (split(x), split(y));
        let node = |dx: usize, dy: usize| f64::from(shares[x + dx + (y + dy) * NODES]);
        let row = |dy: usize| node(0, dy) + (node(1, dy) - node(0, dy)) * fx;
        row(0) + (row(1) - row(0)) * fy
    }
}

fn zenith(latitude_deg: f64, longitude_deg: f64) -> DVec3 {
    let (sin_lat, cos_lat) = latitude_deg.to_radians().sin_cos();
    let (sin_lon, cos_lon) = longitude_deg.to_radians().sin_cos();
    DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat)
}

/// Reads a block: one of those kept, or a new one. Which ones are kept changes no number.
fn block<T>(column: i32, row: i32, read: impl FnOnce(&Block) -> T) -> T {
    type Entry = ((i32, i32), Arc<Block>);
    static BLOCKS: Mutex<VecDeque<Entry>> = Mutex::new(VecDeque::new());
    thread_local! {
        // Neighbouring places ask for the same block: the lock is taken where that changes.
        static LAST: RefCell<Option<Entry>> = const { RefCell::new(None) };
    }
    let key = (column, row);
    LAST.with_borrow_mut(|last| {
        if last.as_ref().is_none_or(|(at, _)| *at != key) {
            let mut kept = BLOCKS.lock().unwrap_or_else(PoisonError::into_inner);
            let found = kept.iter().position(|(at, _)| *at == key).and_then(|at| kept.remove(at));
            drop(kept);
            // Two threads may make it at once: the same bytes.
            let entry = found.unwrap_or_else(|| (key, Arc::new(Block::new(column, row))));
            let mut kept = BLOCKS.lock().unwrap_or_else(PoisonError::into_inner);
            kept.push_front(entry.clone());
            kept.truncate(KEPT);
            drop(kept);
            *last = Some(entry);
        }
        let (_, block) = last.as_ref().expect("just put there");
        read(block)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(latitude_deg: f64, longitude_deg: f64) -> f64 {
        share(latitude_deg.to_radians(), longitude_deg.to_radians(), 0.0)
    }

    #[test]
    fn towns_are_towns_and_the_wilderness_is_not() {
        for (name, latitude, longitude) in
            [("Geneva", 46.20, 6.15), ("Innsbruck", 47.26, 11.39), ("Suva", -18.13, 178.43)]
        {
            assert!(at(latitude, longitude) > 0.9, "{name}");
        }
        for (name, latitude, longitude) in [("Mont Blanc", 45.83, 6.86), ("Atlantic", 30.0, -40.0), ("pole", 90.0, 0.0)]
        {
            assert!(at(latitude, longitude) < 0.15, "{name}: {}", at(latitude, longitude));
        }
        assert_eq!(share(46.2f64.to_radians(), 6.15f64.to_radians(), COARSEST_M), 0.0);
    }

    #[test]
    fn blocks_meet_without_a_step() {
        // Over the borders of blocks in the Ruhr and across the 180th meridian on Fiji.
        for (latitude, longitude) in [(51.37, 7.0), (52.0, 6.99), (-17.0, 180.0), (-16.8, -180.0)] {
            for (north, east) in [(1e-7, 0.0), (0.0, 1e-7), (1e-7, 1e-7)] {
                let across = [at(latitude - north, longitude - east), at(latitude + north, longitude + east)];
                // 1e-7 degrees are a centimetre; a share rises by 1 over 4 km at the least.
                assert!((across[0] - across[1]).abs() < 1e-5, "{latitude} {longitude}: {across:?}");
            }
        }
    }
}
