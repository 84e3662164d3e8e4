//! Time of whole bolts, tables of the grid included unless said, and ratios against slow forms kept here.
//!
//! The slow forms are honest: conjugate gradients with incomplete Cholesky and a warm start for the breakdown model, and for the
//! rational potential the plain incremental program that one writes from the paper (powers, sums over the ring, a linear scan).

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};
use stormdeck::lightning::grid::{Grid, Neighbours};
use stormdeck::lightning::grow::{Method, grow};
use stormdeck::lightning::laplacian::DEFAULT_PULL;
use stormdeck::lightning::random::Stream;
use stormdeck::lightning::rational::Arithmetic;
use stormdeck::lightning::scene::Scene;
use stormdeck::lightning::tables::Tables;

fn cells(method: &Method, scene: &Scene, most: u32, seed: u64, tables: &mut Tables) -> u32 {
    let (_, info) = grow(method, scene, most, seed, tables, &AtomicBool::new(false)).expect("a right scene");
    info.cells
}

fn plane(side: u32) -> Grid {
    Grid::plane(side, side).expect("a grid")
}

fn bolts(criterion: &mut Criterion) {
    let volume = Scene::top_to_bottom(Grid::volume(64, 64, 64).expect("a grid"));
    let cases = [
        ("rational 128x128 eta 3 rho 3", Method::rational(3.0, 3.0), Scene::top_to_bottom(plane(128)), u32::MAX),
        (
            "rational 128x128 eta 3 rho 3, f64",
            Method::Rational { eta: 3.0, rho: 3.0, arithmetic: Arithmetic::Double },
            Scene::top_to_bottom(plane(128)),
            u32::MAX,
        ),
        ("rational 64x64x64 eta 2 rho 3", Method::rational(2.0, 3.0), volume.clone(), u32::MAX),
        ("rational 512x512 eta 2 rho 3, 5000 cells", Method::rational(2.0, 3.0), Scene::free(plane(512)), 5000),
        ("flg 512x512 eta 2, 5000 cells", Method::laplacian(2.0, DEFAULT_PULL), Scene::free(plane(512)), 5000),
        ("dbm 128x128 eta 2", Method::Dielectric { eta: 2.0 }, Scene::top_to_bottom(plane(128)), u32::MAX),
        ("dbm 64x64x64 eta 3", Method::Dielectric { eta: 3.0 }, volume, u32::MAX),
    ];
    let mut group = criterion.benchmark_group("bolt");
    group.sample_size(20).measurement_time(Duration::from_secs(2)).warm_up_time(Duration::from_millis(300));
    for (name, method, scene, most) in &cases {
        let exact = matches!(method, Method::Dielectric { .. });
        let mut kept = Tables::default();
        if exact {
            // The table of the Green's function is kept, as a caller keeps it from bolt to bolt.
            black_box(cells(method, scene, 1, 0, &mut kept));
        }
        let mut seed = 0;
        group.bench_function(*name, |bencher| {
            bencher.iter_batched(
                || {
                    seed += 1;
                    (seed, if exact { kept.clone() } else { Tables::default() })
                },
                |(seed, mut tables)| cells(method, scene, *most, seed, &mut tables),
                BatchSize::PerIteration,
            );
        });
    }
    group.finish();
}

/// Medians of the same seeds, one after another in one run, as "fast, slow, ratio".
fn ratios(_: &mut Criterion) {
    let scene = Scene::top_to_bottom(plane(128));
    let mut tables = Tables::default();
    let exact = Method::Dielectric { eta: 2.0 };
    cells(&exact, &scene, 1, 0, &mut tables);
    let conjugate = Method::DielectricConjugate { eta: 2.0, tolerance: 1e-6 };
    let fast = median(9, |seed| cells(&exact, &scene, u32::MAX, seed, &mut tables));
    let slow = median(3, |seed| cells(&conjugate, &scene, u32::MAX, seed, &mut Tables::default()));
    tell("dbm 128x128 eta 2: Green's function against conjugate gradients at 1e-6", fast, slow);
    let rational = Method::rational(3.0, 3.0);
    let fast = median(21, |seed| cells(&rational, &scene, u32::MAX, seed, &mut Tables::default()));
    let slow = median(9, |seed| plain_rational(&scene, 3.0, 3.0, seed));
    tell("rational 128x128 eta 3 rho 3: against the plain incremental form", fast, slow);
}

