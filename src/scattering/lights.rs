//! Virtual point lights over the space of a simulation, and how a point's light is shared among them.
//!
//! Horizontally at even intervals; vertically evenly through the cloud and, below it, by Dobashi et al. 2007, eq. 4: as far apart as
//! the light that reaches the cloud allows. As printed eq. 4 begins at distance 0 and has no next distance once
//! `1/r^2 <= epsilon` (a root of a negative number); here it begins at one interval below the cloud and ends there.

use crate::numeric::sphere::Direction;

/// Positions of lights: every combination of the three lists, m from the lower south-west corner of the box.
#[derive(Clone, Debug, PartialEq)]
pub struct Lights {
    /// East, ascending.
    pub x_m: Vec<f64>,
    /// North, ascending.
    pub y_m: Vec<f64>,
    /// Up, ascending.
    pub z_m: Vec<f64>,
    /// Period east and north where the medium repeats; weights wrap.
    pub period_m: Option<[f64; 2]>,
}

/// The lights that stand for one point, with their shares.
#[derive(Clone, Debug, PartialEq)]
pub struct Shares {
    /// Light and share; the shares sum to 1.
    pub lights: Vec<(usize, f64)>,
    /// Whether the point lay outside the lights and was moved to their border.
    pub outside: bool,
}

/// What lights cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LightsError {
    /// Too few or too many.
    #[error("{0} lights: 1 to {MOST_LIGHTS} are possible")]
    Count(usize),
    /// A length that is none.
    #[error("{field} is {value}: it must be finite and positive")]
    Length {
        /// Which one.
        field: &'static str,
        /// What it was.
        value: f64,
    },
}

/// Most lights of a basis.
pub const MOST_LIGHTS: usize = 1 << 20;

impl Lights {
    /// `counts` lights spread evenly over a box (the paper: 20 x 20 x 7) and down to `below_m` under it. In a medium that
    /// repeats the first stands half an interval from the tile's edge.
    ///
    /// # Errors
    /// [`LightsError`].
    pub fn even(counts: [usize; 3], size_m: Direction, below_m: f64, periodic: bool) -> Result<Self, LightsError> {
        let total = counts.iter().try_fold(1_usize, |n, c| n.checked_mul(*c)).unwrap_or(usize::MAX);
        if total == 0 || total > MOST_LIGHTS {
            return Err(LightsError::Count(total));
        }
        let lengths = size_m.iter().map(|value| ("size_m", *value)).chain([("below_m", below_m + 1.0)]);
        for (field, value) in lengths {
            if !(value.is_finite() && value > 0.0) {
                return Err(LightsError::Length { field, value });
            }
        }
        let level = |k: usize| -> Vec<f64> {
            let n = counts[k];
            (0..n)
                .map(|i| {
                    let half = if periodic || n == 1 { 0.5 } else { 0.0 };
                    let whole = if periodic || n == 1 { n } else { n - 1 };
                    size_m[k] * (i as f64 + half) / whole as f64
                })
                .collect()
        };
        let height = size_m[2] + below_m;
        let nz = counts[2];
        let z_m = (0..nz)
            .map(|i| if nz == 1 { 0.5 * size_m[2] } else { height * i as f64 / (nz - 1) as f64 - below_m })
            .collect();
        Ok(Self { x_m: level(0), y_m: level(1), z_m, period_m: periodic.then_some([size_m[0], size_m[1]]) })
    }

