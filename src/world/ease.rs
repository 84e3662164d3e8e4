//! Easing: how a quantity goes from an old to a new value over a span of simulation time, without a jump or a kink.

/// A span of simulation time over which something changes; of no length, the change is immediate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Span {
    /// Simulation time at which it begins.
    pub begin_s: f64,
    /// Its length in seconds, at least 0.
    pub length_s: f64,
}

impl Span {
    /// Share of the span that has passed, 0 to 1.
    pub fn progress(&self, now_s: f64) -> f64 {
        if self.length_s > 0.0 { ((now_s - self.begin_s) / self.length_s).clamp(0.0, 1.0) } else { 1.0 }
    }

    /// Smoothstep of the progress: weight of the new value.
    pub fn smooth(&self, now_s: f64) -> f64 {
        smoothstep(self.progress(now_s))
    }

    /// Whether it is over.
    pub fn done(&self, now_s: f64) -> bool {
        self.progress(now_s) >= 1.0
    }

    /// Simulation time at which it is over.
    pub fn end_s(&self) -> f64 {
        self.begin_s + self.length_s
    }

    /// Seconds of the old and of the new value since the beginning: the integrals of `1 - smooth` and `smooth`, in
    /// closed form, and going on after the end (where only the new value counts).
    pub fn seconds_of_old_and_new(&self, now_s: f64) -> (f64, f64) {
        let passed_s = (now_s - self.begin_s).max(0.0);
        if passed_s >= self.length_s {
            return (self.length_s / 2.0, self.length_s / 2.0 + (passed_s - self.length_s));
        }
        let u = passed_s / self.length_s;
        let new_s = self.length_s * u * u * u * (1.0 - u / 2.0);
        (passed_s - new_s, new_s)
    }
}

/// 3 u^2 - 2 u^3 for u in 0 to 1: no slope at either end.
pub fn smoothstep(u: f64) -> f64 {
    u * u * (3.0 - 2.0 * u)
}

/// From `a` to `b`, with both ends met to the bit.
pub fn mix(a: f64, b: f64, weight: f64) -> f64 {
    if weight <= 0.0 {
        a
    } else if weight >= 1.0 || a == b {
        b
    } else {
        a + (b - a) * weight
    }
}

/// On what scale a quantity eases.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// By equal factors: for visibility, which spans four decades.
    Logarithmic,
}

/// A quantity on its way from an old to a new value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eased {
    from: f64,
    to: f64,
    span: Span,
    scale: Scale,
}

impl Eased {
    /// At rest.
    pub fn resting(value: f64, scale: Scale) -> Self {
        Self { from: value, to: value, span: Span::default(), scale }
    }

    /// The value at a time not before the last `aim`.
    pub fn at(&self, now_s: f64) -> f64 {
        let weight = self.span.smooth(now_s);
        match self.scale {
            Scale::Linear => mix(self.from, self.to, weight),
            Scale::Logarithmic if weight <= 0.0 => self.from,
            Scale::Logarithmic if weight >= 1.0 || self.from == self.to => self.to,
            Scale::Logarithmic => (self.from.ln() + (self.to / self.from).ln() * weight).exp(),
        }
    }

    /// Where it goes.
    pub fn target(&self) -> f64 {
        self.to
    }

    /// Whether it has arrived.
    pub fn done(&self, now_s: f64) -> bool {
        self.span.done(now_s)
    }

    /// Turns to a new value from where it is now. The same value again changes nothing, unless it is wanted sooner:
    /// a host that repeats its weather every second does not start the transition anew each time.
    pub fn aim(&mut self, to: f64, span: Span) {
        if to == self.to && span.end_s() >= self.span.end_s() {
            return;
        }
        *self = Self { from: self.at(span.begin_s), to, span, scale: self.scale };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_closed_integral_is_the_integral() {
        let span = Span { begin_s: 5.0, length_s: 40.0 };
        for end_s in [5.0, 12.0, 25.0, 45.0, 60.0] {
            let steps = 4000;
            let step = (end_s - 5.0) / f64::from(steps);
            let sum: f64 = (0..steps).map(|k| span.smooth(5.0 + (f64::from(k) + 0.5) * step) * step).sum();
            let (old_s, new_s) = span.seconds_of_old_and_new(end_s);
            // Midpoint rule: h^2 / 24 * length * S'' with h = 0.01 s, S'' up to 6/1600: 1e-6.
            assert!((new_s - sum).abs() < 2e-6, "{end_s}: {new_s} {sum}");
            assert!((old_s + new_s - (end_s - 5.0)).abs() < 1e-12);
        }
    }

    #[test]
    fn ends_are_met_to_the_bit_and_the_way_is_smooth() {
        for scale in [Scale::Linear, Scale::Logarithmic] {
            let mut value = Eased::resting(0.3, scale);
            value.aim(2.9, Span { begin_s: 10.0, length_s: 20.0 });
            assert_eq!((value.at(10.0), value.at(30.0), value.at(1e6)), (0.3, 2.9, 2.9), "{scale:?}");
            let step = 1e-3;
            for k in 0..40_000 {
                let t = 0.0_f64.max(10.0 - 5.0 + f64::from(k) * step);
                // Slope of smoothstep is at most 1.5 per length: 1.5 / 20 s * 2.6 * 1e-3 s, doubled for the logarithm's bend.
                assert!((value.at(t + step) - value.at(t)).abs() < 5e-4, "{scale:?} at {t}");
            }
        }
    }

    #[test]
    fn the_same_target_again_goes_on_unless_it_is_wanted_sooner() {
        let mut value = Eased::resting(0.0, Scale::Linear);
        value.aim(1.0, Span { begin_s: 0.0, length_s: 10.0 });
        let before = value;
        value.aim(1.0, Span { begin_s: 4.0, length_s: 10.0 });
        assert_eq!(value, before);
        value.aim(1.0, Span { begin_s: 4.0, length_s: 0.0 });
        assert_eq!(value.at(4.0), 1.0);
    }
}
