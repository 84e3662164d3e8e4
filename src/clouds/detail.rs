//! Detail finer than a voxel: 64^3 bytes of eroding noise that repeat every 1.4 km, used near the eye only.

use crate::numeric::noise::{Cellular, fractal};
use glam::Vec3;
use rayon::prelude::*;
use std::sync::LazyLock;

/// Voxels along each axis.
pub const WIDTH: usize = 64;
/// Period along each axis.
pub const TILE_M: f32 = 1_397.0;

/// The volume: `WIDTH^3` bytes with mean about 127, x fastest, z slowest, wrapping along all axes.
pub fn volume() -> &'static [u8] {
    static VOLUME: LazyLock<Vec<u8>> = LazyLock::new(build);
    &VOLUME
}

fn build() -> Vec<u8> {
    let cells = [Cellular::new([8; 3], 51), Cellular::new([15; 3], 52)];
    (0..WIDTH * WIDTH * WIDTH)
        .into_par_iter()
        .map(|i| {
            let p = Vec3::new((i % WIDTH) as f32, ((i / WIDTH) % WIDTH) as f32, (i / (WIDTH * WIDTH)) as f32)
                / WIDTH as f32;
            let billow = 0.65 * cells[0].nearest(p * 8.0) + 0.35 * cells[1].nearest(p * 15.0);
            let value = 0.5 + 0.9 * (0.5 - billow) + 0.35 * fractal(p * 8.0, [8; 3], 3, 53);
            (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
        })
        .collect()
}
