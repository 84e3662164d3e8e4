//! The edge of a growing channel: which cells are part of it, which touch it, which target comes next.
//!
//! All methods on a grid share it; they differ only in the chance that they give to each candidate.

use super::channel::{Channel, Info, Stop};
use super::error::GrowError;
use super::grid::{Cell, Walk};
use super::scene::{Goal, Scene, state};
use std::collections::VecDeque;

/// A cell that touches the channel, and the node that it would grow from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Candidate {
    pub cell: Cell,
    pub parent: u32,
}

/// What one more cell changed.
#[derive(Debug, Default)]
pub(super) struct Step {
    /// Cells that joined the channel: the drawn one, then targets that it touched and growth goes on from.
    pub charged: Vec<Cell>,
    /// Cells that touch the channel now and did not before.
    pub fresh: Vec<Candidate>,
    /// Candidates that joined as targets, without being drawn.
    pub taken: Vec<Cell>,
    /// Whether the targets that attract are other ones now.
    pub retargeted: bool,
}

/// One or several cells that attract at the same time.
struct Stage {
    targets: Vec<Cell>,
    /// Whether each must be reached, or one is enough.
    every: bool,
    /// Waypoints are no targets: they do not count as reached.
    counts: bool,
}

/// The growing channel.
pub(super) struct Frontier {
    pub scene: Scene,
    /// State of every cell.
    pub map: Vec<u8>,
    /// Targets that attract now.
    pub active: Vec<Cell>,
    /// Whether the active targets are the whole ground layer.
    pub ground: bool,
    walk: Walk,
    stages: VecDeque<Stage>,
    /// Cell and parent of every node.
    nodes: Vec<(Cell, u32)>,
    ends: Vec<u32>,
    joined: u32,
    finished: bool,
}

impl Frontier {
    /// The frontier of a channel that is nothing but its start, and the first step.
    ///
    /// `map` is that of [`Scene::checked`]; the waypoints of a leg come before its target, one after another.
    pub fn new(scene: &Scene, map: Vec<u8>, waypoints: &[Vec<Cell>]) -> (Self, Step) {
        let goals: Vec<(Vec<Cell>, bool)> = match &scene.goal {
            Goal::Free => Vec::new(),
            Goal::Nearest(targets) => vec![(targets.clone(), false)],
            Goal::Every(targets) => vec![(targets.clone(), true)],
            Goal::Chain(targets) => targets.iter().map(|&target| (vec![target], false)).collect(),
            Goal::Ground => {
                let open = |cell: &Cell| map[*cell as usize] != state::OBSTACLE;
                vec![(scene.grid.ground().filter(open).collect(), false)]
            }
        };
        let mut stages = VecDeque::new();
        for (leg, (targets, every)) in goals.into_iter().enumerate() {
            let way = waypoints.get(leg).into_iter().flatten();
            stages.extend(way.map(|&cell| Stage { targets: vec![cell], every: false, counts: false }));
            stages.push_back(Stage { targets, every, counts: true });
        }
        let mut frontier = Self {
            walk: Walk::new(scene.grid, scene.neighbours),
            scene: scene.clone(),
            map,
            active: Vec::new(),
            ground: false,
            stages,
            nodes: Vec::new(),
            ends: Vec::new(),
            joined: 0,
            finished: false,
        };
        let mut step = Step::default();
        frontier.grow_with(Candidate { cell: scene.start, parent: 0 }, &mut step, true);
        (frontier, step)
    }

    /// Grows a candidate, which the caller has taken out of its list; `step` tells what that changed.
    pub fn grow(&mut self, candidate: Candidate, step: &mut Step) {
        self.grow_with(candidate, step, false);
    }

    /// Whether everything was reached.
    pub fn finished(&self) -> bool {
        self.finished
    }

    /// Cells grown so far.
    pub fn cells(&self) -> u32 {
        self.nodes.len() as u32 - self.joined
    }

    /// The channel and how its growth went.
    pub fn end(self, stop: Stop, iterations: u64, residual: f64) -> (Channel, Info) {
        let info = Info {
            cells: self.cells(),
            reached: self.finished,
            targets_reached: self.ends.len() as u32,
            iterations,
            residual,
            stop: if self.finished { Stop::Reached } else { stop },
        };
        (Channel::of_cells(self.scene.grid, &self.nodes, self.ends), info)
    }

