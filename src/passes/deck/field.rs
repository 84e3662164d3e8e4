//! The density and light of a layer at a point; twin of the functions of the same names in `field.wgsl` and `lit.wgsl`.

use super::clumps;
use super::glow::{CityGlow, SPACING_M, Texel, WIDTH, at_height, sample};
use super::{FLASH_CAP_M, FLASH_COLOUR, Layer, Region};
use crate::clouds::{CloudKind, clearance, density, detail, modulation};
use crate::passes::common::{Chart, chart_weights, displacement, smoothstep, stereographic};
use crate::passes::light::encoding::{Encoding, View, decode};
use crate::passes::light::volume::Volume;
use crate::passes::sampling::{map_repeat, volume_byte};
use crate::passes::shadow::shade;
use crate::passes::sky::lamps::CITY_COLOUR;
use glam::{Vec2, Vec3, Vec4};

/// What a layer's look-ups read.
#[derive(Clone, Copy)]
pub struct Textures<'a> {
    /// Shape values of the genus.
    pub shape: &'a [u8],
    /// One light volume a chart in use.
    pub lights: &'a [&'a Volume],
    /// Upper bounds of the shape value by column (see [`column_bounds`]); behind them, for walks, the table of `clouds::clearance`
    /// (see [`empty_space`]).
    pub bounds: &'a [u8],
    /// The 2D modulation map.
    pub map: &'a [u8],
    /// The detail volume.
    pub detail: &'a [u8],
    /// The map of shade by higher layers, where these shade the layer.
    pub shade: Option<&'a [f32]>,
    /// City glow and how its table lies; `None`: there is none.
    pub glow: Option<(&'a CityGlow, &'a [Texel])>,
}

impl<'a> Textures<'a> {
    /// Those that say where cloud is, without any light: a genus's shape and its bounds, and what all genera share.
    pub fn unlit(shape: &'a [u8], bounds: &'a [u8]) -> Self {
        Self { shape, lights: &[], bounds, map: modulation::map(), detail: detail::volume(), shade: None, glow: None }
    }
}

/// A bound below this need not be followed up by a look.
const CLEAR: f32 = -0.25;
/// A chart's weight from which on the others are not asked.
const ALONE: f32 = 0.999_9;

/// How far a point is inside a layer's cloud: shape value less theta, cloud where positive, whole from the genus's edge
/// on. Where there is certainly none, an upper bound. `p`: east, north, height over the tangent plane; `height_m` over the
/// sphere; `t_m` its range from the eye.
pub fn margin(layer: &Layer, textures: &Textures, earth_m: f32, p: Vec3, height_m: f32, t_m: f32) -> f32 {
    look(layer, textures, earth_m, p, height_m, &Step { t_m, length_m: f32::INFINITY, sine: 0.0 }).margin
}

/// Where on its ray a look stands.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Range from the eye, m.
    pub t_m: f32,
    /// Length of the step that comes next, m.
    pub length_m: f32,
    /// Sine of the ray's elevation there.
    pub sine: f32,
}

/// What a look finds.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// As [`margin`] gives it; where cloud is further away than the next step, any value below 0.
    pub margin: f32,
    /// How far beyond the next step there is surely no cloud, or hardly any, m.
    pub beyond_m: f32,
}

/// As [`margin`] for a walk: where cloud is further away than the next step, nothing else is read.
pub fn look(layer: &Layer, textures: &Textures, earth_m: f32, p: Vec3, height_m: f32, step: &Step) -> Look {
    let Step { t_m, length_m: step_m, sine } = *step;
    let radius = earth_m + height_m;
    let z = stereographic(p, earth_m, radius);
    let shift = region_shift(layer, z);
    let found = |margin: f32| Look { margin, beyond_m: layer.reach_m * (-margin).max(0.0) };
    if shift >= 1.0 {
        return found(-1.0);
    }
    let share = (height_m - layer.base_m) / layer.thickness_m;
    let heaped = heaped(layer, t_m);
    let weights = chart_weights(&layer.chart, layer.charts, p + Vec3::new(0.0, 0.0, earth_m), radius);
    let by_chart = |chart: &Chart| {
        let moved = chart.displacement(z);
        let map = Vec2::from(chart.map_origin) + modulation::coordinates(moved);
        let above = layer.patchiness * map_repeat(textures.map, modulation::WIDTH, map.x, map.y);
        (chart.tile(moved), layer.theta + above)
    };
    let ruled = layer.chart.iter().zip(weights).find(|(_, weight)| *weight > ALONE).map(|(chart, _)| by_chart(chart));
    if let Some((tile, theta)) = ruled {
        // Where regions begin theta falls faster than by the map.
        let clear_m =
            if shift == 0.0 { clear_m(layer, textures.bounds, tile, share, theta - heaped, sine) } else { 0.0 };
        if clear_m > step_m {
            return Look { margin: -1.0, beyond_m: clear_m - step_m };
        }
        // Who asks for a place alone need not follow up what no column there reaches.
        let most = bound(textures.bounds, tile) + heaped - theta - shift;
        if step_m.is_infinite() && most < CLEAR {
            return found(most);
        }
    }
    let mut sum = 0.0;
    for (chart, weight) in layer.chart.iter().zip(weights).filter(|(_, weight)| *weight > 0.0) {
        let (tile, theta) = ruled.filter(|_| weight > ALONE).unwrap_or_else(|| by_chart(chart));
        let value = volume_byte(textures.shape, density::WIDTH, density::HEIGHT, false, [tile.x, tile.y, share]);
        sum += weight * (value - theta - shift);
    }
    if t_m < layer.detail_fade_m[1] && sum > -heaped && sum < layer.detail + 1.0 / layer.inverse_edge {
        sum += layer.detail * detail_fade(layer, t_m) * fine(layer, textures, z, height_m, 1.0);
    }
    found(sum)
}

