//! A first bound of the potential of a fresh candidate: what it would be if only a few cells near it were held.
//!
//! Holding more cells at 0 can only lower a potential (maximum principle), so the solution with a handful of cells held, the
//! ones next to the new tip, is an upper bound; it costs a small dense system for each grown cell instead of one of
//! hundreds for each candidate.

use super::super::frontier::Frontier;
use super::super::grid::Cell;
use super::super::scene::state;
use super::held::{Held, Row};

/// Most cells held for a bound: more would cost more than the draws they save.
const MOST_HELD: usize = 12;
/// Cells to each side of the tip among which they are looked for, in a plane and in a volume.
const REACH: [u32; 2] = [3, 2];

/// The small system around one tip: targets and near cells of the channel.
pub(super) struct Bound {
    positions: Vec<[u32; 3]>,
    /// The inverse of G over the held cells applied to what they must have above the base.
    charges: [f64; MOST_HELD],
}

impl Bound {
    /// How many cells beside the targets may be held.
    pub fn room(targets: usize) -> usize {
        MOST_HELD.saturating_sub(targets)
    }

    /// Solves for the charges that give each held cell its value; the first [`MOST_HELD`] cells count.
    pub fn new(held: &Held, cells: impl Iterator<Item = (Cell, f64)>) -> Self {
        let mut charges = [0.0; MOST_HELD];
        let mut positions = Vec::with_capacity(MOST_HELD);
        for ((cell, value), charge) in cells.zip(&mut charges) {
            positions.push(held.place(cell));
            *charge = value - held.base(cell);
        }
        solve(positions.len(), |i, j| held.table.at(positions[i], positions[j]), &mut charges);
        Self { positions, charges }
    }

    /// The potential at a cell.
    pub fn at(&self, held: &Held, row: &Row) -> f64 {
        let terms = self.positions.iter().zip(&self.charges);
        row.base + terms.map(|(&position, charge)| charge * held.table.at(row.position, position)).sum::<f64>()
    }
}

/// Solves a symmetric positive definite system in place: Cholesky, then forward and backward substitution.
fn solve(count: usize, matrix: impl Fn(usize, usize) -> f64, x: &mut [f64; MOST_HELD]) {
    let mut factor = [[0.0; MOST_HELD]; MOST_HELD];
    for i in 0..count {
        for j in 0..=i {
            let known: f64 = factor[i][..j].iter().zip(&factor[j][..j]).map(|(a, b)| a * b).sum();
            let value = matrix(i, j) - known;
            factor[i][j] = if i == j { value.sqrt() } else { value / factor[j][j] };
        }
        let known: f64 = factor[i][..i].iter().zip(&x[..i]).map(|(a, b)| a * b).sum();
        x[i] = (x[i] - known) / factor[i][i];
    }
    for i in (0..count).rev() {
        let known: f64 = factor[i + 1..count].iter().zip(&x[i + 1..count]).map(|(row, x)| row[i] * x).sum();
        x[i] = (x[i] - known) / factor[i][i];
    }
}

/// The cells of the channel nearest to its tip, nearest first.
pub(super) fn near_channel(frontier: &Frontier, tip: Cell, most: usize) -> Vec<Cell> {
    let grid = frontier.scene.grid;
    let (size, centre) = (grid.size(), grid.position(tip));
    let reach = REACH[grid.axes() - 2];
    let span = |axis: usize| {
        let low = centre[axis].saturating_sub(reach);
        low..=(centre[axis] + reach).min(size[axis] - 1)
    };
    let mut near = Vec::new();
    for z in span(2) {
        for y in span(1) {
            for x in span(0) {
                let cell = grid.cell([x, y, z]);
                if frontier.map[cell as usize] == state::GROWN {
                    let d = [x.abs_diff(centre[0]), y.abs_diff(centre[1]), z.abs_diff(centre[2])];
                    near.push((d[0] * d[0] + d[1] * d[1] + d[2] * d[2], cell));
                }
            }
        }
    }
    near.sort_unstable();
    near.into_iter().take(most).map(|(_, cell)| cell).collect()
}
