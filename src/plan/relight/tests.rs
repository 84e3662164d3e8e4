//! Which flashes have fields: none without flash, cloud or channel; one for each geometry, whatever frame and eye; faded where many.

use super::*;
use crate::clouds::CloudKind;
use crate::geo::frames::enu;
use crate::lightning::flash::Polarity;
use crate::lightning::strike::{StrikeSpec, grow_strike};
use crate::lightning::tables::Tables;
use crate::plan::scenes::{cumulus_at, flash, layer, place, region};
use crate::plan::{FramePlan, Output, plan};
use crate::world::snapshot::Quality;
use std::sync::atomic::AtomicBool;

fn plan_of(snapshot: &Snapshot) -> FramePlan {
    plan(snapshot, &snapshot.views[0], Output::Srgb8)
}

/// A flash inside the cloud with its channel.
fn struck(position: Geodetic) -> FlashState {
    let spec = StrikeSpec {
        kind: flash(position).kind,
        polarity: Polarity::Negative,
        seed: 7,
        origin_m: position.altitude_m,
        cloud_m: [1_000.0, 2_000.0],
        grounds_m: Vec::new(),
    };
    let channel = grow_strike(&spec, &mut Tables::default(), &AtomicBool::new(false)).expect("a right specification");
    FlashState { channel: Some(Arc::new(channel)), ..flash(position) }
}

#[test]
fn a_flash_in_a_cloud_asks_for_one_field_whatever_the_frame_and_the_eye() {
    let mut snapshot = cumulus_at(place(47.0, 8.0, 500.0));
    snapshot.quality.relight = Lighting::Solve;
    snapshot.weather.layers[0].wind_speed_mps = 30.0;
    assert!(plan_of(&snapshot).lit.is_empty(), "no flash, no field");
    snapshot.flashes.push(struck(place(47.05, 8.02, 1_500.0)));
    let first = plan_of(&snapshot);
    assert!(first.lit.len() == 1 && first.layers[0].layer.flashes == 0, "a field in place of a point");
    // Half a second on the wind has carried the pattern 15 m, the eye has flown, and a stroke is brighter.
    let mut later = snapshot.clone();
    let axis = enu(&snapshot.ownship.position);
    let velocity = axis.x_axis * 30.0;
    later.weather.layers[0].drift =
        DQuat::from_scaled_axis(axis.z_axis.cross(velocity) / (MEAN_RADIUS_M + 1_000.0) * 0.5);
    later.simulation_time_s += 0.5;
    later.ownship.position = place(47.01, 8.01, 700.0);
    later.flashes[0].intensity_cd = 5e9;
    let second = plan_of(&later);
    assert_eq!(first.lit[0].request, second.lit[0].request);
    // The scene's light names no part: the whole tree shines, and the channel alone may come next.
    assert!(first.ahead.len() == 1 && first.ahead[0] != first.lit[0].request);
    assert!(second.lit[0].placing.intensity_cd > 4.0 * first.lit[0].placing.intensity_cd);
    // The branches of a first stroke shine once, the channel again and again: two geometries.
    let light = |branches, amount| Light { channel: 0, branches, span: [0.0, 1.0], amount };
    later.flashes[0].lights = vec![light(true, 3.0), light(false, 1.0), light(false, 2.0)];
    let both = plan_of(&later);
    let parts = both.lit;
    assert!(both.ahead.is_empty(), "what shines already needs no making ahead");
    assert!(parts.len() == 2 && parts[0].request != parts[1].request);
    assert!((parts[0].placing.intensity_cd / 2.5e9 - 1.0).abs() < 1e-5, "half of the light is the branches'");
    later.flashes[0].channel = None;
    assert!(plan_of(&later).lit.is_empty(), "while the channel is being grown there is a point");
    snapshot.quality.relight = Lighting::Point;
    let bare = plan_of(&snapshot);
    assert!(bare.lit.is_empty() && bare.layers[0].layer.flashes == 1);
    snapshot.quality.relight = Lighting::Solve;
    snapshot.weather.layers.clear();
    assert!(plan_of(&snapshot).lit.is_empty(), "no cloud, no field");
}

#[test]
fn more_flashes_than_fields_are_faded_not_cut() {
    let mut snapshot = cumulus_at(place(47.0, 8.0, 500.0));
    snapshot.quality.relight = Lighting::Solve;
    let (count, one) = (FIELDS + 2, struck(place(47.05, 8.02, 1_500.0)));
    snapshot.flashes =
        (0..count).map(|i| FlashState { id: i as u64, intensity_cd: 1e9 * (i + 1) as f64, ..one.clone() }).collect();
    let plan = plan_of(&snapshot);
    assert_eq!(plan.lit.len(), FIELDS);
    // The brightest is 10, the first without a field 2: a fifth of its light is that of a point.
    assert!((plan.lit[0].placing.intensity_cd / 8e9 - 1.0).abs() < 1e-5);
    let points: f32 =
        plan.layers[0].layer.flash[..plan.layers[0].layer.flashes as usize].iter().map(|f| f.intensity).sum();
    let fields: f32 = plan.lit.iter().map(|f| f.placing.intensity_cd).sum();
    // Together they give all the light.
    assert!((points * 12.566_37 + fields) / 55e9 - 1.0 < 1e-4);
}

