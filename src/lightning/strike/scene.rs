//! The grid in which the channel of a strike grows, and where it lies over the ground.

use super::{MOST_GROUNDS, StrikeSpec};
use crate::lightning::error::GrowError;
use crate::lightning::flash::{FlashKind, Polarity};
use crate::lightning::grid::{Cell, Grid};
use crate::lightning::random::Stream;
use crate::lightning::scene::{Goal, Scene};
use crate::lightning::shape::Shape;
use crate::numeric::exact::cos_sin_turns;

/// Least height of a channel's origin.
const LOWEST_ORIGIN_M: f64 = 30.0;
/// Cells of a channel to ground along each axis.
const SIDE: u32 = 64;
/// Cells along the ground where ground points lie far apart.
const WIDE_SIDE: u32 = 96;
/// Cells of the grid beyond the farthest ground point.
const MARGIN: u32 = 8;
/// Share of its height by which a channel to ground starts beside its ground point at most; positive ones come from farther.
const SLANT: [f64; 2] = [0.22, 0.45];
/// Cells upwards of a channel inside clouds.
const FLAT_SIDE: u32 = 16;
/// Length of channels inside a cloud: median, and the spread of its common logarithm. Flashes inside clouds are some
/// kilometres long (Rakov and Uman 2003, 9.2), those between clouds more.
const INSIDE_M: (f64, f64) = (4_500.0, 0.15);
const BETWEEN_M: (f64, f64) = (11_000.0, 0.12);
/// Shortest and longest of them.
const LENGTH_M: [f64; 2] = [1_500.0, 25_000.0];
/// Depth of a channel in clear air, of its length.
const CLEAR_DEPTH: f64 = 0.12;

/// Scene, drawing and place of a channel.
pub(super) struct Plan {
    pub scene: Scene,
    pub shape: Shape,
    /// The cells of the ground points, in their order; none inside clouds.
    pub ends: Vec<Cell>,
    /// Where the origin of the places below lies in the grid, m.
    centre_m: [f64; 3],
    /// Factor on heights.
    squash: f64,
    /// Height of the centre, m.
    height_m: f64,
    /// Cosine and sine of the turn about the vertical.
    turn: (f64, f64),
}

impl Plan {
    /// A place in the grid (m) as east, north and up from the strike's ground point.
    pub fn placed(&self, grid_m: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = std::array::from_fn(|axis| grid_m[axis] - self.centre_m[axis]);
        let (cos, sin) = self.turn;
        [cos * x - sin * y, sin * x + cos * y, self.height_m + self.squash * z]
    }

    /// Centre of a cell in metres of the grid.
    pub fn cell_position_m(&self, cell: Cell) -> [f64; 3] {
        self.scene.grid.position(cell).map(|k| f64::from(k) * self.shape.cell_m)
    }
}

/// The scene of a strike.
pub(super) fn plan(spec: &StrikeSpec) -> Result<Plan, GrowError> {
    match spec.kind {
        FlashKind::CloudToGround => to_ground(spec),
        FlashKind::IntraCloud => inside(spec, INSIDE_M, [SIDE, SIDE, FLAT_SIDE]),
        FlashKind::CloudToCloud => inside(spec, BETWEEN_M, [WIDE_SIDE, SIDE / 2, FLAT_SIDE]),
    }
}

