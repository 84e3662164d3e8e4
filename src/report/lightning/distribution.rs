//! How far the distribution that a method draws from is from exact breakdown's.
//!
//! Two measures. *Per step*: along channels that exact breakdown grew, each method gives every candidate its chance; half the
//! sum of the absolute differences is the share of draws that go elsewhere (total variation). *First cells*: a two-sample
//! chi-squared over the sets of first cells of many channels, as standard deviations from its mean.

use super::super::result::{Case, TimeSpread};
use super::super::subject::{Run, Stopped};
use super::tables::parameters;
use super::{bolts, plane, spread};
use crate::lightning::field::{Potential, potential};
use crate::lightning::grid::{Cell, Grid, Neighbours};
use crate::lightning::grow::{Method, grow};
use crate::lightning::laplacian::DEFAULT_PULL;
use crate::lightning::rational::Arithmetic;
use crate::lightning::scene::Scene;
use crate::lightning::tables::Tables;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::AtomicBool;

/// Cells after which chances are compared: every so many.
const EVERY: usize = 12;

/// Total variation per step over eta, rho and the solver's tolerance, with the time of a bolt.
pub(super) fn per_step(run: &mut Run) -> Result<(), Stopped> {
    let side = run.pick(32, 64);
    let scene = Scene::top_to_bottom(plane(side)?);
    for eta in run.pick(vec![2.0], vec![1.0, 2.0, 3.0]) {
        let exact = bolts(&Method::Dielectric { eta }, &scene, 100_000, run.pick(2, 4))?;
        // Every so many cells of each shared growth: the channel then, its candidates, and their exact chances.
        let mut moments = Vec::new();
        for (channel, info) in &exact.all {
            let cells: Vec<Cell> =
                channel.nodes.iter().map(|node| scene.grid.cell(node.position.map(|p| p as u32))).collect();
            for count in (1..info.cells as usize).step_by(EVERY) {
                let grown = cells[..count].to_vec();
                let candidates = candidates(&scene, &grown);
                let chances = chances(Potential::Laplace, eta, &scene, &grown, &candidates)?;
                moments.push((grown, candidates, chances));
            }
        }
        let mut models: Vec<(Method, Potential, f64)> = vec![(Method::Dielectric { eta }, Potential::Laplace, eta)];
        for tolerance in [1e-6, 1e-3, 1e-1] {
            let method = Method::DielectricConjugate { eta, tolerance };
            models.push((method, Potential::LaplaceTo { tolerance }, eta));
        }
        for (own_eta, rho) in [(eta, 1.0), (eta, 2.0), (eta, 3.0), (eta, 4.0), (eta + 1.0, 3.0)] {
            models.push((Method::rational(own_eta, rho), Potential::Rational { rho }, own_eta));
        }
        let pull = DEFAULT_PULL;
        models.push((Method::laplacian(eta, pull), Potential::Laplacian { pull }, eta));
        for (method, kind, own_eta) in models {
            let mut apart = Vec::new();
            for (grown, candidates, exact) in &moments {
                let found = chances(kind, own_eta, &scene, grown, candidates)?;
                apart.push(0.5 * found.iter().zip(exact).map(|(a, b)| (a - b).abs()).sum::<f64>());
            }
            let (mean, _) = spread(&apart);
            let worst = apart.iter().copied().fold(0.0, f64::max);
            let time_s: TimeSpread = bolts(&method, &scene, 100_000, 3)?.time_s;
            let case =
                parameters(Case::new(format!("chances per step, {side} x {side}, eta {eta}"), method.name()), &method)
                    .time(time_s)
                    .note(format!("at most {worst:.3} in {} steps of shared growths", apart.len()));
            run.record(case.error("total variation per step", "exact dielectric breakdown", mean))?;
        }
    }
    Ok(())
}

/// The free cells that touch a channel.
fn candidates(scene: &Scene, grown: &[Cell]) -> Vec<Cell> {
    let steps = Neighbours::All.steps(scene.grid.axes());
    let size = scene.grid.size();
    let mut found = BTreeSet::new();
    for &cell in grown {
        let at = scene.grid.position(cell);
        for step in &steps {
            let next: [u32; 3] = std::array::from_fn(|axis| at[axis].wrapping_add_signed(step[axis]));
            if (0..3).all(|axis| next[axis] < size[axis]) {
                found.insert(scene.grid.cell(next));
            }
        }
    }
    let targets = scene.targets();
    found.into_iter().filter(|cell| !grown.contains(cell) && !targets.contains(cell)).collect()
}

/// Each candidate's chance by one model.
fn chances(kind: Potential, eta: f64, scene: &Scene, grown: &[Cell], candidates: &[Cell]) -> Result<Vec<f64>, Stopped> {
    let field = potential(kind, scene, grown)?;
    let values: Vec<f64> = candidates.iter().map(|&cell| field[cell as usize]).collect();
    // Fast Laplacian growth counts from its least candidate; the others from 0.
    let floor = match kind {
        Potential::Laplacian { .. } => values.iter().copied().fold(f64::MAX, f64::min),
        _ => 0.0,
    };
    let greatest = values.iter().map(|value| value - floor).fold(f64::MIN_POSITIVE, f64::max);
    let weights: Vec<f64> = values.iter().map(|value| ((value - floor).max(0.0) / greatest).powf(eta)).collect();
    let total: f64 = weights.iter().sum();
    let even = 1.0 / weights.len() as f64;
    Ok(weights.iter().map(|weight| if total > 0.0 { weight / total } else { even }).collect())
}

