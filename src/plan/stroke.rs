//! What a picture shows of the flashes' channels: stretches of light in pixels, places for the veil, lights for the air.

mod project;

use super::PassNote;
use super::eye::Eye;
use crate::geo::Geodetic;
use crate::geo::frames::enu;
use crate::lightning::strike::{Lit, Stretch, StrikeChannel};
use crate::passes::airlight::{Airlight, MOST_SOURCES, Source};
use crate::passes::common::Camera;
use crate::passes::deck::{FLASHES, Flash};
use crate::passes::glow;
use crate::passes::stroke::{NARROWEST_PX, Segment, Strokes};
use crate::passes::veil::Node;
use crate::world::snapshot::{FlashState, Snapshot};
use glam::{DMat3, DVec3, Vec3};
use project::{Projection, Seen};
use std::collections::BTreeMap;

/// Detail below this share of a pixel is left out of a channel: a point that comes or goes moves its line by no more.
const FINEST_PX: f64 = 0.25;
/// Stretches of all channels of one picture at most (some 2 MiB): where there would be more, they become coarser.
const MOST_SEGMENTS: usize = 40_000;
/// Between two nodes of the veil along a line, m; and in pixels, where that is more.
const NODE_M: f64 = 60.0;
const NODE_PX: f64 = 2.0;
/// Lights of one channel for the air.
const SOURCES: usize = 8;
/// A stretch longer than this share of its distance is cut, so that its light is that of its own place.
const LONGEST_SHARE: f64 = 0.2;
/// Pieces that a stretch is cut into at most.
const MOST_PIECES: usize = 64;
/// Pixels of the air's light across the picture at most, and least number of pixels to one of it.
const AIR_PX: u32 = 160;
const COARSE: u32 = 4;
/// Greatest value that the strokes' image is made to hold: half floats keep their digits, and sums stay far below 65504.
const BRIGHTEST: f32 = 4_000.0;
/// Lumens of a light of one candela.
const LUMENS: f64 = 4.0 * std::f64::consts::PI;

/// The channels of one picture.
#[derive(Clone, Debug, PartialEq)]
pub struct StrokePlan {
    /// Stretches of all channels.
    pub segments: Vec<Segment>,
    /// Where the clouds' veil is asked for: along the lines, then at the lights for the air.
    pub nodes: Vec<Node>,
    /// Lights for the air.
    pub sources: Vec<Source>,
    /// How the strokes' image is made.
    pub strokes: Strokes,
    /// How the image of the air's light is made.
    pub airlight: Airlight,
    /// Pixels of the picture each way to one of the air's light.
    pub air_scale: u32,
    /// Shares of the light that stays where it is and that glows at each level.
    pub glow: Vec<f32>,
    /// Bound on the luminance of a pixel of the strokes' image, cd/m2.
    pub brightest: f32,
}

/// A channel that gives light, placed around the eye.
struct Shining<'a> {
    channel: &'a StrikeChannel,
    lit: Lit,
    /// From the channel's axes into the eye's.
    turn: DMat3,
    origin_m: DVec3,
    /// From the eye to its nearest point, m.
    nearest_m: f64,
    /// Illuminance at the eye if nothing were between, lux.
    strength: f64,
}

