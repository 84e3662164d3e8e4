//! Phase functions: how much light a droplet sends into which direction, and their delta-M scaling.

use crate::lightning::random::Stream;
use crate::numeric::sphere::legendre;
use std::f64::consts::PI;

/// A phase function, 1/sr, whose integral over the sphere is 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Phase {
    /// Henyey and Greenstein 1941; asymmetry in the open interval -1 to 1.
    HenyeyGreenstein(f64),
    /// A weighted sum (deck paper eq. 9) of two Cornette-Shanks lobes (eq. 10): pairs of weight and `f`; weights sum to 1.
    /// Eq. 10 has mean 1 over the sphere, so 1/(4 pi) stands outside; its asymmetry is not `f` but a little more.
    CornetteShanks([(f64, f64); 2]),
}

/// Legendre moments of a phase function up to an order, with the forward peak cut off (Wiscombe 1977, "The delta-M method").
#[derive(Clone, Debug, PartialEq)]
pub struct DeltaM {
    /// Share of the scattered light that goes into the peak and counts as not scattered.
    pub forward: f64,
    /// Scaled moments `chi'_0 = 1 .. chi'_order`, each within -1 to 1.
    pub moments: Vec<f64>,
}

impl Phase {
    /// The phase function that the deck pass draws with (weights and lobes of `passes::deck`).
    pub const DECK: Self = Self::CornetteShanks([(0.75, 0.70), (0.25, -0.25)]);

    /// Its value at the cosine of the scattering angle, 1/sr.
    pub fn value(self, cosine: f64) -> f64 {
        let peak = |g: f64| {
            let d = (1.0 + g * g - 2.0 * g * cosine).max(1e-30);
            (1.0 - g * g) / (d * d.sqrt())
        };
        match self {
            Self::HenyeyGreenstein(g) => peak(g) / (4.0 * PI),
            Self::CornetteShanks(lobes) => {
                let sum: f64 =
                    lobes.iter().map(|(w, f)| w * 1.5 / (2.0 + f * f) * (1.0 + cosine * cosine) * peak(*f)).sum();
                sum / (4.0 * PI)
            }
        }
    }

    /// Adds `weight` times its values at many cosines: [`Phase::value`] in f32, for whole lists.
    #[inline(always)]
    pub fn add_values(self, cosines: &[f32], weight: f32, out: &mut [f32]) {
        // Both kinds are sums of k (1 + c x^2) / (1 + g^2 - 2 g x)^(3/2).
        let (lobes, squared) = match self {
            Self::HenyeyGreenstein(g) => ([(1.0, g), (0.0, 0.0)], 0.0),
            Self::CornetteShanks(lobes) => (lobes, 1.0),
        };
        for (share, g) in lobes {
            if share == 0.0 {
                continue;
            }
            let norm = if squared == 0.0 { 1.0 } else { 1.5 / (2.0 + g * g) };
            let k = weight * (share * norm * (1.0 - g * g) / (4.0 * PI)) as f32;
            let (a, b, c) = ((1.0 + g * g) as f32, (2.0 * g) as f32, squared as f32);
            for (x, out) in cosines.iter().zip(out.iter_mut()) {
                let d = (a - b * x).max(1e-12);
                *out += k * (1.0 + c * x * x) / (d * d.sqrt());
            }
        }
    }

    /// Legendre moments `chi_0 = 1 .. chi_order`: means of `P_l` of the cosine.
    pub fn moments(self, order: usize) -> Vec<f64> {
        match self {
            Self::HenyeyGreenstein(g) => (0..=order).map(|l| g.powi(l as i32)).collect(),
            Self::CornetteShanks(lobes) => (0..=order)
                .map(|l| {
                    // The mean of x^2 P_l under Henyey-Greenstein, by x P_l = ((l+1) P_l+1 + l P_l-1) / (2 l + 1) twice.
                    let k = l as f64;
                    let up = (k + 1.0) * (k + 2.0) / ((2.0 * k + 1.0) * (2.0 * k + 3.0));
                    let same = (k + 1.0) * (k + 1.0) / ((2.0 * k + 1.0) * (2.0 * k + 3.0))
                        + if l > 0 { k * k / ((2.0 * k + 1.0) * (2.0 * k - 1.0)) } else { 0.0 };
                    let down = if l > 1 { k * (k - 1.0) / ((2.0 * k + 1.0) * (2.0 * k - 1.0)) } else { 0.0 };
                    lobes
                        .iter()
                        .map(|(w, f)| {
                            let g = |n: i32| f.powi(n);
                            let square = up * g(l as i32 + 2)
                                + same * g(l as i32)
                                + if l > 1 { down * g(l as i32 - 2) } else { 0.0 };
                            w * 1.5 / (2.0 + f * f) * (g(l as i32) + square)
                        })
                        .sum()
                })
                .collect(),
        }
    }

