//! A storm cell: one cumulonimbus as a bounded volume, not a pattern that repeats.
//!
//! *What it is.* Shape values of a tower and its anvil in a square that fits into the region that the cell stands in: the
//! volume's x runs downwind, its tower stands upwind of the middle, and near the square's sides there is nothing, so that neighbours
//! of the tile never show. The threshold theta says how far it has grown: first the tower's core, at last the whole anvil.
//! *How we compute it.* Distances inside a tower that bends and bulges, under a dome that overshoots, and inside a lens that
//! spreads downwind and thins out to its rim, proportions by eye; billows of 3 km and less on the tower, fibres along the wind on the
//! anvil.

use super::CloudKind;
use super::coverage::{Threshold, column_thetas};
use super::density::{HEIGHT, WIDTH};
use crate::numeric::noise::{Cellular, fractal};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::sync::LazyLock;

/// Theta of a cell that has only begun: nothing of it is there.
const BEGUN: f32 = 1.0;
/// Theta of a cell that has grown as far as it can.
const GROWN: f32 = 0.40;
/// How much the shape value rises over the widths below.
const STEEPNESS: f32 = 0.6;
/// Width over which the tower's value rises by that, in sides of the square.
const TOWER_WIDTH: f32 = 0.16;
/// Seed of its noise.
const SEED: u32 = 4_100;

/// Theta of a cell that has grown by a share of 0 to 1. The large map has no part in it: a cell is one cloud.
pub fn threshold(growth: f32) -> Threshold {
    let offset = BEGUN + (GROWN - BEGUN) * growth.clamp(0.0, 1.0);
    Threshold { patchiness: 0.0, offset, typical: offset }
}

/// Share of its square that a cell hides that has grown by a share of 0 to 1.
pub fn cover(growth: f32) -> f32 {
    static SORTED: LazyLock<Vec<f32>> = LazyLock::new(|| {
        let mut thetas = column_thetas(CloudKind::StormCell, 1.0);
        thetas.sort_by(f32::total_cmp);
        thetas
    });
    let theta = threshold(growth).offset;
    let below = SORTED.partition_point(|own| *own < theta);
    1.0 - below as f32 / SORTED.len() as f32
}

