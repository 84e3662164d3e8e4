//! Elementary functions from the four basic operations alone, so that every machine rounds them alike.
//!
//! The standard library passes `ln`, `exp` and `cos` to the platform, whose last bit differs from system to system; a random
//! choice between two nearly equal weights could then fall differently. These are branch-free, so compilers vectorise them.

use std::f64::consts::LN_2;

/// ln 2 split in two: the first part has 21 trailing zero bits, so that its product with an exponent is exact.
const LN_2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
/// 1.5 * 2^52: adding and subtracting it rounds to the nearest integer.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// Below this [`exp`] is 0: no subnormal numbers, whose handling differs from machine to machine.
const UNDERFLOW: f64 = -708.0;
/// Above this [`exp`] is infinite.
const OVERFLOW: f64 = 709.0;

/// Natural logarithm of a positive, finite, normal number; within 2 units in the last place.
#[inline(always)]
pub fn ln(x: f64) -> f64 {
    // x = m 2^e with m in [sqrt(1/2), sqrt(2)), then ln m = 2 artanh((m - 1) / (m + 1)).
    let bits = x.to_bits().wrapping_sub(0x3fe6_a09e_667f_3bcd);
    let e = (bits as i64 >> 52) as f64;
    let m = f64::from_bits((bits & 0x000f_ffff_ffff_ffff).wrapping_add(0x3fe6_a09e_667f_3bcd));
    let f = (m - 1.0) / (m + 1.0);
    let s = f * f;
    let mut p = 1.0 / 23.0;
    for odd in [21.0, 19.0, 17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0] {
        p = p * s + 1.0 / odd;
    }
    e * LN_2_HIGH + (2.0 * f + (2.0 * f * s * p + e * LN_2_LOW))
}

/// Exponential function; within 2 units in the last place, 0 below -708, infinite above 709.
#[inline(always)]
pub fn exp(x: f64) -> f64 {
    let bounded = x.clamp(UNDERFLOW, OVERFLOW);
    let k = (bounded * (1.0 / LN_2) + ROUND) - ROUND;
    let r = (bounded - k * LN_2_HIGH) - k * LN_2_LOW;
    // Taylor about 0 for |r| <= ln(2)/2: the first term left out is 4e-18.
    let mut p = 1.0 / 6_227_020_800.0;
    for factorial in [479_001_600.0, 39_916_800.0, 3_628_800.0, 362_880.0, 40_320.0, 5_040.0, 720.0, 120.0, 24.0, 6.0] {
        p = p * r + 1.0 / factorial;
    }
    p = p * r + 0.5;
    p = p * r + 1.0;
    p = p * r + 1.0;
    // k + ROUND holds the integer k in its low bits: shifted up, they become the exponent of 2^k.
    let power = f64::from_bits((k + (ROUND + 1023.0)).to_bits() << 52);
    let value = p * power;
    let value = if x < UNDERFLOW { 0.0 } else { value };
    if x > OVERFLOW { f64::INFINITY } else { value }
}

/// `x` to the power `y` for positive normal `x`; relative error about |y ln x| 2^-53. 1 where `y` is 0.
#[inline(always)]
pub fn pow(x: f64, y: f64) -> f64 {
    exp(y * ln(x))
}

/// `x` to a small whole power by multiplication alone.
#[inline(always)]
pub fn powi(x: f64, n: u32) -> f64 {
    let mut value = 1.0;
    for _ in 0..n {
        value *= x;
    }
    value
}

