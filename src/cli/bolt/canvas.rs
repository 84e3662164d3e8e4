//! A small picture of light: lines drawn in linear light, glow about them, tone mapping.
//!
//! For `stormdeck bolt` alone: the renderer draws flashes with its own passes.

use super::text::dots;
use crate::lightning::shape::{Line, Point};

/// Linear light of one channel, with a background.
pub(super) struct Canvas {
    pub width: usize,
    pub height: usize,
    light: Vec<f32>,
    background: Vec<[f32; 3]>,
}

/// Standard deviations of the glow's Gaussians, as shares of the picture's height, with their weights: near the channel the air
/// scatters much, far from it little but everywhere.
const GLOW: [(f32, f32); 4] = [(0.0015, 0.5), (0.006, 0.32), (0.025, 0.30), (0.1, 0.45)];
/// Linear colour of the channel: a black body of about 24,000 K.
const CHANNEL: [f32; 3] = [0.82, 0.88, 1.0];
/// Linear colour of its glow: bluer, as small particles scatter it.
const AIR: [f32; 3] = [0.42, 0.50, 1.0];
/// Light of the main channel against display white: far above it, so that it burns out to white.
const CHANNEL_LIGHT: f32 = 7.0;
const GLOW_LIGHT: f32 = 2.4;
/// A line thinner than this (half width in pixels) is drawn as wide and fainter.
const THINNEST_PX: f64 = 0.55;
/// Half width of the main channel as a share of the picture's height.
const HALF_WIDTH: f64 = 0.0013;

impl Canvas {
    /// A night sky over dark ground; `horizon` is the share of the height at which the ground begins.
    pub fn night(width: usize, height: usize, horizon: f64) -> Self {
        let edge = horizon * height as f64;
        let row = |y: usize| {
            let y = y as f64 + 0.5;
            let low = (y / edge.max(1.0)).min(1.0) as f32;
            let sky = [0.006, 0.009, 0.022].map(|c: f32| c * (0.7 + 1.9 * low * low));
            if y < edge { sky } else { [0.0035, 0.0040, 0.0050] }
        };
        let background = (0..height).flat_map(|y| std::iter::repeat_n(row(y), width)).collect();
        Self { width, height, light: vec![0.0; width * height], background }
    }

    /// Draws lines; `project` gives pixels and the scale of widths there, or nothing for what is not in view.
    pub fn lines(&mut self, lines: &[Line], project: impl Fn([f64; 3]) -> Option<([f64; 2], f64)>) {
        let half_width = HALF_WIDTH * self.height as f64;
        for line in lines {
            for pair in line.points.windows(2) {
                let end = |point: &Point| {
                    let (place, scale) = project(point.position_m)?;
                    Some((place, half_width * scale * point.thickness, point.brightness))
                };
                if let (Some(a), Some(b)) = (end(&pair[0]), end(&pair[1])) {
                    self.segment(a, b);
                }
            }
        }
    }

    /// A segment with a Gaussian profile; where segments meet the greater light counts, so that joints do not show.
    fn segment(&mut self, (a, half_a, light_a): ([f64; 2], f64, f64), (b, half_b, light_b): ([f64; 2], f64, f64)) {
        let widest = 3.0 * half_a.max(half_b).max(THINNEST_PX);
        let span = |low: f64, high: f64, size: usize| {
            (low - widest).floor().clamp(0.0, size as f64) as usize
                ..(high + widest).ceil().clamp(0.0, size as f64) as usize
        };
        let d = [b[0] - a[0], b[1] - a[1]];
        let squared = (d[0] * d[0] + d[1] * d[1]).max(1e-12);
        for y in span(a[1].min(b[1]), a[1].max(b[1]), self.height) {
            for x in span(a[0].min(b[0]), a[0].max(b[0]), self.width) {
                let p = [x as f64 + 0.5 - a[0], y as f64 + 0.5 - a[1]];
                let t = ((p[0] * d[0] + p[1] * d[1]) / squared).clamp(0.0, 1.0);
                let away = [p[0] - t * d[0], p[1] - t * d[1]];
                let half = half_a + (half_b - half_a) * t;
                let drawn = half.max(THINNEST_PX);
                let light = (light_a + (light_b - light_a) * t) * half / drawn;
                let value = light * (-(away[0] * away[0] + away[1] * away[1]) / (drawn * drawn)).exp();
                let pixel = &mut self.light[y * self.width + x];
                *pixel = pixel.max(value as f32);
            }
        }
    }

    /// The picture: glow, tone mapping, 8-bit sRGB with alpha.
    pub fn finish(&self) -> Vec<u8> {
        let mut glow = vec![0.0; self.light.len()];
        for (share, weight) in GLOW {
            let sigma = share * self.height as f32;
            let blurred = blurred(&self.light, self.width, self.height, sigma);
            // A blurred line loses light with the width of the blur: weigh it back, so that `weight` is what is seen.
            let gain = weight * (sigma / (HALF_WIDTH as f32 * self.height as f32)).max(1.0);
            glow.iter_mut().zip(&blurred).for_each(|(sum, value)| *sum += gain.sqrt() * weight.sqrt() * value);
        }
        let mut out = Vec::with_capacity(4 * self.light.len());
        for ((light, glow), background) in self.light.iter().zip(&glow).zip(&self.background) {
            for channel in 0..3 {
                let linear = background[channel]
                    + CHANNEL_LIGHT * CHANNEL[channel] * light
                    + GLOW_LIGHT * AIR[channel] * glow * (1.0 + 20.0 * background[channel]);
                out.push(srgb(1.0 - (-linear).exp()));
            }
            out.push(255);
        }
        out
    }

