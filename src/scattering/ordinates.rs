//! The solver: light of point sources in a box of cells, scattered any number of times, by discrete ordinates.
//!
//! *What it is.* The transfer equation behind Dobashi et al. 2007, eq. 1, `s . grad I = -sigma I + sigma albedo P I`, with
//! one point source a lane. Eq. 1 itself, as a matrix over pairs of cells, loses or makes energy at any depth that
//! matters and is not built. *How we compute it.* The extinction is delta-M scaled; direct light is analytic
//! (`direct`), the diffuse light is swept along the directions (`operator`) and iterated (`krylov`); then the scattered
//! light is reconstructed with the phase function as it is (`reconstruct`). *How we store it.* Per unit of extinction, so
//! that it interpolates smoothly and is multiplied by a finer extinction once. *How we read it back.* [`Light::towards`].

mod contract;
mod lone;

pub(super) use contract::check_sources;
pub use contract::{Ground, Info, Light, Params, PointSource, SolveError, Treatment, check};

use super::angles::Angles;
use super::balance::{Energy, energies};
use super::direct::{Direct, Early, Rays, With};
use super::krylov::{self, Holding, Method};
use super::lanes::{LANES, Lanes};
use super::medium::Medium;
use super::operator::{Operator, Work};
use super::reconstruct;
use super::surface::Surface;
use std::sync::Arc;

/// A solver made ready for one medium.
pub struct Solver {
    medium: Medium,
    params: Params,
    operator: Operator,
    /// Where cells are thick.
    early: Option<Early>,
    shared: Arc<Shared>,
}

/// What solvers of different media with the same parameters have in common.
struct Shared {
    angles: Arc<Angles>,
    /// Rays of a single source, and of each of many.
    rays: [Rays; 2],
    matrix: Vec<f32>,
    scattering: Vec<f64>,
    /// Factor on the extinction.
    factor: f32,
}

/// Sources of a lane from which on each gets fewer rays.
const MANY: usize = 8;

impl Solver {
    /// Memory that it takes, bytes, but for what it shares with others of the same parameters.
    pub fn memory_bytes(&self) -> usize {
        self.operator.memory_bytes() + size_of_val(self.medium.extinction_per_m.as_slice())
    }

    /// Checks the parameters and computes what does not depend on sources. The light is open whether or not the medium
    /// is periodic (take [`Medium::window`] first).
    ///
    /// # Errors
    /// [`SolveError::Parameter`].
    pub fn new(medium: &Medium, params: Params) -> Result<Self, SolveError> {
        check(&params)?;
        let angles = Arc::new(Angles::new(params.rule));
        let order = params.rule.order();
        let (moments, albedo, factor) = match params.treatment {
            Treatment::DeltaM => {
                let delta = params.phase.delta_m(order);
                let (albedo, factor) = (delta.albedo(params.albedo), delta.extinction_factor(params.albedo));
                (delta.moments, albedo, factor)
            }
            Treatment::Truncated => (params.phase.moments(order), params.albedo, 1.0),
        };
        let few = (params.rays / 8).max(64);
        let shared = Arc::new(Shared {
            rays: [params.rays, few].map(|n| Rays::new(n, &angles, params.phase)),
            matrix: reconstruct::matrix(&angles, params.phase),
            scattering: moments.iter().map(|m| albedo * m).collect(),
            factor: factor as f32,
            angles,
        });
        Ok(Self::with(medium, params, shared))
    }

    /// The same solver for another medium.
    #[must_use]
    pub fn at(&self, medium: &Medium) -> Self {
        Self::with(medium, self.params, self.shared.clone())
    }

    fn with(medium: &Medium, params: Params, shared: Arc<Shared>) -> Self {
        let mut medium = medium.clone();
        medium.extinction_per_m.iter_mut().for_each(|s| *s *= shared.factor);
        let ground = params.ground.map(|g| Surface {
            albedo: g.albedo,
            depth_m: g.depth_m,
            spacing_m: [medium.spacing_m[0], medium.spacing_m[1]],
        });
        let operator = Operator::new(&medium, &shared.angles, &shared.scattering, ground);
        let early = Early::new(&medium, &shared.scattering);
        Self { medium, params, operator, early, shared }
    }

    /// Directions of the results.
    pub fn angles(&self) -> &Angles {
        &self.shared.angles
    }

    /// Share of each moment of the light in a cell that a collision of the transport scatters, moment by moment.
    pub fn scattered(&self) -> Vec<f32> {
        self.shared.angles.orders.iter().map(|l| self.shared.scattering[*l] as f32).collect()
    }