/// What is left of the detail at a range.
fn detail_fade(layer: &Layer, t_m: f32) -> f32 {
    let [near_m, far_m] = layer.detail_fade_m;
    if t_m < far_m { 1.0 - smoothstep(near_m, far_m, t_m) } else { 0.0 }
}

/// Most that detail adds to a margin at a range and farther away.
fn heaped(layer: &Layer, t_m: f32) -> f32 {
    layer.detail * detail_fade(layer, t_m) * (1.0 - detail::MEAN)
}

/// The detail at a place in its periods, each finer by `times`, less its mean.
pub(super) fn fine(layer: &Layer, textures: &Textures, z: Vec2, height_m: f32, times: f32) -> f32 {
    // In the first chart's axes, so that it stands on the ground while the eye moves.
    let moved = layer.chart[0].displacement(z);
    let [east, north, up] = layer.detail_per_m;
    let at = [layer.detail_origin[0] + moved.x * east, layer.detail_origin[1] + moved.y * north, height_m * up];
    volume_byte(textures.detail, detail::WIDTH, detail::WIDTH, true, at.map(|v| v * times)) - detail::MEAN
}

/// How far along a ray there is surely no cloud, by the table behind the column bounds, for theta less what detail adds, m; 0 where
/// it does not say.
fn clear_m(layer: &Layer, bounds: &[u8], tile: Vec2, share: f32, lowered: f32, sine: f32) -> f32 {
    let height = ((share * clearance::HEIGHT as f32) as usize).min(clearance::HEIGHT - 1);
    let count = clearance::DISTANCES_M.len();
    let at = BOUNDS_WIDTH * BOUNDS_WIDTH + count * (cell(tile) + BOUNDS_WIDTH * BOUNDS_WIDTH * height);
    let Some(stored) = bounds.get(at..at + count) else { return 0.0 };
    let pace = (1.0 + (layer.clear_rise * layer.clear_rise - 1.0) * sine * sine).sqrt();
    let far_m = clearance::DISTANCES_M.map(|distance_m| distance_m * (layer.clear_share / pace));
    // On the way theta may fall.
    let free = stored
        .iter()
        .zip(far_m)
        .filter(|(most, far_m)| f32::from(**most) * (1.0 / 255.0) + layer.theta_slope_per_m * far_m < lowered);
    free.map(|(_, far_m)| far_m).fold(0.0, f32::max)
}

/// Light as stored (see `light::encoding`) at a point of a layer and its height over the sphere, for the theta that rules
/// there.
pub fn light_at(layer: &Layer, textures: &Textures, earth_m: f32, p: Vec3, height_m: f32) -> Vec4 {
    let radius = earth_m + height_m;
    let z = stereographic(p, earth_m, radius);
    let share = (height_m - layer.base_m) / layer.thickness_m;
    let weights = chart_weights(&layer.chart, layer.charts, p + Vec3::new(0.0, 0.0, earth_m), radius);
    let lowest = layer.theta + region_shift(layer, z) - layer.light_low;
    let mut light = Vec4::ZERO;
    for ((chart, weight), volume) in layer.chart.iter().zip(weights).zip(textures.lights) {
        if weight > 0.0 {
            let moved = chart.displacement(z);
            let tile = chart.tile(moved);
            let map = Vec2::from(chart.map_origin) + modulation::coordinates(moved);
            let above = layer.patchiness * map_repeat(textures.map, modulation::WIDTH, map.x, map.y);
            let node = (lowest + above) * layer.light_per_theta;
            light += weight * turned(layer.encoding(), volume.sample(tile.into(), share, node), chart);
        }
    }
    light
}

