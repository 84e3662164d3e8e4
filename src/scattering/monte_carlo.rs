//! Analogue Monte Carlo of a point source in a grid of cells: the independent reference of the solver, with error bars.
//!
//! Photons fly by delta tracking (Woodcock et al. 1965), so nothing is shared with the solver's rays. What is counted is
//! the solver's result: light scattered per cell, in all and towards chosen directions.

use super::medium::Medium;
use super::phase::Phase;
use super::walk::{Estimate, free_depth, isotropic, lambertian, turn};
use crate::lightning::random::Stream;
use crate::numeric::sphere::{Direction, dot};
use rayon::prelude::*;
use std::f64::consts::PI;

/// What to follow.
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// Photons, at least 1; the error falls with the root.
    pub photons: u64,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Single-scattering albedo, 0 to 1.
    pub albedo: f64,
    /// Phase function of the droplets.
    pub phase: Phase,
    /// Ground below: albedo (0 to 1) and distance under the box, m. Light that it sends past the box is lost.
    pub ground: Option<(f64, f64)>,
    /// Directions towards which scattered light is counted; none leaves only the total.
    pub directions: Vec<Direction>,
}

/// Light of a source of 1 W/sr.
#[derive(Clone, Debug, PartialEq)]
pub struct Scattered {
    /// Light scattered once or more, integrated over directions, W/m^3 per cell: mean over the cell.
    pub total: Vec<f64>,
    /// The share of `total` that has been scattered at least once before.
    pub multiple: Vec<f64>,
    /// Light scattered towards each direction, W/(m^3 sr): directions times cells.
    pub towards: Vec<f32>,
    /// Standard error of `total`.
    pub error: Vec<f64>,
    /// Share of the source's light that leaves the box (or is absorbed by the ground).
    pub escaped: Estimate,
    /// Share absorbed in the box.
    pub absorbed: Estimate,
    /// Share given up after a million collisions.
    pub lost: f64,
}

const BATCHES: u64 = 16;
const MOST_COLLISIONS: u32 = 1_000_000;

/// What one batch counts.
struct Tally {
    total: Vec<f64>,
    multiple: Vec<f64>,
    towards: Vec<f32>,
    fates: [f64; 3],
}

/// Follows photons from a point source at `source_m` in (or outside) a box; `medium.periodic` is ignored, the box is open.
/// The caller checks the parameters (the solver's `Params` are checked; this is its reference).
pub fn point_source(medium: &Medium, source_m: Direction, params: &Params) -> Scattered {
    let per_batch = params.photons.div_ceil(BATCHES).max(1);
    let batches: Vec<Tally> = (0..BATCHES)
        .into_par_iter()
        .map(|batch| {
            let mut tally = Tally {
                total: vec![0.0; medium.len()],
                multiple: vec![0.0; medium.len()],
                towards: vec![0.0; medium.len() * params.directions.len()],
                fates: [0.0; 3],
            };
            for photon in 0..per_batch {
                follow(medium, source_m, params, &mut Stream::new(params.seed, batch * per_batch + photon), &mut tally);
            }
            tally
        })
        .collect();
    gather(medium, &batches, per_batch)
}

fn gather(medium: &Medium, batches: &[Tally], per_batch: u64) -> Scattered {
    // 4 pi W in all, shared by the photons of a batch.
    let scale = 4.0 * PI / (per_batch as f64 * medium.cell_volume_m3());
    let estimates: Vec<Estimate> = (0..medium.len())
        .map(|i| Estimate::of(&batches.iter().map(|b| b.total[i] * scale).collect::<Vec<_>>()))
        .collect();
    let mean = |value: &dyn Fn(&Tally) -> f64| batches.iter().map(value).sum::<f64>() / batches.len() as f64;
    let fate = |k: usize| Estimate::of(&batches.iter().map(|b| b.fates[k] / per_batch as f64).collect::<Vec<_>>());
    let towards = batches.first().map_or(0, |b| b.towards.len());
    Scattered {
        total: estimates.iter().map(|e| e.mean).collect(),
        error: estimates.iter().map(|e| e.error).collect(),
        multiple: (0..medium.len()).map(|i| scale * mean(&|b| b.multiple[i])).collect(),
        towards: (0..towards).map(|i| (scale * mean(&|b| f64::from(b.towards[i]))) as f32).collect(),
        escaped: fate(0),
        absorbed: fate(1),
        lost: fate(2).mean,
    }
}

