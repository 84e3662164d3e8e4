//! Made relief: plains, hills and mountains from noise on the sphere, shaped by the coastline and the mountain ranges.
//!
//! *Where it is high* follows the real ranges, *what it looks like* is made up: ridged noise in mountains, rolling noise
//! elsewhere, everything sinking to sea level at the coast and to the valley floor where towns are. The noise lives in space, not on a map: no seam and no pole.

use super::ranges::crest_and_floor_m;
use super::{HIGHEST_M, Heights, Roughness, towns};
use crate::geo::coast::coarse_shore_m;
use crate::numeric::noise::spatial as noise;
use glam::DVec3;
use std::sync::{Arc, LazyLock};

/// Radius of the sphere that the noise is laid through.
const EARTH_M: f64 = 6_371_000.0;
/// From crest to crest of the widest mountains, and of the widest hills.
const MOUNTAIN_M: f64 = 21_000.0;
const HILL_M: f64 = 9_000.0;
/// Each octave has half the wavelength of the one before; the last ones have 80 to 90 m.
const MOUNTAIN_OCTAVES: usize = 9;
const HILL_OCTAVES: usize = 7;
/// Over this way from the shore the land rises to its full height.
const RISE_M: f64 = 9_000.0;
/// Shares of the mountains and of the hills that a town leaves none of.
const CLEARED: [f64; 2] = [0.94, 0.6];

/// The finest folds, and the steepest slope: over six mountain ranges a test finds up to 3.8 in steps of 10 m.
const ROUGHNESS: Roughness = Roughness { grain_m: 80.0, steepest: 5.0, reach_m: f64::INFINITY };

/// The one relief of the house.
#[derive(Debug)]
struct Relief;

/// It, shared, so that two worlds have the same ground.
pub fn shared() -> Arc<dyn Heights> {
    static RELIEF: LazyLock<Arc<Relief>> = LazyLock::new(|| Arc::new(Relief));
    RELIEF.clone()
}

impl Heights for Relief {
    fn height_m(&self, latitude_rad: f64, longitude_rad: f64, spacing_m: f64) -> f64 {
        let shore_m = coarse_shore_m(latitude_rad, longitude_rad, spacing_m);
        if shore_m <= 0.0 {
            return 0.0;
        }
        let (sin_lat, cos_lat) = latitude_rad.sin_cos();
        let (sin_lon, cos_lon) = longitude_rad.sin_cos();
        let up = DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat);
        let town = || towns::share(latitude_rad, longitude_rad, spacing_m);
        inland_m(up, shore_m, spacing_m, town).min(HIGHEST_M)
    }

    fn roughness(&self, _: f64, _: f64) -> Roughness {
        ROUGHNESS
    }
}

/// Height of land at a distance from the shore; `up` is the unit vector of the place, `town` how much of it is town.
fn inland_m(up: DVec3, shore_m: f64, spacing_m: f64, town: impl FnOnce() -> f64) -> f64 {
    let at = |wavelength_m: f64| up * (EARTH_M / wavelength_m);
    // Ranges do not end along a circle: their foot is bent by some 12 km.
    let [crest_m, floor_m] = crest_and_floor_m(up, || {
        let p = at(60_000.0);
        (up + DVec3::new(noise(p, 11), noise(p, 12), noise(p, 13)) * (12_000.0 / EARTH_M)).normalize()
    });
    let town = if crest_m > 1.0 { town() } else { 0.0 };
    let rise = 1.0 - (-shore_m / RISE_M).exp();
    let plain_m = 15.0 + 130.0 * (0.5 + 0.5 * noise(at(260_000.0), 1)) + 60.0 * noise(at(70_000.0), 2);
    // Where there are no ranges some country is flat and some rolls.
    let rolling = (0.5 + 0.9 * noise(at(90_000.0), 3)).clamp(0.06, 1.0);
    let hills_m = (25.0 + 150.0 * rolling + 0.12 * crest_m.min(1_500.0))
        * (1.0 - CLEARED[1] * town)
        * (0.5 + octaves(at(HILL_M), HILL_M, spacing_m));
    let mut height_m = rise * (plain_m.max(8.0) + hills_m);
    if crest_m > 1.0 {
        // The highest peaks stand over the main crest by a quarter.
        let ridges_m = (crest_m - floor_m) * (1.0 - CLEARED[0] * town) * 1.3 * ridges(at(MOUNTAIN_M), spacing_m);
        let mountains_m = (floor_m + ridges_m) * (0.35 + 0.65 * (crest_m / 900.0).min(1.0));
        height_m += rise.min(1.0 - (-shore_m / 3_000.0).exp()) * mountains_m;
    }
    // The beach: what is near the sea is low, whatever else holds.
    height_m.min(0.5 * shore_m + 1.0).max(0.0)
}

/// Rolling noise: -0.5 to 0.5 or so.
fn octaves(mut p: DVec3, mut wavelength_m: f64, spacing_m: f64) -> f64 {
    let (mut sum, mut amplitude) = (0.0, 0.5);
    for octave in 0..HILL_OCTAVES {
        let there = kept(wavelength_m, spacing_m);
        if there <= 0.0 {
            break;
        }
        sum += there * amplitude * noise(p, 20 + octave as u32);
        (p, wavelength_m, amplitude) = (turned(p), 0.5 * wavelength_m, 0.46 * amplitude);
    }
    sum
}

/// Ridged noise (Musgrave 1994): crests where noise crosses zero, finer crests on the coarser ones; 0 to about 1.
fn ridges(mut p: DVec3, spacing_m: f64) -> f64 {
    let (mut sum, mut amplitude, mut wavelength_m, mut weight) = (0.0, 0.5, MOUNTAIN_M, 1.0);
    for octave in 0..MOUNTAIN_OCTAVES {
        let there = kept(wavelength_m, spacing_m);
        if there <= 0.0 {
            // What is left out is there on the mean.
            sum += 0.42 * weight * amplitude * 2.1;
            break;
        }
        let crest = 1.0 - noise(p, 40 + octave as u32).abs() * 1.6;
        let crest = crest.max(0.0) * crest.max(0.0);
        sum += amplitude * weight * (crest * there + 0.42 * (1.0 - there));
        weight = (crest * 1.6).clamp(0.25, 1.0);
        (p, wavelength_m, amplitude) = (turned(p), 0.5 * wavelength_m, 0.52 * amplitude);
    }
    sum
}

/// How much of an octave is there at a spacing: shorter than two spacings it would only be noise between the nodes.
fn kept(wavelength_m: f64, spacing_m: f64) -> f64 {
    if spacing_m <= 0.0 { 1.0 } else { (wavelength_m / (2.0 * spacing_m) - 1.0).clamp(0.0, 1.0) }
}

/// Twice the frequency along axes turned by an angle of no symmetry, so that lattices of two octaves never line up.
fn turned(p: DVec3) -> DVec3 {
    DVec3::new(1.6 * p.y + 1.2 * p.z, -1.6 * p.x + 0.72 * p.y - 0.96 * p.z, -1.2 * p.x - 0.96 * p.y + 1.28 * p.z)
}
