//! Twin of `light.wgsl`: the recurrences, slice by slice, rows over all cores.

use super::{ASYMMETRY, DIFFUSE_RANGE, FORWARD_SHARE, Light};
use crate::clouds::density::{HEIGHT, WIDTH};
use rayon::prelude::*;

const AREA: usize = WIDTH * WIDTH;

/// Optical depths towards the light and towards the zenith of one slice.
type Depths = Vec<[f32; 2]>;

/// The light volume of a density volume: `WIDTH * WIDTH * HEIGHT` texels, x fastest, z slowest.
pub fn light(params: &Light, shape: &[u8]) -> Vec<[u8; 4]> {
    let mut above: Vec<Depths> = vec![vec![[0.0; 2]; AREA]; HEIGHT];
    for z in (0..HEIGHT - 1).rev() {
        let (lower, upper) = above.split_at_mut(z + 1);
        step(params, shape, z + 1, z, 1.0, &upper[0], &mut lower[z]);
    }
    let mut texels = vec![[0u8; 4]; AREA * HEIGHT];
    let mut below = vec![[0.0; 2]; AREA];
    let mut next = below.clone();
    for z in 0..HEIGHT {
        if z > 0 {
            step(params, shape, z - 1, z, -1.0, &below, &mut next);
            std::mem::swap(&mut below, &mut next);
        }
        let out = &mut texels[z * AREA..][..AREA];
        let (above, below) = (&above[z], &below);
        out.par_iter_mut().enumerate().for_each(|(i, texel)| {
            let value = shape[i + z * AREA];
            let own = 0.5 * extinction(params, value) * params.voxel_height_m;
            *texel = shade(params, own, above[i], below[i]);
        });
    }
    texels
}

/// Depths of slice `to` from those of its neighbour `from`; `sign` 1: the light comes from `from`, -1: it goes there.
fn step(params: &Light, shape: &[u8], from: usize, to: usize, sign: f32, source: &[[f32; 2]], out: &mut [[f32; 2]]) {
    let [dx, dy, up] = params.direction;
    let slant = params.voxel_height_m / up;
    let shift = [dx, dy].map(|d| sign * d * slant / params.voxel_m);
    let pieces = params.pieces;
    let slices = [&shape[from * AREA..][..AREA], &shape[to * AREA..][..AREA]];
    out.par_chunks_mut(WIDTH).enumerate().for_each(|(y, row)| {
        for (x, depths) in row.iter_mut().enumerate() {
            let (x, y) = (x as f32, y as f32);
            // Along the light: pieces of the slanted path, each with the extinction at its middle.
            let mut along = 0.0;
            for piece in 0..pieces {
                let s = (piece as f32 + 0.5) / pieces as f32;
                let at = |slice: &[u8]| bilinear(x + s * shift[0], y + s * shift[1], |i| f32::from(slice[i]));
                let value = at(slices[1]) + s * (at(slices[0]) - at(slices[1]));
                along += extinction_of(params, value / 255.0);
            }
            along *= slant / pieces as f32;
            let light = bilinear(x + shift[0], y + shift[1], |i| source[i][0]);
            // From the zenith: the mean of a cross one voxel wide, so that skylight comes from a cone.
            let (xi, yi) = (x as i32, y as i32);
            let cross = |dx: i32, dy: i32| index(xi + dx, yi + dy);
            let around = [cross(-1, 0), cross(1, 0), cross(0, -1), cross(0, 1)];
            let here = cross(0, 0);
            let sky = 0.4 * source[here][1] + 0.15 * around.iter().map(|i| source[*i][1]).sum::<f32>();
            let value = 0.5 * (f32::from(slices[0][here]) + f32::from(slices[1][here]));
            *depths = [light + along, sky + extinction_of(params, value / 255.0) * params.voxel_height_m];
        }
    });
}

fn shade(params: &Light, own: f32, above: [f32; 2], below: [f32; 2]) -> [u8; 4] {
    let mu = params.direction[2];
    let forward = (-(1.0 - FORWARD_SHARE) * above[0]).exp();
    // The slab that the slanted path sees, as vertical depths.
    let (over, under) = (above[0] * mu, below[0] * mu + own);
    let diffuse = slab(over, under, mu);
    let (sky, ground) = (between(above[1], below[1] + own), between(below[1] + own, above[1]));
    let store = |share: f32| (share.clamp(0.0, 1.0).sqrt() * 255.0 + 0.5) as u8;
    [store(forward), store(diffuse / DIFFUSE_RANGE), store(sky / DIFFUSE_RANGE), store(ground / DIFFUSE_RANGE)]
}

/// 4 pi times the mean intensity over the illuminance by even, diffuse light, at a depth of `near` from the side that it
/// comes from and `far` from the other (Eddington; conservative). Lit evenly from both sides a slab is as bright as what
/// lights it, however thin or thick.
fn between(near: f32, far: f32) -> f32 {
    let reduced = 1.0 - ASYMMETRY;
    (4.0 / 3.0) / (4.0 / 3.0 + reduced * (near + far)) * (2.0 + 3.0 * reduced * far)
}

