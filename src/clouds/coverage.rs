//! Coverage that is what was asked (deck paper eq. 15, calibrated).
//!
//! *What it is.* Cloud is where the shape value exceeds theta = patchiness * map + offset. The vertical cover is the
//! share of columns whose vertical optical depth at usual thickness and density 1 exceeds a visible depth.
//! *How we compute it.* For each column the greatest theta that leaves it visibly deep, by bisection; the map is uniform
//! and independent of the tile, so the cover of an offset is an average over the columns, and its inverse a table.

use super::cell;
use super::density::{DensityVolume, HEIGHT, WIDTH};
use super::kind::CloudKind;
use rayon::prelude::*;
use std::sync::{Arc, LazyLock, Mutex};

const STEPS: usize = 64;

/// Offsets of theta by coverage, for one genus.
#[derive(Debug)]
pub struct Coverage {
    entries: [Threshold; STEPS + 1],
}

/// How theta is made from the map for one coverage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Threshold {
    /// Factor on the map's value.
    pub patchiness: f32,
    /// Added to it.
    pub offset: f32,
    /// Mean theta of the places that have cloud: what a basis of lightning is baked with.
    pub typical: f32,
}

impl Coverage {
    /// The calibration of a genus, made at first use and kept.
    pub fn of(kind: CloudKind) -> Arc<Self> {
        static KEPT: LazyLock<[Mutex<Option<Arc<Coverage>>>; CloudKind::COUNT]> =
            LazyLock::new(|| std::array::from_fn(|_| Mutex::new(None)));
        let mut kept = KEPT[kind.index()].lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        kept.get_or_insert_with(|| Arc::new(Self::build(kind))).clone()
    }

    /// Theta for a coverage of 0 to 1.
    pub fn threshold(&self, coverage: f32) -> Threshold {
        let at = coverage.clamp(0.0, 1.0) * STEPS as f32;
        let i = (at as usize).min(STEPS - 1);
        let share = at - i as f32;
        let between = |of: fn(&Threshold) -> f32| {
            let [low, high] = [&self.entries[i], &self.entries[i + 1]].map(of);
            low + (high - low) * share
        };
        Threshold {
            patchiness: between(|t| t.patchiness),
            offset: between(|t| t.offset),
            typical: between(|t| t.typical),
        }
    }

    fn build(kind: CloudKind) -> Self {
        if kind == CloudKind::StormCell {
            // How far it has grown, not how much it covers.
            return Self { entries: std::array::from_fn(|i| cell::threshold(i as f32 / STEPS as f32)) };
        }
        let look = kind.appearance();
        let full = look.extinction_per_m * look.usual_thickness_m;
        // Seen as cloud: an optical depth of 1, or a third of what the thin genera can reach.
        let seen = histogram(&column_thetas(kind, 1.0f32.min(full / 3.0)));
        // Overcast hides the ground: 5 lets 0.7 % of direct light through; thin genera cannot, and get 45 % of their most.
        let hiding = histogram(&column_thetas(kind, 5.0f32.min(full * 0.45)));
        let entries = std::array::from_fn(|i| {
            let share = i as f32 / STEPS as f32;
            // In the last sixteenth, what counts goes over from "seen" to "hides the ground".
            let blend = ((share - 0.9375) / 0.0625).max(0.0);
            let offset = |patchiness: f32| {
                let seen = invert(&seen, patchiness, share);
                let hidden = if blend > 0.0 { invert(&hiding, patchiness, share.min(0.999_9)) } else { seen };
                seen + blend * (hidden.min(seen) - seen)
            };
            // As much of the map as leaves theta over 0 everywhere: below it, a layer is cloud from its very base to its very
            // top, a box with hard edges.
            let (mut low, mut high) = (LEAST_PATCHINESS, look.patchiness);
            if offset(high) < 0.0 {
                for _ in 0..8 {
                    let middle = 0.5 * (low + high);
                    if offset(middle) < 0.0 { high = middle } else { low = middle }
                }
                high = low;
            }
            let (patchiness, offset) = (high, offset(high));
            Threshold { patchiness, offset, typical: typical(&seen, patchiness, offset) }
        });
        Self { entries }
    }
}