/// Stored values whose vector lies in the axes of a chart, in the eye's.
fn turned(encoding: Encoding, stored: Vec4, chart: &Chart) -> Vec4 {
    if !encoding.is_vector() {
        return stored;
    }
    let middle = if encoding == Encoding::Paper { 0.5 } else { 0.0 };
    let a = Vec2::from(chart.a).normalize_or(Vec2::X);
    let (x, y) = (stored.x - middle, stored.y - middle);
    Vec4::new(middle + a.x * x + a.y * y, middle + a.x * y - a.y * x, stored.z, stored.w)
}

/// Luminance that a point of cloud sends towards the eye where it is opaque, cd/m2 per colour (the source function).
///
/// `shown`: share of the source's light that higher layers and detail on its way leave (see [`shown`] and [`relieved`]).
pub fn source(layer: &Layer, stored: Vec4, view: &View, p: Vec3, height_m: f32, shown: f32) -> Vec3 {
    let lit = decode(layer.encoding(), stored, view);
    let up = ((height_m - layer.base_m) / layer.thickness_m).clamp(0.0, 1.0);
    let mut light =
        Vec3::from(layer.light_lux) * Vec3::from(layer.low_light).lerp(Vec3::ONE, up) * (lit.source * shown)
            + Vec3::from(layer.sky_lux) * lit.sky
            + Vec3::from(layer.ground_lux) * lit.ground;
    for flash in &layer.flash[..layer.flashes as usize] {
        // Eq. 21, the distance capped.
        let d2 = (p - Vec3::from(flash.position_m)).length_squared().max(FLASH_CAP_M * FLASH_CAP_M);
        light += FLASH_COLOUR * (flash.intensity / d2);
    }
    light
}

/// Part of a place's own detail against that towards the light.
const BETWEEN_HEAPS: f32 = 0.5;
/// Nearer than this it counts less, m: what lies at the eye would flicker as it is flown through.
const RELIEF_NEAR_M: f32 = 300.0;

/// What detail leaves of the source's light at a point at a range, which light volumes do not know, against its mean: as much less
/// as there is more of it on the light's way, and less between heaps than on them, where light scatters out to all sides.
/// Near the eye clumps inside the cloud do it instead.
pub fn relieved(layer: &Layer, textures: &Textures, earth_m: f32, p: Vec3, height_m: f32, t_m: f32) -> f32 {
    let left = clumps::shaded(layer, textures, earth_m, p, height_m, t_m);
    if t_m >= layer.detail_fade_m[1] {
        return left;
    }
    let towards = Vec3::from(layer.light_direction) * layer.relief_m;
    let z = stereographic(p, earth_m, earth_m + height_m);
    let more = fine(layer, textures, z + towards.truncate(), height_m + towards.z, 1.0)
        - BETWEEN_HEAPS * fine(layer, textures, z, height_m, 1.0);
    let share = detail_fade(layer, t_m) * smoothstep(0.0, RELIEF_NEAR_M, t_m);
    left * (-layer.relief_depth * share * more).exp()
}

/// Share of the source's light that higher layers leave at a point.
pub fn shown(layer: &Layer, textures: &Textures, earth_m: f32, p: Vec3, height_m: f32) -> f32 {
    textures.shade.map_or(1.0, |map| shade::at(layer, map, earth_m, p, height_m))
}

/// A ray of the picture from the eye as a layer's light sees it.
pub fn view(layer: &Layer, direction: Vec3) -> View {
    let light = Vec3::from(layer.light_direction);
    View { direction, light, lobes: phases(direction.dot(light)) }
}

/// Of a diffuse slab's transmittance 1 / (1 + 3/4 (1 - g) tau) with g = 0.85, for cloud that fills seven tenths of its height.
const GLOW_SLAB: f32 = 0.08;

