//! A flash in time: its strokes, drawn from published distributions or given, and the light in any interval.

use super::photometry::{
    continuing_power_lm, continuing_share, luminous_energy_lm_s, stroke_duration_s, stroke_rate, stroke_share,
};
use super::random::Stream;

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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrokeSpec {
    /// Seconds after the flash begins.
    pub delay_s: f64,
    /// Peak current in kiloamperes, positive.
    pub peak_current_ka: f64,
}

/// A stroke with its continuing current.
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
}

/// The strokes of one flash, in rising order of delay.
#[derive(Clone, Debug, PartialEq)]
pub struct Flash {
    /// The strokes.
    pub strokes: Vec<Stroke>,
}

/// Most strokes that are drawn for one flash; 26 is the most ever seen (Malan 1956).
pub const MOST_SAMPLED_STROKES: usize = 26;

/// What the distributions say for a kind and polarity; each constant with its source.
struct Statistics {
    /// Share of flashes with one stroke.
    single: f64,
    /// Mean number of strokes of the others.
    mean_of_multiple: f64,
    /// Median first peak current in kA and standard deviation of its common logarithm.
    first_ka: (f64, f64),
    /// The same for later strokes.
    later_ka: (f64, f64),
    /// Share of strokes followed by a continuing current.
    continuing: f64,
    /// Its median length in seconds and standard deviation of the common logarithm.
    continuing_s: (f64, f64),
}

/// Negative to ground. Strokes: mean 3.67 and a third single (Poelman et al.; CIGRE TB 549), so the rest have 4.985 in
/// the mean. Currents: CIGRE TB 549 (first 30 kA, 0.265; later 12 kA, 0.23). Continuing current: after 36 % of strokes,
/// 4 to 542 ms (Saba et al. 2006); the log-normal about 12 ms puts a tenth above the 40 ms that are called long.
const NEGATIVE: Statistics = Statistics {
    single: 0.33,
    mean_of_multiple: (3.67 - 0.33) / 0.67,
    first_ka: (30.0, 0.265),
    later_ka: (12.0, 0.23),
    continuing: 0.36,
    continuing_s: (0.012, 0.41),
};

/// Positive to ground. Mostly one stroke (mean 1.2, Saba et al. 2010), 35 kA with 5 % above 250 kA (Berger, Anderson and
/// Kroeninger 1975: sigma(log10) 0.52), three quarters with a continuing current, long ones (Saba et al. 2010).
const POSITIVE: Statistics = Statistics {
    single: 0.81,
    mean_of_multiple: 2.05,
    first_ka: (35.0, 0.52),
    later_ka: (20.0, 0.4),
    continuing: 0.75,
    continuing_s: (0.08, 0.4),
};

/// In and between clouds: optical pulses of K changes and recoil leaders instead of return strokes. Few measurements; the
/// number as in negative flashes, the equivalent currents a third (networks report 5 to 15 kA), currents often going on.
const IN_CLOUD: Statistics = Statistics {
    single: 0.2,
    mean_of_multiple: 5.0,
    first_ka: (10.0, 0.25),
    later_ka: (6.0, 0.25),
    continuing: 0.5,
    continuing_s: (0.03, 0.4),
};

/// Seconds between strokes: geometric mean 58 ms (CIGRE TB 549), log-normal, 5 % above 0.25 s; never below 5 ms.
const INTERVAL_S: (f64, f64) = (0.058, 0.37);
const INTERVAL_BOUNDS_S: [f64; 2] = [0.005, 0.7];
/// Bounds of the peak current (CIGRE TB 549 and tropical extremes).
const CURRENT_BOUNDS_KA: [f64; 2] = [2.0, 300.0];
/// Continuing currents seen by high-speed video (Saba et al. 2006).
const CONTINUING_BOUNDS_S: [f64; 2] = [0.004, 0.542];
/// Strength of a continuing current: median 100 A (tens to hundreds of amperes).
const CONTINUING_KA: (f64, f64) = (0.1, 0.25);
const CONTINUING_BOUNDS_KA: [f64; 2] = [0.02, 1.0];

impl Flash {
    /// A flash drawn by its seed: number of strokes, intervals, currents and continuing currents.
    ///
    /// `first_peak_current_ka` fixes the first current; the later ones then keep their usual proportion to it.
    pub fn sample(kind: FlashKind, polarity: Polarity, first_peak_current_ka: Option<f64>, seed: u64) -> Self {
        let statistics = statistics(kind, polarity);
        let count = number_of_strokes(statistics, &mut Stream::new(seed, 0));
        let mut currents = Stream::new(seed, 1);
        let mut intervals = Stream::new(seed, 2);
        let (median, sigma) = statistics.first_ka;
        let drawn = currents.log_normal(median, sigma, CURRENT_BOUNDS_KA);
        let first = first_peak_current_ka.unwrap_or(drawn);
        let scale = first_peak_current_ka.map_or(1.0, |given| given / median);
        let mut strokes = Vec::with_capacity(count);
        let mut delay_s = 0.0;
        for index in 0..count {
            let peak_current_ka = if index == 0 {
                first
            } else {
                delay_s += intervals.log_normal(INTERVAL_S.0, INTERVAL_S.1, INTERVAL_BOUNDS_S);
                scale * currents.log_normal(statistics.later_ka.0, statistics.later_ka.1, CURRENT_BOUNDS_KA)
            };
            strokes.push(with_continuing(delay_s, peak_current_ka, statistics, seed, index));
        }
        Self { strokes }
    }

