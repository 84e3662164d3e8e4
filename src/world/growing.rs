//! Channels of flashes: grown once, beside the world or by whoever cannot go on without them, and shared from then on.

use crate::lightning::strike::{StrikeChannel, StrikeSpec, grow_strike};
use crate::lightning::tables::Tables;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};

/// A channel that is to be grown, is being grown or has been. Cheap to hold; what it holds is made once.
#[derive(Debug)]
pub struct Growing {
    spec: StrikeSpec,
    /// Tables that depend on grids alone, of whoever grew last.
    tables: Arc<Mutex<Tables>>,
    channel: OnceLock<Option<Arc<StrikeChannel>>>,
}

impl Growing {
    pub(super) fn new(spec: StrikeSpec, tables: Arc<Mutex<Tables>>) -> Self {
        Self { spec, tables, channel: OnceLock::new() }
    }

    /// The channel; where it has not been grown yet, grows it here, or waits for who is at it. A few milliseconds.
    ///
    /// `None`: it could not be grown, which no specification that the world accepts causes; then the flash lights clouds and
    /// ground as a point.
    pub fn grow(&self) -> Option<Arc<StrikeChannel>> {
        let grown = self.channel.get_or_init(|| {
            // Not held while growing: others grow meanwhile, each with tables of its own if need be.
            let mut tables = self.tables.lock().unwrap_or_else(PoisonError::into_inner).clone();
            let grown = grow_strike(&self.spec, &mut tables, &AtomicBool::new(false)).ok().map(Arc::new);
            *self.tables.lock().unwrap_or_else(PoisonError::into_inner) = tables;
            grown
        });
        grown.clone()
    }

    /// The channel if it is there already; never waits.
    pub fn grown(&self) -> Option<Arc<StrikeChannel>> {
        self.channel.get().cloned().flatten()
    }

    /// Whether nothing is left to be grown.
    pub fn done(&self) -> bool {
        self.channel.get().is_some()
    }
}

/// Grows those of several channels that are not there yet, on all cores: a picture that waits for a thousand at once waits for
/// its turn on each core, not on one. Each is a function of its own specification, so that the order does not matter.
pub(super) fn grow_all<'a>(channels: impl Iterator<Item = &'a Arc<Growing>>) {
    let missing: Vec<&Growing> = channels.map(Arc::as_ref).filter(|growing| !growing.done()).collect();
    missing.par_iter().for_each(|growing| {
        growing.grow();
    });
}

/// The channels of all flashes that are not over, by the flashes' numbers. Clones share them, so that a look ahead grows
/// nothing twice.
#[derive(Clone, Debug, Default)]
pub(super) struct Channels {
    held: Arc<Mutex<Held>>,
    tables: Arc<Mutex<Tables>>,
}

#[derive(Debug, Default)]
struct Held {
    /// Each with the simulation time from which on nobody needs it any more.
    channels: BTreeMap<u64, (Arc<Growing>, f64)>,
    /// Those that nobody has been given yet to grow.
    fresh: Vec<Weak<Growing>>,
}

impl Channels {
    /// The channel of a flash: the one that is held, or a new one. Held until `until_s`, as whoever asks last knows it.
    pub fn of(&self, flash: u64, until_s: f64, spec: impl FnOnce() -> StrikeSpec) -> Arc<Growing> {
        let mut held = self.held.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((growing, until)) = held.channels.get_mut(&flash) {
            *until = until_s;
            return growing.clone();
        }
        let growing = Arc::new(Growing::new(spec(), self.tables.clone()));
        held.channels.insert(flash, (growing.clone(), until_s));
        held.fresh.push(Arc::downgrade(&growing));
        growing
    }

    /// Lets go of the channels that nobody needs any more at a simulation time.
    pub fn forget(&self, now_s: f64) {
        let mut held = self.held.lock().unwrap_or_else(PoisonError::into_inner);
        held.channels.retain(|_, (_, until_s)| *until_s > now_s);
        held.fresh.retain(|growing| growing.strong_count() > 0);
    }

    /// The channels that are still to be grown and that nobody has been given yet.
    pub fn take_fresh(&self) -> Vec<Arc<Growing>> {
        let mut held = self.held.lock().unwrap_or_else(PoisonError::into_inner);
        held.fresh.drain(..).filter_map(|growing| growing.upgrade()).filter(|growing| !growing.done()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::command::{FlashKind, Polarity};

    fn spec(seed: u64) -> StrikeSpec {
        StrikeSpec {
            kind: FlashKind::CloudToGround,
            polarity: Polarity::Negative,
            seed,
            origin_m: 2_000.0,
            cloud_m: [1_000.0, 3_000.0],
            grounds_m: Vec::new(),
        }
    }

    #[test]
    fn a_flash_has_one_channel_until_it_is_over() {
        let channels = Channels::default();
        let first = channels.of(1, 5.0, || spec(1));
        let again = channels.clone().of(1, 7.0, || spec(9));
        assert!(Arc::ptr_eq(&first, &again) && !Arc::ptr_eq(&first, &channels.of(2, 5.0, || spec(1))));
        assert_eq!(channels.take_fresh().len(), 2);
        assert!(channels.take_fresh().is_empty(), "each is given out once");
        assert!(first.grown().is_none() && !first.done());
        let grown = first.grow().expect("a right specification");
        assert!(Arc::ptr_eq(&grown, &again.grown().expect("the same")));
        let weak = Arc::downgrade(&grown);
        drop((grown, first, again));
        channels.forget(6.0);
        assert!(weak.upgrade().is_some(), "needed until 7 s");
        channels.forget(7.0);
        assert!(weak.upgrade().is_none(), "nobody holds what is over");
    }

    #[test]
    fn what_is_over_is_not_given_out() {
        let channels = Channels::default();
        drop(channels.of(1, 5.0, || spec(1)));
        channels.forget(5.0);
        assert!(channels.take_fresh().is_empty());
    }
}
