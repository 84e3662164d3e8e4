//! The table of scattered light over all directions, made on the CPU for both executors: it is 8192 texels, changes a
//! few times a minute at most, and being one set of numbers it cannot differ between them.
//!
//! *What it is.* Luminance scattered into a ray (red, green, blue) and the ray's transmittance, to the ground or space.
//! *How we store it.* Two discs of directions side by side, above and below the horizon, f16. The horizon is the rim;
//! the distance from the rim goes with the square root of the height above it, so that the horizon's bands are fine.
//! *How we read it back.* Bilinear; a margin round the discs repeats the rim.
//! *Under clouds* a second pair of discs lies below the first: what an endless column of the air before the clouds would send.

use super::atmosphere::{Air, Luminary};
use super::inscatter::Under;
use super::lamps::{CityLamps, MOST};
use super::multiple::HigherOrders;
use super::shade::Shade;
use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};
use half::f16;
use rayon::prelude::*;

/// Texels across one disc.
pub const WIDTH: usize = 64;
/// Radius of a disc as a share of half its square.
pub const RIM: f32 = 0.94;

/// What the table depends on; equal parameters give the same bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableParams {
    /// Height of the eye.
    pub eye_m: f32,
    /// Upward component of the direction to the geometric horizon.
    pub horizon: f32,
    /// Extinction of the haze at height 0, 1/m.
    pub haze_per_m: f32,
    /// Sun and moon; an illuminance of 0 leaves one out.
    pub lights: [Luminary; 2],
    /// Luminance that the sky has without sun and moon (airglow and starlight), cd/m2.
    pub night_luminance: f32,
    /// Cities whose light the air scatters; those of radius 0 are none.
    pub cities: [CityLamps; MOST],
    /// What clouds leave of the air's light; `None`: there are none to speak of.
    pub shade: Option<Shade>,
    /// Factor from stored values to cd/m2, a power of two.
    pub scale: f32,
}

/// One texel: red, green, blue in units of the scale, and transmittance.
///
/// No WGSL struct: the texture has the format rgba16float.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Texel(pub [f16; 4]);

/// Texels of a pair of discs.
const PAIR: usize = 2 * WIDTH * WIDTH;
/// Opacity from which on the light of a column tells that of an endless one.
const LEAST_OPACITY: f32 = 1e-6;
/// Parts of the colours in luminance (ITU-R BT.709).
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// Fills the table: `2 * WIDTH` by `WIDTH` texels, rows one after another, the disc above the horizon on the left; under clouds
/// twice as many.
pub fn build(params: &TableParams) -> Vec<Texel> {
    let air = Air { haze_per_m: params.haze_per_m };
    let higher = HigherOrders::of(&air);
    let lights: Vec<Luminary> =
        params.lights.iter().filter(|l| l.illuminance_lux.max_element() > 0.0).copied().collect();
    let cities: Vec<CityLamps> = params.cities.iter().filter(|city| city.radius_m > 0.0).copied().collect();
    let shade = params.shade.as_ref();
    let pairs = if shade.is_some() { 2 } else { 1 };
    (0..pairs * PAIR)
        .into_par_iter()
        .map(|i| {
            let near = i >= PAIR;
            let (x, y) = (i % (2 * WIDTH), i % PAIR / (2 * WIDTH));
            let above = x < WIDTH;
            let at = Vec2::new((x % WIDTH) as f32 + 0.5, y as f32 + 0.5) * (2.0 / WIDTH as f32) - Vec2::ONE;
            let direction = direction_of(at / RIM, above, params.horizon);
            let end_m = match shade {
                Some(shade) if near => shade.near_end_m(params.eye_m, direction.z),
                _ => f32::INFINITY,
            };
            let under = Under { shade, end_m };
            let (light, passed) = air.inscatter_under(&higher, params.eye_m, direction, &lights, 24, &under);
            let passed = passed.dot(LUMINANCE);
            let night = params.night_luminance * (1.0 - 0.6 * passed) * Vec3::new(0.75, 0.9, 1.25);
            let lit = if cities.is_empty() { Vec3::ZERO } else { air.city_light(&cities, params.eye_m, direction) };
            let seen = match shade {
                Some(shade) if near => {
                    // The night's own light and that of cities are followed along the whole ray; per opacity they depend on its length little.
                    let whole = air.inscatter(&higher, params.eye_m, direction, &[], 8).1.dot(LUMINANCE);
                    let own = (night * shade.at(params.eye_m).1 + lit) / (1.0 - whole).max(0.02);
                    light / (1.0 - passed).max(LEAST_OPACITY) + own
                }
                _ => light + night + lit,
            };
            let stored = (seen / params.scale).min(Vec3::splat(60_000.0));
            Texel([stored.x, stored.y, stored.z, passed].map(f16::from_f32))
        })
        .collect()
}

