//! Flashes in the world: when they begin and end, whose light frames gather, what is refused.

use super::*;

#[test]
fn a_flash_begins_with_the_next_picture_and_ends() {
    let mut world = World::new();
    let Ok(Applied::Flash { id }) = world.apply(Command::Strike(strike())) else { panic!("refused") };
    world.advance_to(7.0);
    assert_eq!(world.peek(0.01).flashes[0].begin_s, 7.0, "a look shows it and does not begin it");
    world.advance_to(8.0);
    let shown = world.snapshot(0.01).flashes.remove(0);
    assert_eq!((shown.id, shown.begin_s), (id, 8.0));
    assert!(shown.intensity_cd > 1e6, "{}", shown.intensity_cd);
    assert!(world.finished_flashes().is_empty());
    world.advance_to(shown.end_s);
    assert!(world.snapshot(0.01).flashes.is_empty());
    assert_eq!((world.finished_flashes(), world.finished_flashes()), (vec![id], vec![]));
}

#[test]
fn frames_gather_all_the_light_of_a_flash() {
    for rate_hz in [24.0, 60.0, 120.0] {
        let mut world = World::new();
        world.apply(Command::Strike(StrikeRequest { at_s: Some(0.5), ..strike() })).unwrap();
        let mut sum = 0.0;
        for k in 0..(2.0 * rate_hz) as u32 {
            world.advance_to(f64::from(k) / rate_hz);
            sum += world.snapshot(1.0 / rate_hz).flashes.iter().map(|f| f.intensity_cd / rate_hz).sum::<f64>();
        }
        let Strokes::Given(strokes) = strike().strokes else { unreachable!() };
        let flash =
            crate::lightning::flash::Flash::given(strike().kind, strike().polarity, &strokes, false, strike().seed);
        let all = flash.energy_lm_s() / (4.0 * std::f64::consts::PI);
        // The ends of abutting frames, k / rate + 1 / rate and (k + 1) / rate, agree to 1e-16 s, a millionth of a
        // millionth of the decay time.
        assert!((sum / all - 1.0).abs() < 1e-6, "{rate_hz} Hz: {sum} of {all}");
    }
}

#[test]
fn frames_gather_all_the_light_of_a_flash_of_a_scenario() {
    // Struck in the middle of a frame: its entry is not due when the shutter opens.
    let entries = vec![TimedCommand { at_s: 1.003, command: Command::Strike(strike()) }];
    let mut world = loaded(Timeline { duration_s: 9.0, entries, ..Default::default() });
    let mut sum = 0.0;
    for k in 0..120 {
        world.advance_to(f64::from(k) / 60.0);
        let flashes = world.snapshot(1.0 / 60.0).flashes;
        assert!(flashes.len() <= 1 && flashes.iter().all(|flash| flash.begin_s == 1.003));
        sum += flashes.iter().map(|f| f.intensity_cd / 60.0).sum::<f64>();
    }
    let Strokes::Given(strokes) = strike().strokes else { unreachable!() };
    let flash = crate::lightning::flash::Flash::given(strike().kind, strike().polarity, &strokes, false, strike().seed);
    let all = flash.energy_lm_s() / (4.0 * std::f64::consts::PI);
    // As above.
    assert!((sum / all - 1.0).abs() < 1e-6, "{sum} of {all}");
}

#[test]
fn a_flash_without_a_height_is_in_the_lowest_cloud_of_its_place() {
    let mut world = World::new();
    let height = |world: &mut World, latitude_deg| {
        let request = StrikeRequest { altitude_m: None, latitude_deg, longitude_deg: 20.0, ..strike() };
        world.apply(Command::Strike(request)).unwrap();
        world.peek(0.1).flashes.last().unwrap().position.altitude_m
    };
    assert_eq!(height(&mut world, 10.0), 2_000.0);
    let empty = LayerSpec { coverage: 0.0, ..layer(100.0) };
    world.apply(layers(vec![empty, layer(3000.0)], 60.0)).unwrap();
    assert_eq!(height(&mut world, 10.0), 3_400.0);
    let local = WeatherEdit { region: Some(region()), layers: Some(vec![layer(5000.0)]), ..Default::default() };
    world.apply(Command::Weather(local)).unwrap();
    assert_eq!(height(&mut world, 10.0), 5_400.0);
    assert_eq!(height(&mut world, 12.0), 3_400.0);
}

