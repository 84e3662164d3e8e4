//! The light of one theta and one direction: the recurrences, slice by slice, on one thread (many nodes are made at once).
//!
//! Whole rows are moved sideways at a time: along a row the fraction of a voxel between a place and where its light comes from
//! is the same, so the loops have no branches and vectorise.

use super::{ASYMMETRY, HEIGHT, LEAVING, Shares, VOXEL_M, WIDTH};
use crate::clouds::density;

const AREA: usize = WIDTH * WIDTH;
/// Straight pieces of the light's path through one slice at most.
const MOST_PIECES: u32 = 8;
/// How even the sky's light is spread sideways on its way: variance a slice, in heights of a slice squared. From the top of a
/// layer it comes from around as far as half the layer's thickness.
const SKY_SPREAD: f32 = 8.0;

/// What a node is made from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Towards the light in the axes of the volume (x, y, up); up is over 0.
    pub direction: [f32; 3],
    /// Threshold theta.
    pub theta: f32,
    /// Height of a voxel.
    pub voxel_height_m: f32,
    /// Extinction where the cloud is whole, 1/m.
    pub extinction_per_m: f32,
    /// 1 over the shape value from edge to whole.
    pub inverse_edge: f32,
    /// Whether nothing lies beside the tile; else it repeats.
    pub bounded: bool,
}

/// Optical depths of one slice, one for each voxel.
type Plane = Vec<f32>;

/// Light in every voxel, x fastest, z slowest, from shape values at twice the resolution east and north.
pub fn shares(node: &Node, shape: &[u8], mut each: impl FnMut(usize, Shares)) {
    let extinction: Vec<Plane> = (0..HEIGHT).map(|z| extinction(node, shape, z)).collect();
    let way = Way::new(node);
    let mut above = [vec![vec![0.0; AREA]; HEIGHT], vec![vec![0.0; AREA]; HEIGHT]];
    for z in (0..HEIGHT - 1).rev() {
        for (depths, step) in above.iter_mut().zip([Way::light, Way::sky]) {
            let (lower, upper) = depths.split_at_mut(z + 1);
            step(&way, [&extinction[z + 1], &extinction[z]], 1.0, &upper[0], &mut lower[z]);
        }
    }
    let mut below = [vec![0.0; AREA], vec![0.0; AREA]];
    let mut next = vec![0.0; AREA];
    for z in 0..HEIGHT {
        if z > 0 {
            for (depths, step) in below.iter_mut().zip([Way::light, Way::sky]) {
                step(&way, [&extinction[z - 1], &extinction[z]], -1.0, depths, &mut next);
                std::mem::swap(depths, &mut next);
            }
        }
        for i in 0..AREA {
            let own = 0.5 * extinction[z][i] * node.voxel_height_m;
            let along = [above[0][z][i], below[0][i]];
            let upwards = [above[1][z][i], below[1][i] + own];
            each(i + z * AREA, shade(node.direction[2], own, along, upwards));
        }
    }
}

/// Extinction of a slice: the mean over the shape's finer voxels, since the threshold is not linear.
fn extinction(node: &Node, shape: &[u8], z: usize) -> Plane {
    const FINE: usize = density::WIDTH;
    let ratio = FINE / WIDTH;
    let slice = &shape[z * FINE * FINE..][..FINE * FINE];
    let scale = node.extinction_per_m / (ratio * ratio) as f32;
    let whole = |v: u8| ((f32::from(v) * (1.0 / 255.0) - node.theta) * node.inverse_edge).clamp(0.0, 1.0);
    let mut plane = vec![0.0; AREA];
    for (y, row) in slice.chunks_exact(FINE).enumerate() {
        let out = &mut plane[y / ratio * WIDTH..][..WIDTH];
        for (sum, fine) in out.iter_mut().zip(row.chunks_exact(ratio)) {
            *sum += scale * fine.iter().map(|v| whole(*v)).sum::<f32>();
        }
    }
    plane
}

/// The light's way through a slice.
struct Way {
    /// Voxels that it moves sideways in a slice.
    shift: [f32; 2],
    /// Length through a slice.
    slant_m: f32,
    pieces: u32,
    height_m: f32,
    /// Share of the sky's light that comes from each of four neighbours.
    spread: f32,
    bounded: bool,
}

impl Way {
    fn new(node: &Node) -> Self {
        let [dx, dy, up] = node.direction;
        let slant_m = node.voxel_height_m / up;
        let shift = [dx, dy].map(|d| d * slant_m / VOXEL_M);
        let pieces = (shift[0].hypot(shift[1]).ceil() as u32).clamp(1, MOST_PIECES);
        let spread = 0.25 * SKY_SPREAD * (node.voxel_height_m / VOXEL_M).powi(2);
        Self { shift, slant_m, pieces, height_m: node.voxel_height_m, spread: spread.min(0.2), bounded: node.bounded }
    }

