//! Directions on the unit sphere: Lebedev quadrature sets and real spherical harmonics.

use std::f64::consts::PI;

/// A unit vector: east, north, up.
pub type Direction = [f64; 3];

/// A quadrature rule on the sphere that is symmetric under the octahedral group, so that every direction has its opposite.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectionSet {
    /// Unit vectors.
    pub directions: Vec<Direction>,
    /// Solid angle that each direction stands for, sr; they sum to 4 pi.
    pub weights: Vec<f64>,
    /// Index of the direction that points the other way.
    pub opposite: Vec<usize>,
    /// Polynomials up to this degree are integrated exactly.
    pub degree: usize,
}

/// The rules that are there, by their number of directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Rule {
    /// 26 directions, degree 7: axes, edges and corners of a cube (the count of Dobashi et al. 2007, section 8).
    Lebedev26,
    /// 50 directions, degree 11.
    Lebedev50,
    /// 110 directions, degree 17.
    Lebedev110,
}

impl Rule {
    /// All rules, coarse to fine.
    pub const ALL: [Self; 3] = [Self::Lebedev26, Self::Lebedev50, Self::Lebedev110];

    /// Number of directions.
    pub fn count(self) -> usize {
        match self {
            Self::Lebedev26 => 26,
            Self::Lebedev50 => 50,
            Self::Lebedev110 => 110,
        }
    }

    /// Highest order of spherical harmonics whose products the rule integrates exactly.
    pub fn order(self) -> usize {
        match self {
            Self::Lebedev26 => 3,
            Self::Lebedev50 => 5,
            Self::Lebedev110 => 8,
        }
    }

    /// The rule itself. Nodes and weights: Lebedev 1976, "Quadratures on a sphere", and Lebedev and Laikov 1999.
    pub fn set(self) -> DirectionSet {
        let mut set = Builder::default();
        let half = 0.5_f64.sqrt();
        let third = (1.0_f64 / 3.0).sqrt();
        match self {
            Self::Lebedev26 => {
                set.orbit([1.0, 0.0, 0.0], 1.0 / 21.0);
                set.orbit([half, half, 0.0], 4.0 / 105.0);
                set.orbit([third, third, third], 9.0 / 280.0);
                set.finish(7)
            }
            Self::Lebedev50 => {
                set.orbit([1.0, 0.0, 0.0], 4.0 / 315.0);
                set.orbit([half, half, 0.0], 64.0 / 2835.0);
                set.orbit([third, third, third], 27.0 / 1280.0);
                let a = (1.0_f64 / 11.0).sqrt();
                set.orbit([a, a, (1.0 - 2.0 * a * a).sqrt()], 14_641.0 / 725_760.0);
                set.finish(11)
            }
            Self::Lebedev110 => {
                set.orbit([1.0, 0.0, 0.0], 0.003_828_270_494_937_162);
                set.orbit([third, third, third], 0.009_793_737_512_487_512);
                for (a, weight) in [
                    (0.185_115_635_344_736_2, 0.008_211_737_283_191_111),
                    (0.690_421_048_382_292_2, 0.009_942_814_891_178_103),
                    (0.395_689_473_055_941_9, 0.009_595_471_336_070_963),
                ] {
                    let a: f64 = a;
                    set.orbit([a, a, (1.0 - 2.0 * a * a).sqrt()], weight);
                }
                let a: f64 = 0.478_369_028_812_150_2;
                set.orbit([a, (1.0 - a * a).sqrt(), 0.0], 0.009_694_996_361_663_028);
                set.finish(17)
            }
        }
    }
}

#[derive(Default)]
struct Builder {
    directions: Vec<Direction>,
    weights: Vec<f64>,
}

impl Builder {
    /// Every distinct permutation and change of sign of a point, each with this share of the sphere.
    fn orbit(&mut self, [a, b, c]: Direction, share: f64) {
        let mut orbit: Vec<Direction> = Vec::new();
        for p in [[a, b, c], [b, a, c], [a, c, b], [c, a, b], [b, c, a], [c, b, a]] {
            for signs in 0..8 {
                let flip = |value: f64, bit: usize| if value != 0.0 && signs >> bit & 1 == 1 { -value } else { value };
                let d = [flip(p[0], 0), flip(p[1], 1), flip(p[2], 2)];
                if !orbit.contains(&d) {
                    orbit.push(d);
                }
            }
        }
        self.weights.extend(orbit.iter().map(|_| 4.0 * PI * share));
        self.directions.extend(orbit);
    }

