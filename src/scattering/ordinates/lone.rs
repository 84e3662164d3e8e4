//! The solver for one source alone: cells in the lanes, and diffusion to speed the iteration up.

use super::{Info, SolveError, Solver, add};
use crate::scattering::diffusion::Diffusion;
use crate::scattering::direct::Direct;
use crate::scattering::krylov::{self, Holding, Method};
use crate::scattering::lanes::{LANES, Lanes};
use crate::scattering::operator::{Lone, Work};
use crate::scattering::reconstruct;

/// A solution for one source: moments of the diffuse light, cells in the lanes, and what remains of the way there.
struct Alone<'a> {
    lone: Lone<'a>,
    work: Work,
    /// Moments of diffuse light.
    x: Vec<Lanes>,
    /// Radiance of light that has been scattered once.
    once: Vec<Lanes>,
    info: Info,
}

impl Solver {
    /// Light towards every direction (as [`Light::towards`]) of given direct light alone: the solution of [`Solver::scatter`]
    /// in a fraction of its time where the cells' rows fill the lanes.
    ///
    /// # Errors
    /// [`SolveError::NoConvergence`].
    pub fn scatter_one(&self, direct: &Direct) -> Result<(Vec<f32>, Info), SolveError> {
        self.towards_one(direct, true).unwrap_or_else(|| {
            // Power counts for the energy alone, which nobody asks for here.
            let (mut lights, info) = self.scatter(std::slice::from_ref(direct), &[0.0])?;
            Ok((lights.pop().map(|light| light.towards).unwrap_or_default(), info))
        })
    }

    /// Light towards every direction of one source; `None` where the cells' rows do not fill the lanes.
    pub(in crate::scattering) fn towards_one(
        &self,
        direct: &Direct,
        spread_out: bool,
    ) -> Option<Result<(Vec<f32>, Info), SolveError>> {
        let Alone { lone, mut work, x, once, info } = match self.alone(direct, spread_out, true)? {
            Ok(alone) => alone,
            Err(why) => return Some(Err(why)),
        };
        // Once more for the radiance itself.
        let mut out = vec![Lanes::ZERO; x.len()];
        lone.apply(&x, None, &mut work, &mut out);
        add(&mut work.radiance, &once);
        add_cells(&mut work.radiance, &direct.arrived);
        let mut towards = once;
        reconstruct::diffuse(&self.shared.matrix, &work.radiance, self.medium.len() / LANES, &mut towards);
        let total = self.total(&towards, direct);
        let negative = total.iter().filter(|value| **value < 0.0).count();
        let info = Info { sweeps: info.sweeps + 1, clamped: negative as f64 / total.len() as f64, ..info };
        Some(Ok((total.into_iter().map(|value| value.max(0.0)).collect(), info)))
    }

    /// Moments of one source's diffuse light, moment by moment (moments times cells); `None` where the cells' rows do not fill
    /// the lanes.
    pub(in crate::scattering) fn diffuse_one(&self, direct: &Direct) -> Option<Result<Vec<f32>, SolveError>> {
        let solved = self.alone(direct, false, false)?;
        let moments = self.operator.angles.moments;
        Some(solved.map(|alone| {
            let mut out = Vec::with_capacity(alone.x.len() * LANES);
            (0..moments).for_each(|k| out.extend(alone.x.iter().skip(k).step_by(moments).flat_map(|v| v.0)));
            out
        }))
    }

