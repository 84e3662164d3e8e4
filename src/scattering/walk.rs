//! Steps of a photon: turning by a scattering angle, random directions, sums with error bars.

use crate::lightning::random::Stream;
use crate::numeric::sphere::Direction;
use std::f64::consts::TAU;

/// Turns a unit vector by a scattering angle with this cosine, around a random azimuth.
pub fn turn(d: Direction, cosine: f64, random: &mut Stream) -> Direction {
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let (sin, cos) = (TAU * random.unit()).sin_cos();
    // A basis across `d` without a singular direction (Duff et al. 2017).
    let sign = 1.0_f64.copysign(d[2]);
    let a = -1.0 / (sign + d[2]);
    let b = d[0] * d[1] * a;
    let u = [1.0 + sign * d[0] * d[0] * a, sign * b, -sign * d[0]];
    let v = [b, sign + d[1] * d[1] * a, -d[1]];
    let mut out = [0.0; 3];
    for k in 0..3 {
        out[k] = cosine * d[k] + sine * (cos * u[k] + sin * v[k]);
    }
    normalise(out)
}

/// An even direction on the sphere.
pub fn isotropic(random: &mut Stream) -> Direction {
    let z = 2.0 * random.unit() - 1.0;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (TAU * random.unit()).sin_cos();
    [r * cos, r * sin, z]
}

/// A direction of the upper half sphere by Lambert's law.
pub fn lambertian(random: &mut Stream) -> Direction {
    let z = random.unit().sqrt();
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (TAU * random.unit()).sin_cos();
    [r * cos, r * sin, z]
}

/// An exponentially distributed optical depth to the next event.
pub fn free_depth(random: &mut Stream) -> f64 {
    -random.unit().ln()
}

fn normalise(d: Direction) -> Direction {
    let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
    d.map(|c| c / length)
}

/// A mean with its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Its standard error.
    pub error: f64,
}

impl Estimate {
    /// From the results of independent batches of equal size.
    pub fn of(batches: &[f64]) -> Self {
        let n = batches.len() as f64;
        let mean = batches.iter().sum::<f64>() / n;
        let variance = batches.iter().map(|b| (b - mean) * (b - mean)).sum::<f64>() / (n - 1.0).max(1.0);
        Self { mean, error: (variance / n).sqrt() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::sphere::dot;

    #[test]
    fn a_turn_has_its_cosine_for_every_direction() {
        let mut random = Stream::new(1, 1);
        for d in [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.6, -0.64, -0.48]] {
            for cosine in [-1.0, -0.3, 0.0, 0.9, 1.0] {
                let e = turn(d, cosine, &mut random);
                assert!((dot(d, e) - cosine).abs() < 1e-12 && (dot(e, e) - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn random_directions_have_their_moments() {
        let mut random = Stream::new(2, 0);
        let n = 20_000;
        let (mut iso, mut lambert) = ([0.0; 3], 0.0);
        for _ in 0..n {
            let d = isotropic(&mut random);
            iso = [iso[0] + d[0], iso[1] + d[1], iso[2] + d[2] * d[2]];
            lambert += super::lambertian(&mut random)[2];
        }
        let n = f64::from(n);
        // Standard errors 0.58, 0.58, 0.30 and 0.24 over sqrt(n) = 141; five of them.
        assert!((iso[0] / n).abs() < 0.021 && (iso[1] / n).abs() < 0.021);
        assert!((iso[2] / n - 1.0 / 3.0).abs() < 0.011 && (lambert / n - 2.0 / 3.0).abs() < 0.0085);
    }
}
