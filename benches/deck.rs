//! The deck paper's own scenes: 1280x1024 pixels, 60 x 45 degrees, extents of 20 km and 90 km, the eye under, in and above
//! the deck; over coverage, slices, forms and executors. Groups are named by the adapter.
//!
//! All of it takes an hour on a machine without a graphics card. A filter runs a part, by executor and form, eye and scene:
//! `cargo bench --bench deck -- 'Marched/above/90 km, cover 0.4'`, `cargo bench --bench deck -- 'GPU.*32 slices'`.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::Duration;
use stormdeck::clouds::CloudKind;
use stormdeck::gpu::GpuExecutor;
use stormdeck::plan::executor::Executor;
use stormdeck::plan::{FramePlan, Output, plan};
use stormdeck::reference::ReferenceExecutor;
use stormdeck::world::command::{Command, Frustum, LayerSpec, Ownship, WeatherEdit};
use stormdeck::world::snapshot::{DeckForm, Quality};
use stormdeck::world::{DEFAULT_QUALITY, World};

/// What is varied.
#[derive(Clone, Copy)]
struct Scene {
    eye: &'static str,
    altitude_m: f64,
    pitch_deg: f64,
    extent_m: f32,
    coverage: f64,
    slices: u32,
    form: DeckForm,
}

const EYES: [(&str, f64, f64); 3] = [("under", 400.0, 10.0), ("in", 1_500.0, 0.0), ("above", 4_000.0, -12.0)];

/// The plan of a scene with a deck of stratocumulus between 1000 and 2000 m.
fn plan_of(scene: Scene) -> FramePlan {
    let mut world = World::new();
    world.set_quality(Quality { slices: scene.slices, deck_form: scene.form, ..DEFAULT_QUALITY });
    let ownship = Ownship {
        latitude_deg: 47.0,
        longitude_deg: 8.0,
        altitude_m: scene.altitude_m,
        yaw_deg: 70.0,
        pitch_deg: scene.pitch_deg,
        roll_deg: 0.0,
        velocity_ned_mps: None,
        host_frame: 0,
    };
    let layer = LayerSpec {
        kind: CloudKind::Stratocumulus,
        base_m: 1_000.0,
        thickness_m: 1_000.0,
        coverage: scene.coverage,
        density: 1.0,
        wind_speed_mps: 0.0,
        wind_from_deg: 0.0,
    };
    let weather = WeatherEdit { layers: Some(vec![layer]), ..Default::default() };
    for command in [Command::Ownship(ownship), Command::Weather(weather)] {
        world.apply(command).expect("a command of the bench is right");
    }
    let mut snapshot = world.snapshot(1.0 / 60.0);
    let view = &mut snapshot.views[0];
    // 60 x 45 degrees on 1280 x 1024: pixels are a little wider than high, as the paper's are.
    view.size_px = [1280, 1024];
    view.frustum = Some(Frustum { left_deg: -30.0, right_deg: 30.0, top_deg: 22.5, bottom_deg: -22.5 });
    let mut plan = plan(&snapshot, &snapshot.views[0], Output::Srgb8);
    for layer in &mut plan.layers {
        layer.layer.extent_m = layer.layer.extent_m.min(scene.extent_m);
        layer.layer.ring_last_m = layer.layer.ring_last_m.min(scene.extent_m);
    }
    plan
}

/// Scenes that change one thing at a time against coverage 0.6 and 32 slices.
fn scenes(form: DeckForm) -> Vec<Scene> {
    let mut scenes = Vec::new();
    for (eye, altitude_m, pitch_deg) in EYES {
        let usual = Scene { eye, altitude_m, pitch_deg, extent_m: 90_000.0, coverage: 0.6, slices: 32, form };
        scenes.extend([usual, Scene { extent_m: 20_000.0, ..usual }]);
        scenes.extend([0.2, 0.4, 0.8, 1.0].map(|coverage| Scene { coverage, ..usual }));
        scenes.extend([8, 16, 64, 128].map(|slices| Scene { slices, ..usual }));
    }
    scenes
}

fn decks(criterion: &mut Criterion) {
    let mut executors: Vec<(Box<dyn Executor>, &[DeckForm])> =
        vec![(Box::new(ReferenceExecutor::new()), &[DeckForm::Marched])];
    match GpuExecutor::new() {
        Ok(gpu) => executors.push((Box::new(gpu), &[DeckForm::Instanced, DeckForm::Marched])),
        Err(fault) => eprintln!("not timed on the GPU: {fault}"),
    }
    for (executor, forms) in &mut executors {
        // Criterion cuts names at some sixty characters: the adapter's own, without its driver's, and the scene have to fit.
        eprintln!("{}", executor.describe());
        let adapter: String = executor.describe().replace('/', "-").chars().take_while(|c| *c != '(').collect();
        let adapter = adapter.replace("executor on ", "");
        for form in forms.iter() {
            let mut group = criterion.benchmark_group(format!("{}, {form:?}", adapter.trim()));
            group.sample_size(10).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2));
            for scene in scenes(*form) {
                let plan = plan_of(scene);
                let Scene { eye, extent_m, coverage, slices, .. } = scene;
                let name = format!("{:.0} km, cover {coverage}, {slices} slices", extent_m / 1000.0);
                group.bench_function(BenchmarkId::new(eye, name), |bencher| {
                    bencher.iter(|| {
                        executor.submit(1, black_box(&plan)).expect("submitted");
                        executor.collect(true).expect("drawn")
                    });
                });
            }
            group.finish();
        }
    }
}

criterion_group!(benches, decks);
criterion_main!(benches);
