//! How far a place of a genus surely is from cloud: what a walk through empty space may leave out.
//!
//! *What it is.* For cells of 128 x 128 columns and 16 heights of the tile, and for four distances, the greatest shape value that any
//! look nearer than that could find. Heights count four times: a ray that is nearly level goes far before it is down at the
//! tops, and what keeps it up is not how far away these are but how much lower.
//! *How we compute it.* The greatest value of each cell and of the voxels around it, then the greatest of all cells whose gap is
//! less than the distance, by rows that have been widened.
//! *How we store it.* Four bytes a cell, one for each distance: x fastest, then y, then height.
//! *How we read it back.* The nearest cell, without interpolation: a value holds for the whole cell. Values are compared with the
//! theta that rules, so that a cloud is as small as it is there; a table of distances for a few thetas, which must be told
//! of the next lower one, found hardly any place free at half cover.

use super::CloudKind;
use super::density::{self, DensityVolume, TILE_M};
use std::sync::{Arc, OnceLock};

/// Cells east and north.
pub const WIDTH: usize = 128;
/// Cells upwards.
pub const HEIGHT: usize = 16;
/// The distances, m.
pub const DISTANCES_M: [f32; 4] = [250.0, 500.0, 1_000.0, 2_000.0];
/// What a metre of height counts.
pub const STRETCH: f32 = 4.0;
const CELL_M: f32 = TILE_M / WIDTH as f32;
const AREA: usize = WIDTH * WIDTH;

/// The table of a genus at its usual thickness, made at first use and kept (1 MiB). In a layer of another thickness heights count
/// by the ratio of both.
pub fn of(kind: CloudKind) -> Arc<Vec<u8>> {
    static KEPT: [OnceLock<Arc<Vec<u8>>>; CloudKind::COUNT] = [const { OnceLock::new() }; CloudKind::COUNT];
    let volume = DensityVolume::of(kind);
    KEPT[kind.index()].get_or_init(|| Arc::new(build(&volume.shape, kind.appearance().usual_thickness_m))).clone()
}

/// The table of any shape values, for a layer of this thickness.
pub fn build(shape: &[u8], thickness_m: f32) -> Vec<u8> {
    let most = greatest(shape);
    let cell_height_m = STRETCH * thickness_m / HEIGHT as f32;
    let mut table = vec![0; AREA * HEIGHT * DISTANCES_M.len()];
    // Row by row wider by a cell to each side.
    let mut widened = vec![most];
    for (level, distance_m) in DISTANCES_M.into_iter().enumerate() {
        while widened.len() <= cells_below(distance_m) {
            let next = wider(&widened[widened.len() - 1]);
            widened.push(next);
        }
        let found = within(&widened, distance_m, cell_height_m);
        for (texel, value) in table.chunks_exact_mut(DISTANCES_M.len()).zip(found) {
            texel[level] = value;
        }
    }
    table
}

/// The greatest value that a look into each cell can find: a trilinear look reads a voxel beyond the cell.
fn greatest(shape: &[u8]) -> Vec<u8> {
    const FINE: usize = density::WIDTH;
    let (ratio, rise) = (FINE / WIDTH, density::HEIGHT / HEIGHT);
    (0..AREA * HEIGHT)
        .map(|i| {
            let [x, y, z] = [i % WIDTH * ratio, i / WIDTH % WIDTH * ratio, i / AREA * rise];
            let mut most = 0;
            for dz in z.saturating_sub(1)..=(z + rise).min(density::HEIGHT - 1) {
                for dy in FINE - 1..=FINE + ratio {
                    let row = &shape[((y + dy) % FINE + dz * FINE) * FINE..][..FINE];
                    for dx in FINE - 1..=FINE + ratio {
                        most = most.max(row[(x + dx) % FINE]);
                    }
                }
            }
            most
        })
        .collect()
}

