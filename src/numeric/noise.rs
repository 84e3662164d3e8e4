//! Noise: gradient and cellular (Worley) noise on lattices that wrap, so that a tile repeats without seam; gradient noise in
//! endless space for what lies on the globe.

use super::hash::{pcg3d, unit};
use glam::{DVec3, Vec3};

/// Gradient noise (Perlin 2002, quintic fade) of period `period` lattice cells per axis, about -1 to 1.
pub fn gradient(p: Vec3, period: [u32; 3], seed: u32) -> f32 {
    let cell = p.floor();
    let f = p - cell;
    // Each axis is wrapped once for its two lattice planes.
    let lattice: [[u32; 2]; 3] =
        std::array::from_fn(|axis| [0, 1].map(|step| wrap(cell[axis] as i32 + step, period[axis])));
    let salt = seed.wrapping_mul(0x9e37_79b9);
    let corner = |dx: usize, dy: usize, dz: usize| {
        let h = pcg3d(lattice[0][dx], lattice[1][dy].wrapping_add(salt), lattice[2][dz]);
        let g = Vec3::new(unit(h[0]), unit(h[1]), unit(h[2])) * 2.0 - Vec3::ONE;
        g.dot(f - Vec3::new(dx as f32, dy as f32, dz as f32))
    };
    let s = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let lerp = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let face =
        |dz| lerp(lerp(corner(0, 0, dz), corner(1, 0, dz), s.x), lerp(corner(0, 1, dz), corner(1, 1, dz), s.x), s.y);
    lerp(face(0), face(1), s.z)
}

/// Gradient noise (Perlin 2002, quintic fade) in space without a period, about -1 to 1; 1.5 times as strong as [`gradient`].
/// Coordinates in lattice cells, up to 2^31 either way.
pub fn spatial(p: DVec3, seed: u32) -> f64 {
    /// Odd factors that spread lattice numbers over the bits of a word.
    const SPREAD: [u32; 3] = [0x9e37_79b1, 0x85eb_ca77, 0xc2b2_ae3d];
    // The largest whole number not above; `floor` is a call on machines without SSE 4.1.
    let low = [p.x, p.y, p.z].map(|v| v as i32 - i32::from(v < f64::from(v as i32)));
    let f = [0, 1, 2].map(|axis| (p[axis] - f64::from(low[axis])) as f32);
    let first: [u32; 3] = std::array::from_fn(|axis| (low[axis] as u32).wrapping_mul(SPREAD[axis]));
    let salt = seed.wrapping_mul(0x27d4_eb2f);
    // Corners as arrays of eight, so that they go side by side through vector registers.
    let mut bits: [u32; 8] = std::array::from_fn(|corner| {
        let axis = |axis: usize| first[axis].wrapping_add(SPREAD[axis] * (corner as u32 >> axis & 1));
        axis(0) ^ axis(1) ^ axis(2) ^ salt
    });
    // A mixer of two multiplications (Wellons 2018, "lowbias32").
    for bits in &mut bits {
        let mut h = *bits;
        h = (h ^ h >> 16).wrapping_mul(0x7feb_352d);
        h = (h ^ h >> 15).wrapping_mul(0x846c_a68b);
        *bits = h ^ h >> 16;
    }
    let mut values = [0.0f32; 8];
    for (corner, (value, bits)) in values.iter_mut().zip(bits).enumerate() {
        let along = |axis: usize| {
            let gradient = (bits >> (11 * axis) & 1023) as i32 as f32 * (2.0 / 1023.0) - 1.0;
            gradient * (f[axis] - (corner >> axis & 1) as f32)
        };
        *value = along(0) + along(1) + along(2);
    }
    let s = f.map(|f| f * f * f * (f * (f * 6.0 - 15.0) + 10.0));
    let lerp = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let row = |at: usize| lerp(values[at], values[at + 1], s[0]);
    let face = |at: usize| lerp(row(at), row(at + 2), s[1]);
    f64::from(lerp(face(0), face(4), s[2])) * 1.5
}

/// Sum of `octaves` of [`gradient`], each of twice the frequency and half the amplitude; about -1 to 1.
pub fn fractal(p: Vec3, period: [u32; 3], octaves: u32, seed: u32) -> f32 {
    let (mut sum, mut amplitude, mut total) = (0.0, 1.0, 0.0);
    for octave in 0..octaves {
        let scale = 1u32 << octave;
        sum += amplitude * gradient(p * scale as f32, period.map(|n| n * scale), seed.wrapping_add(octave));
        total += amplitude;
        amplitude *= 0.5;
    }
    sum / total
}

/// Cellular noise: distance to the nearest of the scattered feature points, one a lattice cell, in cells (0 to about 1.2).
pub struct Cellular {
    period: [u32; 3],
    points: Vec<Vec3>,
}