/// cos(pi a / b) for `b` above 0; within 2 units in the last place.
pub fn cos_pi(a: u64, b: u64) -> f64 {
    // Whole numbers fold the angle into the first eighth of the circle without any rounding.
    let a = a % (2 * b);
    let a = if a > b { 2 * b - a } else { a };
    let (a, sign) = if 2 * a > b { (b - a, -1.0) } else { (a, 1.0) };
    let series = |x: f64, first: f64, skip: f64| {
        let s = x * x;
        let (mut term, mut sum) = (first, first);
        for n in 1..12 {
            let n = 2.0 * f64::from(n) + skip;
            term *= -s / (n * (n - 1.0));
            sum += term;
        }
        sum
    };
    let angle = |a: u64| std::f64::consts::PI * a as f64 / b as f64;
    if 4 * a <= b {
        sign * series(angle(a), 1.0, 0.0)
    } else {
        // cos(pi a / b) = sin(pi (b - 2a) / (2 b)).
        let x = angle(b - 2 * a) * 0.5;
        sign * series(x, x, 1.0)
    }
}

/// Cosine and sine of an angle in turns, rounded to 2^-32 of a turn (1.5e-9 rad).
pub fn cos_sin_turns(turns: f64) -> (f64, f64) {
    const TURN: u64 = 1 << 32;
    // A negative angle wraps round as its two's complement.
    let k = (turns * TURN as f64).round() as i64 as u64 % TURN;
    (cos_pi(k, TURN / 2), cos_pi((k + TURN / 4 * 3) % TURN, TURN / 2))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative distance in units of 2^-52.
    fn ulps(found: f64, expected: f64) -> f64 {
        (found - expected).abs() / (expected.abs() * f64::EPSILON)
    }

    #[test]
    fn they_agree_with_the_platform_to_a_few_last_bits() {
        // Two units in the last place of ours, one of the platform's.
        for k in -3000..3000 {
            let x = 1.003_f64.powi(k) * (1.0 + 1e-3 * f64::from(k % 7));
            if (x - 1.0).abs() > 1e-3 {
                assert!(ulps(ln(x), x.ln()) < 3.0, "ln {x}");
            }
            let y = f64::from(k) * 0.236;
            if y > UNDERFLOW && y < OVERFLOW {
                assert!(ulps(exp(y), y.exp()) < 3.0, "exp {y}: {} {}", exp(y), y.exp());
            }
        }
        assert_eq!((exp(0.0), ln(1.0), exp(-1e4), exp(1e4)), (1.0, 0.0, 0.0, f64::INFINITY));
        assert!(ulps(exp(UNDERFLOW), UNDERFLOW.exp()) < 3.0 && ulps(exp(OVERFLOW), OVERFLOW.exp()) < 3.0);
    }

    #[test]
    fn powers_of_the_range_that_channels_use() {
        for (x, y) in [(2.0, 0.5), (1.7e5, -10.0), (3.0, -0.05), (1e-120, 2.5), (5.0, 20.0), (7.0, 0.0)] {
            // y ln x is rounded at 2^-53 of its size, which exp turns into a relative error.
            let bound = 4.0 + (y * f64::ln(x)).abs();
            assert!(ulps(pow(x, y), x.powf(y)) < bound, "{x}^{y}");
        }
        assert_eq!(powi(3.0, 4), 81.0);
    }

    #[test]
    fn cosines_of_whole_fractions() {
        assert_eq!((cos_pi(0, 5), cos_pi(1, 2), cos_pi(7, 7), cos_pi(4, 2)), (1.0, 0.0, -1.0, 1.0));
        for b in [3_u64, 7, 33, 129] {
            for a in 0..5 * b {
                let x = std::f64::consts::PI * a as f64 / b as f64;
                // The platform's own argument is rounded: its error is that of x, up to 16 * 2^-53.
                assert!((cos_pi(a, b) - x.cos()).abs() < 4e-15, "{a}/{b}");
            }
        }
    }

    #[test]
    fn turns_are_cosine_and_sine() {
        for k in -40..40 {
            let turns = f64::from(k) * 0.0371;
            let (cos, sin) = cos_sin_turns(turns);
            let x = std::f64::consts::TAU * turns;
            // The angle is rounded by up to half of 1.5e-9.
            assert!((cos - x.cos()).abs() < 8e-10 && (sin - x.sin()).abs() < 8e-10, "{turns}");
        }
    }
}
