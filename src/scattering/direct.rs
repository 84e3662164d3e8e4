//! Light that comes straight from a source: the first collisions of every cell, with a mean over cells near the source.
//!
//! Near the source (where 1/r^2 and the cell's own extinction vary within a cell) evenly spread rays are followed and
//! what each spends in a cell is counted, so that energy is kept to rounding; farther away one ray per cell stands for the cone that
//! the cell fills. Everything is fluence, not collisions, so that empty cells need no division.

use super::angles::Angles;
use super::medium::Medium;
use super::phase::Phase;
use super::rays::{clip, depth, walk};
use crate::numeric::sphere::{Direction, dot, fibonacci, harmonics, harmonics_into};
use std::f64::consts::PI;

/// Directions of the near rays with what is known of each beforehand.
pub struct Rays {
    directions: Vec<Direction>,
    /// Harmonics of each ray.
    harmonics: Vec<f32>,
    /// Phase function from each ray to every direction of the set.
    phase: Vec<f32>,
}

/// Direct light of one source of 1 W/sr (or a sum of several).
#[derive(Clone, Debug, PartialEq)]
pub struct Direct {
    /// Moments of the direct radiance in each cell (mean over the cell), W/m^2: cells times moments.
    pub moments: Vec<f32>,
    /// Its scattering into each direction of the set by the phase function as it is, W/(m^2 sr): directions times cells.
    pub towards: Vec<f32>,
    /// What falls on the ground, W/m^2 a column (empty without ground).
    pub ground: Vec<f32>,
    /// Power that leaves the box unscattered, W, of 4 pi.
    pub escaped_w: f64,
    /// For each cell the place of its row in `tilts`, or [`NO_TILT`].
    pub slot: Vec<u32>,
    /// For cells around sources: means of moment times offset from the cell's centre (in edges), three axes times
    /// moments a row. In a source's own cell scattered light goes outwards from the source; without this the cell
    /// would forget where in it the light is and hold too much of it.
    pub tilts: Vec<f32>,
}

