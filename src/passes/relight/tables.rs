//! Tables of virtual lights for pieces of cloud: kept by content, baked while nobody waits, within a cap of memory.
//!
//! A picture that waits has just those lights baked that its flashes need. Running free nothing waits: until the lights are there a
//! flash is solved for itself (which is what a table is to save), the picture is provisional, and the rest of the piece is
//! baked in the background, one piece at a time.

use super::cloud::{medium, window};
use super::patch::recipe;
use super::solve::{self, sources, stored};
use super::{Field, Lighting, Request, Window};
use crate::numeric::haar::Haar;
use crate::scattering::basis::Recipe;
use crate::scattering::compress::Block;
use crate::scattering::lanes::LANES;
use crate::scattering::ordinates::{PointSource, Solver};
use crate::scattering::relight::{Relighter, Table};
use rayon::prelude::*;
use std::collections::{BTreeSet, VecDeque};
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, Weak};

/// Memory that tables may take unless set otherwise, bytes.
const USUAL_BYTES: usize = 256 << 20;

/// Tables of the pieces of cloud that have been struck, latest first.
pub struct Tables {
    kept: Mutex<VecDeque<Arc<Piece>>>,
    most_bytes: AtomicUsize,
    /// Whether a thread bakes in the background.
    filling: AtomicBool,
}

impl Default for Tables {
    fn default() -> Self {
        Self {
            kept: Mutex::new(VecDeque::new()),
            most_bytes: AtomicUsize::new(USUAL_BYTES),
            filling: AtomicBool::new(false),
        }
    }
}

/// One piece and as much of its table as has been baked.
struct Piece {
    /// What decides it: a request without points.
    cloud: Request,
    window: Window,
    recipe: Recipe,
    solver: Solver,
    haar: Haar,
    batches: Vec<Range<usize>>,
    /// The blocks of each batch; none where light could not be found.
    made: Vec<OnceLock<Option<Vec<Block>>>>,
    /// Batches that a flash has asked for: they come first.
    wanted: Mutex<BTreeSet<usize>>,
    bytes: AtomicUsize,
}

impl Tables {
    /// Sets how much memory tables may take, bytes.
    pub fn set_most(&self, bytes: usize) {
        self.most_bytes.store(bytes, Ordering::Relaxed);
    }

    /// Memory that tables take, bytes.
    pub fn bytes(&self) -> usize {
        held(&self.kept())
    }

    /// Lights that have been baked, and those of all pieces that are kept.
    pub fn progress(&self) -> [usize; 2] {
        let kept = self.kept();
        let sum = |count: &dyn Fn(&Piece) -> usize| kept.iter().map(|piece| count(piece)).sum();
        [
            sum(&|p| p.batches.iter().zip(&p.made).filter(|(_, m)| m.get().is_some()).map(|(b, _)| b.len()).sum()),
            sum(&|p| p.recipe.lights.len()),
        ]
    }

    /// The field of a request of a method with a table. `wait`: its lights are baked now if they are not there; else it is solved.
    pub fn field(self: &Arc<Self>, request: &Request, wait: bool) -> Option<Field> {
        let piece = self.piece(request)?;
        let sources = sources(&request.points, &piece.window);
        let due = piece.due(&sources);
        let there = due.iter().all(|batch| piece.made[*batch].get().is_some());
        if wait || there {
            due.par_iter().for_each(|batch| piece.bake(*batch));
            self.trim(0);
            if let Some(field) = piece.field(request, &sources, &due) {
                return Some(field);
            }
        } else {
            lock(&piece.wanted).extend(&due);
            self.fill();
        }
        // Where the table's light was not found no table will come.
        let stand_in = !there && !wait;
        let solved = solve::field(&Request { method: Lighting::Solve, ..request.clone() })?;
        Some(Field { stand_in, ..solved })
    }

