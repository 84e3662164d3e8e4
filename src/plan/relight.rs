//! Which flashes light the picture by a field of scattered light, from what, and where it lies around the eye.
//!
//! A field hangs on the flash and the weather around it alone, as they were when the flash began: not on the eye, so that all
//! views share it, and not on the frame, so that strokes only change its brightness.

mod patch;

use super::PassNote;
use super::cells::{Cell, outlines};
use super::eye::Eye;
use super::layers::extent_m;
use super::regions::{self, NearRegion};
use crate::clouds::coverage::Coverage;
use crate::clouds::density;
use crate::geo::Geodetic;
use crate::geo::terrain::Terrain;
use crate::geo::wgs84::MEAN_RADIUS_M;
use crate::lightning::flash::Light;
use crate::lightning::strike::{Source, StrikeChannel};
use crate::passes::deck::{Layer, Region};
use crate::passes::relight::cloud::too_thin;
use crate::passes::relight::patch::bytes;
use crate::passes::relight::{FIELDS, Lighting, LitFlash, Placing, Point, Request};
use crate::world::command::Exposure;
use crate::world::snapshot::{FlashState, LayerState, OwnshipState, Snapshot, ViewState, WeatherState};
use bytemuck::Zeroable;
use glam::{DQuat, DVec3};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Points farther than this above or below a layer do not light it by a field, m.
const REACH_M: f64 = 6_000.0;
/// Optical depth of a layer up to which it has tables: a night's storm 9.5 km thick took minutes for one flash.
const DEEPEST: f32 = 60.0;
/// Points that stand for a channel: cells of the field are wider than its pieces are long.
const SOURCES: usize = 48;

/// A flash and how much of its light the picture takes as that of a bare point.
pub struct Bare<'a> {
    /// The flash.
    pub flash: &'a FlashState,
    /// Luminous intensity of the point, cd.
    pub intensity_cd: f64,
}

/// A part of a flash's channels that shines for itself: the channel to one ground point, with its branches or without. Strokes
/// that run through the same part only add up.
struct Part<'a> {
    flash: &'a FlashState,
    channel: u32,
    branches: bool,
    intensity_cd: f64,
    /// Illuminance at the eye if nothing were between, lux.
    strength: f64,
}

/// The flashes with a field, brightest at the eye first, and those (or the shares of those) that stay points.
///
/// The third list is of fields that the coming frames may ask for: the channel without its branches, while these shine.
pub fn split<'a>(
    snapshot: &'a Snapshot,
    eye: &Eye,
    notes: &mut Vec<PassNote>,
) -> (Vec<LitFlash>, Vec<Bare<'a>>, Vec<Arc<Request>>) {
    let all = points_of(snapshot);
    let method = snapshot.quality.relight;
    if all.is_empty() || method == Lighting::Point {
        let why = if all.is_empty() { "no flash gives light" } else { "flashes light clouds as points, as asked" };
        notes.push(note(false, why.into()));
        return (Vec::new(), all, Vec::new());
    }
    let mut parts: Vec<Part> = all.iter().flat_map(|bare| parts(bare.flash, eye)).collect();
    parts.sort_by(|a, b| b.strength.total_cmp(&a.strength).then(a.flash.id.cmp(&b.flash.id)));
    let next = parts.get(FIELDS).map_or(0.0, |part| part.strength);
    let (mut lit, mut points, mut ahead) = (Vec::new(), Vec::new(), Vec::new());
    for (rank, part) in parts.iter().enumerate() {
        let Part { flash, intensity_cd, .. } = *part;
        let Some((request, there)) = (rank < FIELDS).then(|| request(snapshot, part, method)).flatten() else {
            bare(&mut points, flash, intensity_cd);
            continue;
        };
        // A part comes to and leaves its place among the brightest with no light in its field.
        let share = 1.0 - next / part.strength.max(1e-30);
        lit.push(LitFlash { request: Arc::new(request), placing: placing(&there, eye, intensity_cd * share) });
        if share < 1.0 {
            bare(&mut points, flash, intensity_cd * (1.0 - share));
        }
    }
    for part in parts.iter().take(FIELDS).filter(|part| part.branches) {
        let same =
            |other: &&Part| (other.flash.id, other.channel, other.branches) == (part.flash.id, part.channel, false);
        if parts.iter().find(same).is_none() {
            ahead.extend(
                request(snapshot, &Part { branches: false, ..*part }, method).map(|(request, _)| Arc::new(request)),
            );
        }
    }
    let why = match (lit.len(), points.len()) {
        (0, _) => "no flash gives light to a cloud by a field".to_owned(),
        (fields, 0) => format!("{fields} fields of light by {}", by(&lit)),
        (fields, bare) => {
            format!("{fields} fields of light by {}; {bare} flashes are points, in part or whole", by(&lit))
        }
    };
    notes.push(note(!lit.is_empty(), why));
    (lit, points, ahead)
}

