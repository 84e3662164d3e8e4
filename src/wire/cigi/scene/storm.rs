//! Storms: random lightning in the extent of a layer, as a storm of the world.

use super::Moment;
use crate::world::command::{RegionShape, StormRequest, StrikeRequest};
use crate::world::storms;

/// Flashes a minute by severity, 0 to 5: chosen, since the standard says only that the rate follows severity.
const FLASHES_PER_MINUTE: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 30.0];
/// Factor on the current by severity: chosen, since the standard says only that strength follows severity.
const STRENGTH: [f64; 6] = [0.6, 0.75, 0.9, 1.0, 1.15, 1.3];
/// About three quarters of all flashes do not reach the ground (Rakov and Uman 2003, "Lightning", chapter 1).
const INSIDE_SHARE: f64 = 0.75;
/// About a tenth of the flashes to ground are positive (Rakov and Uman 2003, chapter 5).
const POSITIVE_SHARE: f64 = 0.1;
/// A storm that moves is moved in the world when it is off by more, of its smaller size.
const STEP_SHARE: f64 = 0.05;
/// Strikes that are asked for by themselves have numbers from here on, beyond those of the schedule.
const SINGLE: u64 = 1 << 47;

/// Lightning over an outline.
#[derive(Clone, Debug, PartialEq)]
pub struct Storm {
    /// Where.
    pub shape: RegionShape,
    /// Height of the light above the ellipsoid; `None`: in the lowest cloud.
    pub base_m: Option<f64>,
    /// 0 to 5.
    pub severity: u8,
    /// Seed.
    pub seed: u64,
    /// The layer's number, so that two storms in one place differ.
    pub layer: u8,
}

impl Storm {
    /// Its name in the world.
    pub fn name(&self) -> String {
        let place = if self.shape.name.is_empty() { "global" } else { &self.shape.name };
        format!("cigi-{place}-{}", self.layer)
    }

    /// The storm as the world has it.
    pub fn request(&self) -> StormRequest {
        let severity = usize::from(self.severity.min(5));
        StormRequest {
            name: self.name(),
            latitude_deg: self.shape.latitude_deg,
            longitude_deg: self.shape.longitude_deg,
            size_east_m: self.shape.size_east_m,
            size_north_m: self.shape.size_north_m,
            corner_radius_m: self.shape.corner_radius_m,
            rotation_deg: self.shape.rotation_deg,
            altitude_m: self.base_m.map(|base_m| base_m.max(0.0)),
            flashes_per_minute: FLASHES_PER_MINUTE[severity],
            inside_share: INSIDE_SHARE,
            positive_share: POSITIVE_SHARE,
            current_factor: STRENGTH[severity],
            seed: self.seed,
        }
    }

    /// One strike now.
    pub fn one(&self, moment: &Moment) -> StrikeRequest {
        storms::strike(&self.request(), SINGLE + u64::from(moment.host_frame))
    }
}

/// Whether two storms are the same but for less than a step.
pub(super) fn near(a: &StormRequest, b: &StormRequest) -> bool {
    let metres_per_degree = 111_000.0;
    let moved = (a.latitude_deg - b.latitude_deg).abs() + super::half_turn(a.longitude_deg - b.longitude_deg).abs();
    let here = StormRequest { latitude_deg: a.latitude_deg, longitude_deg: a.longitude_deg, ..b.clone() };
    *a == here && moved * metres_per_degree <= STEP_SHARE * a.size_east_m.min(a.size_north_m)
}
