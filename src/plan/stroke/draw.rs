//! Draws channels into stretches of light in pixels, with the nodes of the veil that they lie between.

use super::project::{self, Projection, Seen};
use super::{LUMENS, Shining};
use crate::lightning::strike::{self, Stretch};
use crate::passes::airlight::Source;
use crate::passes::common::Camera;
use crate::passes::stroke::{NARROWEST_PX, Segment};
use crate::passes::veil::Node;
use glam::{DVec3, Vec2, Vec3};
use std::collections::BTreeMap;

/// Between two nodes of the veil along a line, m; and in pixels, where that is more.
const NODE_M: f64 = 60.0;
const NODE_PX: f64 = 2.0;
/// A stretch longer than this share of its distance is cut, so that its light is that of its own place.
const LONGEST_SHARE: f64 = 0.2;
/// Pieces that a stretch is cut into at most.
const MOST_PIECES: usize = 64;

/// What has been drawn so far.
pub(super) struct Drawing<'a> {
    pub camera: &'a Camera,
    pub projection: Projection,
    pub segments: Vec<Segment>,
    pub nodes: Vec<Node>,
}

/// Where along a line its nodes lie: the number of the first, and the length along it at each.
struct Line {
    first: u32,
    at_m: Vec<f64>,
}

impl Drawing<'_> {
    /// Draws a channel line by line.
    pub fn channel(&mut self, shining: &Shining, finest_m: f32) {
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
    pub fn sources(&mut self, shining: &Shining, count: usize) -> Vec<Source> {
        let parts = shining.channel.sources(count, &shining.lit);
        let one = |part: strike::Source| {
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
pub(super) fn brightest(segments: &[Segment]) -> f32 {
    let mut squares: BTreeMap<(i32, i32), f32> = BTreeMap::new();
    for segment in segments {
        let [from, to] = [Vec2::from(segment.from_px), Vec2::from(segment.to_px)];
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