/// What a point sends out of the light of cities, cd/m2 where it is opaque; `from_below` is what it sends of a layer's own light
/// from the ground.
pub fn city_glow(layer: &Layer, textures: &Textures, earth_m: f32, p: Vec3, height_m: f32, from_below: f32) -> Vec3 {
    let Some((glow, table)) = textures.glow else { return Vec3::ZERO };
    let z = stereographic(p, earth_m, earth_m + height_m) * Vec2::from(glow.stretch);
    let moved = displacement(glow.a.into(), glow.c.into(), z);
    let lux = sample(table, Vec2::from(glow.origin) + moved * (1.0 / (WIDTH as f64 * SPACING_M) as f32));
    // Through the cloud below it as through a diffuse slab; a flank has open air before it.
    let depth = layer.extinction_per_m * (height_m - layer.base_m).max(0.0);
    let (slab, open) = (1.0 / (1.0 + GLOW_SLAB * depth), 1.0 - 0.25 * from_below);
    let through = slab + (1.0 - slab) * open;
    CITY_COLOUR * (0.079_577_47 * glow.strength * at_height(lux, height_m) * through * from_below)
}

/// Cornette-Shanks (eq. 10) as a weighted sum (eq. 9) of a forward and a backward lobe, 1/sr, at the cosine of the
/// scattering angle: for light that comes from the source straight, and a broader lobe for what has been scattered on its way.
pub fn phases(cos: f32) -> [f32; 2] {
    let lobe = |f: f32| {
        let d = 1.0 + f * f - 2.0 * f * cos;
        1.5 * (1.0 - f * f) / (2.0 + f * f) * (1.0 + cos * cos) / (d * d.sqrt())
    };
    [0.96 * lobe(0.75) + 0.04 * lobe(-0.20), lobe(0.60)].map(|lobes| 0.079_577_47 * lobes)
}

/// How much the outlines of the regions raise theta at a stereographic coordinate: 0 inside, 1 (clear) outside.
pub fn region_shift(layer: &Layer, z: Vec2) -> f32 {
    let mut there = 1.0;
    for (i, region) in layer.outline[..layer.regions as usize].iter().enumerate() {
        let own = layer.region == i as u32 + 1;
        let inside = region_presence(region, z);
        if layer.region == 0 {
            there *= 1.0 - inside;
        } else if own {
            there = inside;
        }
    }
    // Squared, so that half-way through the transition some of both weathers is there.
    (1.0 - there) * (1.0 - there)
}

/// 1 inside a region's outline, easing to 0 over its transition.
fn region_presence(region: &Region, z: Vec2) -> f32 {
    let d = z - Vec2::from(region.centre_m);
    let [c, s] = region.rotation;
    let q = Vec2::new(c * d.x + s * d.y, c * d.y - s * d.x).abs() - Vec2::from(region.core_m);
    let outside = q.max(Vec2::ZERO).length() + q.x.max(q.y).min(0.0) - region.corner_m;
    region.presence * (1.0 - smoothstep(0.0, 1.0, outside * region.inverse_transition))
}

/// Texels across the map of column bounds.
pub const BOUNDS_WIDTH: usize = 128;

/// Upper bounds of the shape value over blocks of 2 x 2 columns and their neighbours, so that a nearest look-up bounds
/// every trilinear one.
pub fn column_bounds(shape: &[u8]) -> Vec<u8> {
    let width = density::WIDTH;
    let columns: Vec<u8> = (0..width * width)
        .map(|i| (0..density::HEIGHT).map(|z| shape[i + z * width * width]).max().unwrap_or(0))
        .collect();
    let ratio = (width / BOUNDS_WIDTH) as i32;
    (0..BOUNDS_WIDTH * BOUNDS_WIDTH)
        .map(|i| {
            let (x, y) = ((i % BOUNDS_WIDTH) as i32 * ratio, (i / BOUNDS_WIDTH) as i32 * ratio);
            let around = -1..=ratio;
            around
                .clone()
                .flat_map(|dy| around.clone().map(move |dx| (dx, dy)))
                .map(|(dx, dy)| {
                    let wrap = |v: i32| v.rem_euclid(width as i32) as usize;
                    columns[wrap(x + dx) + width * wrap(y + dy)]
                })
                .max()
                .unwrap_or(0)
        })
        .collect()
}

/// The bounds by column of a genus and behind them how far its places are from cloud.
pub fn empty_space(kind: CloudKind) -> Vec<u8> {
    let mut table = column_bounds(&density::DensityVolume::of(kind).shape);
    table.extend_from_slice(&clearance::of(kind));
    table
}

fn bound(bounds: &[u8], tile: Vec2) -> f32 {
    f32::from(bounds[cell(tile)]) * (1.0 / 255.0)
}

/// The texel over a place of the tile.
fn cell(tile: Vec2) -> usize {
    let along = |u: f32| {
        let at = u * BOUNDS_WIDTH as f32;
        let low = at as i32 - i32::from((at as i32 as f32) > at);
        low as usize & (BOUNDS_WIDTH - 1)
    };
    along(tile.x) + BOUNDS_WIDTH * along(tile.y)
}