    /// Lights at intervals of `interval_m` through a box and below it down to `below_m`, spaced there by eq. 4 with
    /// `epsilon_per_m2` (1/m^2): the most that 1/r^2 may fall from one level to the next.
    ///
    /// # Errors
    /// [`LightsError`].
    pub fn spaced(
        interval_m: f64,
        epsilon_per_m2: f64,
        size_m: Direction,
        below_m: f64,
        periodic: bool,
    ) -> Result<Self, LightsError> {
        for (field, value) in
            [("interval_m", interval_m), ("epsilon_per_m2", epsilon_per_m2), ("below_m", below_m + 1.0)]
        {
            if !(value.is_finite() && value > 0.0) {
                return Err(LightsError::Length { field, value });
            }
        }
        let count = |size: f64, one: usize| (size / interval_m).ceil().clamp(1.0, 1e6) as usize + one;
        let one = usize::from(!periodic);
        let levels = count(size_m[2], 1);
        let mut lights = Self::even([count(size_m[0], one), count(size_m[1], one), levels], size_m, 0.0, periodic)?;
        let mut z_m: Vec<f64> =
            distances_below(interval_m, epsilon_per_m2, below_m).into_iter().map(|r| -r).rev().collect();
        z_m.append(&mut lights.z_m);
        lights.z_m = z_m;
        if lights.len() > MOST_LIGHTS { Err(LightsError::Count(lights.len())) } else { Ok(lights) }
    }

    /// Number of lights.
    pub fn len(&self) -> usize {
        self.x_m.len() * self.y_m.len() * self.z_m.len()
    }

    /// Whether there is no light.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Position of a light. Lights of one column follow one another, upwards.
    pub fn position_m(&self, light: usize) -> Direction {
        let (nx, nz) = (self.x_m.len(), self.z_m.len());
        [self.x_m[light / nz % nx], self.y_m[light / (nz * nx)], self.z_m[light % nz]]
    }

    /// The up to eight lights around a position with trilinear shares (eq. 6).
    pub fn shares(&self, position_m: Direction) -> Shares {
        let period = |k: usize| self.period_m.map(|p| p[k]);
        let (x, left) = between(&self.x_m, position_m[0], period(0));
        let (y, front) = between(&self.y_m, position_m[1], period(1));
        let (z, below) = between(&self.z_m, position_m[2], None);
        let mut lights = Vec::with_capacity(8);
        for (j, v) in y {
            for (i, u) in x {
                for (k, w) in z {
                    if u * v * w > 0.0 {
                        lights.push((k + self.z_m.len() * (i + self.x_m.len() * j), u * v * w));
                    }
                }
            }
        }
        Shares { lights, outside: left || front || below }
    }
}

/// Distances below the cloud (eq. 4 made safe), up to the first at or beyond `below_m`.
fn distances_below(interval_m: f64, epsilon: f64, below_m: f64) -> Vec<f64> {
    let mut distances = Vec::new();
    let mut r = interval_m;
    while r < below_m && distances.len() < 1000 {
        distances.push(r);
        let left = 1.0 / (r * r) - epsilon;
        // From here on no distance differs by epsilon any more: one last level at the bottom serves.
        r = if left > 0.0 { (1.0 / left.sqrt()).max(r + interval_m) } else { f64::INFINITY };
    }
    if below_m > 0.0 {
        distances.push(below_m);
    }
    distances
}

