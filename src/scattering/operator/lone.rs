//! The pass of light for one source alone: lanes are sixteen neighbouring cells of a row instead of sixteen sources.
//!
//! The cells of a plane depend on the plane before and on the source, never on each other, so that they may stand side by side.
//! Planes across the east axis are turned on the way in and out. The transport is that of the parent, number for number up to
//! the order of sums.

use super::{First, NO_TILT, Operator, Weights, Work, plane_axes};
use crate::scattering::angles::MOST_MOMENTS;
use crate::scattering::lanes::{LANES, Lanes, dispatch};
use rayon::prelude::*;

/// An operator made ready for one source.
pub struct Lone<'a> {
    operator: &'a Operator,
    shares: &'a Shares,
    /// Whether directions are swept on all threads; not where sources are.
    spread_out: bool,
}

/// What cells do to the light of every direction: [`super::Weights`] of sixteen cells an entry, in the order of the sweep. Directions
/// whose planes lie across the same axis at the same distance lose alike, and opposites tilt alike: they share, so that all
/// of it stays near the processor.
pub struct Shares {
    lost: Vec<[Lanes; 2]>,
    tilted: Vec<[Lanes; 2]>,
    /// Where a direction's entries begin in either.
    starts: Vec<[usize; 2]>,
}

/// The order of a direction's sweep: planes, rows of a plane, cells of a row.
#[derive(Clone, Copy)]
struct Order {
    planes: usize,
    rows: usize,
    row: usize,
    /// Strides of the three in the grid.
    stride: [usize; 3],
}

impl Order {
    fn new(cells: [usize; 3], axis: usize) -> Self {
        let stride = [1, cells[0], cells[0] * cells[1]];
        let [u, v] = plane_axes(axis);
        Self { planes: cells[axis], rows: cells[v], row: cells[u], stride: [stride[axis], stride[v], stride[u]] }
    }

    /// Index in the grid of the `i`-th cell of the sweep.
    fn cell(&self, i: usize) -> usize {
        let at = [i / (self.row * self.rows), i / self.row % self.rows, i % self.row];
        at[0] * self.stride[0] + at[1] * self.stride[1] + at[2] * self.stride[2]
    }
}

impl Shares {
    /// For an operator without ground whose rows of cells fill the lanes; `None` for others.
    pub fn new(operator: &Operator) -> Option<Self> {
        let n = operator.cells;
        if operator.ground.is_some() || !n[0].is_multiple_of(LANES) || !n[1].is_multiple_of(LANES) {
            return None;
        }
        let cells = operator.len();
        let mut all = Self { lost: Vec::new(), tilted: Vec::new(), starts: vec![[0; 2]; operator.paths.len()] };
        let mut classes: Vec<(usize, f64, usize)> = Vec::new();
        for (m, (path, from)) in operator.paths.iter().zip(operator.weights.chunks(cells)).enumerate() {
            let order = Order::new(n, path.axis);
            let entries = |pick: &dyn Fn(&Weights) -> [f32; 2]| -> Vec<[Lanes; 2]> {
                let mut out = vec![[Lanes::ZERO; 2]; cells / LANES];
                for (i, out) in out.iter_mut().enumerate() {
                    for lane in 0..LANES {
                        let [a, b] = pick(&from[order.cell(i * LANES + lane)]);
                        (out[0].0[lane], out[1].0[lane]) = (a, b);
                    }
                }
                out
            };
            let like = |(axis, length, _): &&(usize, f64, usize)| {
                *axis == path.axis && (length / path.length_m - 1.0).abs() < 1e-12
            };
            let lost = classes.iter().find(like).map(|class| class.2);
            let lost = lost.unwrap_or_else(|| {
                classes.push((path.axis, path.length_m, all.lost.len()));
                all.lost.extend(entries(&|w| [w.lost, w.share]));
                all.lost.len() - cells / LANES
            });
            let opposite = operator.angles.set.opposite[m];
            let tilted = if opposite < m {
                all.starts[opposite][1]
            } else {
                // Too small to matter: 0.
                all.tilted.extend(entries(&|w| if w.lean > 1e-4 { [w.tilt, w.lean] } else { [0.0; 2] }));
                all.tilted.len() - cells / LANES
            };
            all.starts[m] = [lost, tilted];
        }
        Some(all)
    }

