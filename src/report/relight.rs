//! Subject `relight`: time and error of every way of lighting a cloud by a bolt, against one exact solve per bolt.

use super::lit_cloud::{bolt, cloud, failed, relative_f32};
use super::result::Case;
use super::subject::{Run, Stopped, Subject};
use super::timing::measure;
use crate::scattering::basis::{Basis, Content, Recipe, USUAL_PACKING};
use crate::scattering::compress::{Packing, Width};
use crate::scattering::lights::Lights;
use crate::scattering::ordinates::{Params, Solver};
use crate::scattering::phase::Phase;
use crate::scattering::relight::{Method, Relighter};

/// Bolts in clouds.
pub const SUBJECT: Subject = Subject {
    name: "relight",
    about: "light of a bolt in a cloud by every method, against one solve with every point for itself",
    measure: cases,
};

fn cases(run: &mut Run) -> Result<(), Stopped> {
    let medium = cloud([32, 32, 4], [1.0; 3], 1.0)?;
    let counts = run.pick([4, 4, 3], [20, 20, 7]);
    let lights = Lights::even(counts, medium.size_m(), 4.0, false).map_err(failed)?;
    let params = Params { phase: Phase::HenyeyGreenstein(0.85), albedo: 0.99, tolerance: 1e-3, ..Params::default() };
    let mut bases = Vec::new();
    for (content, packing) in
        [(Content::Total, Packing { threshold: 2e-4, width: Width::F16 }), (Content::Diffuse, USUAL_PACKING)]
    {
        let recipe = Recipe { medium: medium.clone(), params, lights: lights.clone(), content, packing };
        let (basis, time_s) = measure(1, || Basis::bake(recipe.clone()));
        let basis = basis.map_err(failed)?;
        let made = Case::new("bake", format!("{content:?}"))
            .param("lights", basis.blocks.len())
            .param("threads", rayon::current_num_threads())
            .error("relative error of storing", "own dense table", basis.error())
            .memory(basis.bytes() as u64)
            .time(time_s)
            .note("the paper: 3,600 s and 86 MB");
        run.record(made)?;
        bases.push(basis);
    }
    let solver = Solver::new(&medium, Params { tolerance: 1e-5, ..params }).map_err(failed)?;
    let relighter = Relighter::new(&medium, &solver);
    for seeds in [1, 2, 3, 5] {
        let bolts: Vec<_> = (0..run.pick(1, 3)).map(|seed| bolt(medium.size_m(), seeds, seed)).collect();
        let mut truths = Vec::new();
        for points in &bolts {
            truths.push(relighter.relight(Method::Reference, points, None).map_err(failed)?.towards);
        }
        for method in Method::ALL {
            let table = method.table().map(|content| &bases[usize::from(content == Content::Diffuse)]);
            let (mut errors, mut outside) = (Vec::new(), 0);
            for (points, truth) in bolts.iter().zip(&truths) {
                let lit = relighter.relight(method, points, table).map_err(failed)?;
                errors.push(relative_f32(&lit.towards, truth));
                outside += lit.outside;
            }
            let runs = if method == Method::Reference { 1 } else { run.pick(3, 7) };
            let (_, time_s) = measure(runs, || relighter.relight(method, &bolts[0], table));
            let made = Case::new(format!("bolts of {seeds} seed points"), method.name())
                .param("bolts", bolts.len())
                .error(
                    "relative L2 of b",
                    "one solve, every point for itself",
                    errors.iter().sum::<f64>() / errors.len() as f64,
                )
                .memory(table.map_or(0, |t| t.bytes() as u64))
                .time(time_s)
                .note(format!(
                    "{outside} points outside the lights; the paper: 0.06 s for its scheme, 2.1-3.4 s before it"
                ));
            run.record(made)?;
        }
    }
    Ok(())
}
