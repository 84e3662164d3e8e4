//! Regions: made, moved and removed without a jump, and measured truly on the globe.

use super::*;
use crate::clouds::CloudKind;
use crate::world::command::{LayerChange, LayerSpec};

fn shape(name: &str) -> RegionShape {
    RegionShape {
        name: name.into(),
        latitude_deg: 47.0,
        longitude_deg: 179.9,
        size_east_m: 40_000.0,
        size_north_m: 20_000.0,
        corner_radius_m: 5_000.0,
        rotation_deg: 0.0,
        transition_m: 4_000.0,
    }
}

fn layer(coverage: f64) -> LayerSpec {
    LayerSpec {
        kind: CloudKind::Cumulus,
        base_m: 1000.0,
        thickness_m: 500.0,
        coverage,
        density: 1.0,
        wind_speed_mps: 10.0,
        wind_from_deg: 90.0,
    }
}

fn eases(transition_s: f64) -> WeatherEdit {
    WeatherEdit { transition_s, ..Default::default() }
}

/// The point that lies east and north of a shape's centre, on the ellipsoid.
fn beside(shape: &RegionShape, east_m: f64, north_m: f64) -> Geodetic {
    let radius_m = Curvature::at(shape.latitude_deg.to_radians()).mean_m();
    let flat = DVec2::new(east_m, north_m);
    let angle = flat.length() / radius_m;
    let level = flat.normalize_or_zero() * angle.sin();
    let normal = enu(&centre(shape)) * DVec3::new(level.x, level.y, angle.cos());
    Geodetic {
        latitude_rad: normal.z.atan2(normal.x.hypot(normal.y)),
        longitude_rad: normal.y.atan2(normal.x),
        altitude_m: 0.0,
    }
}

#[test]
fn distances_from_the_outline_are_true() {
    let shape = shape("a");
    let diagonal = 5_000.0 * 0.5_f64.sqrt();
    for (east_m, north_m, expected_m) in [
        (0.0, 0.0, -10_000.0),
        (20_000.0, 0.0, 0.0),
        (-23_000.0, 1_000.0, 3_000.0),
        (0.0, 12_000.0, 2_000.0),
        // On the arc of a corner: its centre is at (15 km, 5 km).
        (15_000.0 + diagonal, 5_000.0 + diagonal, 0.0),
    ] {
        let distance = signed_distance_m(&shape, &beside(&shape, east_m, north_m));
        // The same map there and back: rounding of angles only.
        assert!((distance - expected_m).abs() < 1e-4, "{east_m} {north_m}: {distance}");
    }
    // Clockwise by 90 degrees: what was long east-west is long north-south.
    let turned = RegionShape { rotation_deg: 90.0, ..shape.clone() };
    assert!(signed_distance_m(&turned, &beside(&turned, 0.0, 19_000.0)) < 0.0);
    assert!(signed_distance_m(&turned, &beside(&turned, 19_000.0, 0.0)) > 0.0);
    // By 30 degrees: its long axis points east-south-east.
    let turned = RegionShape { rotation_deg: 30.0, ..shape };
    assert!(signed_distance_m(&turned, &beside(&turned, 16_000.0, -9_200.0)) < 0.0);
    assert!(signed_distance_m(&turned, &beside(&turned, 16_000.0, 9_200.0)) > 0.0);
}

#[test]
fn the_weight_goes_smoothly_from_one_to_nothing() {
    let shape = shape("a");
    let weight = |east_m: f64| weight_at(&shape, &beside(&shape, east_m, 0.0));
    assert_eq!((weight(0.0), weight(19_999.0), weight(24_001.0)), (1.0, 1.0, 0.0));
    assert!((weight(22_000.0) - 0.5).abs() < 1e-6);
    let hard = RegionShape { transition_m: 0.0, ..shape };
    assert_eq!(weight_at(&hard, &beside(&hard, 20_001.0, 0.0)), 0.0);
}

