//! Laplace's equation on a box of cells with some cells held at given values: conjugate gradients with modified incomplete
//! Cholesky, MIC(0).
//!
//! The stencil is that of 4 neighbours in a plane and 6 in a volume; the ring (shell) of cells just outside the box is held at 0.
//! Source of the preconditioner: Gustafsson 1978, in the form of Bridson, *Fluid Simulation for Computer Graphics*, section 4.3.
//! Everything runs in the order of the cells, so results are the same on every machine.

/// Weight of the modification: 1 keeps row sums exactly, a little less is safer.
const MODIFIED: f64 = 0.97;
/// A pivot below this share of the diagonal is replaced by the diagonal.
const SAFE_PIVOT: f64 = 0.25;

/// A potential on a box, with the cells that are held.
///
/// Cells are numbered x + nx (y + ny z). Inside, every row has a cell of the outside on either side, so that no step of the
/// solver asks whether a neighbour exists.
#[derive(Clone, Debug)]
pub struct Laplace {
    size: [usize; 3],
    /// Distance in memory from a cell to the next along each axis; equal steps of 0 mean an axis that is not there.
    stride: [usize; 3],
    axes: usize,
    /// Where in memory each row of cells along x begins.
    rows: Vec<usize>,
    potential: Vec<f64>,
    /// 1 for a cell that is solved for, 0 for one that is held or outside.
    free: Vec<f64>,
    work: Work,
}

#[derive(Clone, Debug)]
struct Work {
    residual: Vec<f64>,
    pivot: Vec<f64>,
    direction: Vec<f64>,
    conditioned: Vec<f64>,
    applied: Vec<f64>,
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solved {
    /// Iterations taken.
    pub iterations: u32,
    /// Greatest absolute residual, |sum of neighbours - 2 axes phi| over the free cells.
    pub residual: f64,
    /// Whether that is within the tolerance.
    pub converged: bool,
}

impl Laplace {
    /// All cells free and at 0. `axes` is 2 (then the third side is 1) or 3.
    pub fn new(size: [usize; 3], axes: usize) -> Self {
        debug_assert!(axes == 3 || (axes == 2 && size[2] == 1));
        let stride = [1, size[0] + 2, (size[0] + 2) * (size[1] + 2)];
        let depth = if axes == 3 { size[2] + 2 } else { 1 };
        let length = stride[2] * depth;
        let mut laplace = Self {
            size,
            stride,
            axes,
            rows: Vec::new(),
            potential: vec![0.0; length],
            free: vec![0.0; length],
            work: Work {
                residual: vec![0.0; length],
                pivot: vec![0.0; length],
                direction: vec![0.0; length],
                conditioned: vec![0.0; length],
                applied: vec![0.0; length],
            },
        };
        for cell in 0..size.iter().product() {
            let at = laplace.index(cell);
            laplace.free[at] = 1.0;
            if cell % size[0] == 0 {
                laplace.rows.push(at);
            }
        }
        laplace
    }

    /// Holds a cell at a value from now on.
    pub fn hold(&mut self, cell: usize, value: f64) {
        let at = self.index(cell);
        self.free[at] = 0.0;
        self.potential[at] = value;
    }

    /// The potential of a cell.
    pub fn potential(&self, cell: usize) -> f64 {
        self.potential[self.index(cell)]
    }

    fn index(&self, cell: usize) -> usize {
        let [nx, ny, _] = self.size;
        let (x, y, z) = (cell % nx, cell / nx % ny, cell / nx / ny);
        let z = if self.axes == 3 { z + 1 } else { 0 };
        (x + 1) + (y + 1) * self.stride[1] + z * self.stride[2]
    }

    /// Solves from the present potential on, until no residual is above `tolerance`.
    pub fn solve(&mut self, tolerance: f64, most_iterations: u32) -> Solved {
        match self.axes {
            2 => self.solve_on::<2>(tolerance, most_iterations),
            _ => self.solve_on::<3>(tolerance, most_iterations),
        }
    }

