//! Subject `relight`: time and error of every way of lighting a cloud by a bolt, against one exact solve per bolt.

mod pictures;

use super::lit_cloud::{bolt, cloud, failed, relative_f32};
use super::result::Case;
use super::subject::{Run, Stopped, Subject};
use super::timing::measure;
use crate::clouds::CloudKind;
use crate::clouds::coverage::Coverage;
use crate::scattering::basis::{Basis, Content, Recipe};
use crate::scattering::compress::{Packing, Width};
use crate::scattering::deck::Deck;
use crate::scattering::lights::Lights;
use crate::scattering::medium::Medium;
use crate::scattering::ordinates::{Params, PointSource, Solver};
use crate::scattering::phase::Phase;
use crate::scattering::relight::{Method, Relighter, Relit};
use std::collections::BTreeSet;

/// Bolts in clouds.
pub const SUBJECT: Subject = Subject {
    name: "relight",
    about: "light of a bolt in a cloud by every method, against one solve with every point for itself",
    measure: cases,
};

/// Seed points of the paper's bolts (its figures 6 and 7).
const SEEDS: [usize; 4] = [1, 2, 3, 5];

fn cases(run: &mut Run) -> Result<(), Stopped> {
    let medium = cloud([32, 32, 4], [1.0; 3], 1.0)?;
    let bases = bake(run, &medium)?;
    let solver = Solver::new(&medium, Params { tolerance: 1e-5, ..params() }).map_err(failed)?;
    let relighter = Relighter::new(&medium, &solver);
    for seeds in SEEDS {
        let bolts: Vec<_> = (0..run.pick(1, 8)).map(|seed| bolt(medium.size_m(), seeds, seed)).collect();
        methods(run, &format!("bolts of {seeds} seed points"), &relighter, &bolts, &bases)?;
        pictures::compare(run, &medium, &relighter, &bases, seeds)?;
    }
    let bolts: Vec<_> = (0..run.pick(1, 8)).map(|seed| bolt(medium.size_m(), 1, seed)).collect();
    spacings(run, &relighter, &bolts, &bases)?;
    if run.quick() {
        return Ok(());
    }
    larger_bakes(run)?;
    dense(run, &medium, &relighter, &bolts)?;
    deeper(run)
}

fn params() -> Params {
    Params { phase: Phase::HenyeyGreenstein(0.85), albedo: 0.99, tolerance: 1e-3, ..Params::default() }
}

/// Both tables of the paper's size, baked on every number of threads that halves to one.
fn bake(run: &mut Run, medium: &Medium) -> Result<[Basis; 2], Stopped> {
    let counts = run.pick([4, 4, 3], [20, 20, 7]);
    let lights = Lights::even(counts, medium.size_m(), 4.0, false).map_err(failed)?;
    let recipe = |content| Recipe {
        medium: medium.clone(),
        params: params(),
        lights: lights.clone(),
        content,
        packing: content.usual_packing(),
    };
    let mut threads = rayon::current_num_threads();
    let mut counts = vec![threads];
    while threads > 1 {
        threads /= 2;
        counts.push(threads);
    }
    let mut made = Vec::new();
    for content in [Content::Total, Content::Diffuse] {
        let mut last = None;
        for threads in &counts {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(*threads).build().map_err(failed)?;
            let (basis, time_s) = measure(1, || pool.install(|| Basis::bake(recipe(content))));
            let basis = basis.map_err(failed)?;
            let case = Case::new("bake", format!("{content:?}, {threads} threads"))
                .param("lights", basis.blocks.len())
                .param("threads", *threads)
                .error("relative error of storing", "own dense table", basis.error())
                .memory(basis.bytes() as u64)
                .time(time_s)
                .note("the paper: 3,600 s and 86 MB");
            run.record(case)?;
            last = Some(basis);
        }
        made.extend(last);
    }
    made.try_into().map_err(|_| failed("no basis"))
}

