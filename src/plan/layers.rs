//! The cloud layers in sight, with every number that the light and deck passes read.

use super::cells::{Cell, bound, outlines};
use super::eye::Eye;
use super::illuminance::Illuminance;
use super::regions::NearRegion;
use super::relight::Bare;
use super::{LayerPlan, PassNote};
use crate::clouds::coverage::Coverage;
use crate::clouds::{CloudKind, clearance, density, modulation, slices};
use crate::geo::charts::weights;
use crate::passes::common::Chart;
use crate::passes::deck::clumps::VARIED_M;
use crate::passes::deck::twin::OPAQUE;
use crate::passes::deck::{FLASHES, Flash, Layer};
use crate::passes::light::encoding::Encoding;
use crate::passes::light::grid::corners;
use crate::passes::light::{LEAVING, Light, Nodes};
use crate::world::snapshot::{LayerState, Snapshot};
use glam::{DVec3, Vec2, Vec3};

/// No layer is drawn beyond this range: behind it is only haze at any visibility that the limits allow below 300 km.
const FARTHEST_M: f64 = 300_000.0;
/// Radius of the first ring around the eye.
const FIRST_RING_M: f32 = 60.0;
/// Radius of the last ring: what lies beyond is behind the haze for level rays.
const LAST_RING_M: f32 = 150_000.0;

/// Share of a distance in the tile that is one on the ground for certain: waves that move the tile and charts draw it out.
const CLEAR_SHARE: f32 = 0.75;

/// Ranges in periods of its tile, across, between which detail fades.
const DETAIL_FADE: [f32; 2] = [4.0, 13.0];
/// How far towards the light the detail is looked at that shades a place, in periods: a third of a large heap. It stands for
/// twice that way.
const RELIEF: f32 = 0.05;
/// Most that detail makes of a difference in light, as an exponent for a detail of 1 instead of its mean.
const MOST_RELIEF: f32 = 1.3;
/// Factor on clumps of detail (their spread is 0.2) in the density around the eye: a spread of 0.45 of the mean, as airborne probes find
/// in stratocumulus and cumulus over hundreds of metres.
const VARIED: f32 = 2.8;
/// Period of the finer clumps, m: the largest are a sixth of it, the smallest some thirty metres.
const CLUMPS_M: f32 = 750.0;

/// How far something at a height can be seen over the curved Earth.
pub fn extent_m(eye: &Eye, height_m: f64) -> f64 {
    let reach = |h: f64| (2.0 * eye.earth_m * h.max(0.0)).sqrt();
    (reach(eye.height_m) + reach(height_m)).clamp(2_000.0, FARTHEST_M)
}

/// Flashes that light as points, brightest at the eye first.
pub fn flashes(bare: &[Bare], eye: &Eye, notes: &mut Vec<PassNote>) -> Vec<Flash> {
    let mut lit: Vec<Flash> = bare
        .iter()
        .map(|b| Flash {
            position_m: eye.place(&b.flash.position).into(),
            intensity: b.intensity_cd as f32 * 0.079_577_47,
        })
        .collect();
    let strength = |f: &Flash| {
        let eye = Vec3::new(0.0, 0.0, eye.height_m as f32);
        f.intensity / (Vec3::from(f.position_m) - eye).length_squared().max(1.0)
    };
    lit.sort_by(|a, b| strength(b).total_cmp(&strength(a)));
    let why = match lit.len() {
        0 => "no flash gives light as a point in this frame".to_string(),
        n if n > FLASHES => {
            format!("{n} flashes give light, the brightest {FLASHES} are drawn, less the light of the next")
        }
        n => format!("{n} flashes give light"),
    };
    if let Some(next) = lit.get(FLASHES).map(strength) {
        // A flash comes and goes at the cut with no light.
        for flash in &mut lit[..FLASHES] {
            flash.intensity *= 1.0 - next / strength(flash);
        }
    }
    notes.push(PassNote { pass: "flash", kept: !lit.is_empty(), why });
    lit.truncate(FLASHES);
    lit
}

