//! Basis intensities: the light of every virtual light in a cloud, solved, compressed, in shares that merge to the same bits.

use super::compress::{Block, Packing, Width};
use super::lanes::LANES;
use super::lights::Lights;
use super::medium::Medium;
use super::ordinates::{Params, PointSource, SolveError, Solver};
use crate::numeric::haar::Haar;
use crate::numeric::sphere::harmonics_count;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::ops::Range;

/// What of the light is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Scattered light per unit of extinction in every direction, direct and multiple: the published scheme.
    Total,
    /// Moments of what the transport scatters of diffuse light: smooth, for the hybrid method, which finds direct light itself.
    Diffuse,
}

impl Content {
    /// The usual packing. The published scheme's keeps bolts within 3 % of the dense table; that of diffuse light, which is a part
    /// of the light alone, keeps the paper's table within 20 MB (`stormdeck report compression`, `relight`).
    pub fn usual_packing(self) -> Packing {
        match self {
            Self::Total => Packing { threshold: 2.5e-5, width: Width::F16 },
            Self::Diffuse => Packing { threshold: 3e-5, width: Width::Log8 },
        }
    }
}

/// Everything that decides what a basis holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// The cloud; if it repeats, every column of lights has its own window.
    pub medium: Medium,
    /// How light is solved.
    pub params: Params,
    /// Where the lights are.
    pub lights: Lights,
    /// What is stored.
    pub content: Content,
    /// How.
    pub packing: Packing,
}

/// A baked basis.
#[derive(Clone, Debug, PartialEq)]
pub struct Basis {
    /// What it was made by.
    pub recipe: Recipe,
    /// One a light.
    pub blocks: Vec<Block>,
}

/// Why baking ended.
#[derive(Debug, thiserror::Error)]
pub enum BakeError<E> {
    /// The solver did not find the light.
    #[error("lights {first} to {last}: {why}")]
    Solve {
        /// First light of the batch.
        first: usize,
        /// Last light of the batch.
        last: usize,
        /// The solver's words.
        why: SolveError,
    },
    /// Whoever takes the blocks did not.
    #[error(transparent)]
    Sink(E),
}

impl Recipe {
    /// Fields of one light.
    pub fn components(&self) -> usize {
        match self.content {
            Content::Total => self.params.rule.count(),
            Content::Diffuse => harmonics_count(self.params.rule.order()),
        }
    }

    /// The norm of the threshold: light of 1 W/sr at the distance of a cell's longest edge, W/m^2, times the root of the
    /// number of cells.
    pub fn norm(&self) -> f64 {
        let edge = self.medium.spacing_m.iter().copied().fold(0.0, f64::max);
        (self.medium.len() as f64).sqrt() / (edge * edge)
    }

    /// Bytes of the table before compression, f32.
    pub fn dense_bytes(&self) -> usize {
        self.lights.len() * self.components() * self.medium.len() * 4
    }

    /// Lights that are solved together, in order: those of a column where the medium repeats (they share a window), else
    /// sixteen. Batches, not lights, are shared out, since where lights cannot be solved alone the lanes of a batch stop together.
    pub fn batches(&self) -> Vec<Range<usize>> {
        let column = if self.medium.periodic { self.lights.z_m.len() } else { self.lights.len() };
        let mut batches = Vec::new();
        for start in (0..self.lights.len()).step_by(column.max(1)) {
            let end = start + column;
            batches.extend((start..end).step_by(LANES).map(|at| at..(at + LANES).min(end)));
        }
        batches
    }

    /// The batches of share `index` of `of`: as even as whole batches allow; all shares in order are all batches.
    pub fn share(&self, index: usize, of: usize) -> Range<usize> {
        let (n, of) = (self.batches().len(), of.max(1) as u128);
        let cut = |k: u128| (n as u128 * k.min(of) / of) as usize;
        cut(index as u128)..cut(index as u128 + 1)
    }

    /// Bakes batches in order and hands every light's block to `sink` in order; as many batches are in memory as threads.
    ///
    /// # Errors
    /// [`BakeError`]; blocks handed over before stay good.
    pub fn bake<E: Send>(
        &self,
        batches: Range<usize>,
        sink: impl FnMut(usize, Block) -> Result<(), E>,
    ) -> Result<(), BakeError<E>> {
        self.bake_these(&self.batches()[batches], sink)
    }