fn median(runs: u64, mut bolt: impl FnMut(u64) -> u32) -> (Duration, f64) {
    let mut times = Vec::new();
    let mut all_cells = 0;
    for seed in 0..runs {
        let begin = Instant::now();
        all_cells += black_box(bolt(seed));
        times.push(begin.elapsed());
    }
    times.sort_unstable();
    (times[times.len() / 2], f64::from(all_cells) / runs as f64)
}

fn tell(what: &str, (fast, fast_cells): (Duration, f64), (slow, slow_cells): (Duration, f64)) {
    let ratio = slow.as_secs_f64() / fast.as_secs_f64();
    println!("{what}: {fast:.2?} ({fast_cells:.0} cells) against {slow:.2?} ({slow_cells:.0} cells), {ratio:.0} times");
}

/// The rational potential in a plane as one writes it down: sums kept per candidate, everything else plain.
fn plain_rational(scene: &Scene, eta: f64, rho: f64, seed: u64) -> u32 {
    struct Candidate {
        at: [i32; 2],
        constant: f64,
        sum: f64,
    }
    let [nx, ny, _] = scene.grid.size().map(|side| side as i32);
    let steps = Neighbours::All.steps(2);
    let place = |cell| scene.grid.position(cell).map(|p| p as i32);
    let ([sx, sy, _], [tx, ty, _]) = (place(scene.start), place(scene.targets()[0]));
    let pull = |a: [i32; 2], b: [i32; 2]| f64::from((a[0] - b[0]).pow(2) + (a[1] - b[1]).pow(2)).powf(-0.5 * rho);
    let ring: Vec<[i32; 2]> = (-1..=nx)
        .flat_map(|x| (-1..=ny).map(move |y| [x, y]))
        .filter(|&[x, y]| x < 0 || y < 0 || x == nx || y == ny)
        .collect();
    let mut seen = vec![false; (nx * ny) as usize];
    let mut grown = vec![[sx, sy]];
    seen[(sx + nx * sy) as usize] = true;
    let mut candidates: Vec<Candidate> = Vec::new();
    let mut stream = Stream::new(seed, 0);
    loop {
        let tip = grown[grown.len() - 1];
        if (tip[0] - tx).abs() <= 1 && (tip[1] - ty).abs() <= 1 {
            return grown.len() as u32;
        }
        for candidate in &mut candidates {
            candidate.sum += pull(candidate.at, tip);
        }
        for step in &steps {
            let at = [tip[0] + step[0], tip[1] + step[1]];
            if (0..nx).contains(&at[0]) && (0..ny).contains(&at[1]) && !seen[(at[0] + nx * at[1]) as usize] {
                seen[(at[0] + nx * at[1]) as usize] = true;
                let border: f64 = ring.iter().map(|&wall| pull(at, wall)).sum();
                let sum = grown.iter().map(|&charge| pull(at, charge)).sum();
                candidates.push(Candidate { at, constant: pull(at, [tx, ty]) / border, sum });
            }
        }
        let weights: Vec<f64> = candidates.iter().map(|c| (c.constant / c.sum).powf(eta)).collect();
        let mut left = stream.unit() * weights.iter().sum::<f64>();
        let chosen = weights.iter().position(|weight| {
            left -= weight;
            left < 0.0
        });
        grown.push(candidates.swap_remove(chosen.unwrap_or(candidates.len() - 1)).at);
    }
}

criterion_group!(benches, bolts, ratios);
criterion_main!(benches);
