//! Fields that are there or on their way: each request is solved once, whichever views and strokes ask for it.
//!
//! Where a picture must not depend on anything but its snapshot (lockstep, `render`) the asker waits. Running free a field
//! is solved on a thread of its own and nobody waits: until it is there its points stand in, and the picture is provisional. So
//! it is while a solve stands in for a table that is being baked; when the lights are there, the field is made again by the table,
//! and the picture turns from the one to the other over some frames.

use super::solve;
use super::tables::Tables;
use super::{Field, Request};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};
use std::sync::{Arc, LazyLock};

/// Fields kept at once: 256 KiB each.
const KEPT: usize = 32;
/// Fields solved at once in the background; further ones wait for their turn.
const AT_ONCE: usize = 2;
/// Pictures over which a field takes the place of what stood in for it: a third of a second at 30 a second.
pub const TURNING: u32 = 10;
/// Pictures without a field after which all are forgotten.
const PATIENCE: u32 = 600;
/// Pictures without a field after which tables are forgotten, which take longer to make: ten minutes at 60 a second.
const TABLES_PATIENCE: u32 = 36_000;

/// What came of a request.
#[derive(Clone, Debug)]
pub enum Found {
    /// The field; `None` where there is no cloud to light.
    Ready(Option<Arc<Field>>),
    /// The field, which has begun to take the place of what stood in for it.
    Turning {
        /// What stood in.
        from: Arc<Field>,
        /// The field.
        to: Arc<Field>,
        /// Its share of the light, above 0 and below 1.
        share: f32,
    },
    /// Still being solved.
    Pending,
}

/// A field that is kept.
struct Kept {
    request: Arc<Request>,
    field: Option<Arc<Field>>,
    /// What stood in for it, and the pictures since the field came.
    before: Option<(Arc<Field>, u32)>,
}

impl Kept {
    /// What the next picture that does not wait is lit by.
    fn next(&mut self) -> Found {
        let Some((from, pictures)) = &mut self.before else { return Found::Ready(self.field.clone()) };
        *pictures += 1;
        match &self.field {
            Some(to) if *pictures < TURNING => {
                Found::Turning { from: from.clone(), to: to.clone(), share: *pictures as f32 / TURNING as f32 }
            }
            _ => {
                self.before = None;
                Found::Ready(self.field.clone())
            }
        }
    }
}

/// A quarter of the cores and at least one: the threads that pictures are drawn with stay with the pictures. None where the
/// system gives no threads.
pub(super) fn beside() -> Option<&'static ThreadPool> {
    static POOL: LazyLock<Option<ThreadPool>> = LazyLock::new(|| {
        let threads = (rayon::current_num_threads() / 4).max(1);
        ThreadPoolBuilder::new().num_threads(threads).thread_name(|i| format!("relight-{i}")).build().ok()
    });
    POOL.as_ref()
}

/// Keeps fields, and solves those that are asked for.
#[derive(Default)]
pub struct Store {
    kept: VecDeque<Kept>,
    pending: Vec<(Arc<Request>, Receiver<Option<Field>>)>,
    idle: u32,
    solved: usize,
    tables: Arc<Tables>,
    /// Whether sums of tables are left to a device.
    on_device: bool,
}

/// The field of a request by its method, in a table's light if it needs one.
fn field(request: &Request, tables: &Arc<Tables>, wait: bool, on_device: bool) -> Option<Field> {
    let by_table = request.method.method().table().is_some();
    if by_table { tables.field(request, wait, on_device) } else { solve::field(request) }
}

impl Store {
    /// An empty store over these tables, which it may share with others. `on_device`: whoever reads its fields sums tables of the
    /// published scheme itself ([`super::sum`]).
    pub fn new(tables: Arc<Tables>, on_device: bool) -> Self {
        Self { tables, on_device, ..Self::default() }
    }

    /// The fields of a picture, in order. `wait`: until all of them are there.
    pub fn fields(&mut self, requests: &[Arc<Request>], wait: bool) -> Vec<Found> {
        self.gather();
        if requests.is_empty() {
            self.idle = self.idle.saturating_add(1);
            if self.idle > PATIENCE {
                self.kept = VecDeque::new();
            }
            if self.idle == TABLES_PATIENCE {
                self.tables.forget();
            }
            return Vec::new();
        }
        self.idle = 0;
        requests.iter().map(|request| self.field(request, wait)).collect()
    }

