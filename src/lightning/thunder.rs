//! Thunder: when, from where and how loud each piece of a channel is heard by a listener.
//!
//! What it is: a channel heats its air to a shock, which at a distance is an N-wave (Few 1969, JGR 74 6926, "Power spectrum of
//! thunder"). Tortuosity makes every piece of channel a source of its own: one that is seen from the side claps, one that is seen
//! end-on rumbles, because its ends are heard one after the other (Wright and Medendorp 1968, JASA 43 966; Ribner and Roy 1982,
//! JASA 72 1911). How it is computed: the channel is cut into chords ([`chords`]); each gives a [`Pulse`], an N-wave drawn
//! out over the time between the arrivals of its ends. [`heard`] does it for a whole flash. How it is read: [`summary`] for a message, [`wave::wave`] for a sound.
//!
//! Rays are straight and the temperature falls evenly with height; wind, refraction (which is why thunder is not heard beyond some
//! 25 km, [`FARTHEST_M`]) and the echo of the ground are left out.

pub mod air;
pub mod heard;
pub mod wave;

use air::Air;
use glam::DVec3;

/// Beyond this distance no thunder is heard: sound bends upwards (Few 1982: 25 km at most).
pub const FARTHEST_M: f64 = 25_000.0;
/// Longest chord: pieces of a channel turn every 5 to 70 m (Few; Ribner and Roy).
pub const CHORD_M: f64 = 50.0;
/// Nobody is nearer to a channel, as far as the far field of a shock reaches.
const NEAREST_M: f64 = 10.0;
/// Energy of a metre of channel of a stroke of 30 kA, J/m, in proportion to the current: Few (1969) has 1e5 to 1e6.
const ENERGY_J_PER_M: f64 = 5e5;
const ENERGY_CURRENT_KA: f64 = 30.0;
/// Share of that energy that becomes sound (Holmes, Brook, Krehbiel and McCrory 1971, JGR 76 2106: 0.18 %).
const SOUND_SHARE: f64 = 0.0018;
/// Pressure from which levels in decibels count, Pa.
const REFERENCE_PA: f64 = 20e-6;

/// A line of channel that conducted some strokes.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// Its points in metres; the third axis points up, 0 is the ground.
    pub points_m: Vec<[f64; 3]>,
    /// Its share of the strokes' current: 1 on the main channel.
    pub share: f64,
}

/// A straight piece of channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chord {
    /// One end.
    pub from_m: [f64; 3],
    /// The other.
    pub to_m: [f64; 3],
    /// Its share of the strokes' current.
    pub share: f64,
}

/// What a listener gets of one chord in one stroke.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// Seconds after the flash begins at which it begins to be heard.
    pub arrival_s: f64,
    /// Seconds from the arrival of the nearest point of the chord to that of the farthest.
    pub spread_s: f64,
    /// Length of the N-wave of any one point.
    pub period_s: f64,
    /// Distance of the nearest point.
    pub distance_m: f64,
    /// Unit vector towards its middle.
    pub direction: [f64; 3],
    /// Peak overpressure in pascals that the chord would have, were it seen from the side and the air without loss.
    pub side_pa: f64,
    /// Peak sound pressure level in decibels above 20 micropascals, with the air's loss at the N-wave's main frequency.
    pub level_db: f64,
}

/// Cuts paths into chords of [`CHORD_M`] at most; the ends of paths are kept.
pub fn chords(paths: &[Path]) -> Vec<Chord> {
    let mut found = Vec::new();
    for path in paths.iter().filter(|path| path.share > 0.0) {
        let Some(&first) = path.points_m.first() else { continue };
        let (mut from, mut last) = (first, first);
        let mut push = |from_m: [f64; 3], to_m: [f64; 3]| {
            if from_m != to_m {
                found.push(Chord { from_m, to_m, share: path.share });
            }
        };
        for &point in &path.points_m[1..] {
            if distance(from, point) > CHORD_M {
                push(from, last);
                from = last;
            }
            // A piece that is longer by itself is divided evenly.
            let parts = (distance(from, point) / CHORD_M).ceil().max(1.0) as u32;
            for part in 1..parts {
                let share = 1.0 / f64::from(parts - part + 1);
                let next = std::array::from_fn(|axis| from[axis] + (point[axis] - from[axis]) * share);
                push(from, next);
                from = next;
            }
            last = point;
        }
        push(from, last);
    }
    found
}

