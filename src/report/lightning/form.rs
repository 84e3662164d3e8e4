//! Form over the parameters: fractal dimensions, tips and forks.

use super::super::result::Case;
use super::super::subject::{Run, Stopped};
use super::tables::parameters;
use super::{bolts, plane, spread};
use crate::lightning::grid::Neighbours;
use crate::lightning::grow::Method;
use crate::lightning::laplacian::DEFAULT_PULL;
use crate::lightning::scene::Scene;
use crate::lightning::statistics::{Form, form};

/// Clusters without a target: the published dimension of breakdown at eta 1 is 1.70 (Niemeyer et al. 1984).
pub(super) fn free(run: &mut Run) -> Result<(), Stopped> {
    let (side, cells, seeds) = run.pick((129, 600, 4), (255, 2000, 8));
    let scene = Scene { neighbours: Neighbours::Faces, ..Scene::free(plane(side)?) };
    let name = format!("form: {cells} cells without a target, {side} x {side}, 4 neighbours");
    let mut methods = vec![Method::Dielectric { eta: 1.0 }];
    if !run.quick() {
        methods.extend([2.0, 3.0].map(|eta| Method::Dielectric { eta }));
    }
    methods.extend([2.0, 3.0, 5.0].map(|eta| Method::laplacian(eta, DEFAULT_PULL)));
    methods.extend([1.0, 2.0, 3.0].map(|eta| Method::rational(eta, 3.0)));
    for method in methods {
        record(run, &name, &method, &scene, cells, seeds, 1.70, "Niemeyer et al. 1984, eta 1: 1.70")?;
    }
    Ok(())
}

/// Bolts to a target over eta and rho, against exact breakdown at eta 2.
pub(super) fn to_a_target(run: &mut Run) -> Result<(), Stopped> {
    let side = run.pick(64, 128);
    let seeds = run.pick(6, 20);
    let scene = Scene::top_to_bottom(plane(side)?);
    let name = format!("form: to a target, {side} x {side}");
    let exact = bolts(&Method::Dielectric { eta: 2.0 }, &scene, 100_000, seeds)?;
    let dimensions: Vec<f64> = exact.all.iter().filter_map(|(channel, _)| form(channel).mass_radius).collect();
    let (reference, _) = spread(&dimensions);
    let mut methods: Vec<Method> = [1.0, 2.0, 3.0].map(|eta| Method::Dielectric { eta }).to_vec();
    methods.extend([1.0, 2.0, 3.0, 5.0].map(|eta| Method::rational(eta, 3.0)));
    methods.extend([1.5, 2.0, 4.0, 5.0].map(|rho| Method::rational(3.0, rho)));
    methods.push(Method::laplacian(3.0, DEFAULT_PULL));
    for method in methods {
        record(run, &name, &method, &scene, 100_000, seeds, reference, "exact dielectric breakdown, eta 2")?;
    }
    Ok(())
}

#[expect(clippy::too_many_arguments, reason = "one line of either table above")]
fn record(
    run: &mut Run,
    name: &str,
    method: &Method,
    scene: &Scene,
    cells: u32,
    seeds: u64,
    reference: f64,
    source: &str,
) -> Result<(), Stopped> {
    let grown = bolts(method, scene, cells, seeds)?;
    let forms: Vec<Form> = grown.all.iter().map(|(channel, _)| form(channel)).collect();
    let of = |value: &dyn Fn(&Form) -> Option<f64>| spread(&forms.iter().filter_map(value).collect::<Vec<f64>>());
    let (dimension, deviation) = of(&|form| form.mass_radius);
    let (boxes, _) = of(&|form| form.boxes);
    let (tips, _) = of(&|form| Some(f64::from(form.tips)));
    let (forks, _) = of(&|form| Some(f64::from(form.forks)));
    let (mean, _) = spread(&grown.cells);
    let case = parameters(Case::new(name, method.name()), method).time(grown.time_s).note(format!(
        "mass-radius dimension {dimension:.2} +- {deviation:.2}, by boxes {boxes:.2}; {mean:.0} cells, {tips:.0} tips, {forks:.0} forks; {seeds} seeds"
    ));
    run.record(case.error("difference of mass-radius dimensions", source, (dimension - reference).abs()))
}
