//! A grown channel: a tree of points, and how its growth went.

use super::grid::Grid;

/// A point of a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Position in cells: the centre of cell (i, j, k) is at (i, j, k).
    pub position: [f64; 3],
    /// The node that it grew from; nodes come after their parents, and the first is its own.
    pub parent: u32,
}

/// A channel as a tree of points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Channel {
    /// The start first; each node after its parent.
    pub nodes: Vec<Node>,
    /// The nodes at the targets that were reached, in the order of reaching.
    pub ends: Vec<u32>,
}

/// Why growth stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// Everything that the goal asks for was reached.
    Reached,
    /// The limit of cells was met.
    CellLimit,
    /// No cell was left to grow into.
    Exhausted,
}

/// How growth went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Info {
    /// Cells grown, the start among them; targets are joined, not grown. (For Reed and Wyvill: segments and the start.)
    pub cells: u32,
    /// Whether everything that the goal asks for was reached; false for a free channel.
    pub reached: bool,
    /// Targets reached.
    pub targets_reached: u32,
    /// Work done: iterations of the linear solver, or draws of a candidate (above `cells` where draws are rejected).
    pub iterations: u64,
    /// Greatest residual of the linear solver in all solves; 0 where the potential is in closed form.
    pub residual: f64,
    /// Why it stopped.
    pub stop: Stop,
}

impl Channel {
    /// Length of the step to a node from its parent, in cells; 0 for the start.
    pub fn step_length(&self, node: usize) -> f64 {
        let node = self.nodes[node];
        distance(node.position, self.nodes[node.parent as usize].position)
    }

    /// Nodes from the start to `node`, both included.
    pub fn path_to(&self, node: u32) -> Vec<u32> {
        let mut path = vec![node];
        let mut at = node;
        while at != 0 {
            at = self.nodes[at as usize].parent;
            path.push(at);
        }
        path.reverse();
        path
    }

    /// A channel of grid cells.
    pub(super) fn of_cells(grid: Grid, nodes: &[(u32, u32)], ends: Vec<u32>) -> Self {
        let node = |&(cell, parent): &(u32, u32)| Node { position: grid.position(cell).map(f64::from), parent };
        Self { nodes: nodes.iter().map(node).collect(), ends }
    }
}

/// Distance of two points.
pub(super) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let d: [f64; 3] = std::array::from_fn(|axis| a[axis] - b[axis]);
    (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_leads_from_the_start() {
        let node = |x: f64, y: f64, parent| Node { position: [x, y, 0.0], parent };
        let nodes = vec![node(0.0, 0.0, 0), node(1.0, 0.0, 0), node(1.0, 1.0, 0), node(4.0, 5.0, 2)];
        let channel = Channel { nodes, ends: vec![3] };
        assert_eq!(channel.path_to(3), [0, 2, 3]);
        assert_eq!((channel.path_to(0), channel.step_length(3), channel.step_length(0)), (vec![0], 5.0, 0.0));
    }
}