/// The channels of the flashes that give light in the shutter interval; `None` where there are none.
pub fn strokes(snapshot: &Snapshot, eye: &Eye, camera: &Camera, notes: &mut Vec<PassNote>) -> Option<StrokePlan> {
    let mut shining: Vec<Shining> = snapshot.flashes.iter().filter_map(|flash| shining(flash, eye)).collect();
    let mut note = |kept, why| notes.push(PassNote { pass: "stroke", kept, why });
    if shining.is_empty() {
        let growing = snapshot.flashes.iter().filter(|flash| flash.channel.is_none()).count();
        note(
            false,
            match growing {
                0 => "no flash shows a channel".to_owned(),
                n => format!("the channels of {n} flashes are still being grown"),
            },
        );
        return None;
    }
    // In the order of their strength, the flashes' order where it is equal.
    shining.sort_by(|a, b| b.strength.total_cmp(&a.strength));
    let projection = Projection::new(camera);
    let finest = finest(&shining, &projection);
    let mut drawing = Drawing { camera, projection, segments: Vec::new(), nodes: Vec::new() };
    for (shining, finest_m) in shining.iter().zip(&finest) {
        drawing.channel(shining, *finest_m);
    }
    let each = (MOST_SOURCES / shining.len()).clamp(1, SOURCES);
    let sources: Vec<Source> =
        shining.iter().take(MOST_SOURCES).flat_map(|shining| drawing.sources(shining, each)).collect();
    let Drawing { segments, nodes, .. } = drawing;
    let brightest = brightest(&segments);
    let nearest_m = shining.iter().map(|shining| shining.nearest_m).fold(f64::INFINITY, f64::min);
    note(
        true,
        format!(
            "{} channels in {} stretches, the nearest {:.1} km away; {} places of the veil, {} lights for the air",
            shining.len(),
            segments.len(),
            nearest_m / 1_000.0,
            nodes.len(),
            sources.len(),
        ),
    );
    let [width, height] = [camera.width_px as u32, camera.height_px as u32];
    let pixel_deg = 2.0 * Vec3::from(camera.up).length().to_degrees() / camera.height_px;
    Some(StrokePlan {
        strokes: Strokes { scale: power_below(BRIGHTEST / brightest.max(1e-20)), pad0: 0.0, pad1: 0.0, pad2: 0.0 },
        airlight: Airlight { scale: camera.exposure, sources: sources.len() as u32, pad0: 0.0, pad1: 0.0 },
        air_scale: width.div_ceil(AIR_PX).max(height.div_ceil(AIR_PX)).max(COARSE),
        glow: glow::weights(pixel_deg, [width, height]),
        segments,
        nodes,
        sources,
        brightest,
    })
}

/// The flashes as the ground is lit by them: each channel as several points along it, as far as there is room. `points`: each as
/// one point, which is what remains of flashes that are many or have no channel yet.
pub fn on_ground(snapshot: &Snapshot, eye: &Eye, points: &[Flash]) -> Vec<Flash> {
    let giving: Vec<&FlashState> = snapshot.flashes.iter().filter(|flash| flash.intensity_cd > 0.0).collect();
    let each = (FLASHES / giving.len().max(1)).min(SOURCES);
    if each < 2 {
        return points.to_vec();
    }
    let light = |position_m: Vec3, lumens: f64| Flash {
        position_m: position_m.into(),
        intensity: (lumens / LUMENS) as f32 * std::f32::consts::FRAC_1_PI * 0.25,
    };
    let mut lights = Vec::new();
    for flash in giving {
        match shining(flash, eye) {
            Some(shining) => {
                let parts = shining.channel.sources(each, &shining.lit);
                lights.extend(parts.iter().map(|part| light(shining.around(part.position_m).as_vec3(), part.weight)));
            }
            None => lights.push(light(eye.place(&flash.position), flash.intensity_cd * LUMENS)),
        }
    }
    lights
}

/// Exposure of a picture of linear light that half floats must hold whole: lowered by a power of two as far as its strokes
/// need it, which changes no digit of anything else.
pub fn linear_exposure(exposure: f32, strokes: &StrokePlan) -> f32 {
    exposure.min(exposure * power_below(BRIGHTEST / (strokes.brightest * exposure).max(1e-20)))
}

/// The greatest power of two not above a positive number, within what f32 can invert.
fn power_below(value: f32) -> f32 {
    value.log2().floor().clamp(-60.0, 60.0).exp2()
}

fn shining<'a>(flash: &'a FlashState, eye: &Eye) -> Option<Shining<'a>> {
    let channel = flash.channel.as_deref()?;
    let lit = channel.lit(&flash.lights);
    if lit.is_dark() {
        return None;
    }
    let ground = Geodetic { altitude_m: 0.0, ..flash.position };
    let turn = eye.enu.transpose() * enu(&ground);
    let origin_m = eye.offset(&ground);
    let mut found = Shining { channel, lit, turn, origin_m, nearest_m: f64::INFINITY, strength: 0.0 };
    let own = DVec3::new(0.0, 0.0, eye.height_m);
    let (mut nearest_m, mut strength) = (f64::INFINITY, 0.0);
    channel.visit(NODE_M as f32, |stretch| {
        let [a, b] = found.ends(&stretch);
        let distance_m = project::distance_to_line(own, a, b).max(1.0);
        nearest_m = f64::min(nearest_m, distance_m);
        strength += found.lit.of(channel, &stretch) / LUMENS / (distance_m * distance_m);
    });
    (found.nearest_m, found.strength) = (nearest_m, strength);
    Some(found)
}

