//! An independent reference for the deck's light: a Monte Carlo path tracer of the same density field, sun, sky and
//! ground, which makes none of the deck's assumptions about how light spreads in a cloud.
//!
//! *How we compute it.* Free paths by delta tracking against a majorant (Woodcock et al. 1965; Novák et al. 2018,
//! "Monte Carlo Methods for Volumetric Light Transport Simulation", section 3.1), scattering by sampling the phase
//! function, the sun by next-event estimation whose transmittance is tracked the same way (so it is 0 or 1 and unbiased),
//! sky by where a path escapes, ground as a Lambertian reflector. Paths are followed to their end, without roulette.
//! A seed and a pixel give the same paths on any number of threads; every mean comes with its standard error.

pub mod deck;

use crate::lightning::random::Stream;
use crate::scattering::phase::Phase;
use glam::DVec3;

/// What light travels through. Positions in metres; directions are unit vectors.
pub trait Scene: Sync {
    /// Extinction at a point, 1/m, from 0 to [`Scene::majorant`].
    fn extinction(&self, p: DVec3) -> f64;
    /// An upper bound of the extinction, 1/m; over 0.
    fn majorant(&self) -> f64;
    /// The next stretch of a ray that may hold medium: ranges from and to, the first at least `from`.
    fn stretch(&self, p: DVec3, d: DVec3, from: f64) -> Option<(f64, f64)>;
    /// Range at which a ray meets the ground, and the upward normal there.
    fn ground(&self, p: DVec3, d: DVec3) -> Option<(f64, DVec3)>;
    /// Luminance of the ground by itself at a point of it, after a way of so many metres, cd/m2 per colour.
    fn ground_luminance(&self, _at: DVec3, _way_m: f64) -> DVec3 {
        DVec3::ZERO
    }
}

/// Light and matter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surroundings {
    /// Towards the sun.
    pub sun: DVec3,
    /// Sun's illuminance of a plane facing it above the medium, lux per colour.
    pub sun_lux: DVec3,
    /// Luminance of the sky in every upward direction, cd/m2 per colour.
    pub sky_luminance: DVec3,
    /// Share of the light that the ground reflects, 0 to 1, per colour.
    pub ground_albedo: DVec3,
    /// Single-scattering albedo of the medium, 0 to 1.
    pub albedo: f64,
    /// Its phase function.
    pub phase: Phase,
}

/// Light gathered along many paths that begin with one ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// Luminance that the medium sends back along the ray, cd/m2 per colour: without what is seen through it.
    pub luminance: DVec3,
    /// Standard error of it.
    pub error: DVec3,
    /// Share of paths that passed the medium without a collision: its transmittance.
    pub transmittance: f64,
    /// Paths that were given up after [`MOST_COLLISIONS`].
    pub lost: u32,
}

/// Collisions after which a path is given up; it then counts with what it has gathered.
pub const MOST_COLLISIONS: u32 = 100_000;
/// Collisions at the beginning of a path that always look for the sun.
const ALWAYS_LOOK: u32 = 3;
/// Share of the later collisions that look for the sun, for it with the inverse weight.
const LOOK_SHARE: f64 = 0.25;

/// Follows `paths` (at least 2) paths that begin at `eye` in a direction and end at `end_m` at the latest. `seen` weighs
/// what the first collision at a range sends to the eye and adds what lies in between (air); `|_, l| l` for neither.
pub fn pixel(
    scene: &impl Scene,
    around: &Surroundings,
    (eye, direction, end_m): (DVec3, DVec3, f64),
    paths: u32,
    (seed, pixel): (u64, u64),
    seen: impl Fn(f64, DVec3) -> DVec3,
) -> Pixel {
    let (mut sum, mut squares) = (DVec3::ZERO, DVec3::ZERO);
    let (mut passed, mut lost) = (0, 0);
    for path in 0..paths {
        let mut random = Stream::new(seed, pixel.wrapping_mul(1 << 24).wrapping_add(u64::from(path)));
        let Some(t) = collide(scene, eye, direction, end_m, &mut random) else {
            passed += 1;
            continue;
        };
        let (light, given_up) = gather(scene, around, eye + direction * t, direction, &mut random);
        let light = seen(t, light);
        lost += u32::from(given_up);
        sum += light;
        squares += light * light;
    }
    let count = f64::from(paths);
    let mean = sum / count;
    let variance = (squares / count - mean * mean).max(DVec3::ZERO) / (count - 1.0).max(1.0);
    let error = DVec3::new(variance.x.sqrt(), variance.y.sqrt(), variance.z.sqrt());
    Pixel { luminance: mean, error, transmittance: f64::from(passed) / count, lost }
}

