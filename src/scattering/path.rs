//! How light of one direction comes through a cell: where it comes from, what arrives, what it leaves.
//!
//! Linear characteristics, conservative: a direction crosses the planes of cells of its nearest axis one after the other.
//! Light that leaves the cells of a plane is moved sideways to the cells of the next (quadratic weights, which keep the width of a
//! beam on flat cells; on cubes the 26 directions of Lebedev meet cells exactly), and crosses each cell's whole depth
//! there, past a source that is a straight line in optical depth. What enters is what leaves and what collides, in any
//! mixture of thick and thin cells; uniform light stays uniform; and the second moment of scattered light is exact at
//! every depth of a cell (Fourier analysis of one line: flat sources would spread thick cells' light as if they were only two
//! deep), so that diffusion through cells of depth 20 has its length.

use crate::numeric::sphere::Direction;

/// A cell of the plane before, relative to the cell below the ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tap {
    /// Cells along the first axis of the plane.
    pub u: isize,
    /// Cells along the second axis of the plane.
    pub v: isize,
    /// Its weight; a path's weights sum to 1.
    pub weight: f32,
}

/// The way of a direction through the grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// Axis across the planes; the plane has the other two, in order.
    pub axis: usize,
    /// Whether the ray goes towards higher cells of that axis.
    pub forward: bool,
    /// Length from plane to plane, m.
    pub length_m: f64,
    /// Where light and source of the plane before come from: quadratic.
    pub taps: Vec<Tap>,
    /// Interpolation of extinction: linear, since it must not be negative.
    pub linear: Vec<Tap>,
}

/// What one cell does to light of one direction, with `slope` the difference of the source after and before it:
/// `out = in + lost (source - in) + tilt slope`, `mean = source + share (in - source) - lean slope`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Weights {
    /// `1 - exp(-depth)`.
    pub lost: f32,
    /// Weight of the entering light in the mean over the cell: `lost / depth`.
    pub share: f32,
    /// What the tilt of the source adds to the light that leaves.
    pub tilt: f32,
    /// What it takes from the mean: `tilt / depth`.
    pub lean: f32,
    /// What a source that rises by 1 over the cell adds to the light that leaves, where its rise is known.
    pub unit: f32,
}

/// Axes of the plane across an axis.
pub fn plane_axes(axis: usize) -> [usize; 2] {
    match axis {
        0 => [1, 2],
        1 => [0, 2],
        _ => [0, 1],
    }
}

impl Path {
    /// The way of a direction through cells of this shape.
    pub fn new(direction: Direction, spacing_m: [f64; 3]) -> Self {
        let time =
            |k: usize| if direction[k].abs() > 1e-12 { spacing_m[k] / direction[k].abs() } else { f64::INFINITY };
        // The nearest plane; the highest axis of several equally near ones (edges and corners of a cube).
        let mut axis = 2;
        for k in [1, 0] {
            if time(k) < time(axis) * (1.0 - 1e-12) {
                axis = k;
            }
        }
        let length_m = time(axis);
        let [u, v] = plane_axes(axis);
        let shift = |k: usize| -direction[k] * length_m / spacing_m[k];
        Self {
            axis,
            forward: direction[axis] > 0.0,
            length_m,
            taps: taps(quadratic(shift(u)), quadratic(shift(v))),
            linear: taps(linear(shift(u)), linear(shift(v))),
        }
    }
}

fn taps(u: [f64; 3], v: [f64; 3]) -> Vec<Tap> {
    let mut all = Vec::new();
    for (j, b) in v.iter().enumerate() {
        for (i, a) in u.iter().enumerate() {
            if (a * b).abs() > 1e-12 {
                all.push(Tap { u: i as isize - 1, v: j as isize - 1, weight: (a * b) as f32 });
            }
        }
    }
    all
}

/// Weights of the cells at -1, 0 and 1 for a value at `p` within -1 to 1.
fn quadratic(p: f64) -> [f64; 3] {
    [0.5 * p * (p - 1.0), 1.0 - p * p, 0.5 * p * (p + 1.0)]
}

fn linear(p: f64) -> [f64; 3] {
    [(-p).max(0.0), 1.0 - p.abs(), p.max(0.0)]
}

