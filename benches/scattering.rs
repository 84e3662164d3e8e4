//! Time of light in clouds: one batch of a bake, and a bolt by each method, on one thread, at the sizes of Dobashi et al. 2007.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use stormdeck::numeric::noise::fractal;
use stormdeck::scattering::basis::{Basis, Content, Recipe, USUAL_PACKING};
use stormdeck::scattering::lights::Lights;
use stormdeck::scattering::medium::Medium;
use stormdeck::scattering::ordinates::{Params, PointSource, Solver};
use stormdeck::scattering::phase::Phase;
use stormdeck::scattering::relight::{Method, Relighter};

/// A cloud of 32 x 32 x 4 cells of at most this optical depth.
fn cloud(depth: f32) -> Medium {
    let values = (0..4096)
        .map(|i| {
            let at = glam::Vec3::new((i % 32) as f32 / 4.0, (i / 32 % 32) as f32 / 4.0, (i / 1024) as f32 / 2.0);
            (0.4 + 0.8 * fractal(at, [8, 8, 2], 3, 5)).clamp(0.0, 1.0) * depth
        })
        .collect();
    Medium::new([32, 32, 4], [1.0; 3], values, false).expect("a medium")
}

fn light(criterion: &mut Criterion) {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("the first pool");
    let mut group = criterion.benchmark_group("scattering");
    group.sample_size(10);
    for depth in [1.0, 4.0, 16.0] {
        let params = Params { phase: Phase::HenyeyGreenstein(0.85), albedo: 0.99, ..Params::default() };
        let solver = Solver::new(&cloud(depth), params).expect("a solver");
        let points: Vec<[PointSource; 1]> = (0..16)
            .map(|i| [PointSource { position_m: [8.3 + f64::from(i), 15.2, 1.1 + 0.1 * f64::from(i)], intensity: 1.0 }])
            .collect();
        let lanes: Vec<&[PointSource]> = points.iter().map(|p| &p[..]).collect();
        group.bench_function(format!("sixteen sources, depth {depth}"), |b| {
            b.iter(|| solver.solve(black_box(&lanes)).expect("solved"));
        });
    }
    let medium = cloud(1.0);
    let params = Params { phase: Phase::HenyeyGreenstein(0.85), albedo: 0.99, tolerance: 1e-3, ..Params::default() };
    let lights = Lights::even([8, 8, 4], medium.size_m(), 4.0, false).expect("lights");
    let [total, diffuse] = [Content::Total, Content::Diffuse].map(|content| {
        let recipe = Recipe { medium: medium.clone(), params, lights: lights.clone(), content, packing: USUAL_PACKING };
        Basis::bake(recipe).expect("a basis")
    });
    let solver = Solver::new(&medium, params).expect("a solver");
    let relighter = Relighter::new(&medium, &solver);
    let bolt: Vec<PointSource> = (0..200)
        .map(|i| {
            let t = f64::from(i) / 200.0;
            let position_m = [14.0 + 2.0 * (9.0 * t).sin(), 17.0 - 3.0 * t, 3.5 - 6.0 * t];
            PointSource { position_m, intensity: 0.005 }
        })
        .collect();
    for method in [Method::Point, Method::Single, Method::Basis, Method::Hybrid, Method::Solve] {
        let table = match method.table() {
            Some(Content::Total) => Some(&total),
            Some(Content::Diffuse) => Some(&diffuse),
            None => None,
        };
        group.bench_function(format!("bolt, {}", method.name()), |b| {
            b.iter(|| relighter.relight(method, black_box(&bolt), table).expect("lit"));
        });
    }
    group.finish();
}

criterion_group!(benches, light);
criterion_main!(benches);
