//! What clouds over a city send down again of its light: the ground around it is lit by its own glow.
//!
//! *What it is.* Illuminance of the ground, a tenth of a lux and more under an overcast over a large city. *How we compute it.* A
//! level sheet at a height is lit from below by what lies within about that height, and lights the ground in the same way: the
//! two together are as smooth as one sheet some 1.6 times as high would be lit. *How we read it.* Levels of the lamps' own grids are
//! about as smooth as that, a finer and a coarser one for its long tail; so nothing is made or held for it.

use crate::passes::relief::LEVELS;
use crate::passes::relief::field::Grids;
use glam::Vec2;

/// A level's spacing over the height of the sheet.
const SPACING: f32 = 2.1;
/// The coarser level stands for the tail.
const WIDER: f32 = 1.6;
const TAIL: f32 = 0.4;

/// The level that is as smooth as light from a sheet at a height, of grids with a first spacing.
pub fn level(height_m: f32, spacing_m: f32) -> f32 {
    (SPACING * height_m / spacing_m).max(1.0).log2().min((LEVELS - 1) as f32)
}

/// Light of the cities around as the sheet sends it down, as a share of a core's; `own`: the level that the place is read from
/// otherwise.
pub fn share(grids: &Grids, place_m: Vec2, own: f32, level: f32) -> f32 {
    let level = level.max(own);
    let wide = (level + WIDER).min((LEVELS - 1) as f32);
    (1.0 - TAIL) * grids.light(place_m, level) + TAIL * grids.light(place_m, wide)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geo::charts::{CHARTS, coordinate_of};
    use crate::geo::terrain::Terrain;
    use crate::passes::ground::lights::tile;
    use crate::passes::relief::Relief;
    use crate::passes::relief::window::{Tiles, Window};
    use glam::DVec3;
    use std::f32::consts::TAU;

    /// Rings about a place at which a sheet at a height gives and gets equal parts of the light.
    fn around(here: Vec2, height_m: f32) -> impl Iterator<Item = Vec2> {
        let (rings, spokes) = (16, 8);
        (0..rings * spokes).map(move |i| {
            let (ring, spoke) = ((i / spokes) as f32, (i % spokes) as f32);
            let part = (ring + 0.5) / rings as f32;
            let turn = TAU * (spoke + 0.5 * (ring % 2.0)) / spokes as f32;
            here + Vec2::from_angle(turn) * (height_m * (part / (1.0 - part)).sqrt())
        })
    }

    /// Illuminance of the ground by a sheet at a height that sends all light down again as a matt one does, as a share of a core's
    /// exitance: the mean over the sheet of the mean over the lamps below.
    fn integral(grids: &Grids, here: Vec2, height_m: f32) -> f32 {
        let below = |there: Vec2| around(there, height_m).map(|lamp| grids.light(lamp, 3.0)).sum::<f32>() / 128.0;
        around(here, height_m).map(below).sum::<f32>() / 128.0
    }

    #[test]
    fn levels_of_the_lamps_are_as_bright_as_a_sheet_makes_the_ground() {
        let (lat, lon) = (48.857f64.to_radians(), 2.352f64.to_radians());
        let paris = DVec3::new(lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin());
        let chart = (0..CHARTS)
            .min_by(|a, b| coordinate_of(*a, paris).length().total_cmp(&coordinate_of(*b, paris).length()))
            .expect("there are charts");
        let place_m = coordinate_of(chart, paris);
        let window = Window::around(Terrain::ELLIPSOID, chart, place_m, 30.0);
        let lights = Tiles::default().filled(&window, tile);
        let level_of = |level: usize| {
            let at = window.nodes(level, place_m);
            [at.x, at.y, window.level_spacing_m(level), window.shore_unit_m(level)].map(|v| v as f32)
        };
        let relief = Relief {
            a: [1.0, 0.0],
            c: [0.0; 2],
            stretch: [1.0; 2],
            spacing_m: 30.0,
            highest_m: 0.0,
            level: std::array::from_fn(level_of),
        };
        let grids = Grids { relief: &relief, nodes: &[], lights: Some(&lights) };
        for height_m in [500.0, 1_000.0, 2_000.0] {
            for east_m in [0.0, 6_000.0, 12_000.0, 18_000.0, 25_000.0] {
                let there = Vec2::new(east_m, 0.0);
                let (found, exact) =
                    (share(&grids, there, 0.0, level(height_m, 30.0)), integral(&grids, there, height_m));
                println!("{height_m} {east_m}: {found:.4} {exact:.4}");
                // Two levels stand for the sheet's light; suburbs outside have a tenth of the city's.
                let apart = if exact > 0.2 { 1.35 } else { 2.0 };
                assert!(found < apart * exact && exact < apart * found, "{height_m} {east_m}: {found} {exact}");
            }
        }
    }
}
