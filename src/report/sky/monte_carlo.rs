//! The clear sky by backward Monte Carlo: all orders of scattering over a spherical Earth, in f64, without any table. It shares
//! with the passes what the air is made of and nothing else.

use crate::lightning::random::Stream;
use crate::passes::common::{AIR_SCALE_M, HAZE_SCALE_M};
use crate::passes::sky::atmosphere::{HAZE_ALBEDO, HAZE_ASYMMETRY, Medium, RAYLEIGH_PER_M, TOP_M};
use crate::passes::sky::multiple::GROUND_ALBEDO;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

const EARTH_M: f64 = 6_371_000.0;
/// Paths are ended by chance below this weight.
const LEAST_WEIGHT: f64 = 0.05;
const MOST_COLLISIONS: u32 = 500;

/// Air of one colour under one sun.
#[derive(Clone, Copy, Debug)]
pub struct ClearAir {
    /// Extinction of the haze at height 0, 1/m.
    pub haze_per_m: f64,
    /// 0 red, 1 green, 2 blue.
    pub colour: usize,
    /// Unit direction towards the sun (east, north, up at the eye).
    pub sun: DVec3,
    /// Orders of scattering that are counted.
    pub orders: u32,
}

/// A mean over paths and its standard error.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    /// Mean.
    pub mean: f64,
    /// Standard deviation of the mean.
    pub sigma: f64,
}

/// What is met along a straight line: (distance, optical depth up to there), growing.
type Depths = Vec<[f64; 2]>;

impl ClearAir {
    /// Luminance of the air along a ray from a height, to the ground or to space, per lux of the sun outside the air.
    pub fn luminance(&self, eye_m: f64, direction: DVec3, paths: u32, seed: u64) -> Estimate {
        let eye = DVec3::new(0.0, 0.0, EARTH_M + eye_m);
        let mut first = Depths::new();
        march(eye, direction, |height_m| self.extinction_per_m(height_m), &mut first);
        let (mut sum, mut squares) = (0.0, 0.0);
        let mut random = Stream::new(seed, self.colour as u64);
        let mut scratch = Depths::new();
        for _ in 0..paths {
            let light = self.path(eye, direction, &first, &mut scratch, &mut random);
            sum += light;
            squares += light * light;
        }
        let (count, mean) = (f64::from(paths), sum / f64::from(paths));
        Estimate { mean, sigma: ((squares / count - mean * mean).max(0.0) / (count - 1.0).max(1.0)).sqrt() }
    }

    /// Transmittance from a height to space in a direction, 0 where the ground is between.
    pub fn transmittance(&self, height_m: f64, direction: DVec3) -> f64 {
        self.towards(DVec3::new(0.0, 0.0, EARTH_M + height_m), direction)
    }

    /// One path: its first collision lies on the ray for certain, later ones by chance.
    fn path(&self, eye: DVec3, direction: DVec3, first: &Depths, scratch: &mut Depths, random: &mut Stream) -> f64 {
        let all = first.last().map_or(0.0, |last| last[1]);
        let mut weight = -(-all).exp_m1();
        if weight <= 0.0 {
            return 0.0;
        }
        let depth = -(-random.unit() * weight).ln_1p();
        let (mut at, mut direction) = (eye + direction * distance_at(first, depth), direction);
        let mut light = 0.0;
        let (mut order, mut on_ground) = (1, false);
        for _ in 0..MOST_COLLISIONS {
            let up = at / at.length();
            let next = if on_ground {
                weight *= f64::from(GROUND_ALBEDO);
                light += weight * up.dot(self.sun).max(0.0) / PI * self.towards(at, self.sun);
                cosine_about(up, random)
            } else {
                let height_m = at.length() - EARTH_M;
                let (rayleigh, haze) = self.scattering_per_m(height_m);
                weight *= (rayleigh + haze) / self.extinction_per_m(height_m);
                let cosine = direction.dot(self.sun);
                let phase = (rayleigh * rayleigh_phase(cosine) + haze * haze_phase(cosine)) / (rayleigh + haze);
                light += weight * phase * self.towards(at, self.sun);
                if order == self.orders {
                    return light;
                }
                order += 1;
                if random.unit() * (rayleigh + haze) < rayleigh {
                    about(direction, rayleigh_cosine(random), random)
                } else {
                    // Drawn by Henyey and Greenstein, weighted to Cornette and Shanks.
                    let cosine = henyey_greenstein_cosine(random);
                    weight *= haze_phase(cosine) / henyey_greenstein(cosine);
                    about(direction, cosine, random)
                }
            };
            direction = next;
            if weight < LEAST_WEIGHT {
                if random.unit() * LEAST_WEIGHT >= weight {
                    return light;
                }
                weight = LEAST_WEIGHT;
            }
            let to_ground = march(at, direction, |height_m| self.extinction_per_m(height_m), scratch);
            let depth = -(1.0 - random.unit()).ln();
            on_ground = depth >= scratch.last().map_or(0.0, |last| last[1]);
            if on_ground && !to_ground {
                return light;
            }
            let away_m = if on_ground { scratch.last().map_or(0.0, |l| l[0]) } else { distance_at(scratch, depth) };
            at += direction * away_m;
            if on_ground {
                at *= EARTH_M / at.length();
            }
        }
        light
    }

