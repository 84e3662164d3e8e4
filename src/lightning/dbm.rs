//! The dielectric breakdown model: a channel grows where Laplace's equation puts the greatest potential.
//!
//! Niemeyer, Pietronero and Wiesmann 1984; the scene is that of Yun et al., figure 4: channel, obstacles and the ring (shell)
//! outside the grid are held at 0, targets at 1; a candidate's chance is in proportion to phi^eta. Two forms draw from the same
//! distribution: conjugate gradients solve the whole grid anew for every cell, the incremental Green's function knows the
//! candidates alone.

mod bound;
mod conjugate;
mod exact;
pub(super) mod green;
mod held;

pub(super) use conjugate::conjugate;
pub use exact::MOST_HELD_CELLS;
pub(super) use exact::exact;

use super::error::GrowError;
use super::grid::{Cell, Neighbours, Walk};
use super::scene::{Goal, Scene, flood, state};
use crate::numeric::exact::pow;

/// Relative size of the rounding errors of a potential: what is smaller, against what the targets alone would give, is taken as
/// no potential. A candidate shut in by the channel would otherwise be drawn for its noise when eta is small.
const NOISE: f64 = 1e-13;

/// The cells that the potential of the targets comes to: it passes through faces alone, so obstacles that touch at corners
/// shut it out although a channel of 8 or 26 neighbours could slip between them. None where nothing stands in its way.
///
/// # Errors
/// [`GrowError::NotInField`]: none of the cells that the channel could grow into first has any potential.
fn field_cells(scene: &Scene, map: &[u8]) -> Result<Option<Vec<bool>>, GrowError> {
    let targets: Vec<Cell> = match &scene.goal {
        // A free channel is drawn to the border.
        Goal::Free => (0..scene.grid.cells() as Cell).filter(|&cell| on_border(scene, cell)).collect(),
        _ => scene.targets(),
    };
    if scene.obstacles.is_empty() || targets.contains(&scene.start) {
        return Ok(None);
    }
    let open = |cell: &Cell| map[*cell as usize] != state::OBSTACLE;
    let sources: Vec<Cell> = targets.into_iter().filter(open).collect();
    let mut shut = map.to_vec();
    shut[scene.start as usize] = state::OBSTACLE;
    let reached = flood(&Walk::new(scene.grid, Neighbours::Faces), &shut, &sources);
    match Walk::new(scene.grid, scene.neighbours).around(scene.start).any(|cell| reached[cell as usize]) {
        true => Ok(Some(reached)),
        false => Err(GrowError::NotInField { cell: sources.first().copied().unwrap_or(scene.start) }),
    }
}

fn on_border(scene: &Scene, cell: Cell) -> bool {
    let (size, position) = (scene.grid.size(), scene.grid.position(cell));
    (0..scene.grid.axes()).any(|axis| position[axis] == 0 || position[axis] + 1 == size[axis])
}

/// (phi / reference)^eta: weights up to a common factor. With phi from 1e-12 to 1 and the reference in between, no eta of up to
/// 20 leaves the range of f64.
#[derive(Clone, Copy, Debug)]
struct Weight {
    eta: f64,
    /// One over the reference potential; 0 until it is known.
    scale: f64,
}

impl Weight {
    fn new(eta: f64) -> Self {
        Self { eta, scale: 0.0 }
    }

    /// Sets the reference from the first potentials that are seen.
    fn refer_to(&mut self, potentials: impl Iterator<Item = f64>) {
        if self.scale == 0.0 {
            let greatest = potentials.fold(0.0, f64::max);
            self.scale = if greatest > 0.0 { 1.0 / greatest } else { 0.0 };
        }
    }

    fn of(&self, potential: f64) -> f64 {
        let x = potential * self.scale;
        if x <= 0.0 {
            return 0.0;
        }
        match self.eta {
            0.0 => 1.0,
            1.0 => x,
            2.0 => x * x,
            3.0 => x * x * x,
            eta => pow(x.max(f64::MIN_POSITIVE), eta),
        }
    }
}
