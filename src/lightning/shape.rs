//! From grid cells to lines that look grown: off the grid, smooth, then crooked below the grid's size.

use super::branches::{Appearance, Branches, branches};
use super::channel::Channel;
use super::random::Stream;
use super::tortuosity::Tortuosity;
use glam::DVec3;

/// How a channel is drawn out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Metres to a cell.
    pub cell_m: f64,
    /// Greatest move of a node off its cell's centre along each axis, in cells: hides the grid. 0 leaves it.
    pub jitter: f64,
    /// Rounds of smoothing between neighbours along a line, 0 to 8.
    pub smoothing: u32,
    /// Pieces of smooth curve to a step of the grid, 1 to 16. 1 leaves steps straight for the detail to bend, which looks most
    /// like a channel; more rounds them first.
    pub pieces: u32,
    /// Metres down to which pieces are made crooked; no less than a thousandth of a cell is made.
    pub finest_m: f64,
    /// Times the crookedness observed in nature: 0 none, 1 as observed.
    pub tortuosity: f64,
    /// Thickness and brightness.
    pub appearance: Appearance,
}

impl Shape {
    /// The shape of channels of cells of this size: crooked down to 4 m, so that a bolt is crisp at 500 m, or down to a 32nd of
    /// a large cell, so that a channel from any height has about as many points.
    pub fn of_cells(cell_m: f64) -> Self {
        let appearance = Appearance::default();
        Self {
            cell_m,
            jitter: 0.35,
            smoothing: 1,
            pieces: 1,
            finest_m: (cell_m / 32.0).max(4.0),
            tortuosity: 1.0,
            appearance,
        }
    }
}

/// A point of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Metres along the grid's axes from the centre of cell 0.
    pub position_m: [f64; 3],
    /// Metres along the channel from its start, before it was made crooked.
    pub along_m: f64,
    /// Thickness, 1 on the main channel.
    pub thickness: f64,
    /// Brightness, 1 on the main channel.
    pub brightness: f64,
}

/// A line of points from where it leaves its parent (or the start) to its tip.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// 0 for the main channel, 1 for what leaves it, and so on.
    pub order: u32,
    /// The line that it leaves and the number of the point there, which is also its own first point.
    pub parent: Option<(u32, u32)>,
    /// Its points, at least 1.
    pub points: Vec<Point>,
}

/// Draws a channel out into lines, parents before children. `axes` is the grid's: in a plane everything stays in it.
pub fn lines(channel: &Channel, axes: usize, shape: &Shape, seed: u64) -> Vec<Line> {
    let branches = branches(channel, &shape.appearance);
    let mut positions = jittered(channel, axes, shape.jitter, seed);
    let runs = runs(channel, &branches);
    let mut lines: Vec<Line> = Vec::with_capacity(runs.len());
    // Where each node came to be: line and point.
    let mut place = vec![(0, 0); channel.nodes.len()];
    let detail = Tortuosity { finest: shape.finest_m.max(1e-3 * shape.cell_m), strength: shape.tortuosity, axes };
    for (number, run) in runs.iter().enumerate() {
        // Parents come first, so the node that a run leaves has its final place already.
        let fixed_end = channel.ends.contains(run.last().unwrap_or(&0));
        smooth(&mut positions, run, shape.smoothing.min(8), fixed_end);
        let mut stream = Stream::new(seed, 1 + number as u64);
        let parent = (number > 0).then(|| place[run[0] as usize]);
        let mut line = Line { order: branches.order[*run.last().unwrap_or(&0) as usize], parent, points: Vec::new() };
        draw(&mut line, run, &positions, &branches, shape, &detail, &mut stream, |node, point| {
            if number == 0 || node != run[0] {
                place[node as usize] = (number as u32, point);
            }
        });
        lines.push(line);
    }
    lines
}

