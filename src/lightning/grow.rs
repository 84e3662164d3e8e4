//! The one contract of all growth methods: parameters, scene and seed in, channel and info out.

use super::channel::{Channel, Info};
use super::dbm;
use super::error::GrowError;
use super::laplacian::laplacian;
use super::rational::{Arithmetic, rational};
use super::reed_wyvill::{ReedWyvill, reed_wyvill};
use super::scene::Scene;
use super::tables::Tables;
use std::sync::atomic::AtomicBool;

/// Range of eta, the exponent of the potential: 0 gives a compact Eden cluster, 1 the dielectric breakdown of Niemeyer et al.,
/// 2 and 3 look like lightning, above 5 hardly a branch is left.
pub const ETA_RANGE: [f64; 2] = [0.0, 20.0];
/// Range of the tolerance of the linear solver.
pub const TOLERANCE_RANGE: [f64; 2] = [1e-12, 1.0];

/// A method with its parameters.
#[derive(Clone, Debug, PartialEq)]
pub enum Method {
    /// Branching by statistics of angle and length; needs no field.
    ReedWyvill(ReedWyvill),
    /// Exact dielectric breakdown by the incremental Green's function: the default of the exact forms.
    Dielectric {
        /// Exponent of the potential, [`ETA_RANGE`].
        eta: f64,
    },
    /// Exact dielectric breakdown by conjugate gradients: the slow reference, as Kim and Lin 2004.
    DielectricConjugate {
        /// Exponent of the potential, [`ETA_RANGE`].
        eta: f64,
        /// Greatest residual at which a solve ends, [`TOLERANCE_RANGE`]. 1e-6 is safe; 1e-3 grows a tenth more cells.
        tolerance: f64,
    },
    /// Fast Laplacian growth.
    Laplacian {
        /// Exponent of the potential, [`ETA_RANGE`].
        eta: f64,
        /// Pull of a target in charges, [`super::laplacian::PULL_RANGE`]; [`super::laplacian::DEFAULT_PULL`] reaches most.
        pull: f64,
        /// The kernel.
        arithmetic: Arithmetic,
    },
    /// The rational potential.
    Rational {
        /// Exponent of the potential, [`ETA_RANGE`].
        eta: f64,
        /// Exponent of the distance, [`super::rational::RHO_RANGE`]; more of it gives fewer branches and a straighter way.
        rho: f64,
        /// The kernel.
        arithmetic: Arithmetic,
    },
}

impl Method {
    /// The rational potential in its usual kernel.
    pub fn rational(eta: f64, rho: f64) -> Self {
        Self::Rational { eta, rho, arithmetic: Arithmetic::default() }
    }

    /// Fast Laplacian growth in its usual kernel.
    pub fn laplacian(eta: f64, pull: f64) -> Self {
        Self::Laplacian { eta, pull, arithmetic: Arithmetic::default() }
    }

    /// Its name, as the command line and reports have it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::ReedWyvill(_) => "reed-wyvill",
            Self::Dielectric { .. } => "dbm",
            Self::DielectricConjugate { .. } => "dbm-cg",
            Self::Laplacian { .. } => "flg",
            Self::Rational { .. } => "rational",
        }
    }
}

/// What a method is asked for, beside its own parameters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Order<'a> {
    pub scene: &'a Scene,
    pub most_cells: u32,
    pub seed: u64,
    pub cancel: &'a AtomicBool,
}

/// Grows one channel. Equal arguments give equal channels, on every machine.
///
/// `most_cells` bounds the cells grown and with them time and memory; `cancel`, set from elsewhere, ends growth within one
/// cell; `tables` keeps what depends on the grid alone from call to call.
///
/// # Errors
/// [`GrowError`]: scene or parameters are wrong, the target cannot be reached, the solver did not converge, or the caller
/// cancelled.
pub fn grow(
    method: &Method,
    scene: &Scene,
    most_cells: u32,
    seed: u64,
    tables: &mut Tables,
    cancel: &AtomicBool,
) -> Result<(Channel, Info), GrowError> {
    if most_cells == 0 {
        return Err(GrowError::Parameter { name: "cells", value: 0.0, min: 1.0, max: f64::from(u32::MAX) });
    }
    let order = Order { scene, most_cells, seed, cancel };
    match *method {
        Method::ReedWyvill(ref parameters) => reed_wyvill(&order, parameters),
        Method::Dielectric { eta } => dbm::exact(&order, eta, tables),
        Method::DielectricConjugate { eta, tolerance } => dbm::conjugate(&order, eta, tolerance),
        Method::Laplacian { eta, pull, arithmetic } => laplacian(&order, eta, pull, arithmetic, tables),
        Method::Rational { eta, rho, arithmetic } => rational(&order, eta, rho, arithmetic, tables),
    }
}

#[cfg(test)]
mod tests;