/// The two neighbours of a value in an ascending list with their shares, and whether it lies outside.
fn between(list: &[f64], value: f64, period: Option<f64>) -> ([(usize, f64); 2], bool) {
    let last = list.len() - 1;
    let value = match period {
        Some(p) => list[0] + (value - list[0]).rem_euclid(p),
        None => value,
    };
    let above = list.partition_point(|x| *x <= value);
    if above == 0 {
        return ([(0, 1.0), (0, 0.0)], value < list[0]);
    }
    let low = above - 1;
    let (high, end) = match period {
        Some(p) if low == last => (0, list[0] + p),
        _ if low == last => return ([(last, 1.0), (last, 0.0)], value > list[last]),
        _ => (low + 1, list[low + 1]),
    };
    let share = ((value - list[low]) / (end - list[low])).clamp(0.0, 1.0);
    ([(low, 1.0 - share), (high, share)], false)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_grid_and_its_order() {
        let lights = Lights::even([20, 20, 7], [32.0, 32.0, 4.0], 8.0, false).expect("legal");
        assert_eq!(lights.len(), 2800);
        assert_eq!((lights.position_m(0), lights.position_m(2799)), ([0.0, 0.0, -8.0], [32.0, 32.0, 4.0]));
        assert_eq!(lights.position_m(7)[0], 32.0 / 19.0);
        assert!(Lights::even([0, 1, 1], [1.0; 3], 0.0, false).is_err());
        assert!(Lights::even([1 << 11; 3], [1.0; 3], 0.0, false).is_err());
        assert!(Lights::even([2; 3], [1.0, f64::NAN, 1.0], 0.0, false).is_err());
    }

    #[test]
    fn intervals_below_grow_and_never_fail() {
        for epsilon in [1e-9, 1e-6, 1e-3, 1e3] {
            let lights = Lights::spaced(100.0, epsilon, [1000.0, 1000.0, 300.0], 2000.0, false).expect("legal");
            let below: Vec<f64> = lights.z_m.iter().copied().filter(|z| *z < 0.0).rev().map(|z| -z).collect();
            assert!(lights.z_m.windows(2).all(|w| w[1] > w[0]) && *below.last().expect("some") == 2000.0);
            for w in below.windows(2).take(below.len().saturating_sub(2)) {
                let fall = 1.0 / (w[0] * w[0]) - 1.0 / (w[1] * w[1]);
                // Eq. 4 holds unless the least interval forbids it.
                assert!(fall <= epsilon * (1.0 + 1e-9) || (w[1] - w[0] - 100.0).abs() < 1e-9, "{epsilon} {w:?}");
            }
        }
        assert!(Lights::spaced(0.0, 1.0, [1.0; 3], 1.0, false).is_err());
    }

    #[test]
    fn shares_sum_to_one_and_reproduce_the_position() {
        let lights = Lights::spaced(3.0, 0.01, [17.0, 9.0, 5.0], 40.0, false).expect("legal");
        for i in 0..500 {
            let p = [i as f64 * 0.034, 9.0 - i as f64 * 0.017, -40.0 + i as f64 * 0.09];
            let shares = lights.shares(p);
            assert!(!shares.outside, "{p:?}");
            let mut mean = [0.0; 3];
            let mut sum = 0.0;
            for (light, share) in &shares.lights {
                sum += share;
                let at = lights.position_m(*light);
                (0..3).for_each(|k| mean[k] += share * at[k]);
            }
            // Energy of eq. 6: kept to 1e-6 and much better.
            assert!((sum - 1.0).abs() < 1e-12 && (0..3).all(|k| (mean[k] - p[k]).abs() < 1e-9));
        }
    }

    #[test]
    fn points_outside_keep_their_energy_and_are_told() {
        let lights = Lights::even([4, 4, 3], [8.0, 8.0, 4.0], 2.0, false).expect("legal");
        for p in [[-1.0, 4.0, 1.0], [4.0, 100.0, 1.0], [4.0, 4.0, -3.0], [9.0, 9.0, 9.0]] {
            let shares = lights.shares(p);
            assert!(shares.outside && (shares.lights.iter().map(|l| l.1).sum::<f64>() - 1.0).abs() < 1e-12);
        }
        let tile = Lights::even([4, 4, 3], [8.0, 8.0, 4.0], 2.0, true).expect("legal");
        let (a, b) = (tile.shares([7.9, 0.1, 1.0]), tile.shares([-0.1, 8.1, 1.0]));
        assert!(!a.outside && !b.outside);
        for (x, y) in a.lights.iter().zip(&b.lights) {
            assert!(x.0 == y.0 && (x.1 - y.1).abs() < 1e-12);
        }
        assert_eq!(Lights::even([1, 1, 1], [8.0; 3], 0.0, false).expect("legal").shares([4.0; 3]).lights, [(0, 1.0)]);
    }
}
