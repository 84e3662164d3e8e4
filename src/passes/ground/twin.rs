//! Twin of `ground.wgsl`: luminance of the ground where a ray meets it.

use super::lamps::lamps;
use super::{Ground, glow, hills};
use crate::clouds::modulation;
use crate::passes::beams::Lamp;
use crate::passes::beams::twin::shines;
use crate::passes::common::{CHARTS, Camera, chart_weights, smoothstep, stereographic};
use crate::passes::deck::{FLASH_CAP_M, FLASH_COLOUR};
use crate::passes::relief::field::{Grids, level, place};
use crate::passes::relight::{Lits, twin::on_ground};
use crate::passes::sampling::map_repeat;
use crate::passes::sky::lamps::CITY_COLOUR;
use glam::{IVec2, UVec2, Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, PI};

/// Mean albedo of fields far away.
const FIELDS: Vec3 = Vec3::new(0.125, 0.132, 0.062);
/// Fields lie in blocks of this size, of which so many make a period.
const BLOCK_M: f32 = 2_048.0;
const BLOCKS: i32 = 32;
/// Mean square slope of the waves in a wind of 5 m/s (Cox and Munk 1954: 0.003 + 0.00512 U).
const WAVE_SLOPES: f32 = 0.029;

/// Range at which a ray meets the sphere that stands for the Earth; infinite if it does not.
pub fn range(camera: &Camera, direction: Vec3) -> f32 {
    if camera.eye_m <= 0.0 { f32::INFINITY } else { camera.crossings(direction.z, 0.0).0 }
}

/// What the ground is read from.
pub struct Place<'a> {
    /// Parameters.
    pub ground: &'a Ground,
    /// The large map.
    pub map: &'a [u8],
    /// Heights and distances from the shore; `None`: there is only sea, or only land.
    pub grids: Option<Grids<'a>>,
    /// Fields of flashes' light, if any.
    pub lits: Option<&'a Lits>,
    /// Whether the ground is anywhere else than on the sphere.
    pub terrain: bool,
}

/// The map's value about a point by each chart.
pub(super) struct Patterns<'a> {
    map: &'a [u8],
    places: [Vec2; CHARTS],
    weights: [f32; CHARTS],
    charts: usize,
    footprint: f32,
}

impl Patterns<'_> {
    fn at(&self, scale: f32, offset: f32) -> f32 {
        let mut sum = 0.0;
        for (place, weight) in self.places.iter().zip(self.weights).take(self.charts) {
            if weight > 0.0 {
                let q = *place * scale + Vec2::splat(offset);
                sum += weight * map_repeat(self.map, modulation::WIDTH, q.x, q.y);
            }
        }
        sum
    }

    /// The same less its mean, faded out where its texels are finer than a pixel's footprint.
    pub(super) fn detail(&self, scale: f32, offset: f32, texel: f32) -> f32 {
        let fade = 1.0 - smoothstep(0.5 * texel, 2.0 * texel, self.footprint);
        if fade > 0.0 { fade * (self.at(scale, offset) - 0.5) } else { 0.0 }
    }
}

