//! Subject `lightning`: growth methods on the lightning paper's scenes, against exact dielectric breakdown.
//!
//! The scene of its tables is that of its figure 4: one target cell at the bottom centre, the start at the top centre, 8 (26)
//! neighbours, a ring outside the grid at potential 0. What the paper calls branches are grown cells.

mod distribution;
mod form;
mod profile;
mod tables;

use super::result::TimeSpread;
use super::subject::{Run, Stopped, Subject};
use crate::lightning::channel::{Channel, Info};
use crate::lightning::error::GrowError;
use crate::lightning::grid::Grid;
use crate::lightning::grow::{Method, grow};
use crate::lightning::scene::Scene;
use crate::lightning::tables::Tables;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Growth methods.
pub const SUBJECT: Subject = Subject {
    name: "lightning",
    about: "lightning channels: time, cells, form and distribution of each method against exact dielectric breakdown",
    measure: cases,
};

fn cases(run: &mut Run) -> Result<(), Stopped> {
    tables::target_scenes(run)?;
    tables::free_growth(run)?;
    profile::figure_6(run)?;
    distribution::per_step(run)?;
    distribution::first_cells(run)?;
    form::free(run)?;
    form::to_a_target(run)
}

impl From<GrowError> for Stopped {
    fn from(error: GrowError) -> Self {
        Self::Failed(error.to_string())
    }
}

/// Several bolts of one method.
struct Bolts {
    time_s: TimeSpread,
    cells: Vec<f64>,
    all: Vec<(Channel, Info)>,
}

/// Grows bolts for seeds 0, 1, 2... The tables of the Green's function are kept from bolt to bolt, all else is made anew.
fn bolts(method: &Method, scene: &Scene, most_cells: u32, seeds: u64) -> Result<Bolts, Stopped> {
    let cancel = AtomicBool::new(false);
    let mut kept = Tables::default();
    let keep = matches!(method, Method::Dielectric { .. });
    if keep {
        grow(method, scene, 1, 0, &mut kept, &cancel)?;
    }
    let (mut times_s, mut cells, mut all) = (Vec::new(), Vec::new(), Vec::new());
    for seed in 0..seeds.max(1) {
        let mut tables = if keep { kept.clone() } else { Tables::default() };
        let begin = Instant::now();
        let grown = grow(method, scene, most_cells, seed, &mut tables, &cancel)?;
        times_s.push(begin.elapsed().as_secs_f64());
        cells.push(f64::from(grown.1.cells));
        all.push(grown);
    }
    let time_s = TimeSpread::of(&times_s).ok_or_else(|| Stopped::Failed("no bolt was grown".to_owned()))?;
    Ok(Bolts { time_s, cells, all })
}

/// Mean and standard deviation.
fn spread(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let square = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>();
    (mean, (square / (values.len() as f64 - 1.0).max(1.0)).sqrt())
}

fn plane(side: u32) -> Result<Grid, Stopped> {
    Ok(Grid::plane(side, side)?)
}
