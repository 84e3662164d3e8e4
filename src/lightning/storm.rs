//! A storm as a schedule: which flash begins when and where, a function of its parameters, its seed and the time alone.
//!
//! Time is cut into slots of a second, and what begins in one follows from its number: a storm can be asked for any stretch of
//! time, in any order, by any number of channels, and says the same. Flashes come in bursts: over blocks of half a minute the
//! rate is either a quarter or three and a quarter times the mean (a Poisson process within each, so that counts scatter
//! twice as much as those of an even process and more; Mezuman, Price and Galanti 2014 find such clusters on all scales).

use super::flash::{FlashKind, Polarity, statistics::first_peak_current_ka};
use super::random::Stream;

/// Length of a slot in seconds.
const SLOT_S: f64 = 1.0;
/// Slots of one block, quiet or not.
const BLOCK_SLOTS: u64 = 30;
/// Factors on the rate in quiet blocks and in bursts, and the share of bursts: the mean is 1.
const QUIET: f64 = 0.25;
const BURST: f64 = 3.25;
const BURSTS: f64 = 0.25;
/// Most flashes of one slot, so that no argument makes it unbounded: at the highest rate 33 are the mean in a burst.
pub const MOST_IN_SLOT: u64 = 96;
/// Share of the flashes without a ground point that go from cloud to cloud: an assumption, most stay inside.
const BETWEEN_CLOUDS: f64 = 0.1;
/// Flashes from here on begin beyond every simulation.
const LAST_SLOT: f64 = 1e10;

/// The ground over which a storm rages: a rounded rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Full size towards east before the rotation.
    pub size_east_m: f64,
    /// Full size towards north before the rotation.
    pub size_north_m: f64,
    /// Radius of the corners, at most half the smaller size.
    pub corner_radius_m: f64,
    /// Rotation clockwise seen from above.
    pub rotation_deg: f64,
}

/// A storm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Storm {
    /// Where.
    pub extent: Extent,
    /// Mean rate.
    pub flashes_per_minute: f64,
    /// Share of the flashes that do not come to the ground, 0 to 1.
    pub inside_share: f64,
    /// Share of the flashes to ground that are positive, 0 to 1.
    pub positive_share: f64,
    /// Factor on the peak currents of the published distributions.
    pub current_factor: f64,
    /// Seed.
    pub seed: u64,
}

/// One flash of a storm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StormFlash {
    /// Its number in the storm: slot and place in the slot. Rising with time from slot to slot.
    pub number: u64,
    /// When it begins, in seconds.
    pub at_s: f64,
    /// East and north of the storm's centre.
    pub place_m: [f64; 2],
    /// Type.
    pub kind: FlashKind,
    /// Polarity.
    pub polarity: Polarity,
    /// Peak current of the first stroke in kiloamperes, before limits.
    pub peak_current_ka: f64,
    /// Seed of what the flash itself draws.
    pub seed: u64,
}