/// Shares of larger bakes: eight times the paper's cells, and a deck as it is drawn.
fn larger_bakes(run: &mut Run) -> Result<(), Stopped> {
    const SHARES: usize = 25;
    for (name, medium, below_m) in
        [("64x64x8", cloud([64, 64, 8], [0.5; 3], 0.5)?, 4.0), ("stratocumulus, cells of 500 m", deck()?, 1_000.0)]
    {
        let lights = Lights::even([20, 20, 7], medium.size_m(), below_m, medium.periodic).map_err(failed)?;
        for content in [Content::Total, Content::Diffuse] {
            let (medium, lights) = (medium.clone(), lights.clone());
            let albedo = if medium.periodic { 0.9999 } else { params().albedo };
            let params = Params { albedo, ..params() };
            let recipe = Recipe { medium, params, lights, content, packing: content.usual_packing() };
            let share = recipe.share(SHARES / 2, SHARES);
            let mut bytes = 0;
            let (baked, time_s) = measure(1, || {
                recipe.bake(share.clone(), |_, block| {
                    bytes += block.bytes();
                    Ok::<(), Stopped>(())
                })
            });
            baked.map_err(failed)?;
            let case = Case::new(format!("bake of a 25th of the lights, {name}"), format!("{content:?}"))
                .param("threads", rayon::current_num_threads())
                .param("whole bake, s", SHARES as f64 * time_s.median)
                .memory((bytes * SHARES) as u64)
                .time(time_s)
                .note("the middle 25th; memory is that of the whole table");
            run.record(case)?;
        }
    }
    Ok(())
}

/// Stratocumulus that covers the sky, in the cells of a table.
fn deck() -> Result<Medium, Stopped> {
    let kind = CloudKind::Stratocumulus;
    let theta = Coverage::of(kind).threshold(1.0).typical;
    Deck { kind, theta, density: 1.0, thickness_m: 500.0 }.medium([32, 32, 4]).map_err(failed)
}

/// Every method on some bolts.
fn methods(
    run: &mut Run,
    case: &str,
    relighter: &Relighter,
    bolts: &[Vec<PointSource>],
    bases: &[Basis; 2],
) -> Result<(), Stopped> {
    let truths = truths(relighter, bolts)?;
    for method in Method::ALL {
        let table = table(method, bases);
        let runs = if method == Method::Reference { 1 } else { run.pick(3, 7) };
        let (_, time_s) = measure(runs, || relighter.relight(method, &bolts[0], table));
        let made = errors(Case::new(case, method.name()), relighter, method, bolts, &truths, table)?
            .memory(table.map_or(0, |t| t.bytes() as u64))
            .time(time_s)
            .note("the paper: 0.06 s for its scheme, 2.1 to 3.4 s for the one before it");
        run.record(made)?;
    }
    Ok(())
}

fn truths(relighter: &Relighter, bolts: &[Vec<PointSource>]) -> Result<Vec<Relit>, Stopped> {
    bolts.iter().map(|points| relighter.relight(Method::Reference, points, None).map_err(failed)).collect()
}

fn table(method: Method, bases: &[Basis; 2]) -> Option<&Basis> {
    method.table().map(|content| &bases[usize::from(content == Content::Diffuse)])
}

/// Adds the errors of a method: of b in all directions, and of the light that each cell scatters in all.
fn errors(
    case: Case,
    relighter: &Relighter,
    method: Method,
    bolts: &[Vec<PointSource>],
    truths: &[Relit],
    table: Option<&Basis>,
) -> Result<Case, Stopped> {
    let (mut all, mut worst, mut mean, mut outside) = (0.0, 0.0_f64, 0.0, 0);
    let mut fallen = None;
    for (points, truth) in bolts.iter().zip(truths) {
        let lit = relighter.relight(method, points, table).map_err(failed)?;
        let error = relative_f32(&lit.towards, &truth.towards);
        all += error / bolts.len() as f64;
        worst = worst.max(error);
        mean += relative_f32(&relighter.mean(&lit.towards), &relighter.mean(&truth.towards)) / bolts.len() as f64;
        outside += lit.outside;
        fallen = fallen.or(lit.fallback);
    }
    let reference = "one solve, every point for itself";
    let made = case
        .param("bolts", bolts.len())
        .error("relative L2 of b, mean of the bolts", reference, all)
        .error("relative L2 of b, worst bolt", reference, worst)
        .error("relative L2 of the mean over directions", reference, mean)
        .note(format!("{outside} of {} points outside the lights", bolts.iter().map(Vec::len).sum::<usize>()));
    Ok(match fallen {
        Some(why) => made.note(format!("fell back to single scattering: {why}")),
        None => made,
    })
}

