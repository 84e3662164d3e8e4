//! From a strike to the channel that is drawn: a geometry in metres around the strike's ground point, by its seed alone.
//!
//! What it is: lines of points, each with the light that has come out of its line up to there, so that any stretch of a line
//! knows its share of a stroke's energy. How it is made: grown by the rational potential in a grid that fits the kind
//! ([`scene`]), drawn out into crooked lines ([`super::shape`]), each point marked with the finest picture that needs it
//! ([`detail`]). How it is read: [`StrikeChannel::visit`] gives the segments at a level of detail, [`StrikeChannel::sources`]
//! a few lights that stand for the whole.

mod detail;
mod scene;
mod sources;

pub use sources::Source;

use super::channel::Channel;
use super::error::GrowError;
use super::flash::{FlashKind, Polarity};
use super::grow::{Method, grow};
use super::shape::{Line, lines};
use super::tables::Tables;
use std::sync::atomic::AtomicBool;

/// Most ground points of one flash; more are not grown.
pub const MOST_GROUNDS: usize = 8;
/// Most cells of a channel: several times what one ever took, a bound on time.
const MOST_CELLS: u32 = 6_000;
/// Luminous radius of the main channel of a stroke of 30 kA, m: a few centimetres at the peak (Rakov and Uman 2003, Lightning,
/// 4.6), which is always thinner than a pixel but for an eye within tens of metres.
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
    /// Peak current of the first stroke in kiloamperes.
    pub peak_current_ka: f64,
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
    /// Ground points (bit by bit) whose main channel the piece that ends here belongs to; 0: a side channel.
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
    /// Metres of each ground point's main channel.
    pub main_m: Vec<f64>,
    /// Light of all side channels together, in metres of main channel.
    pub side_m: f64,
    /// Length along the channel to its farthest point, m.
    pub longest_m: f64,
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
    /// Luminous radius, m.
    pub radius_m: f32,
}

/// Light of the parts of a channel, per metre of main channel; side channels are measured in such metres too.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PartLight {
    /// Of the main channel to each ground point. Where main channels are one, their lights add.
    pub main: [f64; MOST_GROUNDS],
    /// Of side channels.
    pub side: f64,
}

impl PartLight {
    /// Light of a metre of what belongs to these ground points.
    pub fn of(&self, grounds: u8) -> f64 {
        if grounds == 0 {
            return self.side;
        }
        (0..MOST_GROUNDS).filter(|ground| grounds >> ground & 1 == 1).map(|ground| self.main[ground]).sum()
    }
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
    Ok(assemble(&channel, &drawn, &plan, spec))
}

fn assemble(channel: &Channel, drawn: &[Line], plan: &scene::Plan, spec: &StrikeSpec) -> StrikeChannel {
    let masks = masks(channel, drawn, plan);
    let radius_m = RADIUS_M * (spec.peak_current_ka.max(0.0) / 30.0).sqrt();
    let mut found = StrikeChannel {
        points: Vec::with_capacity(drawn.iter().map(|line| line.points.len()).sum()),
        lines: Vec::with_capacity(drawn.len()),
        grounds: plan.ends.len().max(1),
        main_m: vec![0.0; plan.ends.len().max(1)],
        side_m: 0.0,
        longest_m: 0.0,
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
                found.count(masks[k], light * length_m);
            }
            found.longest_m = found.longest_m.max(point.along_m);
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
        found.lines.push(ChannelLine { first, count, order, radius_m: (radius_m * thickness) as f32 });
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
    // Main lines to what is no ground point of its own (the far ends of a flash inside clouds) are lit with the first.
    for (line, drawn) in drawn.iter().enumerate().filter(|(_, line)| line.order == 0) {
        let lit: u8 = masks[line].iter().copied().fold(0, |a, b| a | b);
        if lit == 0 {
            masks[line] = vec![1; drawn.points.len()];
        }
    }
    masks
}

impl StrikeChannel {
    fn count(&mut self, grounds: u8, light_m: f64) {
        if grounds == 0 {
            self.side_m += light_m;
        }
        for (ground, main_m) in self.main_m.iter_mut().enumerate() {
            if grounds >> ground & 1 == 1 {
                *main_m += light_m;
            }
        }
    }

    /// Light of the parts when a first stroke to a ground point, which lights all side channels too, gives `first` and later
    /// strokes along each main channel give `later` in the whole: each stroke's light is even along what it lights.
    ///
    /// A ground point that the channel does not have is taken as the last one that it has.
    pub fn part_light(&self, first: &[f64], later: &[f64]) -> PartLight {
        let mut parts = PartLight::default();
        let known = |ground: usize| ground.min(self.grounds - 1);
        for (ground, light) in first.iter().enumerate() {
            let ground = known(ground);
            let per_metre = light / (self.main_m[ground] + self.side_m).max(1e-3);
            parts.main[ground] += per_metre;
            parts.side += per_metre;
        }
        for (ground, light) in later.iter().enumerate() {
            let ground = known(ground);
            parts.main[ground] += light / self.main_m[ground].max(1e-3);
        }
        parts
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
                stretch(Stretch { from, to, light_m, grounds: point.grounds, radius_m: line.radius_m });
                from = to;
            }
        }
    }

    /// The number of stretches of a picture that shows nothing finer than `finest_m`.
    pub fn stretches(&self, finest_m: f32) -> usize {
        self.points.iter().filter(|point| point.detail_m >= finest_m).count() - self.lines.len()
    }

    /// At most `count` lights that stand for the channel, heaviest parts divided first; their weights add up to all light of
    /// `parts`. None where `parts` gives none.
    pub fn sources(&self, count: usize, parts: &PartLight) -> Vec<Source> {
        sources::sources(self, count, parts)
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let d: [f64; 3] = std::array::from_fn(|axis| a[axis] - b[axis]);
    (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt()
}

#[cfg(test)]
mod tests;
