//! Subject `compression`: bytes and error of basis intensities over threshold, width and content, and the ambient term.

use super::lit_cloud::{bolt, cloud, failed, relative_f32};
use super::result::Case;
use super::subject::{Run, Stopped, Subject};
use super::timing::measure;
use crate::numeric::haar::Haar;
use crate::scattering::basis::{Content, Recipe};
use crate::scattering::compress::{Ambient, Block, Packing, Sum, Width};
use crate::scattering::lights::Lights;
use crate::scattering::medium::Medium;
use crate::scattering::ordinates::{Params, Solver};
use crate::scattering::phase::Phase;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Basis intensities as few coefficients.
pub const SUBJECT: Subject = Subject {
    name: "compression",
    about: "basis intensities in few Haar coefficients against their own dense table, summed for a bolt",
    measure: cases,
};

/// Error of a bolt, relative to its own dense table, that the published scheme is asked to keep.
const ASKED: f64 = 0.03;

fn cases(run: &mut Run) -> Result<(), Stopped> {
    let counts = run.pick([5, 5, 4], [20, 20, 7]);
    let widths = [Width::F32, Width::F16, Width::Log8];
    let thresholds = [0.0, 1e-6, 1e-5, 3e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 3e-3];
    for content in [Content::Total, Content::Diffuse] {
        let recipe = recipe(cloud([32, 32, 4], [1.0; 3], 1.0)?, counts, content)?;
        table(run, &recipe, run.pick(2, 8), &widths, &thresholds)?;
    }
    if !run.quick() {
        // Eight times the paper's cells, of half the width.
        let recipe = recipe(cloud([64, 64, 8], [0.5; 3], 0.5)?, counts, Content::Total)?;
        table(run, &recipe, 3, &[Width::F16, Width::Log8], &[1e-6, 3e-6, 1e-5, 3e-5, 1e-4])?;
    }
    Ok(())
}

fn recipe(medium: Medium, counts: [usize; 3], content: Content) -> Result<Recipe, Stopped> {
    let lights = Lights::even(counts, medium.size_m(), 4.0, false).map_err(failed)?;
    let params = Params { phase: Phase::HenyeyGreenstein(0.85), albedo: 0.99, tolerance: 1e-3, ..Params::default() };
    Ok(Recipe { medium, params, lights, content, packing: Packing { threshold: 0.0, width: Width::F32 } })
}

/// Bytes, error and time over widths, thresholds and ambient terms, and at the threshold that keeps bolts within the error asked for.
/// Only the lights that the bolts use are solved: their fields are what the sums read.
fn table(run: &mut Run, recipe: &Recipe, bolts: u64, widths: &[Width], thresholds: &[f64]) -> Result<(), Stopped> {
    let bolts: Vec<BTreeMap<usize, f64>> =
        (0..bolts).map(|seed| weights(recipe, &bolt(recipe.medium.size_m(), 1 + seed as usize % 3, seed))).collect();
    let fields = fields(recipe, bolts.iter().flat_map(|b| b.keys().copied()).collect())?;
    let dense: Vec<Vec<f32>> = bolts.iter().map(|b| dense_sum(b, &fields)).collect();
    let tried = Tried { recipe, bolts, fields, dense, haar: Haar::new(recipe.medium.cells) };
    for width in widths.iter().copied() {
        for threshold in thresholds.iter().copied() {
            let packing = Packing { threshold, width };
            let blocks = tried.packed(packing);
            for ambient in [Ambient::Off, Ambient::Printed, Ambient::SignedMean] {
                if ambient != Ambient::Off && (width != Width::F32 || threshold == 0.0) {
                    continue;
                }
                tried.record(run, packing, &blocks, ambient, "")?;
            }
        }
        // The largest threshold that keeps what is asked, by bisection of its logarithm.
        let (mut low, mut high) = (1e-8_f64, 1e-2_f64);
        for _ in 0..run.pick(4, 9) {
            let threshold = (low * high).sqrt();
            let errors = tried.errors(&tried.packed(Packing { threshold, width }), Ambient::Off);
            if mean(&errors) <= ASKED { low = threshold } else { high = threshold }
        }
        let packing = Packing { threshold: low, width };
        tried.record(run, packing, &tried.packed(packing), Ambient::Off, ", smallest within 3 %")?;
    }
    Ok(())
}