/// Layers in sight, lowest base first.
pub fn in_sight(
    snapshot: &Snapshot,
    eye: &Eye,
    light: &Illuminance,
    regions: &[NearRegion],
    flashes: &[Flash],
    notes: &mut Vec<PassNote>,
) -> Vec<LayerPlan> {
    let context = Context { snapshot, eye, light, regions, flashes };
    let mut plans = Vec::new();
    let weathers = std::iter::once(&snapshot.weather).chain(regions.iter().map(|region| &region.state.weather));
    for (column, weather) in weathers.enumerate() {
        for (i, layer) in weather.layers.iter().enumerate() {
            plans.extend(context.layer(layer, column, i, notes));
        }
    }
    if plans.is_empty() {
        notes.push(PassNote { pass: "deck", kept: false, why: "no layer in sight has cloud".into() });
    }
    plans.sort_by(|a, b| a.layer.base_m.total_cmp(&b.layer.base_m));
    plans
}

struct Context<'a> {
    snapshot: &'a Snapshot,
    eye: &'a Eye,
    light: &'a Illuminance,
    regions: &'a [NearRegion<'a>],
    flashes: &'a [Flash],
}

impl Context<'_> {
    /// Layer `index` of a weather: the global one's (column 0) or that of a region in sight (from 1).
    fn layer(&self, state: &LayerState, column: usize, index: usize, notes: &mut Vec<PassNote>) -> Option<LayerPlan> {
        let above = self.light.columns[column].above[index];
        let mut note = |kept, why: String| notes.push(PassNote { pass: "deck", kept, why });
        let name = format!("{:?} at {:.0} m", state.kind, state.base_m);
        if state.coverage < 1e-3 || state.density <= 0.0 {
            note(false, format!("{name} has no cloud (coverage {:.3}, density {:.3})", state.coverage, state.density));
            return None;
        }
        let top_m = state.base_m + state.thickness_m;
        let extent = extent_m(self.eye, top_m);
        let region = column.checked_sub(1).map(|i| &self.regions[i]);
        let cell = region.and_then(|region| Cell::of(state, &region.state.shape));
        let (near, charts) = match &cell {
            Some(cell) => cell.charts(self.eye),
            None => self.eye.charts(state.drift, extent, f64::from(density::TILE_M)),
        };
        // What the tile is smaller than the cell: light and distances are made for the tile.
        let scale = cell.as_ref().map_or(1.0, Cell::scale);
        let look = state.kind.appearance();
        let threshold = Coverage::of(state.kind).threshold(state.coverage as f32);
        let quality = self.snapshot.quality;
        let extinction = look.extinction_per_m * state.density as f32;
        let tile = look.detail_tile_m;
        let origin = near.first().map_or([0.0; 2], |c| {
            let periods = [c.origin_m.x / f64::from(tile[0]), c.origin_m.y / f64::from(tile[1])];
            periods.map(|v| v.rem_euclid(1.0) as f32)
        });
        // Detail lies in the nearest chart alone: it is gone where the next chart becomes the nearest, so that it never steps.
        let detail_share = weights(&near, DVec3::Z).first().map_or(0.0, |w| (2.0 * w - 1.0).clamp(0.0, 1.0)) as f32;
        let outline = outlines(self.regions, column, state, self.eye);
        let (bound_m, bound_radius_m) = region.map_or(([0.0; 3], 0.0), |region| bound(region, state, self.eye));
        let mut outside_m = (state.base_m - self.eye.height_m).max(self.eye.height_m - top_m) as f32;
        if bound_radius_m > 0.0 {
            let away = Vec3::from(bound_m) - Vec3::new(0.0, 0.0, self.eye.height_m as f32);
            outside_m = outside_m.max(away.length() - bound_radius_m);
        }
        let mut flash = [Flash::default(); FLASHES];
        flash[..self.flashes.len()].copy_from_slice(self.flashes);
        let nodes = Nodes::around(threshold.offset, threshold.patchiness, look.edge);
        let layer = Layer {
            light_lux: (above.direct_lux * self.light.reddening(column, top_m)).into(),
            base_m: state.base_m as f32,
            light_direction: self.light.source.into(),
            thickness_m: state.thickness_m as f32,
            sky_lux: (above.diffuse_lux * 0.079_577_47).into(),
            extinction_per_m: extinction,
            ground_lux: self.light.upwelling_lux(column, index).into(),
            inverse_edge: 1.0 / look.edge,
            theta: threshold.offset,
            patchiness: threshold.patchiness,
            spacing_m: slices::spacing_m(quality.slices, state.thickness_m as f32),
            ring_ratio: quality.ring_ratio as f32,
            ring_first_m: FIRST_RING_M,
            ring_last_m: LAST_RING_M.min(extent as f32),
            extent_m: extent as f32,
            detail: look.detail * detail_share,
            charts: near.len() as u32,
            regions: self.regions.len() as u32,
            flashes: self.flashes.len() as u32,
            region: column as u32,
            detail_origin: origin,
            detail_per_m: [1.0 / (scale * tile[0]), 1.0 / (scale * tile[1]), 1.0 / tile[2]],
            detail_fade_m: DETAIL_FADE.map(|periods| periods * tile[1]),
            relief_m: RELIEF * tile[1],
            relief_depth: (extinction * look.detail * detail_share * RELIEF * tile[1] / look.edge * 2.0 * LEAVING)
                .min(MOST_RELIEF),
            reach_m: 0.3 * density::TILE_M / look.elements[0].max(look.elements[1]) as f32 / scale,
            step_m: (1_200.0 / quality.slices as f32).max(4.0),
            hidden_below: OPAQUE,
            clear_rise: clearance::STRETCH * look.usual_thickness_m / (scale * state.thickness_m as f32),
            clear_share: CLEAR_SHARE / scale,
            theta_slope_per_m: threshold.patchiness * modulation::steepest_per_m(),
            light_low: nodes.theta(0),
            light_per_theta: 1.0 / nodes.step,
            light_nodes: nodes.count as f32,
            light_encoding: quality.light_encoding as u32,
            shade_height_m: 0.0,
            shade_near_m: 1.0,
            shade_span: 0.0,
            low_light: self.light.lower(state.base_m, top_m).into(),
            pad0: 0.0,
            bound_m,
            bound_radius_m,
            varied: if outside_m < VARIED_M[1] { VARIED * detail_share } else { 0.0 },
            clumps_finer: (scale * tile[1] / CLUMPS_M).round().max(1.0),
            chart: charts,
            outline,
            flash,
        };
        let towards: Vec<[f32; 3]> =
            charts[..near.len()].iter().map(|chart| in_chart(chart, self.light.source)).collect();
        let lights = towards
            .iter()
            .map(|towards| light_params(*towards, nodes, &layer, scale, state.kind, quality.light_encoding))
            .collect();
        note(
            true,
            format!("{name} covers {:.2} of the sky, {} slices, {} charts", state.coverage, quality.slices, near.len()),
        );
        Some(LayerPlan { kind: state.kind, slices: quality.slices, layer, light: lights, towards, shade: Vec::new() })
    }
}

/// A direction (east, north, up) in the axes of a chart: the chart's factor turns the eye's axes into the volume's, its length
/// is the chart's scale.
fn in_chart(chart: &Chart, d: Vec3) -> [f32; 3] {
    let a = Vec2::from(chart.a).normalize_or(Vec2::X);
    [a.x * d.x - a.y * d.y, a.x * d.y + a.y * d.x, d.z]
}

/// Parameters of a light volume at the tile's scale, where depths are the same; thickness and extinction are rounded to about one per cent, so that volumes serve for a while.
fn light_params(
    towards: [f32; 3],
    nodes: Nodes,
    layer: &Layer,
    scale: f32,
    kind: CloudKind,
    encoding: Encoding,
) -> Light {
    let one_per_cent = |v: f32| ((v.ln() * 100.0).round() / 100.0).exp();
    Light {
        corners: corners(towards),
        nodes,
        voxel_height_m: one_per_cent(layer.thickness_m * scale) / density::HEIGHT as f32,
        extinction_per_m: one_per_cent(layer.extinction_per_m / scale),
        inverse_edge: layer.inverse_edge,
        bounded: kind.is_bounded(),
        encoding,
    }
}