    /// Memory that it takes, bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(self.lost.as_slice()) + size_of_val(self.tilted.as_slice())
    }
}

impl<'a> Lone<'a> {
    /// `None` where sources cannot be swept alone ([`Shares::new`]).
    pub fn new(operator: &'a Operator, spread_out: bool) -> Option<Self> {
        operator.shares().map(|shares| Self { operator, shares, spread_out })
    }

    /// Room for source and radiance.
    pub fn work(&self) -> Work {
        let count = self.operator.len() / LANES * self.operator.angles.set.len();
        Work { source: vec![Lanes::ZERO; count], radiance: vec![Lanes::ZERO; count], ground: Vec::new() }
    }

    /// Moments cell by cell as the pass takes them: sixteenths of the cells times moments.
    pub fn moments(&self, given: &[f32]) -> Vec<Lanes> {
        let moments = self.operator.angles.moments;
        let mut out = vec![Lanes::ZERO; given.len() / LANES];
        for (cell, row) in given.chunks(moments).enumerate() {
            for (k, value) in row.iter().enumerate() {
                out[cell / LANES * moments + k].0[cell % LANES] = *value;
            }
        }
        out
    }

    /// As [`Operator::apply`]; source and radiance in `work` are directions times cells.
    pub fn apply(&self, given: &[Lanes], first: Option<&First>, work: &mut Work, out: &mut [Lanes]) {
        let operator = self.operator;
        let blocks = operator.len() / LANES;
        spread(operator, given, &mut work.source);
        let one = |room: &mut Room, m: usize, radiance: &mut [Lanes], source: &[Lanes]| {
            let known = first.map(|first| self.known(first, m));
            let [lost, tilted] = self.shares.starts[m];
            let weights = (&self.shares.lost[lost..][..blocks], &self.shares.tilted[tilted..][..blocks]);
            let to: &mut [f32] = bytemuck::cast_slice_mut(radiance);
            sweep(operator, m, weights, bytemuck::cast_slice(source), known.as_ref(), room, to);
        };
        if self.spread_out && rayon::current_num_threads() > 1 {
            let each = work.radiance.par_chunks_mut(blocks).zip(work.source.par_chunks(blocks)).enumerate();
            each.for_each_init(Room::default, |room, (m, (radiance, source))| one(room, m, radiance, source));
        } else {
            let mut room = Room::default();
            let each = work.radiance.chunks_mut(blocks).zip(work.source.chunks(blocks)).enumerate();
            each.for_each(|(m, (radiance, source))| one(&mut room, m, radiance, source));
        }
        gather(operator, &work.radiance, out);
    }

    /// Where the source's rise over a cell is known: 1 and its slope, cell by cell in the order of the sweep.
    fn known(&self, first: &First, m: usize) -> Known {
        let operator = self.operator;
        let cells = operator.len();
        let order = Order::new(operator.cells, operator.paths[m].axis);
        let mut known = Known { there: vec![0.0; cells], slope: vec![0.0; cells] };
        for i in 0..cells {
            let cell = order.cell(i);
            let (slot, w) = (first.slot[cell], &operator.weights[m * cells + cell]);
            if slot != NO_TILT && w.lean > 1e-4 {
                known.there[i] = 1.0;
                known.slope[i] = first.rises[slot as usize * operator.paths.len() + m].0[0] * (w.unit / w.tilt);
            }
        }
        known
    }
}

/// Room for one direction's sweep.
#[derive(Default)]
pub struct Room {
    source: Vec<f32>,
    entering: Vec<f32>,
    leaving: Vec<f32>,
}

/// Where the rise of the source over a cell is known.
pub struct Known {
    there: Vec<f32>,
    slope: Vec<f32>,
}

