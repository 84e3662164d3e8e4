//! The cells held at a potential, and what that makes of the potential elsewhere: a Cholesky factor that grows by a row a cell.

use super::super::error::GrowError;
use super::super::grid::{Cell, Grid};
use super::super::scene::{Goal, Scene};
use super::super::tables::Tables;
use super::NOISE;
use super::green::GreenTable;
use crate::numeric::poisson::Laplace;
use crate::numeric::vector::vectorised;
use std::sync::Arc;

/// Lanes that a dot product runs in.
const LANES: usize = 16;
/// Residual to which the potential of the ground is solved, once.
const GROUND_TOLERANCE: f64 = 1e-12;
const GROUND_ITERATIONS: u32 = 5000;

/// A cell's numbers V, as far as they are known, and its potential as far as they tell.
#[derive(Clone, Debug)]
pub(super) struct Row {
    pub cell: Cell,
    pub position: [u32; 3],
    /// Potential with nothing held.
    pub base: f64,
    values: Vec<f64>,
    potential: f64,
    /// Greatest size that the potential had on the way: rounding errors are in proportion to it.
    greatest: f64,
    /// Whether no potential comes here.
    dark: bool,
}

/// The cells held so far.
pub(super) struct Held {
    pub table: Arc<GreenTable>,
    grid: Grid,
    /// Whether layer 0 is the border of the table, not part of it.
    ground: bool,
    /// Potential with nothing held: one number, or one a cell.
    base: Vec<f64>,
    cells: Vec<Cell>,
    positions: Vec<[u32; 3]>,
    /// Potential that each is held at, less the base there.
    above_base: Vec<f64>,
    /// Rows of the Cholesky factor of G without the diagonal, one after another: row m has m numbers.
    factor: Vec<f64>,
    diagonal: Vec<f64>,
    /// The factor's inverse applied to `above_base`.
    z: Vec<f64>,
}

impl Held {
    /// Nothing held but the border: at 1 for a free channel, at 1 in the ground layer where that is the goal, else at 0.
    pub fn new(scene: &Scene, tables: &mut Tables) -> Result<Self, GrowError> {
        let grid = scene.grid;
        let ground = scene.goal == Goal::Ground;
        let (table, base) = match scene.goal {
            Goal::Ground => {
                let size = grid.size();
                let above = match grid.axes() {
                    2 => Grid::plane(size[0], size[1] - 1),
                    _ => Grid::volume(size[0], size[1], size[2] - 1),
                };
                (tables.green(above?), ground_potential(scene)?)
            }
            Goal::Free => (tables.green(grid), vec![1.0]),
            _ => (tables.green(grid), vec![0.0]),
        };
        let (cells, positions, above_base) = (Vec::new(), Vec::new(), Vec::new());
        let (factor, diagonal, z) = (Vec::new(), Vec::new(), Vec::new());
        Ok(Self { table, grid, ground, base, cells, positions, above_base, factor, diagonal, z })
    }

    /// Whether a cell is part of the table's border.
    pub fn on_border(&self, cell: Cell) -> bool {
        self.ground && self.grid.layer(cell) == 0
    }

    /// Where a cell is in the table.
    pub fn place(&self, cell: Cell) -> [u32; 3] {
        let mut position = self.grid.position(cell);
        if self.ground {
            position[self.grid.axes() - 1] -= 1;
        }
        position
    }

    /// Potential of a cell with nothing held.
    pub fn base(&self, cell: Cell) -> f64 {
        if self.base.len() == 1 { self.base[0] } else { self.base[cell as usize] }
    }

    /// A cell of which nothing is known yet but its base.
    pub fn row(&self, cell: Cell, dark: bool) -> Row {
        let base = self.base(cell);
        Row { cell, position: self.place(cell), base, values: Vec::new(), potential: base, greatest: base.abs(), dark }
    }

