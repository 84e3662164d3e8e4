//! Analogue Monte Carlo of a plane-parallel slab: what of a beam passes, comes back and is absorbed.

use super::phase::Phase;
use super::walk::{Estimate, free_depth, turn};
use crate::lightning::random::Stream;
use rayon::prelude::*;

/// A slab and the beam that falls on it from above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slab {
    /// Optical depth, 0 or more.
    pub optical_depth: f64,
    /// Single-scattering albedo, 0 to 1.
    pub albedo: f64,
    /// Phase function of the droplets.
    pub phase: Phase,
    /// Cosine of the beam's angle to the vertical, over 0 to 1.
    pub cosine: f64,
    /// Albedo of the diffuse ground right below, 0 to 1.
    pub ground_albedo: f64,
    /// Photons to follow, 1 to 10^9; the error falls with the root.
    pub photons: u64,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// Shares of the beam's flux, with standard errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fluxes {
    /// Downward through the lower face, direct and diffuse (every passage counts where the ground reflects).
    pub transmitted: Estimate,
    /// Upward out of the upper face.
    pub reflected: Estimate,
    /// Absorbed in the slab.
    pub absorbed: Estimate,
    /// Photons given up after a million collisions, as a share.
    pub lost: f64,
}

/// A value that the slab cannot have.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("slab: {field} is {value}: {limit}")]
pub struct SlabError {
    /// Which field.
    pub field: &'static str,
    /// What it was.
    pub value: f64,
    /// What it must be.
    pub limit: &'static str,
}

/// Collisions after which a photon is given up and counted as lost.
const MOST_COLLISIONS: u32 = 1_000_000;
/// Batches for the error bars; fixed, so that the number of threads changes nothing.
const BATCHES: u64 = 32;

/// Follows the photons.
///
/// # Errors
/// [`SlabError`] names the field that is out of range.
pub fn fluxes(slab: &Slab) -> Result<Fluxes, SlabError> {
    check(slab)?;
    let per_batch = slab.photons.div_ceil(BATCHES);
    let batches: Vec<[f64; 4]> = (0..BATCHES)
        .into_par_iter()
        .map(|batch| {
            let mut counts = [0.0; 4];
            for photon in 0..per_batch {
                follow(slab, &mut Stream::new(slab.seed, batch * per_batch + photon), &mut counts);
            }
            counts.map(|c| c / per_batch as f64)
        })
        .collect();
    let column = |k: usize| Estimate::of(&batches.iter().map(|b| b[k]).collect::<Vec<_>>());
    Ok(Fluxes { transmitted: column(0), reflected: column(1), absorbed: column(2), lost: column(3).mean })
}

fn check(slab: &Slab) -> Result<(), SlabError> {
    let refuse = |field, value, limit| Err(SlabError { field, value, limit });
    let share = |v: f64| (0.0..=1.0).contains(&v);
    if !(slab.optical_depth >= 0.0 && slab.optical_depth.is_finite()) {
        return refuse("optical_depth", slab.optical_depth, "finite, 0 or more");
    }
    if !share(slab.albedo) {
        return refuse("albedo", slab.albedo, "0 to 1");
    }
    if !share(slab.ground_albedo) {
        return refuse("ground_albedo", slab.ground_albedo, "0 to 1");
    }
    if !(slab.cosine > 0.0 && slab.cosine <= 1.0) {
        return refuse("cosine", slab.cosine, "over 0 and at most 1");
    }
    if !(1..=1_000_000_000).contains(&slab.photons) {
        return refuse("photons", slab.photons as f64, "1 to 1e9");
    }
    if let Some(limit) = slab.phase.fault() {
        return refuse("phase", slab.phase.asymmetry(), limit);
    }
    Ok(())
}

/// One photon: depth below the upper face, direction with z downwards. Counts: transmitted, reflected, absorbed, lost.
fn follow(slab: &Slab, random: &mut Stream, counts: &mut [f64; 4]) {
    let mut depth = 0.0;
    let mut d = [(1.0 - slab.cosine * slab.cosine).max(0.0).sqrt(), 0.0, slab.cosine];
    for _ in 0..MOST_COLLISIONS {
        depth += d[2] * free_depth(random);
        if depth < 0.0 {
            counts[1] += 1.0;
            return;
        }
        if depth >= slab.optical_depth {
            counts[0] += 1.0;
            if random.unit() >= slab.ground_albedo {
                return;
            }
            let up = super::walk::lambertian(random);
            (depth, d) = (slab.optical_depth, [up[0], up[1], -up[2]]);
            continue;
        }
        if random.unit() >= slab.albedo {
            counts[2] += 1.0;
            return;
        }
        d = turn(d, slab.phase.sample(random), random);
    }
    counts[3] += 1.0;
}