/// Error and time over the spacing of the points that a bolt is cut into.
fn spacings(
    run: &mut Run,
    relighter: &Relighter,
    bolts: &[Vec<PointSource>],
    bases: &[Basis; 2],
) -> Result<(), Stopped> {
    let truths = truths(relighter, bolts)?;
    for method in [Method::Hybrid, Method::Solve] {
        for spacing_m in [0.05, 0.1, 0.3, 0.6, 1.0, 2.0] {
            let mut coarser = relighter.clone();
            coarser.spacing_m = spacing_m;
            let table = table(method, bases);
            let (_, time_s) = measure(run.pick(1, 5), || coarser.relight(method, &bolts[0], table));
            let case = Case::new("spacing of the source points", method.name()).param("cell edges", spacing_m);
            run.record(errors(case, &coarser, method, bolts, &truths, table)?.time(time_s))?;
        }
    }
    Ok(())
}

/// What eq. 6 alone costs: the same tables without compression.
fn dense(run: &mut Run, medium: &Medium, relighter: &Relighter, bolts: &[Vec<PointSource>]) -> Result<(), Stopped> {
    let truths = truths(relighter, bolts)?;
    let bolts_of_lights = [[20, 20, 7], [39, 39, 13]];
    for counts in bolts_of_lights {
        for method in [Method::Basis, Method::Hybrid] {
            let Some(content) = method.table() else { continue };
            let lights = Lights::even(counts, medium.size_m(), 4.0, false).map_err(failed)?;
            let packing = Packing { threshold: 0.0, width: Width::F32 };
            let recipe = Recipe { medium: medium.clone(), params: params(), lights, content, packing };
            let case = Case::new("weights of eq. 6, nothing compressed", method.name())
                .param("lights", format!("{}x{}x{}", counts[0], counts[1], counts[2]));
            // Three bolts: a dense table is large.
            let (few, true_few) = (&bolts[..bolts.len().min(3)], &truths[..truths.len().min(3)]);
            let basis = Basis::bake_for(recipe.clone(), &used(&recipe, few)).map_err(failed)?;
            run.record(errors(case, relighter, method, few, true_few, Some(&basis))?)?;
        }
    }
    Ok(())
}

/// A cloud whose cells are ten deep, and a deck as it is drawn.
fn deeper(run: &mut Run) -> Result<(), Stopped> {
    for (name, medium) in [
        ("depth 4 a cell", cloud([32, 32, 4], [1.0; 3], 4.0)?),
        ("depth 10 a cell", cloud([32, 32, 4], [1.0; 3], 10.0)?),
        ("stratocumulus, cells of 500 m", deck()?),
    ] {
        let [x, y, z] = medium.size_m();
        let below_m = if medium.periodic { 1_000.0 } else { z };
        let lights = Lights::even([20, 20, 7], medium.size_m(), below_m, medium.periodic).map_err(failed)?;
        let params = Params { albedo: 0.9999, ..params() };
        let bolts: Vec<_> = (0..3).map(|seed| bolt([x, y, z], 1, seed)).collect();
        let solver = Solver::new(&medium, params).map_err(failed)?;
        let relighter = Relighter::new(&medium, &solver);
        let mut bases = Vec::new();
        for content in [Content::Total, Content::Diffuse] {
            let lights = lights.clone();
            let recipe = Recipe { medium: medium.clone(), params, lights, content, packing: content.usual_packing() };
            bases.push(Basis::bake_for(recipe.clone(), &used(&recipe, &bolts)).map_err(failed)?);
        }
        let bases: [Basis; 2] = bases.try_into().map_err(|_| failed("no basis"))?;
        let case = format!("{name}, greatest depth {:.0}", medium.greatest_cell_depth());
        methods(run, &case, &relighter, &bolts, &bases)?;
    }
    Ok(())
}

/// The lights of a recipe that stand for some bolts.
fn used(recipe: &Recipe, bolts: &[Vec<PointSource>]) -> BTreeSet<usize> {
    let shares = bolts.iter().flatten().map(|point| recipe.lights.shares(point.position_m));
    shares.flat_map(|shares| shares.lights).map(|(light, _)| light).collect()
}
