//! Tables that depend on the grid alone, kept from channel to channel.

use super::dbm::green::GreenTable;
use super::grid::Grid;
use super::walls::WallSums;
use std::sync::Arc;

/// The latest tables made: a caller who grows many channels on one grid makes each once.
#[derive(Clone, Debug, Default)]
pub struct Tables {
    green: Option<Arc<GreenTable>>,
    walls: Option<Arc<WallSums>>,
}

impl Tables {
    /// The Green's function of an empty grid.
    pub(super) fn green(&mut self, grid: Grid) -> Arc<GreenTable> {
        match &self.green {
            Some(table) if table.grid() == grid => table.clone(),
            _ => self.green.insert(Arc::new(GreenTable::new(grid))).clone(),
        }
    }

    /// The sums over the walls of a grid for one exponent.
    pub(super) fn walls(&mut self, grid: Grid, rho: f64) -> Arc<WallSums> {
        match &self.walls {
            Some(sums) if sums.grid() == grid && sums.rho() == rho => sums.clone(),
            _ => self.walls.insert(Arc::new(WallSums::new(grid, rho))).clone(),
        }
    }
}
