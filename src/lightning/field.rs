//! The potential that a method sees, over a whole grid: for pictures, and for figure 6 of the lightning paper.

use super::charges::double::sum_of_pulls;
use super::error::{GrowError, in_range};
use super::grid::Cell;
use super::grow::TOLERANCE_RANGE;
use super::rational::{RHO_RANGE, centre};
use super::scene::{Goal, Scene};
use super::walls::WallSums;
use crate::numeric::poisson::Laplace;

/// Whose potential.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Potential {
    /// Laplace's equation: the dielectric breakdown model's.
    Laplace,
    /// The same, solved from 0 until no residual is above a tolerance: what a loose solver sees.
    LaplaceTo {
        /// Greatest residual.
        tolerance: f64,
    },
    /// P - N - B: the sum of all charges, the form that the lightning paper argues against.
    Sum {
        /// Exponent of the distance.
        rho: f64,
    },
    /// P / (N B): the rational potential.
    Rational {
        /// Exponent of the distance.
        rho: f64,
    },
    /// Fast Laplacian growth's: pull / r of the targets less the sum of 1 / r of the channel.
    Laplacian {
        /// Pull of a target in charges.
        pull: f64,
    },
}

const TOLERANCE: f64 = 1e-9;
const MOST_ITERATIONS: u32 = 5000;

/// The potential in every cell with the channel in some cells; 0 where obstacles or the channel stand (and at most what a
/// neighbour of a target has at the target, where sums over distances are infinite).
///
/// # Errors
/// As growing in this scene, or the solver does not converge.
pub fn potential(kind: Potential, scene: &Scene, channel: &[Cell]) -> Result<Vec<f64>, GrowError> {
    scene.checked()?;
    let grid = scene.grid;
    let targets = scene.targets();
    let held: Vec<Cell> = channel.iter().chain(&scene.obstacles).copied().collect();
    let mut field = match kind {
        Potential::Laplace => laplace(scene, &targets, &held, TOLERANCE)?,
        Potential::LaplaceTo { tolerance } => {
            in_range("tolerance", tolerance, TOLERANCE_RANGE)?;
            laplace(scene, &targets, &held, tolerance)?
        }
        Potential::Sum { rho } | Potential::Rational { rho } => {
            in_range("rho", rho, RHO_RANGE)?;
            let places = |cells: &[Cell]| -> Vec<[f64; 3]> { cells.iter().map(|&cell| centre(grid, cell)).collect() };
            let (positive, negative, shut) = (places(&targets), places(channel), places(&scene.obstacles));
            let walls = WallSums::new(grid, rho);
            let one = |cell: Cell| {
                let at = centre(grid, cell);
                let p = if targets.is_empty() { 1.0 } else { sum_of_pulls(&positive, at, rho) };
                let n = sum_of_pulls(&negative, at, rho);
                let b = walls.shell(cell) + sum_of_pulls(&shut, at, rho);
                if matches!(kind, Potential::Sum { .. }) { p - n - b } else { p / (n * b) }
            };
            outside(scene, &held, &targets, one)
        }
        Potential::Laplacian { pull } => {
            let places = |cells: &[Cell]| -> Vec<[f64; 3]> { cells.iter().map(|&cell| centre(grid, cell)).collect() };
            let (positive, negative) = (places(&targets), places(&held));
            let one = |cell: Cell| {
                let at = centre(grid, cell);
                pull * sum_of_pulls(&positive, at, 1.0) - sum_of_pulls(&negative, at, 1.0)
            };
            outside(scene, &held, &targets, one)
        }
    };
    for &cell in &held {
        field[cell as usize] = 0.0;
    }
    Ok(field)
}

fn laplace(scene: &Scene, targets: &[Cell], held: &[Cell], tolerance: f64) -> Result<Vec<f64>, GrowError> {
    let grid = scene.grid;
    // As in growth: a free channel sees a border at 1.
    let free = scene.goal == Goal::Free;
    let mut laplace = Laplace::new(grid.size().map(|side| side as usize), grid.axes());
    for &cell in targets {
        laplace.hold(cell as usize, 1.0);
    }
    for &cell in held {
        laplace.hold(cell as usize, if free { 1.0 } else { 0.0 });
    }
    let solved = laplace.solve(tolerance, MOST_ITERATIONS);
    if !solved.converged {
        let (iterations, residual) = (solved.iterations, solved.residual);
        return Err(GrowError::NoConvergence { iterations, residual, tolerance });
    }
    let value = |cell: usize| if free { 1.0 - laplace.potential(cell) } else { laplace.potential(cell) };
    Ok((0..grid.cells()).map(value).collect())
}

/// Evaluates where nothing stands; a target gets the greatest value found elsewhere.
fn outside(scene: &Scene, held: &[Cell], targets: &[Cell], one: impl Fn(Cell) -> f64) -> Vec<f64> {
    let mut stands = vec![false; scene.grid.cells()];
    for &cell in held.iter().chain(targets) {
        stands[cell as usize] = true;
    }
    let mut field: Vec<f64> =
        (0..scene.grid.cells() as Cell).map(|cell| if stands[cell as usize] { 0.0 } else { one(cell) }).collect();
    let free = field.iter().zip(&stands).filter(|(_, stands)| !**stands);
    let greatest = free.map(|(value, _)| *value).fold(f64::MIN, f64::max);
    for &cell in targets {
        field[cell as usize] = greatest;
    }
    field
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lightning::grid::Grid;

    /// Potentials down the middle column, from the start to the target, as shares of the value next to the target.
    fn profile(kind: Potential) -> Vec<f64> {
        let grid = Grid::plane(64, 64).expect("a grid");
        let scene = Scene::top_to_bottom(grid);
        let field = potential(kind, &scene, &[scene.start]).expect("a right scene");
        let next = field[grid.cell([32, 1, 0]) as usize];
        (1..63).rev().map(|y| field[grid.cell([32, y, 0]) as usize] / next).collect()
    }

    #[test]
    fn the_rational_potential_rises_to_the_target_as_laplaces_does_and_the_sum_does_not() {
        let rises = |profile: &[f64]| profile.windows(2).all(|pair| pair[1] > pair[0]);
        assert!(rises(&profile(Potential::Laplace)) && rises(&profile(Potential::Rational { rho: 3.0 })));
        // Figure 6 of the paper: the sum is flat in the middle, where the others are still rising.
        let sum = profile(Potential::Sum { rho: 3.0 });
        let slope = |profile: &[f64]| (profile[40] - profile[20]).abs() / profile[40].abs().max(1e-12);
        assert!(slope(&profile(Potential::Laplace)) > 0.5 && slope(&profile(Potential::Rational { rho: 3.0 })) > 0.5);
        let spread = sum.iter().copied().fold(f64::MIN, f64::max) - sum.iter().copied().fold(f64::MAX, f64::min);
        assert!((sum[40] - sum[20]).abs() < 0.01 * spread, "{} of {spread}", sum[40] - sum[20]);
    }
}