    fn bake_these<E: Send>(
        &self,
        batches: &[Range<usize>],
        mut sink: impl FnMut(usize, Block) -> Result<(), E>,
    ) -> Result<(), BakeError<E>> {
        let first = Solver::new(&self.medium, self.params);
        let solver = first.map_err(|why| BakeError::Solve { first: 0, last: 0, why })?;
        let haar = Haar::new(self.medium.cells);
        let wave = rayon::current_num_threads().max(1);
        for batch in batches.chunks(wave) {
            let solved: Vec<Result<Vec<Block>, SolveError>> =
                batch.par_iter().map(|lights| self.solve(&solver, &haar, lights.clone())).collect();
            for (lights, blocks) in batch.iter().zip(solved) {
                let (first, last) = (lights.start, lights.end - 1);
                let blocks = blocks.map_err(|why| BakeError::Solve { first, last, why })?;
                for (light, block) in lights.clone().zip(blocks) {
                    sink(light, block).map_err(BakeError::Sink)?;
                }
            }
        }
        Ok(())
    }

    /// The fields of some lights of one batch, not packed: components times cells each.
    ///
    /// # Errors
    /// [`SolveError`].
    pub fn fields(&self, solver: &Solver, lights: Range<usize>) -> Result<Vec<Vec<f32>>, SolveError> {
        let (window, corner) = self.window(lights.start);
        let windowed;
        let solver = if self.medium.periodic {
            windowed = solver.at(&window);
            &windowed
        } else {
            solver
        };
        let point = |light: usize| {
            let (p, h) = (self.lights.position_m(light), self.medium.spacing_m);
            let position_m = [p[0] - corner[0] as f64 * h[0], p[1] - corner[1] as f64 * h[1], p[2]];
            [PointSource { position_m, intensity: 1.0 }]
        };
        let (cells, scattered) = (self.medium.len(), solver.scattered());
        // What collisions even out needs no bytes.
        let stored = |mut moments: Vec<f32>| {
            for (field, share) in moments.chunks_mut(cells).zip(&scattered) {
                field.iter_mut().for_each(|v| *v *= share);
            }
            moments
        };
        for light in lights.clone() {
            super::ordinates::check_sources(&[&point(light)])?;
        }
        // Each light alone where that can be: it stops when it has converged and its numbers stay near the processor.
        let alone: Option<Vec<Vec<f32>>> = lights
            .clone()
            .map(|light| {
                let solved = match self.content {
                    Content::Total => {
                        solver.towards_one(&solver.direct(&point(light)), false).map(|s| s.map(|(towards, _)| towards))
                    }
                    Content::Diffuse => {
                        solver.diffuse_one(&solver.direct_moments(&point(light))).map(|solved| solved.map(stored))
                    }
                };
                solved.transpose()
            })
            .collect::<Result<_, _>>()?;
        if let Some(fields) = alone {
            return Ok(fields);
        }
        let points: Vec<[PointSource; 1]> = lights.map(point).collect();
        let lanes: Vec<&[PointSource]> = points.iter().map(|p| &p[..]).collect();
        let (solved, _) = solver.solve(&lanes)?;
        let moments = self.components();
        Ok(solved
            .into_iter()
            .map(|light| match self.content {
                Content::Total => light.towards,
                // From cell by cell to moment by moment.
                Content::Diffuse => {
                    stored((0..moments * cells).map(|i| light.diffuse[i % cells * moments + i / cells]).collect())
                }
            })
            .collect())
    }

    /// The blocks of some lights of one batch.
    ///
    /// # Errors
    /// [`SolveError`].
    pub fn solve(&self, solver: &Solver, haar: &Haar, lights: Range<usize>) -> Result<Vec<Block>, SolveError> {
        let fields = self.fields(solver, lights)?;
        Ok(fields.into_iter().map(|mut f| Block::pack(haar, &mut f, self.packing, self.norm())).collect())
    }

    /// The window of a light's column and its corner in cells.
    pub fn window(&self, light: usize) -> (Medium, [i64; 2]) {
        self.medium.window(self.lights.position_m(light))
    }

    /// A name by content: equal recipes, equal names; 32 hexadecimal digits.
    pub fn name(&self) -> String {
        let bytes = super::file::header(self);
        let (a, b) = (super::file::hash(&bytes, 0), super::file::hash(&bytes, 0x5bd1_e995));
        format!("{a:016x}{b:016x}")
    }
}