    fn kept(&self) -> MutexGuard<'_, VecDeque<Arc<Piece>>> {
        lock(&self.kept)
    }

    /// The piece of a request, begun if it is new; `None` where there is no cloud.
    fn piece(&self, request: &Request) -> Option<Arc<Piece>> {
        let cloud = Request { points: Vec::new(), ..request.clone() };
        let known = |kept: &mut VecDeque<Arc<Piece>>| {
            let at = kept.iter().position(|piece| piece.cloud == cloud)?;
            let piece = kept.remove(at)?;
            kept.push_front(piece.clone());
            Some(piece)
        };
        if let Some(piece) = known(&mut self.kept()) {
            return Some(piece);
        }
        let piece = Arc::new(Piece::new(cloud.clone())?);
        let mut kept = self.kept();
        // Another thread may have been quicker.
        let piece = known(&mut kept).unwrap_or_else(|| {
            kept.push_front(piece.clone());
            piece
        });
        drop(kept);
        self.trim(1);
        Some(piece)
    }

    /// Forgets the pieces that were not asked for longest, down to `least` of them, until the rest fits.
    fn trim(&self, least: usize) -> bool {
        let mut kept = self.kept();
        let most = self.most_bytes.load(Ordering::Relaxed);
        while held(&kept) > most && kept.len() > least {
            kept.pop_back();
        }
        held(&kept) <= most
    }

    /// Bakes in the background until every piece is whole or memory is full, or nobody holds the tables any more.
    fn fill(self: &Arc<Self>) {
        if self.filling.swap(true, Ordering::AcqRel) {
            return;
        }
        let weak = Arc::downgrade(self);
        let work = move || {
            // On this thread, not on those that solve beside the pictures: a flash that needs a solve does not wait for a batch.
            while fill_one(&weak) {}
            if let Some(tables) = weak.upgrade() {
                tables.filling.store(false, Ordering::Release);
                // What was asked for since the last look found the thread still at work.
                if tables.trim(1) && tables.next().is_some() {
                    tables.fill();
                }
            }
        };
        if std::thread::Builder::new().name("bake".into()).spawn(work).is_err() {
            self.filling.store(false, Ordering::Release);
        }
    }

    /// What to bake next: what flashes wait for, then the rest of the piece that was asked for last.
    fn next(&self) -> Option<(Arc<Piece>, usize)> {
        let kept = self.kept();
        let wanted = |piece: &Arc<Piece>| {
            let mut wanted = lock(&piece.wanted);
            std::iter::from_fn(|| wanted.pop_first()).find(|batch| piece.made[*batch].get().is_none())
        };
        let any = |piece: &Arc<Piece>| piece.made.iter().position(|made| made.get().is_none());
        let first = kept.iter().find_map(|piece| wanted(piece).map(|batch| (piece.clone(), batch)));
        first.or_else(|| kept.iter().find_map(|piece| any(piece).map(|batch| (piece.clone(), batch))))
    }
}

/// Bakes the next batch; false when there is nothing to do.
fn fill_one(tables: &Weak<Tables>) -> bool {
    let Some(tables) = tables.upgrade() else { return false };
    // The piece at work stays; where it alone is too large, it stays as it is.
    if !tables.trim(1) {
        return false;
    }
    let Some((piece, batch)) = tables.next() else { return false };
    piece.bake(batch);
    true
}

