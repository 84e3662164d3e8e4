//! Light on its way down through the layers of one weather: what is above each of them, at the eye, and at the ground.

use super::air::Left;
use crate::clouds::{CloudKind, cell};
use crate::passes::light::ASYMMETRY;
use crate::world::snapshot::LayerState;
use glam::Vec3;

/// Light at one height: on a plane facing the source, and on a horizontal plane from all the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Lux per colour, facing the source.
    pub direct_lux: Vec3,
    /// Lux per colour, horizontal.
    pub diffuse_lux: Vec3,
}

impl Level {
    const DARK: Self = Self { direct_lux: Vec3::ZERO, diffuse_lux: Vec3::ZERO };

    /// Lux per colour on a horizontal plane, the source's cosine against the zenith given.
    pub fn horizontal_lux(&self, up: f32) -> Vec3 {
        self.direct_lux * up.max(0.0) + self.diffuse_lux
    }

    /// Levels in proportions that add up to 1.
    pub fn mixed(parts: impl Iterator<Item = (f32, Self)>) -> Self {
        parts.fold(Self::DARK, |sum, (share, part)| Self {
            direct_lux: sum.direct_lux + part.direct_lux * share,
            diffuse_lux: sum.diffuse_lux + part.diffuse_lux * share,
        })
    }
}

/// The light of a sky without clouds.
pub struct ClearSky<'a> {
    /// At a height.
    pub at: &'a dyn Fn(f32) -> Level,
    /// At the eye.
    pub eye: Level,
    /// At the ground.
    pub ground: Level,
    /// Cosine of the source's direction against the zenith, kept above 0.
    pub mu: f32,
}

/// The light under one weather.
#[derive(Clone, Debug)]
pub struct Column {
    /// Above all layers.
    pub top: Level,
    /// The height that this is told for, m.
    pub top_m: f32,
    /// Above each layer, by its index.
    pub above: Vec<Level>,
    /// Light that comes up to each layer from what lies below it, by its index: lux per colour on a level plane.
    pub below_lux: Vec<Vec3>,
    /// At the eye, were it under this weather.
    pub eye: Level,
    /// At the ground.
    pub ground: Level,
    /// Share of light from below that the layers send down again, and the height that they have for it, m.
    pub underside: [f32; 2],
    /// What all layers leave of the air's light.
    pub left: Left,
}

/// Share of its light that the ground sends back.
pub const GROUND_ALBEDO: f32 = 0.13;

/// Lowest height at which the light above all layers is told, m.
const LEAST_TOP_M: f32 = 1_000.0;

impl Column {
    /// The light under layers that rise without overlap.
    pub fn new(layers: &[LayerState], clear: &ClearSky, eye_m: f64) -> Self {
        let top_m = layers.last().map_or(0.0, |l| l.base_m + l.thickness_m) as f32;
        let (top, mu) = ((clear.at)(top_m.max(LEAST_TOP_M)), clear.mu);
        let mut now = top;
        let mut eye = clear.eye;
        let mut above = vec![top; layers.len()];
        for (i, layer) in layers.iter().enumerate().rev() {
            above[i] = now;
            let through = pass(layer, now, mu);
            let share = ((eye_m - layer.base_m) / layer.thickness_m).clamp(0.0, 1.0) as f32;
            eye = pass_share(eye, now, through, 1.0 - share);
            now = through;
        }
        // The air below the layers takes its part too.
        let lower = |above: Vec3, clear: Vec3, top: Vec3| above * (clear / top.max(Vec3::splat(1e-9))).min(Vec3::ONE);
        let ground = Level {
            direct_lux: lower(now.direct_lux, clear.ground.direct_lux, top.direct_lux),
            // And it scatters what of the source's light comes down to it.
            diffuse_lux: lower(now.diffuse_lux, clear.ground.diffuse_lux.max(0.9 * top.diffuse_lux), top.diffuse_lux)
                + (clear.ground.diffuse_lux - top.diffuse_lux).max(Vec3::ZERO)
                    * (now.direct_lux / top.direct_lux.max(Vec3::splat(1e-9))),
        };
        let mut up_lux = ground.horizontal_lux(mu) * GROUND_ALBEDO;
        let mut below_lux = Vec::with_capacity(layers.len());
        for (layer, above) in layers.iter().zip(&above) {
            below_lux.push(up_lux);
            up_lux = sent_up(layer, *above, up_lux, mu);
        }
        let left = Left::new(layers, &above, &below_lux, clear, eye_m as f32);
        Self { top, top_m: top_m.max(LEAST_TOP_M), above, below_lux, eye, ground, underside: underside(layers), left }
    }