/// Shape values of the square, x (downwind) fastest, z slowest, one byte each.
pub fn shape() -> Vec<u8> {
    let noise = Noise::new();
    let mut shape = vec![0u8; WIDTH * WIDTH * HEIGHT];
    shape.par_chunks_mut(WIDTH).enumerate().for_each(|(row, out)| {
        let (y, z) = (row % WIDTH, row / WIDTH);
        for (x, voxel) in out.iter_mut().enumerate() {
            let [x, y] = [x, y].map(|i| (i as f32 + 0.5) / WIDTH as f32);
            let height = (z as f32 + 0.5) / HEIGHT as f32;
            *voxel = (value(&noise, Vec3::new(x, y, height)).clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        }
    });
    shape
}

/// The shape value at a place of the square and a share of the height, 0 to 1 each.
fn value(noise: &Noise, p: Vec3) -> f32 {
    let (place, height) = (Vec2::new(p.x - 0.5, p.y - 0.5), p.z);
    let tower = smooth_max(tower(place, height), turrets(place, height), 0.10);
    let anvil = anvil(place, height);
    // Smooth on the anvil, heaped on the tower.
    let spread = smoothstep(0.0, 0.5, anvil - tower);
    let body = smooth_max(tower, anvil, 0.15);
    let rough = noise.billows(p) * (1.0 - 0.75 * spread) + noise.fibres(p) * spread;
    let base = ((height - 0.012) / 0.03).min(1.0);
    // Nothing near the sides, whatever the noise: what lies beyond is the same square again.
    let side = ((0.485 - place.x.abs().max(place.y.abs())) / 0.03).clamp(0.0, 1.0);
    (GROWN + STEEPNESS * (body + rough).min(base)) * side
}

/// How far a place is inside the tower, in widths of its edge.
fn tower(place: Vec2, height: f32) -> f32 {
    // It leans downwind, narrows over its base and widens into the anvil.
    let axis = Vec2::new(-0.17 + 0.07 * height * height, 0.0);
    let radius = 0.115 - 0.02 * (1.0 - (height / 0.3 - 1.0).powi(2)).max(0.0) + 0.035 * smoothstep(0.5, 0.85, height);
    let beside = (radius - (place - axis).length()) / TOWER_WIDTH;
    // A dome goes through the anvil's top.
    let dome = 0.97 - 0.9 * ((place - axis).length() / 0.09).powi(2).min(1.0) * 0.14;
    beside.min((dome - height) / 0.12)
}

/// The same for lesser towers on its flanks, most of them upwind, where the cell grows.
fn turrets(place: Vec2, height: f32) -> f32 {
    let inside = |[x, y, radius, top]: [f32; 4]| {
        let beside = (Vec2::new(x, y) + Vec2::new(0.05 * height, 0.0) - place).length();
        // Each ends in a dome.
        let dome = top - 0.5 * radius * (beside / radius).powi(2);
        ((radius - beside) / TOWER_WIDTH).min((dome - height) / 0.15)
    };
    TURRETS.into_iter().map(inside).fold(f32::NEG_INFINITY, f32::max)
}

/// East and north of the square's middle, radius, and top as a share of the height.
const TURRETS: [[f32; 4]; 6] = [
    [-0.275, -0.040, 0.055, 0.50],
    [-0.250, 0.075, 0.050, 0.40],
    [-0.180, -0.115, 0.060, 0.58],
    [-0.100, -0.125, 0.050, 0.34],
    [-0.120, 0.110, 0.060, 0.66],
    [-0.320, 0.020, 0.040, 0.26],
];

/// The same for the anvil: a lens from an edge upwind of the tower far downwind of it.
fn anvil(place: Vec2, height: f32) -> f32 {
    let along = place.x + 0.10;
    let length = if along > 0.0 { 0.53 } else { 0.25 };
    // It widens downwind.
    let width = 0.22 + 0.16 * smoothstep(-0.1, 0.4, along);
    let out = Vec2::new(along / length, place.y / width).length();
    let top = 0.885 - 0.02 * out;
    let bottom = 0.62 + 0.22 * smoothstep(0.0, 1.0, out);
    let lens = ((top - height) / 0.05).min((height - bottom) / 0.16);
    ((1.0 - out) * 1.6).min(lens.min(1.0) * 0.6)
}

struct Noise {
    cells: [Cellular; 3],
}

/// Cells of the billows across the square and upwards, coarse to fine: three voxels wide at least.
const BILLOWS: [([u32; 3], f32); 3] = [([12, 12, 4], 0.52), ([29, 29, 9], 0.31), ([61, 61, 16], 0.17)];
/// How far billows move the tower's edge, in its widths.
const ROUGHNESS: f32 = 0.55;

impl Noise {
    fn new() -> Self {
        let cells = std::array::from_fn(|i| {
            let [nx, ny, nz] = BILLOWS[i].0;
            Cellular::new([nx, ny, nz + 1], SEED + i as u32)
        });
        Self { cells }
    }

    /// Heaps, -0.5 to 0.5 of their amplitude.
    fn billows(&self, p: Vec3) -> f32 {
        let bend = 0.02
            * Vec3::new(
                fractal(p * Vec3::new(9.0, 9.0, 4.0), [9, 9, 5], 2, SEED + 7),
                fractal(p * Vec3::new(9.0, 9.0, 4.0), [9, 9, 5], 2, SEED + 8),
                0.0,
            );
        let p = p + bend;
        let sum: f32 = BILLOWS
            .iter()
            .zip(&self.cells)
            .map(|(([nx, ny, nz], weight), cells)| {
                let near = cells.nearest(p * Vec3::new(*nx as f32, *ny as f32, *nz as f32));
                weight * (0.5 - near.min(1.0))
            })
            .sum();
        ROUGHNESS * sum
    }

    /// Streaks along the wind.
    fn fibres(&self, p: Vec3) -> f32 {
        0.10 * fractal(p * Vec3::new(7.0, 26.0, 2.0), [7, 26, 3], 4, SEED + 20)
            + 0.22 * fractal(p * Vec3::new(6.0, 8.0, 1.0), [6, 8, 2], 3, SEED + 21)
    }
}

/// The greater of two, their corner rounded over a width (polynomial; Quilez).
fn smooth_max(a: f32, b: f32, width: f32) -> f32 {
    let h = (width - (a - b).abs()).max(0.0) / width;
    a.max(b) + 0.25 * h * h * width
}

/// Hermite step from 0 at `low` to 1 at `high`.
fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clouds::density::DensityVolume;

    fn at(shape: &[u8], x: usize, y: usize, z: usize) -> f32 {
        f32::from(shape[x + (y + z * WIDTH) * WIDTH]) / 255.0
    }

    #[test]
    fn tower_anvil_and_dome_are_where_they_belong_and_the_sides_are_clear() {
        let shape = &DensityVolume::of(CloudKind::StormCell).shape;
        let (middle, tower) = (WIDTH / 2, WIDTH * 35 / 100);
        let cloud = |x, y, z| at(shape, x, y, z) > GROWN;
        let level = |share: f32| (share * HEIGHT as f32) as usize;
        // Up the tower's axis there is cloud from the base to above the anvil's top.
        assert!((2..level(0.90)).all(|z| cloud(tower, middle, z)));
        // Far downwind there is cloud at the anvil's height alone.
        let far = WIDTH * 80 / 100;
        assert!(cloud(far, middle, level(0.86)));
        assert!((0..level(0.6)).all(|z| !cloud(far, middle, z)));
        // The anvil reaches further downwind than upwind, and further than the tower at half its height is wide.
        let extent = |z: usize, x: usize| (0..WIDTH).filter(|y| cloud(x, *y, z)).count();
        assert!(extent(level(0.86), far) > 3 * extent(level(0.45), tower) / 2);
        let upwind = (0..tower).filter(|x| cloud(*x, middle, level(0.86))).count();
        let downwind = (tower..WIDTH).filter(|x| cloud(*x, middle, level(0.86))).count();
        assert!(downwind > 2 * upwind, "{upwind} {downwind}");
        for z in 0..HEIGHT {
            for i in 0..WIDTH {
                for (x, y) in [(i, 0), (i, WIDTH - 1), (0, i), (WIDTH - 1, i)] {
                    assert_eq!(at(shape, x, y, z), 0.0, "{x} {y} {z}");
                }
            }
        }
    }

    #[test]
    fn it_grows_from_nothing_upwards_and_then_outwards() {
        let covers: Vec<f32> = (0..=10).map(|k| cover(k as f32 / 10.0)).collect();
        assert!(covers[0] == 0.0 && covers.windows(2).all(|w| w[0] <= w[1]), "{covers:?}");
        // An anvil of a third to two thirds of its square.
        assert!((0.25..0.7).contains(&covers[10]), "{covers:?}");
        let shape = &DensityVolume::of(CloudKind::StormCell).shape;
        let top = |growth: f32| {
            let theta = threshold(growth).offset;
            (0..HEIGHT).rev().find(|z| (0..WIDTH * WIDTH).any(|i| at(shape, i % WIDTH, i / WIDTH, *z) > theta))
        };
        assert!(top(0.3) <= top(0.6) && top(0.6) <= top(1.0) && top(1.0) >= Some(HEIGHT * 9 / 10));
    }
}
