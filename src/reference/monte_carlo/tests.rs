//! The tracer against closed forms and against photons that run the other way.

use super::*;
use crate::scattering::slab::{Slab, fluxes};

/// A plane slab between two heights over flat ground at height 0.
struct Flat {
    base_m: f64,
    top_m: f64,
    extinction: f64,
    majorant: f64,
    ground: bool,
}

impl Scene for Flat {
    fn extinction(&self, p: DVec3) -> f64 {
        if (self.base_m..=self.top_m).contains(&p.z) { self.extinction } else { 0.0 }
    }

    fn majorant(&self) -> f64 {
        self.majorant
    }

    fn stretch(&self, p: DVec3, d: DVec3, from: f64) -> Option<(f64, f64)> {
        let (a, b) = ((self.base_m - p.z) / d.z, (self.top_m - p.z) / d.z);
        let (begin, end) = (a.min(b).max(from), a.max(b));
        (begin < end).then_some((begin, end))
    }

    fn ground(&self, p: DVec3, d: DVec3) -> Option<(f64, DVec3)> {
        (self.ground && d.z < 0.0).then(|| (p.z / -d.z, DVec3::Z))
    }
}

const SLAB: Flat = Flat { base_m: 1000.0, top_m: 2000.0, extinction: 0.002, majorant: 0.005, ground: true };
const SUN: Surroundings = Surroundings {
    sun: DVec3::Z,
    sun_lux: DVec3::splat(1000.0),
    sky_luminance: DVec3::ZERO,
    ground_albedo: DVec3::ZERO,
    albedo: 1.0,
    phase: Phase::HenyeyGreenstein(0.85),
};

fn straight(_: f64, light: DVec3) -> DVec3 {
    light
}

fn up(sine: f64) -> DVec3 {
    DVec3::new((1.0 - sine * sine).sqrt(), 0.0, sine)
}

#[test]
fn empty_air_sends_nothing_and_hides_nothing() {
    let empty = Flat { extinction: 0.0, ..SLAB };
    let found = pixel(&empty, &SUN, (DVec3::ZERO, up(0.5), f64::INFINITY), 200, (1, 0), straight);
    assert_eq!((found.luminance, found.transmittance, found.lost), (DVec3::ZERO, 1.0, 0));
}

#[test]
fn a_slab_lets_through_what_beer_says() {
    for sine in [1.0, 0.4] {
        let found = pixel(&SLAB, &SUN, (DVec3::ZERO, up(sine), f64::INFINITY), 4000, (2, 0), straight);
        let expected = (-2.0 / sine).exp();
        // A share of 4000 paths: four standard errors of a binomial.
        let error = (expected * (1.0 - expected) / 4000.0).sqrt();
        assert!((found.transmittance - expected).abs() < 4.0 * error, "{sine}: {found:?}");
        // What ends before the slab meets nothing.
        let short = pixel(&SLAB, &SUN, (DVec3::ZERO, up(sine), 900.0), 50, (2, 0), straight);
        assert_eq!(short.transmittance, 1.0);
    }
}

#[test]
fn a_white_furnace_is_white_everywhere() {
    // Sky of luminance 1 all round, a ground that reflects everything, a medium that absorbs nothing: every path ends
    // with exactly 1, whatever it meets.
    let furnace = Surroundings { sun_lux: DVec3::ZERO, sky_luminance: DVec3::ONE, ground_albedo: DVec3::ONE, ..SUN };
    let thick = Flat { extinction: 0.02, majorant: 0.02, ..SLAB };
    for (eye_m, sine) in [(0.0, 0.9), (1500.0, -0.3), (5000.0, -1.0)] {
        let ray = (DVec3::new(0.0, 0.0, eye_m), up(sine), f64::INFINITY);
        let found = pixel(&thick, &furnace, ray, 300, (3, 0), straight);
        // Of 300 equal numbers: rounding.
        assert!((found.luminance.x + found.transmittance - 1.0).abs() < 1e-12, "{found:?}");
        assert_eq!(found.lost, 0);
    }
}

#[test]
fn single_scattering_has_its_closed_form() {
    // Albedo 1e-3: orders above the first are a thousandth of it. From below, sun in the zenith, eye at cosine mu:
    // L = w p E * integral of exp(-(tau - s)) exp(-s / mu) ds / mu, s the depth from the base.
    let (albedo, mu, tau) = (1e-3, 0.8f64, 2.0f64);
    let dim = Surroundings { albedo, phase: Phase::HenyeyGreenstein(0.5), ..SUN };
    let found = pixel(&SLAB, &dim, (DVec3::ZERO, up(mu), f64::INFINITY), 40_000, (4, 0), straight);
    let depth = ((-tau).exp() - (-tau / mu).exp()) / (1.0 / mu - 1.0) / mu;
    let expected = albedo * dim.phase.value(mu) * 1000.0 * depth;
    // Four standard errors and the second order.
    let allowed = 4.0 * found.error.x + 3e-3 * expected;
    assert!((found.luminance.x - expected).abs() < allowed, "{found:?} {expected}");
    assert!(found.error.x < 0.02 * expected, "the error bar itself must mean something: {found:?}");
}