fn follow(medium: &Medium, source_m: Direction, params: &Params, random: &mut Stream, tally: &mut Tally) {
    let majorant = f64::from(medium.extinction_per_m.iter().copied().fold(0.0, f32::max));
    let mut p = source_m;
    let mut d = isotropic(random);
    let mut scattered = false;
    let mut collisions = 0;
    loop {
        // Into the box, if outside.
        let Some(inside) = enter(medium, p, d) else {
            match below(medium, params, p, d, random) {
                Some((ground, up)) => (p, d) = (ground, up),
                None => {
                    tally.fates[0] += 1.0;
                    return;
                }
            }
            continue;
        };
        p = inside;
        let Some(cell) = fly(medium, majorant, &mut p, d, random) else { continue };
        collisions += 1;
        if collisions > MOST_COLLISIONS {
            tally.fates[2] += 1.0;
            return;
        }
        // What is scattered on average, whether or not this photon survives.
        tally.total[cell] += params.albedo;
        if scattered {
            tally.multiple[cell] += params.albedo;
        }
        for (m, s) in params.directions.iter().enumerate() {
            tally.towards[m * medium.len() + cell] += (params.albedo * params.phase.value(dot(*s, d))) as f32;
        }
        if random.unit() >= params.albedo {
            tally.fates[1] += 1.0;
            return;
        }
        d = turn(d, params.phase.sample(random), random);
        scattered = true;
    }
}

/// The first point of the box on a ray: `p` itself when inside, none when it misses or has left.
fn enter(medium: &Medium, p: Direction, d: Direction) -> Option<Direction> {
    let size = medium.size_m();
    let (mut near, mut far) = (0.0_f64, f64::INFINITY);
    for k in 0..3 {
        if d[k].abs() < 1e-300 {
            if p[k] < 0.0 || p[k] >= size[k] {
                return None;
            }
            continue;
        }
        let (a, b) = ((0.0 - p[k]) / d[k], (size[k] - p[k]) / d[k]);
        near = near.max(a.min(b));
        far = far.min(a.max(b));
    }
    // What is left must be more than rounding, or a photon on a face would never leave.
    let least = 1e-9 * size.iter().copied().fold(0.0, f64::max);
    (far > near + least).then(|| std::array::from_fn(|k| p[k] + d[k] * near))
}

/// Flies on to a real collision; moves `p` there and gives the cell, or moves `p` out of the box and gives none.
fn fly(medium: &Medium, majorant: f64, p: &mut Direction, d: Direction, random: &mut Stream) -> Option<usize> {
    let size = medium.size_m();
    // A face counts as inside when the flight goes inwards.
    let slack = 1e-12 * size.iter().copied().fold(0.0, f64::max);
    loop {
        let step = if majorant > 0.0 { free_depth(random) / majorant } else { f64::INFINITY };
        let next: Direction = std::array::from_fn(|k| p[k] + d[k] * step.min(1e30));
        if (0..3).any(|k| next[k] < 0.0 || next[k] >= size[k]) {
            // Out: stand on the face that it crosses, a little beyond.
            let out = (0..3)
                .filter(|k| d[*k] != 0.0)
                .map(|k| (if d[k] > 0.0 { size[k] - p[k] } else { -p[k] }) / d[k])
                .fold(f64::INFINITY, f64::min)
                .max(0.0);
            *p = std::array::from_fn(|k| p[k] + d[k] * (out + slack));
            return None;
        }
        *p = next;
        let cell = medium.index(medium.cell_at(next)?);
        if random.unit() * majorant < f64::from(medium.extinction_per_m[cell]) {
            return Some(cell);
        }
    }
}