    /// Mean cosine of the scattering angle.
    pub fn asymmetry(self) -> f64 {
        self.moments(1)[1]
    }

    /// The scaling for transport with harmonics up to `order`. A phase function that scatters backwards keeps its
    /// moments: cutting a forward peak that is not there would give moments beyond 1.
    pub fn delta_m(self, order: usize) -> DeltaM {
        let chi = self.moments(order + 1);
        let forward = chi[order + 1].clamp(0.0, 0.999_999);
        let scaled = |f: f64| chi[..=order].iter().map(|c| (c - f) / (1.0 - f)).collect::<Vec<_>>();
        let moments = scaled(forward);
        if moments.iter().all(|c| c.abs() <= 1.0) {
            DeltaM { forward, moments }
        } else {
            DeltaM { forward: 0.0, moments: scaled(0.0) }
        }
    }

    /// A random cosine of the scattering angle.
    pub fn sample(self, random: &mut Stream) -> f64 {
        match self {
            Self::HenyeyGreenstein(g) => sample_henyey_greenstein(g, random.unit()),
            Self::CornetteShanks(lobes) => {
                let f = if random.unit() < lobes[0].0 { lobes[0].1 } else { lobes[1].1 };
                // Rejection from Henyey-Greenstein: the ratio is (1 + cos^2) / 2 at most 1, so half the draws and more pass.
                for _ in 0..64 {
                    let cosine = sample_henyey_greenstein(f, random.unit());
                    if 2.0 * random.unit() < 1.0 + cosine * cosine {
                        return cosine;
                    }
                }
                f.signum()
            }
        }
    }

    /// What is wrong with the parameters, if anything.
    pub fn fault(self) -> Option<&'static str> {
        let within = |g: f64| g.is_finite() && g.abs() < 1.0;
        match self {
            Self::HenyeyGreenstein(g) if !within(g) => Some("the asymmetry is not between -1 and 1"),
            Self::CornetteShanks(lobes) => {
                if lobes.iter().any(|(w, f)| !within(*f) || !(0.0..=1.0).contains(w)) {
                    Some("a lobe's weight or factor is out of range")
                } else if (lobes[0].0 + lobes[1].0 - 1.0).abs() > 1e-9 {
                    Some("the weights of the lobes do not sum to 1")
                } else {
                    None
                }
            }
            Self::HenyeyGreenstein(_) => None,
        }
    }
}

impl DeltaM {
    /// Factor on the extinction: `1 - albedo f`.
    pub fn extinction_factor(&self, albedo: f64) -> f64 {
        1.0 - albedo * self.forward
    }

    /// Albedo of the scaled medium.
    pub fn albedo(&self, albedo: f64) -> f64 {
        albedo * (1.0 - self.forward) / self.extinction_factor(albedo)
    }

    /// The scaled phase function, 1/sr; may be slightly negative where the series is cut.
    pub fn value(&self, cosine: f64) -> f64 {
        let p = legendre(cosine, self.moments.len() - 1);
        self.moments.iter().zip(p).enumerate().map(|(l, (c, p))| (2 * l + 1) as f64 / (4.0 * PI) * c * p).sum()
    }
}

