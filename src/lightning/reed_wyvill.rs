//! Channels by statistics alone: segments that turn by about 16 degrees, and branches that leave at about 16 degrees.
//!
//! Reed and Wyvill 1994, "Visual simulation of lightning": each segment is its parent turned by an angle about 16 degrees in a
//! random direction; branches begin the same way. The angle between segments is an input here, not a result. What this adds: the side to
//! which a segment turns leans towards the target as far as the channel is off its course, so that it arrives.

use super::channel::{Channel, Info, Node, Stop};
use super::error::{GrowError, in_range};
use super::flash::FlashKind;
use super::grow::Order;
use super::random::Stream;
use super::scene::{Goal, Scene};
use crate::numeric::exact::{cos_sin_turns, ln};
use glam::DVec3;
use std::sync::atomic::Ordering;

/// Statistics of segments and branches.
#[derive(Clone, Debug, PartialEq)]
pub struct ReedWyvill {
    /// Where the flash goes: branches of a stroke to ground lean downwards, others spread.
    pub kind: FlashKind,
    /// Mean angle between a segment and the one before it, and between a branch and its parent, in degrees.
    pub angle_deg: f64,
    /// Standard deviation of that angle in degrees.
    pub angle_spread_deg: f64,
    /// Mean length of a segment in cells; lengths are even between half and one and a half of it. Less makes a finer channel.
    pub segment_cells: f64,
    /// Chance that a branch begins at the end of a segment.
    pub branch_chance: f64,
    /// Greatest length of a branch as a share of what its parent has still before it.
    pub branch_share: f64,
    /// Most orders of branches: 0 draws the main channel alone.
    pub orders: u32,
}

impl Default for ReedWyvill {
    fn default() -> Self {
        Self {
            kind: FlashKind::CloudToGround,
            angle_deg: 16.0,
            angle_spread_deg: 5.0,
            segment_cells: 1.5,
            branch_chance: 0.16,
            branch_share: 0.55,
            orders: 4,
        }
    }
}

/// Off its course by this much and more, a segment always turns back: the distance of unit vectors some 40 degrees apart.
const FULL_STEER: f64 = 0.7;
/// Segments shorten within this many of their lengths from the target, so that a channel cannot circle it.
const SHORTENING: f64 = 8.0;
/// A target within this many segments is joined by a straight one.
const JOIN: f64 = 1.2;
/// How strongly a branch to ground leans downwards, against its own direction.
const LEAN: f64 = 0.35;

/// Where a line of segments goes.
#[derive(Clone, Copy)]
enum Aim {
    /// To a point, which ends it.
    Point(DVec3),
    /// In a direction, for a length in cells; the ground ends it where it is the goal.
    Direction(DVec3, f64),
}

/// A line of segments that is still to be grown.
struct Line {
    from: u32,
    direction: DVec3,
    /// Direction of the first segment, where it is chosen already: that of a branch.
    first: Option<DVec3>,
    aim: Aim,
    order: u32,
}

struct Tree<'a> {
    parameters: &'a ReedWyvill,
    scene: &'a Scene,
    nodes: Vec<Node>,
    stream: Stream,
    most: usize,
    up: DVec3,
}

