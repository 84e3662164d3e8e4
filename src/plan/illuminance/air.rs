//! What the clouds of the weathers around the eye leave of the light in the air: see [`crate::passes::sky::shade`].

use super::column::{self, ClearSky, Level};
use crate::clouds::density::TILE_M;
use crate::passes::common::smoothstep;
use crate::passes::sky::shade::{NODES, Shade};
use crate::world::snapshot::LayerState;
use glam::Vec3;

/// A cover from which on all of a layer stands before what is behind it.
const STANDS_BEFORE: f32 = 0.2;
/// A share of the direct light that nobody sees.
const NOTHING: f32 = 1e-3;

/// What the clouds of one weather leave of the air's light.
#[derive(Clone, Debug)]
pub struct Left {
    direct: [f32; NODES],
    diffuse: [Vec3; NODES],
    /// The lower end of the air before the clouds, m, and 1 over the upper one.
    before: [f32; 2],
}

impl Left {
    /// That of layers that rise without overlap, with the light above each and that which comes up to it.
    pub fn new(layers: &[LayerState], above: &[Level], below_lux: &[Vec3], clear: &ClearSky, eye_m: f32) -> Self {
        let levels = levels(layers, above, below_lux, clear);
        let nodes: [_; NODES] = std::array::from_fn(|node| at(&levels, Shade::height_m(node)));
        Self { direct: nodes.map(|n| n.0), diffuse: nodes.map(|n| n.1), before: before(layers, eye_m) }
    }

    /// What several leave, in proportions that add up to 1.
    pub fn mixed<'a>(parts: impl Iterator<Item = (f32, &'a Self)>) -> Self {
        let none = Self { direct: [0.0; NODES], diffuse: [Vec3::ZERO; NODES], before: [0.0; 2] };
        parts.fold(none, |sum, (share, part)| Self {
            direct: std::array::from_fn(|node| sum.direct[node] + share * part.direct[node]),
            diffuse: std::array::from_fn(|node| sum.diffuse[node] + part.diffuse[node] * share),
            before: [0, 1].map(|k| sum.before[k] + share * part.before[k]),
        })
    }

    /// The same for the sky's table; `None` where clouds leave all. Rounded, so that the table is made a few times while a weather eases in.
    pub fn shade(&self, eye_m: f32) -> Option<Shade> {
        // In steps of 3 %, which no picture shows.
        let even = |v: f32| ((v.max(1e-4).ln() * 32.0).round() / 32.0).exp();
        let direct = self.direct.map(|v| if v < NOTHING { 0.0 } else { even(v).min(1.0) });
        let diffuse = self.diffuse.map(|v| Vec3::new(even(v.x), even(v.y), even(v.z)));
        let all = direct.iter().all(|v| *v == 1.0) && diffuse.iter().all(|v| *v == Vec3::ONE);
        let [low_m, inverse_high] = self.before;
        let near_m = [(0.98 * even(low_m)).min(eye_m), (1.02 * even(1.0 / inverse_high.max(1e-9))).max(eye_m)];
        (!all).then_some(Shade { direct, diffuse, near_m })
    }
}

/// A layer's heights, and shares of direct and scattered light under it.
struct Under {
    base_m: f32,
    top_m: f32,
    direct: f32,
    diffuse: Vec3,
}

/// Layers from the top down.
fn levels(layers: &[LayerState], above: &[Level], below_lux: &[Vec3], clear: &ClearSky) -> Vec<Under> {
    let Some(top) = above.last() else { return Vec::new() };
    let usual = top.diffuse_lux + clear.ground.horizontal_lux(clear.mu) * column::GROUND_ALBEDO;
    let mut direct = 1.0;
    let below = |(i, layer): (usize, &LayerState)| {
        direct *= 1.0 - slanted_cover(layer, clear.mu) * (1.0 - (-column::depth(layer) / clear.mu).exp());
        let scattered = column::pass(layer, above[i], clear.mu).diffuse_lux + below_lux[i];
        Under {
            base_m: layer.base_m as f32,
            top_m: (layer.base_m + layer.thickness_m) as f32,
            direct,
            diffuse: scattered / usual.max(Vec3::splat(1e-12)),
        }
    };
    layers.iter().enumerate().rev().filter(|(_, layer)| column::cover(layer) > 0.0).map(below).collect()
}

/// Shares of direct and scattered light at a height under layers from the top down.
fn at(levels: &[Under], height_m: f32) -> (f32, Vec3) {
    levels.iter().fold((1.0, Vec3::ONE), |(direct, diffuse), under| {
        let depth = ((under.top_m - height_m) / (under.top_m - under.base_m).max(1.0)).clamp(0.0, 1.0);
        // Most of the light is lost in the upper part of a cloud.
        let share = 1.0 - (1.0 - depth).powi(3);
        (direct + (under.direct - direct) * share, diffuse.lerp(under.diffuse, share))
    })
}

/// Share of a slanted path, its cosine against the zenith given, that a layer's clouds stand in: heaps have flanks, and the share of
/// clear paths falls as the power `1 + height / width * tan` (Kauth and Penquite 1967; half their height here, since they narrow upwards).
fn slanted_cover(layer: &LayerState, mu: f32) -> f32 {
    let look = layer.kind.appearance();
    let width_m = TILE_M / look.elements[0].max(look.elements[1]) as f32;
    let flanks = 0.5 * look.heaped * layer.thickness_m as f32 / width_m;
    let tangent = (1.0 - mu * mu).max(0.0).sqrt() / mu;
    1.0 - (1.0 - column::cover(layer)).max(0.0).powf(1.0 + flanks * tangent)
}

