//! What is published of flashes, and strokes drawn from it: number, intervals, currents, ground points, leaders.

use super::{Flash, FlashKind, Leader, Polarity, Stroke};
use crate::lightning::photometry::{DART_LEADER_S, DART_LEADER_SHARE, STEPPED_LEADER_SHARE};
use crate::lightning::random::Stream;

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
    /// Chance that the second, third, fourth stroke makes a ground point of its own; later ones never do.
    new_point: [f64; 3],
}

/// Negative to ground. Strokes: mean 3.67 and a third single (Poelman et al. 2021, n = 1174), so the rest have 4.985 in the
/// mean. Intervals: 58 ms (CIGRE TB 549), 5 % above a quarter of a second. Currents: CIGRE TB 549 (first 30 kA, 0.265; later
/// 12 kA, 0.23). Continuing currents: 4 to 542 ms, long ones only after strokes below 20 kA (Saba, Pinto and Ballarotti
/// 2006, GRL 33 L23807); share and spread such that about 30 % of flashes have a long one (Saba et al. 2010). New ground
/// points: by order of the stroke as Rakov and Uman 1990, JGR 95 5455 (Florida, 76 flashes).
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
    new_point: [0.37, 0.27, 0.02],
};

/// Positive to ground (Saba et al. 2010, "High-speed video observations of positive lightning flashes to ground", n = 103):
/// 81 % single, mean 1.2; intervals 94 ms; median current 39 kA; 75 % with a long continuing current, whatever the peak.
/// The spread of the current is that of Berger, Anderson and Kroeninger 1975 (5 % above 250 kA). Later positive strokes hardly
/// ever take the old channel: nine in ten is what is assumed here.
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
    new_point: [0.9; 3],
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
    new_point: [0.0; 3],
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
/// Latest stroke that is drawn, in seconds: flashes last some tenths of a second, rarely two seconds.
const LATEST_S: f64 = 3.0;
/// Length of a stepped leader: from a charge 5 km high at 1.5e5 m/s (0.9 to 3.0e5 m/s: Kong et al. 2009; Stolzenburg et al.
/// 2013, "Stepped-to-dart leaders preceding lightning return strokes").
const STEPPED_S: (f64, f64) = (0.033, 0.15);
const STEPPED_BOUNDS_S: [f64; 2] = [0.01, 0.1];
/// Greatest part of the time since the stroke before that a leader takes.
const MOST_OF_INTERVAL: f64 = 0.5;
/// Distance of ground points of one flash: geometric mean 1.7 km, 0.3 to 7.3 km (Thottappillil et al. 1992, JGR 97 7503).
const POINT_DISTANCE_M: (f64, f64) = (1_700.0, 0.3);
const POINT_DISTANCE_BOUNDS_M: [f64; 2] = [300.0, 7_300.0];

/// Streams of random numbers under a flash's seed; the strokes' continuing currents follow from the last.
const NUMBER: u64 = 0;
const CURRENTS: u64 = 1;
const INTERVALS: u64 = 2;
const POINTS: u64 = 3;
const LEADERS: u64 = 4;
const CONTINUING: u64 = 16;

/// The peak current of the first stroke that a flash of this seed draws, in kiloamperes.
pub fn first_peak_current_ka(kind: FlashKind, polarity: Polarity, seed: u64) -> f64 {
    let (median, sigma) = statistics(kind, polarity).first_ka;
    Stream::new(seed, CURRENTS).log_normal(median, sigma, CURRENT_BOUNDS_KA)
}

