//! City lights from above: mean luminance by place, on the grids of the relief, made at night only.
//!
//! *What it is.* The luminance that a city's lamps and what they light send upwards, as a share of a city's core.
//! *How we compute it.* A core as wide as the city's inhabitants need ground, with a skirt of suburbs; cities add up. On
//! coarse grids a small town is spread over a node, with the same light in all.
//! *How we store it.* The bits of an f32 for each node.

use crate::geo::charts::{coordinate_of, place_of};
use crate::geo::cities::near;
use crate::passes::relief::window::{TILE, Window};
use glam::{DVec2, DVec3};

/// Luminance of a city's core, cd/m2: 1,000 lm of lamps an inhabitant, 15 % of it upwards (Garstang 1986), of 3,500
/// inhabitants a square kilometre: 0.15 * 1000 * 3.5e-3 / pi.
pub const CORE_LUMINANCE: f32 = 0.167;
/// Largest distance from a city at which its lights are looked for.
const REACH_M: f64 = 120_000.0;
/// A city's lights end at so many of its radii.
const RADII: f64 = 4.0;
/// Luminance of the suburbs against the core, and how far they reach in radii.
const SUBURBS: (f64, f64) = (0.015, 2.0);
/// Part of a node's spacing that a town is spread over at least.
const SPREAD: f64 = 0.7;

/// A city as a node sees it.
struct Lit {
    place_m: DVec2,
    radius_m: f64,
    core: f64,
}

/// The nodes of one tile of a window's level, rows from the south; the tile's numbers are east and north.
pub fn tile(window: &Window, level: usize, [east, north]: [i32; 2]) -> Vec<u32> {
    let spacing_m = window.level_spacing_m(level);
    let size_m = spacing_m * TILE as f64;
    let corner_m = DVec2::new(f64::from(east), f64::from(north)) * size_m;
    let half_diagonal_m = size_m * std::f64::consts::FRAC_1_SQRT_2;
    let middle_m = corner_m + DVec2::splat(0.5 * size_m);
    let (latitude_rad, longitude_rad) = place_of(window.chart, middle_m);
    let (sin_lat, cos_lat) = latitude_rad.sin_cos();
    let (sin_lon, cos_lon) = longitude_rad.sin_cos();
    let zenith = DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat);
    let lit: Vec<Lit> = near(zenith, half_diagonal_m + REACH_M)
        .iter()
        .map(|city| {
            let own_m = city.radius_m();
            let radius_m = own_m.hypot(SPREAD * spacing_m);
            let core = (own_m / radius_m).powi(2);
            Lit { place_m: coordinate_of(window.chart, city.zenith), radius_m, core }
        })
        .filter(|lit| lit.place_m.distance(middle_m) < half_diagonal_m + RADII * lit.radius_m)
        .collect();
    let node = |i: usize| {
        let place_m = corner_m + DVec2::new((i % TILE) as f64, (i / TILE) as f64) * spacing_m;
        let sum: f64 = lit.iter().map(|lit| lit.at(place_m)).sum();
        (sum as f32).to_bits()
    };
    (0..TILE * TILE).map(node).collect()
}

impl Lit {
    fn at(&self, place_m: DVec2) -> f64 {
        let radii = place_m.distance(self.place_m) / self.radius_m;
        if radii > RADII {
            return 0.0;
        }
        self.core * ((-radii * radii).exp() + SUBURBS.0 * (-radii / SUBURBS.1).exp())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geo::terrain::Terrain;

    #[test]
    fn paris_shines_the_sea_does_not_and_coarse_grids_hold_the_same_light() {
        let (lat, lon) = (48.857f64.to_radians(), 2.352f64.to_radians());
        let paris = DVec3::new(lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin());
        let chart = (0..crate::geo::charts::CHARTS)
            .min_by(|a, b| coordinate_of(*a, paris).length().total_cmp(&coordinate_of(*b, paris).length()))
            .expect("there are charts");
        let place_m = coordinate_of(chart, paris);
        let window = Window::around(Terrain::ELLIPSOID, chart, place_m, 30.0);
        // Light of a square of 61 km (one tile of level 6) about Paris, from three levels.
        let lux = |level: usize| {
            let size_m = window.level_spacing_m(level) * TILE as f64;
            let whole = (window.level_spacing_m(6) * TILE as f64 / size_m) as i32;
            let first = [place_m.x, place_m.y].map(|v| (v / (size_m * f64::from(whole))).floor() as i32 * whole);
            let tiles = (0..whole * whole).map(|i| tile(&window, level, [first[0] + i % whole, first[1] + i / whole]));
            let sum: f64 = tiles.flatten().map(|node| f64::from(f32::from_bits(node))).sum();
            sum * window.level_spacing_m(level).powi(2)
        };
        let [fine, middle, coarse] = [3, 5, 6].map(lux);
        // Nodes of 2 km hold towns of 1.2 km radius, and what lies across the square's edge.
        assert!((middle / fine - 1.0).abs() < 0.05 && (coarse / fine - 1.0).abs() < 0.1, "{fine} {middle} {coarse}");
        // Two million people on 3,500 a square kilometre are 600 km2 of core.
        assert!(fine > 6e8 && fine < 4e9, "{fine}");
        let sea = tile(&Window::around(Terrain::ELLIPSOID, chart, place_m, 30.0), 0, [-90_000, 0]);
        assert!(sea.iter().all(|node| f32::from_bits(*node).is_finite()));
    }
}
