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

/// Most strokes that are drawn for one flash: about the most ever seen.
pub const MOST_SAMPLED_STROKES: usize = 26;

/// What the distributions say for a kind and polarity; each constant with its source. Pairs are the median of a log-normal
/// and the standard deviation of its common logarithm.
struct Statistics {
    /// Share of flashes with one stroke.
    single: f64,
    /// Mean number of strokes of the others.
    mean_of_multiple: f64,
    /// Seconds from stroke to stroke.
    interval_s: (f64, f64),
    /// First peak current in kA.
    first_ka: (f64, f64),
    /// Later peak currents in kA.
    later_ka: (f64, f64),
    /// Share of strokes followed by a continuing current.
    continuing: f64,
    /// Its length in seconds.
    continuing_s: (f64, f64),
    /// Shortest and longest.
    continuing_bounds_s: [f64; 2],
    /// Peak current in kA above which no long one follows.
    no_long_above_ka: f64,
}

/// Negative to ground. Strokes: mean 3.67 and a third single (Poelman et al. 2021, n = 1174), so the rest have 4.985 in the
/// mean. Intervals: 58 ms (CIGRE TB 549), 5 % above a quarter of a second. Currents: CIGRE TB 549 (first 30 kA, 0.265; later
/// 12 kA, 0.23). Continuing currents: 4 to 542 ms, long ones only after strokes below 20 kA (Saba, Pinto and Ballarotti
/// 2006, GRL 33 L23807); share and spread such that about 30 % of flashes have a long one (Saba et al. 2010).
const NEGATIVE: Statistics = Statistics {
    single: 0.33,
    mean_of_multiple: (3.67 - 0.33) / 0.67,
    interval_s: (0.058, 0.37),
    first_ka: (30.0, 0.265),
    later_ka: (12.0, 0.23),
    continuing: 0.48,
    continuing_s: (0.020, 0.55),
    continuing_bounds_s: [0.004, 0.542],
    no_long_above_ka: 20.0,
};

/// Positive to ground (Saba et al. 2010, "High-speed video observations of positive lightning flashes to ground", n = 103):
/// 81 % single, mean 1.2; intervals 94 ms; median current 39 kA; 75 % with a long continuing current, whatever the peak.
/// The spread of the current is that of Berger, Anderson and Kroeninger 1975 (5 % above 250 kA).
const POSITIVE: Statistics = Statistics {
    single: 0.81,
    mean_of_multiple: 2.05,
    interval_s: (0.094, 0.37),
    first_ka: (39.4, 0.5),
    later_ka: (20.0, 0.4),
    continuing: 0.75,
    continuing_s: (0.12, 0.3),
    continuing_bounds_s: [LONG_CONTINUING_S, 0.8],
    no_long_above_ka: f64::INFINITY,
};

/// Inside a cloud: the cloud is luminous for 0.2 to 0.5 s, more or less continuously, with several pulses of about a
/// millisecond on top (Krider, "Thunderstorm", Encyclopaedia Britannica). Number and intervals of the pulses are chosen to
/// give that: K changes alone follow each other faster (geometric mean 12 ms: Nanayakkara et al. 2019, Atmosphere 10, 141),
/// but few of them are bright. An assumption: equivalent currents a third of a first stroke's, as networks report 5 to 15 kA.
const INTRA_CLOUD: Statistics = Statistics {
    single: 0.05,
    mean_of_multiple: 7.0,
    interval_s: (0.04, 0.35),
    first_ka: (10.0, 0.25),
    later_ka: (6.0, 0.25),
    continuing: 0.9,
    continuing_s: (0.045, 0.25),
    continuing_bounds_s: [0.004, 0.542],
    no_long_above_ka: f64::INFINITY,
};

/// From cloud to cloud: as inside one, over a longer way and so for longer (flashes of 50 to 100 km are the long-lasting
/// ones: Cummins and Zhang 2020, EGU2020-4225). No statistics of their own are known: twice the duration is an assumption.
const CLOUD_TO_CLOUD: Statistics =
    Statistics { mean_of_multiple: 11.0, interval_s: (0.05, 0.35), continuing_s: (0.06, 0.25), ..INTRA_CLOUD };

/// A continuing current of this length and more is called long.
pub const LONG_CONTINUING_S: f64 = 0.04;
/// Shortest and longest time between strokes.
const INTERVAL_BOUNDS_S: [f64; 2] = [0.005, 0.7];
/// Bounds of the peak current (CIGRE TB 549 and tropical extremes).
const CURRENT_BOUNDS_KA: [f64; 2] = [2.0, 300.0];
/// Strength of a continuing current: typically 100 A (AMS Glossary of Meteorology), tens to hundreds.
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
                delay_s += intervals.log_normal(statistics.interval_s.0, statistics.interval_s.1, INTERVAL_BOUNDS_S);
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
        // Which sign goes which way inside clouds changes nothing that is known of the light.
        (FlashKind::IntraCloud, _) => &INTRA_CLOUD,
        (FlashKind::CloudToCloud, _) => &CLOUD_TO_CLOUD,
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
    let [shortest_s, longest_s] = statistics.continuing_bounds_s;
    let longest_s = if peak_current_ka > statistics.no_long_above_ka { LONG_CONTINUING_S } else { longest_s };
    let length_s = stream.log_normal(statistics.continuing_s.0, statistics.continuing_s.1, [shortest_s, longest_s]);
    let current_ka = stream.log_normal(CONTINUING_KA.0, CONTINUING_KA.1, CONTINUING_BOUNDS_KA);
    let (continuing_ka, continuing_s) = if flows { (current_ka, length_s) } else { (0.0, 0.0) };
    Stroke { delay_s, peak_current_ka, continuing_ka, continuing_s }
}

#[cfg(test)]
mod tests;
