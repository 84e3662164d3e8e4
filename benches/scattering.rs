//! Time of light in clouds on one thread, at the sizes of Dobashi et al. 2007: parts of a bake, sums, and a bolt by each method.

use criterion::{Criterion, criterion_group, criterion_main};
use std::collections::{BTreeMap, BTreeSet};
use std::hint::black_box;
use std::time::Duration;
use stormdeck::clouds::CloudKind;
use stormdeck::clouds::coverage::Coverage;
use stormdeck::numeric::haar::Haar;
use stormdeck::numeric::noise::fractal;
use stormdeck::scattering::basis::{Basis, Content, Recipe};
use stormdeck::scattering::compress::{Ambient, Sum};
use stormdeck::scattering::deck::Deck;
use stormdeck::scattering::lights::Lights;
use stormdeck::scattering::medium::Medium;
use stormdeck::scattering::ordinates::{Params, PointSource, Solver};
use stormdeck::scattering::phase::Phase;
use stormdeck::scattering::relight::{Method, Relighter};

/// A cloud of the paper's size, 32 x 32 x 4 cells of at most this optical depth, or of finer cells.
fn cloud(depth: f32, finer: usize) -> Medium {
    let cells = [32, 32, 4].map(|n| n * finer);
    let edge = 1.0 / finer as f64;
    let values = (0..cells.iter().product::<usize>())
        .map(|i| {
            let at = [i % cells[0], i / cells[0] % cells[1], i / (cells[0] * cells[1])];
            let [x, y, z] = at.map(|n| (n as f64 * edge) as f32);
            (0.4 + 0.8 * fractal(glam::Vec3::new(x / 4.0, y / 4.0, z / 2.0), [8, 8, 2], 3, 5)).clamp(0.0, 1.0) * depth
        })
        .collect();
    Medium::new(cells, [edge; 3], values, false).expect("a medium")
}

/// Stratocumulus that covers the sky, in cells of 500 m.
fn deck() -> Medium {
    let kind = CloudKind::Stratocumulus;
    let theta = Coverage::of(kind).threshold(1.0).typical;
    Deck { kind, theta, density: 1.0, thickness_m: 500.0 }.medium([32, 32, 4]).expect("a medium")
}

/// The paper's 2,800 lights.
fn recipe(medium: &Medium, content: Content) -> Recipe {
    // Droplets absorb next to nothing; the paper's cloud is compared at 0.99.
    let (albedo, below_m) = if medium.periodic { (0.9999, 1_000.0) } else { (0.99, 4.0) };
    let params = Params { phase: Phase::HenyeyGreenstein(0.85), albedo, tolerance: 1e-3, ..Params::default() };
    let lights = Lights::even([20, 20, 7], medium.size_m(), below_m, medium.periodic).expect("lights");
    Recipe { medium: medium.clone(), params, lights, content, packing: content.usual_packing() }
}

/// 200 points from inside the cloud to below it.
fn bolt() -> Vec<PointSource> {
    (0..200)
        .map(|i| {
            let t = f64::from(i) / 200.0;
            let position_m = [14.0 + 2.0 * (9.0 * t).sin(), 17.0 - 3.0 * t, 3.5 - 6.0 * t];
            PointSource { position_m, intensity: 0.005 }
        })
        .collect()
}

/// The bolt's weights on the lights (eq. 6).
fn weights(recipe: &Recipe) -> BTreeMap<usize, f32> {
    let mut weights = BTreeMap::new();
    for point in bolt() {
        for (light, share) in recipe.lights.shares(point.position_m).lights {
            *weights.entry(light).or_insert(0.0) += (share * point.intensity) as f32;
        }
    }
    weights
}

fn light(criterion: &mut Criterion) {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("the first pool");
    let mut group = criterion.benchmark_group("scattering");
    // Each takes long enough for ten to tell its spread.
    group.sample_size(10).warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(2));
    for depth in [1.0, 4.0, 16.0] {
        let params = Params { phase: Phase::HenyeyGreenstein(0.85), albedo: 0.99, ..Params::default() };
        let solver = Solver::new(&cloud(depth, 1), params).expect("a solver");
        let points: Vec<[PointSource; 1]> = (0..16)
            .map(|i| [PointSource { position_m: [8.3 + f64::from(i), 15.2, 1.1 + 0.1 * f64::from(i)], intensity: 1.0 }])
            .collect();
        let lanes: Vec<&[PointSource]> = points.iter().map(|p| &p[..]).collect();
        group.bench_function(format!("sixteen sources, depth {depth}"), |b| {
            b.iter(|| solver.solve(black_box(&lanes)).expect("solved"));
        });
    }
    for (name, medium, content, parts) in [
        ("32x32x4, total", cloud(1.0, 1), Content::Total, 175),
        ("32x32x4, diffuse", cloud(1.0, 1), Content::Diffuse, 175),
        ("64x64x8, diffuse", cloud(0.5, 2), Content::Diffuse, 175),
        ("stratocumulus of 32x32x4, diffuse", deck(), Content::Diffuse, 400),
    ] {
        let recipe = recipe(&medium, content);
        // From the middle, where the source lies in the cloud.
        let share = recipe.share(parts / 2, parts);
        group.bench_function(format!("bake, 1/{parts} of 2,800 lights, {name}"), |b| {
            b.iter(|| {
                let take = |_, block| {
                    black_box(block);
                    Ok::<(), ()>(())
                };
                recipe.bake(share.clone(), take).expect("baked");
            });
        });
    }
    for finer in [1, 2] {
        let recipe = recipe(&cloud(1.0 / finer as f32, finer), Content::Total);
        let [nx, ny, nz] = recipe.medium.cells;
        let weights = weights(&recipe);
        let basis = Basis::bake_for(recipe, &weights.keys().copied().collect()).expect("a basis");
        let haar = Haar::new(basis.recipe.medium.cells);
        group.bench_function(format!("weighted sum and inverse, published scheme, {nx}x{ny}x{nz}"), |b| {
            b.iter(|| {
                let mut sum = Sum::new(&haar, basis.recipe.components(), Ambient::Off);
                weights.iter().for_each(|(light, weight)| sum.add(&basis.blocks[*light], *weight));
                sum.fields()
            });
        });
    }
    let medium = cloud(1.0, 1);
    let [total, diffuse] = [Content::Total, Content::Diffuse].map(|content| {
        let recipe = recipe(&medium, content);
        let lights: BTreeSet<usize> = weights(&recipe).into_keys().collect();
        Basis::bake_for(recipe, &lights).expect("a basis")
    });
    let solver = Solver::new(&medium, total.recipe.params).expect("a solver");
    let relighter = Relighter::new(&medium, &solver);
    let bolt = bolt();
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
