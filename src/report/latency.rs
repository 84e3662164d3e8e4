//! Subject `latency`: where the time between a CIGI host's datagram and the encoded frame that shows it goes, and how many
//! frames of the regulator's budget that is.

mod flight;

use super::result::{Case, TimeSpread};
use super::subject::{Run, Stopped, Subject};
use crate::gpu::GpuExecutor;
use crate::plan::executor::{Executor, Fault};
use crate::reference::ReferenceExecutor;
use crate::serve::{Stage, Stages, with_server};
use crate::settings::{CigiSettings, Settings};
use crate::wire::cigi::ByteOrder;
use crate::wire::limits;
use flight::{Flight, Flown};
use std::net::UdpSocket;
use std::sync::Arc;
use std::time::Duration;

/// Delay from a host's datagram to its frame.
pub const SUBJECT: Subject = Subject {
    name: "latency",
    about: "a CIGI host's datagram to its encoded frame, stage by stage, in frames of the regulator's budget",
    measure: cases,
};

/// Transport delay that a whole simulator may have, of which a visual system may use two to three frames: 100 ms for
/// helicopters of the highest level, 150 ms for aeroplanes (14 CFR Part 60, tables C1A and A1A).
const BUDGET: &str =
    "a visual system's two to three frames of 100 ms (helicopters) or 150 ms (aeroplanes), 14 CFR Part 60";

fn cases(run: &mut Run) -> Result<(), Stopped> {
    let size_px = run.pick([160, 90], [320, 180]);
    let seconds = run.pick(2.0, 10.0);
    for synchronous in [false, true] {
        for rate_hz in [30.0, 60.0, 120.0] {
            let (stages, flown) = measured(size_px, rate_hz, synchronous, seconds)?;
            let mode = if synchronous { "synchronous" } else { "asynchronous" };
            let [width, height] = size_px;
            let name = format!("{mode} host at {rate_hz} Hz, {width} x {height}");
            for stage in Stage::ALL {
                let times_us = stages.newest_us(stage);
                let Some(spread) = Spread::of(&times_us) else {
                    return Err(Stopped::Failed(format!("{name}: no {} was measured", stage.name())));
                };
                let mut case = spread.case(&name, stage.name(), rate_hz);
                if stage == Stage::Whole {
                    case = case.note(format!(
                        "{} messages sent in {:.1} s, {:.1} frames a second",
                        flown.messages,
                        flown.seconds,
                        times_us.len() as f64 / flown.seconds
                    ));
                }
                run.record(case)?;
            }
        }
    }
    Ok(())
}

/// Flies one host against a server in this process, with a watcher that takes JPEGs.
fn measured(size_px: [u32; 2], rate_hz: f64, synchronous: bool, seconds: f64) -> Result<(Arc<Stages>, Flown), Stopped> {
    let failed = |what: &dyn std::fmt::Display| Stopped::Failed(what.to_string());
    let socket = UdpSocket::bind("127.0.0.1:0").map_err(|error| failed(&error))?;
    let cigi = CigiSettings {
        listen: ([127, 0, 0, 1], 0).into(),
        host: Some(socket.local_addr().map_err(|error| failed(&error))?),
        reply_port: None,
        allow: Vec::new(),
        multicast: None,
        synchronous,
        byte_order: ByteOrder::Little,
        rate_hz,
        silence_s: 3_600.0,
        host_chooses_database: false,
        sea_level_m: 0.0,
        seed: 1,
        size_px,
    };
    let settings = Settings {
        frame_rate_hz: rate_hz.min(limits::SERVER_RATE_HZ.max),
        scenario: None,
        token: None,
        cigi: Some(cigi),
        ..Settings::default()
    };
    let stages = Arc::new(Stages::default());
    let flight = Flight { socket, rate_hz, synchronous, duration: Duration::from_secs_f64(seconds) };
    let counted = Arc::clone(&stages);
    let flown = with_server(settings, Box::new(executor), Arc::clone(&stages), move || flight.fly(&counted));
    flown.map_err(|error| failed(&error))?.map(|flown| (stages, flown)).map_err(|error| failed(&error))
}

fn executor() -> Result<Box<dyn Executor>, Fault> {
    match GpuExecutor::new() {
        Ok(executor) => Ok(Box::new(executor)),
        Err(_) => Ok(Box::new(ReferenceExecutor::new())),
    }
}

/// What is said of the durations of one stage.
#[derive(Clone, Debug, PartialEq)]
struct Spread {
    time_s: TimeSpread,
    p95_s: f64,
    p99_s: f64,
    histogram: String,
}

impl Spread {
    /// `None`: nothing was measured.
    fn of(times_us: &[u64]) -> Option<Self> {
        let seconds: Vec<f64> = times_us.iter().map(|us| *us as f64 * 1e-6).collect();
        let mut sorted = seconds.clone();
        sorted.sort_by(f64::total_cmp);
        // Nearest rank.
        let percentile = |share: f64| sorted[((share * sorted.len() as f64).ceil() as usize).saturating_sub(1)];
        let time_s = TimeSpread::of(&seconds)?;
        Some(Self { time_s, p95_s: percentile(0.95), p99_s: percentile(0.99), histogram: histogram(times_us) })
    }

    fn case(&self, name: &str, stage: &str, rate_hz: f64) -> Case {
        let milliseconds = |seconds: f64| (seconds * 1e6).round() * 1e-3;
        Case::new(name, stage)
            .param("p95_ms", milliseconds(self.p95_s))
            .param("p99_ms", milliseconds(self.p99_s))
            .error("frames of the host at p99", BUDGET, self.p99_s * rate_hz)
            .time(self.time_s)
            .note(self.histogram.clone())
    }
}

/// How many durations lie between powers of two of a millisecond.
fn histogram(times_us: &[u64]) -> String {
    // 62.5 us is the finest bound.
    let bin = |us: u64| (us as f64 / 62.5).log2().ceil().max(0.0) as usize;
    let bound_ms = |bin: usize| 0.0625 * 2f64.powi(bin as i32);
    let mut counts = std::collections::BTreeMap::new();
    times_us.iter().for_each(|us| *counts.entry(bin(*us)).or_insert(0) += 1);
    let said = counts.into_iter().map(|(bin, count): (usize, usize)| format!("up to {} ms {count}", bound_ms(bin)));
    said.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_by_nearest_rank_and_the_histogram_counts_all() {
        let times_us: Vec<u64> = (1..=200).rev().map(|n| 1_000 * n).collect();
        let spread = Spread::of(&times_us).expect("times");
        for (found, expected) in [(spread.p95_s, 0.190), (spread.p99_s, 0.198), (spread.time_s.median, 0.1005)] {
            // Microseconds into seconds: rounding alone.
            assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
        }
        assert_eq!(
            spread.histogram,
            "up to 1 ms 1, up to 2 ms 1, up to 4 ms 2, up to 8 ms 4, up to 16 ms 8, up to 32 ms 16, up to 64 ms 32, \
             up to 128 ms 64, up to 256 ms 72"
        );
        assert_eq!(histogram(&[0, 62, 63]), "up to 0.0625 ms 2, up to 0.125 ms 1");
        assert_eq!(Spread::of(&[]), None);
    }
}
