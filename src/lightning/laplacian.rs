//! Fast Laplacian growth: each grown cell pushes every candidate away by a term of the potential of a sphere.
//!
//! Kim, Sewall, Sud and Lin 2007, "Fast simulation of Laplacian growth": phi_i = sum_j (1 - R / r_ij) over the grown cells with
//! R half a cell, and a chance in proportion to ((phi_i - min) / (max - min))^eta. The 1 is the same for all candidates and
//! drops out of the difference, the range out of the proportion, so what is kept is the sum of 1 / r. A target adds
//! `pull` * R / r: the published form has none, and the lightning paper notes that it takes a strong one.

use super::channel::{Channel, Info};
use super::charges::double::{Double, sum_of_pulls};
use super::charges::single::{GREATEST_ETA, Single};
use super::charges::{Law, grow};
use super::error::{GrowError, in_range};
use super::frontier::Frontier;
use super::grid::Cell;
use super::grow::{ETA_RANGE, Order};
use super::rational::{Arithmetic, centre, small_and_whole, squared};
use super::tables::Tables;
use super::walls::pull;
use super::waypoints::waypoints;

/// A pull that draws a channel to a single target across the grids of the lightning paper.
pub const DEFAULT_PULL: f64 = 1000.0;
/// Range of the pull of a target, in charges.
pub const PULL_RANGE: [f64; 2] = [0.0, 1e6];

/// Grows a channel by fast Laplacian growth.
pub(super) fn laplacian(
    order: &Order<'_>,
    eta: f64,
    strength: f64,
    arithmetic: Arithmetic,
    tables: &mut Tables,
) -> Result<(Channel, Info), GrowError> {
    in_range("eta", eta, ETA_RANGE)?;
    in_range("pull", strength, PULL_RANGE)?;
    let scene = order.scene;
    let map = scene.checked()?;
    let waypoints = waypoints(scene, &map)?;
    let walls = tables.walls(scene.grid, 1.0);
    let obstacles: Vec<[f64; 3]> = scene.obstacles.iter().map(|&cell| centre(scene.grid, cell)).collect();
    let (frontier, step) = Frontier::new(scene, map, &waypoints);
    let fixed = |frontier: &Frontier, cell: Cell| {
        let at = centre(scene.grid, cell);
        let attraction: f64 = match frontier.ground {
            true => walls.ground(cell),
            false => frontier.active.iter().map(|&target| pull(squared(at, centre(scene.grid, target)), 1.0)).sum(),
        };
        strength * attraction - sum_of_pulls(&obstacles, at, 1.0)
    };
    if arithmetic == Arithmetic::Fitting && small_and_whole(eta, GREATEST_ETA) {
        let mut charges = Single::new(Law::Laplacian, 1, eta as u32, 1.0);
        return grow(frontier, step, &mut charges, fixed, order);
    }
    grow(frontier, step, &mut Double::new(Law::Laplacian, 1.0, eta), fixed, order)
}
