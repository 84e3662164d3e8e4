//! Extremes of regions, ground and eye in pictures: the same weather looks the same however it is said and wherever it is.

use super::*;
use crate::geo::terrain::Terrain;
use crate::plan::scenes::{clear_day, region, sun};
use crate::world::command::Exposure;
use crate::world::snapshot::Snapshot;

/// Luminances of a picture.
fn drawn(executor: &mut ReferenceExecutor, snapshot: &Snapshot) -> Vec<f32> {
    match executor.draw(&plan(snapshot, &snapshot.views[0], Output::LinearRgb)) {
        Pixels::LinearRgb(values) => values,
        Pixels::Srgb8(_) => panic!("not linear"),
    }
}

fn mean(values: &[f32]) -> f64 {
    values.iter().map(|value| f64::from(*value)).sum::<f64>() / values.len() as f64
}

/// Mean difference over the mean.
fn apart(a: &[f32], b: &[f32]) -> f64 {
    let sum: f64 = a.iter().zip(b).map(|(a, b)| f64::from((a - b).abs())).sum();
    sum / a.len() as f64 / mean(b)
}

/// An eye at a place under a sun of 50 degrees there, with a fixed exposure.
fn at(latitude_deg: f64, longitude_deg: f64, altitude_m: f64) -> Snapshot {
    let mut snapshot = clear_day();
    snapshot.ownship.position = place(latitude_deg, longitude_deg, altitude_m);
    snapshot.views[0].exposure = Exposure::Ev100(14.5);
    sun(snapshot, 50.0)
}

#[test]
fn a_region_larger_than_the_horizon_is_as_the_same_weather_everywhere() {
    let mut executor = ReferenceExecutor::new();
    let mut everywhere = at(47.0, 8.0, 400.0);
    everywhere.weather.layers.push(layer(CloudKind::Cumulus, 1_000.0, 1_000.0));
    let mut local = at(47.0, 8.0, 400.0);
    local.regions.push(region(47.0, 8.0, 2_000_000.0, 10_000.0));
    local.regions[0].weather = everywhere.weather.clone();
    let (a, b) = (drawn(&mut executor, &local), drawn(&mut executor, &everywhere));
    // The walk takes shorter steps where regions may end: what it gathers differs by that. Without the clouds it would be far off.
    assert!(apart(&a, &b) < 0.03, "{}", apart(&a, &b));
    let clear = drawn(&mut executor, &at(47.0, 8.0, 400.0));
    assert!(apart(&clear, &b) > 0.1, "{}", apart(&clear, &b));
}

#[test]
fn a_region_is_the_same_over_a_pole_and_across_the_180th_meridian() {
    // A disc of 15 km with fog, which goes over into clear air over 4 km: its haze at the eye.
    let haze = |latitude_deg: f64, longitude_deg: f64, centre: (f64, f64)| {
        let mut snapshot = at(latitude_deg, longitude_deg, 400.0);
        let mut fog = region(centre.0, centre.1, 30_000.0, 4_000.0);
        (fog.weather.layers, fog.weather.visibility_m) = (Vec::new(), 500.0);
        (fog.shape.corner_radius_m, fog.shape.rotation_deg) = (15_000.0, 0.0);
        snapshot.regions.push(fog);
        f64::from(plan(&snapshot, &snapshot.views[0], Output::LinearRgb).camera.haze_per_m)
    };
    // 11.1, 16.7 and 22.2 km from the middle: inside, in the transition, beyond.
    for (away_deg, tolerance) in [(0.1, 1e-6), (0.15, 0.4), (0.2, 1e-6)] {
        let expected = haze(away_deg, 8.0, (0.0, 8.0));
        for (name, found) in [
            ("across 180", haze(away_deg, 180.0, (0.0, -180.0))),
            ("across 180, from the east", haze(0.0, -180.0 + 0.5 * away_deg, (0.0, 180.0 - 0.5 * away_deg))),
            ("over the pole", haze(90.0 - away_deg, 77.0, (90.0, 0.0))),
            ("over the other pole", haze(away_deg - 90.0, -120.0, (-90.0, 50.0))),
        ] {
            // A degree is 110.6 km northwards at the equator, 111.3 eastwards and 111.7 at the poles: 0.2 km of 4 in the transition,
            // over which the haze falls by a factor of 80, at most 1.5 times as fast as evenly (ln 80 x 1.5 x 0.05).
            assert!((found / expected - 1.0).abs() < tolerance, "{name}, {away_deg}: {found}, elsewhere {expected}");
        }
    }
    let [inside, between, beyond] = [0.1, 0.15, 0.2].map(|away_deg| haze(90.0 - away_deg, 10.0, (90.0, 0.0)));
    assert!(inside > 1.1 * between && between > 1.1 * beyond, "{inside} {between} {beyond}");
}

