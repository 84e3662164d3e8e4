//! One piece of cloud and its table: read from the cache, baked batch by batch, and what of it a flash needs.

use super::super::cache::{Cache, Key, key};
use super::super::cloud::{medium, window};
use super::super::patch::recipe;
use super::super::solve::{self, stored};
use super::super::{Field, Lighting, Request, Window, sum};
use crate::numeric::haar::Haar;
use crate::scattering::basis::Recipe;
use crate::scattering::compress::Block;
use crate::scattering::lanes::LANES;
use crate::scattering::ordinates::{PointSource, Solver};
use crate::scattering::relight::{Relighter, Table};
use std::collections::BTreeSet;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock};

/// One piece and as much of its table as there is.
pub struct Piece {
    /// What decides it: a request without points.
    cloud: Request,
    /// Its cells.
    pub window: Window,
    /// What its table is made by.
    pub recipe: Recipe,
    solver: Solver,
    haar: Haar,
    /// Lights that are solved together.
    pub batches: Vec<Range<usize>>,
    /// The blocks of each batch; none where light could not be found.
    pub made: Vec<OnceLock<Option<Vec<Block>>>>,
    /// Batches that a flash has asked for: they come first.
    pub wanted: Mutex<BTreeSet<usize>>,
    bytes: AtomicUsize,
    /// Batches that are not there yet.
    left: AtomicUsize,
    /// Where its table is kept beyond this program's life, and under which name.
    shelf: Option<(Arc<Cache>, Key)>,
}

impl Piece {
    /// A piece as much of whose table is there as the cache has; `None` where there is no cloud. Gives the lights that were read.
    pub fn new(request: &Request, cache: Option<Arc<Cache>>) -> Option<(Self, usize)> {
        let cloud = Request { points: Vec::new(), ..request.clone() };
        let window = window(&cloud);
        let medium = medium(&cloud, &window).ok()?;
        if medium.is_empty() {
            return None;
        }
        let solver = solve::solver()?.at(&medium);
        let haar = Haar::new(medium.cells);
        let recipe = recipe(&cloud, &window, medium)?;
        let batches = recipe.batches();
        let made = batches.iter().map(|_| OnceLock::new()).collect();
        let wanted = Mutex::new(BTreeSet::new());
        let bytes = AtomicUsize::new(solver.memory_bytes() + size_of_val(recipe.medium.extinction_per_m.as_slice()));
        let left = AtomicUsize::new(batches.len());
        let shelf = cache.map(|cache| (cache, key(&recipe)));
        let piece = Self { cloud, window, recipe, solver, haar, batches, made, wanted, bytes, left, shelf };
        let read = piece.load();
        Some((piece, read))
    }

    /// Takes what the cache has: whole batches, and how many lights they are.
    fn load(&self) -> usize {
        let Some((cache, key)) = &self.shelf else { return 0 };
        let (mut run, mut next, mut read) = (Vec::new(), usize::MAX, 0);
        cache.load(key, &self.recipe, |light, block| {
            let batch = light / LANES;
            let Range { start, end } = self.batches[batch];
            if light == start {
                run.clear();
            } else if light != next {
                // What does not begin with its batch is of no use.
                next = usize::MAX;
                return;
            }
            run.push(block);
            next = light + 1;
            if next == end && self.put(batch, std::mem::take(&mut run)) {
                read += end - start;
            }
        });
        read
    }

    /// Makes a batch known; false if it was.
    fn put(&self, batch: usize, blocks: Vec<Block>) -> bool {
        let bytes: usize = blocks.iter().map(Block::memory_bytes).sum();
        let is_new = self.made[batch].set(Some(blocks)).is_ok();
        if is_new {
            self.bytes.fetch_add(bytes, Ordering::Relaxed);
            self.left.fetch_sub(1, Ordering::Relaxed);
        }
        is_new
    }

    /// Whether a request's table is this one.
    pub fn is_of(&self, request: &Request) -> bool {
        let Request { kind, layer, earth_m, points: _, method, patch } = request;
        let own = &self.cloud;
        (own.kind, own.method, own.earth_m, own.patch) == (*kind, *method, *earth_m, *patch) && own.layer == *layer
    }

    /// Memory that it takes, bytes.
    pub fn bytes(&self) -> usize {
        self.bytes.load(Ordering::Relaxed)
    }

    /// Lights that are there.
    pub fn lights(&self) -> usize {
        self.batches.iter().zip(&self.made).filter(|(_, made)| made.get().is_some()).map(|(batch, _)| batch.len()).sum()
    }

    /// Whether all of some batches are there.
    pub fn has(&self, batches: &[usize]) -> bool {
        batches.iter().all(|batch| self.made[*batch].get().is_some())
    }

    /// The batches of the lights that stand for some points.
    pub fn due(&self, sources: &[PointSource]) -> Vec<usize> {
        let lights = sources.iter().flat_map(|source| self.recipe.lights.shares(source.position_m).lights);
        let due: BTreeSet<usize> = lights.map(|(light, _)| light / LANES).collect();
        due.into_iter().collect()
    }

    /// Bakes a batch that is not there yet and puts it into the cache; gives the lights that were baked now.
    pub fn bake(&self, batch: usize) -> usize {
        let mut baked = 0;
        let made = self.made[batch].get_or_init(|| {
            let solve = || self.recipe.solve(&self.solver, &self.haar, self.batches[batch].clone());
            baked = self.batches[batch].len();
            // A batch that panics gives no light, and the others are baked all the same.
            let blocks = catch_unwind(AssertUnwindSafe(solve)).ok()?.ok()?;
            let bytes = blocks.iter().map(Block::memory_bytes).sum();
            self.bytes.fetch_add(bytes, Ordering::Relaxed);
            Some(blocks)
        });
        if baked > 0 {
            let last = self.left.fetch_sub(1, Ordering::AcqRel) == 1;
            self.keep(batch, made.as_deref(), last);
        }
        baked
    }

    /// Puts a batch into the cache, or, with the `last` one, the whole table.
    fn keep(&self, batch: usize, made: Option<&[Block]>, last: bool) {
        let Some((cache, key)) = &self.shelf else { return };
        let all = || self.made.iter().map(|made| made.get().and_then(Option::as_deref)).collect::<Option<Vec<_>>>();
        if let Some(all) = last.then(all).flatten() {
            cache.put_whole(key, &self.recipe, all.into_iter().flatten());
        } else if let Some(blocks) = made {
            cache.put_share(key, &self.recipe, self.batches[batch].start, blocks);
        }
    }

    /// The field of points whose lights are there; `None` where the light of one was not found.
    /// `on_device`: its sum is left to a device that can make it.
    pub fn field(&self, request: &Request, sources: &[PointSource], due: &[usize], on_device: bool) -> Option<Field> {
        if !due.iter().all(|batch| matches!(self.made[*batch].get(), Some(Some(_)))) {
            return None;
        }
        let set = &self.solver.angles().set;
        if on_device
            && request.method == Lighting::Basis
            && let Some(field) = sum::field(request, self.window, set, self, sources)
        {
            return Some(field);
        }
        let relighter = Relighter::new(&self.recipe.medium, &self.solver);
        let relit = relighter.relight_from(request.method.method(), sources, Some(self)).ok()?;
        Some(stored(request, self.window, set, &relit))
    }
}

impl Table for Piece {
    fn recipe(&self) -> &Recipe {
        &self.recipe
    }

    fn block(&self, light: usize) -> Option<&Block> {
        self.made[light / LANES].get()?.as_ref()?.get(light % LANES)
    }
}
