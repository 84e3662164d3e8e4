//! Storms: random lightning in the extent of a layer, from a seed and the time alone.

use super::Moment;
use crate::geo::Geodetic;
use crate::geo::frames::{Curvature, enu};
use crate::geo::wgs84::{from_ecef, to_ecef};
use crate::numeric::hash::{pcg3d, unit};
use crate::world::command::{FlashKind, Polarity, RegionShape, StrikeRequest, Strokes};
use glam::{DVec2, DVec3};

/// Flashes a minute by severity, 0 to 5: chosen, since the standard says only that the rate follows severity.
const FLASHES_PER_MINUTE: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 30.0];
/// About three quarters of all flashes do not reach the ground (Rakov and Uman 2003, "Lightning", chapter 1).
const INSIDE_SHARE: f32 = 0.75;
/// Median peak current of first negative strokes (CIGRE TB 549: 31 kA), and the spread of its logarithm.
const MEDIAN_KA: f64 = 31.0;
const SPREAD: f64 = 0.48;
/// Factor on the current by severity: chosen, since the standard says only that strength follows severity.
const STRENGTH: [f64; 6] = [0.6, 0.75, 0.9, 1.0, 1.15, 1.3];
/// Length of a slot: what happens in one is a function of its number.
const SLOT_S: f64 = 0.1;
/// Slots that are looked through at once; after a longer pause the storm goes on from now.
const MOST_SLOTS: u32 = 600;

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
    /// The flashes of an interval of simulation time: those of every slot that begins in it, each at its own time.
    pub fn flashes(&self, begin_s: f64, end_s: f64) -> Vec<StrikeRequest> {
        let first = (begin_s / SLOT_S).ceil().max(0.0);
        let last = (end_s / SLOT_S).ceil().max(first);
        let slots = ((last - first) as u32).min(MOST_SLOTS);
        let share = FLASHES_PER_MINUTE[usize::from(self.severity.min(5))] / 60.0 * SLOT_S;
        (0..slots)
            .filter_map(|slot| {
                let number = first as u64 + u64::from(slot);
                let [chance, later, _] = self.hash(number, 0);
                // At the strongest the chance of two in one slot is 0.1 %: one is taken.
                (f64::from(unit(chance)) < share).then(|| {
                    let at_s = (number as f64 + f64::from(unit(later))) * SLOT_S;
                    StrikeRequest { at_s: Some(at_s), ..self.strike(number) }
                })
            })
            .collect()
    }

    /// One strike now.
    pub fn one(&self, moment: &Moment) -> StrikeRequest {
        self.strike((1 << 40) + u64::from(moment.host_frame))
    }

    fn hash(&self, number: u64, what: u32) -> [u32; 3] {
        let seed = self.seed ^ self.seed >> 32;
        let place = pcg3d(
            seed as u32,
            u32::from(self.layer),
            self.shape.name.bytes().fold(0, |sum: u32, byte| sum.wrapping_mul(31) ^ u32::from(byte)),
        );
        pcg3d(place[0] ^ number as u32, place[1] ^ (number >> 32) as u32, place[2].wrapping_add(what))
    }

    fn strike(&self, number: u64) -> StrikeRequest {
        let [kind, polarity, current] = self.hash(number, 1);
        let [seed_high, seed_low, other] = self.hash(number, 2);
        let place = self.place(number);
        // Box and Muller's normal number.
        let radius = (-2.0 * f64::from(unit(current)).max(1e-7).ln()).sqrt();
        let normal = radius * (std::f64::consts::TAU * f64::from(unit(other))).cos();
        let peak = MEDIAN_KA * STRENGTH[usize::from(self.severity.min(5))] * (SPREAD * normal).exp();
        let inside = unit(kind) < INSIDE_SHARE;
        StrikeRequest {
            latitude_deg: place.latitude_rad.to_degrees(),
            longitude_deg: place.longitude_rad.to_degrees(),
            altitude_m: self.base_m,
            at_s: None,
            kind: if inside { FlashKind::IntraCloud } else { FlashKind::CloudToGround },
            // About a tenth of the flashes to ground are positive (Rakov and Uman 2003, chapter 5).
            polarity: if unit(polarity) < 0.1 { Polarity::Positive } else { Polarity::Negative },
            peak_current_ka: Some(peak.clamp(2.0, 300.0)),
            strokes: Strokes::Sample,
            leader: false,
            seed: u64::from(seed_high) << 32 | u64::from(seed_low),
        }
    }

    /// A place inside the outline, every square metre alike.
    fn place(&self, number: u64) -> Geodetic {
        let shape = &self.shape;
        let half = 0.5 * DVec2::new(shape.size_east_m, shape.size_north_m);
        let mut at = DVec2::ZERO;
        // A try falls into a rounded corner with a chance of at most 1 - pi / 4.
        for attempt in 0..16 {
            let [x, y, _] = self.hash(number, 3 + attempt);
            at = (2.0 * DVec2::new(unit(x).into(), unit(y).into()) - 1.0) * half;
            let beyond = (at.abs() - half + shape.corner_radius_m).max(DVec2::ZERO);
            if beyond.length() <= shape.corner_radius_m {
                break;
            }
        }
        let centre = Geodetic {
            latitude_rad: shape.latitude_deg.to_radians(),
            longitude_rad: shape.longitude_deg.to_radians(),
            altitude_m: 0.0,
        };
        let (sin, cos) = shape.rotation_deg.to_radians().sin_cos();
        let local = DVec2::new(at.x * cos + at.y * sin, at.y * cos - at.x * sin);
        // Along the great circle, so that it is right for regions of a thousand kilometres.
        let radius_m = Curvature::at(centre.latitude_rad).mean_m();
        let angle = local.length() / radius_m;
        let flat = local.normalize_or_zero() * angle.sin();
        let up = enu(&centre) * DVec3::new(flat.x, flat.y, angle.cos());
        let sphere = from_ecef(to_ecef(&centre) + (up - enu(&centre).z_axis) * radius_m);
        Geodetic { altitude_m: 0.0, ..sphere }
    }
}
