//! One weather layer on its way: every quantity eases on its own span, so that an edit of one disturbs no other.

use crate::clouds::CloudKind;
use crate::geo::Geodetic;

use super::command::{LayerChange, LayerSpec};
use super::drift::{Drift, Wind};
use super::ease::{Eased, Scale, Span, mix, smoothstep};
use super::snapshot::LayerState;

/// A layer with its past and its future.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    cover: Cover,
    base_m: Eased,
    thickness_m: Eased,
    density: Eased,
    drift: Drift,
    /// When it came out of clear air.
    since: Span,
    leaving: bool,
}

/// Type and coverage together: a layer that changes its type clears first and comes back as the other.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cover {
    old: (CloudKind, f64),
    new: (CloudKind, f64),
    span: Span,
}

impl Cover {
    fn at(&self, now_s: f64) -> (CloudKind, f64) {
        let progress = self.span.progress(now_s);
        if self.old.0 == self.new.0 {
            (self.new.0, mix(self.old.1, self.new.1, smoothstep(progress)))
        } else if progress < 0.5 {
            (self.old.0, mix(self.old.1, 0.0, smoothstep(2.0 * progress)))
        } else {
            (self.new.0, mix(0.0, self.new.1, smoothstep(2.0 * progress - 1.0)))
        }
    }

    fn aim(&mut self, new: (CloudKind, f64), span: Span) {
        if new == self.new && span.end_s() >= self.span.end_s() {
            return;
        }
        *self = Self { old: self.at(span.begin_s), new, span };
    }
}

impl Layer {
    /// A layer that comes out of clear air.
    pub fn appearing(spec: &LayerSpec, here: &Geodetic, span: Span) -> Self {
        let resting = |value| Eased::resting(value, Scale::Linear);
        Self {
            cover: Cover { old: (spec.kind, 0.0), new: (spec.kind, spec.coverage), span },
            base_m: resting(spec.base_m),
            thickness_m: resting(spec.thickness_m),
            density: resting(spec.density),
            drift: Drift::new(wind(spec, here), span.begin_s),
            since: span,
            leaving: false,
        }
    }

    /// Turns every quantity to that of `spec`, the wind as meant at `here`.
    pub fn aim(&mut self, spec: &LayerSpec, here: &Geodetic, span: Span) {
        self.leaving = false;
        self.cover.aim((spec.kind, spec.coverage), span);
        self.base_m.aim(spec.base_m, span);
        self.thickness_m.aim(spec.thickness_m, span);
        self.density.aim(spec.density, span);
        self.drift.aim(wind(spec, here), span);
    }

    /// Turns only what is named, or differs from where it goes, to that of `spec`.
    pub fn aim_named(&mut self, spec: &LayerSpec, named: &LayerChange, here: &Geodetic, span: Span) {
        let old = self.target();
        if named.kind.is_some() || named.coverage.is_some() || (old.kind, old.coverage) != (spec.kind, spec.coverage) {
            self.cover.aim((spec.kind, spec.coverage), span);
        }
        if named.base_m.is_some() || old.base_m != spec.base_m {
            self.base_m.aim(spec.base_m, span);
        }
        if named.thickness_m.is_some() || old.thickness_m != spec.thickness_m {
            self.thickness_m.aim(spec.thickness_m, span);
        }
        if named.density.is_some() || old.density != spec.density {
            self.density.aim(spec.density, span);
        }
        let wind_named = named.wind_speed_mps.is_some() || named.wind_from_deg.is_some();
        if wind_named || (old.wind_speed_mps, old.wind_from_deg) != (spec.wind_speed_mps, spec.wind_from_deg) {
            self.drift.aim(wind(spec, here), span);
        } else if old.base_m != spec.base_m {
            // The same wind at another height: the same speed is another angular velocity.
            self.drift.aim(Wind { height_m: spec.base_m, ..*self.drift.target() }, span);
        }
    }

    /// Clears away where it is.
    pub fn leave(&mut self, span: Span) {
        self.leaving = true;
        self.cover.aim((self.cover.at(span.begin_s).0, 0.0), span);
    }

    /// Whether it is clearing away for good.
    pub fn leaving(&self) -> bool {
        self.leaving
    }

    /// Whether it has cleared away for good.
    pub fn gone(&self, now_s: f64) -> bool {
        self.leaving && self.cover.span.done(now_s)
    }

    /// Whether it comes, goes, or changes its type.
    pub fn turns(&self, now_s: f64) -> bool {
        let Cover { old, new, span } = self.cover;
        !self.since.done(now_s) || (self.leaving || old.0 != new.0) && !span.done(now_s)
    }

    /// How much it is there as a storm cell, and as any other cloud, whatever its coverage: 0 to 1 each.
    pub fn cell_or_other(&self, now_s: f64) -> [f64; 2] {
        let Cover { old, new, span } = self.cover;
        let progress = span.progress(now_s);
        let (kind, share) = if old.0 == new.0 {
            (new.0, if self.leaving { 1.0 - smoothstep(progress) } else { 1.0 })
        } else if progress < 0.5 {
            (old.0, 1.0 - smoothstep(2.0 * progress))
        } else {
            (new.0, smoothstep(2.0 * progress - 1.0))
        };
        let share = share * self.since.smooth(now_s);
        if kind == CloudKind::StormCell { [share, 0.0] } else { [0.0, share] }
    }

    /// What it is when every transition is over.
    pub fn target(&self) -> LayerSpec {
        let wind = self.drift.target();
        LayerSpec {
            kind: self.cover.new.0,
            base_m: self.base_m.target(),
            thickness_m: self.thickness_m.target(),
            coverage: self.cover.new.1,
            density: self.density.target(),
            wind_speed_mps: wind.speed_mps,
            wind_from_deg: wind.from_deg,
        }
    }

    /// What it is at a time not before its last edit.
    pub fn at(&self, now_s: f64) -> LayerState {
        let (kind, coverage) = self.cover.at(now_s);
        let (wind_speed_mps, wind_from_deg) = self.drift.wind_at(now_s);
        LayerState {
            kind,
            base_m: self.base_m.at(now_s),
            thickness_m: self.thickness_m.at(now_s),
            coverage,
            density: self.density.at(now_s),
            wind_speed_mps,
            wind_from_deg,
            drift: self.drift.at(now_s),
        }
    }
}

fn wind(spec: &LayerSpec, here: &Geodetic) -> Wind {
    Wind { reference: *here, height_m: spec.base_m, speed_mps: spec.wind_speed_mps, from_deg: spec.wind_from_deg }
}
