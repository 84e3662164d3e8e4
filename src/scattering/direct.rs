//! Light that comes straight from a source: the first collisions of every cell, with a mean over cells near the source.
//!
//! Near the source (where 1/r^2 and the cell's own extinction vary within a cell) evenly spread rays are followed and
//! what each spends in a cell is counted, so that energy is kept to rounding; farther away one ray per cell stands for the cone that
//! the cell fills (`far`). In thick clouds the collisions around the source are followed one by one (`early`). Everything is
//! fluence, not collisions, so that empty cells need no division.

mod early;
mod far;

pub use early::Early;

use super::angles::Angles;
use super::lanes::dispatch;
use super::medium::Medium;
use super::phase::Phase;
use super::rays::{clip, depth, walk};
use crate::numeric::sphere::{Direction, dot, fibonacci, harmonics};
use std::f64::consts::PI;

/// Directions of the near rays with what is known of each beforehand.
pub struct Rays {
    directions: Vec<Direction>,
    /// Harmonics of each ray.
    harmonics: Vec<f32>,
    /// Phase function from each ray to every direction of the set.
    phase: Vec<f32>,
}

/// What direct light is found with.
#[derive(Clone, Copy)]
pub struct With<'a> {
    /// Directions and moments.
    pub angles: &'a Angles,
    /// Near rays.
    pub rays: &'a Rays,
    /// Phase function as it is.
    pub phase: Phase,
    /// Where early collisions are followed, if they are.
    pub early: Option<Early>,
    /// The ground's depth below the box, m.
    pub ground_depth_m: Option<f64>,
}

/// Direct light of one source of 1 W/sr (or a sum of several).
#[derive(Clone, Debug, PartialEq)]
pub struct Direct {
    /// Moments of the direct radiance in each cell (mean over the cell), W/m^2: cells times moments.
    pub moments: Vec<f32>,
    /// Its scattering into each direction of the set by the phase function as it is, W/(m^2 sr): directions times cells; empty where
    /// nobody asks for it.
    pub towards: Vec<f32>,
    /// What falls on the ground, W/m^2 a column (empty without ground).
    pub ground: Vec<f32>,
    /// Power that leaves the box unscattered, W, of 4 pi.
    pub escaped_w: f64,
    /// Moments of light whose collisions have been followed already, as `moments`: it is there, and nothing of it is left to
    /// scatter. Empty without early collisions.
    pub settled: Vec<f32>,
    /// Radiance of what early collisions have scattered, W/(m^2 sr): directions times cells. Empty without.
    pub arrived: Vec<f32>,
    /// Power that leaves the box after early collisions, W.
    pub escaped_early_w: f64,
    /// For each cell the place of its row in `tilts`, or [`NO_TILT`].
    pub slot: Vec<u32>,
    /// For cells around sources: means of moment times offset from the cell's centre (in edges), three axes times
    /// moments a row. In a source's own cell scattered light goes outwards from the source; without this the cell
    /// would forget where in it the light is and hold too much of it.
    pub tilts: Vec<f32>,
}

/// A cell whose direct light is even enough.
pub const NO_TILT: u32 = u32::MAX;

/// The cells around sources: a block, from and to on each axis.
type Block = [[usize; 2]; 3];

impl Rays {
    /// `count` even directions, for a set of angles and a phase function.
    pub fn new(count: usize, angles: &Angles, phase: Phase) -> Self {
        let directions = fibonacci(count);
        let order = angles.orders.last().copied().unwrap_or(0);
        Self {
            harmonics: directions.iter().flat_map(|d| harmonics(*d, order)).map(|y| y as f32).collect(),
            phase: directions
                .iter()
                .flat_map(|d| angles.set.directions.iter().map(|s| phase.value(dot(*d, *s)) as f32))
                .collect(),
            directions,
        }
    }
}

impl Direct {
    /// No light at all.
    pub fn dark(cells: usize, angles: &Angles, ground: usize) -> Self {
        Self {
            moments: vec![0.0; cells * angles.moments],
            towards: vec![0.0; cells * angles.set.len()],
            ground: vec![0.0; ground],
            escaped_w: 0.0,
            settled: Vec::new(),
            arrived: Vec::new(),
            escaped_early_w: 0.0,
            slot: vec![NO_TILT; cells],
            tilts: Vec::new(),
        }
    }

