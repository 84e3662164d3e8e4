//! Directions of a solve with the harmonics on them: from moments to directions and back, by pairs of opposites.

use super::lanes::Lanes;
use crate::numeric::sphere::{DirectionSet, Rule, harmonics, harmonics_count, order_of};

/// Most moments of a rule.
pub const MOST_MOMENTS: usize = 81;

/// A quadrature rule with spherical harmonics up to its order.
#[derive(Clone, Debug)]
pub struct Angles {
    /// The rule.
    pub set: DirectionSet,
    /// Moments: `(order + 1)^2`.
    pub moments: usize,
    /// One direction of each pair of opposites, and its opposite.
    pub pairs: Vec<[usize; 2]>,
    /// Order `l` of each moment.
    pub orders: Vec<usize>,
    /// Moments of even order first, then those of odd order: the order in which `spread` takes them.
    pub by_parity: Vec<usize>,
    /// How many are even.
    even: usize,
    /// Harmonics of a pair's first direction, by parity: pairs times moments.
    values: Vec<f32>,
    /// The same times the direction's solid angle, moment by moment: moments times pairs.
    weighted: Vec<f32>,
}

impl Angles {
    /// The angles of a rule.
    pub fn new(rule: Rule) -> Self {
        let set = rule.set();
        let moments = harmonics_count(rule.order());
        let pairs: Vec<[usize; 2]> =
            (0..set.len()).filter(|m| set.opposite[*m] > *m).map(|m| [m, set.opposite[m]]).collect();
        let orders: Vec<usize> = (0..moments).map(order_of).collect();
        let mut by_parity: Vec<usize> = (0..moments).collect();
        by_parity.sort_by_key(|k| orders[*k] & 1);
        let values: Vec<Vec<f64>> = pairs.iter().map(|p| harmonics(set.directions[p[0]], rule.order())).collect();
        Self {
            moments,
            even: orders.iter().filter(|l| *l & 1 == 0).count(),
            values: values.iter().flat_map(|y| by_parity.iter().map(|k| y[*k] as f32)).collect(),
            weighted: (0..moments)
                .flat_map(|k| values.iter().zip(&pairs).map(move |(y, p)| (k, y, p)))
                .map(|(k, y, p)| (y[k] * set.weights[p[0]]) as f32)
                .collect(),
            orders,
            by_parity,
            pairs,
            set,
        }
    }

    /// Harmonics of a direction of the set.
    pub fn harmonics(&self, m: usize) -> Vec<f32> {
        let order = self.orders.last().copied().unwrap_or(0);
        harmonics(self.set.directions[m], order).into_iter().map(|y| y as f32).collect()
    }

    /// The function with these moments (by parity), on all directions: `out[m * stride]`.
    #[inline(always)]
    pub fn spread(&self, moments: &[Lanes], out: &mut [Lanes], stride: usize) {
        let (even, odd) = moments[..self.moments].split_at(self.even);
        for (y, [there, back]) in self.values.chunks_exact(self.moments).zip(&self.pairs) {
            let (y_even, y_odd) = y.split_at(self.even);
            let mut sums = [Lanes::ZERO; 2];
            for (y, moment) in y_even.iter().zip(even) {
                sums[0] = sums[0].plus(*y, moment);
            }
            for (y, moment) in y_odd.iter().zip(odd) {
                sums[1] = sums[1].plus(*y, moment);
            }
            out[there * stride] = sums[0].plus(1.0, &sums[1]);
            out[back * stride] = sums[0].plus(-1.0, &sums[1]);
        }
    }

    /// Moments of a function on all directions, `values[m * stride]`; `halves` is room for one entry a pair.
    #[inline(always)]
    pub fn gather(&self, values: &[Lanes], stride: usize, halves: &mut [[Lanes; 2]], out: &mut [Lanes]) {
        // Sums and differences of the pairs: even and odd orders need one of them each.
        for (half, [there, back]) in halves.iter_mut().zip(&self.pairs) {
            let (a, b) = (&values[there * stride], &values[back * stride]);
            *half = [a.plus(1.0, b), a.plus(-1.0, b)];
        }
        for ((weights, order), out) in self.weighted.chunks_exact(self.pairs.len()).zip(&self.orders).zip(out) {
            let mut sum = Lanes::ZERO;
            for (weight, half) in weights.iter().zip(halves.iter()) {
                sum = sum.plus(*weight, &half[order & 1]);
            }
            *out = sum;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_come_back_from_directions() {
        for rule in Rule::ALL {
            let angles = Angles::new(rule);
            assert!(angles.moments <= MOST_MOMENTS && angles.pairs.len() * 2 == rule.count());
            let given: Vec<Lanes> = (0..angles.moments).map(|k| Lanes::splat(1.0 / (k + 1) as f32)).collect();
            let mut spread = vec![Lanes::ZERO; rule.count()];
            let sorted: Vec<Lanes> = angles.by_parity.iter().map(|k| given[*k]).collect();
            angles.spread(&sorted, &mut spread, 1);
            let mut back = vec![Lanes::ZERO; angles.moments];
            angles.gather(&spread, 1, &mut vec![[Lanes::ZERO; 2]; rule.count() / 2], &mut back);
            for (a, b) in given.iter().zip(&back) {
                // The rule integrates products of these harmonics exactly: rounding of f32 in 110 terms is left.
                assert!((a.0[3] - b.0[3]).abs() < 2e-6, "{rule:?} {} {}", a.0[3], b.0[3]);
            }
            let direct: f64 = harmonics(angles.set.directions[5], rule.order())
                .iter()
                .enumerate()
                .map(|(k, y)| y / (k + 1) as f64)
                .sum();
            assert!((f64::from(spread[5].0[0]) - direct).abs() < 1e-5);
        }
    }
}