    /// Writes a text into the background; `scale` is the size of a dot in pixels.
    pub fn text(&mut self, [left, top]: [usize; 2], scale: usize, text: &str, colour: [f32; 3]) {
        for (column, row) in dots(text) {
            let (x, y) = (left + column * scale, top + row * scale);
            self.fill([x, y, (x + scale).min(self.width), y + scale], colour);
        }
    }

    /// Fills a rectangle of the background; for pictures of fields.
    pub fn fill(&mut self, [x0, y0, x1, y1]: [usize; 4], colour: [f32; 3]) {
        for y in y0..y1.min(self.height) {
            for x in x0..x1.min(self.width) {
                self.background[y * self.width + x] = colour;
            }
        }
    }
}

fn srgb(linear: f32) -> u8 {
    let x = linear.clamp(0.0, 1.0);
    let encoded = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0 + 0.5) as u8
}

/// A Gaussian blur in two passes; wide ones at a quarter of the size, and a quarter of that.
fn blurred(light: &[f32], width: usize, height: usize, sigma: f32) -> Vec<f32> {
    const WIDEST: f32 = 8.0;
    if sigma <= WIDEST || width < 8 || height < 8 {
        let across = blur_rows(light, width, height, sigma);
        return transposed(&blur_rows(&transposed(&across, width, height), height, width, sigma), height, width);
    }
    let (small_width, small_height) = (width.div_ceil(4), height.div_ceil(4));
    let mut small = vec![0.0; small_width * small_height];
    for y in 0..height {
        for x in 0..width {
            small[y / 4 * small_width + x / 4] += light[y * width + x] / 16.0;
        }
    }
    let small = blurred(&small, small_width, small_height, sigma / 4.0);
    // Bilinear between the centres of the small picture's pixels.
    let at = |position: usize, size: usize| {
        let p = ((position as f32 + 0.5) / 4.0 - 0.5).clamp(0.0, (size - 1) as f32);
        (p as usize, (p as usize + 1).min(size - 1), p.fract())
    };
    let mut out = Vec::with_capacity(light.len());
    for y in 0..height {
        let (y0, y1, v) = at(y, small_height);
        for x in 0..width {
            let (x0, x1, u) = at(x, small_width);
            let row = |y: usize| small[y * small_width + x0] * (1.0 - u) + small[y * small_width + x1] * u;
            out.push(row(y0) * (1.0 - v) + row(y1) * v);
        }
    }
    out
}

fn blur_rows(light: &[f32], width: usize, height: usize, sigma: f32) -> Vec<f32> {
    let reach = (3.0 * sigma).ceil() as usize;
    let weights: Vec<f32> = (0..=reach).map(|k| (-0.5 * (k as f32 / sigma.max(1e-3)).powi(2)).exp()).collect();
    let total: f32 = weights[0] + 2.0 * weights[1..].iter().sum::<f32>();
    let mut out = vec![0.0; light.len()];
    let mut padded = vec![0.0; width + 2 * reach];
    for y in 0..height {
        padded[reach..reach + width].copy_from_slice(&light[y * width..(y + 1) * width]);
        let row = &mut out[y * width..(y + 1) * width];
        for (k, weight) in weights.iter().enumerate() {
            let share = weight / total;
            for (x, pixel) in row.iter_mut().enumerate() {
                let sides = padded[reach + x - k] + padded[reach + x + k];
                *pixel += share * if k == 0 { 0.5 * sides } else { sides };
            }
        }
    }
    out
}

fn transposed(values: &[f32], width: usize, height: usize) -> Vec<f32> {
    let mut out = vec![0.0; values.len()];
    for y in 0..height {
        for x in 0..width {
            out[x * height + y] = values[y * width + x];
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_blur_keeps_the_light_and_a_line_is_where_it_should_be() {
        let (width, height) = (96, 80);
        let mut light = vec![0.0; width * height];
        light[40 * width + 48] = 1.0;
        for sigma in [1.0, 4.0, 12.0] {
            let total: f32 = blurred(&light, width, height, sigma).iter().sum();
            // Three standard deviations are kept, 0.3 % of either tail; a wide one also loses what leaves the picture.
            assert!((total - 1.0).abs() < 0.02, "{sigma}: {total}");
        }
        let mut canvas = Canvas::night(width, height, 1.0);
        let point = |x: f64| Point { position_m: [x, 0.0, 0.0], along_m: x, thickness: 1.0, brightness: 1.0 };
        let line = Line { order: 0, parent: None, points: vec![point(10.0), point(80.0)] };
        canvas.lines(&[line], |p| Some(([p[0], 30.5], 1.0)));
        let bytes = canvas.finish();
        let red = |x: usize, y: usize| bytes[4 * (y * width + x)];
        assert!(
            red(45, 30) > 190 && red(45, 36) < 150 && red(45, 70) < 80,
            "{} {} {}",
            red(45, 30),
            red(45, 36),
            red(45, 70)
        );
    }
}