/// Weights of a cell of this depth between cells of the depths `before` and `after` (0 outside the box). The source's tilt
/// over the cell is its share, by depth, of the difference between the neighbours' middles: what light that diffuses
/// through layers of different depth has.
pub fn weights(before: f64, own: f64, after: f64) -> Weights {
    let lost = -(-own).exp_m1();
    if own < 1e-4 {
        // Series: own / 2 and own^2 / 12 to leading order; the rest is below f32.
        let (share, unit) = ((1.0 - 0.5 * own) as f32, (own * own / 12.0) as f32);
        return Weights { lost: lost as f32, share, tilt: 0.0, lean: 0.0, unit };
    }
    let share = lost / own;
    // Of a source that rises by 1 over the cell around 0: what leaves. Differences of nearly equal numbers when thin.
    let unit = if own < 0.05 { own * own / 12.0 * (1.0 - 0.5 * own) } else { 1.0 - share - 0.5 * lost };
    let tilt = unit * own / (0.5 * before + own + 0.5 * after);
    Weights { lost: lost as f32, share: share as f32, tilt: tilt as f32, lean: (tilt / own) as f32, unit: unit as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::sphere::Rule;

    #[test]
    fn on_cubes_the_26_directions_meet_centres() {
        for d in Rule::Lebedev26.set().directions {
            let path = Path::new(d, [2.0; 3]);
            assert_eq!(path.taps.len(), 1, "{d:?}");
            let expected = 2.0 * (d.iter().filter(|c| c.abs() > 1e-9).count() as f64).sqrt();
            assert!((path.length_m - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn interpolation_keeps_three_moments_for_every_shape_of_cell() {
        for flat in [1.0, 0.5, 0.25, 0.125] {
            let spacing = [1.0, 1.0, flat];
            for d in Rule::ALL.into_iter().flat_map(|r| r.set().directions) {
                let path = Path::new(d, spacing);
                let axes = plane_axes(path.axis);
                let sum = |f: &dyn Fn(f64, f64) -> f64, taps: &[Tap]| -> f64 {
                    taps.iter().map(|t| f64::from(t.weight) * f(t.u as f64, t.v as f64)).sum()
                };
                let shift = axes.map(|k| -d[k] * path.length_m / spacing[k]);
                assert!(shift.iter().all(|s| s.abs() < 1.0 + 1e-9));
                assert!((sum(&|_, _| 1.0, &path.taps) - 1.0).abs() < 1e-6);
                assert!((sum(&|u, _| u, &path.taps) - shift[0]).abs() < 1e-6);
                assert!((sum(&|_, v| v, &path.taps) - shift[1]).abs() < 1e-6);
                // The second moment is what keeps a beam from widening on flat cells.
                assert!((sum(&|u, _| u * u, &path.taps) - shift[0] * shift[0]).abs() < 1e-6);
                assert!((sum(&|u, v| u * v, &path.taps) - shift[0] * shift[1]).abs() < 1e-6);
                assert!(path.linear.iter().all(|t| t.weight > 0.0));
                assert!((sum(&|u, _| u, &path.linear) - shift[0]).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn a_cell_keeps_its_balance_and_has_both_limits() {
        let depths = [0.0, 1e-9, 1e-3, 0.04, 0.06, 0.5, 1.0, 4.0, 20.0, 1e4];
        for before in depths {
            for own in depths {
                for after in depths {
                    let w = weights(before, own, after);
                    assert!([w.lost, w.share, w.tilt, w.lean].iter().all(|x| (0.0..=1.0).contains(x)), "{own} {w:?}");
                    // depth (mean - source) = in - out, in units of in - source and of the slope.
                    assert!((own * f64::from(w.share) - f64::from(w.lost)).abs() < 1e-4 * own + 1e-7, "{own}");
                    assert!((own * f64::from(w.lean) - f64::from(w.tilt)).abs() < 1e-6 * own.max(1.0), "{own}");
                }
            }
        }
        // The series meets the closed form.
        let (below, above) = (weights(0.05, 0.049_999, 0.05), weights(0.05, 0.050_001, 0.05));
        assert!((below.tilt / above.tilt - 1.0).abs() < 1e-3);
    }

    #[test]
    fn scattered_light_spreads_by_its_free_path_at_every_depth_of_cell() {
        // A source cos(k x) on an even line gives a mean light of cos(k x) / (1 + (k h / depth)^2) where k h is small: the
        // second moment of an exponential flight. Found here: both directions of the line by the recurrence itself.
        for depth in [0.1, 0.5, 1.0, 2.0, 4.0, 10.0, 30.0] {
            let w = weights(depth, depth, depth);
            let [lost, share, tilt, lean] = [w.lost, w.share, w.tilt, w.lean].map(f64::from);
            let wave = 0.02 * depth.min(1.0);
            let n = 4000;
            let source = |i: usize| (wave * (i as f64 - 2000.0)).cos();
            let mean_at_middle = |forward: bool| {
                let mut light = 0.0;
                let mut mean = 0.0;
                for step in 1..=2000 {
                    let i = if forward { step } else { n - step };
                    let (s, slope) = (
                        source(i),
                        if forward { source(i + 1) - source(i - 1) } else { source(i - 1) - source(i + 1) },
                    );
                    mean = s + share * (light - s) - lean * slope;
                    light += lost * (s - light) + tilt * slope;
                }
                mean
            };
            let response = 0.5 * (mean_at_middle(true) + mean_at_middle(false));
            let spread = (1.0 / response - 1.0) / (wave / depth).powi(2);
            // Fourth order of the wave, and f32 weights against a spread that is small when thick.
            assert!((spread - 1.0).abs() < 0.01 + 1e-6 * depth * depth / (wave * wave), "{depth}: {spread}");
        }
    }
}