/// What is left of the map at least.
const LEAST_PATCHINESS: f32 = 0.04;

/// Greatest theta at which each column still has the vertical optical depth `depth` at usual thickness.
pub(super) fn column_thetas(kind: CloudKind, depth: f32) -> Vec<f32> {
    let volume = DensityVolume::of(kind);
    let look = kind.appearance();
    let per_voxel = look.extinction_per_m * look.usual_thickness_m / HEIGHT as f32;
    let columns = WIDTH * WIDTH;
    (0..columns)
        .into_par_iter()
        .map(|column| {
            let values: [f32; HEIGHT] =
                std::array::from_fn(|z| f32::from(volume.shape[column + z * columns]) * (1.0 / 255.0));
            let (mut low, mut high) = (-1.0f32, 1.0f32);
            for _ in 0..12 {
                let theta = 0.5 * (low + high);
                let sum: f32 = values.iter().map(|v| ((v - theta) / look.edge).clamp(0.0, 1.0)).sum();
                if sum * per_voxel >= depth { low = theta } else { high = theta }
            }
            low
        })
        .collect()
}

/// How many columns have each theta, in steps of 2^-11 from -1 (all that twelve bisections tell apart).
fn histogram(thetas: &[f32]) -> Vec<(f32, f32)> {
    let mut counts = vec![0u32; 4097];
    for theta in thetas {
        counts[((theta + 1.0) * 2048.0) as usize] += 1;
    }
    let bins = counts.into_iter().enumerate().filter(|(_, n)| *n > 0);
    bins.map(|(i, n)| (i as f32 / 2048.0 - 1.0, n as f32 / thetas.len() as f32)).collect()
}

/// The offset at which a share of all (column, map value) pairs is covered.
fn invert(bins: &[(f32, f32)], patchiness: f32, share: f32) -> f32 {
    let cover = |offset: f32| {
        // A column is covered for map values below (theta - offset) / patchiness; the map is uniform.
        bins.iter().map(|(theta, n)| n * ((theta - offset) / patchiness).clamp(0.0, 1.0)).sum::<f32>()
    };
    let (mut low, mut high) = (-2.5f32, 1.2f32);
    for _ in 0..20 {
        let offset = 0.5 * (low + high);
        if cover(offset) >= share { low = offset } else { high = offset }
    }
    low
}

/// Mean theta of the places that are covered, the same (column, map value) pairs as in [`invert`].
fn typical(bins: &[(f32, f32)], patchiness: f32, offset: f32) -> f32 {
    let (mut sum, mut cover) = (0.0, 0.0);
    for (theta, n) in bins {
        let below = ((theta - offset) / patchiness).clamp(0.0, 1.0);
        sum += n * below * (offset + 0.5 * patchiness * below);
        cover += n * below;
    }
    // Nothing is covered: the cloudiest place there is.
    if cover > 0.0 { sum / cover } else { offset }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn theta_falls_with_coverage() {
        let entries = &Coverage::of(CloudKind::Cumulus).entries;
        // In the mean; where the map is least it rises a little towards an overcast, which has less of the map.
        let mean = |t: &Threshold| t.offset + 0.5 * t.patchiness;
        assert!(entries.windows(2).all(|w| mean(&w[1]) < mean(&w[0])), "{entries:?}");
    }

    #[test]
    fn half_cover_covers_half_of_the_columns() {
        let threshold = Coverage::of(CloudKind::Cumulus).threshold(0.5);
        let thetas = column_thetas(CloudKind::Cumulus, 1.0);
        let covered: f64 = (0..256)
            .map(|r| {
                let theta = threshold.patchiness * (r as f32 / 255.0) + threshold.offset;
                thetas.iter().filter(|t| **t >= theta).count() as f64 / thetas.len() as f64
            })
            .sum::<f64>()
            / 256.0;
        // Twelve bisections of 2 resolve theta to 5e-4; the shape's distribution is no steeper than 8 per unit.
        assert!((covered - 0.5).abs() < 0.005, "{covered}");
    }
}
