//! Weather: nothing jumps, nothing overlaps, and a refused edit leaves everything as it was.

use super::*;
use crate::clouds::CloudKind;
use glam::DVec3;

const HERE: Geodetic = Geodetic { latitude_rad: 0.8, longitude_rad: 3.1, altitude_m: 0.0 };

fn spec(kind: CloudKind, base_m: f64, thickness_m: f64, coverage: f64) -> LayerSpec {
    LayerSpec { kind, base_m, thickness_m, coverage, density: 1.0, wind_speed_mps: 15.0, wind_from_deg: 200.0 }
}

fn list(layers: &[LayerSpec], transition_s: f64) -> WeatherEdit {
    WeatherEdit { layers: Some(layers.to_vec()), transition_s, ..Default::default() }
}

fn change(change: LayerChange, transition_s: f64) -> WeatherEdit {
    WeatherEdit { changes: vec![change], transition_s, ..Default::default() }
}

/// Plays edits at their times and returns the weather as a function of time.
fn played(edits: &[(f64, WeatherEdit)]) -> impl Fn(f64) -> WeatherState + use<> {
    let mut stages = vec![(f64::NEG_INFINITY, Weather::clear())];
    for (at_s, edit) in edits {
        let mut next = stages.last().unwrap().1.clone();
        next.edit(edit, &HERE, *at_s).unwrap();
        stages.push((*at_s, next));
    }
    move |t| stages.iter().rev().find(|(at_s, _)| *at_s <= t).unwrap().1.at(t)
}

/// What an eye would notice of a layer: all of it times its coverage, so that a layer of no coverage counts for nothing.
fn seen(state: &WeatherState, slot: usize) -> [f64; 9] {
    let Some(layer) = state.layers.get(slot) else { return [0.0; 9] };
    let kind = layer.kind as usize as f64;
    let drifted = layer.drift * DVec3::X * 6.4e6;
    let (sin, cos) = layer.wind_from_deg.to_radians().sin_cos();
    let c = layer.coverage;
    [
        c * 1e4,
        c * kind * 1e3,
        c * layer.base_m,
        c * layer.thickness_m,
        c * layer.density * 1e3,
        c * layer.wind_speed_mps * sin * 100.0,
        c * layer.wind_speed_mps * cos * 100.0,
        c * drifted.y,
        c * drifted.z,
    ]
}

fn assert_no_jump(weather: &dyn Fn(f64) -> WeatherState, from_s: f64, to_s: f64, most_per_s: f64) {
    let step_s = 0.01;
    let steps = ((to_s - from_s) / step_s) as usize;
    let mut before = weather(from_s);
    for k in 1..=steps {
        let t = from_s + k as f64 * step_s;
        let now = weather(t);
        for slot in 0..limits::MAX_LAYERS {
            for (what, (a, b)) in seen(&before, slot).iter().zip(seen(&now, slot)).enumerate() {
                assert!((a - b).abs() < most_per_s * step_s, "slot {slot}, quantity {what} at {t}: {a} to {b}");
            }
        }
        let change = (now.visibility_m / before.visibility_m).ln().abs();
        assert!(change < 2.0 * step_s, "visibility at {t}: {} to {}", before.visibility_m, now.visibility_m);
        for pair in now.layers.windows(2) {
            assert!(pair[1].base_m >= pair[0].base_m + pair[0].thickness_m - 1e-9, "layer over layer at {t}");
        }
        before = now;
    }
}

#[test]
fn every_quantity_is_continuous_through_all_kinds_of_change() {
    use CloudKind::{Cirrus, Cumulus, Stratus};
    let weather = played(&[
        (0.0, list(&[spec(Cumulus, 1000.0, 500.0, 0.4), spec(Cirrus, 8000.0, 900.0, 0.7)], 20.0)),
        // In mid-transition: another type below, the upper one gone.
        (12.0, WeatherEdit { visibility_m: Some(3_000.0), ..list(&[spec(Stratus, 300.0, 400.0, 1.0)], 30.0) }),
        // In mid-transition again: one field of one layer.
        (
            25.0,
            change(
                LayerChange { index: 0, base_m: Some(900.0), wind_speed_mps: Some(40.0), ..Default::default() },
                15.0,
            ),
        ),
        // The clearing layer is taken up again as another, and one more appears above.
        (
            35.0,
            list(
                &[spec(Cumulus, 700.0, 900.0, 0.5), spec(Cirrus, 7000.0, 300.0, 0.2), spec(Cirrus, 9000.0, 300.0, 0.9)],
                20.0,
            ),
        ),
        (60.0, list(&[], 10.0)),
        (75.0, change_visibility(20_000.0, 5.0)),
    ]);
    // Fastest: coverage 1 in half of 30 s at 1.5 times the mean, times 1e4 or the drift of 4e6 m: 4e5 m/s.
    assert_no_jump(&weather, -1.0, 90.0, 2e6);
    assert!(weather(90.0).layers.is_empty() && weather(90.0).visibility_m == 20_000.0);
}

