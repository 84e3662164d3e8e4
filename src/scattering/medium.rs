//! A cloud as a box of cells: extinction per cell, and windows of a medium that repeats.

use crate::numeric::sphere::Direction;

/// Extinction on a grid. The lower south-west corner is the origin of all positions, in metres east, north and up.
#[derive(Clone, Debug, PartialEq)]
pub struct Medium {
    /// Cells east, north and up; each at least 1.
    pub cells: [usize; 3],
    /// Edges of a cell, m.
    pub spacing_m: [f64; 3],
    /// Extinction, 1/m, one value a cell: east fastest, then north, then up.
    pub extinction_per_m: Vec<f32>,
    /// Whether it repeats east and north (a deck's tile). The light never repeats.
    pub periodic: bool,
}

/// What a medium cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MediumError {
    /// Too few or too many cells.
    #[error("{0:?} cells: each edge needs at least one, all together at most {MOST_CELLS}")]
    Cells([usize; 3]),
    /// An edge of a cell that is not a length.
    #[error("cell edges of {0:?} m: each must be finite and positive")]
    Spacing([f64; 3]),
    /// The list does not fit the grid.
    #[error("{given} values for {needed} cells")]
    Count {
        /// Values given.
        given: usize,
        /// Cells of the grid.
        needed: usize,
    },
    /// An extinction that is not one.
    #[error("extinction of cell {cell} is {value} 1/m: it must be finite and not negative")]
    Extinction {
        /// Index in the list.
        cell: usize,
        /// Its value.
        value: f32,
    },
}

/// Most cells of a grid: 128 x 128 x 16 sixteen times over.
pub const MOST_CELLS: usize = 1 << 22;

impl Medium {
    /// A checked medium.
    ///
    /// # Errors
    /// [`MediumError`] says which number is wrong.
    pub fn new(
        cells: [usize; 3],
        spacing_m: [f64; 3],
        extinction_per_m: Vec<f32>,
        periodic: bool,
    ) -> Result<Self, MediumError> {
        let count = cells.iter().try_fold(1_usize, |n, c| n.checked_mul(*c)).unwrap_or(usize::MAX);
        if count == 0 || count > MOST_CELLS {
            return Err(MediumError::Cells(cells));
        }
        if !spacing_m.iter().all(|h| h.is_finite() && *h > 0.0) {
            return Err(MediumError::Spacing(spacing_m));
        }
        if extinction_per_m.len() != count {
            return Err(MediumError::Count { given: extinction_per_m.len(), needed: count });
        }
        if let Some(cell) = extinction_per_m.iter().position(|v| !(v.is_finite() && *v >= 0.0)) {
            return Err(MediumError::Extinction { cell, value: extinction_per_m[cell] });
        }
        Ok(Self { cells, spacing_m, extinction_per_m, periodic })
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.extinction_per_m.len()
    }

    /// Whether nothing in it scatters or absorbs.
    pub fn is_empty(&self) -> bool {
        self.extinction_per_m.iter().all(|v| *v == 0.0)
    }

