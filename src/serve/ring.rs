//! The frames under way, in the order in which they will go out: some being drawn, some repeats waiting for their turn.

use super::inbox::Posted;
use super::step::StepGuard;
use crate::frame::Pixels;
use crate::plan::FramePlan;
use std::collections::VecDeque;
use std::sync::Arc;

/// One frame under way.
pub(super) struct Slot {
    ticket: u64,
    round: u64,
    pub(super) view: String,
    pub(super) plan: Arc<FramePlan>,
    pub(super) posted: Posted,
    pub(super) guard: Option<Arc<StepGuard>>,
    /// Nothing has changed: goes out with the pixels of the view's frame before.
    pub(super) repeats: bool,
    /// The executor has it.
    pub(super) drawing: bool,
    /// It will never have pixels.
    pub(super) given_up: bool,
    pub(super) pixels: Option<Arc<Pixels>>,
    /// They stand in for something still being made.
    pub(super) provisional: bool,
    pub(super) attempts: u32,
    pub(super) submitted_us: u64,
    pub(super) finished_us: u64,
}

impl Slot {
    pub(super) fn new(
        view: String,
        plan: Arc<FramePlan>,
        posted: Posted,
        guard: Option<Arc<StepGuard>>,
        repeats: bool,
    ) -> Self {
        Self {
            ticket: 0,
            round: 0,
            view,
            plan,
            posted,
            guard,
            repeats,
            drawing: false,
            given_up: false,
            pixels: None,
            provisional: false,
            attempts: 0,
            submitted_us: 0,
            finished_us: 0,
        }
    }

    fn ready(&self) -> bool {
        self.pixels.is_some() || self.repeats || self.given_up
    }
}

/// The frames under way.
#[derive(Default)]
pub(super) struct Ring {
    slots: VecDeque<Slot>,
    next_ticket: u64,
    round: u64,
}

impl Ring {
    /// The slots pushed from now on belong to another snapshot.
    pub(super) fn begin_round(&mut self) {
        self.round += 1;
    }

    /// Adds a slot at the end; its ticket is returned.
    pub(super) fn push(&mut self, mut slot: Slot) -> u64 {
        self.next_ticket += 1;
        slot.ticket = self.next_ticket;
        slot.round = self.round;
        self.slots.push_back(slot);
        self.next_ticket
    }

    pub(super) fn slot_mut(&mut self, ticket: u64) -> Option<&mut Slot> {
        self.slots.iter_mut().find(|slot| slot.ticket == ticket)
    }

    /// The oldest slot, if it can go out.
    pub(super) fn pop_ready(&mut self) -> Option<Slot> {
        if self.slots.front()?.ready() { self.slots.pop_front() } else { None }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.slots.is_empty()
    }

    /// How many the executor has.
    pub(super) fn drawing(&self) -> usize {
        self.slots.iter().filter(|slot| slot.drawing).count()
    }

    /// How many snapshots are under way.
    pub(super) fn rounds(&self) -> usize {
        match (self.slots.front(), self.slots.back()) {
            (Some(first), Some(last)) => (last.round - first.round + 1) as usize,
            _ => 0,
        }
    }

    pub(super) fn drawing_tickets(&self) -> Vec<u64> {
        self.slots.iter().filter(|slot| slot.drawing).map(|slot| slot.ticket).collect()
    }

    /// All that have no pixels and will not go out by themselves.
    pub(super) fn unfinished_tickets(&self) -> Vec<u64> {
        self.slots.iter().filter(|slot| slot.pixels.is_none() && !slot.given_up).map(|slot| slot.ticket).collect()
    }

    /// The picture that these repeat will not come: they are given up as well.
    pub(super) fn forget_repeats(&mut self, view: &str, why: &str) {
        for slot in self.slots.iter_mut().filter(|slot| slot.view == view && slot.repeats) {
            slot.repeats = false;
            slot.given_up = true;
            if let Some(guard) = &slot.guard {
                guard.fail(why);
            }
        }
    }
}