    /// Holds a cell at a potential from now on; one that is held already changes to it.
    pub fn hold(&mut self, cell: Cell, potential: f64) {
        if let Some(number) = self.cells.iter().rposition(|&held| held == cell) {
            self.above_base[number] = potential - self.base(cell);
            self.solve_again(number);
            return;
        }
        self.hold_row(self.row(cell, false), potential);
    }

    /// Holds the cell of a row, which is not held yet.
    pub fn hold_row(&mut self, mut row: Row, potential: f64) {
        self.advance(&mut row);
        let squares = vectorised(
            #[inline(always)]
            || dot(&row.values, &row.values),
        );
        // G over different cells is positive definite with a condition below 1e5 up to 256 cells a side: rounding cannot turn the
        // sign.
        let diagonal = (self.table.at(row.position, row.position) - squares).max(f64::MIN_POSITIVE).sqrt();
        self.z.push((potential - row.potential) / diagonal);
        self.above_base.push(potential - row.base);
        self.cells.push(row.cell);
        self.positions.push(row.position);
        self.diagonal.push(diagonal);
        self.factor.extend_from_slice(&row.values);
    }

    /// The potential of a row's cell, after bringing it up to date.
    pub fn potential(&self, row: &mut Row) -> f64 {
        self.advance(row);
        if row.dark || row.potential <= NOISE * row.greatest { 0.0 } else { row.potential }
    }

    /// Sums a row's potential anew, after held potentials have changed.
    pub fn sum_again(&self, row: &mut Row) {
        row.potential = row.base;
        row.greatest = row.base.abs();
        for (z, value) in self.z.iter().zip(&row.values) {
            row.potential += z * value;
            row.greatest = row.greatest.max(row.potential.abs());
        }
    }

    /// Forward substitution from a changed cell on.
    fn solve_again(&mut self, from: usize) {
        for m in from..self.cells.len() {
            let row = &self.factor[m * (m.max(1) - 1) / 2..][..m];
            let known: f64 = row.iter().zip(&self.z).map(|(factor, z)| factor * z).sum();
            self.z[m] = (self.above_base[m] - known) / self.diagonal[m];
        }
    }

    fn advance(&self, row: &mut Row) {
        vectorised(
            #[inline(always)]
            || {
                for m in row.values.len()..self.cells.len() {
                    let factor = &self.factor[m * (m.max(1) - 1) / 2..][..m];
                    let direct = self.table.at(row.position, self.positions[m]);
                    let value = (direct - dot(&row.values, factor)) / self.diagonal[m];
                    row.values.push(value);
                    row.potential += self.z[m] * value;
                    row.greatest = row.greatest.max(row.potential.abs());
                }
            },
        );
    }
}

/// The potential of the open ground at 1, with obstacles in it at 0, in the whole grid.
fn ground_potential(scene: &Scene) -> Result<Vec<f64>, GrowError> {
    let grid = scene.grid;
    let mut laplace = Laplace::new(grid.size().map(|side| side as usize), grid.axes());
    for cell in grid.ground() {
        laplace.hold(cell as usize, 1.0);
    }
    for &cell in scene.obstacles.iter().filter(|&&cell| grid.layer(cell) == 0) {
        laplace.hold(cell as usize, 0.0);
    }
    let solved = laplace.solve(GROUND_TOLERANCE, GROUND_ITERATIONS);
    if !solved.converged {
        let (iterations, residual) = (solved.iterations, solved.residual);
        return Err(GrowError::NoConvergence { iterations, residual, tolerance: GROUND_TOLERANCE });
    }
    Ok((0..grid.cells()).map(|cell| laplace.potential(cell)).collect())
}

