//! Subject `scattering`: the solver's light against Monte Carlo, over directions, treatments, depths, shapes and sources.

use super::lit_cloud::{cloud, failed, relative};
use super::result::Case;
use super::subject::{Run, Stopped, Subject};
use super::timing::measure;
use crate::numeric::sphere::Rule;
use crate::scattering::monte_carlo;
use crate::scattering::ordinates::{Params, PointSource, Solver, Treatment};
use crate::scattering::phase::Phase;

/// Transport of light.
pub const SUBJECT: Subject = Subject {
    name: "scattering",
    about: "discrete ordinates against analogue Monte Carlo: scattering rate and scattered light of a point source",
    measure: cases,
};

/// One comparison.
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
        compare(run, Setting { params: Params { rule, ..base.params }, ..base })?;
    }
    compare(run, Setting { params: Params { treatment: Treatment::Truncated, ..base.params }, ..base })?;
    for tolerance in [1e-2, 1e-3, 1e-6] {
        compare(run, Setting { params: Params { tolerance, ..base.params }, ..base })?;
    }
    Ok(())
}

fn compare(run: &mut Run, setting: Setting) -> Result<(), Stopped> {
    let Setting { asymmetry, depth, albedo, flat, source: (place, source_m), .. } = setting;
    let medium = cloud([32, 32, (4.0 / flat) as usize], [1.0, 1.0, flat], depth)?;
    let phase = Phase::HenyeyGreenstein(asymmetry);
    let params = Params { phase, albedo, ..setting.params };
    let directions = params.rule.set().directions;
    let photons = run.pick(20_000, 300_000);
    let mc = monte_carlo::Params { photons, seed: 1, albedo, phase, ground: None, directions };
    let reference = monte_carlo::point_source(&medium, source_m, &mc);
    let solver = Solver::new(&medium, params).map_err(failed)?;
    let points = [PointSource { position_m: source_m, intensity: 1.0 }];
    let (solved, time_s) = measure(run.pick(1, 3), || solver.solve(&[&points]));
    let case = format!("g {asymmetry}, depth {depth} a cell, source {place}, albedo {albedo}, cells 1:{}", 1.0 / flat);
    let method = format!("{:?} {:?}", params.rule, params.treatment);
    let mut made = Case::new(case, method).param("tolerance", params.tolerance).time(time_s);
    let (lights, info) = match solved {
        Ok(solved) => solved,
        Err(why) => return run.record(made.note(why.to_string())),
    };
    let light = &lights[0];
    let cells = medium.len();
    let sigma = |i: usize| f64::from(medium.extinction_per_m[i % cells]);
    let rate = light.fluence.iter().enumerate().map(|(i, f)| albedo * f64::from(*f) * sigma(i));
    let b = light.towards.iter().enumerate().map(|(i, v)| f64::from(*v) * sigma(i));
    let noise = rms_over(&reference.error, &reference.total);
    made = made
        .error("relative L2 of the scattering rate", "Monte Carlo", relative(rate, reference.total.iter().copied()))
        .error(
            "relative L2 of b in all directions",
            "Monte Carlo",
            relative(b, reference.towards.iter().map(|v| f64::from(*v))),
        )
        .error("energy missing", "what the source sends", light.energy.imbalance.abs())
        .param("sweeps", info.sweeps)
        .param("iteration", format!("{:?}", info.method))
        .note(format!(
            "noise of the reference {noise:.3} of the rate; the time is that of up to sixteen sources at once"
        ));
    run.record(made)
}

fn rms_over(error: &[f64], value: &[f64]) -> f64 {
    let square = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
    (square(error) / square(value)).sqrt()
}
