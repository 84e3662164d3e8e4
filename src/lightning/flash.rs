//! A flash in time: strokes drawn from published distributions or given, their leaders, and the light in any interval.
//!
//! The first stroke at a ground point opens a channel and lights its branches; later ones run up the main channel alone, as do
//! the dart leaders before them and the continuing currents after them. A leader's light is at its tip, which runs along the
//! channel at an even pace. All light is in closed form, so that frames that abut add up to the whole.

pub mod statistics;

use super::photometry::{continuing_power_lm, continuing_share, luminous_energy_lm_s, stroke_duration_s, stroke_share};

/// Where a flash goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashKind {
    /// Cloud to ground.
    CloudToGround,
    /// Inside one cloud.
    IntraCloud,
    /// From cloud to cloud.
    CloudToCloud,
}

/// Sign of the charge brought down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Polarity {
    /// The usual case.
    Negative,
    /// Rarer, stronger, mostly of one stroke.
    Positive,
}

/// One stroke as a host gives it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StrokeSpec {
    /// Seconds after the flash begins.
    pub delay_s: f64,
    /// Peak current in kiloamperes, positive.
    pub peak_current_ka: f64,
    /// Seconds of continuing current, 0 for none; `None`: drawn by the seed.
    pub continuing_s: Option<f64>,
    /// Its ground point, metres east and north of the flash's place; `None`: that of the stroke before.
    pub ground_point_m: Option<[f64; 2]>,
}

/// What runs ahead of a stroke.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leader {
    /// Seconds that it takes, until the stroke.
    pub length_s: f64,
    /// Its luminous energy as a share of the stroke's.
    pub share: f64,
}

/// A stroke with its leader and its continuing current.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// Seconds after the flash begins.
    pub delay_s: f64,
    /// Peak current in kiloamperes.
    pub peak_current_ka: f64,
    /// Current that goes on flowing at first, in kiloamperes (it falls in a straight line to nothing).
    pub continuing_ka: f64,
    /// Seconds for which it flows; 0: none.
    pub continuing_s: f64,
    /// Which of the flash's channels, from 0.
    pub channel: u32,
    /// Whether it is the first on that channel, and so lights its branches.
    pub opens: bool,
    /// What runs ahead of it.
    pub leader: Option<Leader>,
}

/// The strokes of one flash, in rising order of delay.
#[derive(Clone, Debug, PartialEq)]
pub struct Flash {
    /// The strokes.
    pub strokes: Vec<Stroke>,
    /// The ground point of each channel, metres east and north of the flash's place. (A flash that does not go to ground has
    /// one channel, at its place.)
    pub ground_points_m: Vec<[f64; 2]>,
}

/// Light of a part of a flash's channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Which channel, from 0.
    pub channel: u32,
    /// Whether the branches shine, too.
    pub branches: bool,
    /// Which part of the channel's length shines, evenly: shares from where it starts in the cloud. `[0, 1]` for strokes; for a
    /// leader as far as its tip comes in the interval.
    pub span: [f64; 2],
    /// Luminous energy in lumen seconds (where [`Light::mean`] made it a mean: luminous flux in lumens).
    pub amount: f64,
}

impl Light {
    /// Its mean over an interval of so many seconds.
    pub fn mean(self, length_s: f64) -> Self {
        Self { amount: self.amount / length_s, ..self }
    }
}

/// No flash gives light for longer after it began: the latest stroke that is drawn or may be given, its light, and the longest
/// continuing current.
pub const LONGEST_FLASH_S: f64 = 7.0;

impl Flash {
    /// A flash drawn by its seed: number of strokes, intervals, currents, continuing currents and ground points.
    ///
    /// `first_peak_current_ka` fixes the first current; the later ones then keep their usual proportion to it. With `leader` the
    /// flash begins with its stepped leader and not with its first stroke, and later channels have theirs.
    pub fn sample(
        kind: FlashKind,
        polarity: Polarity,
        first_peak_current_ka: Option<f64>,
        leader: bool,
        seed: u64,
    ) -> Self {
        let mut flash = statistics::sample(kind, polarity, first_peak_current_ka, seed);
        statistics::lead(&mut flash, leader, seed);
        flash
    }