impl Storm {
    /// The flashes that begin in `[begin_s, end_s)`, in the order of their numbers. Work is in proportion to the interval's
    /// length; what lies before 0 or is no number has none.
    pub fn flashes(&self, begin_s: f64, end_s: f64) -> impl Iterator<Item = StormFlash> + '_ {
        let slot = |time_s: f64| (time_s.max(0.0) / SLOT_S).min(LAST_SLOT);
        let slots = if end_s > begin_s { slot(begin_s).floor() as u64..slot(end_s).ceil() as u64 } else { 0..0 };
        let within = move |flash: &StormFlash| flash.at_s >= begin_s && flash.at_s < end_s;
        slots.flat_map(move |slot| self.in_slot(slot)).filter(within)
    }

    /// The flash of a number: as [`Storm::flashes`] has it, and where they have none of it, one all the same (for a strike that is
    /// asked for by itself).
    pub fn flash(&self, number: u64) -> StormFlash {
        let slot = number / MOST_IN_SLOT;
        let mut stream = Stream::new(self.seed, number.wrapping_add(1 << 48));
        let at_s = (slot as f64 + stream.unit()) * SLOT_S;
        let place_m = self.place_m(&mut stream);
        let [inside, between, positive] =
            [self.inside_share, BETWEEN_CLOUDS, self.positive_share].map(|s| stream.unit() < s);
        let kind = match (inside, between) {
            (false, _) => FlashKind::CloudToGround,
            (true, false) => FlashKind::IntraCloud,
            (true, true) => FlashKind::CloudToCloud,
        };
        let polarity = if positive && !inside { Polarity::Positive } else { Polarity::Negative };
        let seed = stream.bits();
        let peak_current_ka = self.current_factor * first_peak_current_ka(kind, polarity, seed);
        StormFlash { number, at_s, place_m, kind, polarity, peak_current_ka, seed }
    }

    fn in_slot(&self, slot: u64) -> impl Iterator<Item = StormFlash> + '_ {
        let burst = Stream::new(self.seed, (2 << 48) + slot / BLOCK_SLOTS).unit() < BURSTS;
        let mean = self.flashes_per_minute / 60.0 * SLOT_S * if burst { BURST } else { QUIET };
        let count = poisson(mean, &mut Stream::new(self.seed, (3 << 48) + slot));
        (0..count).map(move |place| self.flash(slot * MOST_IN_SLOT + place))
    }

    /// A place in the extent, every square metre alike.
    fn place_m(&self, stream: &mut Stream) -> [f64; 2] {
        let Extent { size_east_m, size_north_m, corner_radius_m, rotation_deg } = self.extent;
        let half = [0.5 * size_east_m, 0.5 * size_north_m];
        let mut at = [0.0; 2];
        // A try falls into a corner with a chance of at most 1 - pi / 4.
        for _ in 0..32 {
            let tried = half.map(|half| half * (2.0 * stream.unit() - 1.0));
            let beyond: [f64; 2] =
                std::array::from_fn(|axis| (tried[axis].abs() - half[axis] + corner_radius_m).max(0.0));
            if beyond[0].hypot(beyond[1]) <= corner_radius_m {
                at = tried;
                break;
            }
        }
        let (sin, cos) = rotation_deg.to_radians().sin_cos();
        [at[0] * cos + at[1] * sin, at[1] * cos - at[0] * sin]
    }
}

