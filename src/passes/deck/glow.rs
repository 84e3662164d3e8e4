//! City glow: light of cities on the underside of clouds (deck paper eq. 20), by place and height, made at night only.
//!
//! *What it is.* Illuminance from below by the cities around, each at the height of its ground, in ground-fixed coordinates that neither tile nor drift; what of it a
//! cloud sends on follows from its light from below, so thicker cloud glows more, and its lower parts most. Where eq. 20
//! reads the area from a texture and falls linearly with the height, these are the cities and the light inside the volume.
//! *How we compute it.* Each city is a disc that shines as a matt one does; cities add up.
//! *How we store it.* 256 x 256 texels of 2 km around the eye, f16, for four heights over the sea.
//! *How we read it back.* Bilinear; between the heights by their logarithm, so that the upper parts of a tower receive less.

use crate::geo::charts::{coordinate_of, place_of};
use crate::geo::cities::{City, near};
use crate::geo::terrain::Terrain;
use crate::passes::ground::lights::CORE_LUMINANCE;
use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3, Vec2, Vec3, Vec4};
use half::f16;
use rayon::prelude::*;

/// Texels each way.
pub const WIDTH: usize = 256;
/// Their spacing.
pub const SPACING_M: f64 = 2_000.0;
/// The window moves by so many texels.
const STEP: i32 = 16;
/// Heights that are tabulated.
const HEIGHTS_M: [f64; 4] = [250.0, 1_000.0, 3_000.0, 9_000.0];
/// Heights that lie lower over a city's ground, or under it, have its light there.
const LEAST_HEIGHT_M: f64 = 100.0;
/// A city's light is looked for up to this distance: a million people's is a microlux there.
const REACH_M: f64 = 60_000.0;
/// Way over which haze near the ground takes a city's light to 1/e.
const CLEAR_M: f64 = 40_000.0;

/// How the table lies around the eye. Parameters; twin of `CityGlow` in `lit.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct CityGlow {
    /// Complex factor `a` of the chart that the table lies in.
    pub a: [f32; 2],
    /// Complex factor `c`, 1/m.
    pub c: [f32; 2],
    /// Factors on the eye's stereographic coordinate, east and north.
    pub stretch: [f32; 2],
    /// Where the eye is, in the whole table.
    pub origin: [f32; 2],
    /// How much of the lamps is lit: 1 in the night.
    pub strength: f32,
    /// Pads to a multiple of 8 bytes.
    pub pad0: f32,
}

/// What a table is made from; equal ones give the same bytes.
#[derive(Clone, Debug, PartialEq)]
pub struct GlowWindow {
    /// What the cities stand on.
    pub terrain: Terrain,
    /// Which chart.
    pub chart: usize,
    /// First texel, east and north, in steps of 16.
    pub first: [i32; 2],
}

impl GlowWindow {
    /// The window around a place of a chart.
    pub fn around(terrain: Terrain, chart: usize, eye_m: DVec2) -> Self {
        let first = [eye_m.x, eye_m.y]
            .map(|along| (along / (SPACING_M * f64::from(STEP))).floor() as i32 * STEP - (WIDTH as i32 - STEP) / 2);
        Self { terrain, chart, first }
    }

    /// Where a place of the chart lies in the table, as shares of its width (texel centres at halves).
    pub fn share(&self, place_m: DVec2) -> DVec2 {
        let first = DVec2::new(f64::from(self.first[0]), f64::from(self.first[1]));
        (place_m / SPACING_M - first + 0.5) / WIDTH as f64
    }
}

/// Illuminance from below at the four heights, lux; rows from the south.
pub type Texel = [f16; 4];

