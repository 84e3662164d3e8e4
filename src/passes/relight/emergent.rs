//! What of a field's light comes out of the cloud's lower and upper faces: for the ground, for other layers, for the air.
//!
//! A face is taken as one patch about its middle, as wide as the light on it, that sends the cosine of the angle. On ground
//! two thirds as far below as the patch is wide that is within a tenth of the sum over all columns below the patch and beside
//! it, within a fifth everywhere (test).

use super::{Emergent, Window};

/// Emergent light of a face from the flux out of each of its columns, W/m^2 of a source of 1 W/sr.
pub fn emergent(window: &Window, flux: &[f32]) -> Emergent {
    let [nx, _, _] = window.cells;
    let place = |i: usize| -> [f32; 2] {
        [0, 1].map(|k| window.corner_m[k] + ([i % nx, i / nx][k] as f32 + 0.5) * window.cell_m[k])
    };
    let out = |i: usize| f64::from(flux[i].max(0.0));
    let sum: f64 = (0..flux.len()).map(out).sum();
    if sum <= 0.0 {
        return Emergent::default();
    }
    let mean = |value: &dyn Fn([f32; 2]) -> f32| {
        ((0..flux.len()).map(|i| out(i) * f64::from(value(place(i)))).sum::<f64>() / sum) as f32
    };
    let middle_m = [mean(&|p| p[0]), mean(&|p| p[1])];
    let spread_m2 = mean(&|p| (p[0] - middle_m[0]).powi(2) + (p[1] - middle_m[1]).powi(2));
    let area = window.cell_m[0] * window.cell_m[1];
    let share = (sum * f64::from(area) / (4.0 * std::f64::consts::PI)) as f32;
    Emergent { middle_m, spread_m2, share }
}