fn change_visibility(visibility_m: f64, transition_s: f64) -> WeatherEdit {
    WeatherEdit { visibility_m: Some(visibility_m), transition_s, ..Default::default() }
}

#[test]
fn a_drifted_point_moves_at_the_speed_of_the_wind_through_everything() {
    let weather = played(&[
        (0.0, list(&[spec(CloudKind::Cumulus, 1000.0, 500.0, 0.4)], 0.0)),
        (
            10.0,
            list(
                &[LayerSpec {
                    wind_speed_mps: 45.0,
                    wind_from_deg: 20.0,
                    ..spec(CloudKind::Cumulus, 2000.0, 500.0, 0.4)
                }],
                30.0,
            ),
        ),
        (25.0, change(LayerChange { index: 0, wind_from_deg: Some(300.0), ..Default::default() }, 20.0)),
        (30.0, change(LayerChange { index: 0, coverage: Some(0.9), ..Default::default() }, 0.0)),
    ]);
    let at = |t: f64| weather(t).layers[0].drift * DVec3::X * 6.371e6;
    let mut before = at(1.0);
    for k in 1..6000 {
        let now = at(1.0 + f64::from(k) * 0.01);
        // No wind here is above 60 m/s on the way (45 m/s and what the turn between two reference winds adds).
        assert!((now - before).length() < 0.6, "step {k}: {}", (now - before).length());
        before = now;
    }
}

#[test]
fn ends_are_exactly_what_was_asked() {
    let target = [spec(CloudKind::Stratocumulus, 700.0, 300.0, 0.6), spec(CloudKind::Altocumulus, 3000.0, 300.0, 0.3)];
    let weather = played(&[
        (0.0, list(&[spec(CloudKind::Cumulus, 1000.0, 500.0, 0.4)], 0.0)),
        (10.0, list(&[target[1], target[0]], 7.0)),
    ]);
    for (state, spec) in weather(17.0).layers.iter().zip(&target) {
        let said = (
            state.kind,
            state.base_m,
            state.thickness_m,
            state.coverage,
            state.density,
            state.wind_speed_mps,
            state.wind_from_deg,
        );
        assert_eq!(
            said,
            (
                spec.kind,
                spec.base_m,
                spec.thickness_m,
                spec.coverage,
                spec.density,
                spec.wind_speed_mps,
                spec.wind_from_deg
            )
        );
    }
    assert_eq!(weather(17.0).layers.len(), 2);
    assert_eq!(weather(10.0).layers[0].base_m, 1000.0, "and it begins where it was");
}

#[test]
fn another_type_comes_only_after_the_old_has_cleared() {
    let weather = played(&[
        (0.0, list(&[spec(CloudKind::Cumulus, 1000.0, 500.0, 0.8)], 0.0)),
        (10.0, list(&[spec(CloudKind::Stratus, 1000.0, 500.0, 0.6)], 10.0)),
    ]);
    let at = |t: f64| (weather(t).layers[0].kind, weather(t).layers[0].coverage);
    assert_eq!(at(10.0), (CloudKind::Cumulus, 0.8));
    // Smoothstep half way down is a half.
    assert_eq!(at(12.5), (CloudKind::Cumulus, 0.4));
    assert_eq!(at(15.0), (CloudKind::Stratus, 0.0));
    assert_eq!(at(17.5), (CloudKind::Stratus, 0.3));
    assert_eq!(at(20.0), (CloudKind::Stratus, 0.6));
}

#[test]
fn an_edit_of_one_quantity_disturbs_no_other() {
    let base = (0.0, list(&[spec(CloudKind::Cumulus, 1000.0, 500.0, 0.2)], 0.0));
    let slow = (0.0, list(&[spec(CloudKind::Cumulus, 2000.0, 500.0, 0.2)], 100.0));
    let alone = played(&[base.clone(), slow.clone()]);
    let disturbed = played(&[
        base,
        slow,
        (30.0, change(LayerChange { index: 0, coverage: Some(0.9), ..Default::default() }, 0.0)),
        (40.0, change_visibility(100.0, 0.0)),
    ]);
    for t in [35.0, 50.0, 99.0] {
        assert_eq!(alone(t).layers[0].base_m, disturbed(t).layers[0].base_m);
        assert_eq!(disturbed(t).layers[0].coverage, 0.9);
    }
}

