//! From peak current to light: how much luminous energy a stroke gives, how it comes out in time and along the channel.
//!
//! The chain, with what is known of each link:
//!
//! 1. peak current -> optical energy, 0.4 to 1.1 micrometres: [`OPTICAL_JOULES_PER_KA`]. Single strokes of one current scatter
//!    by a factor of three and more about the mean (Guo and Krider: 2.3e9 W at the peak, with a standard deviation of 1.8e9 W).
//! 2. optical -> luminous energy: [`LUMENS_PER_OPTICAL_WATT`], within a third.
//! 3. luminous energy -> power in time: [`stroke_share`]. Rise and decay are shorter than any frame, so that pictures depend on
//!    the energy alone. Near the channel light decays faster (Guo and Krider: energy over peak power is 160 microseconds).
//! 4. luminous flux -> luminous intensity per metre of channel: [`intensity_per_metre_cd`]. The channel radiates alike in all
//!    directions (optically thin; were it thick, a metre seen end-on would give nothing and one from the side 4/pi times as
//!    much), and its light is spread over its length by brightness.
//!
//! All links together: a factor of about four either way for a single stroke, and about two for the mean of many.

/// Optical energy in joules per kiloampere of peak current, 0.4 to 1.1 micrometres.
///
/// Guo and Krider (1982), "The optical and radiation field signatures produced by lightning return strokes": first strokes
/// radiate some 3.7e5 J in the mean, taken at the median first current of 30 kA. Proportion to the peak current is the
/// simplest of the relations that the measurements allow (peak light against peak current of triggered strokes: a linear, a
/// square and a power law fit alike).
pub const OPTICAL_JOULES_PER_KA: f64 = 3.7e5 / 30.0;

/// Lumens per watt of optical power, 0.4 to 1.1 micrometres.
///
/// Luminous efficacy of a black body of 24,000 K (Orville 1968) within that band, 683 lm/W times the share that
/// V(lambda) weighs; a test integrates it. Lines and cooling move the truth by perhaps a third.
pub const LUMENS_PER_OPTICAL_WATT: f64 = 163.0;

/// Rise of a stroke's light in seconds: tens of microseconds, well under a millisecond.
pub const RISE_S: f64 = 5e-5;
/// Decay of a stroke's light in seconds: about a millisecond, seen from outside the cloud.
pub const DECAY_S: f64 = 1e-3;
/// After so many decay times nothing is left that counts: exp(-24) is 4e-11 of the energy.
pub const DECAYS_TO_DARK: f64 = 24.0;

/// Light of a continuing current relative to the same current at the peak of a stroke: 1, as a plain proportion.
/// (A steady arc may give less; no measurement is known that would settle it.)
const CONTINUING_CURRENT_LIGHT: f64 = 1.0;

/// Length of a dart leader in seconds: some kilometres of old channel at 1e6 to 2e7 m/s take 0.2 to 5 ms.
pub const DART_LEADER_S: f64 = 2e-3;
/// Luminous energy of a dart leader as a share of its stroke's.
///
/// At its peak a tenth of the stroke's light at the same place (0.02 to 0.23: Idone and Orville 1985, JGR 90 6159). Were only its
/// head of 35 m to shine (Mach and Rust 1997, JGR 102 11021), that would be 3e-4 of the energy; were the channel behind it as
/// bright, 0.08. That channel is seen, fainter than the head: 0.03 is taken, right within a factor of ten below and three above.
pub const DART_LEADER_SHARE: f64 = 0.03;
/// Luminous energy of a stepped leader as a share of its stroke's: some 1e6 W for some 30 ms against 4e5 J. An assumption, good
/// to a factor of five; leaders are seen "faintly", and no absolute energies are known.
pub const STEPPED_LEADER_SHARE: f64 = 0.05;

/// Luminous energy of a stroke in lumen seconds.
pub fn luminous_energy_lm_s(peak_current_ka: f64) -> f64 {
    peak_current_ka * OPTICAL_JOULES_PER_KA * LUMENS_PER_OPTICAL_WATT
}

/// Luminous intensity in candela of a metre of channel of brightness 1, where this luminous flux is spread over a length (each
/// metre counted by its brightness, so that a whole channel gives the whole flux).
pub fn intensity_per_metre_cd(flux_lm: f64, bright_length_m: f64) -> f64 {
    flux_lm / (4.0 * std::f64::consts::PI * bright_length_m)
}

/// Luminous power in lumens that a steady current gives: the stroke's energy over its decay time, at the same current.
pub fn continuing_power_lm(current_ka: f64) -> f64 {
    luminous_energy_lm_s(current_ka) / DECAY_S * CONTINUING_CURRENT_LIGHT
}