    /// The light under layers that stand among those around them: indices count the former alone.
    pub fn standing_in(own: &[LayerState], around: &[LayerState], clear: &ClearSky, eye_m: f64) -> Self {
        let mut all: Vec<(bool, LayerState)> = around.iter().map(|layer| (false, *layer)).collect();
        all.extend(own.iter().map(|layer| (true, *layer)));
        // Those that are lit first stand last.
        all.sort_by(|(_, a), (_, b)| (a.base_m + a.thickness_m).total_cmp(&(b.base_m + b.thickness_m)));
        let layers: Vec<LayerState> = all.iter().map(|(_, layer)| *layer).collect();
        let mut column = Self::new(&layers, clear, eye_m);
        let mut is_own = all.iter().map(|(own, _)| *own);
        column.above.retain(|_| is_own.next().unwrap_or(false));
        let mut is_own = all.iter().map(|(own, _)| *own);
        column.below_lux.retain(|_| is_own.next().unwrap_or(false));
        column
    }

    /// A column on its way from one to another of the same layers.
    pub fn between(from: &Self, to: &Self, share: f32) -> Self {
        let level = |a: &Level, b: &Level| Level::mixed([(1.0 - share, *a), (share, *b)].into_iter());
        let mix = |a: f32, b: f32| a + (b - a) * share;
        Self {
            top: level(&from.top, &to.top),
            top_m: mix(from.top_m, to.top_m),
            left: Left::mixed([(1.0 - share, &from.left), (share, &to.left)].into_iter()),
            above: from.above.iter().zip(&to.above).map(|(a, b)| level(a, b)).collect(),
            below_lux: from.below_lux.iter().zip(&to.below_lux).map(|(a, b)| a.lerp(*b, share)).collect(),
            eye: level(&from.eye, &to.eye),
            ground: level(&from.ground, &to.ground),
            underside: [0, 1].map(|k| mix(from.underside[k], to.underside[k])),
        }
    }
}

/// Share of light from below that layers send down again, and the mean of their bases by their parts in it, m.
fn underside(layers: &[LayerState]) -> [f32; 2] {
    let (mut open, mut back, mut moment) = (1.0, 0.0, 0.0);
    for layer in layers {
        let returned = cover(layer) * (1.0 - diffuse_shares(layer, 1.0).1);
        // Up through what lies below and down again.
        let part = open * open * returned;
        (back, moment) = (back + part, moment + part * layer.base_m as f32);
        open *= 1.0 - returned;
    }
    [back, if back > 0.0 { moment / back } else { 0.0 }]
}

/// Share of the sky that a layer hides: of a storm cell, whose coverage is how far it has grown, that of its square.
pub(super) fn cover(layer: &LayerState) -> f32 {
    if layer.kind == CloudKind::StormCell { cell::cover(layer.coverage as f32) } else { layer.coverage as f32 }
}

/// Share of a layer's optical depth that is left where there is cloud: cells are neither boxes nor whole throughout. From
/// the density volumes: 0.15 at small cover, rising to 0.6 (nimbostratus) to 0.9 (cirrus) when the sky is covered.
fn filled(cover: f32) -> f32 {
    0.16 + 0.64 * cover.powi(4)
}

/// Light that leaves a layer upwards: what comes up through it, and what it sends back of the light from above.
fn sent_up(layer: &LayerState, above: Level, below_lux: Vec3, mu: f32) -> Vec3 {
    let cover = cover(layer);
    let (from_source, from_sky) = diffuse_shares(layer, mu);
    below_lux * (1.0 - cover + cover * from_sky)
        + (above.direct_lux * (mu * (1.0 - from_source)) + above.diffuse_lux * (1.0 - from_sky)) * cover
}

/// Shares of the source's light at a cosine, and of even light from one side, that pass a layer's cloud (Eddington).
fn diffuse_shares(layer: &LayerState, mu: f32) -> (f32, f32) {
    let depth = depth(layer);
    let reduced = 4.0 / 3.0 + (1.0 - ASYMMETRY) * depth;
    (((2.0 / 3.0 + mu) / reduced).min(1.0), ((4.0 / 3.0) / reduced).min(1.0))
}