/// Grows a channel by statistics.
pub(super) fn reed_wyvill(order: &Order<'_>, parameters: &ReedWyvill) -> Result<(Channel, Info), GrowError> {
    in_range("angle_deg", parameters.angle_deg, [0.0, 60.0])?;
    in_range("angle_spread_deg", parameters.angle_spread_deg, [0.0, 30.0])?;
    in_range("segment_cells", parameters.segment_cells, [0.01, 100.0])?;
    in_range("branch_chance", parameters.branch_chance, [0.0, 0.5])?;
    in_range("branch_share", parameters.branch_share, [0.0, 1.0])?;
    in_range("orders", f64::from(parameters.orders), [0.0, 16.0])?;
    let scene = order.scene;
    if !scene.obstacles.is_empty() {
        return Err(GrowError::Obstacles { method: "reed-wyvill" });
    }
    scene.checked()?;
    let mut tree = Tree::new(order, parameters);
    let centre = |cell| DVec3::from_array(scene.grid.position(cell).map(f64::from));
    let targets: Vec<DVec3> = scene.targets().into_iter().map(centre).collect();
    let start = centre(scene.start);
    let mut lines = Vec::new();
    let mut ends = Vec::new();
    match &scene.goal {
        Goal::Free => {
            // A leader each way: in a cloud both spread sideways.
            let away = tree.sideways();
            let length = 0.5 * scene.grid.size().map(f64::from).into_iter().fold(0.0, f64::max);
            for direction in [away, -away] {
                lines.push(Line { from: 0, direction, first: None, aim: Aim::Direction(direction, length), order: 0 });
            }
        }
        Goal::Ground => {
            if tree.height(start) > 0.0 {
                let aim = Aim::Direction(-tree.up, f64::INFINITY);
                ends.extend(tree.line(
                    Line { from: 0, direction: -tree.up, first: None, aim, order: 0 },
                    &mut lines,
                    order,
                )?);
            } else {
                ends.push(0);
            }
        }
        Goal::Nearest(_) => {
            let near = targets.iter().copied().min_by(|a, b| a.distance(start).total_cmp(&b.distance(start)));
            ends.extend(tree.lines_to(&near.map_or(Vec::new(), |near| vec![near]), &mut lines, order)?);
        }
        Goal::Every(_) | Goal::Chain(_) => ends.extend(tree.lines_to(&targets, &mut lines, order)?),
    }
    // What the channel itself needs comes first, branches take what is left of the cells.
    while let Some(line) = lines.pop() {
        tree.line(line, &mut lines, order)?;
    }
    let cells = tree.nodes.len() as u32;
    let wanted = match scene.goal {
        Goal::Free => 0,
        Goal::Ground | Goal::Nearest(_) => 1,
        Goal::Every(_) | Goal::Chain(_) => targets.len(),
    };
    let reached = wanted > 0 && ends.len() == wanted;
    let stop = match (reached, tree.nodes.len() >= tree.most) {
        (true, _) => Stop::Reached,
        (false, true) => Stop::CellLimit,
        (false, false) => Stop::Exhausted,
    };
    let targets_reached = ends.len() as u32;
    let info = Info { cells, reached, targets_reached, iterations: u64::from(cells - 1), residual: 0.0, stop };
    Ok((Channel { nodes: tree.nodes, ends }, info))
}

impl<'a> Tree<'a> {
    fn new(order: &Order<'a>, parameters: &'a ReedWyvill) -> Self {
        let grid = order.scene.grid;
        let up = if grid.axes() == 2 { DVec3::Y } else { DVec3::Z };
        let position = grid.position(order.scene.start).map(f64::from);
        Self {
            parameters,
            scene: order.scene,
            nodes: vec![Node { position, parent: 0 }],
            stream: Stream::new(order.seed, 0),
            most: order.most_cells as usize,
            up,
        }
    }

    fn height(&self, point: DVec3) -> f64 {
        point.dot(self.up)
    }

    /// A random direction along the ground.
    fn sideways(&mut self) -> DVec3 {
        let turns = self.stream.unit();
        if self.scene.grid.axes() == 2 {
            return if turns < 0.5 { DVec3::X } else { -DVec3::X };
        }
        let (cos, sin) = cos_sin_turns(turns);
        DVec3::new(cos, sin, 0.0)
    }

    /// Lines to targets one after another; each begins where the tree is nearest (of a chain: at the target before).
    fn lines_to(&mut self, targets: &[DVec3], lines: &mut Vec<Line>, order: &Order<'_>) -> Result<Vec<u32>, GrowError> {
        let mut ends: Vec<u32> = Vec::new();
        for &target in targets {
            let chain = matches!(self.scene.goal, Goal::Chain(_));
            let from = match ends.last() {
                Some(&end) if chain => end,
                _ => self.nearest(target),
            };
            let at = self.point(from);
            if at.distance_squared(target) == 0.0 {
                ends.push(from);
                continue;
            }
            let direction = (target - at).normalize();
            ends.extend(self.line(
                Line { from, direction, first: None, aim: Aim::Point(target), order: 0 },
                lines,
                order,
            )?);
        }
        Ok(ends)
    }

    fn nearest(&self, target: DVec3) -> u32 {
        let distance = |node: &u32| self.point(*node).distance_squared(target);
        (0..self.nodes.len() as u32).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or_default()
    }

    fn point(&self, node: u32) -> DVec3 {
        DVec3::from_array(self.nodes[node as usize].position)
    }