dispatch! {
    fn spread(operator: &Operator, given: &[Lanes], source: &mut [Lanes]) => spread_body
}
dispatch! {
    fn gather(operator: &Operator, radiance: &[Lanes], out: &mut [Lanes]) => gather_body
}
dispatch! {
    /// Light of one direction, plane by plane downwind; `source` and `radiance` cell by cell.
    fn sweep(
        operator: &Operator, m: usize, weights: (&[[Lanes; 2]], &[[Lanes; 2]]), source: &[f32], known: Option<&Known>,
        room: &mut Room, radiance: &mut [f32]
    ) => sweep_body
}

#[inline(always)]
fn spread_body(operator: &Operator, given: &[Lanes], source: &mut [Lanes]) {
    let (blocks, moments) = (operator.len() / LANES, operator.angles.moments);
    let mut scattered = [Lanes::ZERO; MOST_MOMENTS];
    for block in 0..blocks {
        let light = &given[block * moments..][..moments];
        for (s, k) in scattered.iter_mut().zip(&operator.angles.by_parity) {
            *s = light[*k].scaled(operator.scattering[*k]);
        }
        operator.angles.spread(&scattered[..moments], &mut source[block..], blocks);
    }
}

#[inline(always)]
fn gather_body(operator: &Operator, radiance: &[Lanes], out: &mut [Lanes]) {
    let (blocks, moments) = (operator.len() / LANES, operator.angles.moments);
    let mut halves = vec![[Lanes::ZERO; 2]; operator.angles.pairs.len()];
    for block in 0..blocks {
        operator.angles.gather(&radiance[block..], blocks, &mut halves, &mut out[block * moments..][..moments]);
    }
}

#[inline(always)]
fn load(from: &[f32], at: usize) -> Lanes {
    let mut lanes = Lanes::ZERO;
    lanes.0.copy_from_slice(&from[at..at + LANES]);
    lanes
}

#[inline(always)]
fn sweep_body(
    operator: &Operator,
    m: usize,
    (losses, tilts): (&[[Lanes; 2]], &[[Lanes; 2]]),
    source: &[f32],
    known: Option<&Known>,
    room: &mut Room,
    radiance: &mut [f32],
) {
    let path = &operator.paths[m];
    let order = Order::new(operator.cells, path.axis);
    // Each plane has one more row at either side and each row one more cell: dark for light, the nearest cell's for the
    // source.
    let wide = order.row + 2;
    let face = wide * (order.rows + 2);
    framed(&order, source, &mut room.source);
    let source = &room.source[..];
    for light in [&mut room.entering, &mut room.leaving] {
        light.clear();
        light.resize(face, 0.0);
    }
    let (mut entering, mut leaving) = (&mut room.entering[..], &mut room.leaving[..]);
    let taps: Vec<(isize, f32)> = path.taps.iter().map(|t| (t.v * wide as isize + t.u, t.weight)).collect();
    let turned = order.stride[2] != 1;
    for p in 0..order.planes {
        let [plane, before, after] = {
            let last = order.planes - 1;
            let [a, b, c] = [p, p.saturating_sub(1), (p + 1).min(last)];
            if path.forward { [a, b, c] } else { [last - a, last - b, last - c] }
        };
        for v in 0..order.rows {
            for u in (0..order.row).step_by(LANES) {
                let here = (v + 1) * wide + u + 1;
                let (own, ahead, behind) = (plane * face + here, after * face + here, before * face + here);
                let (mut light, mut slope) = (Lanes::ZERO, Lanes::ZERO);
                for (tap, weight) in &taps {
                    if p > 0 {
                        light = light.plus(*weight, &load(entering, here.wrapping_add_signed(*tap)));
                    }
                    let rise = load(source, ahead.wrapping_add_signed(-tap))
                        .plus(-1.0, &load(source, behind.wrapping_add_signed(*tap)));
                    slope = slope.plus(*weight, &rise);
                }
                let at = (plane * order.rows + v) * order.row + u;
                if let Some(known) = known {
                    let instead = load(&known.slope, at).plus(-1.0, &slope);
                    slope = slope.plus(1.0, &instead.times(&load(&known.there, at)));
                }
                let ([lost, share], [tilt, lean]) = (&losses[at / LANES], &tilts[at / LANES]);
                let own = load(source, own);
                let difference = own.plus(-1.0, &light);
                let mean = own.plus(-1.0, &difference.times(share).plus(1.0, &slope.times(lean)));
                let out = light.plus(1.0, &difference.times(lost).plus(1.0, &slope.times(tilt)));
                leaving[here..here + LANES].copy_from_slice(&out.0);
                if turned {
                    for (lane, mean) in mean.0.iter().enumerate() {
                        radiance[plane * order.stride[0] + v * order.stride[1] + (u + lane) * order.stride[2]] = *mean;
                    }
                } else {
                    radiance[plane * order.stride[0] + v * order.stride[1] + u..][..LANES].copy_from_slice(&mean.0);
                }
            }
        }
        std::mem::swap(&mut entering, &mut leaving);
    }
}

