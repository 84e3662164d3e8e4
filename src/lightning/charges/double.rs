//! Sums over charges in f64 with logarithms of the weights: any rho and eta.
//!
//! With rho = eta = 20 the weights of one step span some 1e-1000 to 1e1200, beyond f64: plain powers then give sums of 0 or
//! infinity without a word. So the logarithms are kept, the greatest is subtracted, and what is 708 below it has no chance.

use super::super::frontier::Candidate;
use super::super::urn::draw;
use super::super::walls::pull;
use super::{BLOCK, Charges, Law};
use crate::numeric::exact::{exp, ln};
use crate::numeric::vector::vectorised;

/// Lanes that a sum runs in.
const LANES: usize = 8;
/// Where the empty lanes of a block stand.
const NOWHERE: f64 = 1e6;

type Lanes = [f64; BLOCK];

struct Block {
    x: Lanes,
    y: Lanes,
    z: Lanes,
    fixed: Lanes,
    sum: Lanes,
    weight: Lanes,
}

/// The candidates and charges of one growing channel.
pub(in super::super) struct Double {
    law: Law,
    rho: f64,
    eta: f64,
    candidates: Vec<Candidate>,
    blocks: Vec<Block>,
    weights: Vec<f64>,
    charges: Vec<[f64; 3]>,
}

impl Double {
    /// No candidates, no charges.
    pub fn new(law: Law, rho: f64, eta: f64) -> Self {
        let (candidates, blocks, weights, charges) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { law, rho, eta, candidates, blocks, weights, charges }
    }

    /// The fixed number as it is stored: its logarithm for the rational potential.
    fn stored(&self, fixed: f64) -> f64 {
        match self.law {
            // No attraction at all (P = 0) cannot be: every distance is finite. The bound keeps ln to normal numbers.
            Law::Rational => ln(fixed.max(f64::MIN_POSITIVE)),
            Law::Laplacian => fixed,
        }
    }
}

impl Charges for Double {
    fn insert(&mut self, fresh: &[(Candidate, [u32; 3], f64)]) {
        let Self { charges, rho, .. } = self;
        let mut sums = vec![0.0; fresh.len()];
        // A loop, not an iterator chain: a closure left out of line would not be compiled for the instruction set.
        vectorised(
            #[inline(always)]
            || {
                for (sum, (_, position, _)) in sums.iter_mut().zip(fresh) {
                    let [x, y, z] = *position;
                    *sum = sum_over(charges, [f64::from(x), f64::from(y), f64::from(z)], *rho);
                }
            },
        );
        for (&(candidate, position, fixed), sum) in fresh.iter().zip(sums) {
            let slot = self.candidates.len();
            self.candidates.push(candidate);
            if slot.is_multiple_of(BLOCK) {
                self.blocks.push(Block::empty());
                self.weights.push(0.0);
            }
            let [x, y, z] = position.map(f64::from);
            let fixed = self.stored(fixed);
            self.blocks[slot / BLOCK].put(slot % BLOCK, [x, y, z, fixed, sum, 0.0]);
        }
    }

    fn take(&mut self, slot: usize) -> Candidate {
        let last = self.candidates.len() - 1;
        let moved = self.blocks[last / BLOCK].get(last % BLOCK);
        self.blocks[slot / BLOCK].put(slot % BLOCK, moved);
        self.blocks[last / BLOCK].put(last % BLOCK, Block::EMPTY);
        if last.is_multiple_of(BLOCK) {
            self.blocks.pop();
            self.weights.pop();
        }
        self.candidates.swap_remove(slot)
    }

    fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }

    fn fix(&mut self, slot: usize, fixed: f64) {
        self.blocks[slot / BLOCK].fixed[slot % BLOCK] = self.stored(fixed);
    }

    fn charge(&mut self, position: [u32; 3]) {
        let at = position.map(f64::from);
        self.charges.push(at);
        let Self { blocks, rho, .. } = self;
        vectorised(
            #[inline(always)]
            || {
                for block in blocks.iter_mut() {
                    add_charge(block, at, *rho);
                }
            },
        );
    }

    fn weigh(&mut self) {
        let count = self.candidates.len();
        let Self { blocks, weights, law, eta, .. } = self;
        vectorised(
            #[inline(always)]
            || {
                let mut least = f64::MAX;
                for slot in 0..if *law == Law::Laplacian { count } else { 0 } {
                    let block = &blocks[slot / BLOCK];
                    least = least.min(block.fixed[slot % BLOCK] - block.sum[slot % BLOCK]);
                }
                let mut greatest = f64::MIN;
                for (number, block) in blocks.iter_mut().enumerate() {
                    logarithms(block, *law, *eta, least);
                    for &logarithm in &block.weight[..(count - number * BLOCK).min(BLOCK)] {
                        greatest = greatest.max(logarithm);
                    }
                }
                for (number, (block, total)) in blocks.iter_mut().zip(weights.iter_mut()).enumerate() {
                    let filled = (count - number * BLOCK).min(BLOCK);
                    for k in 0..BLOCK {
                        block.weight[k] = exp(block.weight[k] - greatest);
                    }
                    block.weight[filled..].fill(0.0);
                    *total = sum_of(&block.weight);
                }
            },
        );
    }

    fn draw(&self, u: f64) -> Option<usize> {
        draw(u, &self.weights, |number| &self.blocks[number].weight[..]).map(|(number, lane)| number * BLOCK + lane)
    }

    #[cfg(test)]
    fn weight(&self, slot: usize) -> f64 {
        self.blocks[slot / BLOCK].weight[slot % BLOCK]
    }
}