    /// Depths along the light: `sign` 1, it comes from the first slice to the second; -1, it goes there.
    fn light(&self, extinction: [&Plane; 2], sign: f32, from: &Plane, to: &mut Plane) {
        let ds = self.slant_m / self.pieces as f32;
        for (y, row) in to.chunks_exact_mut(WIDTH).enumerate() {
            row.fill(0.0);
            let moved = |s: f32| self.shift.map(|v| sign * s * v);
            let add = if self.bounded { add_bounded } else { add };
            add(from, y, moved(1.0), 1.0, row);
            for piece in 0..self.pieces {
                let s = (piece as f32 + 0.5) / self.pieces as f32;
                add(extinction[0], y, moved(s), ds * s, row);
                add(extinction[1], y, moved(s), ds * (1.0 - s), row);
            }
        }
    }

    /// Depths from the zenith, or from below, as a mean over places around.
    fn sky(&self, extinction: [&Plane; 2], _: f32, from: &Plane, to: &mut Plane) {
        for y in 0..WIDTH {
            let line = |dy: usize| &from[(y + dy) % WIDTH * WIDTH..][..WIDTH];
            let (south, own, north) = (line(WIDTH - 1), line(0), line(1));
            let here = y * WIDTH;
            for x in 0..WIDTH {
                let around = south[x] + north[x] + own[(x + 1) % WIDTH] + own[(x + WIDTH - 1) % WIDTH];
                let passed = 0.5 * self.height_m * (extinction[0][here + x] + extinction[1][here + x]);
                to[here + x] = own[x] + self.spread * (around - 4.0 * own[x]) + passed;
            }
        }
    }
}

/// Adds to a row `y` a weight times the values of a plane as many voxels away: bilinear, repeating.
fn add(plane: &Plane, y: usize, [away_x, away_y]: [f32; 2], weight: f32, row: &mut [f32]) {
    let (x0, y0) = (away_x.floor(), (y as f32 + away_y).floor());
    let (fx, fy) = (away_x - x0, y as f32 + away_y - y0);
    let wrapped = |v: f32| (v as i32).rem_euclid(WIDTH as i32) as usize;
    let line = |v: f32| &plane[wrapped(v) * WIDTH..][..WIDTH];
    let (low, high) = (line(y0), line(y0 + 1.0));
    let (low_weight, high_weight) = (weight * (1.0 - fy), weight * fy);
    // The row as it lies one and the same number of voxels away, with its neighbour beyond the end.
    let mut moved = [0.0f32; WIDTH + 1];
    let first = wrapped(x0);
    let mut blend = |to: std::ops::Range<usize>, from: usize| {
        let count = to.len();
        let ends = low[from..][..count].iter().zip(&high[from..][..count]);
        for (value, (a, b)) in moved[to].iter_mut().zip(ends) {
            *value = low_weight * a + high_weight * b;
        }
    };
    blend(0..WIDTH - first, first);
    blend(WIDTH - first..WIDTH, 0);
    moved[WIDTH] = moved[0];
    for (x, value) in row.iter_mut().enumerate() {
        *value += moved[x] + (moved[x + 1] - moved[x]) * fx;
    }
}

/// As [`add`] for a plane beside which there is nothing.
fn add_bounded(plane: &Plane, y: usize, [away_x, away_y]: [f32; 2], weight: f32, row: &mut [f32]) {
    let (x0, y0) = (away_x.floor(), (y as f32 + away_y).floor());
    let (fx, fy) = (away_x - x0, y as f32 + away_y - y0);
    for (line, line_weight) in [(y0 as i32, weight * (1.0 - fy)), (y0 as i32 + 1, weight * fy)] {
        let Some(line) = usize::try_from(line).ok().filter(|line| *line < WIDTH) else { continue };
        let values = &plane[line * WIDTH..][..WIDTH];
        for (first, weight) in [(x0 as i32, line_weight * (1.0 - fx)), (x0 as i32 + 1, line_weight * fx)] {
            // Both rows where they overlap.
            let begin = (-first).clamp(0, WIDTH as i32) as usize;
            let end = (WIDTH as i32 - first).clamp(begin as i32, WIDTH as i32) as usize;
            let from = (begin as i32 + first).clamp(0, WIDTH as i32) as usize;
            for (sum, value) in row[begin..end].iter_mut().zip(&values[from..]) {
                *sum += weight * value;
            }
        }
    }
}

/// Light at a voxel whose own half has the depth `own`: `along` depths towards the light and away from it, `upwards` depths
/// towards the zenith and away from it. `mu`: cosine of the light against the zenith.
fn shade(mu: f32, own: f32, along: [f32; 2], upwards: [f32; 2]) -> Shares {
    // A level slab is as deep along the light, times mu, as upwards; a flank in the light is less so.
    let facing = 1.0 - ((along[0] * mu + own + 0.25) / (upwards[0] + own + 0.25)).min(1.0);
    let cosine = mu + (1.0 - mu) * facing;
    let reduced = 1.0 - ASYMMETRY;
    let (over, under) = (along[0] * cosine, along[1] * cosine + own);
    let left = decay(reduced * along[0]);
    let passed = through(reduced * (over + under), cosine, left * decay(reduced * (along[1] + own / cosine)));
    let flux = cosine * passed;
    let diffuse = 2.0 * (cosine - flux) - 3.0 * flux * reduced * over + 3.0 * cosine * cosine * (1.0 - left);
    let total = reduced * (upwards[0] + upwards[1]);
    Shares {
        beam: decay(LEAVING * along[0]),
        diffuse: diffuse.max(0.0),
        through: passed,
        sky: (4.0 / 3.0) / (4.0 / 3.0 + total) * (2.0 + 3.0 * reduced * upwards[1]),
        facing,
    }
}