/// Positions in cells moved off the centres, except start and targets.
fn jittered(channel: &Channel, axes: usize, jitter: f64, seed: u64) -> Vec<DVec3> {
    let mut stream = Stream::new(seed, 0);
    let mut one = |number: usize, position: [f64; 3]| {
        let mut moved = position;
        for coordinate in &mut moved[..axes] {
            *coordinate += jitter * (2.0 * stream.unit() - 1.0);
        }
        let kept = number == 0 || channel.ends.contains(&(number as u32));
        DVec3::from_array(if kept { position } else { moved })
    };
    channel.nodes.iter().enumerate().map(|(number, node)| one(number, node.position)).collect()
}

/// The nodes of each line, from the node that it leaves to its tip; parents before children.
fn runs(channel: &Channel, branches: &Branches) -> Vec<Vec<u32>> {
    let follow = |mut run: Vec<u32>| {
        while let Some(next) = run.last().and_then(|&last| branches.next[last as usize]) {
            run.push(next);
        }
        run
    };
    let mut runs = vec![follow(vec![0])];
    for node in 1..channel.nodes.len() as u32 {
        let parent = channel.nodes[node as usize].parent;
        if branches.next[parent as usize] != Some(node) {
            runs.push(follow(vec![parent, node]));
        }
    }
    runs
}

/// Moves the inner nodes of a run towards their neighbours' middle.
fn smooth(positions: &mut [DVec3], run: &[u32], rounds: u32, fixed_end: bool) {
    let last = run.len() - 1;
    for _ in 0..rounds {
        let before: Vec<DVec3> = run.iter().map(|&node| positions[node as usize]).collect();
        for k in 1..last {
            positions[run[k] as usize] = 0.5 * before[k] + 0.25 * (before[k - 1] + before[k + 1]);
        }
        // A tip draws in a little, so that no hook is left; a target stays where it is.
        if last > 0 && !fixed_end {
            positions[run[last] as usize] = 0.75 * before[last] + 0.25 * before[last - 1];
        }
    }
}

/// Puts the points of a run on a line: a Catmull-Rom curve through its nodes, then detail between.
#[expect(clippy::too_many_arguments, reason = "all of it is one step of `lines`, cut out to be read by itself")]
fn draw(
    line: &mut Line,
    run: &[u32],
    positions: &[DVec3],
    branches: &Branches,
    shape: &Shape,
    detail: &Tortuosity,
    stream: &mut Stream,
    mut placed: impl FnMut(u32, u32),
) {
    let at = |k: usize| positions[run[k.min(run.len() - 1)] as usize] * shape.cell_m;
    // A side channel begins as thick as itself, not as its parent.
    let look = |k: usize| {
        let node = run[k] as usize;
        let own = run[k.max(1).min(run.len() - 1)] as usize;
        (branches.along[node] * shape.cell_m, branches.thickness[own], branches.brightness[own])
    };
    let mut push = |position: DVec3, from: usize, share: f64| {
        let (a, b) = (look(from), look((from + 1).min(run.len() - 1)));
        let mix = |a: f64, b: f64| a + (b - a) * share;
        let position_m = position.to_array();
        let (along_m, thickness, brightness) = (mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2));
        line.points.push(Point { position_m, along_m, thickness, brightness });
        line.points.len() as u32 - 1
    };
    let first = push(at(0), 0, 0.0);
    placed(run[0], first);
    let pieces = shape.pieces.clamp(1, 16);
    let mut between = Vec::new();
    for k in 0..run.len() - 1 {
        let corners = [at(k.saturating_sub(1)), at(k), at(k + 1), at(k + 2)];
        let mut last = corners[1];
        for piece in 1..=pieces {
            let share = f64::from(piece) / f64::from(pieces);
            let end = if piece == pieces { corners[2] } else { catmull_rom(corners, share) };
            between.clear();
            detail.between(last, end, stream, &mut between);
            let from = f64::from(piece - 1) / f64::from(pieces);
            for &(point, inner) in &between {
                push(point, k, from + inner / f64::from(pieces));
            }
            let number = push(end, k, share);
            if piece == pieces {
                placed(run[k + 1], number);
            }
            last = end;
        }
    }
}

