//! Exact dielectric breakdown, the slow way: the whole grid is solved anew after every cell, as Kim and Lin 2004 do.

use super::super::channel::{Channel, Info, Stop};
use super::super::error::{GrowError, in_range};
use super::super::frontier::{Candidate, Frontier};
use super::super::grow::{ETA_RANGE, Order, TOLERANCE_RANGE};
use super::super::random::Stream;
use super::super::scene::Goal;
use super::super::urn::Urn;
use super::{Weight, field_cells};
use crate::numeric::poisson::Laplace;
use std::sync::atomic::Ordering;

/// Iterations after which a solve has failed: MIC(0) needs some 20 for 128 x 128, growing as the root of the side.
const MOST_ITERATIONS: u32 = 2000;

/// Grows a channel by solves of the whole grid, each from the last one's solution, to a greatest residual of `tolerance`.
pub(in super::super) fn conjugate(order: &Order<'_>, eta: f64, tolerance: f64) -> Result<(Channel, Info), GrowError> {
    in_range("eta", eta, ETA_RANGE)?;
    in_range("tolerance", tolerance, TOLERANCE_RANGE)?;
    let scene = order.scene;
    let map = scene.checked()?;
    let in_field = field_cells(scene, &map)?;
    // A free channel at 0 in a border at 1 is one minus a channel at 1 in a border at 0.
    let free = scene.goal == Goal::Free;
    let (repelling, attracting) = if free { (1.0, 0.0) } else { (0.0, 1.0) };
    let mut laplace = Laplace::new(scene.grid.size().map(|side| side as usize), scene.grid.axes());
    for &cell in &scene.obstacles {
        laplace.hold(cell as usize, repelling);
    }
    let (mut frontier, mut step) = Frontier::new(scene, map, &[]);
    let mut candidates: Vec<Candidate> = Vec::new();
    let mut urn = Urn::default();
    let mut weight = Weight::new(eta);
    let mut stream = Stream::new(order.seed, 0);
    let (mut iterations, mut residual) = (0, 0.0_f64);
    let stop = loop {
        if frontier.finished() {
            break Stop::Reached;
        }
        if frontier.cells() >= order.most_cells {
            break Stop::CellLimit;
        }
        if order.cancel.load(Ordering::Relaxed) {
            return Err(frontier.cancelled());
        }
        for &cell in &step.charged {
            laplace.hold(cell as usize, repelling);
        }
        for &cell in &frontier.active {
            laplace.hold(cell as usize, attracting);
        }
        for &cell in &step.taken {
            if let Some(slot) = candidates.iter().position(|candidate| candidate.cell == cell) {
                candidates.swap_remove(slot);
                urn.swap_remove(slot);
            }
        }
        for &candidate in &step.fresh {
            candidates.push(candidate);
            urn.push(0.0);
        }
        let solved = laplace.solve(tolerance, MOST_ITERATIONS);
        iterations += u64::from(solved.iterations);
        residual = residual.max(solved.residual);
        if !solved.converged {
            return Err(GrowError::NoConvergence {
                iterations: solved.iterations,
                residual: solved.residual,
                tolerance,
            });
        }
        let potential = |slot: usize| {
            let cell = candidates[slot].cell as usize;
            let value = laplace.potential(cell);
            let reached = in_field.as_ref().is_none_or(|reached| reached[cell]);
            // The solver's error can leave a small negative potential.
            if reached { f64::max(if free { 1.0 - value } else { value }, 0.0) } else { 0.0 }
        };
        weight.refer_to((0..candidates.len()).map(potential));
        urn.set_all(|slot| weight.of(potential(slot)));
        let Some(slot) = urn.draw(stream.unit()) else { break Stop::Exhausted };
        urn.swap_remove(slot);
        let candidate = candidates.swap_remove(slot);
        frontier.grow(candidate, &mut step);
    };
    Ok(frontier.end(stop, iterations, residual))
}
