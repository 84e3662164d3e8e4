//! The rational potential: phi = P / (N B), the lightning paper's fast stand-in for the solution of Laplace's equation.
//!
//! P, N and B are sums of distance^-rho over the targets, the channel so far and the border with obstacles (Yun et al., eq. 4
//! and 5); a candidate's chance is in proportion to phi^eta (eq. 2). Because N divides, a candidate shut in by the channel has
//! next to none: the tip effect.

use super::channel::{Channel, Info};
use super::charges::double::{Double, sum_of_pulls};
use super::charges::single::{GREATEST_ETA, GREATEST_RHO, Single};
use super::charges::{Law, grow};
use super::error::{GrowError, in_range};
use super::frontier::Frontier;
use super::grid::{Cell, Grid};
use super::grow::{ETA_RANGE, Order};
use super::scene::{Goal, Scene};
use super::tables::Tables;
use super::walls::{WallSums, pull};
use super::waypoints::waypoints;
use crate::numeric::exact::{ln, pow};

/// Range of rho. Below 1 the far charges count nearly as much as the near ones; above 10 only the nearest counts.
pub const RHO_RANGE: [f64; 2] = [0.1, 20.0];

/// Which arithmetic holds the sums.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Arithmetic {
    /// f32 where exponents are small and whole and the weights fit its range with room to spare, else f64 with logarithms.
    #[default]
    Fitting,
    /// Always f64 with logarithms: the same distribution from other roundings.
    Double,
}

/// Decades that f32 weights may span: 1e-35 to 1e35, so that a sum over many of the greatest still fits.
const SINGLE_DECADES: f64 = 70.0;

/// Grows a channel by the rational potential.
pub(super) fn rational(
    order: &Order<'_>,
    eta: f64,
    rho: f64,
    arithmetic: Arithmetic,
    tables: &mut Tables,
) -> Result<(Channel, Info), GrowError> {
    in_range("eta", eta, ETA_RANGE)?;
    in_range("rho", rho, RHO_RANGE)?;
    let scene = order.scene;
    let map = scene.checked()?;
    let waypoints = waypoints(scene, &map)?;
    let walls = tables.walls(scene.grid, rho);
    let obstacles: Vec<[f64; 3]> = scene.obstacles.iter().map(|&cell| centre(scene.grid, cell)).collect();
    let (frontier, step) = Frontier::new(scene, map, &waypoints);
    let fixed = |frontier: &Frontier, cell: Cell| {
        let at = centre(scene.grid, cell);
        let positive = match frontier.ground {
            true => walls.ground(cell),
            false if frontier.active.is_empty() => 1.0,
            false => frontier.active.iter().map(|&target| pull(squared(at, centre(scene.grid, target)), rho)).sum(),
        };
        let mut border = walls.shell(cell);
        if !obstacles.is_empty() {
            border += sum_of_pulls(&obstacles, at, rho);
        }
        positive / border
    };
    match single_scale(scene, &walls, eta, rho).filter(|_| arithmetic == Arithmetic::Fitting) {
        Some(scale) => {
            let mut charges = Single::new(Law::Rational, rho as u32, eta as u32, scale);
            grow(frontier, step, &mut charges, fixed, order)
        }
        None => grow(frontier, step, &mut Double::new(Law::Rational, rho, eta), fixed, order),
    }
}

/// Centre of a cell in cells.
pub(super) fn centre(grid: Grid, cell: Cell) -> [f64; 3] {
    grid.position(cell).map(f64::from)
}

/// Squared distance.
pub(super) fn squared(a: [f64; 3], b: [f64; 3]) -> f64 {
    let d: [f64; 3] = std::array::from_fn(|axis| a[axis] - b[axis]);
    d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
}

/// Whether a number is a whole one of 1 to `greatest`.
pub(super) fn small_and_whole(value: f64, greatest: u32) -> bool {
    (1..=greatest).any(|whole| value == f64::from(whole))
}

/// What to multiply P / B by so that all weights fit f32; none when they do not, or the exponents are not small and whole.
fn single_scale(scene: &Scene, walls: &WallSums, eta: f64, rho: f64) -> Option<f64> {
    if !small_and_whole(rho, GREATEST_RHO) || !small_and_whole(eta, GREATEST_ETA) {
        return None;
    }
    let grid = scene.grid;
    let size = grid.size();
    let far = size.map(|side| f64::from(side - 1));
    let diagonal = squared(far, [0.0; 3]).max(1.0);
    let middle = size.map(|side| side / 2);
    // Bounds of P: one target at the far corner; all targets next to the candidate.
    let (least_p, greatest_p) = match &scene.goal {
        Goal::Free => (1.0, 1.0),
        Goal::Ground => {
            let mut above = middle;
            above[grid.axes() - 1] = 1;
            (pull(diagonal, rho), walls.ground(grid.cell(above.map(|p| p.min(size[0].max(size[1]).max(size[2]) - 1)))))
        }
        Goal::Nearest(targets) | Goal::Every(targets) | Goal::Chain(targets) => {
            (pull(diagonal, rho), targets.len() as f64)
        }
    };
    // Of B: in the middle; in a corner among obstacles.
    let least_b = walls.shell(grid.cell(middle));
    let greatest_b = walls.shell(0) + scene.obstacles.len() as f64;
    // Of N: one diagonal neighbour; a lattice full of charges, which grows with the grid where rho is small.
    let axes = grid.axes() as f64;
    let least_n = pull(axes, rho);
    let greatest_n = 30.0 * pow(diagonal, 0.5 * (axes - rho + 0.5).max(0.0));
    let least = least_p / (greatest_b * greatest_n);
    let greatest = greatest_p / (least_b * least_n);
    let decades = eta * ln(greatest / least) / std::f64::consts::LN_10;
    // In the middle, so that both ends are equally far from the limits.
    (decades <= SINGLE_DECADES).then(|| 1.0 / (least * greatest).sqrt())
}
