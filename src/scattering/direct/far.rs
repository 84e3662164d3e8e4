//! Direct light of cells far from the source: one cone a cell, and the phase function over the angle under which a cell is seen.

use super::{Block, Direct, With};
use crate::numeric::sphere::{Direction, dot, harmonics_into};
use crate::scattering::lanes::dispatch;
use crate::scattering::medium::Medium;
use crate::scattering::phase::Phase;
use crate::scattering::rays::depth;

/// Most parts of a cell for the phase function.
const PARTS: usize = 27;

/// Adds one cone per far cell, all together scaled to the power that the near rays lose there.
pub fn add(
    direct: &mut Direct,
    medium: &Medium,
    (source_m, intensity): (Direction, f64),
    collided: Option<f64>,
    With { angles, phase, .. }: With,
    near: Block,
) {
    let (nk, nm, cells) = (angles.moments, angles.set.len(), medium.len());
    let order = angles.orders.last().copied().unwrap_or(0);
    let [nx, ny, nz] = medium.cells;
    let mut far = Vec::with_capacity(cells);
    let mut sum = 0.0;
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                let at = [x, y, z];
                if (0..3).all(|k| at[k] >= near[k][0] && at[k] < near[k][1]) {
                    continue;
                }
                let cell = medium.index(at);
                let centre = std::array::from_fn(|k| (at[k] as f64 + 0.5) * medium.spacing_m[k]);
                let (d, fluence) = fluence(medium, source_m, cell, centre, intensity);
                if fluence > 1e-30 {
                    sum += fluence * f64::from(medium.extinction_per_m[cell]);
                    far.push((cell, centre, d, fluence));
                }
            }
        }
    }
    let sum = sum * medium.cell_volume_m3();
    let scale = collided.map_or(1.0, |c| if sum > 1e-9 * intensity { (c / sum).clamp(0.5, 2.0) } else { 1.0 });
    let axis = |k: usize| angles.set.directions.iter().map(|d| d[k] as f32).collect::<Vec<_>>();
    let directions = [axis(0), axis(1), axis(2)];
    let mut y = vec![0.0; nk];
    let (mut cosines, mut towards) = (vec![0.0_f32; nm], vec![0.0_f32; nm]);
    // The width of the phase function's peak, rad, is about one over this.
    let sharpness = 1.0 / (1.0 - phase.asymmetry().abs()).max(0.01);
    for (cell, centre, d, fluence) in far {
        let fluence = fluence * scale;
        harmonics_into(d, order, &mut y);
        for (m, y) in direct.moments[cell * nk..][..nk].iter_mut().zip(&y) {
            *m += (fluence * y) as f32;
        }
        if direct.towards.is_empty() {
            continue;
        }
        let (parts, count) = within(medium, source_m, (cell, centre), sharpness);
        towards.fill(0.0);
        scatter(phase, (&parts[..count], fluence as f32), &directions, &mut cosines, &mut towards);
        for (m, value) in towards.iter().enumerate() {
            direct.towards[m * cells + cell] += value;
        }
    }
}

dispatch! {
    /// Adds what light of a fluence from some directions is scattered into the set's.
    fn scatter(
        phase: Phase, light: (&[(Direction, f64)], f32), directions: &[Vec<f32>; 3], cosines: &mut [f32], towards: &mut [f32]
    ) => scatter_body
}

#[inline(always)]
fn scatter_body(
    phase: Phase,
    (parts, fluence): (&[(Direction, f64)], f32),
    [east, north, up]: &[Vec<f32>; 3],
    cosines: &mut [f32],
    towards: &mut [f32],
) {
    for (d, share) in parts {
        let [x, y, z] = d.map(|c| c as f32);
        for (((cosine, a), b), c) in cosines.iter_mut().zip(east).zip(north).zip(up) {
            *cosine = x * a + y * b + z * c;
        }
        phase.add_values(cosines, fluence * *share as f32, towards);
    }
}

/// Directions from a source to the parts of a cell and their shares of its light: as many as the phase function turns over the angle
/// under which the cell is seen. One alone would see a sharp peak whole or not at all.
fn within(
    medium: &Medium,
    source_m: Direction,
    (cell, centre): (usize, Direction),
    sharpness: f64,
) -> ([(Direction, f64); PARTS], usize) {
    let from: Direction = std::array::from_fn(|k| centre[k] - source_m[k]);
    let distance = dot(from, from).sqrt();
    let parts: [usize; 3] = medium.spacing_m.map(|h| (1.5 * sharpness * h / distance).ceil().clamp(1.0, 3.0) as usize);
    let sigma = f64::from(medium.extinction_per_m[cell]);
    let mut all = [([0.0; 3], 0.0); PARTS];
    let count = parts.iter().product();
    let mut nearest = f64::INFINITY;
    for (i, part) in all[..count].iter_mut().enumerate() {
        let at = [i % parts[0], i / parts[0] % parts[1], i / (parts[0] * parts[1])];
        let v: Direction =
            std::array::from_fn(|k| from[k] + ((at[k] as f64 + 0.5) / parts[k] as f64 - 0.5) * medium.spacing_m[k]);
        let r = dot(v, v).sqrt();
        *part = (v.map(|c| c / r), r);
        nearest = nearest.min(r);
    }
    // The near side of a thick cell has more.
    let mut sum = 0.0;
    for (_, r) in &mut all[..count] {
        *r = (sigma * (nearest - *r)).exp() / (*r * *r);
        sum += *r;
    }
    all[..count].iter_mut().for_each(|(_, light)| *light /= sum);
    (all, count)
}

/// Direction from the source to a far cell and the mean fluence in it. A cell that swallows much of the light on its way
/// through is taken in eighths.
fn fluence(medium: &Medium, source_m: Direction, cell: usize, centre: Direction, intensity: f64) -> (Direction, f64) {
    let whole = medium.spacing_m.map(|h| 0.5 * h);
    let (d, fluence, own) = box_fluence(medium, source_m, cell, centre, whole);
    if own < 0.5 || fluence < 1e-12 {
        return (d, intensity * fluence);
    }
    let eighth = whole.map(|h| 0.5 * h);
    let sum: f64 = (0..8)
        .map(|corner| {
            let at = std::array::from_fn(|k| centre[k] + if corner >> k & 1 == 1 { eighth[k] } else { -eighth[k] });
            box_fluence(medium, source_m, cell, at, eighth).1
        })
        .sum();
    (d, intensity * sum / 8.0)
}

/// Direction to the centre of a box within a cell, fluence of 1 W/sr in the cone that it fills, and its depth along the ray.
fn box_fluence(
    medium: &Medium,
    source_m: Direction,
    cell: usize,
    centre: Direction,
    half: Direction,
) -> (Direction, f64, f64) {
    let v: Direction = std::array::from_fn(|k| centre[k] - source_m[k]);
    let distance = dot(v, v).sqrt();
    let d = v.map(|c| c / distance);
    // Half the chord through the centre, on either side.
    let arm = (0..3).map(|k| half[k] / d[k].abs().max(1e-300)).fold(distance, f64::min);
    let [a, b] = [distance - arm, distance + arm];
    let tau = depth(medium, source_m, d, a);
    let sigma = f64::from(medium.extinction_per_m[cell]);
    let own = sigma * (b - a);
    let spent = if own > 1e-6 { -(-own).exp_m1() / sigma } else { b - a };
    // The cone's path over its volume, per solid angle.
    let fluence = (-tau).exp() * spent / ((b * b * b - a * a * a) / 3.0);
    (d, fluence, own)
}
