//! Twin of `lamps.wgsl`: the lamps of cities, single ones as far as a pixel can tell them apart.
//!
//! *What it is.* A pattern around 1 that the mean luminance of a place is multiplied by: one lamp in each cell of a lattice, larger
//! cells farther away. *How it is read.* A pixel's footprint is much longer than wide where the eye is low. As wide as it is long,
//! lamps were drawn out into streaks across the picture; so up to [`ALONG`] looks lie along it, each as wide as the footprint is, or
//! as it is long over their number.

use super::twin::{Patterns, hash2};
use glam::{IVec2, UVec2, Vec2, Vec3};
use std::f32::consts::PI;

/// Cells of the finest lamps, how many of a cell's sides a pixel may span, a lamp's spread in its cell, and a period of the cells.
const LAMP_M: f32 = 64.0;
const LAMP_CELLS: f32 = 0.45;
const LAMP_SPREAD: f32 = 0.11;
const LAMP_PERIOD: i32 = 1_024;
/// How far streets are bent, m.
const STREETS_M: f32 = 80.0;
/// Looks along a footprint at most.
pub const ALONG: f32 = 10.0;

/// Lamps about a place of the first chart, 1 in the mean, of a pixel whose footprint reaches over `along_m` of the chart and is `across_m`
/// wide: one in each cell, the cells as large as a look can tell apart.
pub(super) fn lamps(place_m: Vec2, along_m: Vec2, across_m: f32, patterns: &Patterns) -> Vec3 {
    let long_m = along_m.length();
    let width_m = across_m.max(long_m * (1.0 / ALONG));
    let looks = (long_m / width_m).ceil().clamp(1.0, ALONG);
    let size = (width_m * (1.0 / LAMP_CELLS)).max(LAMP_M);
    let octave = (size * (1.0 / LAMP_M)).log2().max(0.0);
    let low = octave.floor();
    let mut light = Vec3::ZERO;
    for look in 0..looks as u32 {
        let at = place_m + along_m * ((look as f32 + 0.5) / looks - 0.5);
        let at = at + bent(at);
        let of = |octave: u32| lamps_of(at, octave, width_m);
        light += of(low as u32).lerp(of(low as u32 + 1), octave - low);
    }
    // Streets and squares gather lamps, parks have none.
    let district = 1.0 + 2.2 * patterns.detail(20.0, 0.71, 40.0);
    light * (district.clamp(0.1, 2.2) / looks)
}

/// The error function (Winitzki 2008, within 2e-4).
fn error_function(x: f32) -> f32 {
    let squared = x * x;
    let inner = -squared * (1.273_239_5 + 0.147 * squared) / (1.0 + 0.147 * squared);
    x.signum() * (1.0 - inner.exp()).max(0.0).sqrt()
}

/// Streets bend: waves of the charts' period, made of parabolas, which every device computes alike. (A map that is sampled is not: its
/// weights of 8 bits moved lamps by half a metre.)
fn bent(place_m: Vec2) -> Vec2 {
    let p = place_m * (1.0 / (LAMP_M * LAMP_PERIOD as f32));
    let wave = |east: f32, north: f32| {
        let phase = east * p.x + north * p.y;
        let f = phase - (phase + 0.5).floor();
        f * (8.0 - 16.0 * f.abs())
    };
    let broad = Vec2::new(wave(37.0, 22.0), wave(-25.0, 41.0));
    (broad + 0.5 * Vec2::new(wave(83.0, -61.0), wave(59.0, 97.0))) * STREETS_M
}

/// Lamps of one size of cells, which is 64 m times two to the power of `octave`.
fn lamps_of(place_m: Vec2, octave: u32, footprint_m: f32) -> Vec3 {
    let size = LAMP_M * (1u32 << octave.min(24)) as f32;
    let at = place_m / size;
    let cell = at.floor();
    // As many cells as the charts' period holds, so that it does not show.
    let period = (LAMP_PERIOD >> octave.min(10)).max(1);
    let lot = (cell.as_ivec2() & IVec2::splat(period - 1)).as_uvec2() + UVec2::new(octave * 4_096, 77);
    let jitter = hash2(lot);
    let kind = hash2(lot + 8_191);
    let middle = (jitter - Vec2::splat(0.5)) * 0.55;
    let away = at - cell - Vec2::splat(0.5) - middle;
    // Gaussian spots, as wide as the pixel blurs them (a square has the variance f^2 / 12 each way), whose mean over the cell is 1;
    // brighter and fainter ones, warmer and whiter ones.
    let blur = footprint_m / size;
    let spread = (LAMP_SPREAD * LAMP_SPREAD + blur * blur * (1.0 / 6.0)).sqrt();
    let within =
        |middle: f32| 0.5 * (error_function((0.5 - middle) / spread) + error_function((0.5 + middle) / spread));
    let inside = within(middle.x) * within(middle.y);
    let spot = (-away.length_squared() / (spread * spread)).exp() / (PI * spread * spread * inside);
    let bright = 2.5 * kind.x * kind.x + 0.167;
    // The larger the cell the more lamps it stands for, the less they differ.
    let rough = 0.85 / (1.0 + 0.35 * octave as f32);
    let colour = Vec3::new(1.0, 0.66, 0.34).lerp(Vec3::new(0.95, 0.86, 0.72), kind.y);
    colour * (1.0 + (spot * bright - 1.0) * rough)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lamps_keep_their_light_however_a_pixel_lies() {
        // Pixels from 1 to 28 m (the widest of the finest cells) in even grids over the same 32 x 32 cells.
        let whole_m = 32.0 * LAMP_M;
        let mean = |footprint_m: f32, shift_m: f32| {
            let count = (whole_m / footprint_m).round() as usize;
            let step_m = whole_m / count as f32;
            let at = |i: usize| (i as f32 + 0.5) * step_m + shift_m;
            let all = (0..count * count).map(|i| lamps_of(Vec2::new(at(i % count), at(i / count)), 0, step_m).y);
            all.map(f64::from).sum::<f64>() / (count * count) as f64
        };
        let fine = mean(4.0, 0.0);
        for footprint_m in [8.0, 14.0, 20.0, 28.0] {
            for shift_m in [0.0, 3.0, 9.0] {
                // A Gaussian stands for a square pixel, cut at its cell's sides: 3 %.
                let found = mean(footprint_m, shift_m);
                assert!((found / fine - 1.0).abs() < 0.03, "{footprint_m} {shift_m}: {found}, {fine}");
            }
        }
        // As it was, spots of 7 m looked at every 28 m: the same light only by chance.
        let point = |shift_m: f32| {
            let at = |i: usize| (i as f32 + 0.5) * 28.0 + shift_m;
            (0..73 * 73).map(|i| f64::from(lamps_of(Vec2::new(at(i % 73), at(i / 73)), 0, 0.0).y)).sum::<f64>()
        };
        assert!((point(0.0) / point(9.0) - 1.0).abs() > 0.005, "the measure tells the two apart");
    }

    #[test]
    fn the_error_function_is_that_of_the_tables() {
        // Abramowitz and Stegun 1964, table 7.1.
        for (x, expected) in
            [(0.0, 0.0), (0.25, 0.276_326_4), (0.5, 0.520_499_9), (1.0, 0.842_700_8), (2.0, 0.995_322_3)]
        {
            assert!((error_function(x) - expected).abs() < 2e-4 && (error_function(-x) + expected).abs() < 2e-4, "{x}");
        }
    }
}
