//! Where the energy of a solve went: absorbed, out through the faces, into the ground.

use super::direct::Direct;
use super::lanes::{LANES, Lanes};
use super::medium::Medium;
use super::operator::{Operator, Work};
use std::f64::consts::PI;

/// Shares of the power of a lane's sources.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Absorbed in the box.
    pub absorbed: f64,
    /// Left the box without having been scattered.
    pub escaped_direct: f64,
    /// Left the box scattered (what meets a ground below counts here, less what comes back).
    pub escaped_diffuse: f64,
    /// What is missing to 1 (or too much, when negative): the error of the discretisation.
    pub imbalance: f64,
}

/// The shares of every lane. `all` is direct and diffuse light by moments, `scattering[0]` the albedo of the transport.
pub fn energies(
    operator: &Operator,
    medium: &Medium,
    work: &Work,
    (all, scattering): (&[Lanes], &[f64]),
    directs: &[Direct],
    intensity: &[f64],
) -> Vec<Energy> {
    let moments = operator.angles.moments;
    let volume = medium.cell_volume_m3() * (4.0 * PI).sqrt() * (1.0 - scattering[0]);
    let mut absorbed = [0.0; LANES];
    for (cell, sigma) in medium.extinction_per_m.iter().enumerate() {
        let factor = volume * f64::from(*sigma);
        for (sum, light) in absorbed.iter_mut().zip(all[cell * moments].0) {
            *sum += factor * f64::from(light);
        }
    }
    let escaped = leaving(operator, medium, work);
    directs
        .iter()
        .zip(intensity)
        .enumerate()
        .map(|(l, (direct, intensity))| {
            let power = 4.0 * PI * intensity;
            if power <= 0.0 {
                return Energy::default();
            }
            let (a, d) = (absorbed[l] / power, direct.escaped_w / power);
            let s = (escaped[l] + direct.escaped_early_w) / power;
            Energy { absorbed: a, escaped_direct: d, escaped_diffuse: s, imbalance: 1.0 - a - d - s }
        })
        .collect()
}

/// Net diffuse power out of the box, W a lane: what cells send less what they take, over all directions. The transport
/// keeps energy cell by cell, so this is what crosses the faces (less what the ground sends up).
fn leaving(operator: &Operator, medium: &Medium, work: &Work) -> [f64; LANES] {
    let cells = medium.len();
    let volume = medium.cell_volume_m3();
    let mut sums = [0.0; LANES];
    for (m, weight) in operator.angles.set.weights.iter().enumerate() {
        for (cell, sigma) in medium.extinction_per_m.iter().enumerate() {
            let factor = volume * weight * f64::from(*sigma);
            let (light, source) = (&work.radiance[m * cells + cell].0, &work.source[m * cells + cell].0);
            for ((sum, light), source) in sums.iter_mut().zip(light).zip(source) {
                *sum += factor * f64::from(source - light);
            }
        }
    }
    sums
}