impl Basis {
    /// Bakes everything in memory.
    ///
    /// # Errors
    /// [`BakeError::Solve`].
    pub fn bake(recipe: Recipe) -> Result<Self, BakeError<std::convert::Infallible>> {
        let mut blocks = Vec::with_capacity(recipe.lights.len());
        recipe.bake(0..recipe.batches().len(), |_, block| {
            blocks.push(block);
            Ok(())
        })?;
        Ok(Self { recipe, blocks })
    }

    /// Bakes the batches that hold the given lights alone and leaves all others dark: what a few bolts need of a large basis.
    ///
    /// # Errors
    /// [`BakeError::Solve`].
    pub fn bake_for(recipe: Recipe, lights: &BTreeSet<usize>) -> Result<Self, BakeError<std::convert::Infallible>> {
        let mut batches = recipe.batches();
        batches.retain(|batch| lights.range(batch.clone()).next().is_some());
        let haar = Haar::new(recipe.medium.cells);
        let mut nothing = vec![0.0; recipe.components() * recipe.medium.len()];
        let mut blocks = vec![Block::pack(&haar, &mut nothing, recipe.packing, 1.0); recipe.lights.len()];
        recipe.bake_these(&batches, |light, block| {
            blocks[light] = block;
            Ok(())
        })?;
        Ok(Self { recipe, blocks })
    }

    /// Bytes of the coefficients.
    pub fn bytes(&self) -> usize {
        self.blocks.iter().map(Block::bytes).sum()
    }

    /// Relative error of storing, over all lights (root of summed squares).
    pub fn error(&self) -> f64 {
        let sum = |k: usize| self.blocks.iter().map(|b| b.squares[k]).sum::<f64>();
        if sum(0) > 0.0 { (sum(1) / sum(0)).sqrt() } else { 0.0 }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::scattering::ordinates::tests::patchy;

    pub(crate) fn small(content: Content, periodic: bool) -> Recipe {
        let mut medium = patchy([8, 8, 4], [1.0; 3], 1.0);
        medium.periodic = periodic;
        Recipe {
            lights: Lights::even([5, 4, 3], medium.size_m(), 2.0, periodic).expect("legal"),
            params: Params { albedo: 0.99, rays: 256, ..Params::default() },
            content,
            packing: Packing { threshold: 1e-4, width: Width::F16 },
            medium,
        }
    }

    #[test]
    fn shares_merge_to_the_whole_bit_for_bit_on_any_number_of_threads() {
        for periodic in [false, true] {
            let recipe = small(Content::Total, periodic);
            let whole = Basis::bake(recipe.clone()).expect("baked");
            let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("a pool");
            let mut merged = Vec::new();
            for share in [2, 0, 1] {
                pool.install(|| {
                    recipe.bake(recipe.share(share, 3), |light, block| {
                        merged.push((light, block));
                        Ok::<(), ()>(())
                    })
                })
                .expect("baked");
            }
            merged.sort_by_key(|(light, _)| *light);
            assert_eq!(merged.len(), 60);
            assert!(merged.iter().zip(&whole.blocks).all(|((_, a), b)| a == b));
            assert!(whole.error() > 0.0 && whole.error() < 0.05, "{}", whole.error());
        }
    }

    #[test]
    fn a_part_of_a_basis_is_that_part_and_the_rest_is_dark() {
        let recipe = small(Content::Diffuse, false);
        let whole = Basis::bake(recipe.clone()).expect("baked");
        let part = Basis::bake_for(recipe, &BTreeSet::from([17, 18])).expect("baked");
        assert!(part.blocks.iter().zip(&whole.blocks).enumerate().all(|(light, (part, whole))| {
            if (16..32).contains(&light) { part == whole } else { part.values.is_empty() }
        }));
    }

    #[test]
    fn names_follow_content() {
        let recipe = small(Content::Total, false);
        let mut other = recipe.clone();
        assert_eq!(recipe.name(), other.name());
        other.medium.extinction_per_m[7] += 1e-3;
        assert_ne!(recipe.name(), other.name());
        let mut other = recipe.clone();
        other.params.tolerance = 2e-4;
        assert_ne!(recipe.name(), other.name());
    }
}