/// Share of a stroke's luminous energy that has come out `after_s` seconds after its onset: closed form of the
/// difference of two exponentials, complete (1 exactly) when it is dark.
pub fn stroke_share(after_s: f64) -> f64 {
    if after_s <= 0.0 {
        return 0.0;
    }
    if after_s >= stroke_duration_s() {
        return 1.0;
    }
    1.0 - (DECAY_S * (-after_s / DECAY_S).exp() - RISE_S * (-after_s / RISE_S).exp()) / (DECAY_S - RISE_S)
}

/// Rate at which a stroke's luminous energy comes out, in shares per second: the derivative of [`stroke_share`].
#[cfg(test)]
pub(super) fn stroke_rate(after_s: f64) -> f64 {
    if after_s <= 0.0 || after_s >= stroke_duration_s() {
        return 0.0;
    }
    ((-after_s / DECAY_S).exp() - (-after_s / RISE_S).exp()) / (DECAY_S - RISE_S)
}

/// Seconds after which a stroke is dark.
pub fn stroke_duration_s() -> f64 {
    DECAYS_TO_DARK * DECAY_S
}

/// Share of a continuing current's light that has come out: it falls in a straight line to nothing over `length_s`.
pub fn continuing_share(after_s: f64, length_s: f64) -> f64 {
    if after_s <= 0.0 || length_s <= 0.0 {
        return 0.0;
    }
    let u = (after_s / length_s).min(1.0);
    u * (2.0 - u)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_efficacy_is_that_of_the_black_body() {
        // V(lambda) by Wyman, Sloan and Shirley (2013), "Simple analytic approximations to the CIE XYZ functions",
        // eq. for y: within 1 % of the integral. Planck's law in 1 nm steps.
        let planck = |nm: f64| {
            let x = 1.438_776_877e7 / (nm * 24_000.0);
            nm.powi(-5) / x.exp_m1()
        };
        let lobe = |nm: f64, mean: f64, below: f64, above: f64| {
            let t = (nm - mean) / if nm < mean { below } else { above };
            (-0.5 * t * t).exp()
        };
        let v = |nm: f64| 0.821 * lobe(nm, 568.8, 46.9, 40.5) + 0.286 * lobe(nm, 530.9, 16.3, 31.1);
        let (mut seen, mut all) = (0.0, 0.0);
        for nm in 400..1100 {
            let nm = f64::from(nm) + 0.5;
            seen += 683.0 * v(nm) * planck(nm);
            all += planck(nm);
        }
        let efficacy = seen / all;
        assert!((efficacy / LUMENS_PER_OPTICAL_WATT - 1.0).abs() < 0.02, "{efficacy}");
    }

    #[test]
    fn a_typical_first_stroke_has_the_power_that_is_seen() {
        // Optical power at the peak about 1e9 W (studies: 1e8 to 1e10).
        let peak_w =
            (0..1000).map(|k| stroke_rate(f64::from(k) * 1e-6)).fold(0.0, f64::max) * 30.0 * OPTICAL_JOULES_PER_KA;
        assert!((1e8..1e10).contains(&peak_w), "{peak_w}");
    }

    #[test]
    fn a_metre_of_a_typical_channel_has_the_power_that_is_seen() {
        // Guo and Krider 1982: 1e6 W/m in the mean of first strokes near the ground, when a stroke's light is 160 microseconds
        // long and its channel some 2.3 km (2.3e9 W at the peak). Energy is what counts here: 1e6 W/m for 160 us are 160 J/m.
        let metre_lm_s = 4.0 * std::f64::consts::PI * intensity_per_metre_cd(luminous_energy_lm_s(30.0), 2_300.0);
        let joules_per_metre = metre_lm_s / LUMENS_PER_OPTICAL_WATT;
        // The factor of two of the chain's mean.
        assert!((80.0..320.0).contains(&joules_per_metre), "{joules_per_metre}");
    }

    #[test]
    fn the_share_is_the_integral_of_the_rate() {
        let step = 1e-7;
        let mut sum = 0.0;
        for k in 0..240_000 {
            sum += stroke_rate((f64::from(k) + 0.5) * step) * step;
            if k % 1000 == 0 {
                let share = stroke_share(f64::from(k + 1) * step);
                // Midpoint rule: h^2/24 times the change of the slope (4e8 / s^2 at the onset): 2e-7.
                assert!((share - sum).abs() < 1e-6, "{k}: {share} {sum}");
            }
        }
        assert_eq!(stroke_share(stroke_duration_s()), 1.0);
        assert_eq!((continuing_share(0.0, 0.1), continuing_share(0.2, 0.1)), (0.0, 1.0));
    }
}