    /// Grows a line to its end and notes the branches that leave it; the node at a target or on the ground that it came to.
    fn line(&mut self, line: Line, lines: &mut Vec<Line>, order: &Order<'_>) -> Result<Option<u32>, GrowError> {
        let Line { mut from, mut direction, mut first, mut aim, order: rank } = line;
        while self.nodes.len() < self.most {
            if order.cancel.load(Ordering::Relaxed) {
                return Err(GrowError::Cancelled { cells: self.nodes.len() as u32 });
            }
            let at = self.point(from);
            let mut step = self.parameters.segment_cells * (0.5 + self.stream.unit());
            let towards = match aim {
                Aim::Point(target) => {
                    let distance = at.distance(target);
                    if distance <= JOIN * self.parameters.segment_cells {
                        return Ok(Some(self.push(target, from)));
                    }
                    step = step.min(distance / SHORTENING);
                    (target - at) / distance
                }
                Aim::Direction(towards, _) => towards,
            };
            direction = first.take().unwrap_or_else(|| self.turned(direction, towards));
            let next = at + direction * step;
            if let Aim::Direction(_, left) = aim {
                if left.is_finite() && (left < step || !self.inside(next)) {
                    return Ok(None);
                }
                if left.is_infinite() && self.height(next) <= 0.0 {
                    // The ground cuts the last segment off.
                    let share = self.height(at) / (self.height(at) - self.height(next));
                    return Ok(Some(self.push(at + (next - at) * share, from)));
                }
            }
            from = self.push(next, from);
            if let Aim::Direction(_, left) = &mut aim {
                *left -= step;
            }
            if rank < self.parameters.orders && self.stream.unit() < self.parameters.branch_chance {
                lines.push(self.branch(from, direction, aim, rank));
            }
        }
        Ok(None)
    }

    /// A branch that leaves at a node.
    fn branch(&mut self, from: u32, direction: DVec3, aim: Aim, order: u32) -> Line {
        let at = self.point(from);
        let ahead = match aim {
            Aim::Point(target) => at.distance(target),
            Aim::Direction(_, left) if left.is_finite() => left,
            Aim::Direction(..) => self.height(at),
        };
        let length = ahead * self.parameters.branch_share * (0.15 + 0.85 * self.stream.unit());
        let own = self.turned(direction, direction);
        let lean = if self.parameters.kind == FlashKind::CloudToGround { LEAN } else { 0.0 };
        // A branch keeps away from its parent: it leans on to the side to which it left.
        let side = (own - direction).normalize_or_zero();
        let towards = (own + 0.6 * side - lean * self.up).normalize_or(own);
        Line { from, direction, first: Some(own), aim: Aim::Direction(towards, length), order: order + 1 }
    }

    fn push(&mut self, point: DVec3, parent: u32) -> u32 {
        self.nodes.push(Node { position: point.to_array(), parent });
        self.nodes.len() as u32 - 1
    }

    fn inside(&self, point: DVec3) -> bool {
        let size = self.scene.grid.size();
        let p = point.to_array();
        (0..self.scene.grid.axes()).all(|axis| p[axis] >= -0.5 && p[axis] <= f64::from(size[axis]) - 0.5)
    }

    /// A direction turned by an angle of the distribution, to a side that leans towards `towards`.
    fn turned(&mut self, direction: DVec3, towards: DVec3) -> DVec3 {
        let angle_deg = self.parameters.angle_deg + self.parameters.angle_spread_deg * self.normal();
        let (cos, sin) = cos_sin_turns(angle_deg / 360.0);
        let off = direction.distance(towards);
        let steer = (off / FULL_STEER).min(1.0);
        // On course there is no such side: what is left then is rounding.
        let across = towards - direction * towards.dot(direction);
        let across = if across.length_squared() < 1e-18 { DVec3::ZERO } else { across.normalize() };
        if self.scene.grid.axes() == 2 {
            let left = DVec3::new(-direction.y, direction.x, 0.0);
            let side = if across.dot(left) < 0.0 { -left } else { left };
            let side = if self.stream.unit() < 0.5 + 0.5 * steer { side } else { -side };
            return (direction * cos + side * sin).normalize();
        }
        let first = if across == DVec3::ZERO { direction.any_orthonormal_vector() } else { across };
        let second = direction.cross(first);
        let (across, along) = cos_sin_turns((1.0 - steer) * (self.stream.unit() - 0.5));
        let side = first * across + second * along;
        (direction * cos + side * sin).normalize()
    }