fn held(kept: &VecDeque<Arc<Piece>>) -> usize {
    kept.iter().map(|piece| piece.bytes.load(Ordering::Relaxed)).sum()
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // What is guarded is whole between any two statements.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Piece {
    fn new(cloud: Request) -> Option<Self> {
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
        Some(Self { cloud, window, recipe, solver, haar, batches, made, wanted, bytes })
    }

    /// The batches of the lights that stand for some points.
    fn due(&self, sources: &[PointSource]) -> Vec<usize> {
        let lights = sources.iter().flat_map(|source| self.recipe.lights.shares(source.position_m).lights);
        let due: BTreeSet<usize> = lights.map(|(light, _)| light / LANES).collect();
        due.into_iter().collect()
    }

    fn bake(&self, batch: usize) {
        self.made[batch].get_or_init(|| {
            let solve = || self.recipe.solve(&self.solver, &self.haar, self.batches[batch].clone());
            // A batch that panics gives no light, and the others are baked all the same.
            let blocks = catch_unwind(AssertUnwindSafe(solve)).ok()?.ok()?;
            let bytes = blocks.iter().map(|block| block.memory_bytes()).sum();
            self.bytes.fetch_add(bytes, Ordering::Relaxed);
            Some(blocks)
        });
    }

    /// The field of points whose lights are there; `None` where the light of one was not found.
    fn field(&self, request: &Request, sources: &[PointSource], due: &[usize]) -> Option<Field> {
        if !due.iter().all(|batch| matches!(self.made[*batch].get(), Some(Some(_)))) {
            return None;
        }
        let relighter = Relighter::new(&self.recipe.medium, &self.solver);
        let relit = relighter.relight_from(request.method.method(), sources, Some(self)).ok()?;
        Some(stored(request, self.window, &self.solver.angles().set, &relit))
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

#[cfg(test)]
mod tests {
    use super::super::patch;
    use super::super::tests::request;
    use super::*;

    /// A flash of one point in a piece of overcast.
    fn struck(method: Lighting, position_m: [f32; 3]) -> Request {
        let solved = request(600.0, 1.0, 0.03, vec![super::super::Point { position_m, share: 1.0 }]);
        let window = patch::window(1_000.0, 600.0, patch::wide_m(600.0, 0.0));
        Request { method, patch: Some(window), ..solved }
    }

    fn relative(found: &Field, truth: &Field) -> f64 {
        let square =
            |f: &dyn Fn(usize) -> f32| (0..truth.quotients.len()).map(|i| f64::from(f(i)).powi(2)).sum::<f64>();
        (square(&|i| found.quotients[i][0] - truth.quotients[i][0]) / square(&|i| truth.quotients[i][0])).sqrt()
    }

    #[test]
    fn a_table_lights_as_a_solve_does_and_bakes_what_is_asked_for_alone() {
        let tables = Arc::new(Tables::default());
        let at = [210.0, -130.0, 1_320.0];
        let truth = solve::field(&struck(Lighting::Solve, at)).expect("a cloud");
        let found = tables.field(&struck(Lighting::Hybrid, at), true).expect("a cloud");
        assert!(!found.stand_in && found.method == Lighting::Hybrid.method());
        // Lights stand two cells, eighteen free paths, apart: what is scattered more often is blended between their places, far
        // from where it comes from (0.4 to 0.5 of b in such decks). All of it is still better than none of it.
        let single = solve::field(&struck(Lighting::Single, at)).expect("a cloud");
        let (error, without) = (relative(&found, &truth), relative(&single, &truth));
        assert!(error < 0.7 && error < 0.75 * without, "{error} {without}");
        let [baked, all] = tables.progress();
        assert!(baked > 0 && baked * 10 < all, "{baked} of {all}");
        let bytes = tables.bytes();
        assert!(bytes > 0);
        // The same place again costs nothing, and another flash in the cloud finds the piece.
        assert_eq!(tables.field(&struck(Lighting::Hybrid, at), true).expect("a cloud"), found);
        assert_eq!((tables.progress(), tables.bytes()), ([baked, all], bytes));
        tables.field(&struck(Lighting::Hybrid, [900.0, 500.0, 1_200.0]), true).expect("a cloud");
        assert_eq!(tables.progress()[1], all);
        // Memory that is full forgets.
        tables.set_most(1);
        tables.field(&struck(Lighting::Hybrid, at), true).expect("lit all the same");
        assert_eq!((tables.bytes(), tables.progress()), (0, [0, 0]));
        let clear = Request {
            layer: crate::passes::deck::Layer { theta: 1.0, ..struck(Lighting::Hybrid, at).layer },
            ..struck(Lighting::Hybrid, at)
        };
        assert!(tables.field(&clear, true).is_none());
    }

    #[test]
    fn running_free_a_solve_stands_in_until_the_lights_are_there() {
        let tables = Arc::new(Tables::default());
        let flash = struck(Lighting::Hybrid, [40.0, 30.0, 1_250.0]);
        let first = tables.field(&flash, false).expect("a cloud");
        assert!(first.stand_in && first.method == Lighting::Solve.method());
        // What the background does, here: the flash's own lights come first.
        let weak = Arc::downgrade(&tables);
        let piece = tables.piece(&flash).expect("begun");
        let due = piece.due(&sources(&flash.points, &piece.window));
        while !due.iter().all(|batch| piece.made[*batch].get().is_some()) {
            assert!(fill_one(&weak));
        }
        let second = tables.field(&flash, false).expect("a cloud");
        assert!(!second.stand_in);
        // By whomever and whenever lights are baked: the same bits.
        assert_eq!(Arc::new(Tables::default()).field(&flash, true), Some(second));
    }
}