/// The source in the order of a sweep with a frame around each plane.
#[inline(always)]
fn framed(order: &Order, source: &[f32], out: &mut Vec<f32>) {
    let wide = order.row + 2;
    let face = wide * (order.rows + 2);
    out.resize(face * order.planes, 0.0);
    for (plane, out) in out.chunks_exact_mut(face).enumerate() {
        for v in 0..order.rows {
            let row = &mut out[(v + 1) * wide..][..wide];
            let from = plane * order.stride[0] + v * order.stride[1];
            if order.stride[2] == 1 {
                row[1..=order.row].copy_from_slice(&source[from..from + order.row]);
            } else {
                for (u, to) in row[1..=order.row].iter_mut().enumerate() {
                    *to = source[from + u * order.stride[2]];
                }
            }
            (row[0], row[order.row + 1]) = (row[1], row[order.row]);
        }
        out.copy_within(wide..2 * wide, 0);
        out.copy_within(order.rows * wide..(order.rows + 1) * wide, (order.rows + 1) * wide);
    }
}

#[cfg(test)]
mod tests {
    use crate::scattering::medium::Medium;
    use crate::scattering::ordinates::{Params, PointSource, Solver};
    use crate::scattering::relight::{Method, Relighter};

    #[test]
    fn one_source_has_the_light_that_it_has_among_others() {
        // Flat cells, cubes and tall cells: planes across all three axes, thick and empty cells.
        for spacing in [[300.0, 300.0, 75.0], [100.0; 3], [100.0, 130.0, 300.0]] {
            let values: Vec<f32> = (0..32 * 16 * 6).map(|i| [0.0, 0.002, 0.05, 0.02][i * 7 % 11 % 4]).collect();
            let medium = Medium::new([32, 16, 6], spacing, values, false).expect("legal");
            let params = Params { tolerance: 1e-5, ..Params::default() };
            let solver = Solver::new(&medium, params).expect("legal");
            let place = |x: f64, y: f64, z: f64| [x * spacing[0], y * spacing[1], z * spacing[2]];
            let points = [
                PointSource { position_m: place(15.3, 7.7, 2.9), intensity: 1.0 },
                PointSource { position_m: place(11.0, 3.2, -4.0), intensity: 2.0 },
            ];
            let (lights, _) = solver.solve(&[&points]).expect("solved");
            let alone = solver.scatter_one(&solver.direct(&points)).expect("solved").0;
            let among = &lights[0].towards;
            let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>().sqrt();
            let scale = norm(&mut among.iter().map(|v| f64::from(*v)));
            let apart = norm(&mut among.iter().zip(&alone).map(|(a, b)| f64::from(a - b)));
            // Both stop at a residual of 1e-5, which errors exceed where light is scattered some ten times.
            assert!(scale > 0.0 && apart < 3e-4 * scale, "{spacing:?}: {}", apart / scale);
            // What is relit by a solve is this.
            let relit = Relighter::new(&medium, &solver).relight(Method::Solve, &points, None).expect("relit");
            assert_eq!(relit.towards.len(), alone.len());
        }
    }
}
