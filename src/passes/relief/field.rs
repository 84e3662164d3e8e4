//! Twin of `field.wgsl`: height, slope and distance from the shore at a point around the eye, read from the window's grids.

use super::window::{HEIGHT_UNIT_M, WIDTH};
use super::{LEVELS, Relief};
use crate::geo::terrain::LOWEST_M;
use crate::passes::common::{displacement, stereographic};
use glam::{Vec2, Vec3};

/// Nodes from the eye to where a level goes over into the next.
pub const LEVEL_NODES: f32 = 76.0;
/// Share of a level over which it is itself; over the rest it goes over into the next.
const ITSELF: f32 = 0.6;

/// The grids and how they lie.
#[derive(Clone, Copy)]
pub struct Grids<'a> {
    /// Parameters.
    pub relief: &'a Relief,
    /// All nodes; see [`super::window::Tiles::nodes`].
    pub nodes: &'a [u32],
    /// City lights on the same grids; see [`crate::passes::ground::lights`].
    pub lights: Option<&'a [u32]>,
}

/// A place of the chart, from the eye, metres.
pub fn place(relief: &Relief, p: Vec3, earth_m: f32, radius_m: f32) -> Vec2 {
    let z = stereographic(p, earth_m, radius_m) * Vec2::from(relief.stretch);
    displacement(relief.a.into(), relief.c.into(), z)
}

/// Which level a place at a range from the eye is read from, as a number between two levels: by the distance over ground, and
/// seen from high above no finer than a pixel.
pub fn level(relief: &Relief, place_m: Vec2, range_m: f32) -> f32 {
    let nodes = place_m.length().max(0.25 * range_m) / (LEVEL_NODES * relief.spacing_m);
    nodes.max(1.0).log2().min((LEVELS - 1) as f32)
}

impl Grids<'_> {
    /// Height and distance from the shore (above 0 on land) at a place of the chart.
    pub fn at(&self, place_m: Vec2, level: f32) -> Vec2 {
        let low = (level as usize).min(LEVELS - 1);
        let share = ((level - low as f32 - ITSELF) * (1.0 / (1.0 - ITSELF))).max(0.0);
        let found = self.of_level(low, place_m);
        if share > 0.0 && low + 1 < LEVELS { found.lerp(self.of_level(low + 1, place_m), share) } else { found }
    }

    /// Mean luminance of lamps at a place, as a share of a city's core.
    pub fn light(&self, place_m: Vec2, level: f32) -> f32 {
        let Some(lights) = self.lights else { return 0.0 };
        let of_level = |level: usize| {
            let (first, f) = self.lies(level, place_m);
            let node = |i: usize| f32::from_bits(lights[i]);
            let between = |a: f32, b: f32, share: f32| a + (b - a) * share;
            let south = between(node(first), node(first + 1), f.x);
            between(south, between(node(first + WIDTH), node(first + WIDTH + 1), f.x), f.y)
        };
        let low = (level as usize).min(LEVELS - 1);
        let share = ((level - low as f32 - ITSELF) * (1.0 / (1.0 - ITSELF))).max(0.0);
        let found = of_level(low);
        if share > 0.0 && low + 1 < LEVELS { found + (of_level(low + 1) - found) * share } else { found }
    }

    /// The node to the south-west of a place, and where between the nodes it lies.
    fn lies(&self, level: usize, place_m: Vec2) -> (usize, Vec2) {
        let [east, north, spacing_m, _] = self.relief.level[level];
        let last = (WIDTH - 1) as f32 - 0.001;
        let at = (Vec2::new(east, north) + place_m / spacing_m).clamp(Vec2::ZERO, Vec2::splat(last));
        let low = at.floor();
        (level * WIDTH * WIDTH + low.y as usize * WIDTH + low.x as usize, at - low)
    }

    fn of_level(&self, level: usize, place_m: Vec2) -> Vec2 {
        let unit_m = self.relief.level[level][3];
        let (first, f) = self.lies(level, place_m);
        let node = |i: usize| {
            let bits = self.nodes[i];
            Vec2::new((bits & 0xffff) as f32, (bits >> 16) as f32)
        };
        let south = node(first).lerp(node(first + 1), f.x);
        let north = node(first + WIDTH).lerp(node(first + WIDTH + 1), f.x);
        let found = south.lerp(north, f.y);
        Vec2::new(found.x * HEIGHT_UNIT_M as f32 + LOWEST_M as f32, (found.y - 32_768.0) * unit_m)
    }

    /// Slope of the ground (rise to the east and to the north, in the eye's axes) at a place, over its level's spacing.
    pub fn slope(&self, place_m: Vec2, level: f32) -> Vec2 {
        let step_m = self.relief.spacing_m * level.exp2();
        let height = |east: f32, north: f32| self.at(place_m + Vec2::new(east, north) * step_m, level).x;
        let along =
            Vec2::new(height(1.0, 0.0) - height(-1.0, 0.0), height(0.0, 1.0) - height(0.0, -1.0)) * (0.5 / step_m);
        // The chart is turned against the eye's axes as its factor says; farther off it turns on, by a degree in 100 km.
        let a = Vec2::from(self.relief.a);
        Vec2::new(a.x * along.x + a.y * along.y, a.x * along.y - a.y * along.x)
    }
}
