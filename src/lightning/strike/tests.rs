//! Channels of strikes: where they begin and end, what lights what, how little a coarse picture needs, the same every time.

use super::*;

fn spec(kind: FlashKind, seed: u64) -> StrikeSpec {
    StrikeSpec {
        kind,
        polarity: Polarity::Negative,
        seed,
        origin_m: 4_000.0,
        cloud_m: [1_500.0, 8_000.0],
        grounds_m: Vec::new(),
    }
}

fn grown(spec: &StrikeSpec) -> StrikeChannel {
    grow_strike(spec, &mut Tables::default(), &AtomicBool::new(false)).expect("a right specification")
}

fn main_points(channel: &StrikeChannel) -> impl Iterator<Item = &ChannelPoint> {
    let lines = channel.lines.iter().filter(|line| line.order == 0);
    lines.flat_map(|line| &channel.points[line.first as usize..(line.first + line.count) as usize])
}

/// Light of a channel at a fineness: main, and side.
fn light_at(channel: &StrikeChannel, finest_m: f32) -> [f64; 2] {
    let mut sums = [0.0; 2];
    channel.visit(finest_m, |s| sums[usize::from(s.side)] += f64::from(s.light_m));
    sums
}

#[test]
fn a_channel_to_ground_leads_from_the_charge_to_its_ground_points() {
    for grounds_m in [vec![], vec![[0.0, 0.0], [1_700.0, -300.0]], vec![[0.0, 0.0], [0.0, 7_300.0], [-900.0, 200.0]]] {
        let channel = grown(&StrikeSpec { grounds_m: grounds_m.clone(), ..spec(FlashKind::CloudToGround, 5) });
        let wanted: &[[f64; 2]] = if grounds_m.is_empty() { &[[0.0; 2]] } else { &grounds_m };
        assert_eq!(channel.grounds, wanted.len());
        let start = channel.points[0].position_m;
        assert!((start[2] - 4_000.0).abs() < 1.0 && start[0].hypot(start[1]) <= 0.23 * 4_000.0, "{start:?}");
        for (ground, &[east, north]) in wanted.iter().enumerate() {
            // Of the points of its main channel the lowest lies on the ground, half a cell or so from where it was asked for.
            let mut own: Vec<&ChannelPoint> = main_points(&channel).filter(|p| p.grounds >> ground & 1 == 1).collect();
            own.sort_by(|a, b| a.position_m[2].total_cmp(&b.position_m[2]));
            let [x, y, z] = own[0].position_m.map(f64::from);
            assert!(z.abs() < 1e-3 && (x - east).hypot(y - north) < 150.0, "{ground}: {x} {y} {z}");
            assert!(channel.main_m[ground] > (4_000.0_f64).hypot(east.hypot(north)) * 0.9);
        }
        assert!(channel.side_m.iter().all(|m| *m > 0.0), "a first stroke has branches");
    }
}

#[test]
fn channels_inside_clouds_stay_in_them() {
    for (kind, seed) in [(FlashKind::IntraCloud, 1), (FlashKind::IntraCloud, 2), (FlashKind::CloudToCloud, 3)] {
        let channel = grown(&spec(kind, seed));
        let up = |p: &ChannelPoint| p.position_m[2];
        let low = channel.points.iter().map(up).fold(f32::INFINITY, f32::min);
        let high = channel.points.iter().map(up).fold(0.0, f32::max);
        assert!(low > 1_500.0 && high < 8_000.0, "{kind:?}: {low} to {high}");
        assert_eq!(channel.grounds, 1);
        assert!(channel.main_m[0] > 1_500.0);
    }
}

#[test]
fn equal_strikes_are_equal_and_seeds_differ() {
    let one = grown(&spec(FlashKind::CloudToGround, 9));
    let mut tables = Tables::default();
    let used = AtomicBool::new(false);
    for seed in [8, 9] {
        let again = grow_strike(&spec(FlashKind::CloudToGround, seed), &mut tables, &used).expect("grown");
        assert_eq!(again == one, seed == 9, "tables that were used before change nothing");
    }
    used.store(true, std::sync::atomic::Ordering::Relaxed);
    assert!(matches!(
        grow_strike(&spec(FlashKind::CloudToGround, 9), &mut tables, &used),
        Err(GrowError::Cancelled { .. })
    ));
}

#[test]
fn light_is_the_same_at_every_level_of_detail_and_far_away_few_stretches_are_left() {
    let channel = grown(&spec(FlashKind::CloudToGround, 3));
    let [main, side] = light_at(&channel, 0.0);
    assert!((main - channel.main_m[0]).abs() < 1e-3 * main && (side - channel.side_m[0]).abs() < 1e-3 * side);
    let mut before = usize::MAX;
    for finest_m in [0.0, 0.25, 1.0, 4.0, 30.0, 500.0] {
        // Light of a stretch is the difference of two sums in f32: 1e-7 of some kilometres each.
        let [here, beside] = light_at(&channel, finest_m);
        assert!((here - main).abs() < 1e-4 * main && (beside - side).abs() < 1e-4 * side, "{finest_m}");
        let mut count = 0;
        channel.visit(finest_m, |_| count += 1);
        assert_eq!(count, channel.stretches(finest_m));
        assert!(count < before);
        before = count;
    }
    // A pixel of 60 degrees in 640 is 98 m at 60 km: a quarter of it.
    assert!(channel.stretches(25.0) < channel.points.len() / 10, "{}", channel.stretches(25.0));
}

fn light(channel: u32, branches: bool, amount: f64) -> Light {
    Light { channel, branches, span: [0.0, 1.0], amount }
}