    /// A flash of given strokes (in rising order of delay); only the continuing currents are drawn.
    pub fn given(kind: FlashKind, polarity: Polarity, strokes: &[StrokeSpec], seed: u64) -> Self {
        let statistics = statistics(kind, polarity);
        let one = |(index, spec): (usize, &StrokeSpec)| {
            with_continuing(spec.delay_s, spec.peak_current_ka, statistics, seed, index)
        };
        Self { strokes: strokes.iter().enumerate().map(one).collect() }
    }

    /// Seconds from its beginning to its last light.
    pub fn duration_s(&self) -> f64 {
        let end = |stroke: &Stroke| stroke.delay_s + stroke_duration_s().max(stroke.continuing_s);
        self.strokes.iter().map(end).fold(0.0, f64::max)
    }

    /// All its luminous energy in lumen seconds.
    pub fn energy_lm_s(&self) -> f64 {
        self.energy_until_lm_s(f64::INFINITY)
    }

    /// Luminous energy that came out in `[begin, end)`, seconds after the flash begins: closed form, so that intervals
    /// that abut add up to the whole.
    pub fn energy_in_lm_s(&self, begin_s: f64, end_s: f64) -> f64 {
        self.energy_until_lm_s(end_s) - self.energy_until_lm_s(begin_s)
    }

    /// Luminous power at one instant in lumens.
    pub fn power_lm(&self, after_s: f64) -> f64 {
        let one = |stroke: &Stroke| {
            let since_s = after_s - stroke.delay_s;
            let flowing = since_s >= 0.0 && since_s < stroke.continuing_s;
            let left = if flowing { 1.0 - since_s / stroke.continuing_s } else { 0.0 };
            luminous_energy_lm_s(stroke.peak_current_ka) * stroke_rate(since_s)
                + continuing_power_lm(stroke.continuing_ka) * left
        };
        self.strokes.iter().map(one).sum()
    }

    fn energy_until_lm_s(&self, after_s: f64) -> f64 {
        let one = |stroke: &Stroke| {
            let since_s = after_s - stroke.delay_s;
            let going_on = continuing_power_lm(stroke.continuing_ka) * stroke.continuing_s / 2.0;
            luminous_energy_lm_s(stroke.peak_current_ka) * stroke_share(since_s)
                + going_on * continuing_share(since_s, stroke.continuing_s)
        };
        self.strokes.iter().map(one).sum()
    }
}

fn statistics(kind: FlashKind, polarity: Polarity) -> &'static Statistics {
    match (kind, polarity) {
        (FlashKind::CloudToGround, Polarity::Negative) => &NEGATIVE,
        (FlashKind::CloudToGround, Polarity::Positive) => &POSITIVE,
        (FlashKind::IntraCloud | FlashKind::CloudToCloud, _) => &IN_CLOUD,
    }
}

/// One, or two and more by a geometric distribution with the right mean.
fn number_of_strokes(statistics: &Statistics, stream: &mut Stream) -> usize {
    if stream.unit() < statistics.single {
        return 1;
    }
    let more = statistics.mean_of_multiple - 2.0;
    if more <= 0.0 {
        return 2;
    }
    let fail = more / (1.0 + more);
    // At most 26 strokes; the cut takes 0.02 off the mean.
    2 + ((stream.unit().ln() / fail.ln()) as usize).min(MOST_SAMPLED_STROKES - 2)
}

fn with_continuing(delay_s: f64, peak_current_ka: f64, statistics: &Statistics, seed: u64, index: usize) -> Stroke {
    // A stream for each stroke, so that one more draw here changes no other stroke.
    let mut stream = Stream::new(seed, 16 + index as u64);
    let flows = stream.unit() < statistics.continuing;
    let length_s = stream.log_normal(statistics.continuing_s.0, statistics.continuing_s.1, CONTINUING_BOUNDS_S);
    let current_ka = stream.log_normal(CONTINUING_KA.0, CONTINUING_KA.1, CONTINUING_BOUNDS_KA);
    let (continuing_ka, continuing_s) = if flows { (current_ka, length_s) } else { (0.0, 0.0) };
    Stroke { delay_s, peak_current_ka, continuing_ka, continuing_s }
}

#[cfg(test)]
mod tests;