/// Gap between two cells so many cells apart: those that touch are no distance apart.
fn gap(cells: usize, size_m: f32) -> f32 {
    cells.saturating_sub(1) as f32 * size_m
}

/// How many columns away the last one lies whose gap is less than a distance above 0.
fn cells_below(distance_m: f32) -> usize {
    (distance_m / CELL_M).ceil() as usize
}

/// Each row, which wraps, widened by a cell to each side.
fn wider(values: &[u8]) -> Vec<u8> {
    let mut next = values.to_vec();
    for (row, out) in values.chunks_exact(WIDTH).zip(next.chunks_exact_mut(WIDTH)) {
        for (x, value) in out.iter_mut().enumerate() {
            *value = (*value).max(row[(x + 1) % WIDTH]).max(row[(x + WIDTH - 1) % WIDTH]);
        }
    }
    next
}

/// The greatest of all cells nearer than a distance, from rows that are widened by 0 and more cells.
fn within(widened: &[Vec<u8>], distance_m: f32, cell_height_m: f32) -> Vec<u8> {
    let mut found = vec![0; AREA * HEIGHT];
    let reach = cells_below(distance_m);
    for (z, plane) in found.chunks_exact_mut(AREA).enumerate() {
        for other in 0..HEIGHT {
            for dy in 0..=2 * reach {
                let across = gap(z.abs_diff(other), cell_height_m).hypot(gap(dy.abs_diff(reach), CELL_M));
                if across >= distance_m {
                    continue;
                }
                let source = &widened[cells_below((distance_m * distance_m - across * across).sqrt())][other * AREA..];
                for (y, row) in plane.chunks_exact_mut(WIDTH).enumerate() {
                    let from = &source[(y + dy + WIDTH - reach) % WIDTH * WIDTH..][..WIDTH];
                    for (out, value) in row.iter_mut().zip(from) {
                        *out = (*out).max(*value);
                    }
                }
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The greatest value nearer than a distance, cell by cell; with it the same at a distance a centimetre off.
    fn by_hand(most: &[u8], distance_m: f32, from: [i32; 3], height_m: f32) -> u8 {
        let near = most.iter().enumerate().filter(|(i, _)| {
            let at = [i % WIDTH, i / WIDTH % WIDTH, i / AREA].map(|v| v as i32);
            let wide = |axis: usize| {
                let d = (at[axis] - from[axis]).rem_euclid(WIDTH as i32);
                (d.min(WIDTH as i32 - d) - 1).max(0) as f32 * CELL_M
            };
            let high = ((at[2] - from[2]).abs() - 1).max(0) as f32 * height_m;
            wide(0).powi(2) + wide(1).powi(2) + high * high < distance_m * distance_m
        });
        near.map(|(_, value)| *value).max().unwrap_or(0)
    }

    #[test]
    fn values_are_those_found_cell_by_cell() {
        let kind = CloudKind::Cumulus;
        let (shape, thickness_m) = (&DensityVolume::of(kind).shape, kind.appearance().usual_thickness_m);
        let (table, most) = (of(kind), greatest(shape));
        let height_m = STRETCH * thickness_m / HEIGHT as f32;
        let mut grown = 0;
        for k in 0..40usize {
            let from = [k * 37 % WIDTH, k * 91 % WIDTH, k % HEIGHT];
            let at = from[0] + from[1] * WIDTH + from[2] * AREA;
            let stored = &table[DISTANCES_M.len() * at..][..DISTANCES_M.len()];
            for (value, distance_m) in stored.iter().zip(DISTANCES_M) {
                // Whole cells that lie just at the distance may be rounded to either side.
                let found = |by_m: f32| by_hand(&most, distance_m + by_m, from.map(|v| v as i32), height_m);
                assert!((found(-0.01)..=found(0.01)).contains(value), "{from:?} {distance_m}: {value}");
            }
            grown += usize::from(stored[3] > stored[0] && stored[0] > most[at]);
        }
        assert!(grown > 5, "there is more cloud farther away");
    }
}