impl Place<'_> {
    /// Luminance of the ground at range `t_m` along a ray, cd/m2 per colour, without the air in between. `passed` is the
    /// share of the light source that comes through the clouds.
    pub fn luminance(&self, camera: &Camera, direction: Vec3, t_m: f32, passed: f32) -> Vec3 {
        let ground = self.ground;
        let p = direction * t_m + Vec3::new(0.0, 0.0, camera.eye_m);
        let height = if self.terrain { camera.height_at(direction.z, t_m) } else { 0.0 };
        let radius = camera.earth_m + height;
        let up = (p + Vec3::new(0.0, 0.0, camera.earth_m)) / radius;
        let z = stereographic(p, camera.earth_m, radius);
        let facing = -direction.dot(up);
        let footprint = t_m * 2.0 * Vec3::from(camera.up).length() / (camera.height_px * facing.clamp(0.02, 1.0));
        let weights = chart_weights(&ground.chart, ground.charts, up * camera.earth_m, camera.earth_m);
        let places = std::array::from_fn(|i| {
            let chart = &ground.chart[i];
            Vec2::from(chart.map_origin) + modulation::coordinates(chart.displacement(z))
        });
        let patterns = Patterns { map: self.map, places, weights, charts: ground.charts as usize, footprint };
        let (mut normal, mut shore, mut steep, mut passed, mut glow) = (up, ground.shore_m, 0.0, passed, 0.0);
        let light = Vec3::from(ground.light_direction);
        if let Some(grids) = &self.grids {
            let place = place(grids.relief, p, camera.earth_m, radius);
            let level = level(grids.relief, place, t_m);
            shore = grids.at(place, level).y;
            if self.terrain {
                let slope = grids.slope(place, level);
                steep = slope.length();
                normal = (up - slope.extend(0.0)).normalize();
                if ground.hills > 0 {
                    passed *= hills::through(grids, camera, light, up, p, height, t_m);
                }
            }
            if ground.glow_lux > 0.0 {
                glow = ground.glow_lux * glow::share(grids, place, level, ground.glow_level);
            }
        }
        let (albedo, sea) = self.country(&patterns, z, [shore, height, steep]);
        // Ground that stands over a sheet of cloud is lit as above it.
        let over = smoothstep(ground.sheet_base_m, ground.sheet_top_m, height);
        let between = |below: [f32; 3], above: [f32; 3]| Vec3::from(below).lerp(Vec3::from(above), over);
        let light_lux = between(ground.light_lux, ground.above_light_lux);
        let sky_lux = between(ground.sky_lux, ground.above_sky_lux) + CITY_COLOUR * (glow * (1.0 - over));
        // A slope sees less of the sky, and for it lit ground.
        let open = 0.5 + 0.5 * normal.dot(up);
        let mut lit = light_lux * (normal.dot(light).max(0.0) * passed)
            + sky_lux * open
            + (light_lux * up.dot(light).max(0.0) + sky_lux) * (0.13 * (1.0 - open));
        for flash in &ground.flash[..ground.flashes as usize] {
            let towards = Vec3::from(flash.position_m) - p;
            let d2 = towards.length_squared().max(FLASH_CAP_M * FLASH_CAP_M);
            let cos = (normal.dot(towards) / d2.sqrt()).max(0.0);
            lit += FLASH_COLOUR * (12.566_37 * flash.intensity * cos / d2);
        }
        if let Some(lits) = self.lits {
            lit += FLASH_COLOUR * on_ground(lits, p, normal);
        }
        if ground.lamps > 0 {
            lit += Vec3::splat(self.own_lamps(camera, p, normal, height, t_m));
        }
        let mut seen = lit * albedo * FRAC_1_PI;
        // The sea mirrors the sky (Schlick), and the light by waves whose slopes are spread evenly (Cox and Munk 1954).
        let facing = facing.clamp(0.0, 1.0);
        let fresnel = 0.02 + 0.6 * (1.0 - facing).powi(5);
        let half = (light - direction).normalize_or(Vec3::Z);
        let level_share = half.dot(up).clamp(0.05, 1.0);
        let squared = level_share * level_share;
        let spread = ((squared - 1.0) / (squared * WAVE_SLOPES)).exp() / (PI * WAVE_SLOPES * squared * squared);
        let mirrors = 0.02 + 0.98 * (1.0 - half.dot(light).clamp(0.0, 1.0)).powi(5);
        let risen = smoothstep(-0.01, 0.01, up.dot(light));
        let glitter = risen * mirrors * spread * passed / (4.0 * facing.max(0.12));
        seen += (sky_lux * (FRAC_1_PI * fresnel) + light_lux * glitter) * sea;
        if let Some(grids) = self.grids.filter(|grids| grids.lights.is_some()) {
            let place = place(grids.relief, p, camera.earth_m, radius);
            let mean = grids.light(place, level(grids.relief, place, t_m)) * (1.0 - sea);
            if mean > 1e-4 {
                let chart = &ground.chart[0];
                let moved = chart.displacement(z);
                // Over as much ground as the pixel's footprint is long.
                let ahead = (direction - up * direction.dot(up)).normalize_or_zero() * footprint;
                let along = chart.displacement(stereographic(p + ahead, camera.earth_m, radius)) - moved;
                let across = footprint * facing.clamp(0.02, 1.0);
                let place_m = Vec2::from(chart.tile_origin_m) + moved;
                seen += lamps(place_m, along, across, &patterns) * (ground.city_luminance * mean);
            }
        }
        seen
    }

    /// Illuminance by the own ship's lamps, lux: they shine through as much air as lies before the eye.
    fn own_lamps(&self, camera: &Camera, p: Vec3, normal: Vec3, height: f32, t_m: f32) -> f32 {
        let from_eye = p - Vec3::new(0.0, 0.0, camera.eye_m);
        let of = |lamp: &Lamp| {
            let way = from_eye - Vec3::from(lamp.position_m);
            let distance = way.length().max(1.0);
            let towards = way / distance;
            shines(lamp, towards) * (-normal.dot(towards)).max(0.0) / (distance * distance)
        };
        let lux: f32 = self.ground.lamp[..self.ground.lamps as usize].iter().map(of).sum();
        lux * camera.air_transmittance(height, t_m)
    }

    /// Albedo, and how much of it is sea: `shore` above 0 on land, `steep` the tangent of the slope.
    fn country(&self, patterns: &Patterns, z: Vec2, [shore, height, steep]: [f32; 3]) -> (Vec3, f32) {
        let footprint = patterns.footprint;
        let soft = (0.3 * footprint).max(8.0);
        let sea = 1.0 - smoothstep(-soft, soft, shore);
        let broad = patterns.detail(3.0, 0.83, 800.0);
        let middle = patterns.detail(14.0, 0.17, 56.0);
        let small = patterns.detail(60.0, 0.53, 13.0);
        let mut land = FIELDS + Vec3::new(0.03, 0.035, 0.02) * broad;
        let near = 1.0 - smoothstep(50.0, 200.0, footprint);
        if near > 0.0 {
            let bent = Vec2::new(patterns.at(30.0, 0.1) - 0.5, patterns.at(30.0, 0.6) - 0.5) * 420.0;
            let chart = &self.ground.chart[0];
            let at = Vec2::from(chart.tile_origin_m) + chart.displacement(z) + bent;
            land += (field_albedo(at) - FIELDS) * near;
        }
        let rough = 2.0 * middle + small;
        let woods = smoothstep(0.06, 0.20, 0.9 * middle + 0.5 * small + 0.8 * broad + 0.0001 * height + 0.35 * steep);
        land = land.lerp(Vec3::new(0.036, 0.052, 0.026) * (1.0 + 0.8 * small), woods);
        let over_snow = height - self.ground.snow_m;
        let high = smoothstep(-1_100.0, -500.0, over_snow + 500.0 * rough);
        land = land.lerp(Vec3::new(0.112, 0.112, 0.060) * (1.0 + 0.7 * rough), high);
        let bare = smoothstep(0.55, 1.05, steep + 0.5 * rough + 0.35 * high);
        land = land.lerp(Vec3::new(0.145, 0.138, 0.128) * (1.0 + 0.7 * rough), bare);
        let snow =
            smoothstep(-250.0, 250.0, over_snow + 600.0 * rough) * (1.0 - smoothstep(0.9, 1.5, steep + 0.4 * rough));
        land = land.lerp(Vec3::new(0.74, 0.77, 0.81), snow);
        let beach = (1.0 - smoothstep(15.0, 60.0 + soft, shore)) * (1.0 - bare);
        land = land.lerp(Vec3::new(0.29, 0.255, 0.19), beach);
        let shallow = (shore.min(0.0) * (1.0 / 500.0)).exp();
        let water = Vec3::new(0.006, 0.020, 0.032).lerp(Vec3::new(0.030, 0.075, 0.080), shallow * shallow);
        (land.lerp(water, sea), sea)
    }
}

