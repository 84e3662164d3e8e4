//! Sums over charges in f32, for small whole exponents: the fast form.
//!
//! Reciprocals and inverse roots start from the bits of the number and are refined by three steps of Newton's method, so they
//! are plain multiplications, the same on every machine, and as exact as f32 (2e-7).

use super::super::frontier::Candidate;
use super::super::urn::draw;
use super::{BLOCK, Charges, Law};
use crate::numeric::vector::vectorised;

/// Greatest whole rho and eta that this form takes.
pub(in super::super) const GREATEST_RHO: u32 = 4;
pub(in super::super) const GREATEST_ETA: u32 = 4;
/// Lanes that a sum runs in: one AVX-512 register. Narrower machines add in the same lanes.
const LANES: usize = 16;
/// Where the empty lanes of a block stand: far outside every grid.
const NOWHERE: f32 = 1e6;

type Lanes = [f32; BLOCK];

struct Block {
    x: Lanes,
    y: Lanes,
    z: Lanes,
    fixed: Lanes,
    sum: Lanes,
    weight: Lanes,
}

/// Charges by coordinate; `strength` is 0 in empty lanes.
struct ChargeBlock {
    x: Lanes,
    y: Lanes,
    z: Lanes,
    strength: Lanes,
}

/// The candidates and charges of one growing channel.
pub(in super::super) struct Single {
    law: Law,
    rho: u32,
    eta: u32,
    /// Every fixed number is multiplied by this, so that weights stay in the middle of the range of f32.
    scale: f64,
    candidates: Vec<Candidate>,
    blocks: Vec<Block>,
    weights: Vec<f32>,
    charges: Vec<ChargeBlock>,
    charge_count: usize,
}

impl Single {
    /// No candidates, no charges. `rho` is 1 to [`GREATEST_RHO`], `eta` 1 to [`GREATEST_ETA`].
    pub fn new(law: Law, rho: u32, eta: u32, scale: f64) -> Self {
        debug_assert!((1..=GREATEST_RHO).contains(&rho) && (1..=GREATEST_ETA).contains(&eta));
        let (candidates, blocks, weights, charges) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { law, rho, eta, scale, candidates, blocks, weights, charges, charge_count: 0 }
    }
}

