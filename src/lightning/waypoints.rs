//! A way round obstacles: the corners of a shortest path, for methods that only feel how far a target is.
//!
//! A potential of distance alone pulls straight at a target behind a wall and grows against it (Yun et al., section 4.2 and
//! figure 10). So when the straight line is blocked, A* finds a path, and its corners become targets one after another.

use super::error::GrowError;
use super::grid::{Cell, Grid, Walk};
use super::scene::{Goal, Scene, state};
use pathfinding::prelude::astar;

/// Most cells of a grid in which a path is searched: the search keeps some 60 bytes a cell that it sees.
pub const MOST_SEARCHED_CELLS: usize = 1 << 22;
/// Cost of a step that changes no, one, two or three coordinates: 70 times its length, in whole numbers.
const COSTS: [u32; 4] = [0, 70, 99, 121];
/// Up to so many targets the distance to the nearest guides the search.
const MOST_GUIDES: usize = 16;

/// For each leg of the goal (each target of a chain; else one) the waypoints that lead round obstacles. No waypoints where the
/// target is in sight, where the scene wants none, and for goals without a first target.
///
/// # Errors
/// [`GrowError::SearchSize`]: a way must be found in a grid too large for it.
pub(super) fn waypoints(scene: &Scene, map: &[u8]) -> Result<Vec<Vec<Cell>>, GrowError> {
    if !scene.waypoints || scene.obstacles.is_empty() {
        return Ok(Vec::new());
    }
    match &scene.goal {
        Goal::Free | Goal::Every(_) => Ok(Vec::new()),
        Goal::Chain(targets) => {
            let starts = std::iter::once(&scene.start).chain(targets);
            starts.zip(targets).map(|(&from, &to)| corners(scene, map, from, &[to])).collect()
        }
        Goal::Nearest(targets) => Ok(vec![corners(scene, map, scene.start, targets)?]),
        Goal::Ground => {
            let open = |cell: &Cell| map[*cell as usize] != state::OBSTACLE;
            let targets: Vec<Cell> = scene.grid.ground().filter(open).collect();
            Ok(vec![corners(scene, map, scene.start, &targets)?])
        }
    }
}

/// The corners of a shortest path from a cell to the nearest of some targets, without its ends.
fn corners(scene: &Scene, map: &[u8], from: Cell, targets: &[Cell]) -> Result<Vec<Cell>, GrowError> {
    let grid = scene.grid;
    if targets.iter().any(|&target| in_sight(grid, map, from, target)) {
        return Ok(Vec::new());
    }
    if grid.cells() > MOST_SEARCHED_CELLS {
        return Err(GrowError::SearchSize { cells: grid.cells(), limit: MOST_SEARCHED_CELLS });
    }
    let walk = Walk::new(grid, scene.neighbours);
    let mut is_target = vec![false; grid.cells()];
    for &target in targets {
        is_target[target as usize] = true;
    }
    let steps = |&cell: &Cell| {
        let next: Vec<(Cell, u32)> = walk
            .around(cell)
            .filter(|&next| map[next as usize] != state::OBSTACLE)
            .map(|next| (next, COSTS[changed(grid, cell, next)]))
            .collect();
        next
    };
    let guide = |&cell: &Cell| match (&scene.goal, targets.len()) {
        (Goal::Ground, _) => COSTS[1] * grid.layer(cell),
        (_, 1..=MOST_GUIDES) => {
            targets.iter().map(|&target| COSTS[1] * farthest_axis(grid, cell, target)).min().unwrap_or_default()
        }
        _ => 0,
    };
    let Some((path, _)) = astar(&from, steps, guide, |&cell| is_target[cell as usize]) else {
        // The nearest targets may all be shut while a later one is open: the flood fill has said that one can be reached.
        return Ok(Vec::new());
    };
    Ok(pulled_tight(grid, map, &path))
}

