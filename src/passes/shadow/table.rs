//! The table of what a layer lets through: made on the processor for both executors, so that it cannot differ between them;
//! the light's direction is rounded to a quarter of a degree, so that this happens about once a minute of simulated time.
//!
//! *What it is.* Transmittance along the light's path through the layer, for each texel of the tile and [`THETAS`] values of
//! theta from where all is whole (minus the edge) to where nothing is left (1).
//! *How we compute it.* Midpoint sums along the slanted path, one sum a theta.
//! *How we store it.* Four bytes a texel hold four neighbouring thetas; a layer's last is the next one's first, so that any two
//! neighbours stand in one texel. Each coarser level is the mean of the one before: means of transmittance are means of light.
//! *How we read it back.* Bilinear, wrapping, between levels, and between the two thetas.

use super::Columns;
use crate::clouds::density::{HEIGHT, TILE_M, WIDTH};
use rayon::prelude::*;

/// Layers of the table, four thetas each.
pub const LAYERS: usize = 8;
/// Values of theta.
pub const THETAS: usize = 3 * LAYERS + 1;
/// Levels: 256 texels across, 128 and so on to 1.
pub const LEVELS: usize = 9;
/// Width of a texel of the first level.
pub const TEXEL_M: f32 = TILE_M / WIDTH as f32;

/// Texels by level: `LAYERS` squares one after another, x fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Level by level.
    pub levels: Vec<Vec<[u8; 4]>>,
}

/// The theta of an entry.
pub fn theta(entry: usize, edge: f32) -> f32 {
    -edge + (1.0 + edge) * entry as f32 / (THETAS - 1) as f32
}

/// Makes a table from a genus's shape values.
pub fn build(columns: &Columns, shape: &[u8]) -> Table {
    let thetas: [f32; THETAS] = std::array::from_fn(|entry| theta(entry, columns.edge));
    let rows: Vec<Vec<f32>> = (0..WIDTH).into_par_iter().map(|y| row(columns, shape, &thetas, y)).collect();
    // One square a theta.
    let mut squares: Vec<Vec<f32>> = (0..THETAS)
        .map(|entry| rows.iter().flat_map(|row| row[entry * WIDTH..][..WIDTH].iter().copied()).collect())
        .collect();
    let mut levels = Vec::with_capacity(LEVELS);
    for level in 0..LEVELS {
        levels.push(stored(&squares));
        squares = squares.par_iter().map(|square| halved(square, WIDTH >> level)).collect();
    }
    Table { levels }
}

/// Mean transmittance of one row of texels by theta.
pub fn mean_row(columns: &Columns, shape: &[u8], y: usize) -> [f32; THETAS] {
    let thetas = std::array::from_fn(|entry| theta(entry, columns.edge));
    let found = row(columns, shape, &thetas, y);
    std::array::from_fn(|entry| found[entry * WIDTH..][..WIDTH].iter().sum::<f32>() / WIDTH as f32)
}

/// Transmittances of one row of texels, theta by theta.
fn row(columns: &Columns, shape: &[u8], thetas: &[f32; THETAS], y: usize) -> Vec<f32> {
    let [dx, dy, up] = columns.direction;
    let samples = HEIGHT * columns.pieces as usize;
    let span = 1.0 - columns.begin;
    let ds = columns.thickness_m * span / (samples as f32 * up);
    let mut depths = vec![0.0f32; THETAS * WIDTH];
    let mut values = [0.0f32; WIDTH];
    for k in 0..samples {
        let share = columns.begin + span * (k as f32 + 0.5) / samples as f32;
        // Voxels from the texel's own column, along the light.
        let out = (share - columns.middle()) * columns.thickness_m / (up * TEXEL_M);
        values_along(shape, columns.bounded, y, [dx * out, dy * out], share * HEIGHT as f32 - 0.5, &mut values);
        for (theta, sums) in thetas.iter().zip(depths.chunks_exact_mut(WIDTH)) {
            for (sum, value) in sums.iter_mut().zip(&values) {
                *sum += (value - theta).max(0.0).min(columns.edge);
            }
        }
    }
    let scale = columns.extinction_per_m * ds / columns.edge;
    depths.iter_mut().for_each(|depth| *depth = (-scale * *depth).exp());
    depths
}