#[cfg(test)]
mod tests {
    use super::*;

    const BASE: Slab = Slab {
        optical_depth: 2.0,
        albedo: 0.9,
        phase: Phase::HenyeyGreenstein(0.75),
        cosine: 1.0,
        ground_albedo: 0.0,
        photons: 60_000,
        seed: 1,
    };

    /// Within four standard errors and the rounding of the published value.
    fn agrees(estimate: Estimate, published: f64, rounding: f64) {
        assert!(
            (estimate.mean - published).abs() < 4.0 * estimate.error + rounding,
            "{estimate:?} against {published}"
        );
    }

    #[test]
    fn a_published_slab() {
        // van de Hulst 1980, "Multiple Light Scattering", as tabulated in Wang, Jacques and Zheng 1995 (MCML), table 1:
        // optical depth 2, albedo 0.9, g = 0.75, normal incidence.
        let f = fluxes(&BASE).expect("a legal slab");
        agrees(f.reflected, 0.097_39, 5e-6);
        agrees(f.transmitted, 0.660_96, 5e-6);
        assert!((f.transmitted.mean + f.reflected.mean + f.absorbed.mean + f.lost - 1.0).abs() < 1e-12);
    }

    #[test]
    fn without_scattering_the_beam_decays_by_beer() {
        let f = fluxes(&Slab { albedo: 0.0, cosine: 0.5, optical_depth: 1.0, ..BASE }).expect("a legal slab");
        agrees(f.transmitted, f64::exp(-2.0), 0.0);
        assert_eq!(f.reflected.mean, 0.0);
    }

    #[test]
    fn thick_conservative_slabs_follow_diffusion() {
        // Isotropic, conservative, thick, under diffuse light by Lambert's law the transmittance tends to
        // (4/3) / (tau + 2 * 0.7104); at normal incidence the entering beam has its escape function instead:
        // H(1) = 2.9078 and T -> H(1) / sqrt(3) / (tau + 1.4209) (Chandrasekhar 1950; van de Hulst 1980).
        let f = fluxes(&Slab { optical_depth: 20.0, albedo: 1.0, phase: Phase::HenyeyGreenstein(0.0), ..BASE })
            .expect("a legal slab");
        agrees(f.transmitted, 2.9078 / 3.0_f64.sqrt() / (20.0 + 1.4209), 1e-4);
        assert_eq!(f.absorbed.mean, 0.0);
    }

    #[test]
    fn a_white_ground_under_a_clear_slab_sends_everything_back() {
        let f = fluxes(&Slab { optical_depth: 0.0, ground_albedo: 1.0, photons: 1000, ..BASE }).expect("a legal slab");
        assert_eq!((f.transmitted.mean, f.reflected.mean), (1.0, 1.0));
    }

    #[test]
    fn the_same_seed_gives_the_same_numbers_on_any_number_of_threads() {
        let slab = Slab { photons: 2000, ..BASE };
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool").install(|| fluxes(&slab));
        assert_eq!(alone, fluxes(&slab));
        assert_ne!(alone, fluxes(&Slab { seed: 2, ..slab }));
    }

    #[test]
    fn bad_values_are_refused_by_name() {
        let field = |slab: Slab| fluxes(&slab).expect_err("refused").field;
        assert_eq!(field(Slab { optical_depth: -1.0, ..BASE }), "optical_depth");
        assert_eq!(field(Slab { albedo: f64::NAN, ..BASE }), "albedo");
        assert_eq!(field(Slab { cosine: 0.0, ..BASE }), "cosine");
        assert_eq!(field(Slab { ground_albedo: 1.5, ..BASE }), "ground_albedo");
        assert_eq!(field(Slab { photons: 0, ..BASE }), "photons");
        assert_eq!(field(Slab { phase: Phase::HenyeyGreenstein(1.0), ..BASE }), "phase");
    }
}