#[test]
fn a_region_smaller_than_the_spacing_of_slices_is_there_and_two_add_up() {
    let mut executor = ReferenceExecutor::new();
    // 16 slices of 18 km lie 1,200 m apart; the cell is 400 m wide, 2 km north of the eye, which looks there.
    let mut lone = at(47.0, 8.0, 300.0);
    (lone.views[0].size_px, lone.views[0].field_of_view_deg, lone.quality.slices) = ([32, 18], 40.0, 16);
    lone.ownship.attitude.pitch_rad = 0.3;
    let clear = drawn(&mut executor, &lone);
    let mut cell = region(47.018, 8.0, 400.0, 100.0);
    cell.weather.layers = vec![layer(CloudKind::Cumulonimbus, 500.0, 18_000.0)];
    cell.weather.layers[0].coverage = 1.0;
    lone.regions.push(cell.clone());
    let one = drawn(&mut executor, &lone);
    let changed = |a: &[f32], b: &[f32]| a.iter().zip(b).filter(|(a, b)| (*a / *b - 1.0).abs() > 0.02).count();
    assert!(changed(&one, &clear) > 0, "it is seen");
    // Another over half of it: where both are they are as one, beside it there is more.
    let mut both = lone.clone();
    cell.shape.longitude_deg += 0.003;
    both.regions.push(cell);
    let two = drawn(&mut executor, &both);
    assert!(changed(&two, &clear) >= changed(&one, &clear), "{} {}", changed(&two, &clear), changed(&one, &clear));
    assert!(two.iter().all(|value| value.is_finite()));
}

#[test]
fn clouds_end_at_mountains_that_stand_above_their_base() {
    let mut executor = ReferenceExecutor::new();
    // The Alps from 6 km, looking down: a sheet at 1,200 m hides the valleys; peaks stand out of it.
    let mut snapshot = at(46.5, 8.0, 6_000.0);
    (snapshot.views[0].size_px, snapshot.ownship.attitude.pitch_rad) = ([32, 18], -0.5);
    let mut sheet = layer(CloudKind::Stratus, 1_200.0, 400.0);
    sheet.coverage = 1.0;
    let mut hidden = |terrain: Terrain| {
        snapshot.terrain = terrain;
        snapshot.weather.layers = Vec::new();
        let bare = drawn(&mut executor, &snapshot);
        snapshot.weather.layers = vec![sheet];
        let clouded = drawn(&mut executor, &snapshot);
        // Pixels that are white now. Ground above the sheet is up to 1.6 times as bright as without it.
        let pixels = bare.chunks_exact(3).zip(clouded.chunks_exact(3));
        pixels.filter(|(a, b)| b[1] / a[1] > 1.9).count()
    };
    let (level, alps) = (hidden(Terrain::ELLIPSOID), hidden(Terrain::procedural()));
    let all = 32 * 18;
    assert!(level > 7 * all / 10, "over level ground it hides nearly all: {level}");
    assert!(alps < 8 * level / 10 && alps > 0, "and less where mountains stand over it: {alps} of {level}");
}

#[test]
fn an_eye_from_2_m_to_400_km_sees_a_sky_and_a_ground_that_ease_into_one_another() {
    let mut executor = ReferenceExecutor::new();
    let mut before: Option<f64> = None;
    for k in 0..=48 {
        // A factor of 1.29 from one to the next.
        let altitude_m = 2.0 * 200_000f64.powf(f64::from(k) / 48.0);
        let mut snapshot = at(30.0, -40.0, altitude_m);
        snapshot.ownship.attitude.pitch_rad = -0.2;
        let values = drawn(&mut executor, &snapshot);
        assert!(values.iter().all(|value| value.is_finite() && *value >= 0.0), "{altitude_m}");
        let now = mean(&values);
        if let Some(before) = before {
            // The horizon sinks by 20 degrees, and air comes between: the mean changes by tenths, never at once.
            assert!((0.75..1.33).contains(&(now / before)), "at {altitude_m} m: {before} to {now}");
        }
        before = Some(now);
    }
}
