//! Pictures of extreme snapshots are finite.

use super::*;
use crate::plan::plan;
use crate::plan::scenes::{cumulus_at, extremes, layer, place};

#[test]
fn extreme_snapshots_give_finite_pictures() {
    let mut executor = ReferenceExecutor::new();
    for (scene, snapshot) in extremes() {
        let plan = plan(&snapshot, &snapshot.views[0], Output::LinearRgb);
        let Pixels::LinearRgb(values) = executor.draw(&plan) else { panic!("{scene}: not linear") };
        assert_eq!(values.len() as u32, 3 * plan.size_px[0] * plan.size_px[1], "{scene}");
        let bad = values.iter().position(|v| !v.is_finite() || *v < 0.0);
        assert_eq!(bad, None, "{scene}: {:?}", bad.map(|i| values[i]));
        // By day and by night there is some light.
        assert!(values.iter().any(|v| *v > 0.0), "{scene}");
    }
}

#[test]
fn the_second_picture_makes_no_light_anew_however_many_layers_there_are() {
    let mut snapshot = cumulus_at(place(47.0, 8.0, 500.0));
    let other = |k: usize| layer(CloudKind::Cumulus, 3_000.0 + 400.0 * k as f64, 100.0 + 10.0 * k as f64);
    snapshot.weather.layers.extend((0..VOLUMES_KEPT + 1).map(other));
    let plan = plan(&snapshot, &snapshot.views[0], Output::LinearRgb);
    let mut executor = ReferenceExecutor::new();
    let first = executor.draw(&plan);
    let kept = |executor: &ReferenceExecutor| -> Vec<_> {
        let volumes = executor.volumes.iter();
        let mut kept: Vec<_> = volumes.map(|(_, volume)| Arc::as_ptr(volume)).collect();
        kept.sort();
        kept
    };
    let before = kept(&executor);
    assert!(before.len() > VOLUMES_KEPT, "{}", before.len());
    assert_eq!(executor.draw(&plan), first);
    assert_eq!(kept(&executor), before);
}
