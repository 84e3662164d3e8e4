//! From a strike to the channel that is drawn: a geometry in metres around the strike's ground point, by its seed alone.
//!
//! What it is: lines of points, each with the light that has come out of its line up to there, so that any stretch of a line
//! knows its share of a stroke's energy. How it is made: grown by the rational potential in a grid that fits the kind
//! ([`scene`]), drawn out into crooked lines ([`super::shape`]), each point marked with the finest picture that needs it
//! ([`detail`]). How it is read: [`StrikeChannel::visit`] gives the segments at a level of detail, [`StrikeChannel::sources`]
//! a few lights that stand for the whole.

mod detail;
mod lit;
mod scene;
mod sources;

pub use lit::Lit;
pub use sources::Source;

use super::channel::Channel;
use super::error::GrowError;
use super::flash::{FlashKind, Light, Polarity};
use super::grow::{Method, grow};
use super::shape::{Line, lines};
use super::tables::Tables;
use std::sync::atomic::AtomicBool;

/// Most ground points of one flash; more are not grown.
pub const MOST_GROUNDS: usize = 8;
/// Most cells of a channel: several times what one ever took, a bound on time.
const MOST_CELLS: u32 = 6_000;
/// Luminous radius of the main channel, m: some centimetres (Rakov and Uman 2003, Lightning, 4.6), which is thinner than a
/// pixel but for an eye within tens of metres, so that the current, which would change it, is not asked for.
const RADIUS_M: f64 = 0.1;

/// What decides a channel. Equal specifications give equal channels on every machine.
#[derive(Clone, Debug, PartialEq)]
pub struct StrikeSpec {
    /// Where the flash goes.
    pub kind: FlashKind,
    /// Channels of positive strokes branch less and slant more.
    pub polarity: Polarity,
    /// Seed of everything that is drawn by chance.
    pub seed: u64,
    /// Height over the ground of the charge that it starts from; inside clouds of the channel's centre. At least 30 m is taken.
    pub origin_m: f64,
    /// Heights over the ground of base and top of the cloud around it; equal where there is none.
    pub cloud_m: [f64; 2],
    /// Ground points east and north of the strike's own; none is taken as one at `[0, 0]`. Only for strokes to ground; those
    /// beyond [`MOST_GROUNDS`] are left out, and those farther than the grid reaches are drawn nearer.
    pub grounds_m: Vec<[f64; 2]>,
}

/// A point of a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelPoint {
    /// East, north and up from the strike's ground point.
    pub position_m: [f32; 3],
    /// Length along the channel from its start, m.
    pub along_m: f32,
    /// Light of its line from the line's beginning to here, in metres of main channel.
    pub light_m: f32,
    /// How far a line that leaves this point out would pass from it, m: infinite for points that no picture leaves out.
    pub detail_m: f32,
    /// Ground points (bit by bit) whose main channel the piece that ends here belongs to; of a side channel, those whose main
    /// channel it leaves.
    pub grounds: u8,
}

/// A line of points, from where it leaves its parent to its tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelLine {
    /// Its first point.
    pub first: u32,
    /// Number of its points, at least 2.
    pub count: u32,
    /// 0 for main channels, 1 for what leaves them, and so on.
    pub order: u32,
    /// Luminous radius, m.
    pub radius_m: f32,
}

/// The geometry of one flash.
#[derive(Clone, Debug, PartialEq)]
pub struct StrikeChannel {
    /// Points, line by line.
    pub points: Vec<ChannelPoint>,
    /// Lines, parents before children.
    pub lines: Vec<ChannelLine>,
    /// Number of ground points that it has main channels to; 1 inside clouds, too.
    pub grounds: usize,
    /// Light of each ground point's main channel, in metres of main channel: its crooked length.
    pub main_m: Vec<f64>,
    /// Light of the side channels that leave it, in metres of main channel.
    pub side_m: Vec<f64>,
    /// Length along each ground point's channel to its end, m, as [`ChannelPoint::along_m`] counts it.
    pub reach_m: Vec<f64>,
}

/// A stretch of a line between two points that a picture keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Number of its first point.
    pub from: u32,
    /// Number of its last point.
    pub to: u32,
    /// Its light in metres of main channel, that of the points left out included.
    pub light_m: f32,
    /// As [`ChannelPoint::grounds`].
    pub grounds: u8,
    /// Whether it is a side channel's.
    pub side: bool,
    /// Luminous radius, m.
    pub radius_m: f32,
}

/// Grows the channel of a strike. `tables` keeps what depends on the grid alone from call to call.
///
/// # Errors
/// [`GrowError::Cancelled`] when `cancel` was set from elsewhere; nothing else can happen to a finite specification.
pub fn grow_strike(spec: &StrikeSpec, tables: &mut Tables, cancel: &AtomicBool) -> Result<StrikeChannel, GrowError> {
    let plan = scene::plan(spec)?;
    // Few branches for positive strokes: photographs show long, hardly branched channels (Saba et al. 2010).
    let (eta, rho) = match spec.polarity {
        Polarity::Negative => (2.0, 3.0),
        Polarity::Positive => (3.0, 3.0),
    };
    let (channel, _) = grow(&Method::rational(eta, rho), &plan.scene, MOST_CELLS, spec.seed, tables, cancel)?;
    let drawn = lines(&channel, plan.scene.grid.axes(), &plan.shape, spec.seed);
    Ok(assemble(&channel, &drawn, &plan))
}