/// The pulses of a stroke that a listener hears, in the order of the chords; those from beyond [`FARTHEST_M`] are left out.
///
/// `at_s`: when the stroke is, after the flash begins. `listener_m` is in the axes of the chords.
pub fn pulses(chords: &[Chord], at_s: f64, current_ka: f64, listener_m: [f64; 3], air: &Air) -> Vec<Pulse> {
    let listener = DVec3::from_array(listener_m);
    let one = |chord: &Chord| {
        let [from, to] = [chord.from_m, chord.to_m].map(DVec3::from_array);
        let (along, length_m) = (to - from, (to - from).length());
        let nearest = from + along * ((listener - from).dot(along) / (length_m * length_m)).clamp(0.0, 1.0);
        let distance_m = listener.distance(nearest);
        if distance_m > FARTHEST_M || length_m <= 0.0 {
            return None;
        }
        let travel_s = |place: DVec3| air.travel_s(place.to_array(), listener_m);
        let (first_s, last_s) = (travel_s(nearest), travel_s(from).max(travel_s(to)));
        let middle = 0.5 * (from + to);
        let energy_j_per_m = ENERGY_J_PER_M * chord.share * current_ka / ENERGY_CURRENT_KA;
        let speed_mps = air.speed_mps(middle.z);
        // Few 1969, eq. 14: the main frequency of a cylindrical shock; the spectrum of an N-wave is greatest at 0.66 / period.
        let frequency_hz = 0.63 * speed_mps * (air.pressure_pa(middle.z) / energy_j_per_m).sqrt();
        let period_s = 0.66 / frequency_hz;
        // An N-wave of amplitude a / r carries 4 pi a^2 period / (3 rho c) through every sphere.
        let sound_j = SOUND_SHARE * energy_j_per_m * length_m;
        let amplitude = (3.0 * air.impedance(middle.z) * sound_j / (4.0 * std::f64::consts::PI * period_s)).sqrt();
        let side_pa = amplitude / distance_m.max(NEAREST_M);
        let spread_s = (last_s - first_s).max(0.0);
        let loss_db = air.loss_db_per_m(frequency_hz) * distance_m;
        let level_db = 20.0 * (side_pa * peak_share(spread_s, period_s) / REFERENCE_PA).log10() - loss_db;
        let direction = (middle - listener).normalize_or_zero().to_array();
        Some(Pulse { arrival_s: at_s + first_s, spread_s, period_s, distance_m, direction, side_pa, level_db })
    };
    chords.iter().filter_map(one).collect()
}

/// Greatest value of an N-wave of amplitude 1 drawn out over a spread: its mean over that time, in closed form.
fn peak_share(spread_s: f64, period_s: f64) -> f64 {
    if spread_s < 0.5 * period_s { 1.0 - spread_s / period_s } else { 0.25 * period_s / spread_s }
}

/// Pulses gathered by the time at which they are heard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rumble {
    /// Seconds after the flash begins at which the first of them is heard.
    pub arrival_s: f64,
    /// Distance of the loudest of them.
    pub distance_m: f64,
    /// Unit vector towards the loudest of them.
    pub direction: [f64; 3],
    /// Their levels added as energies, decibels.
    pub level_db: f64,
}