#[test]
fn each_stroke_gives_its_light_to_what_it_lights() {
    let two = StrikeSpec { grounds_m: vec![[0.0, 0.0], [1_500.0, 900.0]], ..spec(FlashKind::CloudToGround, 4) };
    let channel = grown(&two);
    // Light of main channels that lead to the first alone, to the second alone, to both, and of side channels.
    let shares = |lights: &[Light], finest_m: f32| {
        let lit = channel.lit(lights);
        let mut sums = [0.0; 4];
        channel.visit(finest_m, |s| {
            let part = if s.side { 3 } else { usize::from(s.grounds) - 1 };
            sums[part] += lit.of(&channel, &s);
        });
        sums
    };
    // Sums of f32 differences, as above.
    let near = |a: f64, b: f64| (a - b).abs() < 1e-3 * b.abs().max(1.0);
    for finest_m in [0.0, 1.0, 40.0] {
        let [first, second, both, side] = shares(&[light(0, true, 600.0)], finest_m);
        assert!(near(first + both + side, 600.0) && second == 0.0 && side > 10.0, "{first} {second} {both} {side}");
        let [first, second, both, side] = shares(&[light(1, false, 70.0)], finest_m);
        assert!(near(second + both, 70.0) && first == 0.0 && side == 0.0 && second > 10.0);
        let all = shares(&[light(0, true, 600.0), light(1, false, 70.0), light(7, false, 9.0)], finest_m);
        assert!(near(all.iter().sum(), 679.0), "a ground point that is not there is the last one: {all:?}");
    }
    assert!(channel.lit(&[light(0, true, 0.0)]).is_dark());
}

#[test]
fn a_leader_lights_the_channel_as_far_as_its_tip() {
    let channel = grown(&spec(FlashKind::CloudToGround, 4));
    let leader = Light { span: [0.2, 0.5], ..light(0, true, 100.0) };
    let lit = channel.lit(&[leader]);
    let (mut inside, mut outside) = (0.0, 0.0);
    channel.visit(1.0, |s| {
        let along = f64::from(channel.points[s.to as usize].along_m) / channel.reach_m[0];
        // A stretch at the fineness of 1 m is some tens of metres long.
        let within = (0.2 - 1e-9..0.5 + 0.05).contains(&along);
        *(if within { &mut inside } else { &mut outside }) += lit.of(&channel, &s);
    });
    // Stretches at the ends of the span are cut by length, not by light, and are finer here than where it was measured.
    assert!((inside - 100.0).abs() < 1.0 && outside < 1e-9, "{inside} {outside}");
    assert!(channel.lit(&[Light { span: [0.3, 0.3], ..leader }]).is_dark(), "no length, no light");
}

#[test]
fn sources_have_the_channels_light_centre_and_spread() {
    let channel = grown(&spec(FlashKind::CloudToGround, 6));
    let lit = channel.lit(&[light(0, true, 1_000.0), light(0, false, 300.0)]);
    let moments = |sources: &[Source]| {
        let weight: f64 = sources.iter().map(|s| s.weight).sum();
        let up = |s: &Source| f64::from(s.position_m[2]);
        let mean = sources.iter().map(|s| s.weight * up(s)).sum::<f64>() / weight;
        let square = |s: &Source| (up(s) - mean).powi(2) + f64::from(s.half_m[2]).powi(2) / 3.0;
        (weight, mean, sources.iter().map(|s| s.weight * square(s)).sum::<f64>() / weight)
    };
    let fine = moments(&channel.sources(400, &lit));
    for count in [1, 2, 7, 16, 64] {
        let sources = channel.sources(count, &lit);
        assert_eq!(sources.len(), count);
        let (weight, mean, square) = moments(&sources);
        assert!((weight - 1_300.0).abs() < 1.5, "{weight}");
        assert!((mean - fine.1).abs() < 1.0, "{mean} {}", fine.1);
        // Each part keeps the spread along its own widest axis alone; of one part that is most of the upward one.
        assert!(square > 0.8 * fine.2 && square < 1.01 * fine.2, "{count}: {square} {}", fine.2);
    }
    assert!(channel.sources(5, &Lit::default()).is_empty());
    let later = channel.lit(&[light(0, false, 1.0)]);
    assert!(channel.sources(3, &later).iter().all(|s| s.weight > 0.0));
}

#[test]
fn extreme_strikes_grow_in_bounds() {
    let wild = |change: fn(&mut StrikeSpec)| {
        let mut wild = spec(FlashKind::CloudToGround, 2);
        change(&mut wild);
        grown(&wild)
    };
    for channel in [
        wild(|s| s.origin_m = 50_000.0),
        wild(|s| s.origin_m = -3_000.0),
        wild(|s| s.origin_m = f64::NAN),
        wild(|s| s.grounds_m = vec![[60_000.0, 0.0]; 40]),
        wild(|s| s.polarity = Polarity::Positive),
        wild(|s| s.grounds_m = vec![[0.0, 0.0], [1.0, 1.0], [900.0, 0.0]]),
        wild(|s| (s.kind, s.cloud_m) = (FlashKind::IntraCloud, [3_000.0, 3_000.0])),
        wild(|s| (s.kind, s.cloud_m) = (FlashKind::CloudToCloud, [3_000.0, 3_001.0])),
    ] {
        let finite = |p: &ChannelPoint| p.position_m.iter().all(|x| x.is_finite()) && p.light_m.is_finite();
        assert!(channel.points.iter().all(finite));
        assert!(channel.points.len() < 200_000, "{}", channel.points.len());
        assert!(channel.lines.iter().all(|line| line.count >= 2));
    }
}