    /// Adds sources that lie close to each other (or one) in a medium whose extinction is that of the transport (scaled).
    /// Near cells see each of them, far cells see all in their middle.
    pub fn add(&mut self, medium: &Medium, sources: &[(Direction, f64)], with: With) {
        let intensity: f64 = sources.iter().map(|s| s.1).sum();
        if intensity <= 0.0 {
            return;
        }
        let middle: Direction = std::array::from_fn(|k| sources.iter().map(|(p, i)| p[k] * i).sum::<f64>() / intensity);
        let mut near = near_cells(medium, middle, 2.5);
        let mut tilted = near_cells(medium, middle, 1.5);
        for (position, _) in sources {
            near = around(near, near_cells(medium, *position, 2.5));
            tilted = around(tilted, near_cells(medium, *position, 1.5));
        }
        let moments = with.angles.moments;
        if with.early.is_some() && self.settled.is_empty() {
            self.settled = vec![0.0; self.moments.len()];
            self.arrived = vec![0.0; medium.len() * with.angles.set.len()];
        }
        // What these sources add is bounded by themselves, so that sources still add up.
        let before = self.tilted_cells(medium, tilted, moments);
        let mut far = Some(0.0);
        for (index, source) in sources.iter().enumerate() {
            let mut collided = None;
            add_near(self, medium, *source, with, near, &mut collided);
            far = far.zip(collided).map(|(a, b)| a + b);
            if let Some(early) = with.early {
                early.follow(self, medium, (*source, index), with);
            }
        }
        self.bound_tilts(medium, moments, &before);
        far::add(self, medium, (middle, intensity), far, with, near);
        if let Some(depth_m) = with.ground_depth_m {
            self.add_ground(medium, middle, intensity, depth_m);
        }
    }

    /// Makes room for tilts and gives what is in the block's cells already: cell, zeroth moment, row.
    fn tilted_cells(&mut self, medium: &Medium, block: Block, moments: usize) -> Vec<(usize, f32, Vec<f32>)> {
        let mut there = Vec::new();
        for cell in cells(medium, block) {
            let slot = &mut self.slot[cell];
            if *slot == NO_TILT {
                *slot = (self.tilts.len() / (3 * moments)) as u32;
                self.tilts.resize(self.tilts.len() + 3 * moments, 0.0);
            }
            let row = &self.tilts[*slot as usize * 3 * moments..][..3 * moments];
            there.push((cell, self.moments[cell * moments], row.to_vec()));
        }
        there
    }

    /// Keeps the rise of what was added since within what a straight line may have: no more than twice the mean where
    /// the cell is thick (or its dark side would send negative light), up to six times (all light on one face) where it is thin
    /// and only the way to the other face counts.
    fn bound_tilts(&mut self, medium: &Medium, moments: usize, before: &[(usize, f32, Vec<f32>)]) {
        for (cell, zeroth, row) in before {
            let added = self.moments[cell * moments] - zeroth;
            let now = &mut self.tilts[self.slot[*cell] as usize * 3 * moments..][..3 * moments];
            for k in 0..3 {
                let depth = medium.extinction_per_m[*cell] * medium.spacing_m[k] as f32;
                let most = (2.0 + 4.0 / (1.0 + depth * depth)) / 12.0 * added;
                let rise = (now[k * moments] - row[k * moments]).abs();
                if rise > most {
                    for i in k * moments..(k + 1) * moments {
                        now[i] = row[i] + (now[i] - row[i]) * most / rise;
                    }
                }
            }
        }
    }

    fn add_ground(&mut self, medium: &Medium, source_m: Direction, intensity: f64, depth_m: f64) {
        let height = source_m[2] + depth_m;
        if height <= 0.0 {
            return;
        }
        let nx = medium.cells[0];
        for (column, lit) in self.ground.iter_mut().enumerate() {
            let at = [column % nx, column / nx];
            let x = (at[0] as f64 + 0.5) * medium.spacing_m[0] - source_m[0];
            let y = (at[1] as f64 + 0.5) * medium.spacing_m[1] - source_m[1];
            // A source closer to the ground than a column is wide lights the column, not its middle.
            let close = 0.25 * medium.spacing_m[0] * medium.spacing_m[1] / PI;
            let r2 = x * x + y * y + height * height;
            let r = r2.sqrt();
            let d = [x / r, y / r, -height / r];
            let tau = if clip(medium, source_m, d).is_some() { depth(medium, source_m, d, r) } else { 0.0 };
            *lit += (intensity * (-tau).exp() * (height / r) / (r2 + close)) as f32;
        }
    }
}

dispatch! {
    /// Follows the rays of a source; `collided` becomes the power that collides in far cells, if enough rays tell.
    fn add_near(
        direct: &mut Direct, medium: &Medium, source: (Direction, f64), with: With, near: Block, collided: &mut Option<f64>
    ) => near_body
}