/// A Poisson number by its distribution function, at most [`MOST_IN_SLOT`].
fn poisson(mean: f64, stream: &mut Stream) -> u64 {
    let chance = stream.unit();
    let mut term = (-mean).exp();
    let mut sum = term;
    let mut count = 0;
    while sum < chance && count < MOST_IN_SLOT {
        count += 1;
        term *= mean / count as f64;
        sum += term;
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    fn storm(flashes_per_minute: f64) -> Storm {
        let extent = Extent { size_east_m: 30e3, size_north_m: 10e3, corner_radius_m: 5e3, rotation_deg: 30.0 };
        let (inside_share, positive_share, current_factor) = (0.75, 0.1, 1.0);
        Storm { extent, flashes_per_minute, inside_share, positive_share, current_factor, seed: 5 }
    }

    #[test]
    fn any_stretch_of_time_says_the_same() {
        let storm = storm(20.0);
        let whole: Vec<StormFlash> = storm.flashes(0.0, 300.0).collect();
        let parts: Vec<StormFlash> =
            (0..3000).flat_map(|k| storm.flashes(f64::from(k) / 10.0, f64::from(k + 1) / 10.0)).collect();
        let sorted = |mut flashes: Vec<StormFlash>| {
            flashes.sort_by_key(|flash| flash.number);
            flashes
        };
        assert_eq!(sorted(whole.clone()), sorted(parts));
        assert!(whole.iter().all(|flash| storm.flash(flash.number) == *flash));
        assert!(whole.windows(2).all(|pair| pair[0].number < pair[1].number));
        assert_ne!(whole, Storm { seed: 6, ..storm }.flashes(0.0, 300.0).collect::<Vec<_>>());
        for [begin_s, end_s] in [[5.0, 5.0], [9.0, 2.0], [-9.0, 0.0], [f64::NAN, 9.0], [0.0, f64::NAN], [1e12, 1e13]] {
            assert_eq!(storm.flashes(begin_s, end_s).count(), 0, "{begin_s} {end_s}");
        }
        // Ten years on it costs the same.
        assert!(storm.flashes(3e8, 3e8 + 600.0).count() > 20);
    }

    #[test]
    fn rate_shares_and_bursts_are_as_asked() {
        let storm = storm(3.0);
        let hours = 200.0;
        let flashes: Vec<StormFlash> = storm.flashes(0.0, 3600.0 * hours).collect();
        let (n, mean) = (flashes.len() as f64, 180.0 * hours);
        // The count of a block of half a minute has variance 1.5 + 1.5^2 * 27/16 = 5.3; five standard errors.
        assert!((n - mean).abs() < 5.0 * (5.3 * 120.0 * hours).sqrt(), "{n} of {mean}");
        let share = |of: &dyn Fn(&StormFlash) -> bool| flashes.iter().filter(|flash| of(flash)).count() as f64 / n;
        // Standard errors of shares: sqrt(0.19 / 36000) = 0.0023 and less; five of them.
        let ground = share(&|flash| flash.kind == FlashKind::CloudToGround);
        assert!((ground - 0.25).abs() < 0.012, "{ground}");
        let positive = share(&|flash| flash.polarity == Polarity::Positive);
        assert!((positive - 0.025).abs() < 0.005, "{positive}");
        assert!((share(&|flash| flash.kind == FlashKind::CloudToCloud) - 0.075).abs() < 0.008);
        // Variance over mean of the counts of half minutes: 1 for an even process, 3.5 as asked.
        let mut counts = vec![0.0; (120.0 * hours) as usize];
        flashes.iter().for_each(|flash| counts[(flash.at_s / 30.0) as usize] += 1.0);
        let mean = n / counts.len() as f64;
        let variance = counts.iter().map(|count| (count - mean) * (count - mean)).sum::<f64>() / counts.len() as f64;
        // Some 24,000 blocks of a fat-tailed count: a few per cent.
        assert!((variance / mean - 3.5).abs() < 0.3, "{}", variance / mean);
        // No rate that may be asked for meets the bound of a slot.
        let wild = Storm { flashes_per_minute: 600.0, ..storm };
        let (found, asked) = (wild.flashes(0.0, 36_000.0).count() as f64, 360_000.0);
        assert!((found / asked - 1.0).abs() < 0.15, "{found}");
        assert_eq!(Storm { flashes_per_minute: 0.0, ..storm }.flashes(0.0, 3600.0).count(), 0);
    }

    #[test]
    fn places_fill_the_extent_evenly_and_currents_follow_their_factor() {
        let storm = storm(600.0);
        let flashes: Vec<StormFlash> = storm.flashes(0.0, 600.0).collect();
        let (sin, cos) = 30_f64.to_radians().sin_cos();
        let mut quarters = [0.0; 4];
        for flash in &flashes {
            let [east, north] = flash.place_m;
            let along = [east * cos - north * sin, east * sin + north * cos];
            let beyond = [(along[0].abs() - 10e3).max(0.0), (along[1].abs() - 0.0).max(0.0)];
            // Corners of half the smaller side: a stadium.
            assert!(beyond[0].hypot(beyond[1]) <= 5e3 + 1e-6, "{along:?}");
            quarters[usize::from(along[0] > 0.0) + 2 * usize::from(along[1] > 0.0)] += 1.0;
        }
        let n = flashes.len() as f64;
        // Standard error of a quarter: sqrt(3/16 n); five of them.
        assert!(quarters.iter().all(|count| (count - n / 4.0).abs() < 5.0 * (0.1875 * n).sqrt()), "{quarters:?}");
        let strong = Storm { current_factor: 2.0, ..storm };
        assert!(
            strong.flashes(0.0, 60.0).zip(storm.flashes(0.0, 60.0)).all(|(a, b)| {
                (a.peak_current_ka / b.peak_current_ka - 2.0).abs() < 1e-12 && a.place_m == b.place_m
            })
        );
    }
}
