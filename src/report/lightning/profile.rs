//! Figure 6 of the lightning paper: the potential from the start down to the target, of each model against Laplace's.

use super::super::result::Case;
use super::super::subject::{Run, Stopped};
use super::plane;
use crate::lightning::field::{Potential, potential};
use crate::lightning::scene::Scene;

/// Distances from the start, in shares of the way, that the notes list.
const LISTED: [usize; 5] = [10, 30, 50, 70, 90];

/// The profiles on 128 x 128, each scaled to run from 0 beside the start to 1 beside the target.
pub(super) fn figure_6(run: &mut Run) -> Result<(), Stopped> {
    let side = run.pick(64, 128);
    let grid = plane(side)?;
    let scene = Scene::top_to_bottom(grid);
    let profile = |kind| -> Result<Vec<f64>, Stopped> {
        let field = potential(kind, &scene, &[scene.start])?;
        let values: Vec<f64> = (1..side - 1).rev().map(|y| field[grid.cell([side / 2, y, 0]) as usize]).collect();
        let (low, high) = (values[0], values[values.len() - 1]);
        Ok(values.iter().map(|value| (value - low) / (high - low)).collect())
    };
    let exact = profile(Potential::Laplace)?;
    let models = [
        ("dbm", Potential::Laplace),
        ("rational", Potential::Rational { rho: 3.0 }),
        ("rational", Potential::Rational { rho: 2.0 }),
        ("rational", Potential::Rational { rho: 1.0 }),
        ("sum", Potential::Sum { rho: 3.0 }),
        ("sum", Potential::Sum { rho: 1.0 }),
    ];
    for (name, kind) in models {
        let found = profile(kind)?;
        let worst = found.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let listed: Vec<String> =
            LISTED.iter().map(|share| format!("{:.4}", found[share * (found.len() - 1) / 100])).collect();
        let mut case = Case::new(format!("figure 6: potential profile, {side} x {side}"), name)
            .note(format!("at {LISTED:?} per cent of the way: {}", listed.join(", ")));
        if let Potential::Rational { rho } | Potential::Sum { rho } = kind {
            case = case.param("rho", rho);
        }
        run.record(case.error("greatest difference of scaled potentials", "Laplace's equation", worst))?;
    }
    Ok(())
}
