//! Twin of `tonemap.wgsl`.

use crate::numeric::hash::{pcg3d, unit};
use glam::Vec3;

/// sRGB bytes of an exposed linear colour at a pixel.
pub fn tonemap(linear: Vec3, x: u32, y: u32) -> [u8; 4] {
    let noise = pcg3d(x, y, 0).map(|h| unit(h) - 0.5);
    let c = filmic(linear.max(Vec3::ZERO));
    let code = |value: f32, noise: f32| (srgb(value) * 255.0 + noise + 0.5).clamp(0.0, 255.0) as u8;
    [code(c.x, noise[0]), code(c.y, noise[1]), code(c.z, noise[2]), 255]
}

/// Share by which the channels are drawn towards their mean before the curve, and from it after: bright colours so go to white
/// by way of paler ones of their own hue, where a curve for each channel alone turns every evening sky yellow.
const TOWARDS_MEAN: f32 = 0.2;
/// Light that becomes half of white: with it the curve leaves middle grey, 0.18, where it was.
const HALF: f32 = 0.4946;

/// Naka and Rushton's response (1966), `x^n / (x^n + half^n)` with n = 1.5, on channels that have been drawn together: from black
/// to white ever flatter, so that neither a low sun's haze nor sunlit cloud loses its shape.
pub fn filmic(c: Vec3) -> Vec3 {
    let mean = |v: Vec3| (v.x + v.y + v.z) * (1.0 / 3.0);
    let x = c.lerp(Vec3::splat(mean(c)), TOWARDS_MEAN) * (1.0 / HALF);
    let power = x * x.map(f32::sqrt);
    // Beyond 1e4 nothing but white is left, and infinity is not to become NaN.
    let power = power.min(Vec3::splat(1e6));
    let y = power / (power + 1.0);
    ((y - TOWARDS_MEAN * mean(y)) * (1.0 / (1.0 - TOWARDS_MEAN))).clamp(Vec3::ZERO, Vec3::ONE)
}

fn srgb(v: f32) -> f32 {
    if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn black_stays_black_white_reaches_white_and_more_light_is_never_darker() {
        assert!(tonemap(Vec3::ZERO, 3, 4)[0] <= 1);
        assert_eq!(tonemap(Vec3::splat(1e4), 3, 4), [255; 4]);
        assert_eq!(tonemap(Vec3::splat(f32::MAX), 3, 4), [255; 4]);
        let curve: Vec<f32> = (0..1000).map(|i| filmic(Vec3::splat(i as f32 * 0.01)).x).collect();
        assert!(curve.windows(2).all(|w| w[1] >= w[0]));
    }

    #[test]
    fn middle_grey_stays_and_bright_colours_go_to_white_in_their_own_hue() {
        // HALF has four digits.
        assert!((filmic(Vec3::splat(0.18)) - 0.18).abs().max_element() < 1e-4);
        // An orange evening sky, brighter and brighter: red leads, blue follows, and green never comes up with red.
        let orange = Vec3::new(1.0, 0.6, 0.25);
        let ratio = |light: f32| {
            let c = filmic(orange * light);
            (c.y / c.x, c.z / c.x)
        };
        let lights = [0.1, 0.5, 2.0, 8.0, 30.0];
        assert!(lights.windows(2).all(|w| ratio(w[0]).0 < ratio(w[1]).0 && ratio(w[0]).1 < ratio(w[1]).1));
        // The tester: by the curve alone, without drawing together, blue stays behind and the sky turns yellow.
        let alone = |v: f32| {
            let x = v / HALF * (v / HALF).sqrt();
            x / (x + 1.0)
        };
        let yellow = alone(0.25 * 2.0) / alone(0.6 * 2.0);
        let (green, blue) = ratio(2.0);
        assert!(blue / green > yellow, "{} {yellow}", blue / green);
    }

    #[test]
    fn srgb_has_its_published_value_at_middle_grey() {
        // IEC 61966-2-1: linear 0.2140 is code 127.5 / 255.
        assert!((srgb(0.2140) - 0.5).abs() < 1e-3);
    }
}
