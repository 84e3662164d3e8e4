//! Early collisions: in thick clouds, light around its source is followed collision by collision.
//!
//! Within a cell or two of its source light falls steeply, and a solver that knows a mean and a straight line a cell puts a quarter to a
//! half too much into the cell of the source where cells are four to ten deep (too little where they are deeper still).
//! So a photon for each near ray is followed until it collides for the first time farther from its source than
//! a radius; those collisions are the solver's source. What a flight leaves in cells is counted by expectation (along the whole
//! flight, weighted by what is left of it), and photons are led to collide within the radius and lose weight for it: energy is
//! kept photon by photon, and some thousand tell enough. What remains for the solver (and for tables
//! of virtual lights) changes smoothly with the source's place.

use super::{Direct, With};
use crate::lightning::random::Stream;
use crate::numeric::sphere::{Direction, dot, harmonics_into};
use crate::scattering::medium::Medium;
use crate::scattering::phase::Phase;
use crate::scattering::rays::walk;
use crate::scattering::walk::turn;
use std::f64::consts::PI;

/// The ball around every source within which collisions are followed, in the medium of the transport.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Early {
    /// Radius of the ball, m.
    pub radius_m: f64,
    albedo: f64,
    phase: Phase,
}

/// Radius in longest edges of a cell.
const EDGES: f64 = 1.25;
/// Depth of a cell from which on its light is uneven enough to matter.
const LEAST_DEPTH: f64 = 1.3;
/// Most free paths of transport within the radius: photons collide as the square of it.
const MOST_PATHS: f64 = 12.0;
/// What is left of a flight where it ends, within the ball and beyond it.
const LEFT: [f64; 2] = [1e-3, 1e-5];
/// Share of its first weight below which a photon plays for its life.
const LIGHT: f64 = 0.1;
/// Collisions after which a photon is dropped.
const MOST_COLLISIONS: usize = 10_000;
const SEED: u64 = 0x0ea2_1c01;

/// A photon on its way from a collision.
struct Photon {
    at: Direction,
    d: Direction,
    power_w: f64,
}

/// A stretch of a flight within the ball: from, depth of the flight up to there, extinction.
type Stretch = (f64, f64, f64);

/// Where flights are counted.
struct Ball<'a> {
    early: Early,
    medium: &'a Medium,
    with: With<'a>,
    source_m: Direction,
    /// The flight's stretches, and its depth within the ball.
    stretches: Vec<Stretch>,
    depth: f64,
    /// Whether the flight goes on beyond the ball; else the little that is left of it collides with the rest.
    leaks: bool,
}

impl Early {
    /// For a medium of the transport and its shares of scattered moments; none where cells are thin or nothing scatters.
    pub fn new(medium: &Medium, scattering: &[f64]) -> Option<Self> {
        let edge = medium.spacing_m.iter().copied().fold(0.0, f64::max);
        let depth = medium.greatest_cell_depth();
        let albedo = scattering.first().copied().unwrap_or(0.0);
        if depth < LEAST_DEPTH || albedo <= 0.0 {
            return None;
        }
        // The transport's phase function has a positive twin: Henyey and Greenstein's of the same mean cosine.
        let cosine = (scattering.get(1).copied().unwrap_or(0.0) / albedo).clamp(-0.99, 0.99);
        let paths = depth * (1.0 - cosine);
        let radius_m = edge * EDGES.min(MOST_PATHS / paths);
        Some(Self { radius_m, albedo, phase: Phase::HenyeyGreenstein(cosine) })
    }

    /// Follows the photons of one source; `index` tells sources of a cluster apart. What flies straight from the source is counted
    /// elsewhere.
    pub fn follow(
        self,
        direct: &mut Direct,
        medium: &Medium,
        ((source_m, intensity), index): ((Direction, f64), usize),
        with: With,
    ) {
        let mut ball = Ball { early: self, medium, with, source_m, stretches: Vec::new(), depth: 0.0, leaks: true };
        let order = with.angles.orders.last().copied().unwrap_or(0);
        let mut y = vec![0.0; with.angles.moments];
        let whole = 4.0 * PI * intensity / with.rays.directions.len() as f64;
        for (r, d) in with.rays.directions.iter().enumerate() {
            let mut random = Stream::new(SEED, (index as u64) << 32 | r as u64);
            let mut photon = Photon { at: source_m, d: *d, power_w: whole };
            ball.first(*d);
            for _ in 0..MOST_COLLISIONS {
                if !ball.collide(&mut photon, whole, &mut random) {
                    break;
                }
                harmonics_into(photon.d, order, &mut y);
                ball.fly(direct, &photon, &y);
            }
        }
    }
}

