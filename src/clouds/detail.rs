//! Detail finer than a voxel: 64^3 bytes of billows that erode and heap up edges, used where pixels are fine enough to see it.
//!
//! *What it is.* Round heaps with sharp creases between them (cellular noise squared, three sizes), bent sideways so that no
//! lattice shows. Its mean is [`MEAN`]: heaps rise less over it than creases fall below, and so a bound on a look that knows
//! no detail has little to add.
//! *How we read it back.* Trilinear, wrapping along all axes, in periods that each genus has for itself.

use crate::numeric::noise::{Cellular, fractal};
use glam::Vec3;
use rayon::prelude::*;
use std::sync::LazyLock;

/// Voxels along each axis.
pub const WIDTH: usize = 64;
/// Mean of the values as shares of 255: what a place has that detail leaves as it is.
pub const MEAN: f32 = 0.62;
/// Heaps along each axis, and their parts. The smallest are 2.7 voxels wide.
const SIZES: [(u32, f32); 3] = [(6, 0.50), (12, 0.30), (24, 0.20)];
/// What heaps are drawn out by: values keep within a byte but for a few in a thousand.
const CONTRAST: f32 = 1.15;

/// The volume: `WIDTH^3` bytes, x fastest, z slowest, wrapping along all axes.
pub fn volume() -> &'static [u8] {
    static VOLUME: LazyLock<Vec<u8>> = LazyLock::new(build);
    &VOLUME
}

fn build() -> Vec<u8> {
    let cells: Vec<Cellular> = (51..).zip(SIZES).map(|(seed, (n, _))| Cellular::new([n; 3], seed)).collect();
    let heap = |i: usize| -> f32 {
        let p =
            Vec3::new((i % WIDTH) as f32, ((i / WIDTH) % WIDTH) as f32, (i / (WIDTH * WIDTH)) as f32) / WIDTH as f32;
        let bend = [55, 56, 57].map(|seed| fractal(p * 5.0, [5; 3], 2, seed));
        let p = p + Vec3::from(bend) * 0.06;
        cells.iter().zip(SIZES).map(|(cells, (n, part))| part * cells.nearest(p * n as f32).powi(2)).sum()
    };
    let creases: Vec<f32> = (0..WIDTH * WIDTH * WIDTH).into_par_iter().map(heap).collect();
    // One sum in one order, whatever the number of threads.
    let mean = (creases.iter().map(|v| f64::from(*v)).sum::<f64>() / creases.len() as f64) as f32;
    let byte = |crease: &f32| ((MEAN + CONTRAST * (mean - crease)).clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    creases.iter().map(byte).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn detail_takes_as_much_as_it_gives_and_heaps_are_flatter_than_creases_deep() {
        let values = volume();
        let count = values.len() as f64;
        let mean = values.iter().map(|v| f64::from(*v)).sum::<f64>() / count / 255.0;
        // Of the creases a few are cut off at 0.
        assert!((mean - f64::from(MEAN)).abs() < 0.003, "{mean}");
        let spread = (values.iter().map(|v| (f64::from(*v) / 255.0 - mean).powi(2)).sum::<f64>() / count).sqrt();
        assert!((0.08..0.25).contains(&spread), "{spread}");
        let cut = values.iter().filter(|v| [0, 255].contains(*v)).count();
        assert!(cut * 200 < values.len(), "{cut} values are cut off");
    }
}
