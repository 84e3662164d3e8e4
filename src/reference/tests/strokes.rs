//! Pictures of a flash at three rates hold the same light.

use super::*;
use crate::lightning::flash::StrokeSpec;
use crate::world::World;
use crate::world::command::{
    Command, Exposure, LayerSpec, Ownship, StrikeRequest, Strokes, ViewAction, ViewEdit, WeatherEdit,
};
use crate::world::testing::{CUMULUS, EYE, NIGHT, STRIKE};

/// A night 4 km south of where it strikes, under broken cumulus that stands still.
fn night(strike: bool) -> World {
    let mut world = World::new();
    let mut apply = |command| world.apply(command).map(|_| ()).expect("a command of a test");
    apply(Command::Ownship(Ownship { pitch_deg: 8.0, ..EYE }));
    apply(NIGHT);
    let layer = LayerSpec { base_m: 1_200.0, wind_speed_mps: 0.0, ..CUMULUS };
    apply(Command::Weather(WeatherEdit { layers: Some(vec![layer]), ..Default::default() }));
    apply(Command::View(ViewEdit {
        action: ViewAction::Change,
        name: "main".into(),
        size_px: Some([48, 27]),
        exposure: Some(Exposure::Ev100(2.0)),
        ..Default::default()
    }));
    if strike {
        let stroke = |delay_s, peak_current_ka| StrokeSpec {
            delay_s,
            peak_current_ka,
            continuing_s: Some(0.0),
            ground_point_m: None,
        };
        apply(Command::Strike(StrikeRequest {
            latitude_deg: 47.036,
            peak_current_ka: None,
            strokes: Strokes::Given(vec![stroke(0.013, 30.0), stroke(0.061, 14.0)]),
            seed: 5,
            ..STRIKE
        }));
    }
    world
}

fn linear(executor: &mut dyn Executor, world: &mut World, shutter_s: f64) -> Vec<f32> {
    let snapshot = world.snapshot(shutter_s);
    executor.submit(1, &plan(&snapshot, &snapshot.views[0], Output::LinearRgb)).expect("submitted");
    let Pixels::LinearRgb(values) = executor.collect(true).expect("drawn").remove(0).pixels else {
        panic!("not linear")
    };
    values
}

/// Light of a flash in its pictures at a rate, over all of its frames: (flash on minus off) times the interval, and how many
/// frames it shows in.
fn light(executor: &mut dyn Executor, rate_hz: u32) -> (f64, u32) {
    let off = linear(executor, &mut night(false), 1.0 / 60.0);
    let mut world = night(true);
    let (mut sum, mut lit) = (0.0, 0);
    // Two strokes of 24 ms each are over after 85 ms.
    for frame in 0..rate_hz / 8 {
        world.advance_to(f64::from(frame) / f64::from(rate_hz));
        let on = linear(executor, &mut world, 1.0 / f64::from(rate_hz));
        let more: f64 = on.iter().zip(&off).map(|(on, off)| f64::from(on - off)).sum();
        sum += more / f64::from(rate_hz);
        lit += u32::from(more > 0.0);
    }
    (sum, lit)
}

/// Holds an executor to it that 24, 60 and 120 Hz give a flash the same light, to a share of `apart`.
pub(crate) fn the_same_light_at_all_rates(executor: &mut dyn Executor, apart: f64) {
    let [(slow, few), (usual, _), (fast, many)] = [24, 60, 120].map(|rate_hz| light(executor, rate_hz));
    assert!(few >= 2 && many > few && slow > 0.0);
    for other in [slow, fast] {
        assert!((other / usual - 1.0).abs() < apart, "{slow} {usual} {fast}");
    }
}

#[test]
fn a_flash_gives_a_picture_the_same_light_at_24_60_and_120_hz() {
    // What is drawn is in proportion to the light in the interval, the intervals abut, and f32 rounds.
    the_same_light_at_all_rates(&mut ReferenceExecutor::new(), 1e-3);
}
