//! The density volume of a genus: 256 x 256 x 32 shape values that tile every 16 km.
//!
//! *What it is.* A share from 0 to 1 per voxel (the deck paper's `T3D.a`); cloud is where it exceeds theta.
//! *How we compute it.* Cellular and gradient noise for the elements, finer noise that erodes them, and a vertical
//! profile that is subtracted, so that a lower theta gives wider *and* taller clouds.
//! *How we store it.* One byte a voxel, x fastest, then y, then z upwards.
//! *How we read it back.* Trilinear, wrapping in x and y, clamped in z (voxel centres at (k + 0.5) / 32 of the thickness).

use super::cell;
use super::kind::CloudKind;
use crate::numeric::noise::{Cellular, fractal, gradient};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::sync::{Arc, LazyLock, Mutex};

/// Voxels east and north.
pub const WIDTH: usize = 256;
/// Voxels upwards.
pub const HEIGHT: usize = 32;
/// Period of the tile east and north.
pub const TILE_M: f32 = 16_000.0;

/// How much lower theta may be in an anvil for the same width: what makes it wider than what it stands on.
const ANVIL_SPREAD: f32 = 0.16;

/// Shape values of one genus, `WIDTH * WIDTH * HEIGHT` bytes, x fastest, z slowest.
pub struct DensityVolume {
    /// Shape value times 255.
    pub shape: Vec<u8>,
}

impl DensityVolume {
    /// The volume of a genus, built at first use and kept (2 MiB each).
    pub fn of(kind: CloudKind) -> Arc<Self> {
        static KEPT: LazyLock<[Mutex<Option<Arc<DensityVolume>>>; CloudKind::COUNT]> =
            LazyLock::new(|| std::array::from_fn(|_| Mutex::new(None)));
        let mut kept = KEPT[kind.index()].lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        kept.get_or_insert_with(|| Arc::new(Self::build(kind))).clone()
    }

