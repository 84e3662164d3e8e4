//! Which part of a channel shines, and how much light each stretch of it gives.

use super::{Stretch, StrikeChannel};
use crate::lightning::flash::Light;

/// The light of a channel's parts while some lights shine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lit {
    parts: Vec<Part>,
}

/// One light, spread evenly over what it lights.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    /// The bit of its ground point.
    ground: u8,
    branches: bool,
    /// From where to where along the channel it shines, m; `None`: all of it.
    span_m: Option<[f64; 2]>,
    /// Light of a metre of main channel.
    per_metre: f64,
}

/// Fineness at which the light of a part of a channel is measured, m.
const MEASURED_M: f32 = 3.0;

impl Lit {
    /// A ground point that the channel does not have is taken as the last one that it has; what has no length gives no light.
    pub(super) fn new(channel: &StrikeChannel, lights: &[Light]) -> Self {
        let mut parts: Vec<Part> = Vec::new();
        for light in lights.iter().filter(|light| light.amount > 0.0) {
            let ground = (light.channel as usize).min(channel.grounds - 1);
            let [begin, end] = light.span;
            let whole = begin <= 0.0 && end >= 1.0;
            let reach_m = channel.reach_m[ground];
            let mut part = Part {
                ground: 1 << ground,
                branches: light.branches,
                span_m: (!whole).then_some([begin * reach_m, end * reach_m]),
                per_metre: 1.0,
            };
            let lit_m = if whole {
                channel.main_m[ground] + if light.branches { channel.side_m[ground] } else { 0.0 }
            } else {
                let mut sum = 0.0;
                channel.visit(MEASURED_M, |stretch| sum += part.of(channel, &stretch));
                sum
            };
            if lit_m > 0.0 {
                part.per_metre = light.amount / lit_m;
                parts.push(part);
            }
        }
        Self { parts }
    }

    /// Light of a stretch, in the unit of the lights.
    pub fn of(&self, channel: &StrikeChannel, stretch: &Stretch) -> f64 {
        self.parts.iter().map(|part| part.of(channel, stretch)).sum()
    }

    /// Whether nothing shines.
    pub fn is_dark(&self) -> bool {
        self.parts.is_empty()
    }
}

impl Part {
    fn of(&self, channel: &StrikeChannel, stretch: &Stretch) -> f64 {
        if stretch.grounds & self.ground == 0 || stretch.side && !self.branches {
            return 0.0;
        }
        let light_m = f64::from(stretch.light_m) * self.per_metre;
        let Some([begin_m, end_m]) = self.span_m else { return light_m };
        let along = |point: u32| f64::from(channel.points[point as usize].along_m);
        let (from_m, to_m) = (along(stretch.from), along(stretch.to));
        let inside_m = to_m.min(end_m) - from_m.max(begin_m);
        if to_m > from_m { light_m * (inside_m / (to_m - from_m)).clamp(0.0, 1.0) } else { 0.0 }
    }
}
