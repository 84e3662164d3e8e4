//! The 2D modulation map (deck paper 5.1): where on 400 km the cloud is denser, so that the 16 km tile is not seen.
//!
//! 512 x 512 bytes, row by row, that repeat. The map is equalised: its values are their own ranks, so that they are
//! uniform in [0, 1] and the coverage that a threshold gives is known (see [`super::coverage`]).

use crate::numeric::noise::fractal;
use glam::Vec2;
use rayon::prelude::*;
use std::sync::LazyLock;

/// Texels east and north.
pub const WIDTH: usize = 512;
/// Period of the map. Against the 16 km tile the ratio is irrational, so the pair never repeats together.
pub const TILE_M: f32 = 400_000.0 * 1.012_354_7;
/// Rotation of the map against the tile: cosine and sine of 0.46 rad.
pub const ROTATION: [f32; 2] = [0.896_052_5, 0.443_948_1];

/// The map: `WIDTH * WIDTH` uniformly distributed bytes.
pub fn map() -> &'static [u8] {
    static MAP: LazyLock<Vec<u8>> = LazyLock::new(build);
    &MAP
}

/// Map coordinates (in periods) of a chart coordinate in metres.
pub fn coordinates(chart_m: Vec2) -> Vec2 {
    let [c, s] = ROTATION;
    Vec2::new(c * chart_m.x - s * chart_m.y, s * chart_m.x + c * chart_m.y) / TILE_M
}

/// How much the map's value changes in a metre at most (a thousandth of all places is steeper).
pub fn steepest_per_m() -> f32 {
    static STEEPEST: LazyLock<f32> = LazyLock::new(|| {
        let map = map();
        let mut counts = [0u32; 512];
        for i in 0..WIDTH * WIDTH {
            let apart = |other: usize| i32::from(map[i]) - i32::from(map[other]);
            let (east, north) = (apart(i / WIDTH * WIDTH + (i + 1) % WIDTH), apart((i + WIDTH) % (WIDTH * WIDTH)));
            counts[((east * east + north * north) as f32).sqrt().ceil() as usize] += 1;
        }
        let mut rest = (WIDTH * WIDTH / 1000) as u32;
        let mut step = 511;
        while counts[step] <= rest {
            rest -= counts[step];
            step -= 1;
        }
        step as f32 / 255.0 * (WIDTH as f32 / TILE_M)
    });
    *STEEPEST
}

fn build() -> Vec<u8> {
    let mut values: Vec<(f32, u32)> = (0..(WIDTH * WIDTH) as u32)
        .into_par_iter()
        .map(|i| {
            let p = Vec2::new((i as usize % WIDTH) as f32, (i as usize / WIDTH) as f32) / WIDTH as f32;
            // Nothing wider than 31 km: places 16 km apart and more would have too much in common.
            let broad = fractal((p * 13.0).extend(0.5), [13, 13, 1], 3, 31);
            let patches = fractal((p * 29.0).extend(0.5), [29, 29, 1], 4, 37);
            (broad + 0.8 * patches, i)
        })
        .collect();
    values.par_sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut map = vec![0u8; WIDTH * WIDTH];
    for (rank, (_, i)) in values.iter().enumerate() {
        map[*i as usize] = (rank * 256 / values.len()) as u8;
    }
    map
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_equally_frequent() {
        let mut counts = [0; 256];
        map().iter().for_each(|v| counts[*v as usize] += 1);
        assert!(counts.iter().all(|n| *n == WIDTH * WIDTH / 256));
    }
}