#[test]
fn a_layer_that_rises_lifts_the_one_above_that_is_slower() {
    let weather = played(&[
        (0.0, list(&[spec(CloudKind::Cumulus, 1000.0, 500.0, 0.2), spec(CloudKind::Cirrus, 3000.0, 500.0, 0.2)], 0.0)),
        (10.0, change(LayerChange { index: 1, base_m: Some(8000.0), ..Default::default() }, 100.0)),
        (20.0, change(LayerChange { index: 0, base_m: Some(6000.0), ..Default::default() }, 5.0)),
    ]);
    // 5000 m in 5 s at 1.5 times the mean speed, times the coverage of 0.2.
    assert_no_jump(&weather, 9.0, 120.0, 500.0);
    assert_eq!(weather(25.0).layers[1].base_m, 6500.0, "lifted");
    assert_eq!(weather(110.0).layers[1].base_m, 8000.0, "and in the end where it was sent");
}

#[test]
fn contradictions_are_refused_and_change_nothing() {
    let mut weather = Weather::clear();
    weather
        .edit(
            &list(&[spec(CloudKind::Cumulus, 1000.0, 500.0, 0.2), spec(CloudKind::Cirrus, 8000.0, 500.0, 0.2)], 0.0),
            &HERE,
            0.0,
        )
        .unwrap();
    let before = weather.clone();
    let cumulus = spec(CloudKind::Cumulus, 1000.0, 500.0, 0.2);
    let nine: Vec<LayerSpec> = (0..9).map(|k| spec(CloudKind::Stratus, f64::from(k) * 600.0, 500.0, 0.1)).collect();
    let bad = |layer: LayerSpec| list(&[layer], 0.0);
    for (edit, field) in [
        (list(&nine, 0.0), "layers"),
        (list(&[spec(CloudKind::Cirrus, 1499.0, 10.0, 0.1), cumulus], 0.0), "layers[0].base_m"),
        (change(LayerChange { index: 2, ..Default::default() }, 0.0), "changes[0].index"),
        (change(LayerChange { index: 0, thickness_m: Some(7001.0), ..Default::default() }, 0.0), "layers[1].base_m"),
        (change(LayerChange { index: 0, coverage: Some(f64::NAN), ..Default::default() }, 0.0), "changes[0].coverage"),
        (bad(LayerSpec { base_m: f64::NAN, ..cumulus }), "layers[0].base_m"),
        (bad(LayerSpec { thickness_m: -1.0, ..cumulus }), "layers[0].thickness_m"),
        (bad(LayerSpec { coverage: 1.1, ..cumulus }), "layers[0].coverage"),
        (bad(LayerSpec { density: f64::INFINITY, ..cumulus }), "layers[0].density"),
        (bad(LayerSpec { wind_speed_mps: -1.0, ..cumulus }), "layers[0].wind_speed_mps"),
        (bad(LayerSpec { wind_from_deg: 1e9, ..cumulus }), "layers[0].wind_from_deg"),
        (list(&[cumulus], -1.0), "transition_s"),
        (list(&[cumulus], f64::NAN), "transition_s"),
        (change_visibility(0.0, 0.0), "visibility_m"),
        (WeatherEdit { visibility_m: Some(f64::NAN), ..list(&[cumulus], 0.0) }, "visibility_m"),
    ] {
        let refused = weather.edit(&edit, &HERE, 1.0).unwrap_err();
        assert_eq!(refused.field, field);
        assert_eq!(weather, before, "{field}");
    }
}

#[test]
fn changes_count_from_the_lowest_base_of_the_new_list_and_may_touch() {
    let mut weather = Weather::clear();
    let high = spec(CloudKind::Cirrus, 8000.0, 500.0, 0.2);
    let low = spec(CloudKind::Cumulus, 1000.0, 500.0, 0.2);
    let edit = WeatherEdit {
        changes: vec![LayerChange { index: 0, base_m: Some(7500.0), ..Default::default() }],
        ..list(&[high, low], 0.0)
    };
    weather.edit(&edit, &HERE, 0.0).unwrap();
    assert_eq!(weather.at(0.0).layers[0].base_m, 7500.0, "top on base is no overlap");
    assert_eq!(weather.targets()[0].kind, CloudKind::Cumulus);
}

#[test]
fn a_host_that_repeats_itself_does_not_hold_the_transition_back() {
    let target = list(&[spec(CloudKind::Cumulus, 2000.0, 500.0, 0.8)], 10.0);
    let mut edits = vec![(0.0, list(&[spec(CloudKind::Cumulus, 1000.0, 500.0, 0.2)], 0.0))];
    edits.extend((1..10).map(|k| (f64::from(k), target.clone())));
    assert_eq!(played(&edits)(11.0).layers[0].base_m, 2000.0);
}
