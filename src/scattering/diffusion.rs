//! Diffuse light by the diffusion equation: what an iteration of the transport is sped up by, never a result.
//!
//! In a thick cloud the error of an iteration is light that diffuses, which sweeps of the transport take away cell by cell. The
//! diffusion of what an iterate still lacks is found by conjugate gradients in a fraction of a sweep's time and added to it
//! (diffusion synthetic acceleration; Adams and Larsen 2002, section III). What it finds need only be near, since the
//! transport's own residual decides when to stop.

use super::lanes::{LANES, Lanes, dispatch};
use super::medium::Medium;

/// Accuracy at which it stops, and the most steps.
const TOLERANCE: f64 = 3e-3;
const MOST_STEPS: usize = 200;

/// Diffusion through a medium: seven numbers a cell.
pub struct Diffusion {
    /// Cells of a row, and of a plane.
    strides: [usize; 2],
    /// Conductance to the next cell east, north and up, m^2; 0 across the box's faces.
    east: Vec<f32>,
    north: Vec<f32>,
    up: Vec<f32>,
    /// What a cell loses to all sides and by absorption, m^2, and its inverse.
    loss: Vec<f32>,
    inverse: Vec<f32>,
    /// Light scattered of unit mean light, m^2.
    scattered: Vec<f32>,
}

impl Diffusion {
    /// For a medium whose extinction is that of the transport; `zeroth` and `first` are albedo times the phase function's moments.
    pub fn new(medium: &Medium, zeroth: f64, first: f64) -> Self {
        let [nx, ny, nz] = medium.cells;
        let h = medium.spacing_m;
        let volume = medium.cell_volume_m3();
        let n = medium.len();
        let sigma = |cell: usize| f64::from(medium.extinction_per_m[cell]);
        // Half a cell's resistance: 3 times its depth of transport; light through clear air is held up by nothing, but
        // no more than all of it leaves.
        let half = |cell: usize, k: usize| 1.5 * sigma(cell) * (1.0 - first) * h[k];
        let mut faces = [vec![0.0_f32; n], vec![0.0_f32; n], vec![0.0_f32; n]];
        let mut loss = vec![0.0_f64; n];
        for cell in 0..n {
            let at = [cell % nx, cell / nx % ny, cell / (nx * ny)];
            for (k, (stride, count)) in [(1, nx), (nx, ny), (nx * ny, nz)].into_iter().enumerate() {
                let area = volume / h[k];
                let outside = usize::from(at[k] == 0) + usize::from(at[k] + 1 == count);
                loss[cell] += outside as f64 * area / (half(cell, k) + 2.0);
                if at[k] + 1 < count {
                    let conductance = area / (half(cell, k) + half(cell + stride, k)).max(1.0);
                    faces[k][cell] = conductance as f32;
                    loss[cell] += conductance;
                    loss[cell + stride] += conductance;
                }
            }
            loss[cell] += sigma(cell) * (1.0 - zeroth) * volume;
        }
        let [east, north, up] = faces;
        Self {
            strides: [nx, nx * ny],
            east,
            north,
            up,
            inverse: loss.iter().map(|v| (1.0 / v.max(1e-30)) as f32).collect(),
            loss: loss.iter().map(|v| *v as f32).collect(),
            scattered: (0..n).map(|cell| (sigma(cell) * zeroth * volume) as f32).collect(),
        }
    }

    /// Mean light of what diffuses when light of the given mean is scattered in every cell.
    pub fn of(&self, light: &[f32]) -> Vec<f32> {
        let n = light.len();
        let mut r: Vec<f32> = light.iter().zip(&self.scattered).map(|(l, s)| l * s).collect();
        let mut x = vec![0.0; n];
        let mut z = vec![0.0; n];
        let mut p = vec![0.0; n];
        let mut q = vec![0.0; n];
        let mut rho = 0.0;
        precondition(&self.inverse, &r, &mut z, &mut rho);
        let start = rho;
        p.copy_from_slice(&z);
        for _ in 0..MOST_STEPS {
            if rho.is_nan() || rho <= TOLERANCE * TOLERANCE * start {
                break;
            }
            let mut along = 0.0;
            multiply(self, &p, &mut q, &mut along);
            let step = (rho / along) as f32;
            advance(step, &p, &q, &mut x, &mut r);
            let before = rho;
            precondition(&self.inverse, &r, &mut z, &mut rho);
            combine((rho / before) as f32, &z, &mut p);
        }
        x
    }
}

