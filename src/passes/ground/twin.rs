//! Twin of `ground.wgsl`: luminance of the ground where a ray meets it.

use super::Ground;
use crate::clouds::modulation;
use crate::passes::common::{CHARTS, Camera, chart_weights, smoothstep, stereographic};
use crate::passes::deck::FLASH_CAP_M;
use crate::passes::sampling::map_repeat;
use glam::{Vec2, Vec3};

/// Range at which a ray meets the ground; infinite if it does not.
pub fn range(camera: &Camera, direction: Vec3) -> f32 {
    if camera.eye_m <= 0.0 { f32::INFINITY } else { camera.crossings(direction.z, 0.0).0 }
}

/// Luminance of the ground at range `t_m` along a ray, cd/m2 per colour, without the air in between. `passed` is the
/// share of the light source that comes through the clouds.
pub fn luminance(ground: &Ground, map: &[u8], camera: &Camera, direction: Vec3, t_m: f32, passed: f32) -> Vec3 {
    let p = direction * t_m + Vec3::new(0.0, 0.0, camera.eye_m);
    let normal = (p + Vec3::new(0.0, 0.0, camera.earth_m)) / camera.earth_m;
    let z = stereographic(p, camera.earth_m, camera.earth_m);
    let weights = chart_weights(&ground.chart, ground.charts, normal * camera.earth_m, camera.earth_m);
    let places: [Vec2; CHARTS] = std::array::from_fn(|i| {
        let chart = &ground.chart[i];
        Vec2::from(chart.map_origin) + modulation::coordinates(chart.displacement(z))
    });
    let at = |scale: f32, offset: f32| {
        let mut sum = 0.0;
        for i in 0..ground.charts as usize {
            if weights[i] > 0.0 {
                let q = places[i] * scale + Vec2::splat(offset);
                sum += weights[i] * map_repeat(map, modulation::WIDTH, q.x, q.y);
            }
        }
        sum
    };
    // Footprint of a pixel on the ground: finer detail than that is averaged away.
    let footprint = t_m * t_m / camera.eye_m.max(10.0) * Vec3::from(camera.up).length() * 2.0 / camera.height_px;
    let fade = |texel: f32| 1.0 - smoothstep(0.5 * texel, 2.0 * texel, footprint);
    let detail = |scale: f32, offset: f32, fade: f32| if fade > 0.0 { fade * (at(scale, offset) - 0.5) } else { 0.0 };
    let sea = 1.0 - smoothstep(0.405, 0.415, at(1.0, 0.0) + 0.03 * detail(8.0, 0.37, fade(2_000.0)));
    let fields = detail(5.0, 0.61, fade(160.0)) + 0.7 * detail(20.0, 0.17, fade(40.0));
    let relief = detail(3.0, 0.83, fade(800.0));
    let land = Vec3::new(0.125, 0.135, 0.070)
        + Vec3::new(0.085, 0.060, 0.035) * fields
        + Vec3::new(0.03, 0.035, 0.02) * relief;
    let albedo = land + (Vec3::new(0.012, 0.030, 0.045) - land) * sea;
    let light = Vec3::from(ground.light_direction);
    let direct = normal.dot(light).max(0.0) * passed;
    let mut lit = Vec3::from(ground.light_lux) * direct + Vec3::from(ground.sky_lux);
    for flash in &ground.flash[..ground.flashes as usize] {
        let towards = Vec3::from(flash.position_m) - p;
        let d2 = towards.length_squared().max(FLASH_CAP_M * FLASH_CAP_M);
        let cos = (normal.dot(towards) / d2.sqrt()).max(0.0);
        lit += Vec3::new(0.80, 0.90, 1.25) * (12.566_37 * flash.intensity * cos / d2);
    }
    let mut seen = lit * albedo * std::f32::consts::FRAC_1_PI;
    // The sea also mirrors sky and sun (Schlick's Fresnel term; the sun's glitter as a broad lobe).
    let facing = (-direction.dot(normal)).clamp(0.0, 1.0);
    let fresnel = 0.02 + 0.6 * (1.0 - facing).powi(5);
    let half = (light - direction).normalize_or(Vec3::Z);
    let glitter = half.dot(normal).max(0.0).powi(220) * 2.5 * passed * fresnel;
    let mirrored =
        Vec3::from(ground.sky_lux) * (std::f32::consts::FRAC_1_PI * fresnel) + Vec3::from(ground.light_lux) * glitter;
    seen += mirrored * sea;
    if ground.city_luminance > 0.0 {
        let towns = smoothstep(0.86, 0.97, at(9.0, 0.29)) * (1.0 - sea) * (0.35 + 0.65 * at(60.0, 0.71));
        seen += Vec3::new(1.0, 0.72, 0.42) * (ground.city_luminance * towns);
    }
    seen
}