/// Share of a beam at a cosine that a slab of this reduced depth lets through (Eddington; conservative); `left` is what is
/// left of the beam at its end.
fn through(depth: f32, cosine: f32, left: f32) -> f32 {
    ((2.0 / 3.0 + cosine) + (2.0 / 3.0 - cosine) * left) / (4.0 / 3.0 + depth)
}

/// exp(-x) for x of 0 and more, within 2e-7 of 1: a power of two by the exponent's bits, the rest by a polynomial (its Taylor
/// series about the middle). Made of the basic operations, so that it vectorises and is the same everywhere.
fn decay(x: f32) -> f32 {
    let power = (-std::f32::consts::LOG2_E * x).max(-120.0);
    let whole = (power - 0.5) as i32;
    let rest = (power - whole as f32) * std::f32::consts::LN_2;
    let mut sum = 1.0f32;
    for k in [6.0f32, 5.0, 4.0, 3.0, 2.0, 1.0] {
        sum = 1.0 + rest / k * sum;
    }
    sum * f32::from_bits(((whole + 127) as u32) << 23)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decay_is_the_exponential() {
        for k in 0..2_000 {
            let x = k as f32 * 0.03;
            let exact = (-f64::from(x)).exp();
            // One rounding in x's product with log2(e) at 60 is 4e-6 of the value.
            assert!((f64::from(decay(x)) / exact - 1.0).abs() < 1e-5, "{x}");
        }
        assert_eq!(decay(0.0), 1.0);
        assert!(decay(1e9) < 1e-30);
    }

    #[test]
    fn a_cloud_in_an_even_light_is_not_to_be_seen() {
        // White furnace: the sky's share and the ground's, which is 4 less it, are those of one slab from both sides.
        for depth in [0.0, 0.01, 1.0, 20.0, 1e4] {
            for share in [0.0f32, 0.3, 1.0] {
                let (near, far) = (share * depth, (1.0 - share) * depth);
                let sky = |near: f32, far: f32| shade(1.0, 0.0, [near, far], [near, far]).sky;
                // f32's rounding of terms that cancel.
                assert!((sky(near, far) + sky(far, near) - 4.0).abs() < 2e-5, "{depth} {share}");
            }
        }
    }

    #[test]
    fn rows_are_moved_as_a_bilinear_sampler_moves_them() {
        let plane: Plane = (0..AREA).map(|i| ((i * 7_919) % 1_000) as f32).collect();
        let at = |x: i32, y: i32| plane[x.rem_euclid(128) as usize + y.rem_euclid(128) as usize * WIDTH];
        for (away, y) in [([0.0, 0.0], 5), ([3.25, -1.5], 0), ([-130.75, 300.5], 127)] {
            let mut row = [0.0; WIDTH];
            add(&plane, y, away, 2.0, &mut row);
            for x in [0usize, 1, 64, 127] {
                let (px, py) = (x as f32 + away[0], y as f32 + away[1]);
                let (x0, y0) = (px.floor() as i32, py.floor() as i32);
                let (fx, fy) = (px - px.floor(), py - py.floor());
                let low = at(x0, y0) * (1.0 - fx) + at(x0 + 1, y0) * fx;
                let high = at(x0, y0 + 1) * (1.0 - fx) + at(x0 + 1, y0 + 1) * fx;
                let expected = 2.0 * (low * (1.0 - fy) + high * fy);
                assert!((row[x] - expected).abs() < 1e-2, "{away:?} {y} {x}: {} {expected}", row[x]);
            }
        }
    }

    #[test]
    fn a_uniform_slab_decays_along_the_lights_way() {
        let shape = vec![255u8; density::WIDTH * density::WIDTH * HEIGHT];
        for direction in [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [-0.3, 0.9, 0.316_227_8]] {
            let node = Node {
                direction,
                theta: 0.0,
                voxel_height_m: 1_000.0 / 32.0,
                extinction_per_m: 0.004,
                inverse_edge: 1.0,
                bounded: false,
            };
            shares(&node, &shape, |i, found| {
                let above = (HEIGHT - 1 - i / AREA) as f32 * 0.125 / direction[2];
                // Sums of up to 31 slices in f32.
                assert!((found.beam - (-LEAVING * above).exp()).abs() < 1e-4, "{direction:?} {i}: {found:?}");
                assert!(found.facing < 1e-3, "a slab is level: {found:?}");
            });
        }
    }
}