/// Direction of a point of a disc of radius 1 (points outside stand for the rim).
fn direction_of(at: Vec2, above: bool, horizon: f32) -> Vec3 {
    let s = (1.0 - at.length()).max(0.0);
    let up = if above { horizon + s * s * (1.0 - horizon) } else { horizon - s * s * (1.0 + horizon) };
    let flat = (1.0 - up * up).max(0.0).sqrt();
    let azimuth = at.try_normalize().unwrap_or(Vec2::X);
    Vec3::new(azimuth.x * flat, azimuth.y * flat, up)
}

/// Texture coordinates of a direction in the whole table, `[0, 1]` each.
pub fn coordinates(direction: Vec3, horizon: f32) -> Vec2 {
    let over = direction.z - horizon;
    let s = (over.abs() / if over >= 0.0 { 1.0 - horizon } else { 1.0 + horizon }).min(1.0).sqrt();
    let flat = Vec2::new(direction.x, direction.y);
    let disc = flat * ((1.0 - s) * RIM / flat.length().max(1e-6));
    let u = 0.25 + 0.25 * disc.x + if over >= 0.0 { 0.0 } else { 0.5 };
    Vec2::new(u, 0.5 + 0.5 * disc.y)
}

/// The pair of discs that tells of the air before the clouds, where there are any.
pub fn before_clouds(table: &[Texel]) -> Option<&[Texel]> {
    table.get(PAIR..).filter(|near| !near.is_empty())
}

/// Bilinear look-up, in stored units, in the first pair of discs of a slice.
pub fn sample(table: &[Texel], at: Vec2) -> [f32; 4] {
    let (x, y) = (at.x * (2 * WIDTH) as f32 - 0.5, at.y * WIDTH as f32 - 0.5);
    let (x0, y0) = (x.floor(), y.floor());
    let (fx, fy) = (x - x0, y - y0);
    let texel = |dx: i32, dy: i32| {
        let column = (x0 as i32 + dx).clamp(0, 2 * WIDTH as i32 - 1) as usize;
        let row = (y0 as i32 + dy).clamp(0, WIDTH as i32 - 1) as usize;
        table[column + row * 2 * WIDTH].0.map(f16::to_f32)
    };
    let [a, b, c, d] = [texel(0, 0), texel(1, 0), texel(0, 1), texel(1, 1)];
    std::array::from_fn(|i| {
        let low = a[i] + (b[i] - a[i]) * fx;
        let high = c[i] + (d[i] - c[i]) * fx;
        low + (high - low) * fy
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_invert_directions() {
        let horizon = -0.02;
        for i in 0..200 {
            let a = i as f32 * 0.7;
            let radius = (i as f32 + 0.5) / 201.0;
            let at = Vec2::new(a.cos(), a.sin()) * radius;
            for above in [true, false] {
                let back = coordinates(direction_of(at, above, horizon), horizon);
                let disc = Vec2::new((back.x - if above { 0.25 } else { 0.75 }) * 4.0, (back.y - 0.5) * 2.0) / RIM;
                // f32 loses half its digits at the rim, where the square root is steep: sqrt(6e-8) = 2.4e-4.
                assert!((disc - at).length() < 5e-4, "{at} {disc}");
            }
        }
    }
}
