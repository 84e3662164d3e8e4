//! Tables of virtual lights for pieces of cloud: kept by content, baked while nobody waits, within a cap of memory, and in a folder
//! beyond the program's life if there is one ([`super::cache`]).
//!
//! A picture that waits has just those lights baked that its flashes need. Running free nothing waits: until the lights are there a
//! flash is solved for itself (which is what a table is to save), the picture is provisional, and the rest of the piece is
//! baked in the background, one piece at a time.

mod piece;

use super::cache::Cache;
use super::solve::{self, sources};
use super::{Field, Lighting, Request};
use piece::Piece;
use rayon::prelude::*;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

/// Memory that tables may take unless set otherwise, bytes.
const USUAL_BYTES: usize = 256 << 20;

/// Tables of the pieces of cloud that have been struck, latest first.
pub struct Tables {
    kept: Mutex<VecDeque<Arc<Piece>>>,
    most_bytes: AtomicUsize,
    /// Whether a thread bakes in the background.
    filling: AtomicBool,
    /// Lights baked, and lights read from the cache, since the beginning.
    made: [AtomicU64; 2],
    cache: Option<Arc<Cache>>,
}

/// How far tables are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// Lights that are there, of the pieces that are kept.
    pub lights: u64,
    /// All lights of these pieces.
    pub of: u64,
    /// Whether some are being baked in the background.
    pub baking: bool,
    /// Lights that were baked since the program began.
    pub baked: u64,
    /// Lights that were read from the cache.
    pub read: u64,
    /// Memory that tables take, bytes.
    pub memory_bytes: u64,
    /// Bytes of the cache; 0 without one.
    pub cache_bytes: u64,
    /// Files of the cache that were refused.
    pub refused: u64,
}

impl Default for Tables {
    fn default() -> Self {
        Self::new(None)
    }
}

impl Tables {
    /// No tables yet; those that are baked are kept in the cache, if there is one.
    pub fn new(cache: Option<Arc<Cache>>) -> Self {
        Self {
            kept: Mutex::new(VecDeque::new()),
            most_bytes: AtomicUsize::new(USUAL_BYTES),
            filling: AtomicBool::new(false),
            made: Default::default(),
            cache,
        }
    }

    /// Sets how much memory tables may take, bytes.
    pub fn set_most(&self, bytes: usize) {
        self.most_bytes.store(bytes, Ordering::Relaxed);
    }

    /// Memory that tables take, bytes.
    pub fn bytes(&self) -> usize {
        held(&self.kept())
    }

    /// How far they are.
    pub fn status(&self) -> Status {
        let kept = self.kept();
        let sum = |count: &dyn Fn(&Piece) -> usize| kept.iter().map(|piece| count(piece) as u64).sum();
        let [baked, read] = [0, 1].map(|k: usize| self.made[k].load(Ordering::Relaxed));
        Status {
            lights: sum(&Piece::lights),
            of: sum(&|piece| piece.recipe.lights.len()),
            baking: self.filling.load(Ordering::Relaxed),
            baked,
            read,
            memory_bytes: held(&kept) as u64,
            cache_bytes: self.cache.as_ref().map_or(0, |cache| cache.bytes()),
            refused: self.cache.as_ref().map_or(0, |cache| cache.refused()),
        }
    }

    /// What went wrong with the cache since this was asked last, each once.
    pub fn complaints(&self) -> Vec<String> {
        self.cache.as_ref().map_or_else(Vec::new, |cache| cache.complaints())
    }

    /// Forgets all tables; those in the cache stay.
    pub fn forget(&self) {
        *self.kept() = VecDeque::new();
    }

    /// The field of a request of a method with a table. `wait`: its lights are baked now if they are not there; else it is solved.
    /// `on_device`: what a device can sum is left to it.
    pub fn field(self: &Arc<Self>, request: &Request, wait: bool, on_device: bool) -> Option<Field> {
        let piece = self.piece(request)?;
        let sources = sources(&request.points, &piece.window);
        let due = piece.due(&sources);
        let there = piece.has(&due);
        if wait || there {
            due.par_iter().for_each(|batch| self.bake(&piece, *batch));
            self.trim(0);
            if let Some(field) = piece.field(request, &sources, &due, on_device) {
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

    /// Whether the lights are there that a request needs, for which something stands in.
    pub fn has(&self, request: &Request) -> bool {
        let known = self.kept().iter().find(|piece| piece.is_of(request)).cloned();
        known.is_some_and(|piece| piece.has(&piece.due(&sources(&request.points, &piece.window))))
    }

    /// Bakes the whole table of a request now, telling how many of its lights are there each time there are more; gives how many
    /// had to be baked, and how many could not be. `None` where there is no cloud.
    pub fn bake_whole(&self, request: &Request, told: impl Fn(usize, usize) + Sync) -> Option<[usize; 2]> {
        let piece = self.piece(request)?;
        let all = piece.recipe.lights.len();
        let before = self.made[0].load(Ordering::Relaxed);
        told(piece.lights(), all);
        (0..piece.batches.len()).into_par_iter().for_each(|batch| {
            self.bake(&piece, batch);
            told(piece.lights(), all);
        });
        let failed = piece.batches.iter().zip(&piece.made).filter(|(_, made)| !matches!(made.get(), Some(Some(_))));
        let failed = failed.map(|(batch, _)| batch.len()).sum();
        Some([(self.made[0].load(Ordering::Relaxed) - before) as usize, failed])
    }

    fn bake(&self, piece: &Piece, batch: usize) {
        self.made[0].fetch_add(piece.bake(batch) as u64, Ordering::Relaxed);
    }

    fn kept(&self) -> MutexGuard<'_, VecDeque<Arc<Piece>>> {
        lock(&self.kept)
    }

    /// The piece of a request, begun if it is new; `None` where there is no cloud.
    fn piece(&self, request: &Request) -> Option<Arc<Piece>> {
        let known = |kept: &mut VecDeque<Arc<Piece>>| {
            let at = kept.iter().position(|piece| piece.is_of(request))?;
            let piece = kept.remove(at)?;
            kept.push_front(piece.clone());
            Some(piece)
        };
        if let Some(piece) = known(&mut self.kept()) {
            return Some(piece);
        }
        let (piece, read) = Piece::new(request, self.cache.clone())?;
        self.made[1].fetch_add(read as u64, Ordering::Relaxed);
        let piece = Arc::new(piece);
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
    tables.bake(&piece, batch);
    true
}

fn held(kept: &VecDeque<Arc<Piece>>) -> usize {
    kept.iter().map(|piece| piece.bytes()).sum()
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // What is guarded is whole between any two statements.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests;