    /// Index of a cell.
    pub fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        x + self.cells[0] * (y + self.cells[1] * z)
    }

    /// Position of a cell's centre, m.
    pub fn centre_m(&self, index: usize) -> Direction {
        let [nx, ny, _] = self.cells;
        let at = [index % nx, index / nx % ny, index / (nx * ny)];
        std::array::from_fn(|k| (at[k] as f64 + 0.5) * self.spacing_m[k])
    }

    /// Edges of the whole box, m.
    pub fn size_m(&self) -> Direction {
        std::array::from_fn(|k| self.cells[k] as f64 * self.spacing_m[k])
    }

    /// Volume of a cell, m^3.
    pub fn cell_volume_m3(&self) -> f64 {
        self.spacing_m.iter().product()
    }

    /// The cell that holds a position, if it lies in the box; a face belongs to the cell above it.
    pub fn cell_at(&self, position_m: Direction) -> Option<[usize; 3]> {
        let mut at = [0; 3];
        for k in 0..3 {
            let cell = (position_m[k] / self.spacing_m[k]).floor();
            if !(cell >= 0.0 && cell < self.cells[k] as f64) {
                return None;
            }
            at[k] = cell as usize;
        }
        Some(at)
    }

    /// Greatest optical depth of a cell along its longest edge.
    pub fn greatest_cell_depth(&self) -> f64 {
        let edge = self.spacing_m.iter().copied().fold(0.0, f64::max);
        f64::from(self.extinction_per_m.iter().copied().fold(0.0, f32::max)) * edge
    }

    /// An open window of the same size as the tile, centred on the cell that holds a position: for a medium that repeats, light of a
    /// source is followed in its own window and leaves it for good. Gives the window and its lower south-west corner
    /// in whole cells of the tile (can be negative); a medium that does not repeat is its own window at 0, 0.
    pub fn window(&self, centre_m: Direction) -> (Self, [i64; 2]) {
        if !self.periodic {
            return (self.clone(), [0, 0]);
        }
        let corner: [i64; 2] = std::array::from_fn(|k| {
            // A position beyond 2^52 cells has no window of its own; the cast saturates.
            let cell = (centre_m[k] / self.spacing_m[k]).floor() as i64;
            cell.saturating_sub(self.cells[k] as i64 / 2)
        });
        let [nx, ny, nz] = self.cells;
        let mut values = Vec::with_capacity(self.len());
        for z in 0..nz {
            for y in 0..ny {
                let row = corner[1].saturating_add(y as i64).rem_euclid(ny as i64) as usize;
                let row = &self.extinction_per_m[nx * (row + ny * z)..][..nx];
                let start = corner[0].rem_euclid(nx as i64) as usize;
                values.extend_from_slice(&row[start..]);
                values.extend_from_slice(&row[..start]);
            }
        }
        let window = Self { cells: self.cells, spacing_m: self.spacing_m, extinction_per_m: values, periodic: false };
        (window, corner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_has_its_centre_in_the_middle_and_wraps() {
        let values: Vec<f32> = (0..4 * 3 * 2).map(|i| i as f32).collect();
        let tile = Medium::new([4, 3, 2], [2.0, 2.0, 1.0], values, true).expect("legal");
        for centre in [[0.5, 0.5, 0.0], [7.9, 5.9, 1.0], [-100.3, 77.0, 0.5]] {
            let (window, corner) = tile.window(centre);
            for z in 0..2_usize {
                for y in 0..3_usize {
                    for x in 0..4_usize {
                        let from = [
                            (corner[0] + x as i64).rem_euclid(4) as usize,
                            (corner[1] + y as i64).rem_euclid(3) as usize,
                            z,
                        ];
                        let (here, there) = (window.index([x, y, z]), tile.index(from));
                        assert_eq!(window.extinction_per_m[here], tile.extinction_per_m[there]);
                    }
                }
            }
            let middle = [(centre[0] / 2.0).floor() as i64 - corner[0], (centre[1] / 2.0).floor() as i64 - corner[1]];
            assert_eq!(middle, [2, 1]);
            assert!(!window.periodic);
        }
    }

    #[test]
    fn bad_media_are_refused() {
        let new = |cells, h, v: Vec<f32>| Medium::new(cells, [h; 3], v, false);
        assert_eq!(new([0, 1, 1], 1.0, vec![]), Err(MediumError::Cells([0, 1, 1])));
        assert_eq!(new([usize::MAX, 2, 1], 1.0, vec![]), Err(MediumError::Cells([usize::MAX, 2, 1])));
        assert!(matches!(new([1, 1, 1], f64::NAN, vec![1.0]), Err(MediumError::Spacing(_))));
        assert_eq!(new([2, 1, 1], 1.0, vec![1.0]), Err(MediumError::Count { given: 1, needed: 2 }));
        assert!(matches!(new([2, 1, 1], 1.0, vec![1.0, -0.5]), Err(MediumError::Extinction { cell: 1, .. })));
        assert!(matches!(new([1, 1, 1], 1.0, vec![f32::NAN]), Err(MediumError::Extinction { .. })));
        assert!(new([1, 1, 1], 1.0, vec![0.0]).expect("legal").is_empty());
    }

    #[test]
    fn positions_find_their_cells() {
        let m = Medium::new([2, 3, 4], [1.0, 2.0, 0.5], vec![0.1; 24], false).expect("legal");
        for i in 0..m.len() {
            assert_eq!(m.cell_at(m.centre_m(i)).map(|c| m.index(c)), Some(i));
        }
        assert_eq!(m.cell_at([-0.1, 0.0, 0.0]), None);
        assert_eq!(m.cell_at([2.0, 0.0, 0.0]), None);
        assert_eq!(m.cell_at([f64::NAN, 0.0, 0.0]), None);
        assert_eq!(m.size_m(), [2.0, 6.0, 2.0]);
    }
}
