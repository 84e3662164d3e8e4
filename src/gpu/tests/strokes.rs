//! Lightning's passes against their twins: what strokes add to a picture, alone; and shaders made wrong.

use super::scene::change;
use super::*;
use crate::plan::plan;
use crate::world::World;
use crate::world::command::{Command, FlashKind, LayerSpec, Ownship, StrikeRequest, ViewEdit, WeatherEdit};
use crate::world::testing::{CUMULUS, EYE, NIGHT, STRIKE};

/// A night under cumulus with a strike to ground to the north; the eye looks there.
#[derive(Clone, Copy)]
struct Bolt {
    coverage: f64,
    eye_m: f64,
    pitch_deg: f64,
    /// North of the eye, degrees of latitude.
    away_deg: f64,
    kind: FlashKind,
    visibility_m: f64,
}

const OPEN: Bolt = Bolt {
    coverage: 0.4,
    eye_m: 700.0,
    pitch_deg: 10.0,
    away_deg: 0.03,
    kind: FlashKind::CloudToGround,
    visibility_m: 12_000.0,
};

impl Bolt {
    fn plan(&self) -> FramePlan {
        let mut world = World::new();
        let mut apply = |command| world.apply(command).map(|_| ()).expect("a command of a test");
        let (altitude_m, pitch_deg) = (self.eye_m, self.pitch_deg);
        apply(Command::Ownship(Ownship { altitude_m, yaw_deg: 3.0, pitch_deg, roll_deg: 4.0, ..EYE }));
        apply(NIGHT);
        let layer = LayerSpec { thickness_m: 1500.0, coverage: self.coverage, ..CUMULUS };
        apply(Command::Weather(WeatherEdit {
            layers: Some(vec![layer]),
            visibility_m: Some(self.visibility_m),
            ..Default::default()
        }));
        apply(Command::Strike(StrikeRequest {
            latitude_deg: 47.0 + self.away_deg,
            altitude_m: Some(2_500.0),
            kind: self.kind,
            ..STRIKE
        }));
        apply(Command::View(ViewEdit { name: "main".into(), size_px: Some([160, 90]), ..change() }));
        let snapshot = world.snapshot(1.0 / 60.0);
        plan(&snapshot, &snapshot.views[0], Output::LinearRgb)
    }
}

/// What the strokes of a plan add to its picture.
fn added(executor: &mut dyn Executor, plan: &FramePlan) -> Pixels {
    let without = FramePlan { strokes: None, ..plan.clone() };
    let (Pixels::LinearRgb(on), Pixels::LinearRgb(off)) = (draw(executor, plan), draw(executor, &without)) else {
        panic!("linear pictures are compared")
    };
    Pixels::LinearRgb(on.iter().zip(&off).map(|(on, off)| on - off).collect())
}

fn apart(name: &str, gpu: &mut GpuExecutor, bolt: Bolt) -> f32 {
    let plan = bolt.plan();
    assert!(plan.strokes.is_some(), "{name}: a bolt is to be seen");
    let (drawn, twin) = (added(gpu, &plan), added(&mut ReferenceExecutor::new(), &plan));
    let (mean, largest, beyond) = difference(&drawn, &twin, 0.05);
    println!("{name}: mean {mean:.5}, largest {largest:.3}, beyond 5 %: {beyond:.4}");
    mean
}

#[test]
#[cfg_attr(not(gpu_tests), ignore = "no graphics adapter")]
fn strokes_equal_their_twins() {
    let mut gpu = gpu();
    let scenes = [
        ("in the open", OPEN),
        ("near, no cloud", Bolt { coverage: 0.0, away_deg: 0.006, ..OPEN }),
        ("behind cloud, from above", Bolt { coverage: 0.7, eye_m: 4_000.0, pitch_deg: -25.0, ..OPEN }),
        ("far", Bolt { away_deg: 0.3, pitch_deg: 1.0, visibility_m: 60_000.0, ..OPEN }),
        ("between clouds", Bolt { kind: FlashKind::CloudToCloud, coverage: 0.2, pitch_deg: 30.0, ..OPEN }),
    ];
    for (name, bolt) in scenes {
        let mean = apart(name, &mut gpu, bolt);
        // Half floats: 2^-11 each time a stretch is added to a pixel and each level of the glow is written; the deck's looks
        // are filtered with weights of 8 bits, which moves the veil at the edges of clouds.
        assert!(mean < 0.01, "{name}: {mean}");
    }
}

#[test]
#[cfg_attr(not(gpu_tests), ignore = "no graphics adapter")]
fn a_wrong_shader_of_lightning_is_noticed() {
    let mut gpu = gpu();
    let hidden = Bolt { coverage: 0.7, eye_m: 4_000.0, pitch_deg: -25.0, ..OPEN };
    for (module, right, wrong, bolt) in [
        ("stroke", "segment.light * profile", "1.1 * segment.light * profile", OPEN),
        ("stroke", "0.5641896 * unit * exp(-h * h", "0.5641896 * unit * exp(-1.3 * h * h", OPEN),
        ("veil", "depth += layer.extinction_per_m *", "depth += 0.2 * layer.extinction_per_m *", hidden),
        ("airlight", "source.intensity_cd / d", "1.5 * source.intensity_cd / d", OPEN),
        ("glow", "spread(here)) * glow.gain", "5.0 * spread(here)) * glow.gain", OPEN),
        ("glow", "0.375 * (fine_at", "0.9 * (fine_at", OPEN),
    ] {
        gpu.pipelines = broken(&gpu, module, right, wrong);
        let mean = apart(&format!("{module} made wrong"), &mut gpu, bolt);
        assert!(mean > 0.02, "{module} with {wrong:?} differs by {mean} only");
    }
}

#[test]
fn a_flash_gives_a_picture_the_same_light_at_24_60_and_120_hz() {
    // Each value is rounded to f16, by 2^-12 of itself at random, and thousands of them are summed.
    crate::reference::tests::strokes::the_same_light_at_all_rates(&mut gpu(), 1e-3);
}