/// Names of the methods that find some fields' light: another than was asked for where a table is not worth making.
fn by(lit: &[LitFlash]) -> String {
    let methods: BTreeSet<Lighting> = lit.iter().map(|flash| flash.request.method).collect();
    methods.into_iter().map(Lighting::name).collect::<Vec<_>>().join(" and ")
}

/// Adds to a flash's light as a point: parts of one flash are one point.
fn bare<'a>(points: &mut Vec<Bare<'a>>, flash: &'a FlashState, intensity_cd: f64) {
    match points.iter_mut().find(|point| point.flash.id == flash.id) {
        Some(point) => point.intensity_cd += intensity_cd,
        None => points.push(Bare { flash, intensity_cd }),
    }
}

/// What of a flash shines in the shutter interval; one part while its channel is still being grown.
fn parts<'a>(flash: &'a FlashState, eye: &Eye) -> Vec<Part<'a>> {
    let mut amounts: BTreeMap<(u32, bool), f64> = BTreeMap::new();
    for light in flash.lights.iter().filter(|light| light.amount > 0.0) {
        *amounts.entry((light.channel, light.branches)).or_insert(0.0) += light.amount;
    }
    let all: f64 = amounts.values().sum();
    if all <= 0.0 {
        amounts = BTreeMap::from([((0, true), 1.0)]);
    }
    let all: f64 = amounts.values().sum();
    let own = DVec3::new(0.0, 0.0, eye.height_m);
    let square = (eye.place(&flash.position).as_dvec3() - own).length_squared().max(1.0);
    let part = |((channel, branches), amount): ((u32, bool), f64)| {
        let intensity_cd = flash.intensity_cd * amount / all;
        Part { flash, channel, branches, intensity_cd, strength: intensity_cd / square }
    };
    amounts.into_iter().map(part).collect()
}

/// All flashes that give light, as points.
pub fn points_of(snapshot: &Snapshot) -> Vec<Bare<'_>> {
    let giving = snapshot.flashes.iter().filter(|f| f.intensity_cd > 0.0);
    giving.map(|flash| Bare { flash, intensity_cd: flash.intensity_cd }).collect()
}

fn note(kept: bool, why: String) -> PassNote {
    PassNote { pass: "relight", kept, why }
}

/// An eye on the ground below a place: its axes are those of a field.
fn below(position: &Geodetic) -> Eye {
    let position = Geodetic { altitude_m: 0.0, ..*position };
    let ownship = OwnshipState { position, attitude: Default::default() };
    let view = ViewState {
        name: String::new(),
        size_px: [1, 1],
        field_of_view_deg: 60.0,
        offset_m: [0.0; 3],
        attitude: Default::default(),
        exposure: Exposure::Automatic,
        frustum: None,
        mirror: [false; 2],
        lights: Default::default(),
        entity: 0,
        carrier: None,
    };
    // Heights matter to an eye below them alone.
    Eye::new(&ownship, &view, &Terrain::ELLIPSOID)
}