/// How fine each channel is drawn, m: by its distance, coarser where there would be too many stretches.
fn finest(shining: &[Shining], projection: &Projection) -> Vec<f32> {
    let mut finest: Vec<f32> =
        shining.iter().map(|s| (FINEST_PX * projection.pixel_rad * s.nearest_m.max(20.0)) as f32).collect();
    let stretches = |finest: &[f32]| shining.iter().zip(finest).map(|(s, f)| s.channel.stretches(*f)).sum::<usize>();
    // Lines are never left out, so that with very many of them this ends by its own bound.
    for _ in 0..40 {
        if stretches(&finest) <= MOST_SEGMENTS {
            break;
        }
        finest.iter_mut().for_each(|finest_m| *finest_m *= 1.5);
    }
    finest
}

impl Shining<'_> {
    /// A place of the channel's axes in the eye's.
    fn around(&self, position_m: [f32; 3]) -> DVec3 {
        self.origin_m + self.turn * DVec3::from_array(position_m.map(f64::from))
    }

    fn place(&self, point: u32) -> DVec3 {
        self.around(self.channel.points[point as usize].position_m)
    }

    fn ends(&self, stretch: &Stretch) -> [DVec3; 2] {
        [stretch.from, stretch.to].map(|point| self.place(point))
    }
}

struct Drawing<'a> {
    camera: &'a Camera,
    projection: Projection,
    segments: Vec<Segment>,
    nodes: Vec<Node>,
}

/// Where along a line its nodes lie: the number of the first, and the length along it at each.
struct Line {
    first: u32,
    at_m: Vec<f64>,
}

