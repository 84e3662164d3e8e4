//! Shadows go with the wind, and leave as much light on the ground as the layers let through on the whole.

use crate::clouds::density::DensityVolume;
use crate::clouds::{CloudKind, modulation};
use crate::geo::frames::enu;
use crate::passes::shadow::table::{Table, build};
use crate::passes::shadow::twin::Caster;
use crate::plan::scenes::{clear_day, layer, place, sun};
use crate::plan::{FramePlan, Output, plan};
use crate::world::snapshot::{LayerState, Snapshot};
use glam::{DQuat, Vec3};

/// Ground in sight, the sun at an elevation, and a layer.
fn scene(layer: LayerState, elevation_deg: f64) -> Snapshot {
    let mut snapshot = clear_day();
    snapshot.ownship.position = place(47.0, 8.0, 2.0);
    snapshot.weather.layers = vec![layer];
    sun(snapshot, elevation_deg)
}

fn tables(plan: &FramePlan) -> Vec<Table> {
    let caster = &plan.shadow.as_ref().expect("shadows").casters[0];
    let shape = &DensityVolume::of(plan.layers[caster.layer].kind).shape;
    caster.columns.iter().map(|columns| build(columns, shape)).collect()
}

fn caster<'a>(plan: &'a FramePlan, tables: &'a [Table]) -> Caster<'a> {
    let found = &plan.shadow.as_ref().expect("shadows").casters[0];
    let layer = &plan.layers[found.layer].layer;
    Caster { layer, shadow: found.shadow, tables: tables.iter().collect(), map: modulation::map() }
}

fn ground(plan: &FramePlan, x: f32, y: f32) -> Vec3 {
    Vec3::new(x, y, -(x * x + y * y) / (2.0 * plan.camera.earth_m))
}

#[test]
fn shadows_move_with_the_wind() {
    let still = scene(layer(CloudKind::Cumulus, 1_000.0, 1_000.0), 40.0);
    let (east_m, north_m) = (700.0, -400.0);
    let mut blown = still.clone();
    let axes = enu(&still.ownship.position);
    let by = (axes.y_axis * east_m - axes.x_axis * north_m) / 6_371_000.0;
    blown.weather.layers[0].drift = DQuat::from_scaled_axis(by);
    let plans = [&still, &blown].map(|s| plan(s, &s.views[0], Output::LinearRgb));
    let tables = [tables(&plans[0]), tables(&plans[1])];
    let (mut moved, mut changed) = (0.0f32, 0.0f32);
    for k in 0..400 {
        let [x, y] = [(k % 20) as f32 * 310.0, (k / 20) as f32 * 290.0];
        let at = |i: usize, p: [f32; 2]| {
            let p = ground(&plans[i], p[0], p[1]);
            caster(&plans[i], &tables[i]).through(plans[i].camera.earth_m, p, 0.0)
        };
        let before = at(0, [x, y]);
        moved += (at(1, [x + east_m as f32, y + north_m as f32]) - before).abs();
        changed += (at(1, [x, y]) - before).abs();
    }
    assert!(changed > 20.0, "elsewhere it is another shadow: {changed}");
    // The ellipsoid's radius here and the mean radius differ by 0.2 %: of 800 m that is 2 m, a thirtieth of a texel.
    assert!(moved < 0.05 * changed, "{moved} of {changed}");
}

#[test]
fn on_the_whole_the_ground_gets_the_light_that_the_layers_let_through() {
    for (kind, thickness_m) in [
        (CloudKind::Cumulus, 1_200.0),
        (CloudKind::Stratocumulus, 500.0),
        (CloudKind::Altocumulus, 400.0),
        (CloudKind::Cirrus, 1_000.0),
        (CloudKind::Stratus, 400.0),
    ] {
        for coverage in [0.2, 0.5, 0.8, 1.0] {
            for elevation_deg in [60.0, 25.0] {
                let state = LayerState { coverage, ..layer(kind, 1_500.0, thickness_m) };
                let snapshot = scene(state, elevation_deg);
                let shaded = plan(&snapshot, &snapshot.views[0], Output::LinearRgb);
                let tables = tables(&shaded);
                let caster = caster(&shaded, &tables);
                // The mean over a tile (the coarsest level), over a grid of places of the map.
                let (mut through, points) = (0.0, 64 * 64);
                for k in 0..points {
                    let at = [k % 64, k / 64].map(|i| (i as f32 - 31.5) * 6_300.0);
                    through += caster.through(shaded.camera.earth_m, ground(&shaded, at[0], at[1]), 64_000.0);
                }
                let through = through / points as f32;
                let given = shaded.ground.expect("ground");
                let mu = given.light_direction[2];
                let now = given.light_lux[1] * mu * through + given.sky_lux[1];
                let light = crate::plan::illuminance::tests::light(&snapshot);
                let before = light.ground.horizontal_lux(mu).y;
                let at = format!("{kind:?} covering {coverage}, {elevation_deg} degrees");
                println!("{at}: through {through:.3}, diffuse {:.0} lx, {now:.0} of {before:.0} lx", given.sky_lux[1]);
                // An eighth of the rows of a tile makes the plan's mean, all of them the shadow's; the map's places are few.
                assert!((now / before - 1.0).abs() < 0.015, "{at}: {now} lx with shadows, {before} lx without");
                // Exposure and the light on clouds know nothing of shadows.
                assert_eq!(shaded.camera.exposure, light.exposure, "{at}");
            }
        }
    }
}
