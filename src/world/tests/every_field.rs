//! Every field of every command counts: changing it alone changes the snapshot.

use super::*;

/// The pictures at a few moments after a world got these commands at time 0.
fn pictures(commands: &[Command]) -> Vec<Snapshot> {
    let mut world = World::new();
    for command in commands {
        world.apply(command.clone()).unwrap();
    }
    world.snapshot(0.01);
    [0.0, 0.051, 1.0, 7.0]
        .map(|t| {
            world.advance_to(t);
            picture(&world)
        })
        .to_vec()
}

fn all_differ(base: &Command, variants: Vec<(&str, Command)>, before: &[Command]) {
    let play = |command: &Command| pictures(&[before, std::slice::from_ref(command)].concat());
    let plain = play(base);
    for (field, variant) in variants {
        assert_ne!(play(&variant), plain, "{field} changes nothing");
    }
}

#[test]
fn ownship_fields() {
    let base = ownship();
    let with = |change: &dyn Fn(&mut Ownship)| {
        let mut changed = base;
        change(&mut changed);
        Command::Ownship(changed)
    };
    all_differ(
        &Command::Ownship(base),
        vec![
            ("latitude_deg", with(&|o| o.latitude_deg += 1e-6)),
            ("longitude_deg", with(&|o| o.longitude_deg += 1e-6)),
            ("altitude_m", with(&|o| o.altitude_m += 0.01)),
            ("yaw_deg", with(&|o| o.yaw_deg += 0.01)),
            ("pitch_deg", with(&|o| o.pitch_deg += 0.01)),
            ("roll_deg", with(&|o| o.roll_deg += 0.01)),
            ("velocity north", with(&|o| o.velocity_ned_mps = Some([101.0, 50.0, -3.0]))),
            ("velocity east", with(&|o| o.velocity_ned_mps = Some([100.0, 51.0, -3.0]))),
            ("velocity down", with(&|o| o.velocity_ned_mps = Some([100.0, 50.0, -4.0]))),
            ("velocity none", with(&|o| o.velocity_ned_mps = None)),
            ("host_frame", with(&|o| o.host_frame += 1)),
        ],
        &[],
    );
}

