//! The thunder of a whole flash along its channels.

use super::air::Air;
use super::{Chord, Path, Pulse, chords, pulses};
use crate::lightning::flash::Flash;
use crate::lightning::strike::StrikeChannel;

/// What a listener hears of all strokes of a flash, in the order of the strokes. `listener_m`: east, north and up from the flash's
/// ground point, as the channel's points are.
pub fn heard(channel: &StrikeChannel, flash: &Flash, listener_m: [f64; 3], air: &Air) -> Vec<Pulse> {
    // Cut once for each channel, as a tree and as a main channel alone.
    let mut cut: Vec<[Option<Vec<Chord>>; 2]> = Vec::new();
    cut.resize_with(channel.grounds, Default::default);
    let mut found = Vec::new();
    for stroke in &flash.strokes {
        let ground = (stroke.channel as usize).min(channel.grounds - 1);
        let held =
            cut[ground][usize::from(stroke.opens)].get_or_insert_with(|| chords(&paths(channel, ground, stroke.opens)));
        found.extend(pulses(held, stroke.delay_s, stroke.peak_current_ka, listener_m, air));
    }
    found
}

/// The main channel to a ground point, with `branches` the side channels that leave it too.
pub fn paths(channel: &StrikeChannel, ground: usize, branches: bool) -> Vec<Path> {
    let mut paths = Vec::new();
    for line in channel.lines.iter().filter(|line| branches || line.order == 0) {
        let points = &channel.points[line.first as usize..(line.first + line.count) as usize];
        let metres = |k: usize| points[k].position_m.map(f64::from);
        let (light_m, length_m) =
            (points[points.len() - 1].light_m, points[points.len() - 1].along_m - points[0].along_m);
        let share = if line.order == 0 || length_m <= 0.0 { 1.0 } else { f64::from(light_m / length_m).min(1.0) };
        // A main line may lead to other ground points as well: its pieces that lead to this one.
        let mut run: Vec<[f64; 3]> = Vec::new();
        for (k, point) in points.iter().enumerate().skip(1) {
            let ours = point.grounds >> ground & 1 == 1 || line.order > 0 && point.grounds == 0;
            if ours {
                if run.is_empty() {
                    run.push(metres(k - 1));
                }
                run.push(metres(k));
            } else if !run.is_empty() {
                paths.push(Path { points_m: std::mem::take(&mut run), share });
            }
        }
        if !run.is_empty() {
            paths.push(Path { points_m: run, share });
        }
    }
    paths
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lightning::flash::{FlashKind, Polarity, StrokeSpec};
    use crate::lightning::strike::{ChannelLine, ChannelPoint};

    /// A main channel 2 km high that forks at half its height to a second ground point, and a branch.
    fn forked() -> StrikeChannel {
        let point = |position_m: [f32; 3], along_m, grounds| {
            let (light_m, detail_m) = (along_m, f32::INFINITY);
            ChannelPoint { position_m, along_m, light_m, detail_m, grounds }
        };
        let points = vec![
            point([0.0, 0.0, 2_000.0], 0.0, 0b11),
            point([0.0, 0.0, 1_000.0], 1_000.0, 0b11),
            point([0.0, 0.0, 0.0], 2_000.0, 0b01),
            point([0.0, 0.0, 1_000.0], 1_000.0, 0b10),
            point([0.0, 3_000.0, 0.0], 4_162.0, 0b10),
            point([0.0, 0.0, 1_500.0], 500.0, 0b01),
            ChannelPoint { light_m: 150.0, ..point([-500.0, 0.0, 1_500.0], 1_000.0, 0b01) },
        ];
        let line = |first, count, order| ChannelLine { first, count, order, radius_m: 0.1 };
        let lines = vec![line(0, 3, 0), line(3, 2, 0), line(5, 2, 1)];
        let whole = forked_sums();
        StrikeChannel { points, lines, ..whole }
    }

    fn forked_sums() -> StrikeChannel {
        use crate::lightning::strike::{StrikeSpec, grow_strike};
        let spec = StrikeSpec {
            kind: FlashKind::CloudToGround,
            polarity: Polarity::Negative,
            seed: 1,
            origin_m: 2_000.0,
            cloud_m: [1_500.0, 2_500.0],
            grounds_m: vec![[0.0, 0.0], [0.0, 1_500.0]],
        };
        grow_strike(&spec, &mut Default::default(), &std::sync::atomic::AtomicBool::new(false)).expect("a right strike")
    }

    #[test]
    fn each_stroke_is_heard_along_what_it_lit() {
        let channel = forked();
        let length =
            |paths: &[Path]| -> Vec<(usize, f64)> { paths.iter().map(|p| (p.points_m.len(), p.share)).collect() };
        assert_eq!(length(&paths(&channel, 0, false)), [(3, 1.0)]);
        assert_eq!(length(&paths(&channel, 1, false)), [(2, 1.0), (2, 1.0)]);
        assert_eq!(length(&paths(&channel, 0, true)), [(3, 1.0), (2, f64::from(0.3_f32))]);

        let spec = |delay_s, ground_point_m| StrokeSpec {
            delay_s,
            peak_current_ka: 30.0,
            ground_point_m,
            ..Default::default()
        };
        let strokes = [spec(0.0, None), spec(0.1, Some([0.0, 3_000.0]))];
        let flash = Flash::given(FlashKind::CloudToGround, Polarity::Negative, &strokes, false, 1);
        let air = Air { lapse_k_per_m: 0.0, ..Air::default() };
        let c = air.speed_mps(0.0);
        // 500 m beside the second ground point: its stroke is heard first, the first stroke's foot much later.
        let listener = [500.0, 3_000.0, 0.0];
        let found = heard(&channel, &flash, listener, &air);
        let first_of = |from: f64, to: f64| {
            let times = found.iter().map(|pulse| pulse.arrival_s).filter(|s| (from..to).contains(s));
            times.fold(f64::INFINITY, f64::min)
        };
        assert!((first_of(0.0, 1e3) - (0.1 + 500.0 / c)).abs() < 1e-6, "{}", first_of(0.0, 1e3));
        // The first stroke's channel is 3041 m away at its nearest, the foot.
        let foot_s = 500_f64.hypot(3_000.0) / c;
        let at_foot = found.iter().map(|pulse| (pulse.arrival_s - foot_s).abs()).fold(f64::INFINITY, f64::min);
        assert!(at_foot < 1e-6, "{at_foot}");
    }

    #[test]
    fn a_grown_flash_is_heard_for_as_long_as_its_height_takes() {
        let channel = forked_sums();
        let flash = Flash::sample(FlashKind::CloudToGround, Polarity::Negative, Some(30.0), false, 4);
        let found = heard(&channel, &flash, [1_000.0, 0.0, 2.0], &Air::default());
        let first_s = found.iter().map(|pulse| pulse.arrival_s).fold(f64::INFINITY, f64::min);
        // The channel bends up to a few hundred metres towards or from the listener.
        assert!((1.5..3.2).contains(&first_s), "{first_s}");
        assert!(found.len() > 100 && found.iter().all(|pulse| pulse.level_db.is_finite()));
    }
}