    fn solve_on<const AXES: usize>(&mut self, tolerance: f64, most_iterations: u32) -> Solved {
        let stride = self.stride;
        let diagonal = 2.0 * AXES as f64;
        let nx = self.size[0];
        let Self { potential, free, work, rows, .. } = self;
        let Work { residual, pivot, direction, conditioned, applied } = work;

        let mut greatest = 0.0_f64;
        for at in rows.iter().flat_map(|&row| row..row + nx) {
            residual[at] = free[at] * (neighbours::<AXES>(potential, at, stride) - diagonal * potential[at]);
            greatest = greatest.max(residual[at].abs());
        }
        if greatest <= tolerance {
            return Solved { iterations: 0, residual: greatest, converged: true };
        }
        factorise::<AXES>(free, pivot, rows, nx, stride);
        precondition::<AXES>(residual, pivot, conditioned, rows, nx, stride);
        direction.copy_from_slice(conditioned);
        let mut rho = dot(residual, conditioned);
        let mut iterations = 0;
        while iterations < most_iterations && rho > 0.0 {
            iterations += 1;
            let mut curvature = 0.0;
            for &row in rows.iter() {
                for at in row..row + nx {
                    applied[at] = free[at] * (diagonal * direction[at] - neighbours::<AXES>(direction, at, stride));
                    curvature += applied[at] * direction[at];
                }
            }
            let step = rho / curvature;
            greatest = 0.0;
            for ((value, left), (along, image)) in
                potential.iter_mut().zip(residual.iter_mut()).zip(direction.iter().zip(applied.iter()))
            {
                *value += step * along;
                *left -= step * image;
                greatest = if left.abs() > greatest { left.abs() } else { greatest };
            }
            if greatest <= tolerance {
                break;
            }
            precondition::<AXES>(residual, pivot, conditioned, rows, nx, stride);
            let next = dot(residual, conditioned);
            let turn = next / rho;
            rho = next;
            for (along, towards) in direction.iter_mut().zip(conditioned.iter()) {
                *along = towards + turn * *along;
            }
        }
        Solved { iterations, residual: greatest, converged: greatest <= tolerance }
    }
}

#[inline(always)]
fn neighbours<const AXES: usize>(field: &[f64], at: usize, stride: [usize; 3]) -> f64 {
    let mut sum = (field[at - 1] + field[at + 1]) + (field[at - stride[1]] + field[at + stride[1]]);
    if AXES == 3 {
        sum += field[at - stride[2]] + field[at + stride[2]];
    }
    sum
}

/// The inverse roots of the pivots of MIC(0); 0 for cells that are not free.
fn factorise<const AXES: usize>(free: &[f64], pivot: &mut [f64], rows: &[usize], nx: usize, stride: [usize; 3]) {
    let diagonal = 2.0 * AXES as f64;
    for at in rows.iter().flat_map(|&row| row..row + nx) {
        if free[at] == 0.0 {
            pivot[at] = 0.0;
            continue;
        }
        let mut value = diagonal;
        for axis in 0..AXES {
            let before = at - stride[axis];
            let square = pivot[before] * pivot[before];
            // Links of the earlier cell to later ones that the factor drops.
            let dropped: f64 = (0..AXES).filter(|&other| other != axis).map(|other| free[before + stride[other]]).sum();
            value -= square * (1.0 + MODIFIED * dropped);
        }
        if value < SAFE_PIVOT * diagonal {
            value = diagonal;
        }
        pivot[at] = 1.0 / value.sqrt();
    }
}

/// Solves L L^T z = r for MIC(0)'s L.
fn precondition<const AXES: usize>(
    residual: &[f64],
    pivot: &[f64],
    z: &mut [f64],
    rows: &[usize],
    nx: usize,
    stride: [usize; 3],
) {
    for &row in rows {
        let mut last = 0.0;
        for at in row..row + nx {
            let mut sum = residual[at] + pivot[at - stride[1]] * z[at - stride[1]];
            if AXES == 3 {
                sum += pivot[at - stride[2]] * z[at - stride[2]];
            }
            last = (sum + pivot[at - 1] * last) * pivot[at];
            z[at] = last;
        }
    }
    for &row in rows.iter().rev() {
        let mut last = 0.0;
        for at in (row..row + nx).rev() {
            let mut sum = z[at + stride[1]];
            if AXES == 3 {
                sum += z[at + stride[2]];
            }
            last = (z[at] + pivot[at] * (sum + last)) * pivot[at];
            z[at] = last;
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Eight fixed lanes: the order of a sum is part of the result.
    let mut lanes = [0.0; 8];
    let (a8, b8) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a8.remainder().iter().zip(b8.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a8.zip(b8) {
        for (lane, (x, y)) in lanes.iter_mut().zip(x.iter().zip(y)) {
            *lane += x * y;
        }
    }
    lanes.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Figure 4 of Yun et al.: 7 x 7 cells, row 0 at the top, the potential to three decimals.
    const FIGURE_4: [[f64; 7]; 7] = [
        [0.002, 0.003, 0.001, 0.0, 0.001, 0.003, 0.002],
        [0.006, 0.008, 0.002, 0.0, 0.002, 0.008, 0.006],
        [0.015, 0.021, 0.0, 0.027, 0.0, 0.021, 0.015],
        [0.032, 0.062, 0.086, 0.106, 0.086, 0.062, 0.032],
        [0.051, 0.109, 0.176, 0.226, 0.176, 0.109, 0.051],
        [0.062, 0.148, 0.281, 0.447, 0.281, 0.148, 0.062],
        [0.05, 0.138, 0.355, 1.0, 0.355, 0.138, 0.05],
    ];

    fn figure_4() -> Laplace {
        let mut laplace = Laplace::new([7, 7, 1], 2);
        for (row, column) in [(0, 3), (1, 3), (2, 2), (2, 4)] {
            laplace.hold(row * 7 + column, 0.0);
        }
        laplace.hold(6 * 7 + 3, 1.0);
        laplace
    }

    #[test]
    fn all_49_values_of_the_papers_figure_4() {
        let mut laplace = figure_4();
        assert!(laplace.solve(1e-12, 100).converged);
        for (cell, printed) in FIGURE_4.iter().flatten().enumerate() {
            let found = laplace.potential(cell);
            assert_eq!((found * 1000.0).round() / 1000.0, *printed, "cell {cell}: {found}");
        }
        // Row 3 and half of row 6 as an independent solver gave them, to its 6 digits.
        let row_3 = [0.031933, 0.062055, 0.085955, 0.106149, 0.085955, 0.062055, 0.031933];
        let row_6 = [0.050069, 0.138150, 0.354872, 1.0];
        for (cell, expected) in (21..).zip(row_3).chain((42..).zip(row_6)) {
            assert!((laplace.potential(cell) - expected).abs() < 6e-7, "cell {cell}");
        }
    }

    #[test]
    fn another_boundary_misses_the_figure() {
        // The ring half a cell nearer, say, or a cell that is not held: the test above has power.
        let mut laplace = figure_4();
        laplace.hold(2 * 7 + 3, 0.0);
        assert!(laplace.solve(1e-12, 100).converged);
        let wrong =
            FIGURE_4.iter().flatten().enumerate().filter(|(cell, printed)| {
                ((laplace.potential(*cell) * 1000.0).round() / 1000.0 - **printed).abs() > 1e-9
            });
        assert!(wrong.count() > 5);
    }

    #[test]
    fn a_separable_solution_in_3d() {
        // Held planes x = 0 at sin(pi (y+1)/8) sin(pi (z+1)/8): inside, phi falls as sinh towards the far wall, with
        // cosh(mu) = 3 - 2 cos(pi / 8).
        let n = 7;
        let mut laplace = Laplace::new([n; 3], 3);
        let wave = |k: usize| (std::f64::consts::PI * (k + 1) as f64 / 8.0).sin();
        for cell in (0..n * n * n).step_by(n) {
            laplace.hold(cell, wave(cell / n % n) * wave(cell / n / n));
        }
        let solved = laplace.solve(1e-13, 200);
        assert!(solved.converged && solved.iterations < 40, "{solved:?}");
        let mu = (3.0 - 2.0 * (std::f64::consts::PI / 8.0).cos()).acosh();
        for cell in 0..n * n * n {
            let (x, y, z) = (cell % n, cell / n % n, cell / n / n);
            let expected = wave(y) * wave(z) * (mu * (n - x) as f64).sinh() / (mu * n as f64).sinh();
            // A residual of 1e-13 through an inverse of norm below 10.
            assert!((laplace.potential(cell) - expected).abs() < 1e-12, "cell {cell}");
        }
    }

    #[test]
    fn a_warm_start_needs_fewer_iterations_and_a_solved_field_none() {
        let mut laplace = Laplace::new([64, 64, 1], 2);
        laplace.hold(63 * 64 + 32, 0.0);
        laplace.hold(32, 1.0);
        let cold = laplace.solve(1e-6, 200);
        assert_eq!(laplace.solve(1e-6, 200).iterations, 0);
        laplace.hold(62 * 64 + 32, 0.0);
        let warm = laplace.solve(1e-6, 200);
        assert!(cold.converged && warm.converged && warm.iterations < cold.iterations, "{cold:?} {warm:?}");
        laplace.hold(2000, 1.0);
        assert!(!laplace.solve(1e-12, 2).converged);
    }
}