impl Charges for Single {
    fn insert(&mut self, fresh: &[(Candidate, [u32; 3], f64)]) {
        let Self { charges, rho, .. } = self;
        let mut sums = vec![0.0; fresh.len()];
        // A loop, not an iterator chain: a closure left out of line would not be compiled for the instruction set.
        vectorised(
            #[inline(always)]
            || {
                for (sum, (_, position, _)) in sums.iter_mut().zip(fresh) {
                    let [x, y, z] = *position;
                    *sum = sum_over(charges, [x as f32, y as f32, z as f32], *rho);
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
            let [x, y, z] = position.map(|p| p as f32);
            let fixed = (fixed * self.scale) as f32;
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
        self.blocks[slot / BLOCK].fixed[slot % BLOCK] = (fixed * self.scale) as f32;
    }

    fn charge(&mut self, position: [u32; 3]) {
        let at = position.map(|p| p as f32);
        let lane = self.charge_count % BLOCK;
        if lane == 0 {
            self.charges.push(ChargeBlock {
                x: [NOWHERE; BLOCK],
                y: [0.0; BLOCK],
                z: [0.0; BLOCK],
                strength: [0.0; BLOCK],
            });
        }
        let block = &mut self.charges[self.charge_count / BLOCK];
        (block.x[lane], block.y[lane], block.z[lane], block.strength[lane]) = (at[0], at[1], at[2], 1.0);
        self.charge_count += 1;
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
        let Self { blocks, weights, law, eta, .. } = self;
        vectorised(
            #[inline(always)]
            || match law {
                Law::Rational => {
                    for (block, total) in blocks.iter_mut().zip(weights.iter_mut()) {
                        weigh_rational(block, *eta);
                        *total = sum_of(&block.weight);
                    }
                }
                Law::Laplacian => {
                    let mut least = f32::MAX;
                    for block in blocks.iter() {
                        least = least.min(least_difference(block));
                    }
                    for (block, total) in blocks.iter_mut().zip(weights.iter_mut()) {
                        weigh_laplacian(block, least, *eta);
                        *total = sum_of(&block.weight);
                    }
                }
            },
        );
        // All candidates alike (as around a lone start): fast Laplacian growth is 0/0 there, and any is as good.
        if *law == Law::Laplacian && weights.iter().all(|&total| total == 0.0) {
            let count = self.candidates.len();
            for (number, (block, total)) in blocks.iter_mut().zip(weights).enumerate() {
                let filled = (count - number * BLOCK).min(BLOCK);
                block.weight[..filled].fill(1.0);
                *total = filled as f32;
            }
        }
    }

    fn draw(&self, u: f64) -> Option<usize> {
        draw(u, &self.weights, |number| &self.blocks[number].weight[..]).map(|(number, lane)| number * BLOCK + lane)
    }

    #[cfg(test)]
    fn weight(&self, slot: usize) -> f64 {
        f64::from(self.blocks[slot / BLOCK].weight[slot % BLOCK])
    }
}

impl Block {
    /// x, y, z, fixed, sum, weight of an empty lane: nothing in it overflows or has weight.
    const EMPTY: [f32; 6] = [NOWHERE, 0.0, 0.0, 0.0, 1.0, 0.0];

    fn empty() -> Self {
        let [x, y, z, fixed, sum, weight] = Self::EMPTY.map(|value| [value; BLOCK]);
        Self { x, y, z, fixed, sum, weight }
    }

    fn get(&self, lane: usize) -> [f32; 6] {
        [self.x[lane], self.y[lane], self.z[lane], self.fixed[lane], self.sum[lane], self.weight[lane]]
    }

    fn put(&mut self, lane: usize, [x, y, z, fixed, sum, weight]: [f32; 6]) {
        (self.x[lane], self.y[lane], self.z[lane]) = (x, y, z);
        (self.fixed[lane], self.sum[lane], self.weight[lane]) = (fixed, sum, weight);
    }
}

/// 1 / sqrt(x) for a positive normal x.
#[inline(always)]
fn inverse_root(x: f32) -> f32 {
    let mut y = f32::from_bits(0x5f37_5a86_u32.wrapping_sub(x.to_bits() >> 1));
    let half = 0.5 * x;
    for _ in 0..3 {
        y *= 1.5 - half * y * y;
    }
    y
}

/// 1 / x for x of 1e-37 to 1e37.
#[inline(always)]
fn reciprocal(x: f32) -> f32 {
    let mut y = f32::from_bits(0x7ef3_11c7_u32.wrapping_sub(x.to_bits()));
    for _ in 0..3 {
        y *= 2.0 - x * y;
    }
    y
}

/// distance^-RHO of a squared distance.
#[inline(always)]
fn pull<const RHO: u32>(squared: f32) -> f32 {
    let y = inverse_root(squared);
    match RHO {
        1 => y,
        2 => y * y,
        3 => y * y * y,
        _ => (y * y) * (y * y),
    }
}

#[inline(always)]
fn add_charge(block: &mut Block, at: [f32; 3], rho: u32) {
    match rho {
        1 => add_charge_of::<1>(block, at),
        2 => add_charge_of::<2>(block, at),
        3 => add_charge_of::<3>(block, at),
        _ => add_charge_of::<4>(block, at),
    }
}

#[inline(always)]
fn add_charge_of<const RHO: u32>(block: &mut Block, [x, y, z]: [f32; 3]) {
    for k in 0..BLOCK {
        let (dx, dy, dz) = (block.x[k] - x, block.y[k] - y, block.z[k] - z);
        block.sum[k] += pull::<RHO>(dx * dx + dy * dy + dz * dz);
    }
}

#[inline(always)]
fn sum_over(charges: &[ChargeBlock], at: [f32; 3], rho: u32) -> f32 {
    match rho {
        1 => sum_over_of::<1>(charges, at),
        2 => sum_over_of::<2>(charges, at),
        3 => sum_over_of::<3>(charges, at),
        _ => sum_over_of::<4>(charges, at),
    }
}

#[inline(always)]
fn sum_over_of<const RHO: u32>(charges: &[ChargeBlock], [x, y, z]: [f32; 3]) -> f32 {
    let mut lanes = [0.0; LANES];
    for block in charges {
        for part in 0..BLOCK / LANES {
            for (lane, sum) in lanes.iter_mut().enumerate() {
                let k = part * LANES + lane;
                let (dx, dy, dz) = (block.x[k] - x, block.y[k] - y, block.z[k] - z);
                *sum += block.strength[k] * pull::<RHO>(dx * dx + dy * dy + dz * dz);
            }
        }
    }
    fold(lanes)
}

#[inline(always)]
fn weigh_rational(block: &mut Block, eta: u32) {
    for k in 0..BLOCK {
        block.weight[k] = power(block.fixed[k] * reciprocal(block.sum[k]), eta);
    }
}

#[inline(always)]
fn least_difference(block: &Block) -> f32 {
    let mut lanes = [f32::MAX; LANES];
    for part in 0..BLOCK / LANES {
        for (lane, least) in lanes.iter_mut().enumerate() {
            let k = part * LANES + lane;
            // Empty lanes have a sum of 1 at a fixed number of 0, and stand so far that their distance tells them.
            let difference = block.fixed[k] - block.sum[k];
            let filled = block.x[k] < NOWHERE;
            let difference = if filled { difference } else { f32::MAX };
            *least = if difference < *least { difference } else { *least };
        }
    }
    lanes.into_iter().fold(f32::MAX, f32::min)
}

#[inline(always)]
fn weigh_laplacian(block: &mut Block, least: f32, eta: u32) {
    for k in 0..BLOCK {
        let weight = power(block.fixed[k] - block.sum[k] - least, eta);
        block.weight[k] = if block.x[k] < NOWHERE { weight } else { 0.0 };
    }
}

#[inline(always)]
fn power(x: f32, n: u32) -> f32 {
    match n {
        1 => x,
        2 => x * x,
        3 => x * x * x,
        _ => (x * x) * (x * x),
    }
}

/// Sum of a block in fixed lanes.
#[inline(always)]
fn sum_of(values: &Lanes) -> f32 {
    let mut lanes = [0.0; LANES];
    for part in 0..BLOCK / LANES {
        for (lane, sum) in lanes.iter_mut().enumerate() {
            *sum += values[part * LANES + lane];
        }
    }
    fold(lanes)
}

#[inline(always)]
fn fold(mut lanes: [f32; LANES]) -> f32 {
    let mut half = LANES / 2;
    while half > 0 {
        for lane in 0..half {
            lanes[lane] += lanes[lane + half];
        }
        half /= 2;
    }
    lanes[0]
}
