//! Thunder as a sound: the sum of the pulses' waves, each dulled by its way through the air.
//!
//! A pulse is the mean of an N-wave over its spread, and a sample the mean of that over its own length: both in closed form, so that
//! nothing aliases and no pressure is left over. The air's loss depends on frequency and distance: pulses of like distance are
//! gathered, and each gathering is filtered once.

use super::Pulse;
use super::air::Air;

/// Length of the filter in samples: resolves 43 Hz at 22,050 samples a second.
const TAPS: usize = 513;
/// Pulses are gathered over a tenth of their distance, in which the loss hardly differs, and no finer than this.
const FINEST_M: f64 = 100.0;
/// Longest sound in seconds: 25 km of way and several strokes; later pulses are left out.
const LONGEST_S: f64 = 120.0;

/// A sound.
#[derive(Clone, Debug, PartialEq)]
pub struct Wave {
    /// Samples a second.
    pub rate_hz: u32,
    /// Seconds after the flash begins at which it begins.
    pub begin_s: f64,
    /// Overpressure in pascals.
    pub pressure_pa: Vec<f32>,
}

/// The sound of pulses; empty when there are none.
pub fn wave(pulses: &[Pulse], air: &Air, rate_hz: u32) -> Wave {
    let rate = f64::from(rate_hz);
    let half = TAPS / 2;
    let first_s = pulses.iter().map(|pulse| pulse.arrival_s).fold(f64::INFINITY, f64::min);
    if first_s.is_infinite() {
        return Wave { rate_hz, begin_s: 0.0, pressure_pa: Vec::new() };
    }
    let begin_s = first_s - (half + 1) as f64 / rate;
    let end = |pulse: &Pulse| pulse.arrival_s + pulse.spread_s + pulse.period_s;
    let last_s = pulses.iter().map(end).fold(0.0, f64::max).min(begin_s + LONGEST_S);
    let samples = ((last_s - begin_s) * rate) as usize + half + 2;
    let mut pressure = vec![0.0_f32; samples];
    let mut ordered: Vec<&Pulse> = pulses.iter().filter(|pulse| end(pulse) <= last_s).collect();
    ordered.sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
    let mut rest = &ordered[..];
    while let Some(nearest) = rest.first() {
        let until_m = nearest.distance_m + (0.1 * nearest.distance_m).max(FINEST_M);
        let (gathered, farther) = rest.split_at(rest.partition_point(|pulse| pulse.distance_m < until_m));
        rest = farther;
        let filter = filter(air, 0.5 * (nearest.distance_m + until_m), rate);
        // Strokes come one after another: only where something is heard is anything to be filtered.
        let mut dry = vec![0.0_f32; samples];
        let mut stretches: Vec<[usize; 2]> = Vec::new();
        for pulse in gathered {
            stretches.push(add(pulse, &mut dry, begin_s, rate));
        }
        stretches.sort_unstable();
        let mut done = 0;
        for [from, to] in stretches {
            for at in from.max(done)..to {
                let value = dry[at];
                if value != 0.0 {
                    let low = at - half.min(at);
                    let high = (at + half + 1).min(samples);
                    for (out, tap) in pressure[low..high].iter_mut().zip(&filter[low + half - at..]) {
                        *out += value * tap;
                    }
                }
            }
            done = done.max(to);
        }
    }
    Wave { rate_hz, begin_s, pressure_pa: pressure }
}

/// Adds a pulse; the samples that it touches.
fn add(pulse: &Pulse, samples: &mut [f32], begin_s: f64, rate: f64) -> [usize; 2] {
    let since_s = |sample: usize| begin_s + sample as f64 / rate - pulse.arrival_s;
    let from = (((pulse.arrival_s - begin_s) * rate) as usize).min(samples.len());
    let length_s = pulse.spread_s + pulse.period_s;
    let to = (from + (length_s * rate) as usize + 2).min(samples.len());
    for (sample, value) in samples.iter_mut().enumerate().take(to).skip(from) {
        let (a, b) = (since_s(sample), since_s(sample) + 1.0 / rate);
        let mean = if pulse.spread_s * rate > 1e-3 {
            let twice =
                |t: f64| second_integral(t, pulse.period_s) - second_integral(t - pulse.spread_s, pulse.period_s);
            (twice(b) - twice(a)) / pulse.spread_s
        } else {
            integral(b, pulse.period_s) - integral(a, pulse.period_s)
        };
        *value += (pulse.side_pa * mean * rate) as f32;
    }
    [from, to]
}

/// Integral of the N-wave 1 - 2 t / period from its onset.
fn integral(t: f64, period_s: f64) -> f64 {
    let t = t.clamp(0.0, period_s);
    t * (1.0 - t / period_s)
}

/// Integral of that.
fn second_integral(t: f64, period_s: f64) -> f64 {
    let t = t.clamp(0.0, period_s);
    t * t * (0.5 - t / (3.0 * period_s))
}