/// The cells of a path at which it must turn: from each the next one is the last that is in sight.
fn pulled_tight(grid: Grid, map: &[u8], path: &[Cell]) -> Vec<Cell> {
    let mut corners = Vec::new();
    let mut anchor = 0;
    for next in 2..path.len() {
        if !in_sight(grid, map, path[anchor], path[next]) {
            anchor = next - 1;
            corners.push(path[anchor]);
        }
    }
    corners
}

/// How many coordinates differ.
fn changed(grid: Grid, a: Cell, b: Cell) -> usize {
    let (a, b) = (grid.position(a), grid.position(b));
    (0..3).filter(|&axis| a[axis] != b[axis]).count()
}

fn farthest_axis(grid: Grid, a: Cell, b: Cell) -> u32 {
    let (a, b) = (grid.position(a), grid.position(b));
    (0..3).map(|axis| a[axis].abs_diff(b[axis])).max().unwrap_or_default()
}

/// Whether no obstacle stands on the straight line between two cells.
fn in_sight(grid: Grid, map: &[u8], a: Cell, b: Cell) -> bool {
    let steps = farthest_axis(grid, a, b);
    let (from, to) = (grid.position(a).map(i64::from), grid.position(b).map(i64::from));
    let steps_wide = i64::from(steps.max(1));
    (0..=i64::from(steps)).all(|step| {
        // The nearest cell, in whole numbers: rounds halves up.
        let at = |axis: usize| {
            (2 * from[axis] * steps_wide + 2 * (to[axis] - from[axis]) * step + steps_wide).div_euclid(2 * steps_wide)
        };
        map[grid.cell([at(0) as u32, at(1) as u32, at(2) as u32]) as usize] != state::OBSTACLE
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walled() -> Scene {
        let grid = Grid::plane(21, 21).expect("a grid");
        let mut scene = Scene::top_to_bottom(grid);
        scene.obstacles = (0..18).map(|x| grid.cell([x, 10, 0])).collect();
        scene
    }

    #[test]
    fn the_way_goes_through_the_gap_and_each_leg_is_in_sight() {
        let scene = walled();
        let map = scene.checked().expect("a right scene");
        let legs = waypoints(&scene, &map).expect("a small grid");
        let mut way = vec![scene.start];
        way.extend(&legs[0]);
        way.extend(scene.targets());
        assert!(way.len() > 2);
        assert!(way.windows(2).all(|leg| in_sight(scene.grid, &map, leg[0], leg[1])));
        assert!(way.iter().any(|&cell| scene.grid.position(cell)[0] >= 17));
    }

    #[test]
    fn a_target_in_sight_needs_none_and_a_chain_has_them_for_each_leg() {
        let mut scene = walled();
        scene.obstacles.truncate(3);
        let map = scene.checked().expect("a right scene");
        assert_eq!(waypoints(&scene, &map), Ok(vec![vec![]]));
        let mut scene = walled();
        let (low, high) = (scene.grid.cell([2, 3, 0]), scene.grid.cell([2, 15, 0]));
        scene.goal = Goal::Chain(vec![high, low]);
        let map = scene.checked().expect("a right scene");
        let legs = waypoints(&scene, &map).expect("a small grid");
        assert!(legs[0].is_empty() && !legs[1].is_empty());
        scene.waypoints = false;
        assert_eq!(waypoints(&scene, &map), Ok(vec![]));
    }

    #[test]
    fn the_ground_is_found_and_a_huge_grid_is_refused() {
        let mut scene = walled();
        scene.goal = Goal::Ground;
        let map = scene.checked().expect("a right scene");
        assert!(!waypoints(&scene, &map).expect("a small grid")[0].is_empty());
        let grid = Grid::plane(4096, 1025).expect("a grid");
        let mut scene = Scene::top_to_bottom(grid);
        scene.obstacles = (1..4096).map(|x| grid.cell([x, 500, 0])).collect();
        let map = scene.checked().expect("a right scene");
        assert!(matches!(waypoints(&scene, &map), Err(GrowError::SearchSize { .. })));
    }
}