fn sample_henyey_greenstein(g: f64, u: f64) -> f64 {
    if g.abs() < 1e-4 {
        return 2.0 * u - 1.0;
    }
    let d = (1.0 - g * g) / (1.0 - g + 2.0 * g * u);
    ((1.0 + g * g - d * d) / (2.0 * g)).clamp(-1.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CASES: [Phase; 6] = [
        Phase::HenyeyGreenstein(0.0),
        Phase::HenyeyGreenstein(0.6),
        Phase::HenyeyGreenstein(0.85),
        Phase::HenyeyGreenstein(-0.9),
        Phase::CornetteShanks([(1.0, 0.85), (0.0, 0.0)]),
        Phase::DECK,
    ];

    /// Integral over the cosine by the midpoint rule, in the angle so that peaks are resolved.
    fn mean(phase: Phase, weigh: impl Fn(f64) -> f64) -> f64 {
        let n = 20_000;
        (0..n)
            .map(|i| {
                let angle = (i as f64 + 0.5) / n as f64 * PI;
                2.0 * PI * phase.value(angle.cos()) * weigh(angle.cos()) * angle.sin() * PI / n as f64
            })
            .sum()
    }

    #[test]
    fn moments_are_those_of_the_value() {
        for phase in CASES {
            for (l, moment) in phase.moments(5).into_iter().enumerate() {
                let integral = mean(phase, |x| legendre(x, l)[l]);
                // The midpoint rule of 20,000 points on a peak 0.1 rad wide.
                assert!((integral - moment).abs() < 1e-6, "{phase:?} {l}: {integral} {moment}");
            }
        }
        // Wang et al. 2012 eq. 10 with f = 0.85 has an asymmetry of 0.885, not 0.85.
        assert!((CASES[4].asymmetry() - 0.885).abs() < 5e-4);
    }

    #[test]
    fn lists_of_values_are_the_values() {
        let cosines = [-1.0_f32, -0.3, 0.0, 0.7, 0.99];
        for phase in CASES {
            let mut out = [1.0; 5];
            phase.add_values(&cosines, 2.0, &mut out);
            for (x, v) in cosines.iter().zip(out) {
                // Rounding of f32 where 1 + g^2 - 2 g x cancels to a hundredth.
                let exact = 1.0 + 2.0 * phase.value(f64::from(*x));
                assert!((f64::from(v) / exact - 1.0).abs() < 2e-4, "{phase:?} {x}");
            }
        }
    }

    #[test]
    fn samples_have_the_moments_of_the_phase_function() {
        for phase in CASES {
            let mut random = Stream::new(5, 0);
            let n = 40_000;
            let mean = (0..n).map(|_| phase.sample(&mut random)).sum::<f64>() / f64::from(n);
            // The standard deviation of a cosine is at most 1: five standard errors.
            assert!((mean - phase.asymmetry()).abs() < 5.0 / f64::from(n).sqrt(), "{phase:?}: {mean}");
        }
    }

    #[test]
    fn delta_m_keeps_the_moments_of_the_scattering() {
        for phase in CASES {
            let scaled = phase.delta_m(3);
            for (l, chi) in phase.moments(3).into_iter().enumerate() {
                // f of the light goes on, the rest scatters by the scaled function.
                let sum = scaled.forward + (1.0 - scaled.forward) * scaled.moments[l];
                assert!((sum - chi).abs() < 1e-12 && scaled.moments[l].abs() <= 1.0);
            }
        }
        let scaled = Phase::HenyeyGreenstein(0.85).delta_m(3);
        assert!((scaled.forward - 0.85_f64.powi(4)).abs() < 1e-12);
        // Similarity: absorption is the same in the scaled medium.
        let (sigma, albedo) = (scaled.extinction_factor(0.9), scaled.albedo(0.9));
        assert!((sigma * (1.0 - albedo) - 0.1).abs() < 1e-12);
    }

    #[test]
    fn bad_parameters_are_named() {
        for bad in [1.0, -1.0, f64::NAN, 2.0] {
            assert!(Phase::HenyeyGreenstein(bad).fault().is_some());
            assert!(Phase::CornetteShanks([(0.5, bad), (0.5, 0.0)]).fault().is_some());
        }
        assert!(Phase::CornetteShanks([(0.5, 0.1), (0.6, 0.0)]).fault().is_some());
        assert!(CASES.iter().all(|p| p.fault().is_none()));
    }
}