/// Optical depth of a layer where it has cloud.
pub(super) fn depth(layer: &LayerState) -> f32 {
    let whole = layer.kind.appearance().extinction_per_m * (layer.density * layer.thickness_m) as f32;
    filled(cover(layer)) * whole
}

/// Light below a layer: what its gaps let through and what it transmits diffusely (Eddington, see `passes::light`).
pub(super) fn pass(layer: &LayerState, above: Level, mu: f32) -> Level {
    let cover = cover(layer);
    let (depth, (from_source, from_sky)) = (depth(layer), diffuse_shares(layer, mu));
    Level {
        direct_lux: above.direct_lux * (1.0 - cover * (1.0 - (-depth / mu).exp())),
        diffuse_lux: above.diffuse_lux * (1.0 - cover + cover * from_sky)
            + above.direct_lux * (cover * mu * (from_source - (-depth / mu).exp()).max(0.0)),
    }
}

/// Applies a share of what a layer does to the light at the eye.
fn pass_share(eye: Level, above: Level, below: Level, share: f32) -> Level {
    let apply = |eye: Vec3, above: Vec3, below: Vec3| {
        let ratio = below / above.max(Vec3::splat(1e-9));
        eye * (Vec3::ONE + (ratio - Vec3::ONE) * share)
    };
    Level {
        direct_lux: apply(eye.direct_lux, above.direct_lux, below.direct_lux),
        diffuse_lux: apply(eye.diffuse_lux, above.diffuse_lux, below.diffuse_lux),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clouds::coverage::Coverage;
    use crate::clouds::density::{DensityVolume, HEIGHT, WIDTH};
    use crate::clouds::modulation;
    use crate::plan::scenes;

    #[test]
    fn thin_layers_let_through_no_more_light_than_there_is_and_none_is_no_layer() {
        let level = Level { direct_lux: Vec3::splat(100_000.0), diffuse_lux: Vec3::splat(12_000.0) };
        let clear = ClearSky { at: &|_| level, eye: level, ground: level, mu: 0.64 };
        let under = |layers: &[LayerState]| Column::new(layers, &clear, 0.0).ground.horizontal_lux(0.64).y;
        let none = under(&[]);
        for density in [0.0, 0.3, 1.0, 5.0, 50.0] {
            let veil = scenes::layer(CloudKind::Cirrostratus, 8_000.0, 500.0);
            let lux = under(&[LayerState { coverage: 1.0, density, ..veil }]);
            assert!(lux <= none * 1.0001, "{density}: {lux} of {none}");
            assert!(density > 0.0 || lux > none * 0.9999, "{lux} of {none}");
        }
        let nothing = LayerState { coverage: 0.0, ..scenes::layer(CloudKind::Cirrus, 10_000.0, 500.0) };
        assert!((under(&[nothing]) / none - 1.0).abs() < 1e-4);
    }

    #[test]
    fn the_filled_share_is_that_of_the_volumes() {
        for kind in [CloudKind::Stratus, CloudKind::Cumulus] {
            let (shape, map, edge) = (&DensityVolume::of(kind).shape, modulation::map(), kind.appearance().edge);
            for cover in [0.3, 0.6, 1.0] {
                let threshold = Coverage::of(kind).threshold(cover);
                let (mut whole, mut covered) = (0.0, 0.0);
                // A column in 37 of the tile, under a place of the map that has nothing to do with it.
                for column in (0..WIDTH * WIDTH).step_by(37) {
                    let above = f32::from(map[column * 7_919 % map.len()]) / 255.0;
                    let theta = threshold.offset + threshold.patchiness * above;
                    let at = |z: usize| f32::from(shape[column + z * WIDTH * WIDTH]) / 255.0;
                    let depth: f32 = (0..HEIGHT).map(|z| ((at(z) - theta) / edge).clamp(0.0, 1.0)).sum();
                    whole += depth / HEIGHT as f32;
                    covered += if depth > 0.5 { 1.0 } else { 0.0 };
                }
                let found = whole / covered;
                // One formula for genera that differ: within a third of each.
                assert!((found / filled(cover) - 1.0).abs() < 0.34, "{kind:?} at {cover}: {found} {}", filled(cover));
            }
        }
    }
}
