//! What the solver is asked, what it answers, and what it refuses.

use crate::numeric::sphere::{Direction, Rule};
use crate::scattering::balance::Energy;
use crate::scattering::krylov::Method;
use crate::scattering::lanes::LANES;
use crate::scattering::phase::Phase;

/// How the forward peak of the phase function is treated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Treatment {
    /// Delta-M: the peak counts as not scattered. The best in accuracy and speed.
    DeltaM,
    /// The series is cut at the order of the rule and nothing else; for the report.
    Truncated,
}

/// A diffuse ground below the box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Share of the light that it sends back, 0 to 1.
    pub albedo: f64,
    /// Distance below the box, m, 0 or more.
    pub depth_m: f64,
}

/// What to solve and how well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params {
    /// Directions; more follow sharp light better and cost in proportion. Default 26, the paper's.
    pub rule: Rule,
    /// Phase function of the droplets. Default Henyey-Greenstein 0.85.
    pub phase: Phase,
    /// Treatment of its peak. Default delta-M.
    pub treatment: Treatment,
    /// Single-scattering albedo, 0 to 1. Default 0.9999 (water in visible light).
    pub albedo: f64,
    /// Ground below. Default none.
    pub ground: Option<Ground>,
    /// Residual relative to the first scattering at which it stops, 1e-7 to 0.1. Default 1e-4; less costs iterations.
    pub tolerance: f64,
    /// Most sweeps over all directions, 1 to 100,000. Default 2,000.
    pub most_sweeps: usize,
    /// Iteration; none chooses by optical depth and albedo. Default none.
    pub method: Option<Method>,
    /// Rays around the source for the cells near it, 64 to 65,536. Default 2,048.
    pub rays: usize,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            rule: Rule::Lebedev26,
            phase: Phase::HenyeyGreenstein(0.85),
            treatment: Treatment::DeltaM,
            albedo: 0.9999,
            ground: None,
            tolerance: 1e-4,
            most_sweeps: 2000,
            method: None,
            rays: 2048,
        }
    }
}

/// A point source of a lane; a lane may have many (a bolt).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointSource {
    /// Position from the lower south-west corner of the box, m; may lie outside.
    pub position_m: Direction,
    /// Radiant intensity, W/sr, over 0.
    pub intensity: f64,
}

/// Light of one lane's sources.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Scattered light per unit of extinction (times the extinction it is `b` of Dobashi et al. 2007), W/(m^2 sr):
    /// directions times cells.
    pub towards: Vec<f32>,
    /// Of `towards`, what comes of direct light.
    pub single: Vec<f32>,
    /// Moments of the diffuse radiance of the transport, W/m^2: cells times moments.
    pub diffuse: Vec<f32>,
    /// Fluence of direct and diffuse light, W/m^2 a cell; times albedo and extinction it is the scattered light in all.
    pub fluence: Vec<f32>,
    /// Where the energy went.
    pub energy: Energy,
}

/// How a solve went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Info {
    /// The iteration that ended it.
    pub method: Method,
    /// Sweeps over all directions.
    pub sweeps: usize,
    /// Greatest residual of the lanes, relative to their first scattering.
    pub residual: f64,
    /// Values of `towards` that were negative (interpolation beside sharp light) and are 0 now, as a share.
    pub clamped: f64,
}

/// Why there is no solution.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// A parameter out of range.
    #[error("{field} is {value}: {limit}")]
    Parameter {
        /// Which one.
        field: &'static str,
        /// What it was.
        value: f64,
        /// What it must be.
        limit: &'static str,
    },
    /// A source that is none.
    #[error("source {index}: {field} is {value}: {limit}")]
    Source {
        /// Its number, counted over all lanes.
        index: usize,
        /// Which of its numbers.
        field: &'static str,
        /// What it was.
        value: f64,
        /// What it must be.
        limit: &'static str,
    },
    /// More lanes than fit.
    #[error("{0} sources at once: at most {LANES}")]
    Lanes(usize),
    /// The limit of sweeps was reached, or numbers overflowed.
    #[error("residual {residual} after {sweeps} sweeps, {tolerance} was asked for")]
    NoConvergence {
        /// Residual reached.
        residual: f64,
        /// Residual asked for.
        tolerance: f64,
        /// Sweeps done.
        sweeps: usize,
    },
}

/// Whether parameters can be solved by.
///
/// # Errors
/// [`SolveError::Parameter`] names the first that cannot.
pub fn check(params: &Params) -> Result<(), SolveError> {
    let refuse = |field, value, limit| Err(SolveError::Parameter { field, value, limit });
    if let Some(limit) = params.phase.fault() {
        return refuse("phase", params.phase.asymmetry(), limit);
    }
    if !(0.0..=1.0).contains(&params.albedo) {
        return refuse("albedo", params.albedo, "0 to 1");
    }
    if !(1e-7..=0.1).contains(&params.tolerance) {
        return refuse("tolerance", params.tolerance, "1e-7 to 0.1");
    }
    if !(1..=100_000).contains(&params.most_sweeps) {
        return refuse("most_sweeps", params.most_sweeps as f64, "1 to 100,000");
    }
    if !(64..=65_536).contains(&params.rays) {
        return refuse("rays", params.rays as f64, "64 to 65,536");
    }
    if let Some(ground) = params.ground {
        if !(0.0..=1.0).contains(&ground.albedo) {
            return refuse("ground.albedo", ground.albedo, "0 to 1");
        }
        if !(ground.depth_m >= 0.0 && ground.depth_m <= 1e6) {
            return refuse("ground.depth_m", ground.depth_m, "0 to 1e6");
        }
    }
    Ok(())
}

/// Whether sources are some, lane by lane.
pub(in crate::scattering) fn check_sources(lanes: &[&[PointSource]]) -> Result<(), SolveError> {
    if lanes.len() > LANES {
        return Err(SolveError::Lanes(lanes.len()));
    }
    for (index, point) in lanes.iter().flat_map(|l| l.iter()).enumerate() {
        let refuse = |field, value, limit| Err(SolveError::Source { index, field, value, limit });
        if !(point.intensity > 0.0 && point.intensity <= 1e15) {
            return refuse("intensity", point.intensity, "over 0, at most 1e15 W/sr");
        }
        if let Some(x) = point.position_m.iter().find(|x| x.is_nan() || x.abs() > 1e7) {
            return refuse("position_m", *x, "within 1e7 m");
        }
    }
    Ok(())
}