/// Flux on a plane facing along `d.z * side`, from rays by Lambert's law, over the sun's: the mean and its error.
fn flux(scene: &Flat, around: &Surroundings, eye_m: f64, side: f64) -> (f64, f64) {
    let rays = 4000;
    let shares: Vec<f64> = (0..rays)
        .map(|ray| {
            let mut random = Stream::new(77, ray);
            let d = diffuse(DVec3::Z * side, &mut random);
            let ray = pixel(scene, around, (DVec3::new(0.0, 0.0, eye_m), d, f64::INFINITY), 2, (5, ray), straight);
            ray.luminance.x * std::f64::consts::PI / (around.sun_lux.x * around.sun.z)
        })
        .collect();
    let mean = shares.iter().sum::<f64>() / rays as f64;
    let variance = shares.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (rays * (rays - 1)) as f64;
    (mean, variance.sqrt())
}

#[test]
fn slabs_agree_with_photons_that_run_from_the_sun() {
    // Two programs with nothing in common but the phase function: paths from the eye here, photons from the sun there.
    // A broad phase function: a sharp one shows as few bright paths, whose error bars say little.
    for (depth, mu) in [(4.0, 1.0), (10.0, 0.6)] {
        let scene = Flat { extinction: depth / 1000.0, majorant: depth / 900.0, ground: false, ..SLAB };
        let around = Surroundings { sun: up(mu), phase: Phase::HenyeyGreenstein(0.5), ..SUN };
        let slab = Slab {
            optical_depth: depth,
            albedo: 1.0,
            phase: around.phase,
            cosine: mu,
            ground_albedo: 0.0,
            photons: 40_000,
            seed: 9,
        };
        let photons = fluxes(&slab).expect("a legal slab");
        let (down, down_error) = flux(&scene, &around, 0.0, 1.0);
        let (up, up_error) = flux(&scene, &around, 3000.0, -1.0);
        let direct = (-depth / mu).exp();
        let agrees = |found: f64, error: f64, other: crate::scattering::slab::Fluxes, share: f64, bar: f64| {
            let allowed = 4.0 * (error * error + bar * bar).sqrt();
            assert!((found - share).abs() < allowed, "{depth} {mu}: {found} +- {error} against {other:?}");
            assert!(allowed < 0.1, "an error bar this wide says nothing: {allowed}");
        };
        agrees(down + direct, down_error, photons, photons.transmitted.mean, photons.transmitted.error);
        agrees(up, up_error, photons, photons.reflected.mean, photons.reflected.error);
    }
}

#[test]
fn a_looser_majorant_changes_nothing_but_the_noise() {
    let ray = (DVec3::ZERO, up(0.7), f64::INFINITY);
    let of = |majorant: f64| pixel(&Flat { majorant, ..SLAB }, &SUN, ray, 3000, (6, 0), straight);
    let (tight, loose) = (of(0.002), of(0.02));
    let error = tight.error.x.hypot(loose.error.x);
    assert!((tight.luminance.x - loose.luminance.x).abs() < 4.0 * error, "{tight:?} {loose:?}");
}

#[test]
fn the_ground_gives_back_its_share() {
    // Nothing in the air: the ground under the sun has a luminance of albedo E / pi, seen by paths that a thin veil
    // turns down; here straight from the function that follows them.
    let empty = Flat { extinction: 0.0, ..SLAB };
    let lit = Surroundings { ground_albedo: DVec3::new(0.5, 0.25, 0.0), phase: Phase::HenyeyGreenstein(0.0), ..SUN };
    let mut random = Stream::new(8, 0);
    let paths = 2000;
    let mut sum = DVec3::ZERO;
    for _ in 0..paths {
        sum += gather(&empty, &lit, DVec3::new(0.0, 0.0, 3000.0), DVec3::X, &mut random).0;
    }
    // An isotropic collision: a quarter pi of the sun's illuminance, and half of the directions see the ground.
    let expected = |albedo: f64| 1000.0 * (0.25 / std::f64::consts::PI + 0.5 * albedo / std::f64::consts::PI);
    let mean = sum / f64::from(paths);
    // Half of the paths meet the ground: four standard errors of a binomial of 2000, at most 4 %.
    for (found, albedo) in [(mean.x, 0.5), (mean.y, 0.25), (mean.z, 0.0)] {
        assert!((found / expected(albedo) - 1.0).abs() < 0.045, "{albedo}: {found} {}", expected(albedo));
    }
}

#[test]
fn the_same_seed_gives_the_same_paths() {
    let of = |seed, number| pixel(&SLAB, &SUN, (DVec3::ZERO, up(0.7), f64::INFINITY), 100, (seed, number), straight);
    assert_eq!(of(1, 2), of(1, 2));
    assert_ne!(of(1, 2), of(2, 2));
    assert_ne!(of(1, 2), of(1, 3));
}
