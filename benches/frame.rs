//! Time of whole frames at 640x360 with one deck of 32 slices, on both executors and, on a
//! GPU, in both forms of the deck: below, above and inside it.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use stormdeck::clouds::CloudKind;
use stormdeck::gpu::GpuExecutor;
use stormdeck::plan::executor::Executor;
use stormdeck::plan::{FramePlan, Output, plan};
use stormdeck::reference::ReferenceExecutor;
use stormdeck::world::World;
use stormdeck::world::command::{Command, LayerSpec, Ownship, WeatherEdit};
use stormdeck::world::snapshot::{DeckForm, Quality};

/// The plan of a frame of broken cumulus between 1000 and 2200 m from an altitude.
fn scene(altitude_m: f64, pitch_deg: f64, deck_form: DeckForm) -> FramePlan {
    let mut world = World::new();
    let quality = world.peek(0.0).quality;
    world.set_quality(Quality { deck_scale: 2, deck_form, ..quality });
    let ownship = Ownship {
        latitude_deg: 47.0,
        longitude_deg: 8.0,
        altitude_m,
        yaw_deg: 70.0,
        pitch_deg,
        roll_deg: 0.0,
        velocity_ned_mps: None,
        host_frame: 0,
    };
    let layer = LayerSpec {
        kind: CloudKind::Cumulus,
        base_m: 1000.0,
        thickness_m: 1200.0,
        coverage: 0.6,
        density: 1.0,
        wind_speed_mps: 0.0,
        wind_from_deg: 0.0,
    };
    let weather = WeatherEdit { layers: Some(vec![layer]), ..Default::default() };
    for command in [Command::Ownship(ownship), Command::Weather(weather)] {
        world.apply(command).expect("a command of the bench is right");
    }
    let snapshot = world.snapshot(1.0 / 60.0);
    plan(&snapshot, &snapshot.views[0], Output::Srgb8)
}

fn frames(criterion: &mut Criterion) {
    let mut executors: Vec<(&str, DeckForm, Box<dyn Executor>)> =
        vec![("reference", DeckForm::Auto, Box::new(ReferenceExecutor::new()))];
    for (name, form) in [("gpu, marched", DeckForm::Marched), ("gpu, instanced", DeckForm::Instanced)] {
        match GpuExecutor::new() {
            Ok(gpu) => executors.push((name, form, Box::new(gpu))),
            Err(fault) => eprintln!("not timed on the GPU: {fault}"),
        }
    }
    for (name, form, executor) in &mut executors {
        println!("{}", executor.describe());
        let mut group = criterion.benchmark_group(*name);
        group.sample_size(20);
        for (place, altitude_m, pitch_deg) in [("below", 500.0, 5.0), ("above", 6000.0, -8.0), ("inside", 1500.0, 0.0)]
        {
            let plan = scene(altitude_m, pitch_deg, *form);
            group.bench_function(place, |bencher| {
                bencher.iter(|| {
                    executor.submit(1, black_box(&plan)).expect("submitted");
                    executor.collect(true).expect("drawn")
                });
            });
        }
        group.finish();
    }
}

criterion_group!(benches, frames);
criterion_main!(benches);