    /// Standard normal (Box and Muller 1958) from functions that round alike on every machine.
    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * ln(self.stream.unit())).sqrt();
        radius * cos_sin_turns(self.stream.unit()).0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lightning::grid::Grid;
    use std::sync::atomic::AtomicBool;

    fn grown(scene: &Scene, parameters: &ReedWyvill, seed: u64) -> (Channel, Info) {
        let cancel = AtomicBool::new(false);
        let order = Order { scene, most_cells: 20_000, seed, cancel: &cancel };
        reed_wyvill(&order, parameters).expect("a right scene")
    }

    /// Angles in degrees between segments and the ones before them, without the last one to the target.
    fn turns(channel: &Channel) -> Vec<f64> {
        let at = |node: u32| DVec3::from_array(channel.nodes[node as usize].position);
        let segment = |node: u32| at(node) - at(channel.nodes[node as usize].parent);
        let inner = (1..channel.nodes.len() as u32).filter(|node| !channel.ends.contains(node));
        let after_another = inner.filter(|&node| channel.nodes[node as usize].parent != 0);
        after_another
            .map(|node| segment(node).angle_between(segment(channel.nodes[node as usize].parent)).to_degrees())
            .collect()
    }

    #[test]
    fn segments_turn_by_sixteen_degrees_and_the_target_is_reached() {
        for grid in [Grid::plane(128, 128), Grid::volume(64, 64, 64)] {
            let scene = Scene::top_to_bottom(grid.expect("a grid"));
            let mut all = Vec::new();
            for seed in 0..20 {
                let (channel, info) = grown(&scene, &ReedWyvill::default(), seed);
                assert!(info.reached, "{info:?}");
                let end = channel.nodes[channel.ends[0] as usize].position;
                assert_eq!(end, scene.grid.position(scene.grid.bottom_centre()).map(f64::from));
                all.extend(turns(&channel));
            }
            let mean = all.iter().sum::<f64>() / all.len() as f64;
            // A standard deviation of 5 degrees over some thousand segments: standard error 0.1; five of these. (Negative angles,
            // which count as positive, are a thousandth of the normal distribution.)
            assert!(all.len() > 1500 && (mean - 16.0).abs() < 0.5, "{mean} of {}", all.len());
        }
    }

    #[test]
    fn every_kind_goes_where_it_should() {
        let grid = Grid::volume(64, 64, 64).expect("a grid");
        let (west, east) = (grid.cell([4, 32, 50]), grid.cell([60, 32, 50]));
        let ground = Scene { goal: Goal::Ground, ..Scene::top_to_bottom(grid) };
        let (channel, info) = grown(&ground, &ReedWyvill::default(), 3);
        assert!(info.reached && channel.nodes[channel.ends[0] as usize].position[2].abs() < 1e-9);
        let between = Scene { start: west, goal: Goal::Nearest(vec![east]), ..ground.clone() };
        let spread = ReedWyvill { kind: FlashKind::CloudToCloud, ..Default::default() };
        assert!(grown(&between, &spread, 3).1.reached);
        let inside = Scene { start: grid.cell([32; 3]), goal: Goal::Free, ..ground.clone() };
        let (channel, info) = grown(&inside, &ReedWyvill { kind: FlashKind::IntraCloud, ..Default::default() }, 3);
        assert!(!info.reached && channel.nodes.len() > 40);
        let chain =
            Scene { start: west, goal: Goal::Chain(vec![east, west, grid.cell([32, 32, 0])]), ..ground.clone() };
        let (channel, info) = grown(&chain, &spread, 3);
        assert!(info.reached && info.targets_reached == 3 && channel.ends.len() == 3);
        let every = Scene { goal: Goal::Every(vec![east, west]), ..ground };
        assert_eq!(grown(&every, &spread, 3).1.targets_reached, 2);
    }

    #[test]
    fn limits_and_obstacles() {
        let cancel = AtomicBool::new(false);
        let scene = Scene::top_to_bottom(Grid::plane(64, 64).expect("a grid"));
        let order = |scene| Order { scene, most_cells: 10, seed: 1, cancel: &cancel };
        let (channel, info) = reed_wyvill(&order(&scene), &ReedWyvill::default()).expect("a right scene");
        assert_eq!((channel.nodes.len(), info.stop, info.reached), (10, Stop::CellLimit, false));
        let wild = ReedWyvill { branch_chance: 0.9, ..Default::default() };
        assert!(matches!(reed_wyvill(&order(&scene), &wild), Err(GrowError::Parameter { name: "branch_chance", .. })));
        let shut = Scene { obstacles: vec![7], ..scene.clone() };
        assert!(matches!(reed_wyvill(&order(&shut), &ReedWyvill::default()), Err(GrowError::Obstacles { .. })));
    }
}
