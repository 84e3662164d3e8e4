//! Sums of distance^-rho over whole walls and over the ground, for any cell in a few look-ups.
//!
//! What it is: the lightning paper's boundary charge B is a sum over the shell of cells just outside the grid (edges and corners
//! belong to it), and the ground as a target is a sum over a layer inside it. How it is computed: walls across an axis, seen from
//! a distance d, are windows of one infinite plane (in 2D: line) of charges, so sums over that plane from its foot point
//! outwards, kept for each d, give any window by adding: nothing is subtracted, so nothing cancels.

use super::grid::{Cell, Grid};
use crate::numeric::exact::pow;

/// Prefix sums of (d^2 + j^2 (+ k^2))^(-rho/2) for the distances and offsets of one grid.
#[derive(Clone, Debug)]
pub(super) struct WallSums {
    grid: Grid,
    rho: f64,
    /// One a shape of wall; axes whose walls have the same shape share it.
    planes: Vec<Plane>,
    /// Which of them belongs to the walls across an axis.
    plane_of: [usize; 3],
}

/// The sums over a plane (or line) of charges as seen from distances 1, 2, ...
#[derive(Clone, Debug)]
struct Plane {
    /// Greatest distance, entries along the first axis of the plane, entries along the second (1 for a line).
    shape: [usize; 3],
    /// For each distance: entry (j, k) is the sum over offsets 0 to j and 0 to k in which offset 0 counts half, so that a window
    /// from -a to b is entry a plus entry b.
    sums: Vec<f64>,
}

/// distance^-rho of a squared distance.
#[inline(always)]
pub(super) fn pull(squared: f64, rho: f64) -> f64 {
    // Whole exponents, which are the usual ones, by multiplication.
    let near = 1.0 / squared;
    match rho {
        1.0 => near.sqrt(),
        2.0 => near,
        3.0 => near * near.sqrt(),
        4.0 => near * near,
        _ => pow(squared, -0.5 * rho),
    }
}

impl Plane {
    fn new(shape: [usize; 3], rho: f64) -> Self {
        let [distances, side, depth] = shape;
        let mut sums = vec![0.0; distances * side * depth];
        for (d, table) in sums.chunks_exact_mut(side * depth).enumerate() {
            let d2 = ((d + 1) * (d + 1)) as f64;
            for (k, row) in table.chunks_exact_mut(side).enumerate() {
                let far = d2 + (k * k) as f64;
                for (j, entry) in row.iter_mut().enumerate() {
                    *entry = pull(far + (j * j) as f64, rho);
                }
                let share = if depth > 1 && k == 0 { 0.5 } else { 1.0 };
                let mut sum = -0.5 * row[0];
                for entry in row {
                    sum += *entry;
                    *entry = share * sum;
                }
            }
            for k in side..side * depth {
                table[k] += table[k - side];
            }
        }
        Self { shape, sums }
    }

    /// Sum over the window of offsets -before to after along each of the axes of the plane at distance `d` >= 1.
    fn window(&self, d: usize, [j, k]: [[usize; 2]; 2]) -> f64 {
        let [_, side, depth] = self.shape;
        let table = &self.sums[(d - 1) * side * depth..];
        if depth == 1 {
            return table[j[0]] + table[j[1]];
        }
        let at = |j: usize, k: usize| table[k * side + j];
        (at(j[0], k[0]) + at(j[1], k[1])) + (at(j[0], k[1]) + at(j[1], k[0]))
    }
}

impl WallSums {
    /// Builds the sums of a grid: about as many evaluations as the grid has cells, for each different shape of wall.
    pub fn new(grid: Grid, rho: f64) -> Self {
        let size = grid.size().map(|side| side as usize);
        let axes = grid.axes();
        let mut planes: Vec<Plane> = Vec::new();
        let mut plane_of = [0; 3];
        for axis in 0..axes {
            // From a cell inside, the shell is up to n cells away along an axis and reaches up to n to each side.
            let mut shape = [size[axis], 1, 1];
            for (entries, other) in shape[1..].iter_mut().zip((0..axes).filter(|&other| other != axis)) {
                *entries = size[other] + 1;
            }
            plane_of[axis] = planes.iter().position(|plane| plane.shape == shape).unwrap_or_else(|| {
                planes.push(Plane::new(shape, rho));
                planes.len() - 1
            });
        }
        Self { grid, rho, planes, plane_of }
    }

