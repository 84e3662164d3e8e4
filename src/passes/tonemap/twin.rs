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

/// Rational fit of the ACES reference tone curve (Narkowicz 2015). The fit is brighter than the curve by 1 / 0.6; the factor
/// takes half of that back, by eye, so that sunlit cloud keeps its shading.
pub fn filmic(c: Vec3) -> Vec3 {
    let x = c * 0.75;
    (x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)).clamp(Vec3::ZERO, Vec3::ONE)
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
        assert_eq!(tonemap(Vec3::splat(50.0), 3, 4), [255; 4]);
        let curve: Vec<f32> = (0..1000).map(|i| filmic(Vec3::splat(i as f32 * 0.01)).x).collect();
        assert!(curve.windows(2).all(|w| w[1] >= w[0]));
    }

    #[test]
    fn srgb_has_its_published_value_at_middle_grey() {
        // IEC 61966-2-1: linear 0.2140 is code 127.5 / 255.
        assert!((srgb(0.2140) - 0.5).abs() < 1e-3);
    }
}