/// Fills a table.
pub fn build(window: &GlowWindow) -> Vec<Texel> {
    const TILE: usize = 16;
    let tiles = WIDTH / TILE;
    let made: Vec<Vec<Texel>> = (0..tiles * tiles)
        .into_par_iter()
        .map(|tile| {
            let corner = [tile % tiles, tile / tiles].map(|t| (t * TILE) as f64);
            let place_m = |x: f64, y: f64| {
                DVec2::new(f64::from(window.first[0]) + corner[0] + x, f64::from(window.first[1]) + corner[1] + y)
                    * SPACING_M
            };
            let cities = lit_around(window, place_m(7.5, 7.5), REACH_M + SPACING_M * TILE as f64);
            let texel = |i: usize| {
                let here = place_m((i % TILE) as f64, (i / TILE) as f64);
                let mut sums = [0.0; 4];
                for Lit { place_m, radius_m, ground_m } in &cities {
                    let apart = here.distance_squared(*place_m);
                    if apart < REACH_M * REACH_M {
                        for (sum, height_m) in sums.iter_mut().zip(HEIGHTS_M) {
                            *sum += disc_lux(apart, *radius_m, (height_m - ground_m).max(LEAST_HEIGHT_M));
                        }
                    }
                }
                sums.map(f16::from_f64)
            };
            (0..TILE * TILE).map(texel).collect()
        })
        .collect();
    (0..WIDTH * WIDTH)
        .map(|i| {
            let (x, y) = (i % WIDTH, i / WIDTH);
            made[x / TILE + y / TILE * tiles][x % TILE + y % TILE * TILE]
        })
        .collect()
}

/// A city: where in the chart, how wide, and on what height.
struct Lit {
    place_m: DVec2,
    radius_m: f64,
    ground_m: f64,
}

/// Cities about a place of the window's chart.
fn lit_around(window: &GlowWindow, place_m: DVec2, reach_m: f64) -> Vec<Lit> {
    let (latitude_rad, longitude_rad) = place_of(window.chart, place_m);
    let (sin_lat, cos_lat) = latitude_rad.sin_cos();
    let (sin_lon, cos_lon) = longitude_rad.sin_cos();
    let cities = near(DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat), reach_m);
    let lit = |city: &City| Lit {
        place_m: coordinate_of(window.chart, city.zenith),
        radius_m: city.radius_m(),
        ground_m: city.ground_m(&window.terrain),
    };
    cities.iter().map(lit).collect()
}

/// Illuminance of a level plane at a height by a matt disc on the ground, whose middle is the square root of `apart` away (the
/// configuration factor from an element to a parallel disc; Howell, "A Catalog of Radiation Heat Transfer Configuration
/// Factors"), less what haze takes on the way from its middle or from below.
fn disc_lux(apart: f64, radius_m: f64, height_m: f64) -> f64 {
    let (r2, h2) = (radius_m * radius_m, height_m * height_m);
    let sum = apart + h2 + r2;
    let factor = 0.5 * (1.0 - (apart + h2 - r2) / (sum * sum - 4.0 * r2 * apart).sqrt());
    // Over the disc most light comes from right below.
    let way_m = ((apart - r2).max(0.0) + h2).sqrt();
    std::f64::consts::PI * f64::from(CORE_LUMINANCE) * factor * (-way_m / CLEAR_M).exp()
}

/// What arrives at a height, of a texel's four: between them by the logarithm of the height. Twin of the same in `lit.wgsl`.
pub fn at_height(lux: Vec4, height_m: f32) -> f32 {
    let log_height = height_m.max(1.0).ln();
    let share = (Vec3::splat(log_height) - Vec3::new(5.521_461, 6.907_755_3, 8.006_368))
        * Vec3::new(0.721_347_5, 0.910_239_2, 0.910_239_2);
    let share = share.clamp(Vec3::ZERO, Vec3::ONE);
    let between = |a: f32, b: f32, share: f32| a + (b - a) * share;
    between(between(between(lux.x, lux.y, share.x), lux.z, share.y), lux.w, share.z)
}

