//! Growth by sums over charges: one more grown cell adds one term to the sum of every candidate.
//!
//! What it is: the rational potential and fast Laplacian growth both give a candidate a chance that depends on S, the sum of
//! distance^-rho over all grown cells, and on a number that stays (targets, walls, obstacles). How it is computed: S is kept for
//! every candidate and gets one term a step; a fresh candidate sums over all grown cells once. That is some G^2 evaluations for G cells
//! instead of G^3. How it is stored: candidates in blocks of 64, coordinate by coordinate, so that a whole block is one
//! run of vector instructions. How it is read: the weights of a block are summed as they are made, and a draw looks at block sums
//! first.
//!
//! The same source is compiled for several instruction sets and chosen at run time; all round alike (no fused
//! multiply-add, no approximate instruction, sums in fixed lanes), so the cells are the same on every machine.

pub(super) mod double;
pub(super) mod single;

use super::channel::{Channel, Info, Stop};
use super::error::GrowError;
use super::frontier::{Candidate, Frontier, Step};
use super::grid::Cell;
use super::grow::Order;
use super::random::Stream;
use std::sync::atomic::Ordering;

/// Candidates to a block.
const BLOCK: usize = 64;

/// How a candidate's weight follows from its sum S over the grown cells and its fixed number Q.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Law {
    /// (Q / S)^eta with Q = P / B: the rational potential.
    Rational,
    /// (Q - S - m)^eta with m the least Q - S of all candidates: fast Laplacian growth.
    Laplacian,
}

/// The candidates with their sums and weights, in one arithmetic.
pub(super) trait Charges {
    /// Adds candidates; their sums run over all charges so far.
    fn insert(&mut self, fresh: &[(Candidate, [u32; 3], f64)]);
    /// Takes a candidate out; the last one moves into its slot.
    fn take(&mut self, slot: usize) -> Candidate;
    /// All candidates, by slot.
    fn candidates(&self) -> &[Candidate];
    /// Changes a candidate's fixed number.
    fn fix(&mut self, slot: usize, fixed: f64);
    /// Adds a charge: one term to every sum.
    fn charge(&mut self, position: [u32; 3]);
    /// Makes the weights from the sums.
    fn weigh(&mut self);
    /// The slot at share `u` of all weights; none when there is no weight.
    fn draw(&self, u: f64) -> Option<usize>;
    /// A candidate's weight, up to a factor common to all.
    #[cfg(test)]
    fn weight(&self, slot: usize) -> f64;
}

/// Grows a channel to its end. `fixed` gives a cell's number for the targets that attract now.
pub(super) fn grow(
    mut frontier: Frontier,
    mut step: Step,
    charges: &mut impl Charges,
    fixed: impl Fn(&Frontier, Cell) -> f64,
    order: &Order<'_>,
) -> Result<(Channel, Info), GrowError> {
    let grid = frontier.scene.grid;
    let mut stream = Stream::new(order.seed, 0);
    let mut fresh = Vec::new();
    let mut draws = 0;
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
        take_step(&frontier, &step, charges, &fixed, &mut fresh);
        draws += 1;
        let Some(slot) = charges.draw(stream.unit()) else { break Stop::Exhausted };
        let candidate = charges.take(slot);
        frontier.grow(candidate, &mut step);
    };
    debug_assert!(frontier.cells() as usize <= grid.cells());
    Ok(frontier.end(stop, draws, 0.0))
}

/// Brings the candidates up to date with what the last cell changed.
pub(super) fn take_step(
    frontier: &Frontier,
    step: &Step,
    charges: &mut impl Charges,
    fixed: &impl Fn(&Frontier, Cell) -> f64,
    fresh: &mut Vec<(Candidate, [u32; 3], f64)>,
) {
    let grid = frontier.scene.grid;
    for &cell in &step.taken {
        if let Some(slot) = charges.candidates().iter().position(|candidate| candidate.cell == cell) {
            charges.take(slot);
        }
    }
    if step.retargeted {
        for slot in 0..charges.candidates().len() {
            let cell = charges.candidates()[slot].cell;
            charges.fix(slot, fixed(frontier, cell));
        }
    }
    fresh.clear();
    fresh.extend(step.fresh.iter().map(|&c| (c, grid.position(c.cell), fixed(frontier, c.cell))));
    charges.insert(fresh);
    for &cell in &step.charged {
        charges.charge(grid.position(cell));
    }
    charges.weigh();
}

#[cfg(test)]
mod tests {
    use super::double::Double;
    use super::single::Single;
    use super::*;

    /// Some candidates and charges, as a growing channel would have them.
    fn filled(mut charges: impl Charges) -> Vec<f64> {
        let mut stream = Stream::new(5, 0);
        let mut position = || [0; 3].map(|_: u32| (stream.bits() % 500) as u32);
        for number in 0..300_u32 {
            let [x, y, z] = position();
            // Candidates on even x, charges on odd: they never meet.
            let candidate = (Candidate { cell: number, parent: 0 }, [2 * x, y, z], 1.0 + f64::from(number % 7));
            charges.insert(&[candidate]);
            let [x, y, z] = position();
            charges.charge([2 * x + 1, y, z]);
        }
        for slot in [299, 64, 0, 17] {
            charges.take(slot);
        }
        charges.weigh();
        (0..charges.candidates().len()).map(|slot| charges.weight(slot)).collect()
    }

    #[test]
    fn both_arithmetics_give_the_same_weights() {
        for law in [Law::Rational, Law::Laplacian] {
            for (rho, eta) in [(1, 1), (1, 3), (2, 2), (3, 1), (3, 2), (4, 4)] {
                // The scale is for the range of f32; a difference must not be scaled.
                let scale = if law == Law::Rational { 1e-9 } else { 1.0 };
                let single = filled(Single::new(law, rho, eta, scale));
                let double = filled(Double::new(law, f64::from(rho), f64::from(eta)));
                let total = |weights: &[f64]| weights.iter().sum::<f64>();
                let apart: f64 =
                    single.iter().zip(&double).map(|(s, d)| (s / total(&single) - d / total(&double)).abs()).sum();
                // 300 terms in f32 at 2e-7 each, then a power of up to 4; for the Laplacian law the differences are of the
                // size of the sums themselves.
                assert!(apart < 1e-5, "{law:?} {rho} {eta}: {apart}");
            }
        }
    }

    #[test]
    fn another_exponent_gives_other_weights() {
        let [two, three] = [2, 3].map(|rho| filled(Single::new(Law::Rational, rho, 1, 1.0)));
        let total = |weights: &[f64]| weights.iter().sum::<f64>();
        let apart: f64 = two.iter().zip(&three).map(|(a, b)| (a / total(&two) - b / total(&three)).abs()).sum();
        assert!(apart > 0.1, "{apart}");
    }
}
