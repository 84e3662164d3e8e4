//! Pictures of extreme snapshots are finite; more coverage hides more.

mod clumps;
mod extremes;
mod geometry;
mod memory;

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
        // By day and by night there is some light, but for an eye outside the air that looks past the Earth.
        let space = plan.camera.eye_m > 100_000.0 && plan.camera.forward[2] > -0.1;
        assert!(space || values.iter().any(|v| *v > 0.0), "{scene}");
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

/// What the deck of a plan hides, in the mean over the picture.
fn mean_opacity(plan: &FramePlan) -> f64 {
    let opacities = opacities(plan);
    opacities.iter().map(|opacity| f64::from(*opacity)).sum::<f64>() / opacities.len() as f64
}

/// What the deck of a plan hides, pixel by pixel, rows from the top. Light does not matter to it.
fn opacities(plan: &FramePlan) -> Vec<f32> {
    let texels = Texels::Bytes(vec![[0; 4]; crate::passes::light::volume::VOXELS]);
    let dark = Volume { nodes: 1, texels };
    let table = vec![Texel([half::f16::ZERO; 4]); 2 * crate::passes::sky::table::WIDTH.pow(2)];
    let lights = [&dark; 3];
    let prepared: Vec<_> = plan
        .layers
        .iter()
        .map(|layer| {
            let density = DensityVolume::of(layer.kind);
            let bounds = crate::passes::deck::field::empty_space(layer.kind);
            (layer, density, bounds)
        })
        .collect();
    let layers: Vec<Prepared> = prepared
        .iter()
        .map(|(layer, density, bounds)| {
            let textures = Textures {
                shape: &density.shape,
                lights: &lights[..layer.light.len()],
                bounds,
                map: modulation::map(),
                detail: detail::volume(),
                shade: None,
                glow: None,
            };
            Prepared::new(&layer.layer, textures)
        })
        .collect();
    images::deck(plan, &table, &layers, None).texels.iter().map(|texel| texel.w).collect()
}

#[test]
fn every_hundredth_of_coverage_hides_no_less() {
    for (kind, altitude_m, pitch_deg) in [
        (CloudKind::Cumulus, 200.0, 90.0f64),
        (CloudKind::Stratus, 200.0, 90.0),
        (CloudKind::Cumulus, 1_500.0, 0.0),
        (CloudKind::Cumulus, 5_000.0, -90.0),
    ] {
        let mut snapshot = cumulus_at(place(47.0, 8.0, altitude_m));
        snapshot.ownship.attitude.pitch_rad = pitch_deg.to_radians();
        snapshot.weather.layers[0].kind = kind;
        (snapshot.views[0].size_px, snapshot.views[0].field_of_view_deg) = ([24, 16], 100.0);
        let mut last = 0.0;
        for hundredths in 0..=100 {
            snapshot.weather.layers[0].coverage = f64::from(hundredths) / 100.0;
            let now = mean_opacity(&plan(&snapshot, &snapshot.views[0], Output::LinearRgb));
            // Steps follow the distance to the cloud, so that a ray may miss a wisp that it had met: 0.4 % of the picture.
            assert!(now >= last - 0.004, "{kind:?} from {altitude_m} m: {last} to {now} at {hundredths} %");
            last = f64::max(last, now);
            if hundredths == 0 {
                assert_eq!(now, 0.0);
            }
        }
        assert!(last > 0.9, "{kind:?} from {altitude_m} m: {last}");
    }
}

mod relight;
pub(crate) mod strokes;