dispatch! {
    /// `q = D p`, and `p . q`.
    fn multiply(diffusion: &Diffusion, p: &[f32], q: &mut [f32], along: &mut f64) => multiply_body
}
dispatch! {
    /// `z = r / loss`, and `r . z`.
    fn precondition(inverse: &[f32], r: &[f32], z: &mut [f32], product: &mut f64) => precondition_body
}
dispatch! {
    /// `x += step p`, `r -= step q`.
    fn advance(step: f32, p: &[f32], q: &[f32], x: &mut [f32], r: &mut [f32]) => advance_body
}
dispatch! {
    /// `p = z + beta p`.
    fn combine(beta: f32, z: &[f32], p: &mut [f32]) => combine_body
}

/// Sum of products in fixed lanes: f32 within blocks, f64 between them.
#[inline(always)]
fn dot(a: &[f32], b: &[f32]) -> f64 {
    let mut whole = 0.0;
    for (a, b) in a.chunks(64 * LANES).zip(b.chunks(64 * LANES)) {
        let mut sum = Lanes::ZERO;
        for (a, b) in a.chunks(LANES).zip(b.chunks(LANES)) {
            for (s, (a, b)) in sum.0.iter_mut().zip(a.iter().zip(b)) {
                *s += a * b;
            }
        }
        whole += sum.0.iter().map(|s| f64::from(*s)).sum::<f64>();
    }
    whole
}

#[inline(always)]
fn multiply_body(diffusion: &Diffusion, p: &[f32], q: &mut [f32], along: &mut f64) {
    for ((q, p), loss) in q.iter_mut().zip(p).zip(&diffusion.loss) {
        *q = loss * p;
    }
    let n = p.len();
    for (stride, face) in
        [(1, &diffusion.east), (diffusion.strides[0], &diffusion.north), (diffusion.strides[1], &diffusion.up)]
    {
        if stride >= n {
            continue;
        }
        for ((q, p), g) in q[..n - stride].iter_mut().zip(&p[stride..]).zip(face) {
            *q -= g * p;
        }
        for ((q, p), g) in q[stride..].iter_mut().zip(&p[..n - stride]).zip(face) {
            *q -= g * p;
        }
    }
    *along = dot(p, q);
}

#[inline(always)]
fn precondition_body(inverse: &[f32], r: &[f32], z: &mut [f32], product: &mut f64) {
    for ((z, r), i) in z.iter_mut().zip(r).zip(inverse) {
        *z = r * i;
    }
    *product = dot(r, z);
}

#[inline(always)]
fn advance_body(step: f32, p: &[f32], q: &[f32], x: &mut [f32], r: &mut [f32]) {
    for ((x, p), (r, q)) in x.iter_mut().zip(p).zip(r.iter_mut().zip(q)) {
        *x += step * p;
        *r -= step * q;
    }
}

#[inline(always)]
fn combine_body(beta: f32, z: &[f32], p: &mut [f32]) {
    for (p, z) in p.iter_mut().zip(z) {
        *p = z + beta * *p;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_in_a_slab_falls_as_the_diffusion_equation_says() {
        // Many cells wide, so that the middle column knows nothing of the sides: no absorption, light scattered in the
        // middle layer, a face at each end. The mean light falls in a straight line from there to zero two thirds of a
        // free path beyond each face.
        let (sigma, h, nz) = (0.02_f64, 50.0, 11);
        let medium = Medium::new([48, 48, nz], [h; 3], vec![sigma as f32; 48 * 48 * nz], false).expect("legal");
        let diffusion = Diffusion::new(&medium, 1.0, 0.0);
        let mut given = vec![0.0_f32; medium.len()];
        given[5 * 48 * 48..6 * 48 * 48].fill(1.0);
        let found = diffusion.of(&given);
        let column = |z: usize| f64::from(found[24 + 48 * 24 + 48 * 48 * z]);
        let reach = 5.5 * h + 2.0 / (3.0 * sigma);
        for z in [0, 1, 3, 4, 6, 8, 10] {
            let away = (z as f64 - 5.0).abs() * h;
            let (share, exact) = (column(z) / column(5), 1.0 - away / reach);
            // Solved to 3e-3; the sides are twice the thickness away, by which their darkness falls to a five-hundredth.
            assert!((share - exact).abs() < 0.02, "{z}: {share} {exact}");
        }
    }

    #[test]
    fn clear_air_and_darkness_do_no_harm() {
        let medium = Medium::new([16, 16, 2], [10.0; 3], vec![0.0; 512], false).expect("legal");
        assert!(Diffusion::new(&medium, 1.0, 0.5).of(&[1.0; 512]).iter().all(|v| *v == 0.0));
        let medium = Medium::new([16, 16, 1], [10.0; 3], vec![1.0; 256], false).expect("legal");
        let diffusion = Diffusion::new(&medium, 0.9, 0.0);
        assert!(diffusion.of(&[0.0; 256]).iter().all(|v| *v == 0.0));
        assert!(diffusion.of(&[1.0; 256]).iter().all(|v| v.is_finite() && *v > 0.0));
    }
}