    fn build(kind: CloudKind) -> Self {
        if kind == CloudKind::StormCell {
            return Self { shape: cell::shape() };
        }
        let look = kind.appearance();
        let seed = 100 * (kind.index() as u32 + 1);
        let [nx, ny] = look.elements;
        let thickness = look.usual_thickness_m / TILE_M;
        // Elements are as tall as they are wide where the layer is thick enough, but at least one fits in it.
        let nz = ((nx.max(ny) as f32 * thickness).round() as u32).max(1);
        // Elements across the tile of the finer octaves, none smaller than three voxels, which the volume could not hold.
        let finer = |factor: u32| [nx, ny].map(|n| (factor * n + 1).min(WIDTH as u32 / 3).max(n));
        let ([mx, my], [fx, fy]) = (finer(2), finer(4));
        let coarse = Cellular::new([nx, ny, nz + 1], seed);
        let middle = Cellular::new([mx, my, 2 * nz + 1], seed + 1);
        let fine = Cellular::new([fx, fy, 4 * nz + 1], seed + 2);
        let mut shape = vec![0u8; WIDTH * WIDTH * HEIGHT];
        shape.par_chunks_mut(WIDTH).enumerate().for_each(|(row, out)| {
            let (y, z) = (row % WIDTH, row / WIDTH);
            let height = (z as f32 + 0.5) / HEIGHT as f32;
            for (x, voxel) in out.iter_mut().enumerate() {
                let at = Vec2::new((x as f32 + 0.5) / WIDTH as f32, (y as f32 + 0.5) / WIDTH as f32);
                // The lattice of a coarser octave is not sheared against that of a finer one, so warp the plane a little.
                let bend = 0.35 / nx as f32;
                let warp = Vec2::new(
                    fractal(at.extend(0.0) * nx as f32, [nx, nx, 1], 2, seed + 7),
                    fractal(at.extend(0.5) * nx as f32, [nx, nx, 1], 2, seed + 8),
                ) * bend;
                // An anvil spreads from what stands below it, smooth and wider than that.
                let aloft = look.anvil * smoothstep(0.66, 0.82, height);
                let p = (at + warp).extend(height);
                let stem = (at + warp).extend(height.min(height + (0.7 - height) * aloft));
                let billow = |cells: &Cellular, n: Vec3| 1.0 - cells.nearest(stem * n).min(1.0);
                let n1 = Vec3::new(nx as f32, ny as f32, nz as f32 * 0.999);
                let n2 = Vec3::new(mx as f32, my as f32, 2.0 * nz as f32);
                let n4 = Vec3::new(fx as f32, fy as f32, 4.0 * nz as f32);
                // Towers stand on their base: large heaps reach upwards.
                let tall = Vec3::new(1.0, 1.0, 1.0 - look.columnar);
                let heaps = 0.60 * billow(&coarse, n1 * tall) + 0.27 * billow(&middle, n2) + 0.13 * billow(&fine, n4);
                let sheet = 0.5 + 0.9 * fractal(p * n1, [nx, ny, nz + 1], 4, seed + 3);
                let eroding = fractal(p * n4, [fx, fy, 4 * nz + 1], 3, seed + 4);
                let body = sheet + look.heaped * (1.25 * heaps - sheet) + look.erosion * (1.0 - 0.6 * aloft) * eroding;
                let body = body + ANVIL_SPREAD * aloft;
                let body = if look.fibrous > 0.0 {
                    let trail = TRAIL * (1.0 - height) * thickness;
                    let streaks = streaks(Vec3::new(p.x + trail, p.y, height), [nx, ny], seed + 11);
                    body + look.fibrous * (0.5 * sheet + streaks - body)
                } else {
                    body
                };
                let value = body - penalty(&look, height);
                *voxel = (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
            }
        });
        Self { shape }
    }
}

/// How far fibres trail behind where they begin, in falls: ice falls into slower air below.
const TRAIL: f32 = 2.0;

/// Fibres drawn out along x, of three widths: the crests of gradient noise, which hardly change upwards, 0 to 0.5.
fn streaks(p: Vec3, [nx, ny]: [u32; 2], seed: u32) -> f32 {
    let octave = |k: u32| {
        let (x, y) = (nx << k, ny << (k + 1));
        let noise = gradient(Vec3::new(p.x * x as f32, p.y * y as f32, 0.6 * p.z), [x, y, 4], seed + k);
        1.0 - (3.0 * noise.abs()).min(1.0)
    };
    0.5 * (0.45 * octave(0) + 0.33 * octave(1) + 0.22 * octave(2))
}

/// What the vertical profile takes away at a height share of 0 (base) to 1 (top).
fn penalty(look: &super::kind::Appearance, height: f32) -> f32 {
    let below = (1.0 - height / look.base_softness).max(0.0);
    let above = (1.0 - (1.0 - height) / look.top_softness).max(0.0);
    look.taper * height.powf(1.3) + 0.9 * below * below + 0.8 * above * above
}

/// Hermite step from 0 at `low` to 1 at `high`.
fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_genus_has_structure_and_closes_at_base_and_top() {
        for kind in [CloudKind::Cumulus, CloudKind::Stratus, CloudKind::Cirrus] {
            let volume = DensityVolume::of(kind);
            let mean = |z: usize| {
                let slice = &volume.shape[z * WIDTH * WIDTH..][..WIDTH * WIDTH];
                slice.iter().map(|v| f64::from(*v)).sum::<f64>() / (255 * WIDTH * WIDTH) as f64
            };
            assert!(mean(0) < 0.5 * mean(12), "{kind:?}: base {} middle {}", mean(0), mean(12));
            assert!(mean(HEIGHT - 1) < 0.5 * mean(12), "{kind:?}: top {}", mean(HEIGHT - 1));
            let (low, high) = volume.shape.iter().fold((255u8, 0u8), |(low, high), v| (low.min(*v), high.max(*v)));
            assert!(high > 150 && low < 30, "{kind:?}: {low}..{high}");
        }
    }
}
