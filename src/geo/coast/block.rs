//! A block of distances from the shore on a grid of latitudes and longitudes.

use super::rings::{Edge, Rings};

/// Nodes of a block each way; its borders are its neighbours' borders.
pub const NODES: usize = 101;
const METRES_PER_DEGREE: f64 = 111_195.0;
/// No edge is near.
const NONE: u32 = u32::MAX;

/// Signed distances, rows from the south, in metres.
pub struct Block {
    metres: Vec<f32>,
}

/// A grid larger than the block by the reach, on which nodes hand on the nearest edge they know of.
struct Grid<'a> {
    edges: &'a [Edge],
    /// Longitude and latitude of the first node, and the step.
    origin: [f64; 2],
    step: f64,
    width: usize,
    height: usize,
    nearest: Vec<u32>,
    squared: Vec<f64>,
}

impl Block {
    /// The block whose south-west corner lies `column` and `row` blocks from 180 W 90 S.
    pub fn new(rings: &Rings, step_deg: f64, column: i32, row: i32, reach_m: f64) -> Self {
        let size = step_deg * (NODES - 1) as f64;
        let (west, south) = (f64::from(column) * size - 180.0, f64::from(row) * size - 90.0);
        let highest = (south + size).abs().max(south.abs()).min(89.5);
        let rows = (reach_m / METRES_PER_DEGREE / step_deg).ceil() as usize + 1;
        // Near a pole the reach spans many longitudes: there is no shore to be near within 5 degrees of either.
        let columns = ((rows as f64 / highest.to_radians().cos().max(0.1)) as usize).min(4 * NODES);
        let margin = [columns as f64 * step_deg, rows as f64 * step_deg];
        let edges =
            rings.around([west - margin[0], west + size + margin[0]], [south - margin[1], south + size + margin[1]]);
        let mut grid =
            Grid::new(&edges, [west - margin[0], south - margin[1]], step_deg, [NODES + 2 * columns, NODES + 2 * rows]);
        if !edges.is_empty() {
            grid.stamp();
            grid.sweep();
            grid.sweep();
        }
        let mut metres = vec![0.0; NODES * NODES];
        for x in 0..NODES {
            let crossings = rings.crossings(wrapped(west + x as f64 * step_deg));
            for y in 0..NODES {
                let latitude = south + y as f64 * step_deg;
                let south_of_it = crossings.partition_point(|crossing| *crossing < latitude);
                let distance = grid.distance_m(x + columns, y + rows).min(reach_m) as f32;
                metres[x + y * NODES] = if south_of_it % 2 == 0 { distance } else { -distance };
            }
        }
        Self { metres }
    }

    /// Bilinear; coordinates in steps from the south-west corner.
    pub fn at(&self, x: f64, y: f64) -> f32 {
        let split = |v: f64| {
            let low = (v.max(0.0) as usize).min(NODES - 2);
            (low, (v - low as f64).clamp(0.0, 1.0) as f32)
        };
        let ((x0, fx), (y0, fy)) = (split(x), split(y));
        let node = |dx: usize, dy: usize| self.metres[x0 + dx + (y0 + dy) * NODES];
        let low = node(0, 0) + (node(1, 0) - node(0, 0)) * fx;
        let high = node(0, 1) + (node(1, 1) - node(0, 1)) * fx;
        low + (high - low) * fy
    }
}

fn wrapped(longitude_deg: f64) -> f64 {
    (longitude_deg + 180.0).rem_euclid(360.0) - 180.0
}

impl<'a> Grid<'a> {
    fn new(edges: &'a [Edge], origin: [f64; 2], step: f64, [width, height]: [usize; 2]) -> Self {
        let nodes = width * height;
        Self { edges, origin, step, width, height, nearest: vec![NONE; nodes], squared: vec![f64::INFINITY; nodes] }
    }

    /// Square of the distance from a node to an edge, in degrees of latitude, longitudes shortened as at the node: a node on
    /// the border of two blocks so has one distance.
    fn to_edge(&self, x: usize, y: usize, edge: &Edge) -> f64 {
        let latitude = self.origin[1] + y as f64 * self.step;
        let shrink = latitude.to_radians().cos().max(0.01);
        let place = [self.origin[0] + x as f64 * self.step, latitude];
        let along = [(edge.to[0] - edge.from[0]) * shrink, edge.to[1] - edge.from[1]];
        let away = [(place[0] - edge.from[0]) * shrink, place[1] - edge.from[1]];
        let length = along[0] * along[0] + along[1] * along[1];
        let share =
            if length > 0.0 { ((away[0] * along[0] + away[1] * along[1]) / length).clamp(0.0, 1.0) } else { 0.0 };
        let off = [away[0] - share * along[0], away[1] - share * along[1]];
        off[0] * off[0] + off[1] * off[1]
    }

    fn offer(&mut self, x: usize, y: usize, edge: u32) {
        let at = x + y * self.width;
        if edge == NONE || self.nearest[at] == edge {
            return;
        }
        let squared = self.to_edge(x, y, &self.edges[edge as usize]);
        // Equal distances go to the edge of the lower number, whatever the order.
        if squared < self.squared[at] || (squared == self.squared[at] && edge < self.nearest[at]) {
            (self.squared[at], self.nearest[at]) = (squared, edge);
        }
    }

    /// Tells the nodes around each edge of it.
    fn stamp(&mut self) {
        let edges = self.edges;
        for (i, edge) in edges.iter().enumerate() {
            let long = (edge.to[0] - edge.from[0]).abs().max((edge.to[1] - edge.from[1]).abs());
            let pieces = (2.0 * long / self.step).ceil().clamp(1.0, 10_000.0) as usize;
            for k in 0..=pieces {
                let share = k as f64 / pieces as f64;
                let at = |axis: usize| {
                    let place = edge.from[axis] + (edge.to[axis] - edge.from[axis]) * share;
                    ((place - self.origin[axis]) / self.step).floor()
                };
                let (x, y) = (at(0), at(1));
                if x < 0.0 || y < 0.0 || x + 1.0 >= self.width as f64 || y + 1.0 >= self.height as f64 {
                    continue;
                }
                for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    self.offer(x as usize + dx, y as usize + dy, i as u32);
                }
            }
        }
    }

    /// Hands the nearest edges on to the north-east, then to the south-west.
    fn sweep(&mut self) {
        let (width, height) = (self.width, self.height);
        for y in 0..height {
            for x in 0..width {
                self.ask(x, y, -1);
            }
            for x in (0..width).rev() {
                self.ask(x, y, 1);
            }
        }
        for y in (0..height).rev() {
            for x in (0..width).rev() {
                self.ask(x, y, 1);
            }
            for x in 0..width {
                self.ask(x, y, -1);
            }
        }
    }

    fn ask(&mut self, x: usize, y: usize, side: isize) {
        for (dx, dy) in [(side, 0), (0, side), (side, side), (-side, side)] {
            let (Some(nx), Some(ny)) = (x.checked_add_signed(dx), y.checked_add_signed(dy)) else { continue };
            if nx < self.width && ny < self.height {
                let edge = self.nearest[nx + ny * self.width];
                self.offer(x, y, edge);
            }
        }
    }

    fn distance_m(&self, x: usize, y: usize) -> f64 {
        self.squared[x + y * self.width].sqrt() * METRES_PER_DEGREE
    }
}
