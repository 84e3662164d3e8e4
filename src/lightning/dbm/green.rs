//! The Green's function of an empty box, for any two cells, from one table.
//!
//! What it is: G(c, s) is the potential at c of a unit charge at s with the ring (shell) outside the box held at 0, for the stencil
//! of 4 (6) neighbours. How it is computed: in sines, G = sum u_k(c) u_k(s) / lambda_k; a product of sines is a difference of
//! cosines of difference and sum, so G is 4 (8) entries of one table of cosine sums. How it is stored: entry (p, q, r) for
//! p = 0 to n + 1; greater sums fold back. How it is read: [`GreenTable::at`].

use super::super::grid::Grid;
use crate::numeric::exact::cos_pi;
use crate::numeric::vector::vectorised;

/// The table of one grid: (nx + 2)(ny + 2)(nz + 2) numbers, n^3 operations to make for a plane and n^4 for a volume.
#[derive(Clone, Debug)]
pub(in super::super) struct GreenTable {
    grid: Grid,
    /// 2 (n + 1) along each axis: the period of the cosines.
    period: [u32; 3],
    stride: [usize; 3],
    table: Vec<f64>,
}

impl GreenTable {
    /// Makes the table.
    pub fn new(grid: Grid) -> Self {
        let size = grid.size().map(|side| side as usize);
        let axes = grid.axes();
        let cosines: Vec<Vec<f64>> = size[..axes].iter().map(|&n| cosine_period(n)).collect();
        // 1 / lambda_k, the first axis fastest.
        let count: usize = size[..axes].iter().product();
        let normal: f64 = size[..axes].iter().map(|&n| 1.0 / (n + 1) as f64).product();
        let mut field: Vec<f64> = Vec::with_capacity(count);
        for index in 0..count {
            let mut rest = index;
            let mut lambda = 2.0 * axes as f64;
            for axis in 0..axes {
                lambda -= 2.0 * cosines[axis][rest % size[axis] + 1];
                rest /= size[axis];
            }
            field.push(normal / lambda);
        }
        // Each round transforms the slowest axis and makes it the fastest: after all rounds the order is what it was.
        for axis in (0..axes).rev() {
            field = transform(&field, size[axis], &cosines[axis]);
        }
        let mut stride = [1, size[0] + 2, (size[0] + 2) * (size[1] + 2)];
        if axes == 2 {
            stride[2] = 0;
        }
        Self { grid, period: grid.size().map(|side| 2 * (side + 1)), stride, table: field }
    }

    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// G of two cells.
    #[inline]
    pub fn at(&self, c: [u32; 3], s: [u32; 3]) -> f64 {
        let (near_x, far_x) = self.pair(0, c, s);
        let (near_y, far_y) = self.pair(1, c, s);
        let t = &self.table;
        if self.grid.axes() == 2 {
            return (t[near_x + near_y] - t[far_x + near_y]) - (t[near_x + far_y] - t[far_x + far_y]);
        }
        let (near_z, far_z) = self.pair(2, c, s);
        let plane = |z: usize| {
            (t[near_x + near_y + z] - t[far_x + near_y + z]) - (t[near_x + far_y + z] - t[far_x + far_y + z])
        };
        plane(near_z) - plane(far_z)
    }

    /// Places in the table of the difference and of the sum of two coordinates, counted from 1.
    #[inline]
    fn pair(&self, axis: usize, c: [u32; 3], s: [u32; 3]) -> (usize, usize) {
        let sum = c[axis] + s[axis] + 2;
        let folded = sum.min(self.period[axis] - sum);
        (c[axis].abs_diff(s[axis]) as usize * self.stride[axis], folded as usize * self.stride[axis])
    }
}

/// cos(pi k / (n + 1)) for k over one period.
fn cosine_period(n: usize) -> Vec<f64> {
    let half = n as u64 + 1;
    (0..2 * half).map(|k| cos_pi(k, half)).collect()
}

/// Sums over k = 1 to n of the slowest axis with cos(pi k p / (n + 1)) for p = 0 to n + 1; p becomes the fastest axis.
fn transform(field: &[f64], n: usize, cosines: &[f64]) -> Vec<f64> {
    let rest = field.len() / n;
    let mut out = vec![0.0; (n + 2) * rest];
    let mut line = vec![0.0; rest];
    for p in 0..n + 2 {
        line.fill(0.0);
        vectorised(
            #[inline(always)]
            || {
                for (k, row) in field.chunks_exact(rest).enumerate() {
                    let factor = cosines[(k + 1) * p % cosines.len()];
                    for (sum, value) in line.iter_mut().zip(row) {
                        *sum += factor * value;
                    }
                }
            },
        );
        for (place, value) in out[p..].iter_mut().step_by(n + 2).zip(&line) {
            *place = *value;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::poisson::Laplace;

    #[test]
    fn it_is_the_potential_of_a_unit_charge() {
        // A cell held at G(s, s) is a unit charge; conjugate gradients then give G(c, s) elsewhere.
        let grids = [Grid::plane(12, 9), Grid::plane(1, 7), Grid::volume(6, 5, 7), Grid::volume(3, 1, 2)];
        for grid in grids.map(|grid| grid.expect("a grid")) {
            let table = GreenTable::new(grid);
            let size = grid.size().map(|side| side as usize);
            for source in [0, grid.cells() / 2, grid.cells() - 1] {
                let s = grid.position(source as u32);
                let mut laplace = Laplace::new(size, grid.axes());
                laplace.hold(source, table.at(s, s));
                assert!(laplace.solve(1e-13, 500).converged);
                for cell in 0..grid.cells() {
                    let (found, expected) = (table.at(grid.position(cell as u32), s), laplace.potential(cell));
                    // The solver's residual of 1e-13 through an inverse of norm below 100, and rounding.
                    assert!((found - expected).abs() < 1e-11, "{grid:?} {cell} {source}: {found} {expected}");
                }
                // A unit charge: 2 axes G(s, s) less the neighbours' is 1.
                let around = super::super::super::grid::Walk::new(grid, super::super::super::grid::Neighbours::Faces);
                let flux: f64 = around.around(source as u32).map(|c| table.at(grid.position(c), s)).sum();
                assert!((2.0 * grid.axes() as f64 * table.at(s, s) - flux - 1.0).abs() < 1e-12);
            }
        }
    }
}