#[test]
fn strikes_out_of_bounds_are_refused() {
    let mut world = World::new();
    world.advance_to(10.0);
    let stroke = |delay_s, peak_current_ka| StrokeSpec { delay_s, peak_current_ka, ..Default::default() };
    let given = |list: Vec<StrokeSpec>| StrikeRequest { strokes: Strokes::Given(list), ..strike() };
    for (bad, field) in [
        (StrikeRequest { latitude_deg: f64::NAN, ..strike() }, "latitude_deg"),
        (StrikeRequest { longitude_deg: 181.0, ..strike() }, "longitude_deg"),
        (StrikeRequest { altitude_m: Some(1e6), ..strike() }, "altitude_m"),
        (StrikeRequest { altitude_m: Some(-0.1), ..strike() }, "altitude_m"),
        (StrikeRequest { peak_current_ka: Some(0.0), ..strike() }, "peak_current_ka"),
        (given(vec![stroke(0.0, 0.0)]), "strokes[0].peak_current_ka"),
        (given(vec![StrokeSpec { continuing_s: Some(9.0), ..stroke(0.0, 9.0) }]), "strokes[0].continuing_s"),
        (
            given(vec![StrokeSpec { ground_point_m: Some([0.0, 1e6]), ..stroke(0.0, 9.0) }]),
            "strokes[0].ground_point_m[1]",
        ),
        (
            StrikeRequest {
                kind: FlashKind::IntraCloud,
                ..given(vec![StrokeSpec { ground_point_m: Some([0.0, 1.0]), ..stroke(0.0, 9.0) }])
            },
            "strokes[0].ground_point_m",
        ),
        (StrikeRequest { at_s: Some(9.9), ..strike() }, "at_s"),
        (StrikeRequest { at_s: Some(f64::INFINITY), ..strike() }, "at_s"),
        (StrikeRequest { peak_current_ka: Some(-3.0), ..strike() }, "peak_current_ka"),
        (given(vec![]), "strokes"),
        (given(vec![stroke(0.0, 10.0); 33]), "strokes"),
        (given(vec![stroke(0.2, 10.0), stroke(0.1, 10.0)]), "strokes[1].delay_s"),
        (given(vec![stroke(0.0, f64::NAN)]), "strokes[0].peak_current_ka"),
        (given(vec![stroke(99.0, 10.0)]), "strokes[0].delay_s"),
    ] {
        assert_eq!(world.apply(Command::Strike(bad)).unwrap_err().field, field);
    }
    assert!(world.peek(0.1).flashes.is_empty());
    for _ in 0..limits::MAX_PENDING_STRIKES {
        world.apply(Command::Strike(strike())).unwrap();
    }
    assert_eq!(world.apply(Command::Strike(strike())).unwrap_err().field, "strike");
    world.snapshot_at_once(0.1);
    world.advance_to(20.0);
    world.apply(Command::Strike(strike())).unwrap();
    assert_eq!(world.finished_flashes().len(), limits::MAX_PENDING_STRIKES);
}

#[test]
fn a_new_world_says_that_the_flashes_of_the_old_are_over_and_gives_no_number_twice() {
    let mut world = World::new();
    world.apply(Command::Strike(strike())).unwrap();
    world.apply(Command::Scenario(ScenarioEdit::Load(Arc::new(demo())))).unwrap();
    assert_eq!(world.finished_flashes(), [1]);
    let Ok(Applied::Flash { id }) = world.apply(Command::Strike(strike())) else { panic!("refused") };
    world.advance_to(1.5);
    let ids: Vec<u64> = world.peek(0.1).flashes.iter().map(|flash| flash.id).collect();
    assert_eq!(ids.len(), 2);
    assert!(ids[1] == id && ids[0] > 1 && ids[0] < id, "{ids:?}");
}