#[test]
fn a_region_begins_as_a_copy_of_its_surroundings_and_fades_in() {
    let mut around = Weather::clear();
    let here = centre(&shape("a"));
    around.edit(&WeatherEdit { layers: Some(vec![layer(0.3)]), ..Default::default() }, &here, 0.0).unwrap();
    let mut regions = Vec::new();
    let denser = LayerChange { index: 0, coverage: Some(0.9), ..Default::default() };
    let made = WeatherEdit { changes: vec![denser], transition_s: 10.0, ..Default::default() };
    edit(&mut regions, &shape("a"), &made, &around, 50.0).unwrap();
    let state = at(&regions, 55.0).remove(0);
    assert_eq!((state.presence, state.weather.layers[0].coverage), (0.5, 0.9));
    assert_eq!(state.weather.layers[0].drift, around.at(55.0).layers[0].drift, "the same pattern goes on inside");
    assert_eq!((at(&regions, 50.0)[0].presence, at(&regions, 60.0)[0].presence), (0.0, 1.0));

    // Taken away from the middle of its coming, and made again from the middle of its going: no jump.
    remove(&mut regions, "a", 10.0, 55.0).unwrap();
    assert_eq!(at(&regions, 55.0)[0].presence, 0.5);
    let going = at(&regions, 58.0)[0].presence;
    edit(&mut regions, &shape("a"), &eases(10.0), &around, 58.0).unwrap();
    assert_eq!(at(&regions, 58.0)[0].presence, going);
    assert_eq!(at(&regions, 68.0)[0].presence, 1.0);
    remove(&mut regions, "a", 10.0, 70.0).unwrap();
    assert!(at(&regions, 80.0).is_empty());
    assert!(remove(&mut regions, "a", 0.0, 80.0).is_err());
}

#[test]
fn a_moving_region_moves_evenly_across_the_180th_meridian() {
    let mut regions = Vec::new();
    let around = Weather::clear();
    edit(&mut regions, &shape("a"), &eases(0.0), &around, 0.0).unwrap();
    let moved = RegionShape {
        longitude_deg: -179.9,
        size_east_m: 60_000.0,
        size_north_m: 30_000.0,
        corner_radius_m: 8_000.0,
        rotation_deg: 350.0,
        transition_m: 9_000.0,
        ..shape("a")
    };
    edit(&mut regions, &moved, &eases(10.0), &around, 10.0).unwrap();
    assert_eq!(at(&regions, 10.0)[0].shape, shape("a"));
    let middle = at(&regions, 15.0).remove(0).shape;
    assert!((middle.longitude_deg.abs() - 180.0).abs() < 1e-9, "{}", middle.longitude_deg);
    assert_eq!(
        (middle.size_east_m, middle.size_north_m, middle.corner_radius_m, middle.transition_m),
        (50_000.0, 25_000.0, 6_500.0, 6_500.0)
    );
    assert!((middle.rotation_deg + 5.0).abs() < 1e-9, "the short way: {}", middle.rotation_deg);
    assert_eq!(at(&regions, 20.0)[0].shape, moved);
    let mut before = enu(&centre(&at(&regions, 9.0)[0].shape)).z_axis;
    for k in 1..1200 {
        let now = enu(&centre(&at(&regions, 9.0 + f64::from(k) * 0.01)[0].shape)).z_axis;
        // 15 km in 10 s at 1.5 times the mean speed: 23 m a step.
        assert!((now - before).length() * 6.4e6 < 25.0, "step {k}");
        before = now;
    }
}

#[test]
fn nonsense_is_refused_and_changes_nothing() {
    let around = Weather::clear();
    let mut regions = Vec::new();
    edit(&mut regions, &shape("a"), &eases(0.0), &around, 0.0).unwrap();
    let before = regions.clone();
    for (bad, field) in [
        (RegionShape { name: "no spaces".into(), ..shape("b") }, "region.name"),
        (RegionShape { latitude_deg: 91.0, ..shape("b") }, "region.latitude_deg"),
        (RegionShape { longitude_deg: f64::NAN, ..shape("b") }, "region.longitude_deg"),
        (RegionShape { size_east_m: 0.0, ..shape("b") }, "region.size_east_m"),
        (RegionShape { size_north_m: -1.0, ..shape("b") }, "region.size_north_m"),
        (RegionShape { corner_radius_m: 10_001.0, ..shape("b") }, "region.corner_radius_m"),
        (RegionShape { rotation_deg: f64::INFINITY, ..shape("b") }, "region.rotation_deg"),
        (RegionShape { transition_m: -1.0, ..shape("b") }, "region.transition_m"),
    ] {
        assert_eq!(edit(&mut regions, &bad, &eases(0.0), &around, 1.0).unwrap_err().field, field);
    }
    assert_eq!(remove(&mut regions, "a", f64::NAN, 1.0).unwrap_err().field, "transition_s");
    assert_eq!(remove(&mut regions, "zz", 0.0, 1.0).unwrap_err().limit, "one of: a");
    assert_eq!(regions, before);
    for k in 1..limits::MAX_REGIONS {
        edit(&mut regions, &shape(&format!("r{k}")), &eases(0.0), &around, 1.0).unwrap();
    }
    assert_eq!(edit(&mut regions, &shape("more"), &eases(0.0), &around, 1.0).unwrap_err().field, "region");
    // Room again as soon as one has gone, not before.
    remove(&mut regions, "r3", 5.0, 1.0).unwrap();
    assert!(edit(&mut regions, &shape("more"), &eases(0.0), &around, 2.0).is_err());
    edit(&mut regions, &shape("more"), &eases(0.0), &around, 6.0).unwrap();
}