    /// Solves for one source; `once` is filled where it is asked for.
    fn alone(&self, direct: &Direct, spread_out: bool, with_once: bool) -> Option<Result<Alone<'_>, SolveError>> {
        let operator = &self.operator;
        let lone = Lone::new(operator, spread_out)?;
        let mut work = lone.work();
        let first = lone.moments(&direct.moments);
        let mut b = vec![Lanes::ZERO; first.len()];
        lone.apply(&first, Some(&operator.first(std::slice::from_ref(direct))), &mut work, &mut b);
        let once = if with_once { work.radiance.clone() } else { Vec::new() };
        let diffusion = (self.method() == Method::BiCgStab).then(|| {
            let [zeroth, first] = [0, 1].map(|l| self.shared.scattering.get(l).copied().unwrap_or(0.0));
            Diffusion::new(&self.medium, zeroth, first)
        });
        let (mut x, mut done) = self.iterate(&lone, diffusion.as_ref(), &b, &mut work);
        if !done.converged && diffusion.is_some() {
            (x, done) = self.iterate(&lone, None, &b, &mut work);
        }
        let (residual, sweeps) = (done.residual, done.applications);
        if !done.converged {
            return Some(Err(SolveError::NoConvergence { residual, tolerance: self.params.tolerance, sweeps }));
        }
        let info = Info { method: done.method, sweeps: sweeps + 1, residual, clamped: 0.0 };
        Some(Ok(Alone { lone, work, x, once, info }))
    }

    /// [`Solver::collect`] in a fraction of its time; `None` where the cells' rows do not fill the lanes.
    pub(super) fn collect_one(&self, direct: &Direct, diffuse: &[f32]) -> Option<Vec<f32>> {
        let operator = &self.operator;
        let lone = Lone::new(operator, true)?;
        let mut work = lone.work();
        let mut out = vec![Lanes::ZERO; diffuse.len() / LANES];
        lone.apply(&lone.moments(diffuse), None, &mut work, &mut out);
        let mut towards = work.radiance.clone();
        // Apart from the rest, since the rise of the source over a cell is known for direct light alone.
        let first = operator.first(std::slice::from_ref(direct));
        lone.apply(&lone.moments(&direct.moments), Some(&first), &mut work, &mut out);
        add(&mut work.radiance, &towards);
        add_cells(&mut work.radiance, &direct.arrived);
        reconstruct::diffuse(&self.shared.matrix, &work.radiance, self.medium.len() / LANES, &mut towards);
        Some(self.total(&towards, direct).into_iter().map(|value| value.max(0.0)).collect())
    }

    /// What cells send of diffuse light in cells' lanes and of direct light.
    fn total(&self, towards: &[Lanes], direct: &Direct) -> Vec<f32> {
        let albedo = self.params.albedo as f32;
        let diffuse: &[f32] = bytemuck::cast_slice(towards);
        diffuse.iter().zip(&direct.towards).map(|(d, s)| albedo * (d + s)).collect()
    }

    /// Solves for a lone source; with `diffusion` what is iterated is the solution less its diffusion.
    fn iterate(
        &self,
        lone: &Lone,
        diffusion: Option<&Diffusion>,
        b: &[Lanes],
        work: &mut Work,
    ) -> (Vec<Lanes>, krylov::Iterations) {
        let moments = self.operator.angles.moments;
        let of = |x: &[Lanes]| -> Vec<f32> {
            let mean: Vec<f32> = x.iter().step_by(moments).flat_map(|lanes| lanes.0).collect();
            diffusion.map_or(Vec::new(), |diffusion| diffusion.of(&mean))
        };
        let (mut x, mut whole) = (b.to_vec(), b.to_vec());
        let step = |x: &[Lanes], out: &mut [Lanes]| {
            let diffused = of(x);
            whole.copy_from_slice(x);
            add_mean(&mut whole, moments, 1.0, &diffused);
            lone.apply(&whole, None, work, out);
            add_mean(out, moments, -1.0, &diffused);
        };
        let method = (self.method(), Holding::Cells);
        let done = krylov::solve(step, b, &mut x, method, self.params.tolerance, self.params.most_sweeps);
        let diffused = of(&x);
        add_mean(&mut x, moments, 1.0, &diffused);
        (x, done)
    }
}

/// Adds what is listed direction by direction and cell by cell; nothing where the list is empty.
fn add_cells(to: &mut [Lanes], list: &[f32]) {
    let to: &mut [f32] = bytemuck::cast_slice_mut(to);
    to.iter_mut().zip(list).for_each(|(to, value)| *to += value);
}

/// Adds to the zeroth moments, sixteen cells an entry.
fn add_mean(to: &mut [Lanes], moments: usize, weight: f32, mean: &[f32]) {
    for (to, mean) in to.iter_mut().step_by(moments).zip(mean.chunks_exact(LANES)) {
        for (to, mean) in to.0.iter_mut().zip(mean) {
            *to += weight * mean;
        }
    }
}