/// A cell whose direct light is even enough.
pub const NO_TILT: u32 = u32::MAX;

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
            slot: vec![NO_TILT; cells],
            tilts: Vec::new(),
        }
    }

    /// Adds sources that lie close to each other (or one) in a medium whose extinction is that of the transport (scaled).
    /// Near cells see each of them, far cells see all in their middle. `ground_depth_m` is the ground's depth below the box.
    pub fn add(
        &mut self,
        medium: &Medium,
        sources: &[(Direction, f64)],
        (angles, rays, phase): (&Angles, &Rays, Phase),
        ground_depth_m: Option<f64>,
    ) {
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
        // What these sources add is bounded by themselves, so that sources still add up.
        let before = self.tilted_cells(medium, tilted, angles.moments);
        let mut far = Some(0.0);
        for (position, intensity) in sources {
            let collided = self.add_near(medium, *position, *intensity, angles, rays, near);
            far = far.zip(collided).map(|(a, b)| a + b);
        }
        self.bound_tilts(medium, angles.moments, &before);
        self.add_far(medium, (middle, intensity), far, angles, phase, near);
        if let Some(depth_m) = ground_depth_m {
            self.add_ground(medium, middle, intensity, depth_m);
        }
    }

    /// Makes room for tilts and gives what is in the block's cells already: cell, zeroth moment, row.
    fn tilted_cells(&mut self, medium: &Medium, block: [[usize; 2]; 3], moments: usize) -> Vec<(usize, f32, Vec<f32>)> {
        let mut there = Vec::new();
        let [xs, ys, zs] = block;
        for z in zs[0]..zs[1] {
            for y in ys[0]..ys[1] {
                for x in xs[0]..xs[1] {
                    let cell = medium.index([x, y, z]);
                    let slot = &mut self.slot[cell];
                    if *slot == NO_TILT {
                        *slot = (self.tilts.len() / (3 * moments)) as u32;
                        self.tilts.resize(self.tilts.len() + 3 * moments, 0.0);
                    }
                    let row = &self.tilts[*slot as usize * 3 * moments..][..3 * moments];
                    there.push((cell, self.moments[cell * moments], row.to_vec()));
                }
            }
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

    /// Follows the rays; gives the power that collides in far cells, if enough rays tell.
    fn add_near(
        &mut self,
        medium: &Medium,
        source_m: Direction,
        intensity: f64,
        angles: &Angles,
        rays: &Rays,
        near: [[usize; 2]; 3],
    ) -> Option<f64> {
        let (mut collided, mut hits) = (0.0, 0);
        let (nk, nm, cells) = (angles.moments, angles.set.len(), medium.len());
        let solid = 4.0 * PI / rays.directions.len() as f64 * intensity;
        let per_volume = solid / medium.cell_volume_m3();
        let [nx, ny, _] = medium.cells;
        for (r, d) in rays.directions.iter().enumerate() {
            let mut passed = 1.0;
            let mut outside = 0.0;
            walk(medium, source_m, *d, |cell, a, b| {
                let sigma = f64::from(medium.extinction_per_m[cell]);
                let tau = sigma * (b - a);
                let at = [cell % nx, cell / nx % ny, cell / (nx * ny)];
                if (0..3).all(|k| at[k] >= near[k][0] && at[k] < near[k][1]) {
                    // Path length weighted by what is left of the ray.
                    let spent = if tau > 1e-6 { -(-tau).exp_m1() / sigma } else { b - a };
                    let fluence = (per_volume * passed * spent) as f32;
                    let y = &rays.harmonics[r * nk..][..nk];
                    for (m, y) in self.moments[cell * nk..][..nk].iter_mut().zip(y) {
                        *m += fluence * y;
                    }
                    for (m, p) in rays.phase[r * nm..][..nm].iter().enumerate() {
                        self.towards[m * cells + cell] += fluence * p;
                    }
                    if self.slot[cell] != NO_TILT {
                        // Where on its way through the cell the light is, on average.
                        let middle = if tau > 1e-3 { a + 1.0 / sigma - (b - a) / tau.exp_m1() } else { 0.5 * (a + b) };
                        let rows = &mut self.tilts[self.slot[cell] as usize * 3 * nk..][..3 * nk];
                        for (k, row) in rows.chunks_mut(nk).enumerate() {
                            let offset = (source_m[k] + d[k] * middle) / medium.spacing_m[k] - at[k] as f64 - 0.5;
                            let weight = fluence * offset as f32;
                            for (t, y) in row.iter_mut().zip(y) {
                                *t += weight * y;
                            }
                        }
                    }
                } else {
                    outside += passed * -(-tau).exp_m1();
                }
                passed *= (-tau).exp();
                passed > 1e-12
            });
            self.escaped_w += solid * passed;
            collided += solid * outside;
            hits += usize::from(outside > 0.0);
        }
        // Few rays of a far source hit the box: they tell nothing that the cones do not.
        (hits * 8 >= rays.directions.len().min(1600)).then_some(collided)
    }

    /// One cone per far cell, all together scaled to the power that the rays lose there.
    fn add_far(
        &mut self,
        medium: &Medium,
        (source_m, intensity): (Direction, f64),
        collided: Option<f64>,
        angles: &Angles,
        phase: Phase,
        near: [[usize; 2]; 3],
    ) {
        let (nk, nm, cells) = (angles.moments, angles.set.len(), medium.len());
        let order = angles.orders.last().copied().unwrap_or(0);
        let [nx, ny, _] = medium.cells;
        let mut y = vec![0.0; nk];
        let mut cosines = vec![0.0_f32; nm];
        let mut towards = vec![0.0_f32; nm];
        let mut far = Vec::with_capacity(cells);
        let mut sum = 0.0;
        // The width of the phase function's peak, rad, is about one over this.
        let sharpness = 1.0 / (1.0 - phase.asymmetry().abs()).max(0.01);
        for cell in 0..cells {
            let at = [cell % nx, cell / nx % ny, cell / (nx * ny)];
            if (0..3).all(|k| at[k] >= near[k][0] && at[k] < near[k][1]) {
                continue;
            }
            let (d, fluence) = far_fluence(medium, source_m, cell, intensity);
            if fluence > 1e-30 {
                sum += fluence * f64::from(medium.extinction_per_m[cell]) * medium.cell_volume_m3();
                far.push((cell, d, fluence));
            }
        }
        let scale = collided.map_or(1.0, |c| if sum > 1e-9 * intensity { (c / sum).clamp(0.5, 2.0) } else { 1.0 });
        for (cell, d, fluence) in far {
            let fluence = fluence * scale;
            harmonics_into(d, order, &mut y);
            for (m, y) in self.moments[cell * nk..][..nk].iter_mut().zip(&y) {
                *m += (fluence * y) as f32;
            }
            towards.fill(0.0);
            for (d, share) in within(medium, source_m, cell, sharpness) {
                for (x, s) in cosines.iter_mut().zip(&angles.set.directions) {
                    *x = dot(d, *s) as f32;
                }
                phase.add_values(&cosines, (fluence * share) as f32, &mut towards);
            }
            for (m, value) in towards.iter().enumerate() {
                self.towards[m * cells + cell] += value;
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

/// The smallest block around two.
fn around(a: [[usize; 2]; 3], b: [[usize; 2]; 3]) -> [[usize; 2]; 3] {
    std::array::from_fn(|k| [a[k][0].min(b[k][0]), a[k][1].max(b[k][1])])
}

/// Directions from a source to the parts of a cell and their shares of its light: as many as the phase function turns over the angle
/// under which the cell is seen. One alone would see a sharp peak whole or not at all.
fn within(medium: &Medium, source_m: Direction, cell: usize, sharpness: f64) -> Vec<(Direction, f64)> {
    let centre = medium.centre_m(cell);
    let from: Direction = std::array::from_fn(|k| centre[k] - source_m[k]);
    let distance = dot(from, from).sqrt();
    let parts: [usize; 3] = medium.spacing_m.map(|h| (1.5 * sharpness * h / distance).ceil().clamp(1.0, 3.0) as usize);
    let sigma = f64::from(medium.extinction_per_m[cell]);
    let part = |i: usize| -> (Direction, f64) {
        let at = [i % parts[0], i / parts[0] % parts[1], i / (parts[0] * parts[1])];
        let v: Direction =
            std::array::from_fn(|k| from[k] + ((at[k] as f64 + 0.5) / parts[k] as f64 - 0.5) * medium.spacing_m[k]);
        let r = dot(v, v).sqrt();
        (v.map(|c| c / r), r)
    };
    let mut all: Vec<(Direction, f64)> = (0..parts.iter().product()).map(part).collect();
    // The near side of a thick cell has more.
    let nearest = all.iter().map(|(_, r)| *r).fold(f64::INFINITY, f64::min);
    all.iter_mut().for_each(|(_, r)| *r = (sigma * (nearest - *r)).exp() / (*r * *r));
    let sum: f64 = all.iter().map(|(_, light)| light).sum();
    all.iter_mut().for_each(|(_, light)| *light /= sum);
    all
}

/// Direction from the source to a far cell and the mean fluence in it. A cell that swallows much of the light on its way
/// through is taken in eighths.
fn far_fluence(medium: &Medium, source_m: Direction, cell: usize, intensity: f64) -> (Direction, f64) {
    let centre = medium.centre_m(cell);
    let whole = medium.spacing_m.map(|h| 0.5 * h);
    let (d, fluence, own) = box_fluence(medium, source_m, cell, centre, whole);
    if own < 0.5 || fluence < 1e-12 {
        return (d, intensity * fluence);
    }
    let eighth = whole.map(|h| 0.5 * h);
    let sum: f64 = (0..8)
        .map(|corner| {
            let at = std::array::from_fn(|k| centre[k] + if corner >> k & 1 == 1 { eighth[k] } else { -eighth[k] });
            box_fluence(medium, source_m, cell, at, eighth).1
        })
        .sum();
    (d, intensity * sum / 8.0)
}

/// Direction to the centre of a box within a cell, fluence of 1 W/sr in the cone that it fills, and its depth along the ray.
fn box_fluence(
    medium: &Medium,
    source_m: Direction,
    cell: usize,
    centre: Direction,
    half: Direction,
) -> (Direction, f64, f64) {
    let v: Direction = std::array::from_fn(|k| centre[k] - source_m[k]);
    let distance = dot(v, v).sqrt();
    let d = v.map(|c| c / distance);
    // Half the chord through the centre, on either side.
    let arm = (0..3).map(|k| half[k] / d[k].abs().max(1e-300)).fold(distance, f64::min);
    let [a, b] = [distance - arm, distance + arm];
    let tau = depth(medium, source_m, d, a);
    let sigma = f64::from(medium.extinction_per_m[cell]);
    let own = sigma * (b - a);
    let spent = if own > 1e-6 { -(-own).exp_m1() / sigma } else { b - a };
    // The cone's path over its volume, per solid angle.
    let fluence = (-tau).exp() * spent / ((b * b * b - a * a * a) / 3.0);
    (d, fluence, own)
}

/// The block of cells (from, to on each axis) whose centres lie within so many of the longest edge of the source.
fn near_cells(medium: &Medium, source_m: Direction, edges: f64) -> [[usize; 2]; 3] {
    let reach = edges * medium.spacing_m.iter().copied().fold(0.0, f64::max);
    std::array::from_fn(|k| {
        let cell = |x: f64| (x / medium.spacing_m[k]).round().clamp(0.0, medium.cells[k] as f64) as usize;
        [cell(source_m[k] - reach), cell(source_m[k] + reach)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::sphere::Rule;

    fn light(medium: &Medium, source: Direction) -> Direct {
        let angles = Angles::new(Rule::Lebedev26);
        let phase = Phase::HenyeyGreenstein(0.5);
        let rays = Rays::new(2048, &angles, phase);
        let mut direct = Direct::dark(medium.len(), &angles, medium.cells[0] * medium.cells[1]);
        direct.add(medium, &[(source, 1.0)], (&angles, &rays, phase), Some(0.5));
        direct
    }

    /// Power that collides in the box, from the zeroth moments.
    fn collided(medium: &Medium, direct: &Direct) -> f64 {
        (0..medium.len())
            .map(|c| f64::from(direct.moments[c * 16]) * (4.0 * PI).sqrt() * f64::from(medium.extinction_per_m[c]))
            .sum::<f64>()
            * medium.cell_volume_m3()
    }

    #[test]
    fn what_collides_and_what_leaves_is_what_was_sent() {
        for sigma in [0.0, 0.1, 1.0, 8.0, 1e4] {
            let medium = Medium::new([12, 12, 6], [1.0; 3], vec![sigma; 864], false).expect("legal");
            for source in [[6.5, 6.5, 3.5], [6.0, 6.0, 3.0], [5.7, 6.2, 3.4], [0.3, 0.2, 5.9], [6.1, 5.8, -3.0]] {
                let direct = light(&medium, source);
                let sum = (collided(&medium, &direct) + direct.escaped_w) / (4.0 * PI);
                // Counted along the rays; the moments are f32. Where nearly all is far, the scale has its limits.
                let bound = if source[2] < 0.0 { 0.02 } else { 1e-3 };
                assert!((sum - 1.0).abs() < bound, "{sigma} {source:?}: {sum}");
                assert!(direct.moments.iter().chain(&direct.towards).all(|v| v.is_finite()));
            }
        }
    }

    #[test]
    fn a_cell_that_a_sharp_peak_meets_scatters_the_mean_of_it() {
        // Clear cells behind each other on an axis, which is a direction of the set: the peak points at it.
        let medium = Medium::new([15, 5, 5], [1.0; 3], vec![0.0; 375], false).expect("legal");
        let (source, forward) = ([2.5, 2.5, 2.5], [1.0, 0.0, 0.0]);
        let angles = Angles::new(Rule::Lebedev26);
        let ahead = angles.set.nearest(forward);
        for asymmetry in [0.85, 0.95] {
            let phase = Phase::HenyeyGreenstein(asymmetry);
            let mut direct = Direct::dark(medium.len(), &angles, 0);
            direct.add(&medium, &[(source, 1.0)], (&angles, &Rays::new(2048, &angles, phase), phase), None);
            for distance in [4.0, 7.0, 11.0] {
                let cell = medium.index([2 + distance as usize, 2, 2]);
                // The mean of phase function over distance squared, by 20 x 20 x 20 parts.
                let part = |i: usize| (i as f64 + 0.5) / 20.0 - 0.5;
                let mean = (0..8000)
                    .map(|i| {
                        let v = [distance + part(i % 20), part(i / 20 % 20), part(i / 400)];
                        let r2 = dot(v, v);
                        phase.value(v[0] / r2.sqrt()) / r2
                    })
                    .sum::<f64>()
                    / 8000.0;
                let found = f64::from(direct.towards[ahead * medium.len() + cell]);
                // Three parts an edge at most, one of them in the middle of the peak.
                let bound = if asymmetry > 0.9 { 0.2 } else { 0.1 };
                assert!((found / mean - 1.0).abs() < bound, "{asymmetry} {distance}: {found} {mean}");
                let alone = phase.value(1.0) / (distance * distance);
                assert!(alone > 1.2 * mean || distance > 5.0 && asymmetry < 0.9 || distance > 8.0, "{alone} {mean}");
            }
        }
    }

    #[test]
    fn the_cell_around_a_source_has_the_mean_of_the_inverse_square() {
        // Mean of 1/r^2 over a unit cube around its centre: the integral over a face of 3 / (x^2 + y^2 + 1/4), 7.674214.
        let medium = Medium::new([9, 9, 9], [1.0; 3], vec![0.0; 729], false).expect("legal");
        let direct = light(&medium, [4.5; 3]);
        let mean = f64::from(direct.moments[medium.index([4; 3]) * 16]) * (4.0 * PI).sqrt();
        assert!((mean / 7.674_214 - 1.0).abs() < 1e-3, "{mean}");
        // A far cell has the square of its distance, but for the spread of a cell at four cells' distance.
        let far = f64::from(direct.moments[medium.index([8, 4, 4]) * 16]) * (4.0 * PI).sqrt();
        assert!((far * 16.0 - 1.0).abs() < 0.02, "{far}");
    }

    #[test]
    fn the_ground_gets_the_cosine_over_the_square() {
        let medium = Medium::new([3, 3, 2], [1.0; 3], vec![0.2; 18], false).expect("legal");
        let direct = light(&medium, [1.5, 1.5, 10.0]);
        let tau = 0.2 * 2.0;
        let exact = f64::exp(-tau) / (10.5 * 10.5 + 0.08);
        assert!((f64::from(direct.ground[4]) / exact - 1.0).abs() < 1e-5);
    }
}