#[test]
fn strikes_at_the_extremes_give_light_where_they_are() {
    for (latitude_deg, altitude_m, peak_current_ka) in [
        (90.0, 4_000.0, 30.0),
        (-90.0, 4_000.0, 30.0),
        (47.0, 50_000.0, 30.0),
        (47.0, 0.0, 30.0),
        (47.0, 5_000.0, 500.0),
    ] {
        let mut world = World::new();
        let (altitude_m, peak_current_ka) = (Some(altitude_m), Some(peak_current_ka));
        let request = StrikeRequest { latitude_deg, altitude_m, peak_current_ka, strokes: Strokes::Sample, ..strike() };
        world.apply(Command::Strike(request)).unwrap();
        let flashes = world.snapshot(0.02).flashes;
        let found = &flashes[0];
        assert!(found.intensity_cd.is_finite() && found.intensity_cd > 1e6, "{found:?}");
        assert!((found.position.latitude_rad.to_degrees() - latitude_deg).abs() < 1e-12);
        assert_eq!((found.position.altitude_m, found.peak_current_ka), (altitude_m.unwrap(), peak_current_ka.unwrap()));
    }
}

#[test]
fn a_thousand_strikes_in_one_second_are_all_taken_shine_and_end() {
    let mut world = World::new();
    for k in 0..1_000 {
        let at_s = Some(1.0 + 0.001 * f64::from(k));
        world.apply(Command::Strike(StrikeRequest { at_s, seed: k as u64, ..strike() })).unwrap();
    }
    let mut lit = std::collections::BTreeSet::new();
    for frame in 0..180 {
        world.advance_to(f64::from(frame) / 60.0);
        let flashes = world.snapshot(1.0 / 60.0).flashes;
        let shown = flashes.iter().filter(|flash| !flash.lights.is_empty());
        assert!(shown.clone().all(|flash| flash.channel.is_some()), "a picture waits for its channels");
        lit.extend(flashes.iter().filter(|flash| flash.intensity_cd > 0.0).map(|flash| flash.id));
    }
    assert_eq!(lit.len(), 1_000);
    world.advance_to(9.0);
    assert_eq!(world.finished_flashes().len(), 1_000);
}

#[test]
fn the_guard_lets_so_many_strokes_through_and_no_more() {
    let begun = |limit: Option<u32>| {
        let mut world = World::new();
        world.set_flicker_guard(limit.map(FlickerGuard::new));
        for k in 0..200 {
            let at_s = Some(0.05 * f64::from(k));
            world.apply(Command::Strike(StrikeRequest { at_s, seed: k as u64, ..strike() })).unwrap();
        }
        // Frames in which some flash's light rises: more than it had a frame before.
        let (mut rises, mut before) = (Vec::new(), 0.0);
        for frame in 0..900 {
            world.advance_to(f64::from(frame) / 60.0);
            let light: f64 = world.peek(1.0 / 60.0).flashes.iter().map(|flash| flash.intensity_cd).sum();
            // Of two frames that share a stroke the second may be the brighter one.
            if light > before && rises.last() != Some(&(frame - 1)) {
                rises.push(frame);
            }
            before = light;
            world.finished_flashes();
        }
        rises
    };
    let guarded = begun(Some(3));
    assert!(guarded.windows(4).all(|window| window[3] - window[0] >= 59), "{guarded:?}");
    // Half a second for each of ten: all slots have a stroke.
    assert!(guarded.len() >= 18, "{}", guarded.len());
    assert!(begun(None).len() > 3 * guarded.len(), "without a guard there are many more");
}