    /// A flash of given strokes (in rising order of delay); continuing currents that are not given are drawn. `leader` as for
    /// [`Flash::sample`].
    pub fn given(kind: FlashKind, polarity: Polarity, strokes: &[StrokeSpec], leader: bool, seed: u64) -> Self {
        let mut flash = Self { strokes: Vec::with_capacity(strokes.len()), ground_points_m: Vec::new() };
        let mut channel = 0;
        for (index, spec) in strokes.iter().enumerate() {
            if let Some(point) = spec.ground_point_m.or((index == 0).then_some([0.0; 2])) {
                let known = flash.ground_points_m.iter().position(|&other| other == point);
                channel = known.unwrap_or(flash.ground_points_m.len());
                if known.is_none() {
                    flash.ground_points_m.push(point);
                }
            }
            let StrokeSpec { delay_s, peak_current_ka, continuing_s, .. } = *spec;
            let place = statistics::Place { delay_s, peak_current_ka, channel: channel as u32, index };
            flash.strokes.push(statistics::stroke(kind, polarity, place, continuing_s, seed));
        }
        statistics::lead(&mut flash, leader, seed);
        flash
    }

    /// Seconds from its beginning to its last light.
    pub fn duration_s(&self) -> f64 {
        let end = |stroke: &Stroke| stroke.delay_s + stroke_duration_s().max(stroke.continuing_s);
        self.strokes.iter().map(end).fold(0.0, f64::max)
    }

    /// All its luminous energy in lumen seconds.
    pub fn energy_lm_s(&self) -> f64 {
        let one = |stroke: &Stroke| {
            let leader = stroke.leader.map_or(0.0, |leader| leader.share);
            (1.0 + leader) * luminous_energy_lm_s(stroke.peak_current_ka) + continuing_energy_lm_s(stroke)
        };
        self.strokes.iter().map(one).sum()
    }

    /// Luminous energy that came out in `[begin, end)`, seconds after the flash begins: the sum of [`Flash::lights_in`].
    pub fn energy_in_lm_s(&self, begin_s: f64, end_s: f64) -> f64 {
        self.lights_in(begin_s, end_s, |_| true).iter().map(|light| light.amount).sum()
    }

    /// What shone in `[begin, end)`, seconds after the flash begins, of those strokes that `kept` keeps by their index: for each
    /// channel the tree, the main channel alone, and the stretches that leaders came through; parts without light are left out.
    pub fn lights_in(&self, begin_s: f64, end_s: f64, kept: impl Fn(usize) -> bool) -> Vec<Light> {
        let channels = self.ground_points_m.len();
        let mut whole = vec![[0.0; 2]; channels];
        let mut lights = Vec::new();
        let kept = self.strokes.iter().enumerate().filter(|(index, _)| kept(*index));
        for stroke in kept.map(|(_, stroke)| stroke) {
            let stroke_lm_s = luminous_energy_lm_s(stroke.peak_current_ka);
            let [from_s, to_s] = [begin_s, end_s].map(|edge_s| edge_s - stroke.delay_s);
            let [tree, main] = &mut whole[stroke.channel as usize];
            let part = stroke_lm_s * (stroke_share(to_s) - stroke_share(from_s));
            *(if stroke.opens { tree } else { &mut *main }) += part;
            let flowed = |since_s: f64| continuing_share(since_s, stroke.continuing_s);
            *main += continuing_energy_lm_s(stroke) * (flowed(to_s) - flowed(from_s));
            if let Some(Leader { length_s, share }) = stroke.leader {
                let span = [from_s, to_s].map(|since_s| (1.0 + since_s / length_s).clamp(0.0, 1.0));
                let amount = share * stroke_lm_s * (span[1] - span[0]);
                lights.push(Light { channel: stroke.channel, branches: stroke.opens, span, amount });
            }
        }
        for (channel, [tree, main]) in (0_u32..).zip(whole) {
            for (branches, amount) in [(true, tree), (false, main)] {
                lights.push(Light { channel, branches, span: [0.0, 1.0], amount });
            }
        }
        lights.retain(|light| light.amount > 0.0);
        lights
    }
}

fn continuing_energy_lm_s(stroke: &Stroke) -> f64 {
    continuing_power_lm(stroke.continuing_ka) * stroke.continuing_s / 2.0
}

#[cfg(test)]
mod tests;