/// Shape values, 0 to 1, over a whole row, each at the same distance (voxels) from its own column and at height `z` (voxels,
/// centres at integers): trilinear, repeating in x and y unless nothing lies beside the tile, clamped in z.
fn values_along(shape: &[u8], bounded: bool, y: usize, away: [f32; 2], z: f32, values: &mut [f32; WIDTH]) {
    let wrapped = |v: i32| v.rem_euclid(WIDTH as i32) as usize;
    let clamped = |v: i32| v.clamp(0, HEIGHT as i32 - 1) as usize;
    let split = |v: f32| (v.floor() as i32, v - v.floor());
    let ((x0, fx), (y0, fy), (z0, fz)) = (split(away[0]), split(y as f32 + away[1]), split(z));
    let line = |dy: i32, dz: i32| &shape[(wrapped(y0 + dy) + clamped(z0 + dz) * WIDTH) * WIDTH..][..WIDTH];
    let lines = [line(0, 0), line(1, 0), line(0, 1), line(1, 1)];
    let weights = [(1.0 - fy) * (1.0 - fz), fy * (1.0 - fz), (1.0 - fy) * fz, fy * fz].map(|w| w / 255.0);
    let mut blended = [0.0f32; WIDTH];
    let beside = |v: i32| bounded && !(0..WIDTH as i32).contains(&v);
    for (k, (line, weight)) in lines.into_iter().zip(weights).enumerate() {
        if beside(y0 + (k as i32 & 1)) {
            continue;
        }
        for (sum, value) in blended.iter_mut().zip(line) {
            *sum += weight * f32::from(*value);
        }
    }
    for (x, value) in values.iter_mut().enumerate() {
        let at = |dx: i32| {
            let x = x as i32 + x0 + dx;
            if beside(x) { 0.0 } else { blended[wrapped(x)] }
        };
        *value = at(0) + (at(1) - at(0)) * fx;
    }
}

/// The mean of each four texels.
fn halved(square: &[f32], width: usize) -> Vec<f32> {
    let half = width / 2;
    let mean = |i: usize| {
        let (x, y) = (2 * (i % half), 2 * (i / half));
        let at = |dx: usize, dy: usize| square[x + dx + (y + dy) * width];
        0.25 * (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1))
    };
    (0..half * half).map(mean).collect()
}

fn stored(squares: &[Vec<f32>]) -> Vec<[u8; 4]> {
    let byte = |v: f32| (v * 255.0 + 0.5) as u8;
    let texel = |layer: usize, i: usize| std::array::from_fn(|k| byte(squares[3 * layer + k][i]));
    (0..LAYERS).flat_map(|layer| (0..squares[0].len()).map(move |i| texel(layer, i))).collect()
}

/// Four thetas of a layer at a place of the tile (periods) and a level, which may lie between two: 0 to 1 each.
pub fn sample(table: &Table, u: f32, v: f32, layer: usize, level: f32) -> [f32; 4] {
    let low = level as usize;
    let near = bilinear(&table.levels[low], WIDTH >> low, u, v, layer);
    let share = level - low as f32;
    if share == 0.0 || low + 1 >= LEVELS {
        return near;
    }
    let far = bilinear(&table.levels[low + 1], WIDTH >> (low + 1), u, v, layer);
    std::array::from_fn(|k| near[k] + (far[k] - near[k]) * share)
}

fn bilinear(texels: &[[u8; 4]], width: usize, u: f32, v: f32, layer: usize) -> [f32; 4] {
    let split = |v: f32| (v.floor() as i32, v - v.floor());
    let ((x, fx), (y, fy)) = (split(u * width as f32 - 0.5), split(v * width as f32 - 0.5));
    let mask = width as i32 - 1;
    let texel =
        |dx: i32, dy: i32| texels[((x + dx) & mask) as usize + (((y + dy) & mask) as usize + layer * width) * width];
    let [a, b, c, d] = [texel(0, 0), texel(1, 0), texel(0, 1), texel(1, 1)];
    std::array::from_fn(|k| {
        let [a, b, c, d] = [a, b, c, d].map(|t| f32::from(t[k]));
        let (low, high) = (a + (b - a) * fx, c + (d - c) * fx);
        (low + (high - low) * fy) * (1.0 / 255.0)
    })
}
