//! The box of cells in which a channel grows, and which cells are neighbours.

use super::error::GrowError;

/// Most cells of a grid: 256 x 256 x 256.
pub const MOST_GRID_CELLS: u64 = 1 << 24;
/// Most cells along one axis.
pub const LONGEST_SIDE: u32 = 4096;

/// The number of a cell: x + nx (y + ny z).
pub type Cell = u32;

/// A plane or volume of cells. Its last axis (y of a plane, z of a volume) points up; layer 0 is the ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Grid {
    size: [u32; 3],
    axes: usize,
}

impl Grid {
    /// A plane of `nx` by `ny` cells, `y` up.
    ///
    /// # Errors
    /// [`GrowError::GridSize`]: a side is 0 or above [`LONGEST_SIDE`].
    pub fn plane(nx: u32, ny: u32) -> Result<Self, GrowError> {
        Self::new([nx, ny, 1], 2)
    }

    /// A volume of `nx` by `ny` by `nz` cells, `z` up.
    ///
    /// # Errors
    /// [`GrowError::GridSize`]: a side is 0 or above [`LONGEST_SIDE`], or there are more than [`MOST_GRID_CELLS`].
    pub fn volume(nx: u32, ny: u32, nz: u32) -> Result<Self, GrowError> {
        Self::new([nx, ny, nz], 3)
    }

    fn new(size: [u32; 3], axes: usize) -> Result<Self, GrowError> {
        let cells: u64 = size.iter().map(|&side| u64::from(side)).product();
        if size.iter().any(|side| !(1..=LONGEST_SIDE).contains(side)) || cells > MOST_GRID_CELLS {
            return Err(GrowError::GridSize { size });
        }
        Ok(Self { size, axes })
    }

    /// Cells along x, y and z (1 for a plane).
    pub fn size(self) -> [u32; 3] {
        self.size
    }

    /// 2 or 3.
    pub fn axes(self) -> usize {
        self.axes
    }

    /// Number of cells.
    pub fn cells(self) -> usize {
        self.size.iter().map(|&side| side as usize).product()
    }

    /// The cell at a position inside the grid.
    pub fn cell(self, [x, y, z]: [u32; 3]) -> Cell {
        let [nx, ny, _] = self.size;
        x + nx * (y + ny * z)
    }

    /// The position of a cell.
    pub fn position(self, cell: Cell) -> [u32; 3] {
        let [nx, ny, _] = self.size;
        [cell % nx, cell / nx % ny, cell / nx / ny]
    }

    /// Height of a cell above the ground layer.
    pub fn layer(self, cell: Cell) -> u32 {
        self.position(cell)[self.axes - 1]
    }

    /// The middle of the highest layer: where a stroke to ground begins.
    pub fn top_centre(self) -> Cell {
        self.centre_of_layer(self.size[self.axes - 1] - 1)
    }

    /// The middle of the ground layer.
    pub fn bottom_centre(self) -> Cell {
        self.centre_of_layer(0)
    }

    fn centre_of_layer(self, layer: u32) -> Cell {
        let mut position = self.size.map(|side| side / 2);
        position[self.axes - 1] = layer;
        self.cell(position)
    }

    /// The cells of the ground layer.
    pub fn ground(self) -> impl Iterator<Item = Cell> {
        let [nx, ny, _] = self.size;
        // Layer 0 of the last axis comes first in the numbering.
        0..if self.axes == 2 { nx } else { nx * ny }
    }
}

/// Which cells touch a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Neighbours {
    /// Those that share a face: 4 in a plane, 6 in a volume.
    Faces,
    /// Those that share a corner, too: 8 and 26. The lightning paper's (its figure 4 has diagonal steps).
    #[default]
    All,
}

impl Neighbours {
    /// Steps to the neighbours, in a fixed order.
    pub fn steps(self, axes: usize) -> Vec<[i32; 3]> {
        let depth = if axes == 3 { -1..=1 } else { 0..=0 };
        let mut steps = Vec::with_capacity(26);
        for dz in depth {
            for dy in -1..=1_i32 {
                for dx in -1..=1_i32 {
                    let away = dx.abs() + dy.abs() + i32::abs(dz);
                    if away == 1 || (away > 1 && self == Self::All) {
                        steps.push([dx, dy, dz]);
                    }
                }
            }
        }
        steps
    }
}

/// Steps prepared for one grid: the walk over the neighbours of a cell that lie inside.
#[derive(Clone, Debug)]
pub(super) struct Walk {
    grid: Grid,
    steps: Vec<([i32; 3], i32)>,
}

impl Walk {
    pub(super) fn new(grid: Grid, neighbours: Neighbours) -> Self {
        let [nx, ny, _] = grid.size.map(|side| side as i32);
        let numbered = |step: [i32; 3]| (step, step[0] + nx * (step[1] + ny * step[2]));
        Self { grid, steps: neighbours.steps(grid.axes).into_iter().map(numbered).collect() }
    }

    /// The neighbours of `cell`, in a fixed order.
    pub(super) fn around(&self, cell: Cell) -> impl Iterator<Item = Cell> {
        let position = self.grid.position(cell);
        let size = self.grid.size;
        self.steps.iter().filter_map(move |(step, offset)| {
            let inside = |axis: usize| position[axis].wrapping_add_signed(step[axis]) < size[axis];
            (inside(0) && inside(1) && inside(2)).then(|| cell.wrapping_add_signed(*offset))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_and_positions_are_inverse_and_up_is_the_last_axis() {
        let plane = Grid::plane(5, 7).expect("a grid");
        let volume = Grid::volume(3, 4, 5).expect("a grid");
        for grid in [plane, volume] {
            assert!((0..grid.cells() as u32).all(|cell| grid.cell(grid.position(cell)) == cell));
            assert!(grid.ground().all(|cell| grid.layer(cell) == 0));
        }
        assert_eq!((plane.position(plane.top_centre()), plane.position(plane.bottom_centre())), ([2, 6, 0], [2, 0, 0]));
        assert_eq!(volume.position(volume.top_centre()), [1, 2, 4]);
        assert_eq!((plane.ground().count(), volume.ground().count()), (5, 12));
    }

    #[test]
    fn sizes_out_of_bounds_are_refused() {
        for (nx, ny, nz) in [(0, 4, 4), (4, 0, 4), (4, 4, 0), (4097, 1, 1), (512, 512, 65), (4096, 4096, 4096)] {
            assert!(matches!(Grid::volume(nx, ny, nz), Err(GrowError::GridSize { .. })), "{nx} {ny} {nz}");
        }
        assert!(Grid::volume(256, 256, 256).is_ok() && Grid::plane(1, 1).is_ok());
    }

    #[test]
    fn neighbours_stay_inside() {
        let count = |grid: Grid, neighbours, position| Walk::new(grid, neighbours).around(grid.cell(position)).count();
        let plane = Grid::plane(5, 5).expect("a grid");
        let volume = Grid::volume(3, 3, 3).expect("a grid");
        assert_eq!((count(plane, Neighbours::All, [2, 2, 0]), count(plane, Neighbours::Faces, [2, 2, 0])), (8, 4));
        assert_eq!((count(plane, Neighbours::All, [0, 0, 0]), count(plane, Neighbours::Faces, [4, 2, 0])), (3, 3));
        assert_eq!((count(volume, Neighbours::All, [1; 3]), count(volume, Neighbours::Faces, [1; 3])), (26, 6));
        assert_eq!(count(volume, Neighbours::All, [2; 3]), 7);
        let row = Grid::plane(1, 9).expect("a grid");
        assert_eq!(count(row, Neighbours::All, [0, 4, 0]), 2);
    }
}