impl Drawing<'_> {
    /// Draws a channel line by line.
    fn channel(&mut self, shining: &Shining, finest_m: f32) {
        let mut line: Vec<Stretch> = Vec::new();
        shining.channel.visit(finest_m, |stretch| {
            // A line begins where a stretch does not begin with the end of the one before.
            if line.last().is_some_and(|last| last.to != stretch.from) {
                self.line(shining, &line);
                line.clear();
            }
            line.push(stretch);
        });
        self.line(shining, &line);
    }

    fn line(&mut self, shining: &Shining, stretches: &[Stretch]) {
        if stretches.iter().all(|stretch| shining.lit.of(shining.channel, stretch) <= 0.0) {
            return;
        }
        let spacing_m = NODE_M.max(NODE_PX * self.projection.pixel_rad * shining.nearest_m);
        let mut line = Line { first: self.nodes.len() as u32, at_m: vec![0.0] };
        self.node(shining.place(stretches[0].from));
        let mut along_m = 0.0;
        for (k, stretch) in stretches.iter().enumerate() {
            let [a, b] = shining.ends(stretch);
            along_m += a.distance(b);
            let last = line.at_m[line.at_m.len() - 1];
            if k + 1 == stretches.len() || along_m - last >= spacing_m {
                line.at_m.push(along_m);
                self.node(b);
            }
        }
        let (mut along_m, mut interval) = (0.0, 0);
        for stretch in stretches {
            let [a, b] = shining.ends(stretch);
            let end_m = along_m + a.distance(b);
            let [low, high] = [line.at_m[interval], line.at_m[interval + 1]];
            let share = |at_m: f64| ((at_m - low) / (high - low).max(1e-6)) as f32;
            let shares = [share(along_m), share(end_m)];
            let candela = shining.lit.of(shining.channel, stretch) / LUMENS;
            self.stretch([a, b], candela, stretch.radius_m, line.first + interval as u32, shares);
            along_m = end_m;
            if along_m >= high && interval + 2 < line.at_m.len() {
                interval += 1;
            }
        }
    }

    fn node(&mut self, place: DVec3) -> u32 {
        self.nodes.push(Node { position_m: place.as_vec3().into(), passed: 1.0 });
        self.nodes.len() as u32 - 1
    }

    /// One stretch, cut where it is long against its distance; what is not in sight is left out.
    fn stretch(&mut self, [a, b]: [DVec3; 2], candela: f64, radius_m: f32, node: u32, shares: [f32; 2]) {
        if candela <= 0.0 {
            return;
        }
        let eye = self.projection.eye;
        let distance_m = project::distance_to_line(eye, a, b).max(1.0);
        let pieces = ((a.distance(b) / (LONGEST_SHARE * distance_m)).ceil() as usize).clamp(1, MOST_PIECES);
        for piece in 0..pieces {
            let [s, e] = [piece, piece + 1].map(|k| k as f64 / pieces as f64);
            let Some([s, e]) = self.projection.in_sight([a.lerp(b, s), a.lerp(b, e)], [s, e]) else { continue };
            let (from, to) = (a.lerp(b, s), a.lerp(b, e));
            let Some([from, to]) = self.projection.seen(from, to) else { continue };
            let mix = |share: f64| shares[0] + (shares[1] - shares[0]) * share as f32;
            self.segment([from, to], candela * (e - s), radius_m, node, [mix(s), mix(e)]);
        }
    }

    fn segment(&mut self, [from, to]: [Seen; 2], candela: f64, radius_m: f32, node: u32, shares: [f32; 2]) {
        let range_m = 0.5 * (from.range_m + to.range_m);
        let height_m = self.camera.height_at((0.5 * (from.up + to.up)) as f32, range_m as f32);
        let air = self.camera.air_transmittance(height_m, range_m as f32);
        let steradian = 0.5 * (from.pixel_sr + to.pixel_sr);
        let light = (candela / (range_m * range_m) / steradian) as f32 * air;
        let width_px = (f64::from(radius_m) / (range_m * self.projection.pixel_rad)) as f32;
        let sigma_px = NARROWEST_PX.hypot(width_px).min(64.0);
        if !light.is_finite() || light <= 0.0 {
            return;
        }
        self.segments.push(Segment {
            from_px: from.at_px.as_vec2().into(),
            to_px: to.at_px.as_vec2().into(),
            light,
            sigma_px,
            share_from: shares[0],
            share_to: shares[1],
            node,
            pad: 0,
        });
    }

    /// The lights that stand for a channel in the air, each with a node of its own.
    fn sources(&mut self, shining: &Shining, count: usize) -> Vec<Source> {
        let parts = shining.channel.sources(count, &shining.lit);
        let one = |part: crate::lightning::strike::Source| {
            let place = shining.around(part.position_m);
            let node = self.node(place);
            Source {
                position_m: place.as_vec3().into(),
                intensity_cd: (part.weight / LUMENS) as f32,
                width_m: (0.5 * Vec3::from(part.half_m).length()).max(10.0),
                node,
                pad0: 0.0,
                pad1: 0.0,
            }
        };
        parts.into_iter().map(one).collect()
    }
}

/// A bound on the luminance of a pixel: light by squares of two pixels, as dense as a profile can make it.
fn brightest(segments: &[Segment]) -> f32 {
    let mut squares: BTreeMap<(i32, i32), f32> = BTreeMap::new();
    for segment in segments {
        let [from, to] = [glam::Vec2::from(segment.from_px), glam::Vec2::from(segment.to_px)];
        let pieces = (0.5 * from.distance(to)).ceil().clamp(1.0, 8_192.0) as u32;
        for piece in 0..pieces {
            let at = 0.5 * from.lerp(to, (piece as f32 + 0.5) / pieces as f32);
            *squares.entry((at.x as i32, at.y as i32)).or_default() += segment.light / pieces as f32;
        }
    }
    let most = squares.values().copied().fold(0.0, f32::max);
    // All of a square's light in one narrowest point: 1 / (2 pi 0.6^2) of it in the pixel; as much again from squares beside it.
    2.0 * most / (std::f32::consts::TAU * NARROWEST_PX * NARROWEST_PX)
}

#[cfg(test)]
mod tests;
