//! Light of flashes inside clouds in whole pictures: what is solved, and how often.

use super::super::*;
use crate::clouds::CloudKind;
use crate::passes::relight::Lighting;
use crate::plan::plan;
use crate::world::World;
use crate::world::command::{
    Command, LayerSpec, Ownship, StrikeRequest, StrokeSpec, Strokes, ViewAction, ViewEdit, WeatherEdit,
};
use crate::world::snapshot::Quality;
use crate::world::testing::{CUMULUS, EYE, STRIKE};
use std::collections::BTreeSet;

#[test]
fn a_flicker_of_twenty_frames_costs_as_many_fields_as_it_has_geometries() {
    let mut world = World::new();
    world.set_quality(Quality { relight: Lighting::Solve, ..world.peek(0.0).quality });
    let mut apply = |command| world.apply(command).map(|_| ()).expect("a command of a test");
    apply(Command::Ownship(Ownship { pitch_deg: 10.0, velocity_ned_mps: Some([90.0, 20.0, 0.0]), ..EYE }));
    let layer = LayerSpec {
        kind: CloudKind::Stratocumulus,
        thickness_m: 300.0,
        coverage: 1.0,
        density: 0.5,
        wind_speed_mps: 25.0,
        wind_from_deg: 240.0,
        ..CUMULUS
    };
    apply(Command::Weather(WeatherEdit { layers: Some(vec![layer]), ..Default::default() }));
    let stroke =
        |delay_s, ground_point_m| StrokeSpec { delay_s, peak_current_ka: 20.0, continuing_s: None, ground_point_m };
    apply(Command::Strike(StrikeRequest {
        altitude_m: Some(1_200.0),
        peak_current_ka: None,
        // Two ground points: the first with its branches, then the channel alone; the second with its branches.
        strokes: Strokes::Given(vec![
            stroke(0.0, None),
            stroke(0.05, None),
            stroke(0.12, Some([1_500.0, 0.0])),
            stroke(0.2, Some([0.0, 0.0])),
        ]),
        seed: 5,
        ..STRIKE
    }));
    apply(Command::View(ViewEdit {
        action: ViewAction::Change,
        name: "main".into(),
        size_px: Some([16, 16]),
        ..Default::default()
    }));
    let mut executor = ReferenceExecutor::new();
    let (mut frames, mut geometries) = (0, BTreeSet::new());
    for frame in 0..20 {
        world.advance_to(f64::from(frame) / 60.0);
        let snapshot = world.snapshot(1.0 / 60.0);
        let lights = snapshot.flashes.iter().flat_map(|flash| &flash.lights).filter(|light| light.amount > 0.0);
        geometries.extend(lights.map(|light| (light.channel, light.branches)));
        let plan = plan(&snapshot, &snapshot.views[0], Output::LinearRgb);
        frames += usize::from(!plan.lit.is_empty());
        executor.draw(&plan);
        assert!(!executor.provisional);
    }
    assert!(frames >= 8 && geometries.len() >= 3, "there is a flicker: {frames} frames, {geometries:?}");
    assert_eq!(executor.fields.solved(), geometries.len());
}