/// Bolts in a cloud with the fields of the lights that stand for them.
struct Tried<'a> {
    recipe: &'a Recipe,
    bolts: Vec<BTreeMap<usize, f64>>,
    fields: BTreeMap<usize, Vec<f32>>,
    dense: Vec<Vec<f32>>,
    haar: Haar,
}

impl Tried<'_> {
    fn packed(&self, packing: Packing) -> BTreeMap<usize, Block> {
        let norm = self.recipe.norm();
        let pack = |(light, f): (&usize, &Vec<f32>)| (*light, Block::pack(&self.haar, &mut f.clone(), packing, norm));
        self.fields.iter().map(pack).collect()
    }

    fn sum(&self, bolt: usize, blocks: &BTreeMap<usize, Block>, ambient: Ambient) -> Vec<f32> {
        let mut sum = Sum::new(&self.haar, self.recipe.components(), ambient);
        self.bolts[bolt].iter().for_each(|(light, weight)| sum.add(&blocks[light], *weight as f32));
        sum.fields()
    }

    /// Relative errors of the bolts.
    fn errors(&self, blocks: &BTreeMap<usize, Block>, ambient: Ambient) -> Vec<f64> {
        self.dense.iter().enumerate().map(|(i, dense)| relative_f32(&self.sum(i, blocks, ambient), dense)).collect()
    }

    fn record(
        &self,
        run: &mut Run,
        packing: Packing,
        blocks: &BTreeMap<usize, Block>,
        ambient: Ambient,
        remark: &str,
    ) -> Result<(), Stopped> {
        let (recipe, known) = (self.recipe, self.fields.len());
        let [nx, ny, nz] = recipe.medium.cells;
        let case = format!("{nx}x{ny}x{nz}, {:?}, {known} of {} lights", recipe.content, recipe.lights.len());
        let bytes: usize = blocks.values().map(Block::bytes).sum();
        // What the whole table would take, from the share that was solved.
        let whole = (bytes as f64 * recipe.lights.len() as f64 / known as f64) as u64;
        let errors = self.errors(blocks, ambient);
        let (_, time_s) = measure(run.pick(3, 11), || self.sum(0, blocks, ambient));
        let made = Case::new(case, format!("{:?}, ambient {ambient:?}{remark}", packing.width))
            .param("threshold", packing.threshold)
            .param("ratio", recipe.dense_bytes() as f64 / whole as f64)
            .error("relative L2, mean of the bolts", "own dense table", mean(&errors))
            .error("relative L2, worst bolt", "own dense table", errors.iter().copied().fold(0.0, f64::max))
            .memory(whole)
            .time(time_s)
            .note("time of the weighted sum and the inverse transform of one bolt, one core; the paper: 86 MB, 0.06 s");
        run.record(made)
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// The fields of the batches that hold the given lights.
fn fields(recipe: &Recipe, lights: BTreeSet<usize>) -> Result<BTreeMap<usize, Vec<f32>>, Stopped> {
    let solver = Solver::new(&recipe.medium, recipe.params).map_err(failed)?;
    let mut batches = recipe.batches();
    batches.retain(|batch| lights.range(batch.clone()).next().is_some());
    let solved: Result<Vec<_>, _> =
        batches.par_iter().map(|batch| recipe.fields(&solver, batch.clone()).map(|f| (batch.clone(), f))).collect();
    Ok(solved.map_err(failed)?.into_iter().flat_map(|(batch, fields)| batch.zip(fields)).collect())
}

fn weights(recipe: &Recipe, points: &[crate::scattering::ordinates::PointSource]) -> BTreeMap<usize, f64> {
    let mut weights = BTreeMap::new();
    for point in points {
        for (light, share) in recipe.lights.shares(point.position_m).lights {
            *weights.entry(light).or_insert(0.0) += share * point.intensity;
        }
    }
    weights
}

fn dense_sum(weights: &BTreeMap<usize, f64>, fields: &BTreeMap<usize, Vec<f32>>) -> Vec<f32> {
    let length = fields.values().next().map_or(0, Vec::len);
    let mut sum = vec![0.0; length];
    for (light, weight) in weights {
        for (s, f) in sum.iter_mut().zip(&fields[light]) {
            *s += *weight as f32 * f;
        }
    }
    sum
}