    /// What it was made with.
    pub fn params(&self) -> &Params {
        &self.params
    }

    /// Light of up to sixteen lanes of sources.
    ///
    /// # Errors
    /// [`SolveError`]; nothing is solved by half.
    pub fn solve(&self, lanes: &[&[PointSource]]) -> Result<(Vec<Light>, Info), SolveError> {
        check_sources(lanes)?;
        let directs: Vec<Direct> = lanes.iter().map(|points| self.direct(points)).collect();
        let power: Vec<f64> = lanes.iter().map(|p| p.iter().map(|q| q.intensity).sum()).collect();
        self.scatter(&directs, &power)
    }

    /// Direct light of one lane's points, each for itself.
    pub fn direct(&self, points: &[PointSource]) -> Direct {
        self.direct_of_clusters(&points.iter().map(std::slice::from_ref).collect::<Vec<_>>())
    }

    /// [`Solver::direct`] without what it scatters into each direction ([`Direct::towards`] is empty): for
    /// diffuse light alone, in half the time.
    pub(super) fn direct_moments(&self, points: &[PointSource]) -> Direct {
        self.direct_into(&points.iter().map(std::slice::from_ref).collect::<Vec<_>>(), false)
    }

    /// Direct light of clusters of points: far cells see a cluster in its middle.
    pub fn direct_of_clusters(&self, clusters: &[&[PointSource]]) -> Direct {
        self.direct_into(clusters, true)
    }

    fn direct_into(&self, clusters: &[&[PointSource]], towards: bool) -> Direct {
        let columns = self.params.ground.map_or(0, |_| self.medium.cells[0] * self.medium.cells[1]);
        let mut direct = Direct::dark(self.medium.len(), &self.shared.angles, columns);
        if !towards {
            direct.towards = Vec::new();
        }
        let many = usize::from(clusters.iter().map(|c| c.len()).sum::<usize>() > MANY);
        for cluster in clusters {
            let sources: Vec<_> = cluster.iter().map(|p| (p.position_m, p.intensity)).collect();
            let with = With {
                angles: &self.shared.angles,
                rays: &self.shared.rays[many],
                phase: self.params.phase,
                early: self.early,
                ground_depth_m: self.params.ground.map(|g| g.depth_m),
            };
            direct.add(&self.medium, &sources, with);
        }
        direct
    }

    /// Whatever is scattered of given direct light, one a lane; `power` is the lanes' intensity in all, W/sr.
    ///
    /// # Errors
    /// [`SolveError::NoConvergence`], [`SolveError::Lanes`].
    pub fn scatter(&self, directs: &[Direct], power: &[f64]) -> Result<(Vec<Light>, Info), SolveError> {
        if directs.len() > LANES {
            return Err(SolveError::Lanes(directs.len()));
        }
        let operator = &self.operator;
        let mut work = Work::new(operator);
        let size = self.medium.len() * operator.angles.moments;
        let first = interleave(directs.iter().map(|d| &d.moments[..]), size);
        let mut b = vec![Lanes::ZERO; size];
        operator.apply(&first, Some(&operator.first(directs)), &mut work, &mut b);
        let once = (work.source.clone(), work.radiance.clone());
        let mut x = b.clone();
        let done = krylov::solve(
            |x, out| operator.apply(x, None, &mut work, out),
            &b,
            &mut x,
            (self.method(), Holding::Sources),
            self.params.tolerance,
            self.params.most_sweeps,
        );
        if !done.converged {
            return Err(SolveError::NoConvergence {
                residual: done.residual,
                tolerance: self.params.tolerance,
                sweeps: done.applications,
            });
        }
        // Once more for the radiance itself, then light scattered once on top of light scattered more often.
        let mut again = vec![Lanes::ZERO; size];
        operator.apply(&x, None, &mut work, &mut again);
        add(&mut work.source, &once.0);
        add(&mut work.radiance, &once.1);
        add(&mut again, &b);
        let x = again;
        let mut all = x.clone();
        add(&mut all, &first);
        add_lists(&mut all, directs.iter().map(|d| &d.settled[..]));
        let energy = energies(operator, &self.medium, &work, (&all, &self.shared.scattering), directs, power);
        add_lists(&mut work.radiance, directs.iter().map(|d| &d.arrived[..]));
        let mut towards = once.1;
        reconstruct::diffuse(&self.shared.matrix, &work.radiance, self.medium.len(), &mut towards);
        let mut info =
            Info { method: done.method, sweeps: done.applications + 2, residual: done.residual, clamped: 0.0 };
        let mut negative = 0_usize;
        let lights: Vec<Light> = directs
            .iter()
            .zip(energy)
            .enumerate()
            .map(|(l, (direct, energy))| {
                let (light, below) = self.light(l, direct, &towards, &x, energy);
                negative += below;
                light
            })
            .collect();
        info.clamped = negative as f64 / (towards.len() * directs.len().max(1)) as f64;
        Ok((lights, info))
    }

