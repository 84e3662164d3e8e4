//! Exact dielectric breakdown, the fast way: only the candidates' potentials, from an incremental Green's function.
//!
//! What it is: with the cells S held at values b, phi(c) = base(c) + G(c,S) G(S,S)^-1 (b - base(S)). One more held cell adds
//! one row to the Cholesky factor of G(S,S) and one number V(c) to each candidate: V(c) = (G(c,s) - V(c) V(s)) / d, and phi(c) += z V(c).
//!
//! How it is made lazy and stays exact: growing only lowers potentials (maximum principle), so an old potential is a bound
//! of the new one. Draw from the bounds; bring the drawn candidate up to date; take it with the chance of its true
//! weight over the bound, else keep the true weight as its new bound and draw again. That is rejection sampling from the true weights.

use super::super::channel::{Channel, Info, Stop};
use super::super::error::{GrowError, in_range};
use super::super::frontier::{Candidate, Frontier, Step};
use super::super::grow::{ETA_RANGE, Order};
use super::super::random::Stream;
use super::super::scene::Goal;
use super::super::tables::Tables;
use super::super::urn::Urn;
use super::bound::{Bound, near_channel};
use super::held::{Held, Row};
use super::{Weight, field_cells};
use std::sync::atomic::Ordering;

/// Most cells held, grown or otherwise: the factor then takes 144 MB. More obstacles are refused; growth stops there.
pub const MOST_HELD_CELLS: usize = 6000;
/// Targets up to which a fresh candidate gets a cheap bound; with more it is brought up to date at once.
const FEW_TARGETS: usize = 4;

/// Grows a channel by the incremental Green's function.
pub(in super::super) fn exact(order: &Order<'_>, eta: f64, tables: &mut Tables) -> Result<(Channel, Info), GrowError> {
    in_range("eta", eta, ETA_RANGE)?;
    let scene = order.scene;
    let map = scene.checked()?;
    let in_field = field_cells(scene, &map)?;
    let targets = if scene.goal == Goal::Ground { 0 } else { scene.targets().len() };
    let given = scene.obstacles.len() + targets;
    if given >= MOST_HELD_CELLS {
        return Err(GrowError::TooManyFixed { cells: given, limit: MOST_HELD_CELLS - 1 });
    }
    let most_cells = order.most_cells.min((MOST_HELD_CELLS - given) as u32);
    let (frontier, step) = Frontier::new(scene, map, &[]);
    if frontier.finished() {
        return Ok(frontier.end(Stop::Reached, 0, 0.0));
    }
    let held = Held::new(scene, tables)?;
    let urn = Urn::default();
    let mut growth = Growth { held, rows: Vec::new(), parents: Vec::new(), urn, weight: Weight::new(eta), in_field };
    growth.run(frontier, step, most_cells, order)
}

/// The candidates with their rows and bounds.
struct Growth {
    held: Held,
    rows: Vec<Row>,
    parents: Vec<u32>,
    urn: Urn,
    weight: Weight,
    in_field: Option<Vec<bool>>,
}

impl Growth {
    fn run(
        &mut self,
        mut frontier: Frontier,
        mut step: Step,
        most_cells: u32,
        order: &Order<'_>,
    ) -> Result<(Channel, Info), GrowError> {
        let mut stream = Stream::new(order.seed, 0);
        let mut draws = 0;
        for &cell in &order.scene.obstacles {
            if !self.held.on_border(cell) {
                self.held.hold(cell, 0.0);
            }
        }
        self.hold_targets(&frontier);
        let mut drawn = None;
        loop {
            if frontier.finished() {
                return Ok(frontier.end(Stop::Reached, draws, 0.0));
            }
            if frontier.cells() >= most_cells {
                return Ok(frontier.end(Stop::CellLimit, draws, 0.0));
            }
            self.take_step(&frontier, &step, drawn.take());
            let slot = loop {
                if order.cancel.load(Ordering::Relaxed) {
                    return Err(frontier.cancelled());
                }
                draws += 1;
                let Some(slot) = self.urn.draw(stream.unit()) else {
                    return Ok(frontier.end(Stop::Exhausted, draws, 0.0));
                };
                let bound = self.urn.weight(slot);
                let weight = self.weight.of(self.held.potential(&mut self.rows[slot]));
                if stream.unit() * bound < weight {
                    break slot;
                }
                self.urn.set(slot, weight.min(bound));
            };
            self.urn.swap_remove(slot);
            let parent = self.parents.swap_remove(slot);
            let row = self.rows.swap_remove(slot);
            let candidate = Candidate { cell: row.cell, parent };
            drawn = Some(row);
            frontier.grow(candidate, &mut step);
        }
    }

    /// Holds what has joined the channel and takes up fresh candidates.
    fn take_step(&mut self, frontier: &Frontier, step: &Step, mut drawn: Option<Row>) {
        for &cell in &step.taken {
            if let Some(slot) = self.rows.iter().position(|row| row.cell == cell) {
                self.rows.swap_remove(slot);
                self.parents.swap_remove(slot);
                self.urn.swap_remove(slot);
            }
        }
        for &cell in &step.charged {
            match drawn.take_if(|row| row.cell == cell) {
                Some(row) => self.held.hold_row(row, 0.0),
                None => self.held.hold(cell, 0.0),
            }
        }
        if step.retargeted && !self.rows.is_empty() {
            self.hold_targets(frontier);
            // A new target raises potentials: old bounds are none, so every candidate is brought up to date.
            for (slot, row) in self.rows.iter_mut().enumerate() {
                self.held.sum_again(row);
                self.urn.set(slot, self.weight.of(self.held.potential(row)));
            }
        }
        self.insert(frontier, step);
    }

    fn hold_targets(&mut self, frontier: &Frontier) {
        for &cell in frontier.active.iter().filter(|_| !frontier.ground) {
            self.held.hold(cell, 1.0);
        }
    }

    fn insert(&mut self, frontier: &Frontier, step: &Step) {
        let targets = if frontier.ground { &[][..] } else { &frontier.active[..] };
        let bound = (targets.len() <= FEW_TARGETS).then(|| {
            let tip = step.charged.last().copied().unwrap_or(frontier.scene.start);
            let near = near_channel(frontier, tip, Bound::room(targets.len()));
            let values = targets.iter().map(|&cell| (cell, 1.0)).chain(near.into_iter().map(|cell| (cell, 0.0)));
            Bound::new(&self.held, values)
        });
        let mut bounds = Vec::with_capacity(step.fresh.len());
        for &Candidate { cell, parent } in &step.fresh {
            let dark = self.in_field.as_ref().is_some_and(|reached| !reached[cell as usize]);
            let mut row = self.held.row(cell, dark);
            bounds.push(match &bound {
                _ if dark => 0.0,
                // A margin for rounding: a bound must not be below the truth.
                Some(bound) => bound.at(&self.held, &row) * (1.0 + 1e-9),
                None => self.held.potential(&mut row),
            });
            self.rows.push(row);
            self.parents.push(parent);
        }
        self.weight.refer_to(bounds.iter().copied());
        for potential in bounds {
            self.urn.push(self.weight.of(potential));
        }
    }
}