fn placing(there: &Eye, eye: &Eye, intensity_cd: f64) -> Placing {
    let axis = |axis: DVec3| eye.direction(axis).to_array();
    Placing {
        axes: [axis(there.enu.x_axis), axis(there.enu.y_axis), axis(there.enu.z_axis)],
        origin_m: (eye.enu.transpose() * (there.ground_ecef_m - eye.ground_ecef_m)).as_vec3().into(),
        intensity_cd: intensity_cd as f32,
    }
}

/// What a part's field is made from and the ground point that it lies about; `None` where no cloud is near, and while there is
/// no channel. Where a table is not worth making the flash is solved.
fn request(snapshot: &Snapshot, part: &Part, method: Lighting) -> Option<(Request, Eye)> {
    let flash = part.flash;
    let points = points(flash.channel.as_deref()?, part);
    if points.is_empty() {
        return None;
    }
    let there = below(&flash.position);
    let regions = regions::near(snapshot, &there, &mut Vec::new());
    let around: f64 = regions.iter().map(|r| 1.0 - r.weight * r.state.gives_way()).product();
    let weathers = std::iter::once((0, &snapshot.weather, around))
        .chain(regions.iter().enumerate().map(|(i, r)| (i + 1, &r.state.weather, r.weight)));
    let mut best: Option<(f64, usize, &LayerState)> = None;
    for (column, weather, weight) in weathers {
        for layer in weather.layers.iter().filter(|l| l.coverage >= 1e-3 && l.density > 0.0) {
            let rank = weight * nearness(layer, &points) * layer.coverage;
            if rank > best.map_or(1e-3, |(rank, ..)| rank) {
                best = Some((rank, column, layer));
            }
        }
    }
    let (_, column, layer) = best?;
    let drift = blown_back(layer, &there, snapshot.simulation_time_s - flash.begin_s);
    let mut method = method;
    if method.method().table().is_some() {
        let region = column.checked_sub(1).map(|i| regions[i].state);
        let piece = patch::request(snapshot, flash, &points, (layer, region, drift), method);
        if let Some((request, middle)) = piece.filter(|(request, _)| fits(snapshot, request)) {
            return (!too_thin(&request)).then_some((request, middle));
        }
        method = Lighting::Solve;
    }
    let request = Request {
        kind: layer.kind,
        layer: drawn(layer, column, &there, &regions, drift),
        earth_m: there.earth_m as f32,
        points,
        method,
        patch: None,
    };
    (!too_thin(&request)).then_some((request, there))
}

/// Whether a request's table is worth making: it has room in the memory that all may take, and its cloud is no tower, where each
/// light would take seconds and be worth little between its neighbours.
fn fits(snapshot: &Snapshot, request: &Request) -> bool {
    let most = snapshot.quality.basis_memory_mib as usize;
    let depth = request.layer.extinction_per_m * request.layer.thickness_m;
    depth <= DEEPEST && request.patch.is_none_or(|window| bytes(request.method, &window) >> 20 <= most)
}

/// How far a flash lies behind the nearer of the faces of its cloud, m; 0 outside of clouds.
pub fn depth_m(snapshot: &Snapshot, flash: &FlashState) -> f64 {
    let regions = regions::near(snapshot, &below(&flash.position), &mut Vec::new());
    let around: f64 = regions.iter().map(|r| 1.0 - r.weight * r.state.gives_way()).product();
    let weathers =
        std::iter::once((&snapshot.weather, around)).chain(regions.iter().map(|r| (&r.state.weather, r.weight)));
    let depth_of = |layer: &LayerState| {
        let over_m = flash.position.altitude_m - layer.base_m;
        layer.coverage * over_m.min(layer.thickness_m - over_m).max(0.0)
    };
    let depth =
        |(weather, weight): (&WeatherState, f64)| weight * weather.layers.iter().map(depth_of).fold(0.0, f64::max);
    weathers.map(depth).sum()
}