impl Ball<'_> {
    /// The stretches of a ray from the source, which is counted elsewhere.
    fn first(&mut self, d: Direction) {
        let Self { early, medium, source_m, stretches, .. } = self;
        stretches.clear();
        let mut depth = 0.0;
        walk(medium, *source_m, d, |cell, a, b| {
            let sigma = f64::from(medium.extinction_per_m[cell]);
            stretches.push((a, depth, sigma));
            depth += sigma * (b.min(early.radius_m) - a).max(0.0);
            b < early.radius_m
        });
        (self.depth, self.leaks) = (depth, true);
    }

    /// Leads a photon to a collision within the ball and turns it; false when it ends.
    fn collide(&self, photon: &mut Photon, whole: f64, random: &mut Stream) -> bool {
        let collides = -(-self.depth).exp_m1();
        photon.power_w *= self.early.albedo * if self.leaks { collides } else { 1.0 };
        let least = LIGHT * whole;
        if photon.power_w < least {
            if random.unit() * least >= photon.power_w {
                return false;
            }
            photon.power_w = least;
        }
        let to = -(-random.unit() * collides).ln_1p();
        let after = self.stretches.partition_point(|(_, before, _)| *before <= to);
        let Some((from, before, sigma)) = after.checked_sub(1).map(|i| self.stretches[i]) else { return false };
        // The last stretch that begins before the depth has some, but for rounding.
        let distance = from + if sigma > 0.0 { (to - before) / sigma } else { 0.0 };
        photon.at = std::array::from_fn(|k| photon.at[k] + photon.d[k] * distance);
        photon.d = turn(photon.d, self.early.phase.sample(random), random);
        true
    }

    /// Counts what a flight leaves on its way.
    fn fly(&mut self, direct: &mut Direct, photon: &Photon, y: &[f64]) {
        let Self { early, medium, with, source_m, stretches, .. } = self;
        let (nk, cells) = (with.angles.moments, medium.len());
        let place = with.angles.set.nearest(photon.d);
        let per_volume = photon.power_w / medium.cell_volume_m3();
        let per_solid = 1.0 / with.angles.set.weights[place];
        let away: Direction = std::array::from_fn(|k| photon.at[k] - source_m[k]);
        let along = dot(away, photon.d);
        let out = along * along - dot(away, away) + early.radius_m * early.radius_m;
        let leaves = (out.max(0.0).sqrt() - along).max(0.0);
        stretches.clear();
        let (mut depth, mut left, mut ends_within) = (0.0_f64, 1.0_f64, false);
        walk(medium, photon.at, photon.d, |cell, a, b| {
            let sigma = f64::from(medium.extinction_per_m[cell]);
            let edge = leaves.clamp(a, b);
            for (a, b, inside) in [(a, edge, true), (edge, b, false)] {
                if b <= a {
                    continue;
                }
                let tau = sigma * (b - a);
                let lost = -(-tau).exp_m1();
                let fluence = per_volume * left * if tau > 1e-6 { lost / sigma } else { b - a };
                let to = if inside {
                    stretches.push((a, depth, sigma));
                    depth += tau;
                    &mut direct.settled
                } else {
                    &mut direct.moments
                };
                for (m, y) in to[cell * nk..][..nk].iter_mut().zip(y) {
                    *m += (fluence * y) as f32;
                }
                direct.arrived[place * cells + cell] += (fluence * per_solid) as f32;
                left *= 1.0 - lost;
                if inside && left < LEFT[0] {
                    ends_within = true;
                    return false;
                }
            }
            left > LEFT[1]
        });
        self.depth = depth;
        self.leaks = !ends_within;
        if self.leaks {
            direct.escaped_early_w += photon.power_w * left;
        }
    }
}