/// Where a photon that left through the lower face meets the ground and what the ground sends back; none when it is
/// absorbed, went elsewhere, or there is no ground.
fn below(
    medium: &Medium,
    params: &Params,
    p: Direction,
    d: Direction,
    random: &mut Stream,
) -> Option<(Direction, Direction)> {
    let (albedo, depth_m) = params.ground?;
    // Rounding of a photon that stands on the lower face, which may be the ground itself.
    let slack = 1e-9 * medium.size_m().iter().copied().fold(0.0, f64::max);
    if d[2] >= 0.0 || p[2] > slack || p[2] + depth_m < -slack || random.unit() >= albedo {
        return None;
    }
    let t = ((p[2] + depth_m) / -d[2]).max(0.0);
    let foot = [p[0] + d[0] * t, p[1] + d[1] * t];
    let up = lambertian(random);
    // Back to the height of the lower face at once; past the box it is lost.
    let size = medium.size_m();
    let back = depth_m / up[2];
    let face = [foot[0] + up[0] * back, foot[1] + up[1] * back];
    let inside = (0..2).all(|k| face[k] >= 0.0 && face[k] < size[k]);
    inside.then_some(([face[0], face[1], 0.0], up))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(n: usize, extinction: f32) -> Medium {
        Medium::new([n; 3], [1.0; 3], vec![extinction; n * n * n], false).expect("legal")
    }

    fn params(albedo: f64, photons: u64) -> Params {
        Params { photons, seed: 3, albedo, phase: Phase::HenyeyGreenstein(0.0), ground: None, directions: vec![] }
    }

    #[test]
    fn the_first_collisions_of_a_uniform_medium_are_known_in_closed_form() {
        // Collisions within a distance r: 1 - exp(-sigma r). The cube of edge 1 around the source lies between its inner
        // and outer sphere; a cube of 31 around it holds all but exp(-15).
        let medium = cube(31, 1.0);
        let p = Params { albedo: 1e-12, ..params(0.0, 50_000) };
        let found = point_source(&medium, [15.5; 3], &p);
        let middle = found.total[medium.index([15; 3])] / 1e-12 / (4.0 * PI);
        // Mean over directions of 1 - exp(-r) to the faces of the cube, by 20,000 even directions: exact to 1e-4.
        let directions = crate::numeric::sphere::fibonacci(20_000);
        let exact =
            directions.iter().map(|d| 1.0 - (-0.5 / d.iter().fold(0.0_f64, |m, c| m.max(c.abs()))).exp()).sum::<f64>()
                / 20_000.0;
        assert!((middle - exact).abs() < 4.0 * (exact * (1.0 - exact) / 50_000.0).sqrt() + 1e-4, "{middle} {exact}");
        assert!(found.absorbed.mean > 0.9999);
    }

    #[test]
    fn scattering_in_an_infinite_medium_sums_to_the_geometric_series() {
        // With albedo w every photon scatters w / (1 - w) times in an endless medium; a box of 30 mean free paths
        // around the source loses exp(-sqrt(3 (1 - w)) 15) = 7e-9 of diffuse light at w = 0.5.
        let found = point_source(&cube(30, 1.0), [15.2, 14.7, 15.1], &params(0.5, 20_000));
        let scatterings = found.total.iter().sum::<f64>() / (4.0 * PI);
        // Standard deviation of a geometric number of collisions: sqrt(w) / (1 - w) times w; four standard errors.
        assert!((scatterings - 1.0).abs() < 4.0 * 0.71 / 20_000.0_f64.sqrt(), "{scatterings}");
        let multiple = found.multiple.iter().sum::<f64>() / (4.0 * PI);
        assert!((multiple - 0.5).abs() < 4.0 * 0.87 / 20_000.0_f64.sqrt(), "{multiple}");
    }

    #[test]
    fn mean_square_distance_of_diffusion() {
        // Isotropic scattering in an endless medium: the k-th collision lies at mean square distance 2 k / sigma^2; all
        // collisions together (weights w^(k-1)): sum 2 k w^(k-1) / sum w^(k-1) = 2 / (1 - w).
        let medium = Medium::new([31; 3], [2.0; 3], vec![0.5; 31 * 31 * 31], false).expect("legal");
        let found = point_source(&medium, [31.0; 3], &params(0.8, 20_000));
        let (mut weight, mut square) = (0.0, 0.0);
        for (i, total) in found.total.iter().enumerate() {
            let c = medium.centre_m(i).map(|x| x - 31.0);
            weight += total;
            // A cell's spread about its centre adds 3 * 4 / 12.
            square += total * (dot(c, c) + 1.0);
        }
        let expected = 2.0 / 0.2 / 0.25;
        // Spread of r^2 over collisions of a photon is about its mean times 3: four standard errors of 20,000; and the
        // box cuts off exp(-0.7 * 15).
        assert!((square / weight / expected - 1.0).abs() < 4.0 * 3.0 / 141.0, "{}", square / weight);
    }

    #[test]
    fn energy_is_complete_and_sources_outside_count() {
        let mut medium = cube(6, 0.0);
        medium.extinction_per_m.iter_mut().enumerate().for_each(|(i, v)| *v = (i % 5) as f32 * 0.3);
        for source in [[3.1, 2.9, 3.0], [3.0, 3.0, -4.0], [0.0, 0.0, 0.0], [-50.0, 3.0, 3.0]] {
            let p = Params { phase: Phase::HenyeyGreenstein(0.85), ..params(0.9, 20_000) };
            let found = point_source(&medium, source, &p);
            assert!((found.escaped.mean + found.absorbed.mean - 1.0).abs() < 1e-9 && found.lost == 0.0);
            let collisions = found.total.iter().sum::<f64>() / (4.0 * PI) / 0.9;
            // Each collision absorbs a tenth.
            assert!((collisions * 0.1 - found.absorbed.mean).abs() < 6.0 * found.absorbed.error + 1e-3, "{source:?}");
        }
        assert_eq!(point_source(&cube(3, 0.0), [1.0; 3], &params(0.9, 100)).escaped.mean, 1.0);
    }

    #[test]
    fn light_towards_directions_sums_to_the_total() {
        let set = crate::numeric::sphere::Rule::Lebedev26.set();
        let p =
            Params { phase: Phase::HenyeyGreenstein(0.3), directions: set.directions.clone(), ..params(0.9, 20_000) };
        let medium = cube(4, 0.5);
        let found = point_source(&medium, [2.2, 1.9, 2.0], &p);
        for cell in 0..medium.len() {
            let sum: f64 = (0..26).map(|m| set.weights[m] * f64::from(found.towards[m * 64 + cell])).sum();
            // The rule of degree 7 sees a Henyey-Greenstein lobe of 0.3 but for 0.3^8.
            assert!((sum / found.total[cell] - 1.0).abs() < 1e-3);
        }
    }

    #[test]
    fn a_white_ground_sends_light_back_up() {
        let medium = cube(5, 0.2);
        let lit = |ground| {
            let p = Params { ground, ..params(0.9, 40_000) };
            let found = point_source(&medium, [2.5, 2.5, 2.5], &p);
            assert!((found.escaped.mean + found.absorbed.mean - 1.0).abs() < 1e-9);
            found.total.iter().sum::<f64>()
        };
        let (black, white, far) = (lit(None), lit(Some((1.0, 0.0))), lit(Some((1.0, 1000.0))));
        assert!(white > 1.15 * black, "{white} {black}");
        // Light from the ground a kilometre below hardly finds five metres again.
        assert!((far / black - 1.0).abs() < 0.02, "{far} {black}");
    }
}