    fn finish(self, degree: usize) -> DirectionSet {
        let opposite = self
            .directions
            .iter()
            .enumerate()
            .map(|(i, d)| {
                let back = [-d[0], -d[1], -d[2]];
                self.directions.iter().position(|e| distance_squared(*e, back) < 1e-24).unwrap_or(i)
            })
            .collect();
        DirectionSet { directions: self.directions, weights: self.weights, opposite, degree }
    }
}

impl DirectionSet {
    /// Number of directions.
    pub fn len(&self) -> usize {
        self.directions.len()
    }

    /// Whether there is no direction at all.
    pub fn is_empty(&self) -> bool {
        self.directions.is_empty()
    }

    /// Index of the direction nearest to a vector of any length; the first of several at the same distance.
    pub fn nearest(&self, to: Direction) -> usize {
        let mut best = 0;
        for (i, d) in self.directions.iter().enumerate() {
            if dot(*d, to) > dot(self.directions[best], to) + 1e-12 {
                best = i;
            }
        }
        best
    }
}

/// Scalar product.
pub fn dot(a: Direction, b: Direction) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn distance_squared(a: Direction, b: Direction) -> f64 {
    let d = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    dot(d, d)
}

/// Evenly spread directions: a spherical Fibonacci lattice (Keinert et al. 2015), each standing for 4 pi / count.
pub fn fibonacci(count: usize) -> Vec<Direction> {
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    (0..count)
        .map(|i| {
            let z = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
            let r = (1.0 - z * z).sqrt();
            let (sin, cos) = (golden * i as f64).sin_cos();
            [r * cos, r * sin, z]
        })
        .collect()
}

/// Number of real spherical harmonics up to an order: `(order + 1)^2`.
pub fn harmonics_count(order: usize) -> usize {
    (order + 1) * (order + 1)
}

/// Order `l` of the harmonic at a place of the list that [`harmonics`] fills.
pub fn order_of(index: usize) -> usize {
    (0..).find(|l| harmonics_count(*l) > index).unwrap_or(0)
}

/// Real orthonormal spherical harmonics of a unit vector up to `order`, at `l * (l + 1) + m`: the sum over `m` of
/// `Y_lm(a) Y_lm(b)` is `(2 l + 1) / (4 pi) P_l(a . b)`.
pub fn harmonics(direction: Direction, order: usize) -> Vec<f64> {
    let mut out = vec![0.0; harmonics_count(order)];
    harmonics_into(direction, order, &mut out);
    out
}

/// [`harmonics`] into the first `(order + 1)^2` places of a list that is there.
pub fn harmonics_into([x, y, z]: Direction, order: usize, out: &mut [f64]) {
    // Re and Im of (x + i y)^m, and the Legendre functions divided by sin^m, normalised on the way (no overflow).
    let (mut re, mut im) = (1.0, 0.0);
    let mut diagonal = (1.0 / (4.0 * PI)).sqrt();
    for m in 0..=order {
        if m > 0 {
            (re, im) = (re * x - im * y, re * y + im * x);
            diagonal *= ((2 * m + 1) as f64 / (2 * m) as f64).sqrt();
        }
        let (mut before, mut here) = (0.0, diagonal);
        for l in m..=order {
            if l > m {
                let (lf, mf) = (l as f64, m as f64);
                let a = ((4.0 * lf * lf - 1.0) / (lf * lf - mf * mf)).sqrt();
                let k = lf - 1.0;
                let b = ((k * k - mf * mf) / (4.0 * k * k - 1.0)).max(0.0).sqrt();
                (before, here) = (here, a * (z * here - b * before));
            }
            let scale = if m == 0 { 1.0 } else { 2.0_f64.sqrt() };
            out[l * (l + 1) + m] = scale * here * re;
            if m > 0 {
                out[l * (l + 1) - m] = scale * here * im;
            }
        }
    }
}

