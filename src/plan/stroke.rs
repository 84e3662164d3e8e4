//! What a picture shows of the flashes' channels: stretches of light in pixels, places for the veil, lights for the air.

mod draw;
mod project;

use super::PassNote;
use super::eye::Eye;
use super::relight::Bare;
use crate::geo::Geodetic;
use crate::geo::frames::enu;
use crate::lightning::strike::{Lit, Stretch, StrikeChannel};
use crate::passes::airlight::{Airlight, MOST_SOURCES, Source};
use crate::passes::common::Camera;
use crate::passes::deck::{FLASHES, Flash};
use crate::passes::glow;
use crate::passes::stroke::{Segment, Strokes};
use crate::passes::veil::Node;
use crate::world::snapshot::{FlashState, Snapshot};
use draw::{Drawing, brightest};
use glam::{DMat3, DVec3, Vec3};
use project::Projection;

/// Detail below this share of a pixel is left out of a channel: a point that comes or goes moves its line by no more.
const FINEST_PX: f64 = 0.25;
/// Channels of one picture at most: of more the strongest at the eye, each of which outshines what is left out.
const MOST_CHANNELS: usize = 64;
/// Stretches of all channels of one picture at most (some 2 MiB): where there would be more, they become coarser.
const MOST_SEGMENTS: usize = 40_000;
/// Fineness at which a channel's distance and strength are found, m.
const MEASURED_M: f32 = 60.0;
/// Lights of one channel for the air.
const SOURCES: usize = 8;
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
    shining.truncate(MOST_CHANNELS);
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

/// The flashes without a field as the ground is lit by them: each channel as several points along it, as far as there is
/// room. `points`: each as one point, which is what remains of flashes that are many or have no channel yet.
pub fn on_ground(bare: &[Bare], eye: &Eye, points: &[Flash]) -> Vec<Flash> {
    let each = (FLASHES / bare.len().max(1)).min(SOURCES);
    if each < 2 {
        return points.to_vec();
    }
    let light = |position_m: Vec3, lumens: f64| Flash {
        position_m: position_m.into(),
        intensity: (lumens / LUMENS) as f32 * std::f32::consts::FRAC_1_PI * 0.25,
    };
    let mut lights = Vec::new();
    for Bare { flash, intensity_cd } in bare {
        // Of the flash's light, what is not in a field.
        let share = intensity_cd / flash.intensity_cd;
        match shining(flash, eye) {
            Some(shining) => {
                let parts = shining.channel.sources(each, &shining.lit);
                lights.extend(
                    parts.iter().map(|part| light(shining.around(part.position_m).as_vec3(), part.weight * share)),
                );
            }
            None => lights.push(light(eye.place(&flash.position), intensity_cd * LUMENS)),
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
    channel.visit(MEASURED_M, |stretch| {
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

#[cfg(test)]
mod tests;
