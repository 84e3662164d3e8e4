//! Flashes: the distributions against what is published, and light that neither gets lost nor appears between frames.

use super::statistics::{LONG_CONTINUING_S, MOST_SAMPLED_STROKES};
use super::*;
use crate::lightning::photometry::{DART_LEADER_S, DART_LEADER_SHARE, STEPPED_LEADER_SHARE, stroke_rate};

const NEGATIVE_TO_GROUND: (FlashKind, Polarity) = (FlashKind::CloudToGround, Polarity::Negative);

fn samples(kind: FlashKind, polarity: Polarity, n: u64) -> Vec<Flash> {
    (0..n).map(|seed| Flash::sample(kind, polarity, None, false, seed)).collect()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
fn negative_flashes_have_the_published_numbers() {
    let flashes = samples(NEGATIVE_TO_GROUND.0, NEGATIVE_TO_GROUND.1, 20_000);
    let n = flashes.len() as f64;
    let mean = flashes.iter().map(|f| f.strokes.len() as f64).sum::<f64>() / n;
    // Mean 3.67; its standard deviation is 3.3, so the standard error 0.024, five of them; less 0.02 for the cut at 26.
    assert!((mean - 3.67).abs() < 0.14, "mean strokes {mean}");
    let single = flashes.iter().filter(|f| f.strokes.len() == 1).count() as f64 / n;
    // Standard error sqrt(0.33 * 0.67 / 20000) = 0.0033, five of them.
    assert!((single - 0.33).abs() < 0.017, "single {single}");
    assert!(flashes.iter().all(|f| f.strokes.len() <= MOST_SAMPLED_STROKES));

    let first = median(flashes.iter().map(|f| f.strokes[0].peak_current_ka).collect());
    // Standard error of a log-normal median: 1.25 * 0.61 / sqrt(20000) = 0.54 %, five of them.
    assert!((first / 30.0 - 1.0).abs() < 0.027, "first current {first}");
    let later: Vec<f64> = flashes.iter().flat_map(|f| &f.strokes[1..]).map(|s| s.peak_current_ka).collect();
    // The bound of 2 kA hardly moves the median of 12 kA; standard error 0.3 %, five of them and 0.5 % for the bound.
    assert!((median(later) / 12.0 - 1.0).abs() < 0.02);

    let gaps = |f: &Flash| f.strokes.windows(2).map(|p| p[1].delay_s - p[0].delay_s).collect::<Vec<_>>();
    let intervals: Vec<f64> = flashes.iter().flat_map(gaps).collect();
    // The bounds cut a little more above than below: 0.4 % of the median; standard error 0.46 %, five of them.
    assert!(intervals.iter().all(|&s| s >= 0.005 - 1e-12));
    assert!((median(intervals) / 0.058 - 1.0).abs() < 0.03);

    let stronger = |f: &&Flash| f.strokes[1..].iter().any(|s| s.peak_current_ka > f.strokes[0].peak_current_ka);
    let share =
        flashes.iter().filter(stronger).count() as f64 / flashes.iter().filter(|f| f.strokes.len() > 1).count() as f64;
    // 15 of 46 flashes, 33 % (Thottappillil et al. 1992): one standard error of their count is 7 %.
    assert!((0.26..0.40).contains(&share), "a later stroke is stronger in {share}");
}

#[test]
fn continuing_currents_are_as_often_and_as_long_as_seen() {
    let long = |f: &&Flash| f.strokes.iter().any(|s| s.continuing_s >= LONG_CONTINUING_S);
    let negative = samples(NEGATIVE_TO_GROUND.0, NEGATIVE_TO_GROUND.1, 10_000);
    let share = negative.iter().filter(long).count() as f64 / 10_000.0;
    // "Approximately 30 %" of negative flashes (Saba et al. 2010): a statement in round words.
    assert!((share - 0.30).abs() < 0.03, "{share}");
    for stroke in negative.iter().flat_map(|f| &f.strokes).filter(|s| s.continuing_s > 0.0) {
        assert!((0.004..=0.542).contains(&stroke.continuing_s));
        assert!(stroke.peak_current_ka <= 20.0 || stroke.continuing_s <= LONG_CONTINUING_S, "{stroke:?}");
    }
    let positive = samples(FlashKind::CloudToGround, Polarity::Positive, 10_000);
    let share = positive.iter().filter(long).count() as f64 / 10_000.0;
    // 75 % of positive flashes; drawn for each of 1.2 strokes, so a fifth of the flashes have two chances (to 78.6 %).
    assert!((share - 0.77).abs() < 0.03, "{share}");
}

#[test]
fn positive_flashes_are_fewer_stronger_and_longer() {
    let flashes = samples(FlashKind::CloudToGround, Polarity::Positive, 20_000);
    let mean = flashes.iter().map(|f| f.strokes.len() as f64).sum::<f64>() / flashes.len() as f64;
    // Mean 1.2 (Saba et al. 2010); standard error 0.003.
    assert!((mean - 1.2).abs() < 0.02, "{mean}");
    let middle = median(flashes.iter().map(|f| f.strokes[0].peak_current_ka).collect());
    // The bound of 300 kA cuts the highest 4 % away: the median falls by 4.6 %, and 1 % is the standard error.
    assert!((0.92..1.0).contains(&(middle / 39.4)), "{middle}");
    let strong = flashes.iter().filter(|f| f.strokes[0].peak_current_ka > 100.0).count();
    let negative = samples(NEGATIVE_TO_GROUND.0, NEGATIVE_TO_GROUND.1, 20_000);
    let strong_negative = negative.iter().filter(|f| f.strokes[0].peak_current_ka > 100.0).count();
    assert!(strong > 5 * strong_negative, "{strong} {strong_negative}");
    let intervals =
        flashes.iter().flat_map(|f| f.strokes.windows(2).map(|p| p[1].delay_s - p[0].delay_s).collect::<Vec<_>>());
    // 94 ms; 4000 intervals: standard error 1.7 %, five of them.
    assert!((median(intervals.collect()) / 0.094 - 1.0).abs() < 0.085);
}

#[test]
fn light_adds_up_over_frames_at_every_rate() {
    for (kind, polarity, leader, seed) in [
        (FlashKind::CloudToGround, Polarity::Negative, false, 3),
        (FlashKind::CloudToGround, Polarity::Negative, true, 3),
        (FlashKind::CloudToGround, Polarity::Positive, true, 4),
        (FlashKind::IntraCloud, Polarity::Negative, false, 5),
        (FlashKind::CloudToCloud, Polarity::Negative, true, 6),
    ] {
        let flash = Flash::sample(kind, polarity, None, leader, seed);
        for rate_hz in [24.0, 60.0, 120.0] {
            let frames = (flash.duration_s() * rate_hz).ceil() as u32 + 2;
            let offset_s = 0.37 / rate_hz;
            let sum: f64 = (0..frames)
                .map(|k| f64::from(k) / rate_hz - offset_s)
                .map(|t| flash.energy_in_lm_s(t, t + 1.0 / rate_hz))
                .sum();
            // Abutting intervals of a closed form telescope; the ends of neighbouring frames differ by rounding (1e-16 s
            // of times), which moves 1e-13 of the energy.
            assert!((sum / flash.energy_lm_s() - 1.0).abs() < 1e-6, "{kind:?} at {rate_hz} Hz: {sum}");
        }
    }
}

#[test]
fn energy_is_the_integral_of_power() {
    let stroke = Stroke {
        delay_s: 0.01,
        peak_current_ka: 30.0,
        continuing_ka: 0.1,
        continuing_s: 0.08,
        channel: 0,
        opens: true,
        leader: Some(Leader { length_s: 0.005, share: 0.05 }),
    };
    let flash = Flash { strokes: vec![stroke], ground_points_m: vec![[0.0; 2]] };
    let power_lm = |after_s: f64| {
        let since_s = after_s - 0.01;
        let stroke_lm_s = luminous_energy_lm_s(30.0);
        let leader = if (-0.005..0.0).contains(&since_s) { 0.05 / 0.005 } else { 0.0 };
        let left = if (0.0..0.08).contains(&since_s) { 1.0 - since_s / 0.08 } else { 0.0 };
        stroke_lm_s * (stroke_rate(since_s) + leader) + continuing_power_lm(0.1) * left
    };
    let step = 1e-6;
    let sum: f64 = (0..100_000).map(|k| power_lm((f64::from(k) + 0.5) * step) * step).sum();
    // Midpoint rule with a kink at the onset: h^2/24 * 4e8 / s^2 of the energy and less: 2e-11; a step at the onset of
    // the continuing current falls on a cell's edge.
    assert!((sum / flash.energy_lm_s() - 1.0).abs() < 1e-6, "{sum} {}", flash.energy_lm_s());
    assert_eq!(flash.energy_in_lm_s(-1.0, 0.005), 0.0, "no light before the leader");
    assert_eq!(flash.energy_in_lm_s(flash.duration_s(), 10.0), 0.0, "no light after the end");
}

#[test]
fn the_seed_and_the_given_currents_decide() {
    let sample = |seed, first| Flash::sample(FlashKind::CloudToGround, Polarity::Negative, first, false, seed);
    assert_eq!(sample(9, None), sample(9, None));
    assert_ne!(sample(9, None), sample(10, None));
    assert_eq!(sample(9, Some(60.0)).strokes[0].peak_current_ka, 60.0);
    let ratio =
        |a: &Flash, b: &Flash| a.strokes.last().unwrap().peak_current_ka / b.strokes.last().unwrap().peak_current_ka;
    let many = (0..99).find(|&seed| sample(seed, None).strokes.len() > 2).unwrap();
    // The later strokes are scaled by the given current over the median of 30 kA.
    assert!((ratio(&sample(many, Some(60.0)), &sample(many, Some(30.0))) - 2.0).abs() < 1e-12);

    let spec = |delay_s, peak_current_ka| StrokeSpec { delay_s, peak_current_ka, ..Default::default() };
    let strokes = [spec(0.0, 20.0), spec(0.3, 5.0)];
    let given = Flash::given(FlashKind::CloudToGround, Polarity::Negative, &strokes, false, 1);
    assert_eq!(given.strokes.len(), 2);
    assert_eq!((given.strokes[1].delay_s, given.strokes[1].peak_current_ka), (0.3, 5.0));
}

#[test]
fn flashes_in_and_between_clouds_glow_on_as_long_as_is_seen() {
    let of = |kind| samples(kind, Polarity::Negative, 4_000);
    let [inside, between, ground] = [FlashKind::IntraCloud, FlashKind::CloudToCloud, FlashKind::CloudToGround].map(of);
    let length = |flashes: &[Flash]| median(flashes.iter().map(Flash::duration_s).collect());
    // "Approximately 0.2 to 0.5 second"; a standard error of the median of 2 % moves it out of neither end.
    assert!((0.22..0.46).contains(&length(&inside)), "{}", length(&inside));
    let ratio = length(&between) / length(&inside);
    assert!((1.7..2.3).contains(&ratio), "{ratio}");
    // "More or less continuous": the share of the time in which there is light, in steps of a millisecond.
    let lit = |flashes: &[Flash]| {
        let of_one = |f: &Flash| {
            let steps = (f.duration_s() * 1e3) as usize;
            (0..steps).map(|k| k as f64 * 1e-3).filter(|&t| f.energy_in_lm_s(t, t + 1e-6) > 1e-3).count() as f64
                / steps as f64
        };
        flashes.iter().take(500).map(of_one).sum::<f64>() / 500.0
    };
    let [a, b, c] = [&inside, &between, &ground].map(|flashes| lit(flashes));
    assert!(a > 0.68 && b > 0.68, "{a} {b}");
    assert!(c < 0.6, "strokes to ground leave it dark in between: {c}");
    // Several pulses, each far above the glow: at its peak a pulse of 6 kA gives 50 times the light of 0.1 kA.
    let several = inside.iter().filter(|f| f.strokes.len() >= 3).count() as f64 / 4_000.0;
    assert!(several > 0.75, "{several}");
    let brightest = |f: &Flash| f.strokes.iter().map(|s| s.peak_current_ka).fold(0.0, f64::max);
    assert!(median(inside.iter().map(brightest).collect()) < 0.6 * median(ground.iter().map(brightest).collect()));
}

#[test]
fn what_shines_is_the_tree_once_then_the_main_channel_and_leaders_come_along_it() {
    let spec = |delay_s, peak_current_ka| StrokeSpec { delay_s, peak_current_ka, ..Default::default() };
    let second_point = StrokeSpec { ground_point_m: Some([900.0, -400.0]), ..spec(0.2, 12.0) };
    let back = StrokeSpec { ground_point_m: Some([0.0, 0.0]), ..spec(0.3, 8.0) };
    let steady = StrokeSpec { continuing_s: Some(0.1), ..spec(0.4, 8.0) };
    let strokes = [spec(0.0, 30.0), spec(0.1, 10.0), second_point, back, steady];
    for leader in [false, true] {
        let flash = Flash::given(FlashKind::CloudToGround, Polarity::Negative, &strokes, leader, 7);
        assert_eq!(flash.ground_points_m, [[0.0, 0.0], [900.0, -400.0]]);
        let seen: Vec<(u32, bool)> = flash.strokes.iter().map(|stroke| (stroke.channel, stroke.opens)).collect();
        assert_eq!(seen, [(0, true), (0, false), (1, true), (0, false), (0, false)]);
        assert_eq!(flash.strokes[4].continuing_s, 0.1, "as given");
        assert!(flash.strokes[4].continuing_ka > 0.0);
        let leaders: Vec<Option<f64>> =
            flash.strokes.iter().map(|stroke| stroke.leader.map(|leader| leader.share)).collect();
        let (stepped, dart) = (leader.then_some(STEPPED_LEADER_SHARE), Some(DART_LEADER_SHARE));
        assert_eq!(leaders, [stepped, dart, stepped, dart, dart]);
        // The first return stroke comes at once, or after its leader, and all others keep their distance from it.
        let first_s = flash.strokes[0].delay_s;
        assert_eq!(first_s > 0.0, leader);
        assert!((flash.strokes[3].delay_s - first_s - 0.3).abs() < 1e-12);

        let during = |stroke: usize| {
            let from_s = flash.strokes[stroke].delay_s;
            flash.lights_in(from_s, from_s + 1e-3, |_| true)
        };
        // Of a first stroke the tree and, a little, its continuing current; of a later one the main channel alone.
        assert!(during(0)[0].branches && during(2).iter().any(|light| light.branches && light.channel == 1));
        assert!(during(1).iter().chain(&during(3)).all(|light| !light.branches));
        // The dart leader's last millisecond comes down the lower half of the main channel, evenly.
        let dart_s = flash.strokes[1].delay_s;
        let tip = flash.lights_in(dart_s - DART_LEADER_S / 2.0, dart_s, |_| true);
        let tip = tip.iter().find(|light| light.span != [0.0, 1.0]).expect("a leader");
        assert!((tip.span[0] - 0.5).abs() < 1e-9 && tip.span[1] == 1.0 && !tip.branches, "{tip:?}");
        let half = 0.5 * DART_LEADER_SHARE * luminous_energy_lm_s(10.0);
        assert!((tip.amount / half - 1.0).abs() < 1e-9);
        // What is not kept gives nothing, with its leader and its continuing current.
        assert_eq!(flash.lights_in(dart_s - 0.01, dart_s + 0.05, |stroke| stroke != 1 && stroke != 0), []);
    }
    // Strokes at one moment leave no time for a leader.
    let together = Flash::given(FlashKind::CloudToGround, Polarity::Negative, &[spec(0.0, 9.0); 2], true, 7);
    assert!(together.strokes[1].leader.is_none() && together.energy_lm_s().is_finite());
}

#[test]
fn ground_points_are_as_many_and_as_far_apart_as_seen() {
    let flashes = samples(NEGATIVE_TO_GROUND.0, NEGATIVE_TO_GROUND.1, 20_000);
    let points = flashes.iter().map(|flash| flash.ground_points_m.len() as f64).sum::<f64>() / 20_000.0;
    // 1.45 to 1.7 in the published sets (Rakov and Uman 1990: 1.7; Valine and Krider 2002: 1.45), which differ in how many
    // single-stroke flashes they have.
    assert!((1.35..1.7).contains(&points), "{points}");
    let away: Vec<f64> = flashes.iter().flat_map(|f| &f.ground_points_m[1..]).map(|p| p[0].hypot(p[1])).collect();
    assert!(away.iter().all(|m| (300.0..=7_300.0).contains(m)));
    // Standard error of a log-normal median: 1.25 * 0.69 / sqrt(8000) = 1 %; the bounds move it by less than two.
    assert!((median(away) / 1_700.0 - 1.0).abs() < 0.06);
    // The strokes of a flash are at its points, and every point has a stroke that opens its channel.
    for flash in &flashes {
        let opened = flash.strokes.iter().filter(|stroke| stroke.opens).count();
        assert_eq!(opened, flash.ground_points_m.len());
        assert!(flash.duration_s() < LONGEST_FLASH_S);
    }
    for flash in samples(FlashKind::IntraCloud, Polarity::Negative, 100) {
        assert_eq!(flash.ground_points_m, [[0.0, 0.0]]);
    }
}

#[test]
fn a_stepped_leader_takes_as_long_as_is_seen_and_is_faint() {
    let lengths: Vec<f64> = (0..4_000)
        .map(|seed| Flash::sample(FlashKind::CloudToGround, Polarity::Negative, None, true, seed))
        .map(|flash| flash.strokes[0].leader.expect("it was asked for").length_s)
        .collect();
    // 5 km at 0.9 to 3.0e5 m/s: 17 to 56 ms; the median by its standard error of 0.7 %, five of them.
    assert!(lengths.iter().all(|s| (0.01..=0.1).contains(s)));
    assert!((median(lengths) / 0.033 - 1.0).abs() < 0.04);
    let flash = Flash::sample(FlashKind::CloudToGround, Polarity::Negative, Some(30.0), true, 1);
    let before = flash.energy_in_lm_s(0.0, flash.strokes[0].delay_s);
    assert!(before > 0.0 && before < 0.1 * luminous_energy_lm_s(30.0));
}