/// Range of the next collision before `end_m`, by delta tracking.
fn collide(scene: &impl Scene, p: DVec3, d: DVec3, end_m: f64, random: &mut Stream) -> Option<f64> {
    let majorant = scene.majorant();
    let mut from = 0.0;
    while let Some((begin, end)) = scene.stretch(p, d, from).filter(|(begin, _)| *begin < end_m) {
        let end = end.min(end_m);
        let mut t = begin;
        loop {
            t -= random.unit().ln() / majorant;
            if t >= end {
                break;
            }
            if random.unit() * majorant < scene.extinction(p + d * t) {
                return Some(t);
            }
        }
        if end >= end_m {
            return None;
        }
        from = end;
    }
    None
}

/// Light that reaches a collision at `p` and leaves it against `d`; the second value: the path was given up.
fn gather(scene: &impl Scene, around: &Surroundings, mut p: DVec3, mut d: DVec3, random: &mut Stream) -> (DVec3, bool) {
    let mut weight = DVec3::ONE;
    let mut light = DVec3::ZERO;
    for collision in 0..MOST_COLLISIONS {
        weight *= around.albedo;
        let share = if collision < ALWAYS_LOOK { 1.0 } else { LOOK_SHARE };
        if random.unit() < share && sun_shows(scene, around, p, random) {
            light += weight * around.sun_lux * (around.phase.value(d.dot(around.sun)) / share);
        }
        d = turned(d, around.phase.sample(random), random);
        loop {
            let ground = scene.ground(p, d);
            let end_m = ground.map_or(f64::INFINITY, |(t, _)| t);
            if let Some(t) = collide(scene, p, d, end_m, random) {
                p += d * t;
                break;
            }
            let Some((t, normal)) = ground else {
                return (light + weight * around.sky_luminance, false);
            };
            light += weight * scene.ground_luminance(p + d * t, t);
            weight *= around.ground_albedo;
            if weight == DVec3::ZERO {
                return (light, false);
            }
            // A little above, so that the next ray does not begin below the ground.
            p += d * t + normal * 1e-3;
            let facing = normal.dot(around.sun);
            if facing > 0.0 && sun_shows(scene, around, p, random) {
                light += weight * around.sun_lux * (facing * std::f64::consts::FRAC_1_PI);
            }
            d = diffuse(normal, random);
        }
    }
    (light, true)
}

/// Whether light from the sun gets to a point without a collision: 1 or 0, with the transmittance as its mean.
fn sun_shows(scene: &impl Scene, around: &Surroundings, p: DVec3, random: &mut Stream) -> bool {
    around.sun_lux != DVec3::ZERO
        && scene.ground(p, around.sun).is_none()
        && collide(scene, p, around.sun, f64::INFINITY, random).is_none()
}

/// A direction at an angle of this cosine to `d`, around an even azimuth.
fn turned(d: DVec3, cosine: f64, random: &mut Stream) -> DVec3 {
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let (sin, cos) = (std::f64::consts::TAU * random.unit()).sin_cos();
    let across = d.any_orthonormal_vector();
    (d * cosine + (across * cos + d.cross(across) * sin) * sine).normalize()
}

/// A direction by Lambert's law around a normal.
fn diffuse(normal: DVec3, random: &mut Stream) -> DVec3 {
    turned(normal, random.unit().sqrt(), random)
}

#[cfg(test)]
mod tests;
