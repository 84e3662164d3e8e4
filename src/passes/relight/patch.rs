//! A piece of a layer that is lit by a table: its cells, and where its virtual lights stand.
//!
//! Pieces lie at fixed places of a layer's pattern and drift with it, so that flashes hours apart in one cloud find the same one.

use super::cloud::{cell_m, levels};
use super::{Lighting, Request, WIDTH, Window};
use crate::scattering::basis::{Content, Recipe};
use crate::scattering::lights::{Lights, LightsError};
use crate::scattering::medium::Medium;

/// Cells from the middle of one piece to the next: a flash is at most half of that off the middle.
pub const STEP_CELLS: usize = 8;
/// Cells from the middle within which source points may lie, as far as there are lights.
pub const REACH_CELLS: f32 = 12.0;
/// Cells from light to light, east and north.
const APART_CELLS: f32 = 2.0;
/// Lights through a layer upwards, at least and at most.
const LEVELS: [usize; 2] = [4, 12];
/// Lights below the layer.
const BELOW: usize = 3;
/// By how much a table is smaller than its fields as they are: what tables of stratocumulus and cumulonimbus had, made less.
const PACKED: usize = 40;

/// The cells of a piece about its ground point, wide enough for points that lie `reach_m` from a flash in it.
pub fn window(base_m: f32, thickness_m: f32, wide_m: f32) -> Window {
    let half = 0.5 * WIDTH as f32 * wide_m;
    let levels = levels(thickness_m);
    Window {
        corner_m: [-half, -half, base_m],
        cell_m: [wide_m, wide_m, thickness_m / levels as f32],
        cells: [WIDTH, WIDTH, levels],
    }
}

/// Width of the cells for points that lie up to `reach_m` (east or north) from a flash: that of a solve, doubled until they are all
/// among the lights wherever in the piece the flash is.
pub fn wide_m(thickness_m: f32, reach_m: f32) -> f32 {
    let mut wide = cell_m(thickness_m);
    while reach_m > (REACH_CELLS - 0.5 * STEP_CELLS as f32) * wide && wide < 1e5 {
        wide *= 2.0;
    }
    wide
}

/// The lights of a piece, in the window's coordinates.
///
/// # Errors
/// [`LightsError`]: lengths that are none.
pub fn lights(window: &Window) -> Result<Lights, LightsError> {
    let [wide, _, high] = window.cell_m.map(f64::from);
    let thickness_m = high * window.cells[2] as f64;
    let levels = (thickness_m / wide * 2.0).round().clamp(LEVELS[0] as f64, LEVELS[1] as f64) as usize;
    // The lists of a box as wide as the lights reach, with what stands below it.
    let across = 2.0 * f64::from(REACH_CELLS) * wide;
    let count = (2.0 * REACH_CELLS / APART_CELLS) as usize + 1;
    let below_m = f64::from(window.corner_m[2]).clamp(1.0, 6_000.0);
    let mut lights = Lights::even([count, count, levels + 1], [across, across, thickness_m], 0.0, false)?;
    let aside = (0.5 * WIDTH as f64 - f64::from(REACH_CELLS)) * wide;
    lights.x_m.iter_mut().chain(&mut lights.y_m).for_each(|at| *at += aside);
    // Ever farther apart, as eq. 4 has it.
    let below = (0..BELOW).map(|i| -below_m * 0.25_f64.powi(i as i32));
    lights.z_m = below.chain(lights.z_m).collect();
    Ok(lights)
}

/// What a method stores.
fn content(method: Lighting) -> Option<Content> {
    method.method().table()
}

/// The recipe of a request's table.
pub fn recipe(request: &Request, window: &Window, medium: Medium) -> Option<Recipe> {
    let lights = lights(window).ok()?;
    let content = content(request.method)?;
    Some(Recipe { medium, params: super::solve::params(), lights, content, packing: content.usual_packing() })
}

/// About how much memory the whole table of a piece takes, bytes; 0 for methods without one.
pub fn bytes(method: Lighting, window: &Window) -> usize {
    let Some(content) = content(method) else { return 0 };
    let components = if content == Content::Total { 26 } else { 16 };
    let cells: usize = window.cells.iter().product();
    lights(window).map_or(usize::MAX, |lights| lights.len() * cells * components * 4 / PACKED)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_stand_through_the_piece_and_down_to_the_ground() {
        for (thickness_m, base_m) in [(300.0, 600.0), (700.0, 1_000.0), (9_500.0, 900.0), (100.0, 0.0)] {
            let wide = wide_m(thickness_m, 1_500.0);
            let window = window(base_m, thickness_m, wide);
            let lights = lights(&window).expect("legal");
            let middle = f64::from(16.0 * wide);
            let reach = f64::from(REACH_CELLS * wide);
            assert!((lights.x_m[0] - (middle - reach)).abs() < 1e-3 && lights.x_m == lights.y_m);
            assert!((lights.x_m.last().expect("some") - (middle + reach)).abs() < 1e-3);
            assert!(lights.z_m.windows(2).all(|z| z[1] > z[0]), "{:?}", lights.z_m);
            assert!((lights.z_m[0] + f64::from(base_m.max(1.0))).abs() < 1e-3);
            assert!((lights.z_m.last().expect("some") - f64::from(thickness_m)).abs() < 1e-2);
            // Wherever in the piece a flash is, its points are among the lights.
            assert!(1_500.0 + 0.5 * STEP_CELLS as f32 * wide <= REACH_CELLS * wide);
            assert!(bytes(Lighting::Hybrid, &window) < 100 << 20 && bytes(Lighting::Solve, &window) == 0);
        }
    }
}