/// How much of the points' light starts near a layer: all of it inside, nothing beyond [`REACH_M`].
fn nearness(layer: &LayerState, points: &[Point]) -> f64 {
    let top_m = layer.base_m + layer.thickness_m;
    let near = |p: &Point| {
        let height_m = f64::from(p.position_m[2]);
        let apart = (layer.base_m - height_m).max(height_m - top_m).max(0.0);
        f64::from(p.share) * (1.0 - apart / REACH_M).max(0.0)
    };
    points.iter().map(near).sum()
}

/// The layer as the flash began, around the flash's ground point; numbers that ease or drift are rounded to steps that no
/// picture shows, so that a flash's frames ask for one field.
fn drawn(state: &LayerState, column: usize, there: &Eye, regions: &[NearRegion], drift: DQuat) -> Layer {
    let look = state.kind.appearance();
    let threshold = Coverage::of(state.kind).threshold(state.coverage as f32);
    let cell = column.checked_sub(1).and_then(|i| Cell::of(state, &regions.get(i)?.state.shape));
    let (near, mut chart) = match &cell {
        Some(cell) => cell.charts(there),
        None => there.charts(drift, extent_m(there, 0.0), f64::from(density::TILE_M)),
    };
    let rounded = |v: f32, steps: f32| (v * steps).round() / steps;
    for chart in &mut chart {
        // A metre in the tile; less than that in the map.
        chart.tile_origin_m = chart.tile_origin_m.map(|v| rounded(v, 1.0));
        chart.map_origin = chart.map_origin.map(|v| rounded(v, 65_536.0));
        chart.a = chart.a.map(|v| rounded(v, 65_536.0));
        chart.c = chart.c.map(|v| rounded(v, 1e12));
        chart.w = chart.w.map(|v| rounded(v, 65_536.0));
        // A metre of waves that are 60 km long.
        chart.warp = chart.warp.map(|v| rounded(v, 65_536.0));
    }
    let one_per_cent = |v: f32| ((v.ln() * 100.0).round() / 100.0).exp();
    let outline =
        outlines(regions, column, state, there).map(|near| Region { presence: rounded(near.presence, 64.0), ..near });
    Layer {
        base_m: rounded(state.base_m as f32, 0.1),
        thickness_m: one_per_cent(state.thickness_m as f32),
        extinction_per_m: one_per_cent(look.extinction_per_m * state.density as f32),
        inverse_edge: 1.0 / look.edge,
        theta: rounded(threshold.offset, 256.0),
        patchiness: rounded(threshold.patchiness, 256.0),
        charts: near.len() as u32,
        regions: regions.len() as u32,
        region: column as u32,
        chart,
        outline,
        ..Layer::zeroed()
    }
}

/// The layer's drift some seconds ago, by the wind that it has now.
fn blown_back(state: &LayerState, there: &Eye, since_s: f64) -> DQuat {
    if state.kind.is_bounded() {
        // A storm cell stands where its region does.
        return DQuat::IDENTITY;
    }
    let (sin, cos) = state.wind_from_deg.to_radians().sin_cos();
    let velocity = (there.enu.x_axis * -sin + there.enu.y_axis * -cos) * state.wind_speed_mps;
    let turn = there.enu.z_axis.cross(velocity) / (MEAN_RADIUS_M + state.base_m);
    DQuat::from_scaled_axis(-turn * since_s) * state.drift
}

/// A few points that stand for a part of a channel, whole metres from the flash's ground point.
fn points(channel: &StrikeChannel, part: &Part) -> Vec<Point> {
    let light = Light { channel: part.channel, branches: part.branches, span: [0.0, 1.0], amount: 1.0 };
    let sources = channel.sources(SOURCES, &channel.lit(&[light]));
    let all: f64 = sources.iter().map(|source| source.weight).sum();
    let point =
        |source: &Source| Point { position_m: source.position_m.map(f32::round), share: (source.weight / all) as f32 };
    sources.iter().filter(|_| all > 0.0).map(point).collect()
}

#[cfg(test)]
mod tests;