#[inline(always)]
fn near_body(
    direct: &mut Direct,
    medium: &Medium,
    (source_m, intensity): (Direction, f64),
    With { angles, rays, early, .. }: With,
    near: Block,
    collided: &mut Option<f64>,
) {
    let (nk, nm, count) = (angles.moments, angles.set.len(), medium.len());
    let towards = if direct.towards.is_empty() { 0 } else { nm };
    let solid = 4.0 * PI / rays.directions.len() as f64 * intensity;
    let per_volume = solid / medium.cell_volume_m3();
    let radius = early.map_or(0.0, |e| e.radius_m);
    let [nx, ny, _] = medium.cells;
    // A row for each near cell, where the rays' light is summed: moments, those settled, light towards directions.
    let wide = 2 * nk + towards;
    let mut row = vec![NO_TILT; count];
    let listed: Vec<usize> = cells(medium, near).collect();
    for (i, cell) in listed.iter().enumerate() {
        row[*cell] = (i * wide) as u32;
    }
    let mut sums = vec![0.0_f32; listed.len() * wide];
    let (mut power, mut hits) = (0.0, 0);
    for (r, d) in rays.directions.iter().enumerate() {
        let y = &rays.harmonics[r * nk..][..nk];
        let phases = &rays.phase[r * nm..][..towards];
        let (mut passed, mut far) = (1.0_f64, 0.0_f64);
        walk(medium, source_m, *d, |cell, a, b| {
            let sigma = f64::from(medium.extinction_per_m[cell]);
            if row[cell] == NO_TILT {
                far += sigma * (b - a);
                return far < 30.0;
            }
            let sums = &mut sums[row[cell] as usize..][..wide];
            // Within the ball of early collisions, then beyond it.
            let edge = radius.clamp(a, b);
            for (a, b, place) in [(a, edge, nk), (edge, b, 0)] {
                if b <= a {
                    continue;
                }
                let tau = sigma * (b - a);
                let lost = -(-tau).exp_m1();
                // Path length weighted by what is left of the ray.
                let spent = if tau > 1e-6 { lost / sigma } else { b - a };
                let fluence = (per_volume * passed * spent) as f32;
                for (m, y) in sums[place..place + nk].iter_mut().zip(y) {
                    *m += fluence * y;
                }
                for (m, p) in sums[2 * nk..].iter_mut().zip(phases) {
                    *m += fluence * p;
                }
                if place == 0 && direct.slot[cell] != NO_TILT {
                    // Where on its way through the cell the light is, on average.
                    let middle = if tau > 1e-3 { a + 1.0 / sigma - (b - a) / tau.exp_m1() } else { 0.5 * (a + b) };
                    let rows = &mut direct.tilts[direct.slot[cell] as usize * 3 * nk..][..3 * nk];
                    let at = [cell % nx, cell / nx % ny, cell / (nx * ny)];
                    for (k, row) in rows.chunks_exact_mut(nk).enumerate() {
                        let offset = (source_m[k] + d[k] * middle) / medium.spacing_m[k] - at[k] as f64 - 0.5;
                        let weight = fluence * offset as f32;
                        for (t, y) in row.iter_mut().zip(y) {
                            *t += weight * y;
                        }
                    }
                }
                passed *= 1.0 - lost;
            }
            passed > 1e-12
        });
        let lost = passed * -(-far).exp_m1();
        direct.escaped_w += solid * (passed - lost);
        power += solid * lost;
        hits += usize::from(lost > 0.0);
    }
    for (cell, sums) in listed.iter().zip(sums.chunks_exact(wide)) {
        for (m, sum) in direct.moments[cell * nk..][..nk].iter_mut().zip(sums) {
            *m += sum;
        }
        if early.is_some() {
            for (m, sum) in direct.settled[cell * nk..][..nk].iter_mut().zip(&sums[nk..]) {
                *m += sum;
            }
        }
        for (m, sum) in sums[2 * nk..].iter().enumerate() {
            direct.towards[m * count + cell] += sum;
        }
    }
    // Few rays of a far source hit the box: they tell nothing that the cones do not.
    *collided = (hits * 8 >= rays.directions.len().min(1600)).then_some(power);
}

/// The smallest block around two.
fn around(a: Block, b: Block) -> Block {
    std::array::from_fn(|k| [a[k][0].min(b[k][0]), a[k][1].max(b[k][1])])
}

/// The block of cells (from, to on each axis) whose centres lie within so many of the longest edge of the source.
fn near_cells(medium: &Medium, source_m: Direction, edges: f64) -> Block {
    let reach = edges * medium.spacing_m.iter().copied().fold(0.0, f64::max);
    std::array::from_fn(|k| {
        let cell = |x: f64| (x / medium.spacing_m[k]).round().clamp(0.0, medium.cells[k] as f64) as usize;
        [cell(source_m[k] - reach), cell(source_m[k] + reach)]
    })
}

/// The cells of a block.
fn cells(medium: &Medium, [xs, ys, zs]: Block) -> impl Iterator<Item = usize> {
    let [nx, ny, _] = medium.cells;
    (zs[0]..zs[1])
        .flat_map(move |z| (ys[0]..ys[1]).flat_map(move |y| (xs[0]..xs[1]).map(move |x| x + nx * (y + ny * z))))
}

#[cfg(test)]
mod tests;