/// The uniform Catmull-Rom curve between the middle two of four points (Catmull and Rom 1974).
fn catmull_rom([a, b, c, d]: [DVec3; 4], t: f64) -> DVec3 {
    0.5 * (2.0 * b
        + (c - a) * t
        + (2.0 * a - 5.0 * b + 4.0 * c - d) * (t * t)
        + (3.0 * b - a - 3.0 * c + d) * (t * t * t))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lightning::grid::Grid;
    use crate::lightning::grow::{Method, grow};
    use crate::lightning::scene::Scene;
    use crate::lightning::tables::Tables;
    use std::sync::atomic::AtomicBool;

    fn bolt(grid: Grid) -> Channel {
        let scene = Scene::top_to_bottom(grid);
        let method = Method::rational(2.0, 3.0);
        grow(&method, &scene, 10_000, 3, &mut Tables::default(), &AtomicBool::new(false)).expect("a right scene").0
    }

    #[test]
    fn lines_join_and_lead_from_start_to_target() {
        for grid in [Grid::plane(48, 48), Grid::volume(24, 24, 24)].map(|grid| grid.expect("a grid")) {
            let channel = bolt(grid);
            let shape = Shape::of_cells(50.0);
            let drawn = lines(&channel, grid.axes(), &shape, 7);
            for (number, line) in drawn.iter().enumerate() {
                assert!(line.points.iter().all(|p| p.position_m.iter().all(|x| x.is_finite())));
                assert!(line.points.windows(2).all(|pair| pair[1].along_m >= pair[0].along_m));
                match line.parent {
                    None => assert_eq!(number, 0),
                    Some((parent, point)) => {
                        assert!((parent as usize) < number);
                        let there = drawn[parent as usize].points[point as usize].position_m;
                        assert_eq!(there, line.points[0].position_m, "line {number} leaves its parent's point");
                        assert!(line.order >= drawn[parent as usize].order);
                    }
                }
            }
            let main = &drawn[0];
            let cell = |node: usize| channel.nodes[node].position.map(|x| x * 50.0);
            assert_eq!(main.points[0].position_m, cell(0));
            assert_eq!(main.points.last().expect("a point").position_m, cell(channel.ends[0] as usize));
            assert!(main.points.iter().all(|p| p.brightness == 1.0 && p.thickness == 1.0));
            // Crisp at 500 m: pieces are of finest_m, and what an uneven split and a step aside add to a half.
            let longest = main.points.windows(2).map(|p| distance(p[0], p[1])).fold(0.0, f64::max);
            assert!(longest < 1.5 * shape.finest_m, "{longest}");
            assert_eq!(drawn, lines(&channel, grid.axes(), &shape, 7));
            assert_ne!(drawn, lines(&channel, grid.axes(), &shape, 8));
        }
    }

    fn distance(a: Point, b: Point) -> f64 {
        DVec3::from_array(a.position_m).distance(DVec3::from_array(b.position_m))
    }

    #[test]
    fn without_any_of_it_the_nodes_are_the_points() {
        let channel = bolt(Grid::plane(20, 20).expect("a grid"));
        let plain = Shape { jitter: 0.0, smoothing: 0, pieces: 1, tortuosity: 0.0, ..Shape::of_cells(1.0) };
        let drawn = lines(&channel, 2, &plain, 1);
        // Each line repeats the node that it leaves.
        let points: usize = drawn.iter().map(|line| line.points.len()).sum();
        assert_eq!(points, channel.nodes.len() + drawn.len() - 1);
    }

    #[test]
    fn a_channel_of_one_node_is_one_point() {
        let one = Channel { nodes: vec![bolt(Grid::plane(9, 9).expect("a grid")).nodes[0]], ends: vec![0] };
        let drawn = lines(&one, 2, &Shape::of_cells(10.0), 1);
        assert_eq!((drawn.len(), drawn[0].points.len()), (1, 1));
    }
}