/// Bilinear look-up of a table, clamped; coordinates as shares of its width.
pub fn sample(table: &[Texel], at: Vec2) -> Vec4 {
    let place = (at * WIDTH as f32 - 0.5).clamp(Vec2::ZERO, Vec2::splat((WIDTH - 1) as f32));
    let low = place.floor().min(Vec2::splat((WIDTH - 2) as f32));
    let f = place - low;
    let first = low.x as usize + low.y as usize * WIDTH;
    let texel = |i: usize| Vec4::from(table[i].map(f16::to_f32));
    let south = texel(first).lerp(texel(first + 1), f.x);
    south.lerp(texel(first + WIDTH).lerp(texel(first + WIDTH + 1), f.x), f.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The disc's illuminance by summing small pieces of it.
    fn summed_lux(apart_m: f64, radius_m: f64, height_m: f64) -> f64 {
        let (rings, spokes) = (200, 400);
        let mut sum = 0.0;
        for ring in 0..rings {
            let r = radius_m * (f64::from(ring) + 0.5) / f64::from(rings);
            for spoke in 0..spokes {
                let place = DVec2::from_angle(std::f64::consts::TAU * f64::from(spoke) / f64::from(spokes)) * r;
                let d2 = place.distance_squared(DVec2::new(apart_m, 0.0)) + height_m * height_m;
                let area = std::f64::consts::TAU * r * radius_m / f64::from(rings * spokes);
                sum += f64::from(CORE_LUMINANCE) * area * height_m * height_m / (d2 * d2);
            }
        }
        sum
    }

    #[test]
    fn a_discs_light_is_that_of_its_pieces() {
        for (radius_m, height_m) in
            [(1_200.0f64, 1_000.0f64), (9_500.0, 1_000.0), (9_500.0, 3_000.0), (3_000.0, 9_000.0)]
        {
            for apart_m in [0.0f64, 0.5 * radius_m, 0.9 * radius_m, 1.1 * radius_m, 3.0 * radius_m, 20_000.0] {
                let way_m = (apart_m * apart_m - radius_m * radius_m).max(0.0).sqrt().hypot(height_m);
                let found = disc_lux(apart_m * apart_m, radius_m, height_m) / (-way_m / CLEAR_M).exp();
                // Both are exact but for the pieces' size, which is a quarter of the height where the light falls steepest.
                let ratio = found / summed_lux(apart_m, radius_m, height_m);
                assert!((0.995..1.005).contains(&ratio), "{radius_m} {height_m} {apart_m}: {ratio}");
            }
        }
    }

    #[test]
    fn what_is_lower_is_lit_more() {
        for apart_m in [0.0f64, 2_000.0] {
            let lux: Vec<f64> = HEIGHTS_M.iter().map(|h| disc_lux(apart_m * apart_m, 5_000.0, *h)).collect();
            assert!(lux.windows(2).all(|pair| pair[1] < pair[0]), "{lux:?}");
        }
        let lux = Vec4::new(9.0, 4.0, 2.0, 1.0);
        for (height_m, expected) in [
            (-500.0, 9.0),
            (250.0, 9.0),
            (500.0, 6.5),
            (1_000.0, 4.0),
            (3_000.0, 2.0),
            (5_196.15, 1.5),
            (20_000.0, 1.0),
        ] {
            // The logarithms' eight digits.
            assert!((at_height(lux, height_m) - expected).abs() < 1e-4, "{height_m}: {}", at_height(lux, height_m));
        }
    }

    #[test]
    fn the_table_glows_over_paris_and_stands_on_the_ground() {
        let (lat, lon) = (48.857f64.to_radians(), 2.352f64.to_radians());
        let paris = DVec3::new(lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin());
        let chart = (0..crate::geo::charts::CHARTS)
            .min_by(|a, b| coordinate_of(*a, paris).length().total_cmp(&coordinate_of(*b, paris).length()))
            .expect("there are charts");
        let place_m = coordinate_of(chart, paris);
        let at = |eye_m: DVec2, there_m: DVec2| {
            let window = GlowWindow::around(Terrain::ELLIPSOID, chart, eye_m);
            sample(&build(&window), window.share(there_m).as_vec2())
        };
        let over = at(place_m, place_m);
        // The disc's closed form over its middle, and other towns' light.
        assert!(over.y > 0.45 && over.y < 0.7, "{over}");
        assert!(over.x > over.y && over.y > over.z && over.z > over.w, "{over}");
        let moved = at(place_m + DVec2::new(70_000.0, -40_000.0), place_m);
        // The same texels, up to the rounding of f32 shares.
        assert!((moved - over).abs().max_element() < 1e-3, "{moved} {over}");
    }
}