/// At most `most` rumbles, rising in time: the time from first to last arrival divided evenly, stretches of silence left out.
pub fn summary(pulses: &[Pulse], most: usize) -> Vec<Rumble> {
    let first_s = pulses.iter().map(|pulse| pulse.arrival_s).fold(f64::INFINITY, f64::min);
    let last_s = pulses.iter().map(|pulse| pulse.arrival_s).fold(f64::NEG_INFINITY, f64::max);
    let stretch_s = ((last_s - first_s) / most as f64).max(1e-9);
    let mut gathered: Vec<Vec<&Pulse>> = vec![Vec::new(); most];
    for pulse in pulses {
        let number = ((pulse.arrival_s - first_s) / stretch_s) as usize;
        gathered[number.min(most - 1)].push(pulse);
    }
    let rumble = |heard: Vec<&Pulse>| {
        let loudest = heard.iter().copied().max_by(|a, b| a.level_db.total_cmp(&b.level_db))?;
        let energy: f64 = heard.iter().map(|pulse| 10_f64.powf(0.1 * pulse.level_db)).sum();
        Some(Rumble {
            arrival_s: heard.iter().map(|pulse| pulse.arrival_s).fold(f64::INFINITY, f64::min),
            distance_m: loudest.distance_m,
            direction: loudest.direction,
            level_db: 10.0 * energy.log10(),
        })
    };
    gathered.into_iter().filter_map(rumble).collect()
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    DVec3::from_array(a).distance(DVec3::from_array(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn straight(from_m: [f64; 3], to_m: [f64; 3]) -> Vec<Chord> {
        chords(&[Path { points_m: vec![from_m, to_m], share: 1.0 }])
    }

    #[test]
    fn a_straight_channel_is_heard_from_its_nearest_to_its_farthest_point() {
        // Air of one temperature: 340.3 m/s (20.05 sqrt(288.15)).
        let air = Air { lapse_k_per_m: 0.0, ..Air::default() };
        let c = air.speed_mps(0.0);
        let channel = straight([0.0, 0.0, 0.0], [0.0, 0.0, 4_000.0]);
        assert_eq!(channel.len(), 80);
        for (listener, nearest_m, farthest_m) in [
            ([1_000.0, 0.0, 0.0], 1_000.0, 1_000_f64.hypot(4_000.0)),
            ([3_000.0, 4_000.0, 2_000.0], 5_000.0, 5_000_f64.hypot(2_000.0)),
            ([0.0, 0.0, 6_000.0], 2_000.0, 6_000.0),
        ] {
            let heard = pulses(&channel, 0.25, 30.0, listener, &air);
            let first_s = heard.iter().map(|pulse| pulse.arrival_s).fold(f64::INFINITY, f64::min);
            let last_s = heard.iter().map(|pulse| pulse.arrival_s + pulse.spread_s).fold(0.0, f64::max);
            // Closed forms; rounding of some 1e4 m / c.
            assert!((first_s - 0.25 - nearest_m / c).abs() < 1e-9, "{first_s}");
            assert!((last_s - 0.25 - farthest_m / c).abs() < 1e-9, "{last_s}");
            let near = heard.iter().map(|pulse| pulse.distance_m).fold(f64::INFINITY, f64::min);
            assert!((near - nearest_m).abs() < 1e-9);
        }
    }

    #[test]
    fn levels_fall_with_distance_and_end_on_and_are_what_is_measured() {
        let air = Air { loss: false, ..Air::default() };
        let chord = straight([0.0, -20.0, 10.0], [0.0, 20.0, 10.0]);
        let heard = |listener| pulses(&chord, 0.0, 30.0, listener, &air)[0];
        let [near, far] = [1_000.0, 2_000.0].map(|x| heard([x, 0.0, 10.0]));
        // Twice as far: 20 lg 2 = 6.02 dB. Even broadside the ends are heard later, by 0.6 and 0.3 ms of 6.8 ms, which takes 0.8
        // and 0.4 dB of them.
        let side_db = |pulse: &Pulse| pulse.level_db - 20.0 * peak_share(pulse.spread_s, pulse.period_s).log10();
        assert!((side_db(&near) - side_db(&far) - 6.0206).abs() < 1e-3, "{} {}", near.level_db, far.level_db);
        assert!((5.5..6.1).contains(&(near.level_db - far.level_db)));
        let end_on = heard([0.0, 1_020.0, 10.0]);
        // 40 m / 340 m/s = 118 ms against a period of some 8 ms: a quarter of 8 / 118.
        let expected = 20.0 * (0.25 * end_on.period_s / (40.0 / air.speed_mps(10.0))).log10();
        assert!((end_on.level_db - side_db(&near) - expected).abs() < 0.01, "{} {expected}", end_on.level_db);
        // Main frequencies of thunder from the ground: 40 to 150 Hz (Few 1969; Holmes et al. 1971).
        assert!((40.0..150.0).contains(&(0.66 / near.period_s)), "{}", near.period_s);
        // Some pascals to some tens are what is measured about a kilometre away: 100 to 130 dB.
        assert!((100.0..130.0).contains(&near.level_db), "{}", near.level_db);
        // Half the current: half the energy per metre in a pulse shorter by the root of that: 10 lg 2 - 5 lg 2.
        let weak = pulses(&chord, 0.0, 15.0, [1_000.0, 0.0, 10.0], &air)[0];
        assert!((side_db(&near) - side_db(&weak) - 1.505).abs() < 1e-3, "{}", weak.level_db);
        // The air takes more: 0.2 dB/km and more at 80 Hz.
        let lossy = pulses(&chord, 0.0, 30.0, [10_000.0, 0.0, 10.0], &Air::default())[0];
        let clear = heard([10_000.0, 0.0, 10.0]);
        assert!((1.0..8.0).contains(&(clear.level_db - lossy.level_db)), "{}", clear.level_db - lossy.level_db);
        assert_eq!(pulses(&chord, 0.0, 30.0, [26_000.0, 0.0, 0.0], &air), [], "too far to be heard");
    }

    #[test]
    fn the_sound_carries_the_share_of_the_energy_that_it_should() {
        let air = Air { loss: false, lapse_k_per_m: 0.0, ..Air::default() };
        let chord = straight([0.0, -20.0, 0.0], [0.0, 20.0, 0.0]);
        let pulse = pulses(&chord, 0.0, 30.0, [3_000.0, 0.0, 0.0], &air)[0];
        // 4 pi r^2 / (rho c) times the integral of p^2, a third of peak squared times the period.
        let sphere = 4.0 * std::f64::consts::PI * 3_000.0 * 3_000.0;
        let energy_j = sphere * pulse.side_pa * pulse.side_pa * pulse.period_s / 3.0 / air.impedance(0.0);
        assert!((energy_j / (0.0018 * 5e5 * 40.0) - 1.0).abs() < 1e-9, "{energy_j}");
    }

    #[test]
    fn chords_keep_ends_and_lengths_and_rumbles_keep_energy() {
        let zigzag: Vec<[f64; 3]> = (0..200).map(|k| [0.0, f64::from(k % 2) * 3.0, 5.0 * f64::from(k)]).collect();
        let long = vec![[0.0, 0.0, 0.0], [170.0, 0.0, 0.0]];
        let silent = Path { points_m: long.clone(), share: 0.0 };
        let paths = [Path { points_m: zigzag, share: 1.0 }, Path { points_m: long, share: 0.3 }, silent];
        let cut = chords(&paths);
        let lengths: Vec<f64> = cut.iter().map(|chord| distance(chord.from_m, chord.to_m)).collect();
        assert!(lengths.iter().all(|m| (5.0..=CHORD_M).contains(m)), "{lengths:?}");
        assert_eq!(cut.iter().filter(|chord| chord.share == 0.3).count(), 4);
        let total: f64 = cut.iter().zip(&lengths).filter(|(c, _)| c.share == 0.3).map(|(_, m)| m).sum();
        assert!((total - 170.0).abs() < 1e-9);
        let main: Vec<&Chord> = cut.iter().filter(|chord| chord.share == 1.0).collect();
        assert!(main.windows(2).all(|pair| pair[0].to_m == pair[1].from_m));
        assert_eq!((main[0].from_m, main[main.len() - 1].to_m), ([0.0; 3], [0.0, 3.0, 995.0]));
        assert_eq!(chords(&[Path { points_m: Vec::new(), share: 1.0 }]), []);

        let heard = pulses(&cut, 0.0, 30.0, [2_000.0, 0.0, 0.0], &Air::default());
        let energy = |levels: &mut dyn Iterator<Item = f64>| levels.map(|db| 10_f64.powf(0.1 * db)).sum::<f64>();
        let rumbles = summary(&heard, 8);
        assert!(rumbles.len() <= 8 && rumbles.windows(2).all(|pair| pair[0].arrival_s < pair[1].arrival_s));
        let before = energy(&mut heard.iter().map(|pulse| pulse.level_db));
        let after = energy(&mut rumbles.iter().map(|rumble| rumble.level_db));
        assert!((after / before - 1.0).abs() < 1e-9);
        assert_eq!(summary(&[], 8), []);
        assert_eq!(summary(&heard[..1], 8).len(), 1);
    }
}