    fn towards(&self, at: DVec3, sun: DVec3) -> f64 {
        let mut depths = Depths::new();
        if march(at, sun, |height_m| self.extinction_per_m(height_m), &mut depths) {
            return 0.0;
        }
        (-depths.last().map_or(0.0, |last| last[1])).exp()
    }

    fn scattering_per_m(&self, height_m: f64) -> (f64, f64) {
        let rayleigh = f64::from(RAYLEIGH_PER_M[self.colour]) * (-height_m / f64::from(AIR_SCALE_M)).exp();
        (rayleigh, f64::from(HAZE_ALBEDO) * self.haze_per_m * (-height_m / f64::from(HAZE_SCALE_M)).exp())
    }

    fn extinction_per_m(&self, height_m: f64) -> f64 {
        let (rayleigh, haze) = self.scattering_per_m(height_m);
        rayleigh + haze / f64::from(HAZE_ALBEDO) + f64::from(Medium::ozone_per_m(height_m as f32)[self.colour])
    }
}

/// Optical depths along a line to the ground or out of the air, and whether it ends at the ground. Steps are as long as the
/// height changes by a tenth of the haze's scale height, or of the height's own scale further up.
fn march(from: DVec3, direction: DVec3, extinction_per_m: impl Fn(f64) -> f64, depths: &mut Depths) -> bool {
    depths.clear();
    let along = from.dot(direction);
    let sphere = |radius: f64| along * along - from.length_squared() + radius * radius;
    let top = EARTH_M + f64::from(TOP_M);
    // A point of the ground itself is on it only where the line goes down.
    let ground = sphere(EARTH_M);
    let height_m = from.length() - EARTH_M;
    let to_ground = along < 0.0 && ground > 0.0 && height_m > -1.0;
    let air = sphere(top);
    if air <= 0.0 {
        return false;
    }
    let begin = if from.length() > top { -along - air.sqrt() } else { 0.0 };
    let end = if to_ground { (-along - ground.sqrt()).max(0.0) } else { -along + air.sqrt() };
    let (mut t, mut depth) = (begin.max(0.0), 0.0);
    depths.push([t, 0.0]);
    while t < end {
        let p = from + direction * t;
        let (radius, rise) = (p.length(), p.dot(direction) / p.length());
        let height_m = (radius - EARTH_M).max(0.0);
        let fine_m = 0.1 * f64::from(HAZE_SCALE_M) + 0.08 * (height_m - 6_000.0).max(0.0);
        let step = (fine_m / (rise.abs() + (fine_m / (2.0 * EARTH_M)).sqrt())).min(end - t);
        let middle = (from + direction * (t + 0.5 * step)).length() - EARTH_M;
        depth += extinction_per_m(middle.max(0.0)) * step;
        t += step;
        depths.push([t, depth]);
        if step <= 0.0 {
            break;
        }
    }
    to_ground
}

fn distance_at(depths: &Depths, depth: f64) -> f64 {
    let after = depths.partition_point(|entry| entry[1] < depth).clamp(1, depths.len() - 1);
    let ([t0, d0], [t1, d1]) = (depths[after - 1], depths[after]);
    t0 + (t1 - t0) * ((depth - d0) / (d1 - d0).max(1e-300)).clamp(0.0, 1.0)
}

fn rayleigh_phase(cosine: f64) -> f64 {
    3.0 / (16.0 * PI) * (1.0 + cosine * cosine)
}

fn haze_phase(cosine: f64) -> f64 {
    let g = f64::from(HAZE_ASYMMETRY);
    henyey_greenstein(cosine) * 1.5 * (1.0 + cosine * cosine) / (2.0 + g * g)
}

fn henyey_greenstein(cosine: f64) -> f64 {
    let g = f64::from(HAZE_ASYMMETRY);
    (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cosine).powf(1.5))
}

fn rayleigh_cosine(random: &mut Stream) -> f64 {
    // The inverse of its cubic distribution function (Frisvad 2011).
    let u = 2.0 * (2.0 * random.unit() - 1.0);
    let v = (u + (u * u + 1.0).sqrt()).cbrt();
    (v - 1.0 / v).clamp(-1.0, 1.0)
}