/// The sets of first cells, with how often each grew in either sample.
type Sets = BTreeMap<Vec<Cell>, [f64; 2]>;

/// Chi-squared over first cells: fast forms against slow ones, a control, and two pairs that must differ.
pub(super) fn first_cells(run: &mut Run) -> Result<(), Stopped> {
    let runs = run.pick(4000, 60_000);
    let grid = plane(run.pick(12, 32))?;
    let exact = Method::Dielectric { eta: 2.0 };
    let conjugate = Method::DielectricConjugate { eta: 2.0, tolerance: 1e-10 };
    let rational = Method::rational(2.0, 3.0);
    let double = Method::Rational { eta: 2.0, rho: 3.0, arithmetic: Arithmetic::Double };
    let pairs = [
        ("control: exact breakdown with other seeds", exact.clone(), exact.clone()),
        ("Green's function against conjugate gradients at 1e-10", exact.clone(), conjugate),
        ("f32 against f64", rational.clone(), double),
        ("must differ: eta 2.5 against 2", Method::Dielectric { eta: 2.5 }, exact.clone()),
        ("must differ: rational against exact breakdown", rational, exact),
    ];
    for (number, (name, fast, slow)) in (1_u64..).zip(pairs) {
        let a = sets(&fast, grid, runs, number << 40)?;
        let b = sets(&slow, grid, runs, (number << 40) + (1 << 39))?;
        let (z, freedom) = chi_squared(&a, &b);
        let case = Case::new(format!("first 5 cells: {name}"), fast.name())
            .note(format!("{runs} runs each, {freedom} degrees of freedom; below 4 means no difference was seen"));
        let reference = format!("{} ({} runs)", slow.name(), runs);
        run.record(parameters(case, &fast).error("chi-squared, standard deviations from its mean", &reference, z))?;
    }
    Ok(())
}

fn sets(method: &Method, grid: Grid, runs: u64, first_seed: u64) -> Result<BTreeMap<Vec<Cell>, f64>, Stopped> {
    let scene = Scene::top_to_bottom(grid);
    let (mut tables, cancel) = (Tables::default(), AtomicBool::new(false));
    let mut counts = BTreeMap::new();
    for seed in first_seed..first_seed + runs {
        let (channel, _) = grow(method, &scene, 5, seed, &mut tables, &cancel)?;
        let mut cells: Vec<Cell> =
            channel.nodes.iter().map(|node| grid.cell(node.position.map(|p| p as u32))).collect();
        cells.sort_unstable();
        *counts.entry(cells).or_default() += 1.0;
    }
    Ok(counts)
}

/// Two-sample chi-squared of equally many runs, as standard deviations from its mean, and its degrees of freedom. Sets seen less
/// than 20 times in both together count as one.
fn chi_squared(a: &BTreeMap<Vec<Cell>, f64>, b: &BTreeMap<Vec<Cell>, f64>) -> (f64, usize) {
    let mut both = Sets::new();
    for (side, counts) in [a, b].into_iter().enumerate() {
        for (cells, count) in counts {
            both.entry(cells.clone()).or_default()[side] += count;
        }
    }
    let (mut rare, mut frequent) = ([0.0; 2], Vec::new());
    for &[x, y] in both.values() {
        if x + y < 20.0 { rare = [rare[0] + x, rare[1] + y] } else { frequent.push([x, y]) }
    }
    if rare[0] + rare[1] > 0.0 {
        frequent.push(rare);
    }
    let chi: f64 = frequent.iter().map(|[x, y]| (x - y) * (x - y) / (x + y)).sum();
    let freedom = frequent.len().saturating_sub(1).max(1);
    ((chi - freedom as f64) / (2.0 * freedom as f64).sqrt(), freedom)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chi_squared_by_hand() {
        let counts = |values: [f64; 3]| -> BTreeMap<Vec<Cell>, f64> {
            (0..3).map(|cell| vec![cell]).zip(values).filter(|(_, count)| *count > 0.0).collect()
        };
        // (20^2 / 100 + 20^2 / 100 + 0) = 8 with 2 degrees of freedom: (8 - 2) / 2.
        let (z, freedom) = chi_squared(&counts([60.0, 40.0, 50.0]), &counts([40.0, 60.0, 50.0]));
        assert!((z - 3.0).abs() < 1e-12 && freedom == 2);
        // Rare sets together: 3 and 2 of them make one set.
        assert_eq!(chi_squared(&counts([60.0, 3.0, 0.0]), &counts([60.0, 0.0, 2.0])).1, 1);
    }

    #[test]
    fn chances_of_a_lone_start_add_up_and_favour_the_way_down() {
        let scene = Scene::top_to_bottom(Grid::plane(9, 9).expect("a grid"));
        let around = candidates(&scene, &[scene.start]);
        assert_eq!(around.len(), 5);
        for kind in [Potential::Laplace, Potential::Rational { rho: 3.0 }, Potential::Laplacian { pull: 1000.0 }] {
            let chances = chances(kind, 2.0, &scene, &[scene.start], &around).expect("a right scene");
            assert!((chances.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            // Straight down or across a corner: a method may prefer either, but none stays in the row of the start.
            let best = around.iter().zip(&chances).max_by(|a, b| a.1.total_cmp(b.1)).expect("candidates");
            assert_eq!(scene.grid.position(*best.0)[1], 7, "{kind:?} {chances:?}");
        }
    }
}