    pub fn grid(&self) -> Grid {
        self.grid
    }

    pub fn rho(&self) -> f64 {
        self.rho
    }

    /// Sum of distance^-rho over the shell of cells just outside the grid.
    pub fn shell(&self, cell: Cell) -> f64 {
        let size = self.grid.size().map(|side| side as usize);
        let position = self.grid.position(cell).map(|p| p as usize);
        // Distances to the shell on both sides of each axis.
        let gap: [[usize; 2]; 3] = std::array::from_fn(|axis| [position[axis] + 1, size[axis] - position[axis]]);
        // The first axis' walls span the whole shell, the next ones leave out what is already counted.
        let whole = |axis: usize| gap[axis];
        let inner = |axis: usize| gap[axis].map(|reach| reach - 1);
        let axes = self.grid.axes();
        let mut sum = 0.0;
        for (axis, away) in gap.into_iter().enumerate().take(axes) {
            let mut spans = [[0, 0]; 2];
            for (span, other) in spans.iter_mut().zip((0..axes).filter(|&other| other != axis)) {
                *span = if other < axis { inner(other) } else { whole(other) };
            }
            let plane = &self.planes[self.plane_of[axis]];
            sum += plane.window(away[0], spans) + plane.window(away[1], spans);
        }
        sum
    }

    /// Sum of distance^-rho over the ground layer, for a cell above it.
    pub fn ground(&self, cell: Cell) -> f64 {
        let size = self.grid.size().map(|side| side as usize);
        let position = self.grid.position(cell).map(|p| p as usize);
        let axes = self.grid.axes();
        let mut spans = [[0, 0]; 2];
        for (axis, span) in spans.iter_mut().enumerate().take(axes - 1) {
            *span = [position[axis], size[axis] - 1 - position[axis]];
        }
        self.planes[self.plane_of[axes - 1]].window(position[axes - 1].max(1), spans)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn direct(grid: Grid, rho: f64, cell: Cell, charges: impl Fn([i64; 3]) -> bool) -> f64 {
        let size = grid.size().map(i64::from);
        let at = grid.position(cell).map(i64::from);
        let depth = if grid.axes() == 3 { -1..=size[2] } else { 0..=0 };
        let mut sum = 0.0;
        for z in depth {
            for y in -1..=size[1] {
                for x in -1..=size[0] {
                    if charges([x, y, z]) {
                        let d = [x - at[0], y - at[1], z - at[2]].map(|d| d as f64);
                        sum += (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).powf(-0.5 * rho);
                    }
                }
            }
        }
        sum
    }

    #[test]
    fn they_equal_the_direct_sums() {
        let grids =
            [Grid::plane(9, 14), Grid::plane(1, 6), Grid::plane(7, 1), Grid::volume(5, 8, 6), Grid::volume(1, 1, 4)];
        for grid in grids.map(|grid| grid.expect("a grid")) {
            for rho in [0.1, 1.0, 2.5, 3.0, 4.0, 20.0] {
                let sums = WallSums::new(grid, rho);
                let size = grid.size().map(i64::from);
                let up = grid.axes() - 1;
                for cell in 0..grid.cells() as u32 {
                    let outside = |p: [i64; 3]| (0..=up).any(|axis| p[axis] < 0 || p[axis] >= size[axis]);
                    let expected = direct(grid, rho, cell, outside);
                    // A window is a sum of up to 4 entries of up to 225 positive terms: rounding below 1e-13.
                    assert!((sums.shell(cell) / expected - 1.0).abs() < 1e-13, "{grid:?} {rho} {cell}");
                    if grid.layer(cell) > 0 {
                        let ground = |p: [i64; 3]| p[up] == 0 && !outside(p);
                        let expected = direct(grid, rho, cell, ground);
                        assert!((sums.ground(cell) / expected - 1.0).abs() < 1e-13, "{grid:?} {rho} {cell}");
                    }
                }
            }
        }
    }
}
