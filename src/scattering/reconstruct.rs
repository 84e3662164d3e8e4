//! From the transport's radiance to what cells scatter: the phase function as it is, averaged over direction cells.
//!
//! The delta-M source is not the light that a cell scatters (it lacks the peak). What Dobashi et al. 2007 call intensity,
//! the right side of their eq. 1, is: the direct light by the phase function, plus the diffuse radiance of every
//! direction by the mean of the phase function over the part of the sphere that the direction stands for.

use super::angles::Angles;
use super::lanes::{Lanes, dispatch};
use super::phase::Phase;
use crate::numeric::sphere::{dot, fibonacci};
use std::f64::consts::PI;

/// Share of the radiance of each direction that is scattered into each other: `m * directions + n`, rows sum to 1.
pub fn matrix(angles: &Angles, phase: Phase) -> Vec<f32> {
    const SAMPLES: usize = 20_000;
    let n = angles.set.len();
    let mut sums = vec![0.0_f64; n * n];
    for d in fibonacci(SAMPLES) {
        let cell = angles.set.nearest(d);
        for (m, s) in angles.set.directions.iter().enumerate() {
            sums[m * n + cell] += phase.value(dot(*s, d)) * 4.0 * PI / SAMPLES as f64;
        }
    }
    // The samples' own error of a sharp peak goes out with the sum of the row.
    for row in sums.chunks_mut(n) {
        let whole: f64 = row.iter().sum();
        row.iter_mut().for_each(|v| *v /= whole);
    }
    sums.into_iter().map(|v| v as f32).collect()
}

/// What cells scatter into every direction of the diffuse light, per unit of extinction and albedo: directions times cells.
pub fn diffuse(matrix: &[f32], radiance: &[Lanes], cells: usize, out: &mut [Lanes]) {
    multiply(matrix, radiance, cells, out);
}

/// [`diffuse`] of one lane's radiance.
pub fn diffuse_one(matrix: &[f32], radiance: &[f32], cells: usize) -> Vec<f32> {
    let n = matrix.len().isqrt();
    let mut out = vec![0.0; radiance.len()];
    for (row, out) in matrix.chunks(n).zip(out.chunks_mut(cells)) {
        for (share, light) in row.iter().zip(radiance.chunks(cells)) {
            for (o, l) in out.iter_mut().zip(light) {
                *o += share * l;
            }
        }
    }
    out
}

dispatch! {
    /// The matrix times every cell's directions.
    fn multiply(matrix: &[f32], radiance: &[Lanes], cells: usize, out: &mut [Lanes]) => multiply_body
}

#[inline(always)]
fn multiply_body(matrix: &[f32], radiance: &[Lanes], cells: usize, out: &mut [Lanes]) {
    let n = matrix.len().isqrt();
    for cell in 0..cells {
        for m in 0..n {
            let mut sum = Lanes::ZERO;
            for (k, share) in matrix[m * n..][..n].iter().enumerate() {
                sum = sum.plus(*share, &radiance[k * cells + cell]);
            }
            out[m * cells + cell] = sum;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::sphere::Rule;

    #[test]
    fn uniform_light_scatters_uniformly_and_a_peak_stays_forward() {
        for phase in [Phase::HenyeyGreenstein(0.0), Phase::HenyeyGreenstein(0.85), Phase::DECK] {
            let angles = Angles::new(Rule::Lebedev26);
            let p = matrix(&angles, phase);
            for row in p.chunks(26) {
                assert!((row.iter().sum::<f32>() - 1.0).abs() < 1e-5);
            }
            for m in 0..26 {
                let best = (0..26).max_by(|a, b| p[m * 26 + a].total_cmp(&p[m * 26 + b]));
                assert!(phase.asymmetry() < 0.5 || best == Some(m));
            }
        }
    }
}
