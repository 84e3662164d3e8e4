//! Light of flashes inside clouds against its twin: what fields add to a picture, alone; and shaders made wrong.

use super::scene::change;
use super::*;
use crate::clouds::CloudKind;
use crate::passes::relight::Lighting;
use crate::plan::plan;
use crate::world::World;
use crate::world::command::{Command, FlashKind, LayerSpec, Ownship, StrikeRequest, ViewEdit, WeatherEdit};
use crate::world::snapshot::Quality;
use crate::world::testing::{CUMULUS, EYE, NIGHT, STRIKE};

/// A night under, in or above a layer with a strike to ground to the north; the eye looks there.
#[derive(Clone, Copy)]
struct Lit {
    coverage: f64,
    eye_m: f64,
    pitch_deg: f64,
    form: DeckForm,
    kind: FlashKind,
}

const UNDER: Lit =
    Lit { coverage: 0.95, eye_m: 400.0, pitch_deg: 8.0, form: DeckForm::Marched, kind: FlashKind::CloudToGround };

impl Lit {
    fn plan(&self) -> FramePlan {
        let mut world = World::new();
        let quality = Quality { relight: Lighting::Solve, deck_form: self.form, ..world.peek(0.0).quality };
        world.set_quality(quality);
        let mut apply = |command| world.apply(command).map(|_| ()).expect("a command of a test");
        let (altitude_m, pitch_deg) = (self.eye_m, self.pitch_deg);
        apply(Command::Ownship(Ownship { altitude_m, yaw_deg: 3.0, pitch_deg, roll_deg: 4.0, ..EYE }));
        apply(NIGHT);
        let layer = LayerSpec {
            kind: CloudKind::Stratocumulus,
            thickness_m: 700.0,
            coverage: self.coverage,
            density: 0.7,
            ..CUMULUS
        };
        // A higher layer is lit by what comes out of the lower one.
        let high =
            LayerSpec { kind: CloudKind::Altocumulus, base_m: 3500.0, thickness_m: 400.0, coverage: 0.4, ..layer };
        apply(Command::Weather(WeatherEdit { layers: Some(vec![layer, high]), ..Default::default() }));
        apply(Command::Strike(StrikeRequest {
            latitude_deg: 47.03,
            longitude_deg: 8.01,
            altitude_m: Some(1_400.0),
            kind: self.kind,
            ..STRIKE
        }));
        apply(Command::View(ViewEdit { name: "main".into(), size_px: Some([160, 90]), ..change() }));
        let snapshot = world.snapshot(1.0 / 60.0);
        plan(&snapshot, &snapshot.views[0], Output::LinearRgb)
    }
}

/// What the fields of a plan add to its picture.
fn added(executor: &mut dyn Executor, plan: &FramePlan) -> Pixels {
    let without = FramePlan { lit: Vec::new(), ..plan.clone() };
    let (Pixels::LinearRgb(on), Pixels::LinearRgb(off)) = (draw(executor, plan), draw(executor, &without)) else {
        panic!("linear pictures are compared")
    };
    Pixels::LinearRgb(on.iter().zip(&off).map(|(on, off)| on - off).collect())
}

fn apart(name: &str, gpu: &mut GpuExecutor, scene: Lit) -> (f32, f32) {
    // The channel itself is a hundred times brighter than what it lights.
    let plan = FramePlan { strokes: None, ..scene.plan() };
    assert!(!plan.lit.is_empty(), "{name}: there is a field");
    let (drawn, twin) = (added(gpu, &plan), added(&mut ReferenceExecutor::new(), &plan));
    let (mean, largest, beyond) = difference(&drawn, &twin, 0.05);
    println!("{name}: mean {mean:.5}, largest {largest:.3}, beyond 5 %: {beyond:.4}");
    (mean, beyond)
}

#[test]
#[cfg_attr(not(gpu_tests), ignore = "no graphics adapter")]
fn light_inside_clouds_equals_its_twin() {
    let mut gpu = gpu();
    let scenes = [
        ("under", UNDER),
        ("under, instanced", Lit { form: DeckForm::Instanced, ..UNDER }),
        ("inside", Lit { eye_m: 1_300.0, pitch_deg: 0.0, ..UNDER }),
        ("between", Lit { eye_m: 2_500.0, pitch_deg: 3.0, ..UNDER }),
        ("above", Lit { eye_m: 6_000.0, pitch_deg: -35.0, ..UNDER }),
        ("broken, inside the cloud", Lit { coverage: 0.6, kind: FlashKind::IntraCloud, ..UNDER }),
        ("ground", Lit { pitch_deg: -20.0, ..UNDER }),
    ];
    for (name, scene) in scenes {
        let (mean, beyond) = apart(name, &mut gpu, scene);
        // As for the deck itself, twice: the picture without fields is taken off. Quotients are half floats (0.05 %) and are
        // read with weights of 8 bits, a 256th of the difference between cells.
        assert!(mean < 0.01, "{name}: {mean}");
        assert!(beyond < 0.06, "{name}: {beyond}");
    }
}

#[test]
#[cfg_attr(not(gpu_tests), ignore = "no graphics adapter")]
fn a_wrong_shader_of_light_inside_clouds_is_noticed() {
    let mut gpu = gpu();
    let ground = Lit { pitch_deg: -20.0, ..UNDER };
    let above = Lit { eye_m: 2_500.0, pitch_deg: 20.0, ..UNDER };
    for (module, right, wrong, scene) in [
        ("march", "quotient = max(found.x + dot(found.yzw, d), 0.0)", "quotient = max(found.x, 0.0)", UNDER),
        ("march", "share / (dot(away, away) + lits.lit[i].cap_m2)", "share / dot(away, away)", UNDER),
        (
            "march",
            "clamp(level * levels, 0.5, levels - 0.5)",
            "clamp((1.0 - level) * levels, 0.5, levels - 0.5)",
            UNDER,
        ),
        ("march", "let wide = square + 2.0 * spread", "let wide = square + spread", above),
        ("ground", "let wide = square + 2.0 * spread", "let wide = square + spread", ground),
    ] {
        gpu.pipelines = broken(&gpu, module, right, wrong);
        let (mean, _) = apart(&format!("{module} made wrong"), &mut gpu, scene);
        assert!(mean > 0.02, "{module} with {wrong:?} differs by {mean} only");
    }
}
