//! One pass of light through the grid for sixteen sources: from what cells scatter to the light in them.

mod lone;
mod sweep;

pub use lone::Lone;
use lone::Shares;

use super::angles::{Angles, MOST_MOMENTS};
use super::direct::{Direct, NO_TILT};
use super::lanes::{Lanes, dispatch};
use super::medium::Medium;
use super::path::{Path, Weights, plane_axes, weights};
use super::surface::Surface;
use std::sync::{Arc, OnceLock};
use sweep::{light_ground, sweep};

/// Transport through one medium: everything that does not depend on the source.
pub struct Operator {
    /// Directions and moments.
    pub angles: Arc<Angles>,
    /// Cells east, north, up.
    pub cells: [usize; 3],
    /// Light of every direction that falls in through the open faces (0; 1 in a white furnace).
    pub incoming: f32,
    /// The ground below, if any.
    pub ground: Option<Surface>,
    /// Share of each moment that a collision scatters: albedo times the moment of the phase function.
    scattering: Vec<f32>,
    spacing_m: [f64; 3],
    paths: Vec<Path>,
    /// One per direction and cell.
    weights: Vec<Weights>,
    /// Optical depth from the centre of each cell of the lowest plane to the lower face, vertically.
    lowest: Vec<f32>,
    /// Directions in the order of the sweep: down, level, up, so that the ground is lit before it lights.
    order: Vec<usize>,
    /// For sources alone, made when first asked for.
    shares: OnceLock<Option<Shares>>,
}

/// What comes with direct light: light on the ground, and the rise of the scattered light over cells around sources.
pub struct First {
    /// Direct light on the ground, W/m^2 a column.
    lit: Vec<Lanes>,
    /// Row of each cell in `known` and `rises`, or [`NO_TILT`].
    slot: Vec<u32>,
    /// 1 in the lanes whose rise is known.
    known: Vec<Lanes>,
    /// Rise along each direction: rows times directions.
    rises: Vec<Lanes>,
}

/// Light of sixteen sources on the way: source and radiance on every direction and cell.
pub struct Work {
    /// What cells scatter into each direction per unit of extinction: directions times cells.
    pub source: Vec<Lanes>,
    /// Mean radiance of the cells: directions times cells.
    pub radiance: Vec<Lanes>,
    /// Light that the ground sends up, one a column.
    pub ground: Vec<Lanes>,
}

impl Work {
    /// Room for an operator.
    pub fn new(operator: &Operator) -> Self {
        let [nx, ny, nz] = operator.cells;
        let count = nx * ny * nz * operator.angles.set.len();
        Self {
            source: vec![Lanes::ZERO; count],
            radiance: vec![Lanes::ZERO; count],
            ground: vec![Lanes::ZERO; nx * ny],
        }
    }
}

impl Operator {
    /// Prepares a medium whose extinction is scaled already; `scattering[l]` is albedo times the l-th moment.
    pub fn new(medium: &Medium, angles: &Arc<Angles>, scattering: &[f64], ground: Option<Surface>) -> Self {
        let paths: Vec<Path> = angles.set.directions.iter().map(|d| Path::new(*d, medium.spacing_m)).collect();
        let mut order: Vec<usize> = (0..paths.len()).collect();
        let rise = |m: &usize| angles.set.directions[*m][2];
        order.sort_by(|a, b| rise(a).total_cmp(&rise(b)));
        let area = medium.cells[0] * medium.cells[1];
        let half = 0.5 * medium.spacing_m[2] as f32;
        Self {
            angles: angles.clone(),
            cells: medium.cells,
            spacing_m: medium.spacing_m,
            incoming: 0.0,
            ground,
            scattering: angles.orders.iter().map(|l| scattering[*l] as f32).collect(),
            weights: paths.iter().flat_map(|path| path_weights(medium, path)).collect(),
            lowest: medium.extinction_per_m[..area].iter().map(|s| s * half).collect(),
            paths,
            order,
            shares: OnceLock::new(),
        }
    }

    /// Memory that it takes, bytes, but for what solvers share.
    pub fn memory_bytes(&self) -> usize {
        let alone = self.shares.get().and_then(Option::as_ref).map_or(0, Shares::memory_bytes);
        size_of_val(self.weights.as_slice()) + size_of_val(self.lowest.as_slice()) + alone
    }

    /// What sources alone need; `None` where they cannot be swept alone.
    fn shares(&self) -> Option<&Shares> {
        self.shares.get_or_init(|| Shares::new(self)).as_ref()
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.cells.iter().product()
    }

