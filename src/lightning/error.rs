//! Why a channel could not be grown.

use super::grid::{Cell, LONGEST_SIDE, MOST_GRID_CELLS};

/// Why a channel could not be grown. Each names what was wrong and what would be right.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GrowError {
    /// The grid is empty or too large.
    #[error("a grid of {size:?} cells: sides are 1 to {LONGEST_SIDE}, cells at most {MOST_GRID_CELLS}")]
    GridSize {
        /// Cells along each axis.
        size: [u32; 3],
    },
    /// A cell lies outside the grid.
    #[error("{what} is cell {cell}, the grid has {cells}")]
    Outside {
        /// Start, target or obstacle.
        what: &'static str,
        /// Its number.
        cell: Cell,
        /// Cells of the grid.
        cells: usize,
    },
    /// The start or a target lies on an obstacle.
    #[error("{what} (cell {cell}) is an obstacle")]
    OnObstacle {
        /// Start or target.
        what: &'static str,
        /// Its number.
        cell: Cell,
    },
    /// A goal that names targets names none.
    #[error("the goal names no target")]
    NoTarget,
    /// Obstacles shut the way from the start to a target.
    #[error("no way leads from the start to the target at cell {cell}")]
    Unreachable {
        /// The target's number.
        cell: Cell,
    },
    /// The start is shut off from the potential of the targets, which does not pass between obstacles that touch at corners.
    #[error(
        "the potential of the target at cell {cell} does not come to the start: it passes through faces of cells alone"
    )]
    NotInField {
        /// The target's number.
        cell: Cell,
    },
    /// A parameter is outside its range.
    #[error("{name} is {value}, must be {min} to {max}")]
    Parameter {
        /// Its name.
        name: &'static str,
        /// What was given.
        value: f64,
        /// Least value.
        min: f64,
        /// Greatest value.
        max: f64,
    },
    /// Too many cells are held at a fixed potential for this method's memory and time.
    #[error(
        "{cells} cells of fixed potential, the incremental Green's function takes at most {limit}: use the form by conjugate gradients"
    )]
    TooManyFixed {
        /// Obstacles and targets.
        cells: usize,
        /// The limit.
        limit: usize,
    },
    /// This method knows no obstacles.
    #[error("{method} knows no obstacles: take a method with a field")]
    Obstacles {
        /// Its name.
        method: &'static str,
    },
    /// A way round obstacles would have to be searched in too large a grid.
    #[error(
        "a way round obstacles is searched in at most {limit} cells, the grid has {cells}: take fewer, or no waypoints"
    )]
    SearchSize {
        /// Cells of the grid.
        cells: usize,
        /// The limit.
        limit: usize,
    },
    /// The linear solver did not reach its tolerance.
    #[error("after {iterations} iterations the greatest residual is {residual:e}, asked was {tolerance:e}")]
    NoConvergence {
        /// Iterations of this solve.
        iterations: u32,
        /// Greatest residual reached.
        residual: f64,
        /// Greatest residual asked for.
        tolerance: f64,
    },
    /// The caller asked to stop.
    #[error("stopped by the caller after {cells} cells")]
    Cancelled {
        /// Cells grown until then.
        cells: u32,
    },
}

/// Checks a number against its range; NaN is outside every range.
pub(super) fn in_range(name: &'static str, value: f64, [min, max]: [f64; 2]) -> Result<(), GrowError> {
    if (min..=max).contains(&value) { Ok(()) } else { Err(GrowError::Parameter { name, value, min, max }) }
}
