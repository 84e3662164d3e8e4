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
    let cell = p.floor();
    let f = (p - cell).as_vec3();
    let [x, y, z] = [cell.x, cell.y, cell.z].map(|v| v as i32 as u32);
    let salt = seed.wrapping_mul(0x9e37_79b9);
    let corner = |dx: u32, dy: u32, dz: u32| {
        let h = pcg3d(x.wrapping_add(dx), y.wrapping_add(dy).wrapping_add(salt), z.wrapping_add(dz));
        let g = Vec3::new(unit(h[0]), unit(h[1]), unit(h[2])) * 2.0 - Vec3::ONE;
        g.dot(f - Vec3::new(dx as f32, dy as f32, dz as f32))
    };
    let s = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let lerp = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let face =
        |dz| lerp(lerp(corner(0, 0, dz), corner(1, 0, dz), s.x), lerp(corner(0, 1, dz), corner(1, 1, dz), s.x), s.y);
    f64::from(lerp(face(0), face(1), s.z)) * 1.5
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
