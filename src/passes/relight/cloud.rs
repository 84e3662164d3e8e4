//! The cloud around a flash as a box of cells: the drawn layer itself, its charts, map and outlines, averaged.

use super::{HEIGHT, Point, Request, WIDTH, Window};
use crate::clouds::density::DensityVolume;
use crate::clouds::modulation;
use crate::passes::deck::field::{BOUNDS_WIDTH, Textures, margin};
use crate::scattering::medium::{Medium, MediumError};
use glam::Vec3;
use rayon::prelude::*;

/// Width of a cell in a layer of this thickness, m.
pub fn cell_m(thickness_m: f32) -> f32 {
    (0.5 * thickness_m).clamp(CELL_M[0], CELL_M[1])
}

/// Cells upwards in a layer of this thickness.
pub fn levels(thickness_m: f32) -> usize {
    if thickness_m <= THIN_M { HEIGHT / 2 } else { HEIGHT }
}

/// Widths of a cell, m: half a layer's thickness, within these. In a thick deck light spreads by about a third of the
/// thickness, which cells of 500 m would not show under a thin one.
const CELL_M: [f32; 2] = [150.0, 500.0];
/// Up to this thickness a field has half the cells upwards.
const THIN_M: f32 = 4_000.0;
/// A look into a cell for so many metres of its width, m, and how many upwards. The volume's voxels are 62.5 m wide.
const LOOK_M: f32 = 100.0;
const LOOKS_UP: usize = 2;

/// Whether a layer scatters too little for light to be scattered twice in it; such a one is lit by points.
pub fn too_thin(request: &Request) -> bool {
    request.layer.extinction_per_m * request.layer.thickness_m < 0.05
}

/// The box around the points of a request.
pub fn window(request: &Request) -> Window {
    if let Some(patch) = request.patch {
        return patch;
    }
    let layer = &request.layer;
    let (base, thickness) = (layer.base_m, layer.thickness_m);
    // Points outside the layer's heights light it from there, the less the farther.
    let weight = |p: &Point| {
        let apart = (base - p.position_m[2]).max(p.position_m[2] - base - thickness).max(0.0);
        p.share * (-apart / thickness.max(500.0)).exp()
    };
    let all: f32 = request.points.iter().map(weight).sum::<f32>().max(1e-30);
    let middle: [f32; 2] =
        std::array::from_fn(|k| request.points.iter().map(|p| weight(p) * p.position_m[k]).sum::<f32>() / all);
    let reach = request
        .points
        .iter()
        .filter(|p| weight(p) > 1e-3 * all)
        .map(|p| (0..2).map(|k| (p.position_m[k] - middle[k]).abs()).fold(0.0, f32::max))
        .fold(0.0, f32::max);
    let wide = cell_m(thickness);
    // Beside the outermost points there is room for as much light again.
    let wide = wide.max((reach + 4.0 * wide) / (0.5 * WIDTH as f32));
    let levels = levels(thickness);
    let half = 0.5 * WIDTH as f32 * wide;
    Window {
        corner_m: [middle[0] - half, middle[1] - half, base],
        cell_m: [wide, wide, thickness / levels as f32],
        cells: [WIDTH, WIDTH, levels],
    }
}

/// Mean extinction of the window's cells.
///
/// # Errors
/// [`MediumError`] for a layer whose numbers are none.
pub fn medium(request: &Request, window: &Window) -> Result<Medium, MediumError> {
    let layer = &request.layer;
    let volume = DensityVolume::of(request.kind);
    // Bounds only save looks at clear sky, and cost as much as they would save here.
    let bounds = [u8::MAX; BOUNDS_WIDTH * BOUNDS_WIDTH];
    let textures = Textures {
        shape: &volume.shape,
        lights: &[],
        bounds: &bounds,
        map: modulation::map(),
        detail: &[],
        shade: None,
        glow: None,
    };
    let [nx, ny, nz] = window.cells;
    let wide = ((window.cell_m[0] / LOOK_M).ceil() as usize).clamp(1, 4);
    let looks = [wide, wide, LOOKS_UP];
    let at = |k: usize, i: usize, look: usize| {
        window.corner_m[k] + (i as f32 + (look as f32 + 0.5) / looks[k] as f32) * window.cell_m[k]
    };
    let mut values = vec![0.0_f32; nx * ny * nz];
    values.par_chunks_mut(nx).enumerate().for_each(|(row, out)| {
        for (x, out) in out.iter_mut().enumerate() {
            let mut sum = 0.0;
            for look in 0..looks.iter().product() {
                let [i, j, k] = [look % wide, look / wide % wide, look / (wide * wide)];
                let (east, north, height) = (at(0, x, i), at(1, row % ny, j), at(2, row / ny, k));
                // The sphere falls below the tangent plane.
                let fall = (east * east + north * north) / (2.0 * request.earth_m);
                let p = Vec3::new(east, north, height - fall);
                // Fine detail is no matter here: it has no mean.
                let found = margin(layer, &textures, request.earth_m, p, height, f32::INFINITY);
                sum += (found * layer.inverse_edge).clamp(0.0, 1.0);
            }
            *out = layer.extinction_per_m * sum / looks.iter().product::<usize>() as f32;
        }
    });
    Medium::new(window.cells, window.cell_m.map(f64::from), values, false)
}