/// Legendre polynomials `P_0 .. P_order` at `x`.
pub fn legendre(x: f64, order: usize) -> Vec<f64> {
    let mut p = vec![1.0; order + 1];
    if order > 0 {
        p[1] = x;
    }
    for l in 2..=order {
        p[l] = ((2 * l - 1) as f64 * x * p[l - 1] - (l - 1) as f64 * p[l - 2]) / l as f64;
    }
    p
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integral of x^a y^b z^c over the sphere (Folland 2001): 0 for an odd power.
    fn moment(powers: [u32; 3]) -> f64 {
        if powers.iter().any(|p| p % 2 == 1) {
            return 0.0;
        }
        // 4 pi times the product of double factorials (p-1)!! over (a+b+c+1)!!.
        let double = |n: u32| (1..=n).rev().step_by(2).map(f64::from).product::<f64>();
        let top: f64 = powers.iter().map(|p| double(p.saturating_sub(1))).product();
        4.0 * PI * top / double(powers.iter().sum::<u32>() + 1)
    }

    #[test]
    fn rules_integrate_polynomials_up_to_their_degree_and_no_further() {
        for rule in Rule::ALL {
            let set = rule.set();
            assert_eq!(set.len(), rule.count());
            let error = |degree: u32| {
                let mut worst = 0.0_f64;
                for a in 0..=degree {
                    for b in 0..=degree - a {
                        let c = degree - a - b;
                        let sum: f64 = set
                            .directions
                            .iter()
                            .zip(&set.weights)
                            .map(|(d, w)| w * d[0].powi(a as i32) * d[1].powi(b as i32) * d[2].powi(c as i32))
                            .sum();
                        worst = worst.max((sum - moment([a, b, c])).abs());
                    }
                }
                worst
            };
            for degree in 0..=set.degree as u32 {
                // The tables have 16 digits, the sums 110 terms.
                assert!(error(degree) < 2e-13, "{rule:?} degree {degree}: {}", error(degree));
            }
            // Monomials of degree 18 have integrals down to 1e-4, of which a rule that is not made for them misses shares.
            assert!(error(set.degree as u32 + 1) > 1e-8, "{rule:?} is finer than it says");
        }
    }

    #[test]
    fn every_direction_has_its_opposite() {
        for rule in Rule::ALL {
            let set = rule.set();
            for (i, d) in set.directions.iter().enumerate() {
                let back = set.directions[set.opposite[i]];
                assert!((0..3).all(|k| (d[k] + back[k]).abs() < 1e-15));
                assert_eq!(set.nearest(*d), i);
            }
        }
    }

    #[test]
    fn harmonics_are_orthonormal_and_obey_the_addition_theorem() {
        let set = Rule::Lebedev110.set();
        let all: Vec<Vec<f64>> = set.directions.iter().map(|d| harmonics(*d, 8)).collect();
        for i in 0..81 {
            for j in 0..81 {
                let product: f64 = all.iter().zip(&set.weights).map(|(y, w)| w * y[i] * y[j]).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-12, "{i} {j}: {product}");
            }
        }
        let (a, b) = ([0.6, 0.0, 0.8], [-0.48, 0.64, 0.6]);
        let (ya, yb, p) = (harmonics(a, 8), harmonics(b, 8), legendre(dot(a, b), 8));
        for (l, p) in p.into_iter().enumerate() {
            let sum: f64 = (l * l..(l + 1) * (l + 1)).map(|k| ya[k] * yb[k]).sum();
            assert!((sum - (2 * l + 1) as f64 / (4.0 * PI) * p).abs() < 1e-13);
        }
        assert_eq!([order_of(0), order_of(3), order_of(4), order_of(15)], [0, 1, 2, 3]);
    }

    #[test]
    fn fibonacci_directions_are_even() {
        let directions = fibonacci(1000);
        let set = Rule::Lebedev26.set();
        // Every octant holds an eighth: the lattice's discrepancy is a few points of 1000.
        let octant = directions.iter().filter(|d| d.iter().all(|c| *c > 0.0)).count();
        assert!((octant as i32 - 125).abs() < 5, "{octant}");
        let mean_z2 = directions.iter().map(|d| d[2] * d[2]).sum::<f64>() / 1000.0;
        // A midpoint rule of 1000 points: error of order 1e-6.
        assert!((mean_z2 - 1.0 / 3.0).abs() < 1e-6);
        assert!(set.nearest(directions[0]) == set.nearest([0.0, 0.0, 2.0]));
    }
}