impl Block {
    /// x, y, z, fixed, sum, weight of an empty lane.
    const EMPTY: [f64; 6] = [NOWHERE, 0.0, 0.0, 0.0, 1.0, 0.0];

    fn empty() -> Self {
        let [x, y, z, fixed, sum, weight] = Self::EMPTY.map(|value| [value; BLOCK]);
        Self { x, y, z, fixed, sum, weight }
    }

    fn get(&self, lane: usize) -> [f64; 6] {
        [self.x[lane], self.y[lane], self.z[lane], self.fixed[lane], self.sum[lane], self.weight[lane]]
    }

    fn put(&mut self, lane: usize, [x, y, z, fixed, sum, weight]: [f64; 6]) {
        (self.x[lane], self.y[lane], self.z[lane]) = (x, y, z);
        (self.fixed[lane], self.sum[lane], self.weight[lane]) = (fixed, sum, weight);
    }
}

#[inline(always)]
fn add_charge(block: &mut Block, [x, y, z]: [f64; 3], rho: f64) {
    for k in 0..BLOCK {
        let (dx, dy, dz) = (block.x[k] - x, block.y[k] - y, block.z[k] - z);
        block.sum[k] += pull(dx * dx + dy * dy + dz * dz, rho);
    }
}

/// Sum of distance^-rho over charges.
pub(in super::super) fn sum_of_pulls(charges: &[[f64; 3]], at: [f64; 3], rho: f64) -> f64 {
    vectorised(
        #[inline(always)]
        || sum_over(charges, at, rho),
    )
}

#[inline(always)]
fn sum_over(charges: &[[f64; 3]], [x, y, z]: [f64; 3], rho: f64) -> f64 {
    let mut lanes = [0.0; LANES];
    let whole = charges.chunks_exact(LANES);
    let rest = whole.remainder();
    for chunk in whole {
        for (lane, charge) in lanes.iter_mut().zip(chunk) {
            *lane += term(charge, [x, y, z], rho);
        }
    }
    for (lane, charge) in lanes.iter_mut().zip(rest) {
        *lane += term(charge, [x, y, z], rho);
    }
    fold(lanes)
}

#[inline(always)]
fn term(charge: &[f64; 3], [x, y, z]: [f64; 3], rho: f64) -> f64 {
    let (dx, dy, dz) = (charge[0] - x, charge[1] - y, charge[2] - z);
    pull(dx * dx + dy * dy + dz * dz, rho)
}

/// Puts the logarithms of the weights in place of the weights.
#[inline(always)]
fn logarithms(block: &mut Block, law: Law, eta: f64, least: f64) {
    for k in 0..BLOCK {
        let logarithm = match law {
            Law::Rational => block.fixed[k] - ln(block.sum[k]),
            // The least one has no chance (unless all are least: then all have the same).
            Law::Laplacian => ln((block.fixed[k] - block.sum[k] - least).max(f64::MIN_POSITIVE)),
        };
        block.weight[k] = eta * logarithm;
    }
}

#[inline(always)]
fn sum_of(values: &Lanes) -> f64 {
    let mut lanes = [0.0; LANES];
    for chunk in values.chunks_exact(LANES) {
        for (lane, value) in lanes.iter_mut().zip(chunk) {
            *lane += value;
        }
    }
    fold(lanes)
}

#[inline(always)]
fn fold(mut lanes: [f64; LANES]) -> f64 {
    let mut half = LANES / 2;
    while half > 0 {
        for lane in 0..half {
            lanes[lane] += lanes[lane + half];
        }
        half /= 2;
    }
    lanes[0]
}