    /// Moments of the light that arrives when cells scatter light of the given moments (`cells * moments`, cell by cell);
    /// leaves source and radiance in `work`. `first` comes with direct light.
    pub fn apply(&self, given: &[Lanes], first: Option<&First>, work: &mut Work, out: &mut [Lanes]) {
        apply(self, given, first, work, out);
    }

    /// What direct light brings beside its moments.
    pub fn first(&self, directs: &[Direct]) -> First {
        let (cells, moments) = (self.len(), self.angles.moments);
        let mut first = First {
            lit: vec![Lanes::ZERO; self.cells[0] * self.cells[1]],
            slot: vec![NO_TILT; cells],
            known: Vec::new(),
            rises: Vec::new(),
        };
        for (lane, direct) in directs.iter().enumerate() {
            for (out, lit) in first.lit.iter_mut().zip(&direct.ground) {
                out.0[lane] = *lit;
            }
            for (cell, from) in direct.slot.iter().enumerate().filter(|(_, slot)| **slot != NO_TILT) {
                let rows = &direct.tilts[*from as usize * 3 * moments..][..3 * moments];
                if first.slot[cell] == NO_TILT {
                    first.slot[cell] = first.known.len() as u32;
                    first.known.push(Lanes::ZERO);
                    first.rises.resize(first.rises.len() + self.paths.len(), Lanes::ZERO);
                }
                let slot = first.slot[cell] as usize;
                first.known[slot].0[lane] = 1.0;
                for (m, d) in self.angles.set.directions.iter().enumerate() {
                    first.rises[slot * self.paths.len() + m].0[lane] = self.rise(m, *d, rows);
                }
            }
        }
        first
    }

    /// How much the scattered direct light rises over a cell along a direction: the straight line with the given first
    /// moments (a unit edge has a second moment of 1/12).
    fn rise(&self, m: usize, d: [f64; 3], rows: &[f32]) -> f32 {
        let y = self.angles.harmonics(m);
        let mut sum = 0.0;
        for (k, row) in rows.chunks(self.angles.moments).enumerate() {
            let edges = (d[k] * self.paths[m].length_m / self.spacing_m[k]) as f32;
            let along: f32 =
                row.iter().zip(&y).zip(&self.scattering).map(|((moment, y), share)| moment * y * share).sum();
            sum += 12.0 * edges * along;
        }
        sum
    }

    /// Depth from a centre of the lowest plane down to the lower face along a direction.
    fn exit_depth(&self, column: usize, rise: f64) -> f32 {
        self.lowest[column] / rise.abs() as f32
    }
}

dispatch! {
    /// [`Operator::apply`] by instruction set.
    fn apply(operator: &Operator, given: &[Lanes], first: Option<&First>, work: &mut Work, out: &mut [Lanes]) => apply_body
}

#[inline(always)]
fn apply_body(operator: &Operator, given: &[Lanes], first: Option<&First>, work: &mut Work, out: &mut [Lanes]) {
    let cells = operator.len();
    let moments = operator.angles.moments;
    let mut scattered = [Lanes::ZERO; MOST_MOMENTS];
    for cell in 0..cells {
        let light = &given[cell * moments..][..moments];
        for (s, k) in scattered.iter_mut().zip(&operator.angles.by_parity) {
            *s = light[*k].scaled(operator.scattering[*k]);
        }
        operator.angles.spread(&scattered[..moments], &mut work.source[cell..], cells);
    }
    let mut ground_lit = false;
    for m in operator.order.iter().copied() {
        if operator.angles.set.directions[m][2] > 1e-12 && !ground_lit {
            ground_lit = true;
            light_ground(operator, first, work);
        }
        sweep(operator, m, first, work);
    }
    let mut halves = vec![[Lanes::ZERO; 2]; operator.angles.pairs.len()];
    for cell in 0..cells {
        operator.angles.gather(&work.radiance[cell..], cells, &mut halves, &mut out[cell * moments..][..moments]);
    }
}