#[test]
fn a_storm_cell_needs_a_region_however_it_is_asked_for() {
    use crate::world::World;
    use crate::world::command::Command;
    let cell = LayerSpec { kind: CloudKind::StormCell, ..layer(1.0) };
    let mut world = World::new();
    let listed = WeatherEdit { layers: Some(vec![layer(0.5), cell]), ..Default::default() };
    let refused = world.apply(Command::Weather(listed.clone())).expect_err("over the globe");
    assert_eq!(refused.field, "layers[1].cloud_type");
    let sheet = WeatherEdit { layers: Some(vec![layer(0.5)]), ..Default::default() };
    world.apply(Command::Weather(sheet)).expect("a layer");
    let change = LayerChange { index: 0, kind: Some(CloudKind::StormCell), ..Default::default() };
    let changed = WeatherEdit { changes: vec![change], ..Default::default() };
    let refused = world.apply(Command::Weather(changed)).expect_err("by a change");
    assert_eq!(refused.field, "changes[0].cloud_type");
    let region = WeatherEdit { region: Some(shape("a")), layers: Some(vec![cell]), ..Default::default() };
    world.apply(Command::Weather(region)).expect("in a region");
    let seen = world.snapshot(0.01);
    assert!(seen.regions[0].stands_in() && seen.weather.layers[0].kind == CloudKind::Cumulus);
}

#[test]
fn a_region_that_turns_from_a_cell_into_other_clouds_lets_the_weather_around_go_and_come_without_a_step() {
    use crate::clouds::CloudKind::{Cumulus, StormCell};
    use crate::world::World;
    use crate::world::command::Command;
    let spec = |kind| LayerSpec {
        kind,
        base_m: 1_000.0,
        thickness_m: 5_000.0,
        coverage: 0.8,
        density: 1.0,
        wind_speed_mps: 0.0,
        wind_from_deg: 0.0,
    };
    for (from, to) in [
        (vec![StormCell], vec![Cumulus]),
        (vec![Cumulus], vec![StormCell]),
        (vec![StormCell], vec![]),
        (vec![], vec![StormCell]),
    ] {
        let edit = |kinds: &[CloudKind], transition_s: f64| {
            Command::Weather(WeatherEdit {
                region: Some(shape("a")),
                layers: Some(kinds.iter().map(|kind| spec(*kind)).collect()),
                transition_s,
                ..WeatherEdit::default()
            })
        };
        let mut world = World::new();
        world.apply(edit(&from, 0.0)).expect("a region");
        world.advance_to(1.0);
        world.apply(edit(&to, 100.0)).expect("the change");
        let mut seen = Vec::new();
        for k in 0..=110 {
            world.advance_to(1.0 + f64::from(k));
            seen.push(world.snapshot(0.01).regions[0].gives_way());
        }
        let ends = |kinds: &[CloudKind]| if kinds == [StormCell] { 0.0 } else { 1.0 };
        assert_eq!((seen[0], seen[110]), (ends(&from), ends(&to)), "{from:?} {to:?}");
        // Smoothstep over half of the 100 s is steepest at 3 % a second.
        let step = seen.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
        assert!(step < 0.032, "{from:?} {to:?}: {step}");
    }
}
