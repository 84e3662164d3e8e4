//! What a channel grows in: grid, start, goal and obstacles, checked before anything grows.

use super::error::GrowError;
use super::grid::{Cell, Grid, Neighbours, Walk};

/// Where a channel should go.
#[derive(Clone, Debug, PartialEq)]
pub enum Goal {
    /// Nowhere: it grows until its cells are used up.
    Free,
    /// To whichever of these cells it reaches first.
    Nearest(Vec<Cell>),
    /// To all of these cells, in any order.
    Every(Vec<Cell>),
    /// To these cells one after another: only the next one attracts.
    Chain(Vec<Cell>),
    /// To any cell of the ground layer.
    Ground,
}

/// A grid with what stands in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The cells.
    pub grid: Grid,
    /// Which cells a channel can step to.
    pub neighbours: Neighbours,
    /// Where the channel begins.
    pub start: Cell,
    /// Where it goes.
    pub goal: Goal,
    /// Cells that it must not enter; they repel it as the border does.
    pub obstacles: Vec<Cell>,
    /// Whether a target that obstacles hide from the start is approached by waypoints (rational potential and fast
    /// Laplacian growth; the dielectric breakdown models find their way by themselves).
    pub waypoints: bool,
}

/// What is in a cell, as the growth sees it.
pub(super) mod state {
    /// Nothing yet.
    pub const FREE: u8 = 0;
    /// Touches the channel and may be grown next.
    pub const CANDIDATE: u8 = 1;
    /// Part of the channel.
    pub const GROWN: u8 = 2;
    /// Attracts the channel, which ends on touching it.
    pub const TARGET: u8 = 3;
    /// Shut.
    pub const OBSTACLE: u8 = 4;
}

impl Scene {
    /// An empty grid, from the middle of the top to the middle of the ground: the lightning paper's scene.
    pub fn top_to_bottom(grid: Grid) -> Self {
        Self {
            grid,
            neighbours: Neighbours::default(),
            start: grid.top_centre(),
            goal: Goal::Nearest(vec![grid.bottom_centre()]),
            obstacles: Vec::new(),
            waypoints: true,
        }
    }

    /// An empty grid with the start in its middle and no target.
    pub fn free(grid: Grid) -> Self {
        let start = grid.cell(grid.size().map(|side| side / 2));
        Self { start, goal: Goal::Free, ..Self::top_to_bottom(grid) }
    }

    /// The cells that the goal names, in its order.
    pub fn targets(&self) -> Vec<Cell> {
        match &self.goal {
            Goal::Free => Vec::new(),
            Goal::Nearest(cells) | Goal::Every(cells) | Goal::Chain(cells) => cells.clone(),
            Goal::Ground => self.grid.ground().filter(|cell| !self.obstacles.contains(cell)).collect(),
        }
    }

    /// Checks everything that can be wrong and returns the state of each cell: free or obstacle.
    ///
    /// # Errors
    /// A cell outside the grid, a start or target on an obstacle, no target, or a target that cannot be reached
    /// (one of `Every` and `Chain`, all of `Nearest` and `Ground`).
    pub(super) fn checked(&self) -> Result<Vec<u8>, GrowError> {
        let cells = self.grid.cells();
        let inside = |what, cell: Cell| match (cell as usize) < cells {
            true => Ok(()),
            false => Err(GrowError::Outside { what, cell, cells }),
        };
        let mut map = vec![state::FREE; cells];
        for &cell in &self.obstacles {
            inside("an obstacle", cell)?;
            map[cell as usize] = state::OBSTACLE;
        }
        let standing = |what, cell: Cell| match map[cell as usize] {
            state::OBSTACLE => Err(GrowError::OnObstacle { what, cell }),
            _ => Ok(()),
        };
        inside("the start", self.start)?;
        standing("the start", self.start)?;
        if let Goal::Nearest(targets) | Goal::Every(targets) | Goal::Chain(targets) = &self.goal {
            if targets.is_empty() {
                return Err(GrowError::NoTarget);
            }
            for &cell in targets {
                inside("a target", cell)?;
                standing("a target", cell)?;
            }
        }
        self.refuse_what_cannot_be_reached(&map)?;
        Ok(map)
    }