fn henyey_greenstein_cosine(random: &mut Stream) -> f64 {
    let g = f64::from(HAZE_ASYMMETRY);
    let share = (1.0 - g * g) / (1.0 - g + 2.0 * g * random.unit());
    ((1.0 + g * g - share * share) / (2.0 * g)).clamp(-1.0, 1.0)
}

fn about(axis: DVec3, cosine: f64, random: &mut Stream) -> DVec3 {
    let (a, b) = axis.any_orthonormal_pair();
    let (sin, cos) = (TAU * random.unit()).sin_cos();
    (axis * cosine + (a * cos + b * sin) * (1.0 - cosine * cosine).max(0.0).sqrt()).normalize()
}

fn cosine_about(axis: DVec3, random: &mut Stream) -> DVec3 {
    let cosine = random.unit().sqrt();
    about(axis, cosine, random)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::passes::sky::atmosphere::{Air, Luminary};
    use crate::passes::sky::multiple::HigherOrders;
    use glam::Vec3;

    fn air(colour: usize, elevation_deg: f64, orders: u32) -> ClearAir {
        let (up, flat) = elevation_deg.to_radians().sin_cos();
        ClearAir { haze_per_m: 5e-5, colour, sun: DVec3::new(flat, 0.0, up), orders }
    }

    #[test]
    fn vertical_transmittance_is_that_of_the_scale_heights() {
        // Ozone: a triangle of 30 km whose peak is 1.881e-6 in the green (Hillaire 2020, table 1).
        let depth = 14.32e-6 * 8_000.0 + 5e-5 * 1_200.0 + 2.11e-6 * 15_000.0;
        let found = -air(1, 90.0, 1).transmittance(0.0, DVec3::Z).ln();
        // Steps of a tenth of a scale height by the midpoint rule: 0.1^2 / 24; the top cuts 4e-6 of the air.
        assert!((found / depth - 1.0).abs() < 1e-3, "{found} {depth}");
        assert_eq!(air(1, 90.0, 1).transmittance(10.0, DVec3::new(1.0, 0.0, -0.1).normalize()), 0.0, "the ground");
    }

    #[test]
    fn one_order_is_what_the_passes_integrate_and_more_orders_are_brighter() {
        for (elevation_deg, direction) in [(40.0, DVec3::new(0.3, 0.4, 0.9)), (8.0, DVec3::new(-0.8, 0.1, 0.2))] {
            let direction = direction.normalize();
            for colour in [0, 2] {
                let thin = |orders| ClearAir { haze_per_m: 5e-6, ..air(colour, elevation_deg, orders) };
                let once = thin(1);
                let found = once.luminance(200.0, direction, 4_000, 1);
                let sun = Luminary { direction: once.sun.as_vec3(), illuminance_lux: Vec3::ONE };
                let none = HigherOrders::none();
                let wanted = Air { haze_per_m: 5e-6 }.inscatter(&none, 200.0, direction.as_vec3(), &[sun], 2_000).0;
                // Chance; the passes' table of columns (1.5 % of the haze's); and that they let half of the haze's light go on,
                // half of a depth of 0.006 over a sine of 0.14.
                let allowed = 4.0 * found.sigma + 0.03 * found.mean;
                assert!((found.mean - f64::from(wanted[colour])).abs() < allowed, "{found:?} {wanted}");
                let all = thin(u32::MAX).luminance(200.0, direction, 4_000, 1);
                assert!(all.mean > found.mean + 3.0 * (all.sigma + found.sigma), "{all:?} {found:?}");
            }
        }
    }

    #[test]
    fn cosines_are_drawn_as_the_phases_say() {
        let mut random = Stream::new(3, 0);
        let count = 200_000;
        let mean = |mut draw: Box<dyn FnMut(&mut Stream) -> f64>, random: &mut Stream| {
            (0..count).map(|_| draw(random)).sum::<f64>() / f64::from(count)
        };
        // Means of the square, 2/5, and of the cosine, g; chance is 1 over the root of their number.
        assert!((mean(Box::new(|r| rayleigh_cosine(r).powi(2)), &mut random) - 0.4).abs() < 0.004);
        let g = mean(Box::new(henyey_greenstein_cosine), &mut random);
        assert!((g - f64::from(HAZE_ASYMMETRY)).abs() < 0.004, "{g}");
        // Both phases hold 1 over the sphere: midpoint rule over cosines.
        let whole = |phase: fn(f64) -> f64| {
            (0..20_000).map(|k| phase(-1.0 + (f64::from(k) + 0.5) * 1e-4) * TAU * 1e-4).sum::<f64>()
        };
        assert!((whole(rayleigh_phase) - 1.0).abs() < 1e-4 && (whole(haze_phase) - 1.0).abs() < 1e-4);
    }
}