/// What a distance of air does, as a symmetric filter: the inverse transform of the loss, under a Hann window.
fn filter(air: &Air, distance_m: f64, rate: f64) -> Vec<f32> {
    let half = TAPS / 2;
    let gain: Vec<f64> = (0..=half)
        .map(|k| 10_f64.powf(-air.loss_db_per_m(k as f64 / TAPS as f64 * rate) * distance_m / 20.0))
        .collect();
    let tap = |n: usize| {
        let turn = std::f64::consts::TAU * n as f64 / TAPS as f64;
        let sum: f64 = gain.iter().enumerate().skip(1).map(|(k, gain)| 2.0 * gain * (turn * k as f64).cos()).sum();
        let window = 0.5 + 0.5 * (std::f64::consts::PI * n as f64 / (half + 1) as f64).cos();
        window * (gain[0] + sum) / TAPS as f64
    };
    let side: Vec<f64> = (0..=half).map(tap).collect();
    (0..TAPS).map(|at| side[at.abs_diff(half)] as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Path, chords, pulses};
    use super::*;

    const RATE: u32 = 22_050;

    fn pulse(spread_s: f64) -> Pulse {
        Pulse {
            arrival_s: 3.0,
            spread_s,
            period_s: 0.008,
            distance_m: 1_000.0,
            direction: [1.0, 0.0, 0.0],
            side_pa: 20.0,
            level_db: 120.0,
        }
    }

    fn clear() -> Air {
        Air { loss: false, ..Air::default() }
    }

    #[test]
    fn one_pulse_is_an_n_wave_of_its_amplitude_length_and_time() {
        let sound = wave(&[pulse(0.0)], &clear(), RATE);
        let at = |t: f64| sound.pressure_pa[((t - sound.begin_s) * f64::from(RATE)) as usize];
        // Samples are means over 45 microseconds, over which the wave falls by 1.1 % of its height.
        assert!((at(3.0002) - 20.0 * (1.0 - 0.05)).abs() < 0.3, "{}", at(3.0002));
        assert!(at(3.004).abs() < 0.3 && (at(3.0078) + 19.0).abs() < 0.3);
        // The filter without loss is a single tap; the rest is rounding.
        assert!(at(2.999).abs() < 1e-3 && at(3.0085).abs() < 1e-3);
        let sum: f64 = sound.pressure_pa.iter().map(|&p| f64::from(p)).sum();
        assert!((sum / 20.0).abs() < 1e-2, "no pressure is left over: {sum}");
        let square: f64 = sound.pressure_pa.iter().map(|&p| f64::from(p) * f64::from(p)).sum::<f64>() / f64::from(RATE);
        // A third of height squared times length; sample means lose a little at the edges (2 of 176 samples).
        assert!((square / (400.0 * 0.008 / 3.0) - 1.0).abs() < 0.01, "{square}");
        assert_eq!(wave(&[], &clear(), RATE).pressure_pa.len(), 0);
    }

    #[test]
    fn a_spread_out_pulse_is_two_bumps_of_a_quarter_of_the_period_over_the_spread() {
        let sound = wave(&[pulse(0.1)], &clear(), RATE);
        let greatest = sound.pressure_pa.iter().copied().fold(f32::MIN, f32::max);
        let least = sound.pressure_pa.iter().copied().fold(f32::MAX, f32::min);
        // Wright and Medendorp: 20 Pa * 0.25 * 8 / 100 ms; the top of a parabola loses nothing in a sample.
        assert!((greatest / 0.4 - 1.0).abs() < 0.01 && (least / -0.4 - 1.0).abs() < 0.01, "{greatest} {least}");
        let place = |value: f32| sound.pressure_pa.iter().position(|&p| p == value).expect("there") as f64;
        assert!(((place(least) - place(greatest)) / f64::from(RATE) - 0.1).abs() < 1e-3, "one from either end");
    }

    #[test]
    fn the_air_dulls_the_sound_by_the_loss_at_each_frequency() {
        let air = Air::default();
        for distance_m in [500.0, 5_000.0] {
            let filter = filter(&air, distance_m, f64::from(RATE));
            for frequency_hz in [86.0, 430.0, 1_000.0] {
                let turn = std::f64::consts::TAU * frequency_hz / f64::from(RATE);
                let half = (TAPS / 2) as f64;
                let gain: f64 =
                    filter.iter().enumerate().map(|(n, &h)| f64::from(h) * (turn * (n as f64 - half)).cos()).sum();
                let expected = 10_f64.powf(-air.loss_db_per_m(frequency_hz) * distance_m / 20.0);
                // The window smooths the gain over 43 Hz.
                assert!((gain - expected).abs() < 0.02, "{distance_m} m, {frequency_hz} Hz: {gain} {expected}");
            }
        }
    }

    #[test]
    fn a_channel_is_heard_from_its_first_to_its_last_arrival() {
        let air = Air { lapse_k_per_m: 0.0, ..Air::default() };
        let channel = chords(&[Path { points_m: vec![[0.0, 0.0, 0.0], [0.0, 0.0, 3_000.0]], share: 1.0 }]);
        let heard = pulses(&channel, 0.0, 30.0, [1_000.0, 0.0, 0.0], &air);
        let sound = wave(&heard, &air, 8_000);
        assert!(sound.pressure_pa.iter().all(|p| p.is_finite()));
        let loud = |p: &&f32| p.abs() > 0.02;
        let first = sound.pressure_pa.iter().position(|p| loud(&p)).expect("thunder") as f64 / 8_000.0 + sound.begin_s;
        let last = sound.pressure_pa.iter().rposition(|p| loud(&p)).expect("thunder") as f64 / 8_000.0 + sound.begin_s;
        let c = air.speed_mps(0.0);
        // The air rounds the onset by some milliseconds; the last wave lasts its period longer.
        assert!((first - 1_000.0 / c).abs() < 0.01, "{first}");
        assert!((last - 1_000_f64.hypot(3_000.0) / c).abs() < 0.03, "{last}");
    }
}