/// A number in [0, 1) each, of two counters (Jarzynski and Olano 2020, pcg2d).
pub(super) fn hash2(counters: UVec2) -> Vec2 {
    let step = |v: u32| v.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let (mut x, mut y) = (step(counters.x), step(counters.y));
    for _ in 0..2 {
        x = x.wrapping_add(y.wrapping_mul(1_664_525));
        y = y.wrapping_add(x.wrapping_mul(1_664_525));
        (x, y) = (x ^ x >> 16, y ^ y >> 16);
    }
    Vec2::new((x >> 8) as f32, (y >> 8) as f32) * (1.0 / 16_777_216.0)
}

/// Colour of the field at a place of the first chart in metres: blocks of 2 km, each with fields of its own size and turn.
fn field_albedo(place_m: Vec2) -> Vec3 {
    let at = place_m * (1.0 / BLOCK_M);
    let block = at.floor();
    // The charts' origins are told in periods of so many blocks.
    let lot = (block.as_ivec2() & IVec2::splat(BLOCKS - 1)).as_uvec2();
    let kind = hash2(lot);
    let turn = Vec2::new((PI * kind.x).cos(), (PI * kind.x).sin());
    let local = (at - block - Vec2::splat(0.5)) * BLOCK_M;
    let turned = Vec2::new(turn.x * local.x - turn.y * local.y, turn.y * local.x + turn.x * local.y);
    let size = Vec2::new(190.0 + 260.0 * kind.y, 120.0 + 160.0 * (kind.y * 7.0).fract());
    let cell = ((turned / size).floor().as_ivec2() + IVec2::splat(512)).as_uvec2();
    let crop = hash2(cell + lot * 1_024);
    let found = match crop.x {
        crop if crop > 0.84 => Vec3::new(0.138, 0.104, 0.068),
        crop if crop > 0.6 => Vec3::new(0.205, 0.178, 0.086),
        crop if crop > 0.3 => Vec3::new(0.108, 0.150, 0.052),
        _ => Vec3::new(0.070, 0.112, 0.038),
    };
    found * (0.85 + 0.3 * crop.y)
}