impl Cellular {
    /// Scatters the points of a lattice of `period` cells.
    pub fn new(period: [u32; 3], seed: u32) -> Self {
        let [nx, ny, nz] = period;
        let points = (0..nx * ny * nz)
            .map(|i| {
                let h = pcg3d(i % nx, (i / nx) % ny, (i / (nx * ny)).wrapping_add(seed.wrapping_mul(0x85eb_ca6b)));
                Vec3::new(unit(h[0]), unit(h[1]), unit(h[2]))
            })
            .collect();
        Self { period, points }
    }

    /// Distance from `p` (in cells) to the nearest feature point.
    pub fn nearest(&self, p: Vec3) -> f32 {
        let cell = p.floor();
        let f = p - cell;
        let [nx, ny, _] = self.period;
        let lattice: [[u32; 3]; 3] =
            std::array::from_fn(|axis| [-1, 0, 1].map(|step| wrap(cell[axis] as i32 + step, self.period[axis])));
        let mut best = f32::MAX;
        for (dz, z) in lattice[2].iter().enumerate() {
            for (dy, y) in lattice[1].iter().enumerate() {
                for (dx, x) in lattice[0].iter().enumerate() {
                    let offset = Vec3::new(dx as f32, dy as f32, dz as f32) - Vec3::ONE;
                    let point = self.points[(x + nx * (y + ny * z)) as usize];
                    best = best.min((offset + point - f).length_squared());
                }
            }
        }
        best.sqrt()
    }
}

fn wrap(cell: i32, period: u32) -> u32 {
    cell.rem_euclid(period as i32) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_repeats_with_its_period() {
        let cells = Cellular::new([4, 5, 3], 1);
        for k in 0..50 {
            let p = Vec3::new(0.37 * k as f32, 0.11 * k as f32, 0.23 * k as f32);
            let q = p + Vec3::new(4.0, 5.0, 3.0);
            // The sum p + period rounds at 2^-21 for these sizes and the slope of the noise is below 4.
            assert!((gradient(p, [4, 5, 3], 9) - gradient(q, [4, 5, 3], 9)).abs() < 1e-4);
            assert!((cells.nearest(p) - cells.nearest(q)).abs() < 1e-4);
        }
    }

    #[test]
    fn gradient_noise_is_zero_on_the_lattice_and_differs_by_seed() {
        assert_eq!(gradient(Vec3::new(2.0, 1.0, 3.0), [8; 3], 4), 0.0);
        let p = Vec3::new(2.5, 1.5, 3.5);
        assert_ne!(gradient(p, [8; 3], 4), gradient(p, [8; 3], 5));
    }

    #[test]
    fn noise_in_space_is_smooth_zero_on_the_lattice_and_has_the_strength_it_says() {
        assert_eq!(spatial(DVec3::new(-2.0, 1.0, 70_000.0), 4), 0.0);
        let at = |k: i32| DVec3::new(0.371 * f64::from(k), 0.113 * f64::from(k) - 40.0, 0.237 * f64::from(k));
        let (mut sum, mut squares, mut periodic) = (0.0, 0.0, 0.0);
        for k in 0..20_000 {
            let (here, p) = (spatial(at(k), 5), at(k));
            // The slope is below 6: eight gradients of length sqrt(3) and the fade's 1.9 between them, times 1.5.
            assert!((spatial(p + DVec3::splat(1e-4), 5) - here).abs() < 6.0 * 1.8e-4, "{p}");
            sum += here;
            squares += here * here;
            periodic += here * f64::from(gradient(Vec3::new(p.x as f32, p.y as f32, p.z as f32), [1 << 20; 3], 5));
        }
        // Mean 0 within five standard errors of 20,000 numbers; one of the other noise's seeds has nothing to do with it.
        let spread = (squares / 20_000.0f64).sqrt();
        assert!((sum / 20_000.0).abs() < 0.035 * spread && periodic.abs() / 20_000.0 < 0.01, "{sum} {periodic}");
        let other = (0..20_000).map(|k| f64::from(gradient(at(k).as_vec3(), [1 << 20; 3], 5)).powi(2)).sum::<f64>();
        // Both have gradients of the same kind: 1.5 within 3 %.
        assert!((spread / (other / 20_000.0).sqrt() / 1.5 - 1.0).abs() < 0.03, "{spread}");
        assert_ne!(spatial(at(7), 5), spatial(at(7), 6));
    }

    #[test]
    fn cellular_noise_finds_the_nearest_point() {
        let cells = Cellular::new([3, 3, 3], 2);
        let p = Vec3::new(1.3, 0.2, 2.9);
        let mut best = f32::MAX;
        for i in 0..27 * 27 {
            let c = Vec3::new((i % 9) as f32, ((i / 9) % 9) as f32, (i / 81) as f32) - Vec3::splat(3.0);
            let [x, y, z] = [c.x, c.y, c.z].map(|v| wrap(v as i32, 3));
            best = best.min((c + cells.points[(x + 3 * (y + 3 * z)) as usize] - p).length());
        }
        assert!((cells.nearest(p) - best).abs() < 1e-6);
    }
}