#[test]
fn flashes_minutes_apart_in_one_cloud_share_a_table_and_lie_where_they_are() {
    let mut snapshot = cumulus_at(place(47.0, 8.0, 500.0));
    snapshot.quality.relight = Lighting::Hybrid;
    let layer = &mut snapshot.weather.layers[0];
    (layer.wind_speed_mps, layer.wind_from_deg, layer.density) = (20.0, 250.0, 0.3);
    snapshot.flashes.push(struck(place(47.05, 8.02, 1_500.0)));
    let first = plan_of(&snapshot).lit.remove(0);
    assert!(first.request.patch.is_some() && first.request.method == Lighting::Hybrid);
    // Five minutes on: the wind has carried the cloud six kilometres; the next flash is in the same part of it.
    let axis = enu(&place(47.05, 8.02, 0.0));
    let (sin, cos) = 250.0_f64.to_radians().sin_cos();
    let carried = (axis.x_axis * -sin + axis.y_axis * -cos) * 6_000.0;
    let turn = DQuat::from_scaled_axis(axis.z_axis.cross(carried) / (MEAN_RADIUS_M + 1_000.0));
    let mut later = snapshot.clone();
    later.weather.layers[0].drift = turn;
    later.simulation_time_s += 300.0;
    let zenith = turn * axis.z_axis;
    let position = place(zenith.z.asin().to_degrees() + 0.001, zenith.y.atan2(zenith.x).to_degrees(), 1_400.0);
    later.flashes[0] = FlashState { begin_s: later.simulation_time_s, ..struck(position) };
    let second = plan_of(&later).lit.remove(0);
    let cloud = |lit: &LitFlash| Request { points: Vec::new(), ..(*lit.request).clone() };
    assert_eq!(cloud(&first), cloud(&second));
    assert_ne!(first.request.points, second.request.points);
    // A cloud elsewhere has its own.
    later.flashes[0] = struck(place(47.4, 8.5, 1_500.0));
    assert_ne!(cloud(&first), cloud(&plan_of(&later).lit[0]));
    // About the piece's middle or the flash's own ground point: the same place, but for steps of 10 m.
    snapshot.quality.relight = Lighting::Solve;
    let solved = plan_of(&snapshot).lit.remove(0);
    let middle = |lit: &LitFlash| -> [f32; 3] {
        let [east, north, up] = lit.placing.axes;
        std::array::from_fn(|k| {
            let at = |p: &Point| p.position_m[0] * east[k] + p.position_m[1] * north[k] + p.position_m[2] * up[k];
            lit.placing.origin_m[k] + lit.request.points.iter().map(|p| p.share * at(p)).sum::<f32>()
        })
    };
    let (a, b) = (middle(&first), middle(&solved));
    assert!((0..3).all(|k| (a[k] - b[k]).abs() < 8.0), "{a:?} {b:?}");
    // A table that is larger than all may be is not begun, nor that of a tower.
    let hybrid = Quality { relight: Lighting::Hybrid, ..snapshot.quality };
    for (basis_memory_mib, density) in [(1, 0.3), (256, 5.0)] {
        snapshot.quality = Quality { basis_memory_mib, ..hybrid };
        snapshot.weather.layers[0].density = density;
        let plan = plan_of(&snapshot);
        assert!(plan.lit[0].request.method == Lighting::Solve && plan.lit[0].request.patch.is_none());
        assert!(plan.notes.iter().any(|note| note.pass == "relight" && note.why.contains("by solve")));
    }
}

#[test]
fn a_table_is_of_the_region_that_was_struck_wherever_the_middle_of_its_piece_lies() {
    let mut snapshot = cumulus_at(place(47.0, 8.0, 500.0));
    snapshot.quality.relight = Lighting::Hybrid;
    snapshot.weather.layers.clear();
    // Two circles side by side, half a kilometre apart; the eye is far from both.
    let mut own = region(47.05, 8.02, 6_000.0, 300.0);
    let mut other = region(47.05, 8.02 + 0.092, 7_000.0, 300.0);
    own.weather.layers =
        vec![LayerState { density: 0.3, coverage: 1.0, ..layer(CloudKind::Stratocumulus, 1_000.0, 800.0) }];
    other.weather.layers =
        vec![LayerState { density: 0.3, coverage: 1.0, ..layer(CloudKind::Stratus, 1_000.0, 700.0) }];
    snapshot.regions = vec![other, own];
    let one = struck(place(47.05, 8.02, 1_400.0));
    let mut turned = 0;
    for step in 0..36 {
        // Degrees that are 700 m north and east.
        let (east, north) = (f64::from(step % 6) - 2.5, f64::from(step / 6) - 2.5);
        let position = place(47.05 + 0.0063 * north, 8.02 + 0.0092 * east, 1_400.0);
        snapshot.flashes = vec![FlashState { position, ..one.clone() }];
        let lit = plan_of(&snapshot).lit.remove(0);
        let (request, column) = (&lit.request, lit.request.layer.region as usize);
        assert!(request.kind == CloudKind::Stratocumulus && request.patch.is_some(), "{step}");
        // The outline that the layer is cut by is that of its own region, whichever number that has from there: a circle of 6 km.
        assert_eq!(request.layer.outline[column - 1].corner_m, 3_000.0, "{step}");
        // From the flash its own region is the first.
        turned += usize::from(column == 2);
    }
    assert!(turned > 0, "a middle of a piece lies nearer to the other region");
}