    fn refuse_what_cannot_be_reached(&self, map: &[u8]) -> Result<(), GrowError> {
        // In an empty grid everything can be reached.
        if self.goal == Goal::Free || self.obstacles.is_empty() {
            return Ok(());
        }
        let reached = flood(&Walk::new(self.grid, self.neighbours), map, &[self.start]);
        let missed = |cell: &&Cell| !reached[**cell as usize];
        let refused = match &self.goal {
            Goal::Free => None,
            Goal::Every(targets) | Goal::Chain(targets) => targets.iter().find(missed).copied(),
            Goal::Nearest(targets) => targets.iter().all(|cell| missed(&cell)).then(|| targets[0]),
            Goal::Ground => {
                let shut = !self.grid.ground().any(|cell| reached[cell as usize]);
                shut.then(|| self.grid.bottom_centre())
            }
        };
        refused.map_or(Ok(()), |cell| Err(GrowError::Unreachable { cell }))
    }
}

/// Every cell that a walk from `sources` through cells that are no obstacles can come to.
pub(super) fn flood(walk: &Walk, map: &[u8], sources: &[Cell]) -> Vec<bool> {
    let mut reached = vec![false; map.len()];
    let mut open: Vec<Cell> = Vec::new();
    for &cell in sources {
        reached[cell as usize] = true;
        open.push(cell);
    }
    while let Some(cell) = open.pop() {
        for next in walk.around(cell) {
            let seen = &mut reached[next as usize];
            if !*seen && map[next as usize] != state::OBSTACLE {
                *seen = true;
                open.push(next);
            }
        }
    }
    reached
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene() -> Scene {
        Scene::top_to_bottom(Grid::plane(9, 9).expect("a grid"))
    }

    #[test]
    fn what_is_wrong_is_refused_by_name() {
        let right = scene();
        assert!(right.checked().is_ok());
        let start = right.start;
        let wrong = |change: fn(&mut Scene)| {
            let mut scene = scene();
            change(&mut scene);
            scene.checked().expect_err("a wrong scene")
        };
        assert_eq!(wrong(|s| s.start = 81), GrowError::Outside { what: "the start", cell: 81, cells: 81 });
        assert_eq!(wrong(|s| s.obstacles = vec![s.start]), GrowError::OnObstacle { what: "the start", cell: start });
        assert_eq!(wrong(|s| s.goal = Goal::Chain(vec![])), GrowError::NoTarget);
        assert_eq!(
            wrong(|s| s.goal = Goal::Every(vec![4, 99])),
            GrowError::Outside { what: "a target", cell: 99, cells: 81 }
        );
        assert_eq!(wrong(|s| s.obstacles = vec![4]), GrowError::OnObstacle { what: "a target", cell: 4 });
    }

    #[test]
    fn walls_make_targets_unreachable_and_gaps_reachable() {
        let mut scene = scene();
        let wall: Vec<Cell> = (0..9).map(|x| scene.grid.cell([x, 4, 0])).collect();
        scene.obstacles = wall.clone();
        assert_eq!(scene.checked(), Err(GrowError::Unreachable { cell: 4 }));
        scene.goal = Goal::Ground;
        assert!(matches!(scene.checked(), Err(GrowError::Unreachable { .. })));
        scene.goal = Goal::Nearest(vec![4, scene.grid.cell([0, 8, 0])]);
        assert!(scene.checked().is_ok());
        scene.goal = Goal::Chain(vec![scene.grid.cell([0, 8, 0]), 4]);
        assert_eq!(scene.checked(), Err(GrowError::Unreachable { cell: 4 }));
        scene.obstacles.remove(7);
        assert!(scene.checked().is_ok());
        // A diagonal gap lets 8 neighbours through and not 4.
        scene.obstacles = wall;
        scene.obstacles[3] = scene.grid.cell([3, 3, 0]);
        assert!(scene.checked().is_ok());
        scene.neighbours = Neighbours::Faces;
        assert_eq!(scene.checked(), Err(GrowError::Unreachable { cell: 4 }));
    }
}