/// From the charge down to each ground point.
fn to_ground(spec: &StrikeSpec) -> Result<Plan, GrowError> {
    let origin_m = if spec.origin_m.is_finite() { spec.origin_m.max(LOWEST_ORIGIN_M) } else { LOWEST_ORIGIN_M };
    let grounds: &[[f64; 2]] = if spec.grounds_m.is_empty() { &[[0.0; 2]] } else { &spec.grounds_m };
    let grounds = &grounds[..grounds.len().min(MOST_GROUNDS)];
    let reach_m = grounds.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
    let layers = SIDE - 1;
    let fine_m = origin_m / f64::from(layers);
    let needed = 2.0 * (reach_m / fine_m + f64::from(MARGIN));
    // Where ground points lie too far apart for the grid, its cells grow, and there are fewer of them upwards.
    let side = if needed <= f64::from(SIDE) { SIDE } else { WIDE_SIDE };
    let half = f64::from(side / 2 - MARGIN);
    let up = ((half * origin_m / reach_m.max(1e-3)) as u32).clamp(MARGIN, layers);
    let cell_m = origin_m / f64::from(up);
    let grid = Grid::volume(side, side, up + 1)?;
    let middle = side / 2;
    let cell = |x_m: f64| {
        let steps = (x_m / cell_m).round().clamp(-half, half);
        (f64::from(middle) + steps) as u32
    };
    let mut stream = Stream::new(spec.seed, 1 << 20);
    let (cos, sin) = cos_sin_turns(stream.unit());
    let slant = SLANT[usize::from(spec.polarity == Polarity::Positive)] * stream.unit() * origin_m;
    let start = grid.cell([cell(slant * cos), cell(slant * sin), up]);
    let ends: Vec<Cell> = grounds.iter().map(|&[east, north]| grid.cell([cell(east), cell(north), 0])).collect();
    // Ground points in one cell share their channel.
    let mut goals: Vec<Cell> = Vec::new();
    for &end in &ends {
        if !goals.contains(&end) {
            goals.push(end);
        }
    }
    let scene = Scene { start, goal: Goal::Every(goals), ..Scene::top_to_bottom(grid) };
    let centre_m = [f64::from(middle) * cell_m, f64::from(middle) * cell_m, 0.0];
    let shape = Shape::of_cells(cell_m);
    Ok(Plan { scene, shape, ends, centre_m, squash: 1.0, height_m: 0.0, turn: (1.0, 0.0) })
}

/// Through a cloud or from one to another: from the middle (or one end) to several ends, as deep as the cloud.
fn inside(spec: &StrikeSpec, (median_m, spread): (f64, f64), size: [u32; 3]) -> Result<Plan, GrowError> {
    let mut stream = Stream::new(spec.seed, 1 << 20);
    let turn = cos_sin_turns(stream.unit());
    let length_m = stream.log_normal(median_m, spread, LENGTH_M);
    let cell_m = length_m / f64::from(size[0]);
    let grid = Grid::volume(size[0], size[1], size[2])?;
    let mut within = |low: f64, high: f64, axis: usize| {
        let share = low + (high - low) * stream.unit();
        ((share * f64::from(size[axis])) as u32).min(size[axis] - 1)
    };
    let mut place = |x: [f64; 2], y: [f64; 2]| [within(x[0], x[1], 0), within(y[0], y[1], 1), within(0.15, 0.85, 2)];
    let (start, ends) = if spec.kind == FlashKind::IntraCloud {
        let ends = [place([0.02, 0.10], [0.2, 0.8]), place([0.90, 0.98], [0.2, 0.8]), place([0.3, 0.7], [0.02, 0.15])];
        ([size[0] / 2, size[1] / 2, size[2] / 2], ends)
    } else {
        let ends = [place([0.92, 0.98], [0.3, 0.7]), place([0.6, 0.8], [0.02, 0.2]), place([0.4, 0.7], [0.8, 0.98])];
        (place([0.02, 0.08], [0.3, 0.7]), ends)
    };
    let goal = Goal::Every(ends.iter().map(|&end| grid.cell(end)).collect());
    let scene = Scene { start: grid.cell(start), goal, ..Scene::top_to_bottom(grid) };
    let centre_m = size.map(|side| 0.5 * f64::from(side) * cell_m);
    let depth_m = f64::from(size[2]) * cell_m;
    let [base_m, top_m] = spec.cloud_m;
    let cloud_m = if top_m > base_m { 0.8 * (top_m - base_m) } else { CLEAR_DEPTH * length_m };
    let squash = (cloud_m / depth_m).min(1.0);
    // The whole depth within the cloud, as near to the origin as that leaves.
    let half = 0.5 * squash * depth_m;
    let height_m =
        if top_m - base_m >= 2.0 * half { spec.origin_m.clamp(base_m + half, top_m - half) } else { spec.origin_m };
    let shape = Shape::of_cells(cell_m);
    Ok(Plan { scene, shape, ends: Vec::new(), centre_m, squash, height_m, turn })
}
