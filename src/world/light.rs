//! What flashes show in an interval: the light of each, and of all together no more flicker than the guard allows.

use crate::geo::Geodetic;
use crate::lightning::flash::{Flash, Light};
use crate::lightning::guard::FlickerGuard;
use std::borrow::Cow;

use super::command::{FlashKind, Polarity};
use super::snapshot::FlashState;

/// An interval of no length is one instant, which is taken to be so long.
const INSTANT_S: f64 = 1e-6;

/// A flash with its place and its beginning.
#[derive(Clone, Debug)]
pub(super) struct Ongoing<'a> {
    pub id: u64,
    pub position: Geodetic,
    pub kind: FlashKind,
    pub polarity: Polarity,
    pub seed: u64,
    pub begin_s: f64,
    pub flash: Cow<'a, Flash>,
}

impl Ongoing<'_> {
    /// The same with strokes of its own.
    pub fn into_owned(self) -> Ongoing<'static> {
        let Self { id, position, kind, polarity, seed, begin_s, flash } = self;
        Ongoing { id, position, kind, polarity, seed, begin_s, flash: Cow::Owned(flash.into_owned()) }
    }

    /// Simulation time at which its last light ends.
    pub fn end_s(&self) -> f64 {
        self.begin_s + self.flash.duration_s()
    }
}

/// The flashes of which some part lies in `[begin_s, end_s)`, with their light in it. `ongoing` must hold all flashes that have
/// strokes in [`FlickerGuard::memory_s`] before and in the interval, where there is a guard.
pub(super) fn states(
    ongoing: &[Ongoing<'_>],
    begin_s: f64,
    end_s: f64,
    guard: Option<FlickerGuard>,
) -> Vec<FlashState> {
    let passed = guard.map(|guard| {
        let strokes = |flash: &Ongoing<'_>| {
            let (id, first_s) = (flash.id, flash.begin_s);
            flash.flash.strokes.iter().enumerate().map(move |(n, stroke)| (first_s + stroke.delay_s, id, n)).collect()
        };
        guard.passed(ongoing.iter().flat_map(|flash| -> Vec<_> { strokes(flash) }))
    });
    let length_s = (end_s - begin_s).max(INSTANT_S);
    let mut states = Vec::new();
    for flash in ongoing {
        let (first_s, last_s) = (flash.begin_s, flash.end_s());
        if last_s <= begin_s || first_s > begin_s && first_s >= end_s {
            continue;
        }
        let since_s = begin_s - first_s;
        let kept = |n: usize| passed.as_ref().is_none_or(|passed| passed.contains(&(flash.id, n)));
        let lights = flash.flash.lights_in(since_s, since_s + length_s, kept);
        let lights: Vec<Light> = lights.into_iter().map(|light| light.mean(length_s)).collect();
        let flux_lm: f64 = lights.iter().map(|light| light.amount).sum();
        states.push(FlashState {
            id: flash.id,
            position: flash.position,
            kind: flash.kind,
            polarity: flash.polarity,
            seed: flash.seed,
            peak_current_ka: flash.flash.strokes.first().map_or(0.0, |stroke| stroke.peak_current_ka),
            begin_s: first_s,
            end_s: last_s,
            intensity_cd: flux_lm / (4.0 * std::f64::consts::PI),
            ground_points_m: flash.flash.ground_points_m.clone(),
            lights,
            channel: None,
        });
    }
    states
}
