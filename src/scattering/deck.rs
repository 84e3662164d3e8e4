//! The medium of a deck: one tile of a genus's density volume at a theta, in coarse cells that keep their mean extinction.

use super::medium::{Medium, MediumError};
use crate::clouds::CloudKind;
use crate::clouds::density::{DensityVolume, HEIGHT, TILE_M, WIDTH};

/// What decides a deck's medium, whatever its place and base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deck {
    /// Genus.
    pub kind: CloudKind,
    /// Shape value above which there is cloud, 0 to 1.
    pub theta: f32,
    /// Density factor `D`, 0 or more.
    pub density: f32,
    /// Thickness, m, over 0.
    pub thickness_m: f32,
}

/// Thetas at which a genus's bases are baked; the light between two of them is interpolated.
pub const THETAS: usize = 3;

impl Deck {
    /// The tile as a medium that repeats: `cells` must divide 256 x 256 x 32. Extinction as the deck pass draws it,
    /// `sigma_ref D min(max(T3D.a - theta, 0) / edge, 1)`, averaged over the voxels of a cell.
    ///
    /// # Errors
    /// [`MediumError`]: cells that do not divide the volume, or a thickness or density that is none.
    pub fn medium(&self, cells: [usize; 3]) -> Result<Medium, MediumError> {
        let voxels = [WIDTH, WIDTH, HEIGHT];
        if (0..3).any(|k| cells[k] == 0 || !voxels[k].is_multiple_of(cells[k])) {
            return Err(MediumError::Cells(cells));
        }
        let per: [usize; 3] = std::array::from_fn(|k| voxels[k] / cells[k]);
        let look = self.kind.appearance();
        let volume = DensityVolume::of(self.kind);
        let mut sums = vec![0.0_f64; cells.iter().product()];
        for (i, shape) in volume.shape.iter().enumerate() {
            let margin = f32::from(*shape) / 255.0 - self.theta;
            if margin > 0.0 {
                let at = [i % WIDTH / per[0], i / WIDTH % WIDTH / per[1], i / (WIDTH * WIDTH) / per[2]];
                sums[at[0] + cells[0] * (at[1] + cells[1] * at[2])] += f64::from((margin / look.edge).min(1.0));
            }
        }
        let count = per.iter().product::<usize>() as f64;
        let sigma = f64::from(look.extinction_per_m * self.density) / count;
        let tile = f64::from(TILE_M);
        let spacing = [tile / cells[0] as f64, tile / cells[1] as f64, f64::from(self.thickness_m) / cells[2] as f64];
        Medium::new(cells, spacing, sums.into_iter().map(|s| (s * sigma) as f32).collect(), true)
    }
}

/// The values of a range at which something is known, around a value: two indices and the share of the second.
pub fn bracket(known: &[f64], value: f64) -> Option<(usize, usize, f64)> {
    let last = known.len().checked_sub(1)?;
    let above = known.partition_point(|k| *k <= value);
    if above == 0 {
        return Some((0, 0, 0.0));
    }
    if above > last {
        return Some((last, last, 0.0));
    }
    let (low, high) = (known[above - 1], known[above]);
    Some((above - 1, above, (value - low) / (high - low)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coarse_cells_keep_the_column_of_the_fine_ones() {
        let deck = Deck { kind: CloudKind::Stratocumulus, theta: 0.4, density: 1.0, thickness_m: 500.0 };
        let depth = |cells: [usize; 3]| -> f64 {
            let m = deck.medium(cells).expect("legal");
            let sum: f64 = m.extinction_per_m.iter().map(|s| f64::from(*s)).sum();
            sum * m.spacing_m[2] / (cells[0] * cells[1]) as f64
        };
        let fine = depth([256, 256, 32]);
        for cells in [[32, 32, 4], [64, 64, 8], [1, 1, 1]] {
            // Sums of f32 cells.
            assert!((depth(cells) / fine - 1.0).abs() < 1e-5, "{cells:?}");
        }
        assert!(fine > 0.5, "a deck of some depth: {fine}");
        assert!(deck.medium([32, 32, 5]).is_err() && deck.medium([0, 1, 1]).is_err());
        assert!(Deck { thickness_m: f32::NAN, ..deck }.medium([32, 32, 4]).is_err());
        let thin = Deck { theta: 1.0, ..deck }.medium([32, 32, 4]).expect("legal");
        assert!(thin.is_empty() && thin.periodic);
    }

    #[test]
    fn brackets_hold_their_value() {
        let known = [0.1, 0.4, 0.8];
        assert_eq!(bracket(&known, 0.0), Some((0, 0, 0.0)));
        assert_eq!(bracket(&known, 9.0), Some((2, 2, 0.0)));
        let (a, b, share) = bracket(&known, 0.5).expect("known");
        assert!((a, b) == (1, 2) && (share - 0.25).abs() < 1e-12);
        assert_eq!(bracket(&[], 0.5), None);
    }
}
