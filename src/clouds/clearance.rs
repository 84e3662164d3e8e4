//! How far a place of a genus surely is from cloud: what a walk through empty space may leave out.
//!
//! *What it is.* For cells of 128 x 128 columns and 8 heights of the tile, and for 12 thetas, the distance to the nearest cell
//! in which any look could find a shape value above that theta.
//! *How we compute it.* The greatest value of each cell and of the voxels around it, then an exact distance transform axis by
//! axis over gaps between cells, up to 2 km away.
//! *How we store it.* One byte a cell in steps of 8 m, rounded down: x fastest, then y, then height, then theta.
//! *How we read it back.* The nearest cell, without interpolation: a distance holds for the whole cell.

use super::CloudKind;
use super::density::{self, DensityVolume, TILE_M};
use std::sync::{Arc, OnceLock};

/// Cells east and north.
pub const WIDTH: usize = 128;
/// Cells upwards.
pub const HEIGHT: usize = 8;
/// Thetas.
pub const THETAS: usize = 12;
/// Theta from one to the next; the first is 0.
pub const THETA_STEP: f32 = 0.08;
/// What one step of a byte stands for.
pub const UNIT_M: f32 = 8.0;
/// Cells that are looked over each way.
const REACH: usize = 16;
const CELL_M: f32 = TILE_M / WIDTH as f32;
const AREA: usize = WIDTH * WIDTH;

/// The table of a genus at its usual thickness, made at first use and kept (1.5 MiB). A layer of another thickness may go as far
/// where it is thicker, and less far by the ratio of both where it is thinner.
pub fn of(kind: CloudKind) -> Arc<Vec<u8>> {
    static KEPT: [OnceLock<Arc<Vec<u8>>>; CloudKind::COUNT] = [const { OnceLock::new() }; CloudKind::COUNT];
    let volume = DensityVolume::of(kind);
    KEPT[kind.index()].get_or_init(|| Arc::new(build(&volume.shape, kind.appearance().usual_thickness_m))).clone()
}

/// The table of any shape values, for a layer of this thickness.
pub fn build(shape: &[u8], thickness_m: f32) -> Vec<u8> {
    let most = greatest(shape);
    let cell_height_m = thickness_m / HEIGHT as f32;
    let mut table = vec![0; AREA * HEIGHT * THETAS];
    for (node, out) in table.chunks_exact_mut(AREA * HEIGHT).enumerate() {
        let theta = node as f32 * THETA_STEP * 255.0;
        let occupied: Vec<f32> = most.iter().map(|v| if f32::from(*v) > theta { 0.0 } else { f32::INFINITY }).collect();
        for (byte, square) in out.iter_mut().zip(distances(occupied, cell_height_m)) {
            *byte = (square.sqrt() / UNIT_M).min(255.0) as u8;
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

/// Squares of the distances to the nearest cell that is 0; what is farther than the reach has that of the reach.
fn distances(mut field: Vec<f32>, cell_height_m: f32) -> Vec<f32> {
    // Cells that touch are no distance apart.
    let gap = |cells: usize, size_m: f32| (cells.saturating_sub(1) as f32 * size_m).powi(2);
    let mut next = vec![0.0; field.len()];
    for z in 0..HEIGHT {
        let out = &mut next[z * AREA..][..AREA];
        out.fill(f32::INFINITY);
        for (other, plane) in field.chunks_exact(AREA).enumerate() {
            least(out, plane, gap(z.abs_diff(other), cell_height_m));
        }
    }
    std::mem::swap(&mut field, &mut next);
    for (plane, out) in field.chunks_exact(AREA).zip(next.chunks_exact_mut(AREA)) {
        for (y, row) in out.chunks_exact_mut(WIDTH).enumerate() {
            row.fill(f32::INFINITY);
            for dy in 0..=2 * REACH {
                least(
                    row,
                    &plane[(y + dy + WIDTH - REACH) % WIDTH * WIDTH..][..WIDTH],
                    gap(dy.abs_diff(REACH), CELL_M),
                );
            }
        }
    }
    let farthest = gap(REACH, CELL_M);
    let mut ring = [0.0f32; WIDTH + 2 * REACH];
    for (row, out) in next.chunks_exact(WIDTH).zip(field.chunks_exact_mut(WIDTH)) {
        for (i, value) in ring.iter_mut().enumerate() {
            *value = row[(i + WIDTH - REACH) % WIDTH];
        }
        out.fill(farthest);
        for dx in 0..=2 * REACH {
            least(out, &ring[dx..][..WIDTH], gap(dx.abs_diff(REACH), CELL_M));
        }
    }
    field
}

fn least(out: &mut [f32], values: &[f32], more: f32) {
    for (out, value) in out.iter_mut().zip(values) {
        *out = out.min(value + more);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distance from a cell to the nearest that is occupied, cell by cell.
    fn by_hand(most: &[u8], theta: f32, from: [i32; 3], height_m: f32) -> f32 {
        let mut nearest = (REACH - 1) as f32 * CELL_M;
        for (i, _) in most.iter().enumerate().filter(|(_, v)| f32::from(**v) > theta * 255.0) {
            let at = [i % WIDTH, i / WIDTH % WIDTH, i / AREA].map(|v| v as i32);
            let wide = |axis: usize| {
                let d = (at[axis] - from[axis]).rem_euclid(WIDTH as i32);
                (d.min(WIDTH as i32 - d) - 1).max(0) as f32 * CELL_M
            };
            let high = ((at[2] - from[2]).abs() - 1).max(0) as f32 * height_m;
            nearest = nearest.min((wide(0).powi(2) + wide(1).powi(2) + high * high).sqrt());
        }
        nearest
    }

    #[test]
    fn distances_are_those_found_cell_by_cell() {
        let kind = CloudKind::Cumulus;
        let (shape, thickness_m) = (&DensityVolume::of(kind).shape, kind.appearance().usual_thickness_m);
        let (table, most) = (of(kind), greatest(shape));
        let mut far = 0;
        for k in 0..60usize {
            let node = 4 + k % 7;
            let from = [k * 37 % WIDTH, k * 91 % WIDTH, k % HEIGHT];
            let stored = table[from[0] + from[1] * WIDTH + from[2] * AREA + node * AREA * HEIGHT];
            let expected =
                by_hand(&most, node as f32 * THETA_STEP, from.map(|v| v as i32), thickness_m / HEIGHT as f32);
            // Rounded down to 8 m; both sum the same squares.
            let found = f32::from(stored) * UNIT_M;
            assert!(
                found <= expected + 0.01 && found > expected - UNIT_M - 0.01,
                "{from:?} {node}: {found} {expected}"
            );
            far += usize::from(found > 400.0);
        }
        assert!(far > 5, "some places are far from cloud");
    }
}
