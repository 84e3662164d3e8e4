//! Subject `scattering`: the solver's light against Monte Carlo, over directions, treatments, depths, shapes and sources.

use super::lit_cloud::{cloud, failed, less_noise};
use super::result::Case;
use super::subject::{Run, Stopped, Subject};
use super::timing::measure;
use crate::clouds::CloudKind;
use crate::clouds::coverage::Coverage;
use crate::numeric::sphere::Rule;
use crate::scattering::deck::Deck;
use crate::scattering::krylov::Method;
use crate::scattering::medium::Medium;
use crate::scattering::monte_carlo;
use crate::scattering::ordinates::{Params, PointSource, Solver, Treatment};
use crate::scattering::phase::Phase;
use crate::scattering::view::arriving;

/// Transport of light.
pub const SUBJECT: Subject = Subject {
    name: "scattering",
    about: "discrete ordinates against analogue Monte Carlo: scattering rate, scattered light b and radiance of a point source",
    measure: cases,
};

/// One comparison in the report's own cloud.
#[derive(Clone, Copy)]
struct Setting {
    asymmetry: f64,
    depth: f32,
    albedo: f64,
    /// Height to width of a cell.
    flat: f64,
    source: (&'static str, [f64; 3]),
    params: Params,
}

const SOURCES: [(&str, [f64; 3]); 3] =
    [("in", [15.3, 16.7, 1.9]), ("below", [16.2, 15.6, -3.0]), ("on a centre", [15.5, 16.5, 1.5])];

/// Depth of a cell beyond which photons collide so often that light towards single directions is not counted.
const DIRECTIONS_UP_TO: f32 = 4.0;

fn cases(run: &mut Run) -> Result<(), Stopped> {
    let base =
        Setting { asymmetry: 0.85, depth: 1.0, albedo: 0.99, flat: 1.0, source: SOURCES[0], params: Params::default() };
    let depths = run.pick(&[1.0_f32][..], &[0.1, 0.25, 1.0, 4.0, 10.0, 20.0][..]);
    let asymmetries = run.pick(&[0.85_f64][..], &[0.0, 0.6, 0.85, 0.95][..]);
    for depth in depths {
        for asymmetry in asymmetries {
            for source in SOURCES {
                let albedo = if *depth >= 10.0 { 0.9999 } else { base.albedo };
                compare(run, Setting { depth: *depth, asymmetry: *asymmetry, source, albedo, ..base })?;
            }
        }
    }
    if run.quick() {
        return Ok(());
    }
    for albedo in [0.9, 1.0] {
        compare(run, Setting { albedo, ..base })?;
    }
    for flat in [0.5, 0.25, 0.125] {
        compare(run, Setting { flat, ..base })?;
    }
    for rule in [Rule::Lebedev50, Rule::Lebedev110] {
        for asymmetry in [0.6, 0.85] {
            compare(run, Setting { asymmetry, params: Params { rule, ..base.params }, ..base })?;
        }
    }
    for asymmetry in [0.0, 0.6, 0.85] {
        let params = Params { treatment: Treatment::Truncated, ..base.params };
        compare(run, Setting { asymmetry, params, ..base })?;
    }
    for depth in [1.0, 4.0] {
        for method in [Method::SourceIteration, Method::BiCgStab] {
            compare(run, Setting { depth, params: Params { method: Some(method), ..base.params }, ..base })?;
        }
    }
    for tolerance in [1e-2, 1e-3, 1e-6] {
        compare(run, Setting { params: Params { tolerance, ..base.params }, ..base })?;
    }
    decks(run)
}

/// Decks as they are drawn, in the cells of a baked table: 500 m wide, much deeper than the paper's.
fn decks(run: &mut Run) -> Result<(), Stopped> {
    for (coverage, thickness_m, source) in
        [(1.0, 500.0, "in"), (1.0, 500.0, "below"), (0.7, 500.0, "in"), (1.0, 1_000.0, "in")]
    {
        let kind = CloudKind::Stratocumulus;
        let theta = Coverage::of(kind).threshold(coverage).typical;
        let deck = Deck { kind, theta, density: 1.0, thickness_m };
        let tile = deck.medium([32, 32, 4]).map_err(failed)?;
        let [x, y, _] = tile.size_m();
        let height_m = f64::from(thickness_m) * if source == "in" { 0.45 } else { -0.6 };
        let middle = [0.5 * x + 70.0, 0.5 * y + 130.0, height_m];
        let (window, corner) = tile.window(middle);
        let at = |k: usize| middle[k] - corner[k] as f64 * tile.spacing_m[k];
        let case = format!(
            "stratocumulus, cover {coverage}, {thickness_m} m, cells of 500 m, depth {:.1}, source {source}",
            window.greatest_cell_depth()
        );
        let params = Params { albedo: 0.9999, ..Params::default() };
        compare_in(run, &case, &window, [at(0), at(1), height_m], params, false)?;
    }
    Ok(())
}

fn compare(run: &mut Run, setting: Setting) -> Result<(), Stopped> {
    let Setting { asymmetry, depth, albedo, flat, source: (place, source_m), .. } = setting;
    let medium = cloud([32, 32, (4.0 / flat) as usize], [1.0, 1.0, flat], depth)?;
    let params = Params { phase: Phase::HenyeyGreenstein(asymmetry), albedo, ..setting.params };
    let case = format!("g {asymmetry}, depth {depth} a cell, source {place}, albedo {albedo}, cells 1:{}", 1.0 / flat);
    compare_in(run, &case, &medium, source_m, params, depth <= DIRECTIONS_UP_TO)
}

/// Compares in any medium; light towards directions only where it is asked for.
fn compare_in(
    run: &mut Run,
    case: &str,
    medium: &Medium,
    source_m: [f64; 3],
    params: Params,
    towards: bool,
) -> Result<(), Stopped> {
    let directions = if towards { params.rule.set().directions } else { Vec::new() };
    // Twice, so that what both have in common is known without noise.
    let photons = run.pick(10_000, if towards { 150_000 } else { 60_000 });
    let [one, two] = [1, 2].map(|seed| {
        let Params { albedo, phase, .. } = params;
        let mc = monte_carlo::Params { photons, seed, albedo, phase, ground: None, directions: directions.clone() };
        monte_carlo::point_source(medium, source_m, &mc)
    });
    let solver = Solver::new(medium, params).map_err(failed)?;
    let points = [PointSource { position_m: source_m, intensity: 1.0 }];
    let (solved, time_s) = measure(run.pick(1, 3), || solver.solve(&[&points]));
    let method = format!("{:?} {:?}", params.rule, params.treatment);
    let mut made = Case::new(case, method).param("tolerance", params.tolerance).time(time_s);
    let (lights, info) = match solved {
        Ok(solved) => solved,
        Err(why) => return run.record(made.note(why.to_string())),
    };
    let light = &lights[0];
    let cells = medium.len();
    let sigma = |i: usize| f64::from(medium.extinction_per_m[i % cells]);
    let rate: Vec<f64> =
        light.fluence.iter().enumerate().map(|(i, f)| params.albedo * f64::from(*f) * sigma(i)).collect();
    made = made.error("relative L2 of the scattering rate", "Monte Carlo", less_noise(&rate, &one.total, &two.total));
    if towards {
        let b: Vec<f64> = light.towards.iter().enumerate().map(|(i, v)| f64::from(*v) * sigma(i)).collect();
        let [first, second] = [&one, &two].map(|r| r.towards.iter().map(|v| f64::from(*v)).collect::<Vec<_>>());
        made = made.error("relative L2 of b in all directions", "Monte Carlo", less_noise(&b, &first, &second));
        // Per unit of extinction, as light is stored; cells without any send none.
        let seen = |b: &[f64]| {
            let source = |(i, v): (usize, &f64)| if sigma(i) > 0.0 { (v / sigma(i)) as f32 } else { 0.0 };
            arriving(medium, &b.iter().enumerate().map(source).collect::<Vec<_>>(), &directions)
        };
        let error = less_noise(&seen(&b), &seen(&first), &seen(&second));
        made = made.error("relative L2 of the radiance in all directions", "Monte Carlo", error);
    }
    made = made
        .error("energy missing", "what the source sends", light.energy.imbalance.abs())
        .param("sweeps", info.sweeps)
        .param("residual", info.residual)
        .param("iteration", format!("{:?}", info.method))
        .note(format!(
            "{} photons twice, errors without their noise; the time is that of up to sixteen sources at once",
            photons
        ));
    run.record(made)
}