    /// Light towards every direction (as [`Light::towards`]) from direct light and known moments of the diffuse radiance: one
    /// pass of light, no iteration.
    pub fn collect(&self, direct: &Direct, diffuse: &[f32]) -> Vec<f32> {
        self.collect_one(direct, diffuse).unwrap_or_else(|| self.collect_lane(direct, diffuse))
    }

    /// [`Solver::collect`] with one source in sixteen lanes.
    pub(super) fn collect_lane(&self, direct: &Direct, diffuse: &[f32]) -> Vec<f32> {
        let operator = &self.operator;
        let mut work = Work::new(operator);
        let given = interleave([diffuse, &direct.moments[..]].into_iter(), diffuse.len());
        let mut out = vec![Lanes::ZERO; diffuse.len()];
        let dark = Direct::dark(self.medium.len(), &self.shared.angles, direct.ground.len());
        let first = operator.first(&[dark, direct.clone()]);
        operator.apply(&given, Some(&first), &mut work, &mut out);
        add_lists(&mut work.radiance, std::iter::once(&direct.arrived[..]));
        let radiance: Vec<f32> = work.radiance.iter().map(|r| r.0[0] + r.0[1]).collect();
        let albedo = self.params.albedo as f32;
        let diffuse = reconstruct::diffuse_one(&self.shared.matrix, &radiance, self.medium.len());
        diffuse.iter().zip(&direct.towards).map(|(d, s)| (albedo * (d + s)).max(0.0)).collect()
    }

    /// The result of one lane, and how many of its values were negative.
    fn light(
        &self,
        lane: usize,
        direct: &Direct,
        towards: &[Lanes],
        diffuse: &[Lanes],
        energy: Energy,
    ) -> (Light, usize) {
        let albedo = self.params.albedo as f32;
        let mut negative = 0;
        let total = towards
            .iter()
            .zip(&direct.towards)
            .map(|(diffuse, single)| {
                let value = albedo * (diffuse.0[lane] + single);
                negative += usize::from(value < 0.0);
                value.max(0.0)
            })
            .collect();
        let nk = self.shared.angles.moments;
        let whole = (4.0 * std::f32::consts::PI).sqrt();
        let light = Light {
            towards: total,
            single: direct.towards.iter().map(|s| albedo * s).collect(),
            diffuse: diffuse.iter().map(|d| d.0[lane]).collect(),
            fluence: (0..self.medium.len())
                .map(|c| {
                    let settled = direct.settled.get(c * nk).copied().unwrap_or(0.0);
                    whole * (diffuse[c * nk].0[lane] + direct.moments[c * nk] + settled).max(0.0)
                })
                .collect(),
            energy,
        };
        (light, negative)
    }

    /// Source iteration where light soon leaves or is absorbed, BiCGStab elsewhere.
    fn method(&self) -> Method {
        self.params.method.unwrap_or_else(|| {
            let transport =
                self.medium.greatest_cell_depth() * (1.0 - self.shared.scattering.get(1).map_or(0.0, |s| s.max(0.0)));
            if transport < 0.6 || self.shared.scattering[0] < 0.7 { Method::SourceIteration } else { Method::BiCgStab }
        })
    }
}

fn add(to: &mut [Lanes], what: &[Lanes]) {
    for (a, b) in to.iter_mut().zip(what) {
        *a = a.plus(1.0, b);
    }
}

fn interleave<'a>(lists: impl Iterator<Item = &'a [f32]>, size: usize) -> Vec<Lanes> {
    let mut out = vec![Lanes::ZERO; size];
    add_lists(&mut out, lists);
    out
}

/// Adds one list a lane; empty ones are dark.
fn add_lists<'a>(to: &mut [Lanes], lists: impl Iterator<Item = &'a [f32]>) {
    for (l, list) in lists.enumerate() {
        for (o, v) in to.iter_mut().zip(list) {
            o.0[l] += *v;
        }
    }
}

#[cfg(test)]
pub(in crate::scattering) mod tests;