fn weather_variants(region: Option<RegionShape>) -> (Command, Vec<(&'static str, Command)>) {
    let base = WeatherEdit {
        region,
        layers: Some(vec![layer(1000.0), layer(4000.0)]),
        changes: vec![LayerChange { index: 0, ..Default::default() }],
        visibility_m: Some(9_000.0),
        transition_s: 5.0,
    };
    let with = |change: &dyn Fn(&mut WeatherEdit)| {
        let mut changed = base.clone();
        change(&mut changed);
        Command::Weather(changed)
    };
    let first = |change: &dyn Fn(&mut LayerSpec)| with(&|w| change(&mut w.layers.as_mut().unwrap()[0]));
    let single = |change: LayerChange| with(&|w| w.changes = vec![change]);
    let none = LayerChange { index: 0, ..Default::default() };
    let density = LayerChange { density: Some(2.0), ..none };
    let variants = vec![
        ("layers", with(&|w| w.layers = Some(vec![layer(1000.0)]))),
        ("layers.kind", first(&|l| l.kind = CloudKind::Stratus)),
        ("layers.base_m", first(&|l| l.base_m += 1.0)),
        ("layers.thickness_m", first(&|l| l.thickness_m += 1.0)),
        ("layers.coverage", first(&|l| l.coverage += 0.01)),
        ("layers.density", first(&|l| l.density += 0.01)),
        ("layers.wind_speed_mps", first(&|l| l.wind_speed_mps += 0.1)),
        ("layers.wind_from_deg", first(&|l| l.wind_from_deg += 1.0)),
        ("changes.index", single(LayerChange { index: 1, ..density })),
        ("changes.kind", single(LayerChange { kind: Some(CloudKind::Stratus), ..none })),
        ("changes.base_m", single(LayerChange { base_m: Some(1100.0), ..none })),
        ("changes.thickness_m", single(LayerChange { thickness_m: Some(700.0), ..none })),
        ("changes.coverage", single(LayerChange { coverage: Some(0.7), ..none })),
        ("changes.density", single(density)),
        ("changes.wind_speed_mps", single(LayerChange { wind_speed_mps: Some(11.0), ..none })),
        ("changes.wind_from_deg", single(LayerChange { wind_from_deg: Some(280.0), ..none })),
        ("visibility_m", with(&|w| w.visibility_m = Some(9_100.0))),
        ("transition_s", with(&|w| w.transition_s = 6.0)),
    ];
    // An index only tells when something is changed there.
    let (base, indexed): (Command, Command) = (Command::Weather(base.clone()), single(density));
    assert_ne!(pictures(&[indexed]), pictures(&[variants[8].1.clone()]));
    (base, variants)
}

#[test]
fn weather_fields() {
    let (base, mut variants) = weather_variants(None);
    let Command::Weather(global) = &base else { unreachable!() };
    variants.push(("region", Command::Weather(WeatherEdit { region: Some(region()), ..global.clone() })));
    all_differ(&base, variants, &[]);
}

#[test]
fn region_fields() {
    let (base, mut variants) = weather_variants(Some(region()));
    let Command::Weather(local) = &base else { unreachable!() };
    let mut shape = |name, change: &dyn Fn(&mut RegionShape)| {
        let mut changed = region();
        change(&mut changed);
        variants.push((name, Command::Weather(WeatherEdit { region: Some(changed), ..local.clone() })));
    };
    shape("name", &|r| r.name = "other".into());
    shape("latitude_deg", &|r| r.latitude_deg += 1e-6);
    shape("longitude_deg", &|r| r.longitude_deg += 1e-6);
    shape("size_east_m", &|r| r.size_east_m += 1.0);
    shape("size_north_m", &|r| r.size_north_m += 1.0);
    shape("corner_radius_m", &|r| r.corner_radius_m += 1.0);
    shape("rotation_deg", &|r| r.rotation_deg += 0.1);
    shape("transition_m", &|r| r.transition_m += 1.0);
    all_differ(&base, variants, &[]);

    let made = [Command::Weather(WeatherEdit { transition_s: 0.0, ..local.clone() })];
    let remove = |transition_s| Command::RemoveRegion { name: "storm".into(), transition_s };
    let keep = Command::Time(TimeEdit::default());
    all_differ(&remove(9.0), vec![("transition_s", remove(8.0)), ("not removed", keep)], &made);
}

#[test]
fn time_fields() {
    let edit = |utc_s, rate| Command::Time(TimeEdit { utc_s, rate });
    let variants = vec![
        ("utc_s", edit(Some(1_700_000_001.0), Some(2.0))),
        ("utc_s none", edit(None, Some(2.0))),
        ("rate", edit(Some(1_700_000_000.0), Some(3.0))),
        ("rate none", edit(Some(1_700_000_000.0), None)),
    ];
    all_differ(&edit(Some(1_700_000_000.0), Some(2.0)), variants, &[]);
    let [early, late] =
        [1_700_000_000.0, 1_700_010_000.0].map(|utc_s| pictures(&[edit(Some(utc_s), None)]).remove(0).sky);
    assert_ne!(early.sun_direction_ecef, late.sun_direction_ecef);
    assert_ne!(early.moon_direction_ecef, late.moon_direction_ecef);
    assert_ne!(early.moon_lit_fraction, late.moon_lit_fraction);
}

#[test]
fn view_fields() {
    let view = ViewEdit { name: "v".into(), ..Default::default() };
    let with = |change: &dyn Fn(&mut ViewEdit)| {
        let mut changed = view.clone();
        change(&mut changed);
        Command::View(changed)
    };
    let variants = vec![
        ("name", with(&|v| v.name = "w".into())),
        ("width", with(&|v| v.size_px = Some([641, 360]))),
        ("height", with(&|v| v.size_px = Some([640, 361]))),
        ("field_of_view_deg", with(&|v| v.field_of_view_deg = Some(61.0))),
        ("forward", with(&|v| v.offset_m = Some([1.0, 0.0, 0.0]))),
        ("right", with(&|v| v.offset_m = Some([0.0, 1.0, 0.0]))),
        ("down", with(&|v| v.offset_m = Some([0.0, 0.0, 1.0]))),
        ("yaw_deg", with(&|v| v.yaw_deg = Some(1.0))),
        ("pitch_deg", with(&|v| v.pitch_deg = Some(1.0))),
        ("roll_deg", with(&|v| v.roll_deg = Some(1.0))),
        ("landing_light", with(&|v| v.landing_light = Some(true))),
        ("strobe", with(&|v| v.strobe = Some(true))),
        ("exposure", with(&|v| v.exposure = Some(Exposure::Ev100(12.0)))),
        ("removed", Command::RemoveView { name: "main".into() }),
    ];
    all_differ(&with(&|_| ()), variants, &[]);
    let wide = |action| {
        Command::View(ViewEdit { action, name: "main".into(), field_of_view_deg: Some(80.0), ..Default::default() })
    };
    let mut world = World::new();
    assert!(world.apply(wide(ViewAction::Create)).is_err() && world.apply(wide(ViewAction::Change)).is_ok(), "action");
    let set = with(&|v| (v.yaw_deg, v.exposure) = (Some(30.0), Some(Exposure::Ev100(12.0))));
    let change = with(&|v| v.action = ViewAction::Change);
    let kept = pictures(&[set, change]).remove(0).views.remove(1);
    assert_eq!(
        (kept.attitude.yaw_rad, kept.exposure),
        (30.0_f64.to_radians(), Exposure::Ev100(12.0)),
        "what is not given stays"
    );
}

#[test]
fn strike_fields() {
    let base = StrikeRequest { at_s: Some(0.0), ..strike() };
    let with = |change: &dyn Fn(&mut StrikeRequest)| {
        let mut changed = base.clone();
        change(&mut changed);
        Command::Strike(changed)
    };
    let strokes = |a: (f64, f64), b: (f64, f64)| {
        let one = |(delay_s, peak_current_ka)| StrokeSpec { delay_s, peak_current_ka, ..Default::default() };
        Strokes::Given(vec![one(a), one(b)])
    };
    fn first(request: &mut StrikeRequest) -> &mut StrokeSpec {
        let Strokes::Given(strokes) = &mut request.strokes else { panic!("strokes are given") };
        &mut strokes[0]
    }
    let variants = vec![
        ("latitude_deg", with(&|s| s.latitude_deg += 1e-6)),
        ("longitude_deg", with(&|s| s.longitude_deg += 1e-6)),
        ("altitude_m", with(&|s| s.altitude_m = None)),
        ("at_s", with(&|s| s.at_s = Some(0.001))),
        ("kind", with(&|s| s.kind = FlashKind::CloudToCloud)),
        ("polarity", with(&|s| s.polarity = Polarity::Positive)),
        ("peak_current_ka", with(&|s| s.peak_current_ka = Some(26.0))),
        ("strokes", with(&|s| s.strokes = Strokes::Sample)),
        ("delay_s", with(&|s| s.strokes = strokes((0.0, 25.0), (0.051, 10.0)))),
        ("stroke current", with(&|s| s.strokes = strokes((0.0, 25.0), (0.05, 11.0)))),
        ("leader", with(&|s| s.leader = true)),
        ("continuing_s", with(&|s| first(s).continuing_s = Some(0.2))),
        ("ground_point_m", with(&|s| first(s).ground_point_m = Some([300.0, 0.0]))),
    ];
    all_differ(&with(&|_| ()), variants, &[]);
    let sample = |seed, peak_current_ka| {
        with(&|s| {
            *s = StrikeRequest { strokes: Strokes::Sample, seed, peak_current_ka, ..s.clone() };
        })
    };
    all_differ(&sample(1, None), vec![("seed", sample(2, None)), ("sampled current", sample(1, Some(77.0)))], &[]);
}

#[test]
fn storm_fields() {
    let base = StormRequest {
        name: "a".into(),
        latitude_deg: 47.0,
        longitude_deg: 8.0,
        size_east_m: 9_000.0,
        size_north_m: 8_000.0,
        corner_radius_m: 0.0,
        rotation_deg: 0.0,
        altitude_m: Some(4_000.0),
        flashes_per_minute: 600.0,
        inside_share: 0.3,
        positive_share: 0.0,
        current_factor: 1.0,
        seed: 1,
    };
    let with = |change: &dyn Fn(&mut StormRequest)| {
        let mut changed = base.clone();
        change(&mut changed);
        Command::Storm(changed)
    };
    let variants = vec![
        ("name", with(&|s| s.name = "b".into())),
        ("latitude_deg", with(&|s| s.latitude_deg += 1e-6)),
        ("longitude_deg", with(&|s| s.longitude_deg += 1e-6)),
        ("size_east_m", with(&|s| s.size_east_m += 1.0)),
        ("size_north_m", with(&|s| s.size_north_m += 1.0)),
        ("corner_radius_m", with(&|s| s.corner_radius_m = 1.0)),
        ("rotation_deg", with(&|s| s.rotation_deg = 1.0)),
        ("altitude_m", with(&|s| s.altitude_m = None)),
        ("flashes_per_minute", with(&|s| s.flashes_per_minute = 60.0)),
        ("inside_share", with(&|s| s.inside_share = 1.0)),
        ("positive_share", with(&|s| s.positive_share = 1.0)),
        ("current_factor", with(&|s| s.current_factor = 1.1)),
        ("seed", with(&|s| s.seed = 2)),
    ];
    all_differ(&with(&|_| ()), variants, &[]);
    let other = Command::Storm(StormRequest { name: "b".into(), ..base.clone() });
    let remove = |name: &str| Command::RemoveStorm { name: name.into() };
    all_differ(&remove("a"), vec![("name", remove("b"))], &[with(&|_| ()), other]);
}

#[test]
fn scenario_fields() {
    let load = |timeline: Timeline| Command::Scenario(ScenarioEdit::Load(Arc::new(timeline)));
    let mut later = demo();
    later.entries[4].at_s += 0.1;
    let mut other = demo();
    other.entries[5].command = layers(vec![layer(1700.0)], 20.0);
    let short = Timeline { duration_s: 3.0, entries: demo().entries[..5].to_vec(), ..demo() };
    let variants = vec![("at_s", load(later)), ("command", load(other)), ("duration_s", load(short))];
    all_differ(&load(demo()), variants, &[]);
    let seek = |at_s| Command::Scenario(ScenarioEdit::Seek { at_s });
    all_differ(&seek(8.0), vec![("seek", seek(9.0))], &[load(demo())]);
    // Name and description are for people, and play, pause and speed for whoever lets the time run.
    let mut world = loaded(Timeline { name: "n".into(), description: "d".into(), ..demo() });
    assert_eq!(world.timeline().map(|t| (t.name.as_str(), t.description.as_str())), Some(("n", "d")));
    assert!(world.playing());
    world.apply(Command::Scenario(ScenarioEdit::Pause)).unwrap();
    assert!(!world.playing());
}
