//! The density that varies around the eye: where it is planned, how much it varies, that a flight shows it.

use crate::clouds::CloudKind;
use crate::frame::Pixels;
use crate::passes::deck::Layer;
use crate::passes::deck::clumps::{VARIED_M, varied};
use crate::passes::deck::field::Textures;
use crate::plan::{Output, plan, scenes};
use crate::reference::ReferenceExecutor;
use crate::world::snapshot::Snapshot;
use glam::Vec3;

const EARTH_M: f32 = 6_371_000.0;

fn overcast(altitude_m: f64) -> Snapshot {
    let mut snapshot = scenes::clear_day();
    snapshot.ownship.position.altitude_m = altitude_m;
    let mut layer = scenes::layer(CloudKind::Stratocumulus, 1_000.0, 600.0);
    layer.coverage = 1.0;
    snapshot.weather.layers.push(layer);
    snapshot
}

fn layer_at(altitude_m: f64) -> Layer {
    let snapshot = overcast(altitude_m);
    plan(&snapshot, &snapshot.views[0], Output::LinearRgb).layers[0].layer
}

#[test]
fn clumps_are_there_where_they_are_flown_through_and_nowhere_else() {
    let [inside, near, far] = [1_300.0, 500.0, 350.0].map(layer_at);
    assert!(inside.varied > 1.0 && near.varied == inside.varied, "{} {}", inside.varied, near.varied);
    assert_eq!(far.varied, 0.0);
}

#[test]
fn density_varies_by_two_fifths_about_its_mean_and_not_far_away() {
    let layer = layer_at(1_300.0);
    let textures = Textures::unlit(&[], &[]);
    let at = |i: usize, t: f32| {
        let p = Vec3::new((i % 100) as f32 * 37.0 - 1_850.0, (i / 100) as f32 * 41.0 - 2_050.0, 1_300.0);
        f64::from(varied(&layer, &textures, EARTH_M, p, 1_300.0, t))
    };
    let moments = |t: f32| {
        let values: Vec<f64> = (0..10_000).map(|i| at(i, t)).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt())
    };
    let (mean, spread) = moments(100.0);
    // Some ten periods of the coarser clumps lie in the square, and a few values are cut off: a twentieth.
    assert!((mean - 1.0).abs() < 0.05 && (0.3..0.6).contains(&spread), "{mean} {spread}");
    let (_, fading) = moments(400.0);
    assert!(fading < 0.7 * spread && fading > 0.1 * spread, "{fading} of {spread}");
    assert_eq!(moments(VARIED_M[1]), (1.0, 0.0));
}

#[test]
fn a_flight_through_an_overcast_has_brighter_and_darker_places() {
    let mut executor = ReferenceExecutor::new();
    // Mean luminance ahead at twelve places 40 m apart.
    let mut luminance = |snapshot: &Snapshot, still: bool| -> Vec<f64> {
        (0..12)
            .map(|i| {
                let mut there = snapshot.clone();
                there.ownship.position.latitude_rad += f64::from(i) * 40.0 / 6_371_000.0;
                let mut plan = plan(&there, &there.views[0], Output::LinearRgb);
                if still {
                    plan.layers[0].layer.varied = 0.0;
                }
                let Pixels::LinearRgb(values) = executor.draw(&plan) else { panic!("not linear") };
                // Without its exposure, which might answer to what is measured.
                values.iter().map(|v| f64::from(*v)).sum::<f64>() / f64::from(plan.camera.exposure)
            })
            .collect()
    };
    let mut snapshot = overcast(1_300.0);
    snapshot.views[0].size_px = [16, 16];
    let spread = |values: Vec<f64>| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (values.iter().map(|v| (v / mean - 1.0).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
    };
    let (with, without) = (spread(luminance(&snapshot, false)), spread(luminance(&snapshot, true)));
    assert!(with > 0.03 && with > 2.0 * without, "{with} with clumps, {without} without");
}
