//! The shade of higher layers against the integral along the light, the ground's shadows, and the light that there was before.

use crate::clouds::density::DensityVolume;
use crate::clouds::{CloudKind, detail, modulation};
use crate::passes::deck::field::{BOUNDS_WIDTH, Textures};
use crate::passes::shadow::march::through_from;
use crate::passes::shadow::shade::{WIDTH, at, map};
use crate::passes::shadow::table::{Table, build};
use crate::passes::shadow::twin::Caster;
use crate::plan::scenes::{clear_day, layer, place, region, sun};
use crate::plan::{FramePlan, Output, plan};
use crate::world::snapshot::{LayerState, Snapshot};
use glam::Vec3;

/// Altocumulus over stratocumulus, the sun at an elevation.
fn two(elevation_deg: f64, coverage: f64) -> Snapshot {
    let mut snapshot = clear_day();
    snapshot.ownship.position = place(47.0, 8.0, 6_000.0);
    snapshot.weather.layers = vec![
        LayerState { coverage: 0.9, ..layer(CloudKind::Stratocumulus, 1_200.0, 600.0) },
        LayerState { coverage, ..layer(CloudKind::Altocumulus, 4_500.0, 400.0) },
    ];
    sun(snapshot, elevation_deg)
}

fn planned(snapshot: &Snapshot) -> FramePlan {
    plan(snapshot, &snapshot.views[0], Output::LinearRgb)
}

/// The map of shade on the lowest layer.
fn shade_map(plan: &FramePlan) -> Vec<f32> {
    let casters = &plan.layers[0].shade;
    let tables: Vec<Vec<Table>> = casters
        .iter()
        .map(|caster| {
            let shape = &DensityVolume::of(plan.layers[caster.layer].kind).shape;
            caster.columns.iter().map(|columns| build(columns, shape)).collect()
        })
        .collect();
    let casters: Vec<Caster> = casters
        .iter()
        .zip(&tables)
        .map(|(caster, tables)| Caster {
            layer: &plan.layers[caster.layer].layer,
            shadow: caster.shadow,
            tables: tables.iter().collect(),
            map: modulation::map(),
        })
        .collect();
    map(&plan.layers[0].layer, &casters, plan.camera.earth_m)
}

/// A point at a height over the sphere, this far east and north of the eye.
fn point(plan: &FramePlan, x: f32, y: f32, height_m: f32) -> Vec3 {
    Vec3::new(x, y, height_m - (x * x + y * y) / (2.0 * plan.camera.earth_m))
}

#[test]
fn shade_is_what_the_higher_layer_lets_through_along_the_light() {
    for elevation_deg in [70.0, 30.0] {
        let plan = planned(&two(elevation_deg, 0.5));
        let (lower, upper) = (&plan.layers[0].layer, &plan.layers[1]);
        let map = shade_map(&plan);
        assert_eq!(map.len(), WIDTH * WIDTH);
        let shape = &DensityVolume::of(upper.kind).shape;
        let bounds = vec![255u8; BOUNDS_WIDTH * BOUNDS_WIDTH];
        let (all, detail) = (modulation::map(), detail::volume());
        let textures = Textures { shape, lights: &[], bounds: &bounds, map: all, detail, shade: None, glow: None };
        let earth_m = plan.camera.earth_m;
        let (mut ours, mut truth, mut apart, mut moved) = (0.0, 0.0, 0.0, 0.0);
        for k in 0..900 {
            let [x, y] = [k % 30, k / 30].map(|i| (i as f32 - 14.5) * 160.0);
            let height_m = lower.base_m + (k % 7) as f32 / 6.0 * lower.thickness_m;
            let p = point(&plan, x, y, height_m);
            let found = at(lower, &map, earth_m, p, height_m);
            let marched = through_from(&upper.layer, &textures, earth_m, p, height_m, 64);
            let elsewhere = at(lower, &map, earth_m, point(&plan, x + 900.0, y, height_m), height_m);
            (ours, truth) = (ours + found / 900.0, truth + marched / 900.0);
            (apart, moved) = (apart + (found - marched).abs() / 900.0, moved + (found - elsewhere).abs() / 900.0);
        }
        println!("{elevation_deg} degrees: mean {ours:.4}, marched {truth:.4}, apart {apart:.4}, elsewhere {moved:.4}");
        assert!(truth > 0.05 && truth < 0.95 && moved > 0.1, "there is shade: {truth} {moved}");
        // The table's texels of 62.5 m and the map's, of 62 m and more, soften the edges of elements of 1.7 km whose gaps are
        // narrower than that; the mean stays.
        assert!((ours - truth).abs() < 0.02 && apart < 0.1 && apart < 0.65 * moved, "{ours} {truth} {apart}");
    }
}

#[test]
fn the_mean_light_on_the_lower_layer_stays() {
    for (elevation_deg, coverage) in [(60.0, 0.3), (25.0, 0.7)] {
        let snapshot = two(elevation_deg, coverage);
        let shaded = planned(&snapshot);
        let light = crate::plan::illuminance::tests::light(&snapshot);
        let mu = light.source.z;
        let layer = &shaded.layers[0].layer;
        let casters = &shaded.layers[0].shade;
        assert_eq!(casters.len(), 1);
        let upper = &shaded.layers[1];
        let through = crate::passes::shadow::mean::mean_through(
            upper.kind,
            &casters[0].columns[0],
            upper.layer.theta,
            upper.layer.patchiness,
        );
        let now = layer.light_lux[1] * mu * through + layer.sky_lux[1] * 4.0 * std::f32::consts::PI;
        // The air between the layers takes its part of the source's light.
        let above = light.columns[0].above[0];
        let red = light.reddening(0, f64::from(layer.base_m + layer.thickness_m));
        let before = (above.direct_lux * red).y * mu + above.diffuse_lux.y;
        // The same numbers in another order, in f32.
        assert!((now / before - 1.0).abs() < 1e-4, "{elevation_deg} {coverage}: {now} {before}");
        assert!(layer.light_lux[1] > upper.layer.light_lux[1] * 0.99 * red.y, "between the shadows the light is whole");
    }
}

#[test]
fn shade_is_planned_only_where_it_is_to_be_seen() {
    let shaded = |snapshot: &Snapshot| planned(snapshot).layers.iter().filter(|l| !l.shade.is_empty()).count();
    assert_eq!(shaded(&two(40.0, 0.5)), 1);
    let mut night = two(-20.0, 0.5);
    assert_eq!(shaded(&night), 1, "by the moon");
    night.sky.moon_shines = false;
    assert_eq!(shaded(&night), 0, "at night");
    let mut one = two(40.0, 0.5);
    one.weather.layers.truncate(1);
    assert_eq!(shaded(&one), 0, "nothing above");
    let mut covered = two(40.0, 1.0);
    covered.weather.layers[1] = LayerState { coverage: 1.0, ..layer(CloudKind::Nimbostratus, 3_000.0, 4_000.0) };
    assert_eq!(shaded(&covered), 0, "no light left to be shaded");
    // A tower of a region stands above the layer around it.
    let mut tower = one.clone();
    let mut own = region(47.0, 8.0, 30_000.0, 2_000.0);
    own.weather.layers = vec![layer(CloudKind::Cumulonimbus, 900.0, 8_000.0)];
    tower.regions.push(own);
    assert_eq!(shaded(&tower), 1, "the layer around it, not the tower");
    let note = planned(&one).notes.into_iter().find(|n| n.pass == "shade").expect("a note");
    assert!(!note.kept);
}