fn assemble(channel: &Channel, drawn: &[Line], plan: &scene::Plan) -> StrikeChannel {
    let masks = masks(channel, drawn, plan);
    let mut found = StrikeChannel {
        points: Vec::with_capacity(drawn.iter().map(|line| line.points.len()).sum()),
        lines: Vec::with_capacity(drawn.len()),
        grounds: plan.ends.len().max(1),
        main_m: vec![0.0; plan.ends.len().max(1)],
        side_m: vec![0.0; plan.ends.len().max(1)],
        reach_m: vec![0.0; plan.ends.len().max(1)],
    };
    for (line, masks) in drawn.iter().zip(&masks) {
        if line.points.len() < 2 {
            continue;
        }
        let positions: Vec<[f64; 3]> = line.points.iter().map(|point| plan.placed(point.position_m)).collect();
        let kept = |k: usize| k > 0 && k + 1 < positions.len() && masks[k] != masks[k + 1];
        let details = detail::details(&positions, kept);
        let first = found.points.len() as u32;
        let mut light_m = 0.0;
        for (k, point) in line.points.iter().enumerate() {
            if k > 0 {
                let before = line.points[k - 1];
                let length_m = distance(positions[k - 1], positions[k]);
                let light = 0.5 * (before.brightness * before.thickness + point.brightness * point.thickness);
                light_m += light * length_m;
                found.count(masks[k], line.order > 0, light * length_m, point.along_m);
            }
            found.points.push(ChannelPoint {
                position_m: positions[k].map(|x| x as f32),
                along_m: point.along_m as f32,
                light_m: light_m as f32,
                detail_m: details[k] as f32,
                grounds: masks[k.max(1)],
            });
        }
        let thickness = line.points[line.points.len() / 2].thickness;
        let (count, order) = (line.points.len() as u32, line.order);
        found.lines.push(ChannelLine { first, count, order, radius_m: (RADIUS_M * thickness) as f32 });
    }
    found
}

/// For each point of each line, the ground points whose main channel the piece that ends there belongs to.
fn masks(channel: &Channel, drawn: &[Line], plan: &scene::Plan) -> Vec<Vec<u8>> {
    let mut masks: Vec<Vec<u8>> = drawn.iter().map(|line| vec![0; line.points.len()]).collect();
    let mut mark = |mut line: usize, mut last: usize, bit: u8| {
        loop {
            masks[line][..=last].iter_mut().for_each(|mask| *mask |= bit);
            match drawn[line].parent {
                Some((parent, point)) => (line, last) = (parent as usize, point as usize),
                None => break,
            }
        }
    };
    let mains = || drawn.iter().enumerate().filter(|(_, line)| line.order == 0);
    for (ground, end) in plan.ends.iter().enumerate() {
        // The main line that ends at this target.
        let tip = |line: &Line| line.points.last().map_or([f64::INFINITY; 3], |point| point.position_m);
        let there = plan.cell_position_m(*end);
        let nearest = mains().min_by(|a, b| distance(tip(a.1), there).total_cmp(&distance(tip(b.1), there)));
        if let Some((line, drawn)) = nearest {
            mark(line, drawn.points.len() - 1, 1 << ground);
        }
    }
    if plan.ends.is_empty() || channel.ends.is_empty() {
        for (line, drawn) in mains() {
            mark(line, drawn.points.len() - 1, 1);
        }
    }
    // Side channels shine with the main channel that they leave; so do main lines to what is no ground point of its own.
    for line in 0..drawn.len() {
        let marked = masks[line].iter().any(|mask| *mask != 0);
        let parent = drawn[line].parent.map(|(parent, point)| masks[parent as usize][point as usize]);
        if !marked {
            let own = parent.filter(|mask| *mask != 0).unwrap_or(1);
            masks[line] = vec![own; drawn[line].points.len()];
        }
    }
    masks
}

impl StrikeChannel {
    fn count(&mut self, grounds: u8, side: bool, light_m: f64, along_m: f64) {
        for ground in (0..self.grounds).filter(|ground| grounds >> ground & 1 == 1) {
            let lights = if side { &mut self.side_m } else { &mut self.main_m };
            lights[ground] += light_m;
            if !side {
                self.reach_m[ground] = self.reach_m[ground].max(along_m);
            }
        }
    }

    /// The light of its parts while these lights shine, each of them even along what it lights.
    pub fn lit(&self, lights: &[Light]) -> Lit {
        Lit::new(self, lights)
    }

    /// The stretches of a picture that shows nothing finer than `finest_m`, line by line.
    pub fn visit(&self, finest_m: f32, mut stretch: impl FnMut(Stretch)) {
        for line in &self.lines {
            let last = line.first + line.count - 1;
            let mut from = line.first;
            for to in line.first + 1..=last {
                let point = &self.points[to as usize];
                if point.detail_m < finest_m {
                    continue;
                }
                let light_m = point.light_m - self.points[from as usize].light_m;
                let (grounds, side, radius_m) = (point.grounds, line.order > 0, line.radius_m);
                stretch(Stretch { from, to, light_m, grounds, side, radius_m });
                from = to;
            }
        }
    }

    /// The number of stretches of a picture that shows nothing finer than `finest_m`.
    pub fn stretches(&self, finest_m: f32) -> usize {
        self.points.iter().filter(|point| point.detail_m >= finest_m).count() - self.lines.len()
    }

    /// At most `count` lights that stand for the channel, widest parts divided first; their weights add up to all light of
    /// `lit`. None where it gives none.
    pub fn sources(&self, count: usize, lit: &Lit) -> Vec<Source> {
        sources::sources(self, count, lit)
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let d: [f64; 3] = std::array::from_fn(|axis| a[axis] - b[axis]);
    (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt()
}

#[cfg(test)]
mod tests;