/// Weights of every cell for one direction, cell by cell.
fn path_weights(medium: &Medium, path: &Path) -> Vec<Weights> {
    let n = medium.cells;
    let stride = [1, n[0], n[0] * n[1]];
    let [u_axis, v_axis] = plane_axes(path.axis);
    let mut all = vec![Weights::default(); medium.len()];
    for (cell, out) in all.iter_mut().enumerate() {
        let at = [cell % n[0], cell / n[0] % n[1], cell / (n[0] * n[1])];
        let own = path.length_m * f64::from(medium.extinction_per_m[cell]);
        // Extinction where the ray meets the plane `step` planes on; nothing outside the box.
        let beside = |back: bool| -> Option<f64> {
            let towards_lower = path.forward == back;
            let plane = if towards_lower { at[path.axis].checked_sub(1)? } else { at[path.axis] + 1 };
            if plane >= n[path.axis] {
                return None;
            }
            let sign = if back { 1 } else { -1 };
            let mut sum = 0.0;
            for tap in &path.linear {
                let u = at[u_axis].checked_add_signed(sign * tap.u).filter(|u| *u < n[u_axis]);
                let v = at[v_axis].checked_add_signed(sign * tap.v).filter(|v| *v < n[v_axis]);
                if let (Some(u), Some(v)) = (u, v) {
                    let index = plane * stride[path.axis] + u * stride[u_axis] + v * stride[v_axis];
                    sum += f64::from(tap.weight) * f64::from(medium.extinction_per_m[index]);
                }
            }
            Some(path.length_m * sum)
        };
        *out = weights(beside(true).unwrap_or(0.0), own, beside(false).unwrap_or(0.0));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::sphere::Rule;

    /// Light of a uniform beam through an absorbing box: Beer's law for every direction set and shape of cell.
    #[test]
    fn without_scattering_light_from_outside_decays_by_beer() {
        for (rule, flat) in [(Rule::Lebedev26, 1.0), (Rule::Lebedev26, 0.25), (Rule::Lebedev50, 1.0)] {
            let cells = [9, 9, 9];
            let medium = Medium::new(cells, [1.0, 1.0, flat], vec![0.2; 729], false).expect("legal");
            let angles = Arc::new(Angles::new(rule));
            let mut operator = Operator::new(&medium, &angles, &vec![0.0; rule.order() + 1], None);
            operator.incoming = 1.0;
            let mut work = Work::new(&operator);
            let zero = vec![Lanes::ZERO; 729 * angles.moments];
            let mut out = zero.clone();
            operator.apply(&zero, None, &mut work, &mut out);
            let middle = medium.index([4; 3]);
            for (m, d) in angles.set.directions.iter().enumerate() {
                // Length from the middle back to the face.
                let half = [4.5, 4.5, 4.5 * flat];
                let length = (0..3).map(|k| half[k] / d[k].abs().max(1e-12)).fold(f64::INFINITY, f64::min);
                let found = f64::from(work.radiance[m * 729 + middle].0[0]);
                // Mean over the cell around the middle.
                let own = 0.2 * operator.paths[m].length_m;
                let exact = (-0.2 * length).exp() * (0.5 * own).sinh() / (0.5 * own);
                // On lattice directions exact up to f32; else the faces' corners are seen through interpolation.
                let bound = if operator.paths[m].taps.len() == 1 { 1e-5 } else { 0.06 };
                assert!((found - exact).abs() < bound, "{rule:?} {flat} {d:?}: {found} {exact}");
            }
        }
    }

    #[test]
    fn uniform_light_stays_where_nothing_is_lost() {
        for rule in Rule::ALL {
            for flat in [1.0, 0.125] {
                let values: Vec<f32> = (0..7 * 5 * 4).map(|i| [0.0, 0.1, 1.0, 20.0][i * 7 % 4]).collect();
                let medium = Medium::new([7, 5, 4], [1.0, 1.0, flat], values, false).expect("legal");
                let angles = Arc::new(Angles::new(rule));
                let mut scattering = vec![0.7; rule.order() + 1];
                scattering[0] = 1.0;
                let mut operator = Operator::new(&medium, &angles, &scattering, None);
                operator.incoming = 1.0;
                let mut work = Work::new(&operator);
                let mut given = vec![Lanes::ZERO; 140 * angles.moments];
                // Mean intensity 1: the zeroth moment is sqrt(4 pi).
                given.iter_mut().step_by(angles.moments).for_each(|g| *g = Lanes::splat(3.544_907_7));
                let mut out = given.clone();
                operator.apply(&given, None, &mut work, &mut out);
                for (i, light) in work.radiance.iter().enumerate() {
                    // Rounding of f32 over some tens of steps.
                    assert!((light.0[9] - 1.0).abs() < 5e-6, "{rule:?} {flat} {i}: {}", light.0[9]);
                }
            }
        }
    }
}