/// Strokes and ground points by seed; see [`Flash::sample`].
pub(super) fn sample(kind: FlashKind, polarity: Polarity, first_ka: Option<f64>, seed: u64) -> Flash {
    let statistics = statistics(kind, polarity);
    let count = number_of_strokes(statistics, &mut Stream::new(seed, NUMBER));
    let mut currents = Stream::new(seed, CURRENTS);
    let mut intervals = Stream::new(seed, INTERVALS);
    let mut points = Stream::new(seed, POINTS);
    let (median, sigma) = statistics.first_ka;
    let drawn = currents.log_normal(median, sigma, CURRENT_BOUNDS_KA);
    let first = first_ka.unwrap_or(drawn);
    let scale = first_ka.map_or(1.0, |given| given / median);
    let mut flash = Flash { strokes: Vec::with_capacity(count), ground_points_m: vec![[0.0; 2]] };
    let mut delay_s = 0.0;
    for index in 0..count {
        let mut peak_current_ka = first;
        if index > 0 {
            delay_s += intervals.log_normal(statistics.interval_s.0, statistics.interval_s.1, INTERVAL_BOUNDS_S);
            let (median, sigma) = statistics.later_ka;
            peak_current_ka = scale * currents.log_normal(median, sigma, CURRENT_BOUNDS_KA);
        }
        if delay_s > LATEST_S {
            break;
        }
        let (chance, turn) = (points.unit(), points.unit());
        let (median, sigma) = POINT_DISTANCE_M;
        let away_m = points.log_normal(median, sigma, POINT_DISTANCE_BOUNDS_M);
        if index > 0 && statistics.new_point.get(index - 1).is_some_and(|&likely| chance < likely) {
            let (sin, cos) = (std::f64::consts::TAU * turn).sin_cos();
            flash.ground_points_m.push([away_m * cos, away_m * sin]);
        }
        let channel = flash.ground_points_m.len() as u32 - 1;
        let drawn = Place { delay_s, peak_current_ka, channel, index };
        flash.strokes.push(stroke(kind, polarity, drawn, None, seed));
    }
    flash
}

/// What is known of a stroke before its continuing current is drawn.
pub(super) struct Place {
    pub delay_s: f64,
    pub peak_current_ka: f64,
    pub channel: u32,
    /// Its number in the flash.
    pub index: usize,
}

/// A stroke with its continuing current, whose strength, and length where none is given, are drawn by seed and index. It has no
/// leader yet.
pub(super) fn stroke(kind: FlashKind, polarity: Polarity, place: Place, given_s: Option<f64>, seed: u64) -> Stroke {
    let statistics = statistics(kind, polarity);
    let Place { delay_s, peak_current_ka, channel, index } = place;
    // A stream for each stroke, so that one more draw here changes no other stroke.
    let mut stream = Stream::new(seed, CONTINUING + index as u64);
    let flows = stream.unit() < statistics.continuing;
    let [shortest_s, longest_s] = statistics.continuing_bounds_s;
    let longest_s = if peak_current_ka > statistics.no_long_above_ka { LONG_CONTINUING_S } else { longest_s };
    let drawn_s = stream.log_normal(statistics.continuing_s.0, statistics.continuing_s.1, [shortest_s, longest_s]);
    let drawn_ka = stream.log_normal(CONTINUING_KA.0, CONTINUING_KA.1, CONTINUING_BOUNDS_KA);
    let continuing_s = given_s.unwrap_or(if flows { drawn_s } else { 0.0 });
    let continuing_ka = if continuing_s > 0.0 { drawn_ka } else { 0.0 };
    Stroke { delay_s, peak_current_ka, continuing_ka, continuing_s, channel, opens: false, leader: None }
}

/// Finds which stroke opens which channel, and puts leaders before the strokes: dart leaders where a channel is there, and
/// stepped ones before the others when `stepped`, which puts the first stroke off by its leader's length.
pub(super) fn lead(flash: &mut Flash, stepped: bool, seed: u64) {
    let mut stream = Stream::new(seed, LEADERS);
    let mut put_off_s = 0.0;
    let mut opened = vec![false; flash.ground_points_m.len()];
    let mut before_s: Option<f64> = None;
    for stroke in &mut flash.strokes {
        let opens = !std::mem::replace(&mut opened[stroke.channel as usize], true);
        let longest_s = before_s.map_or(f64::INFINITY, |before_s| MOST_OF_INTERVAL * (stroke.delay_s - before_s));
        before_s = Some(stroke.delay_s);
        let drawn_s = stream.log_normal(STEPPED_S.0, STEPPED_S.1, STEPPED_BOUNDS_S);
        stroke.opens = opens;
        stroke.leader = match (opens, stepped) {
            (true, true) => Some(Leader { length_s: drawn_s.min(longest_s), share: STEPPED_LEADER_SHARE }),
            (true, false) => None,
            (false, _) => Some(Leader { length_s: DART_LEADER_S.min(longest_s), share: DART_LEADER_SHARE }),
        }
        .filter(|leader| leader.length_s > 0.0);
        if longest_s.is_infinite() {
            put_off_s = stroke.leader.map_or(0.0, |leader| leader.length_s);
        }
        stroke.delay_s += put_off_s;
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