#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; LANES];
    let (whole_a, whole_b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let (rest_a, rest_b) = (whole_a.remainder(), whole_b.remainder());
    for (a, b) in whole_a.zip(whole_b) {
        for (lane, (a, b)) in lanes.iter_mut().zip(a.iter().zip(b)) {
            *lane += a * b;
        }
    }
    for (lane, (a, b)) in lanes.iter_mut().zip(rest_a.iter().zip(rest_b)) {
        *lane += a * b;
    }
    let mut half = LANES / 2;
    while half > 0 {
        for lane in 0..half {
            lanes[lane] += lanes[lane + half];
        }
        half /= 2;
    }
    lanes[0]
}

#[cfg(test)]
mod tests {
    use super::super::bound::Bound;
    use super::*;

    /// Holds a crooked channel and some obstacles; every other cell's potential and its bound against conjugate gradients.
    fn check(grid: Grid, goal: Goal) {
        let (nx, up) = (grid.size()[0], grid.axes() - 1);
        let target = grid.bottom_centre() + 1;
        let scene = Scene { goal: goal.clone(), ..Scene::top_to_bottom(grid) };
        let ground = goal == Goal::Ground;
        let channel: Vec<Cell> =
            (0..5).map(|k| scene.start - k * if up == 1 { nx } else { nx * grid.size()[1] } - k % 2).collect();
        let obstacles: Vec<Cell> = (0..3).map(|k| grid.cells() as Cell / 2 + 2 * k).collect();
        let free = goal == Goal::Free;

        let mut laplace = Laplace::new(grid.size().map(|side| side as usize), grid.axes());
        let mut held = Held::new(&scene, &mut Tables::default()).expect("a right scene");
        let mut fix = |held: &mut Held, cell: Cell, value: f64| {
            held.hold(cell, value);
            laplace.hold(cell as usize, if free { 1.0 - value } else { value });
        };
        let early = grid.cells() as Cell - 1;
        let mut row = held.row(early, false);
        obstacles.iter().for_each(|&cell| fix(&mut held, cell, 0.0));
        if !free && !ground {
            fix(&mut held, target, 1.0);
        }
        held.potential(&mut row);
        channel.iter().for_each(|&cell| fix(&mut held, cell, 0.0));
        if !free && !ground {
            // A target that falls to 0 and rises again changes nothing.
            held.hold(target, 0.0);
            held.hold(target, 1.0);
        }
        for cell in grid.ground().filter(|_| ground) {
            laplace.hold(cell as usize, 1.0);
        }
        assert!(laplace.solve(1e-13, 1000).converged);
        let truth =
            |cell: Cell| if free { 1.0 - laplace.potential(cell as usize) } else { laplace.potential(cell as usize) };
        let targets = if free || ground { vec![] } else { vec![(target, 1.0)] };
        let near = channel.iter().rev().take(3).map(|&cell| (cell, 0.0));
        let bound = Bound::new(&held, targets.into_iter().chain(near));
        for cell in 0..grid.cells() as Cell {
            if held.on_border(cell) || held.cells.contains(&cell) {
                continue;
            }
            let mut fresh = held.row(cell, false);
            let least = bound.at(&held, &fresh);
            let found = held.potential(&mut fresh);
            // The solver's residual of 1e-13 through an inverse of norm below 100; rounding is smaller.
            assert!((found - truth(cell)).abs() < 1e-10, "{goal:?} {cell}: {found} {}", truth(cell));
            assert!(least >= found - 1e-12, "{goal:?} {cell}: bound {least} below {found}");
        }
        // A row begun early and brought up to date late, after held values changed.
        held.sum_again(&mut row);
        assert!((held.potential(&mut row) - truth(early)).abs() < 1e-10);
    }

    #[test]
    fn potentials_equal_those_of_conjugate_gradients_and_bounds_lie_above() {
        for grid in [Grid::plane(14, 11), Grid::volume(7, 6, 9)].map(|grid| grid.expect("a grid")) {
            check(grid, Goal::Nearest(vec![grid.bottom_centre() + 1]));
            check(grid, Goal::Ground);
            check(grid, Goal::Free);
        }
    }
}