    /// The error of a caller who asks to stop now.
    pub fn cancelled(&self) -> GrowError {
        GrowError::Cancelled { cells: self.cells() }
    }

    fn grow_with(&mut self, candidate: Candidate, step: &mut Step, first: bool) {
        step.charged.clear();
        step.fresh.clear();
        step.taken.clear();
        step.retargeted = false;
        let from = self.nodes.len();
        self.charge(candidate.cell, candidate.parent, step);
        if first {
            self.activate(step);
        }
        // Each charged cell may touch targets, which are charged in their turn.
        let mut done = from;
        while done < self.nodes.len() && !self.finished {
            let (cell, _) = self.nodes[done];
            let touched = self.walk.around(cell).find(|&next| self.map[next as usize] == state::TARGET);
            match touched {
                Some(target) => self.reach(target, done as u32, step),
                None => done += 1,
            }
        }
        if self.finished {
            return;
        }
        for node in from..self.nodes.len() {
            let (cell, _) = self.nodes[node];
            for next in self.walk.around(cell) {
                let here = &mut self.map[next as usize];
                if *here == state::FREE {
                    *here = state::CANDIDATE;
                    step.fresh.push(Candidate { cell: next, parent: node as u32 });
                }
            }
        }
    }

    fn charge(&mut self, cell: Cell, parent: u32, step: &mut Step) {
        self.map[cell as usize] = state::GROWN;
        self.nodes.push((cell, parent));
        step.charged.push(cell);
    }

    /// An active target is touched by a node: it is joined, and growth goes on from it if it is not over.
    fn reach(&mut self, target: Cell, node: u32, step: &mut Step) {
        self.charge(target, node, step);
        self.joined += 1;
        self.arrive(target, self.nodes.len() as u32 - 1, step);
    }

    /// Counts a target of the present stage as reached at a node, and opens the next stage when this one is over.
    fn arrive(&mut self, target: Cell, node: u32, step: &mut Step) {
        step.retargeted = true;
        let Some(stage) = self.stages.front() else { return };
        if stage.counts {
            self.ends.push(node);
        }
        self.active.retain(|&cell| cell != target);
        if stage.every && !self.active.is_empty() {
            return;
        }
        for cell in self.active.drain(..) {
            self.map[cell as usize] = state::FREE;
        }
        self.stages.pop_front();
        self.activate(step);
    }

    /// Lets the targets of the next stage attract; those that the channel already holds or touches are reached at once.
    fn activate(&mut self, step: &mut Step) {
        let Some(stage) = self.stages.front() else {
            self.finished = self.scene.goal != Goal::Free;
            return;
        };
        self.ground = stage.counts && self.scene.goal == Goal::Ground;
        let (targets, every) = (stage.targets.clone(), stage.every);
        let stages_left = self.stages.len();
        self.active.clear();
        for &cell in &targets {
            if self.map[cell as usize] != state::GROWN && !self.active.contains(&cell) {
                self.active.push(cell);
            }
        }
        step.retargeted = true;
        // Already part of the channel (a target named twice is one target).
        let mut held: Vec<Cell> = targets.into_iter().filter(|&cell| self.map[cell as usize] == state::GROWN).collect();
        held.dedup();
        if !every {
            held.truncate(1);
        }
        for cell in held {
            let node = self.nodes.iter().position(|&(grown, _)| grown == cell).unwrap_or_default() as u32;
            self.arrive(cell, node, step);
            if self.stages.len() != stages_left {
                return;
            }
        }
        for cell in self.active.clone() {
            if self.map[cell as usize] == state::CANDIDATE {
                step.taken.push(cell);
                let parent = self
                    .walk
                    .around(cell)
                    .find_map(|next| self.nodes.iter().position(|&(grown, _)| grown == next).map(|node| node as u32));
                self.reach(cell, parent.unwrap_or_default(), step);
                if self.stages.len() != stages_left {
                    return;
                }
            } else {
                self.map[cell as usize] = state::TARGET;
            }
        }
    }
}