/// Heights around an eye between which nothing but air lies, m: the lower one, and 1 over the upper one. In the clouds both run from
/// those below them to those above, so that nothing steps as an eye passes; nor does it where a layer eases in.
fn before(layers: &[LayerState], eye_m: f32) -> [f32; 2] {
    layers.iter().fold([0.0f32; 2], |[low, inverse_high], layer| {
        let base_m = (layer.base_m as f32).max(1.0);
        let thickness_m = ((layer.base_m + layer.thickness_m) as f32 - base_m).max(1.0);
        let there = smoothstep(0.0, STANDS_BEFORE, column::cover(layer));
        let share = ((eye_m - base_m) / thickness_m).clamp(0.0, 1.0);
        let inverse = (1.0 - share) / (base_m * (1.0 - share) + thickness_m * share);
        [low.max(there * share * (base_m + thickness_m)), inverse_high.max(there * inverse)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clouds::CloudKind;
    use crate::passes::sky::table::build;
    use crate::passes::sky::twin::endless;
    use crate::plan::{Output, plan, scenes};

    #[test]
    fn air_under_an_overcast_is_lit_by_what_comes_through_it() {
        let luminance = |coverage: f64| {
            let mut snapshot = scenes::sun(scenes::clear_day(), 25.0);
            snapshot.weather.visibility_m = 20_000.0;
            snapshot.ownship.position.altitude_m = 300.0;
            snapshot.weather.layers = vec![layer(coverage)];
            let plan = plan(&snapshot, &snapshot.views[0], Output::LinearRgb);
            assert_eq!(plan.table.shade.is_some(), coverage > 0.0);
            let table = build(&plan.table);
            let sun = Vec3::from(plan.sky.sun_direction);
            let across = Vec3::new(sun.y, -sun.x, 0.0).normalize();
            let ground = plan.ground.expect("the ground is in sight");
            (endless(&plan.sky, &table, across).y, ground.sky_lux[1], ground.light_lux[1] * sun.z)
        };
        // An endless column in light that comes evenly from a sky of E and a ground that sends back its albedo of it has the mean of
        // their radiances. Haze takes a tenth (its albedo), molecules are as bright; the solution for the clear air's own
        // vertical course, whose shape is kept, differs from an even one: within 40 %.
        let (under, sky_lux, _) = luminance(1.0);
        let even = sky_lux * (1.0 + column::GROUND_ALBEDO) / (2.0 * std::f32::consts::PI);
        assert!((under / even - 1.0).abs() < 0.4, "{under} cd/m2, and {even} of even light");
        // Without clouds the sun shines on it, and no clouds are asked.
        let (clear, sky_lux, sun_lux) = luminance(0.0);
        assert!(clear > 1.5 * under && clear < (sky_lux + sun_lux) / std::f32::consts::PI, "{clear} over {under}");
    }

    fn layer(coverage: f64) -> LayerState {
        LayerState { coverage, ..scenes::layer(CloudKind::Stratocumulus, 1_000.0, 600.0) }
    }

    #[test]
    fn before_the_clouds_lies_all_up_to_them_and_nothing_steps_on_the_way_through() {
        let layers = [layer(1.0)];
        assert_eq!(before(&layers, 400.0), [0.0, 1e-3]);
        assert_eq!(before(&layers, 3_000.0), [1_600.0, 0.0]);
        let mut last = before(&layers, 900.0);
        for eye_m in 901..1_700 {
            let now = before(&layers, eye_m as f32);
            assert!(now[0] <= eye_m as f32 + 1e-3 && now[1] * eye_m as f32 <= 1.0 + 1e-5, "{eye_m}: {now:?}");
            assert!((now[0] - last[0]).abs() < 4.0 && (now[1] - last[1]).abs() < 4e-6, "{eye_m}: {last:?} {now:?}");
            last = now;
        }
        // What hardly covers stands hardly before anything.
        let [low, inverse] = before(&[layer(0.01)], 3_000.0);
        assert!(low < 30.0 && inverse == 0.0, "{low}");
    }

    #[test]
    fn air_before_the_clouds_ends_at_the_next_layer_each_way_and_one_that_eases_in_does_not_step() {
        let cirrus = |coverage: f64| LayerState { coverage, ..scenes::layer(CloudKind::Cirrus, 9_000.0, 500.0) };
        assert_eq!(before(&[layer(1.0), cirrus(1.0)], 3_000.0), [1_600.0, 1.0 / 9_000.0]);
        let mut last = before(&[layer(1.0)], 3_000.0);
        for percent in 0..=30 {
            let now = before(&[layer(1.0), cirrus(f64::from(percent) / 100.0)], 3_000.0);
            assert!(now[0] == last[0] && (now[1] - last[1]).abs() < 0.1 / 9_000.0, "{percent} %: {last:?} {now:?}");
            last = now;
        }
    }

    #[test]
    fn heaps_stop_more_of_a_low_light_than_of_a_high_one() {
        let half = LayerState { coverage: 0.5, ..scenes::layer(CloudKind::Cumulus, 1_000.0, 1_000.0) };
        assert!((slanted_cover(&half, 1.0) - 0.5).abs() < 1e-6);
        let [high, low] = [0.9, 0.15].map(|mu| slanted_cover(&half, mu));
        assert!(high < 0.62 && low > 0.85, "{high} {low}");
        assert_eq!(slanted_cover(&layer(1.0), 0.5), 1.0);
    }
}