/// 4 pi times the mean diffuse intensity over the light's illuminance on a plane facing it, at depths `over` and `under`
/// of a slab lit at cosine `mu` (Eddington; conservative). Goes to 0 with the slab's depth.
fn slab(over: f32, under: f32, mu: f32) -> f32 {
    let total = over + under;
    let reduced = 1.0 - ASYMMETRY;
    let passed = ((2.0 / 3.0 + mu) + (2.0 / 3.0 - mu) * (-total / mu).exp()) / (4.0 / 3.0 + reduced * total);
    let whole = mu * passed * (2.0 + 3.0 * reduced * under);
    (whole - (-over / mu).exp()).max(0.0) * (1.0 - (-2.0 * reduced * total).exp())
}

fn extinction(params: &Light, value: u8) -> f32 {
    extinction_of(params, f32::from(value) / 255.0)
}

fn extinction_of(params: &Light, value: f32) -> f32 {
    params.extinction_per_m * ((value - params.theta) * params.inverse_edge).clamp(0.0, 1.0)
}

fn index(x: i32, y: i32) -> usize {
    let mask = WIDTH as i32 - 1;
    (x & mask) as usize + (y & mask) as usize * WIDTH
}

/// Bilinear value at a texel coordinate (centres at integers), repeating.
fn bilinear(x: f32, y: f32, value: impl Fn(usize) -> f32) -> f32 {
    let (x0, y0) = (x.floor(), y.floor());
    let (fx, fy) = (x - x0, y - y0);
    let (xi, yi) = (x0 as i32, y0 as i32);
    let at = |dx, dy| value(index(xi + dx, yi + dy));
    let low = at(0, 0) + (at(1, 0) - at(0, 0)) * fx;
    let high = at(0, 1) + (at(1, 1) - at(0, 1)) * fx;
    low + (high - low) * fy
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slab_params(extinction_per_m: f32) -> Light {
        Light {
            direction: [0.0, 0.0, 1.0],
            theta: 0.0,
            voxel_m: 62.5,
            voxel_height_m: 1000.0 / 32.0,
            extinction_per_m,
            inverse_edge: 1.0,
            pieces: 1,
            pad0: 0,
            pad1: 0,
            pad2: 0,
        }
    }

    #[test]
    fn a_uniform_slab_transmits_what_monte_carlo_says() {
        // Closed form of Eddington against Monte Carlo (asymmetry 0.85, conservative): the two-stream form is known to
        // overestimate thin slabs by up to 6 %.
        for (depth, transmitted) in [(5.0, 0.77), (10.0, 0.58), (20.0, 0.38), (40.0, 0.23)] {
            let passed = (5.0 / 3.0 - (1.0 / 3.0) * f32::exp(-depth)) / (4.0 / 3.0 + 0.15 * depth);
            assert!((passed / transmitted - 1.0f32).abs() < 0.06, "{depth}: {passed}");
        }
    }

    #[test]
    fn a_cloud_in_an_even_light_is_not_to_be_seen() {
        // White furnace: luminance L all around lights each side with pi L; 4 pi J is 4 pi L everywhere.
        for depth in [0.0, 0.01, 1.0, 20.0, 1e4] {
            for share in [0.0f32, 0.3, 1.0] {
                let (near, far) = (share * depth, (1.0 - share) * depth);
                let all = (between(near, far) + between(far, near)) / 4.0;
                // The two terms cancel to within f32's rounding.
                assert!((all - 1.0f32).abs() < 1e-5, "{depth} {share}: {all}");
            }
        }
    }

    #[test]
    fn recurrence_gives_the_exponential_of_a_uniform_slab() {
        let shape = vec![255u8; AREA * HEIGHT];
        let params = slab_params(0.004);
        let texels = light(&params, &shape);
        for z in [0, 10, 31] {
            // Depth above the voxel's centre: 31 - z voxels of 0.125 each.
            let depth = (31 - z) as f32 * 0.125;
            let expected = (-(1.0 - FORWARD_SHARE) * depth).exp().sqrt() * 255.0;
            // Rounding to 8 bits: half a code.
            assert!((f32::from(texels[z * AREA + 777][0]) - expected).abs() <= 0.51, "{z}");
        }
    }

    #[test]
    fn slanted_light_travels_further() {
        let shape = vec![255u8; AREA * HEIGHT];
        let mut params = slab_params(0.004);
        params.direction = [0.6, 0.0, 0.8];
        let depth = 31.0 * 0.125 / 0.8f32;
        let expected = (-(1.0 - FORWARD_SHARE) * depth).exp().sqrt() * 255.0;
        assert!((f32::from(light(&params, &shape)[999][0]) - expected).abs() <= 0.6);
    }
}