    /// Fields that are kept now.
    pub fn len(&self) -> usize {
        self.kept.len()
    }

    /// Whether nothing is kept.
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    /// Begins a field that will be asked for, unless there is it already or as much as can be done at once is being done.
    pub fn prepare(&mut self, request: &Arc<Request>) {
        let known = self.kept.iter().map(|kept| &kept.request).chain(self.pending.iter().map(|(known, _)| known));
        if self.pending.len() < AT_ONCE && !known.into_iter().any(|known| known == request) {
            self.begin(request.clone());
        }
    }

    /// The tables of virtual lights.
    pub fn tables(&self) -> &Arc<Tables> {
        &self.tables
    }

    /// How many fields have been solved or begun since the store was made.
    pub fn solved(&self) -> usize {
        self.solved
    }

    fn field(&mut self, request: &Arc<Request>, wait: bool) -> Found {
        // What stands in is no answer to who waits.
        let serves = |kept: &Kept| !wait || kept.field.as_ref().is_none_or(|field| !field.stand_in);
        if let Some(at) = self.kept.iter().position(|kept| kept.request == *request && serves(kept))
            && let Some(mut kept) = self.kept.remove(at)
        {
            let found = if wait { Found::Ready(kept.field.clone()) } else { kept.next() };
            let stands_in = kept.field.as_ref().is_some_and(|field| field.stand_in);
            self.kept.push_front(kept);
            if stands_in && self.has_room_for(request) && self.tables.has(request) {
                self.begin(request.clone());
            }
            return found;
        }
        let under_way = self.pending.iter().position(|(known, _)| known == request);
        if wait {
            let solved = match under_way.map(|at| self.pending.swap_remove(at)) {
                // A thread that is gone has left nothing: once more, here.
                Some((_, result)) => {
                    let made = result.recv().ok().filter(|made| made.as_ref().is_none_or(|made| !made.stand_in));
                    made.unwrap_or_else(|| field(request, &self.tables, true, self.on_device))
                }
                None => {
                    self.solved += 1;
                    field(request, &self.tables, true, self.on_device)
                }
            };
            let found = self.keep(request.clone(), solved);
            // Who waited has the field whole.
            self.kept.iter_mut().take(1).for_each(|kept| kept.before = None);
            return Found::Ready(found);
        }
        if self.has_room_for(request) {
            self.begin(request.clone());
        }
        Found::Pending
    }

    /// Whether a field may be begun that is not under way.
    fn has_room_for(&self, request: &Arc<Request>) -> bool {
        self.pending.len() < AT_ONCE && self.pending.iter().all(|(known, _)| known != request)
    }

    /// Solves in the background.
    fn begin(&mut self, request: Arc<Request>) {
        let (send, result) = sync_channel(1);
        let given = request.clone();
        let thread = std::thread::Builder::new().name("relight".into());
        let (tables, on_device) = (self.tables.clone(), self.on_device);
        let solve = move || match beside() {
            Some(pool) => pool.install(|| field(&given, &tables, false, on_device)),
            None => field(&given, &tables, false, on_device),
        };
        // Nobody may be left to take it.
        if thread.spawn(move || drop(send.send(solve()))).is_ok() {
            self.pending.push((request, result));
            self.solved += 1;
        }
    }

    /// Takes what the background has finished.
    fn gather(&mut self) {
        for (request, result) in std::mem::take(&mut self.pending) {
            match result.try_recv() {
                Ok(solved) => drop(self.keep(request, solved)),
                Err(TryRecvError::Empty) => self.pending.push((request, result)),
                // It panicked: no field, and it is not tried again.
                Err(TryRecvError::Disconnected) => drop(self.keep(request, None)),
            }
        }
    }

    fn keep(&mut self, request: Arc<Request>, solved: Option<Field>) -> Option<Arc<Field>> {
        let field = solved.map(Arc::new);
        let old = self.kept.iter().position(|kept| kept.request == request).and_then(|at| self.kept.remove(at));
        let stood_in = old.and_then(|old| old.field).filter(|old| old.stand_in);
        let before = stood_in.filter(|_| field.as_ref().is_some_and(|field| !field.stand_in)).map(|old| (old, 0));
        self.kept.push_front(Kept { request, field: field.clone(), before });
        self.kept.truncate(KEPT);
        field
    }
}
