//! What happened on the CIGI port, in numbers for `/metrics`.

use std::fmt::Write as _;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

macro_rules! counters {
    ($($(#[doc = $doc:literal])+ $name:ident,)+) => {
        /// Counts since the server began.
        #[derive(Default)]
        pub struct Counters {
            $($(#[doc = $doc])+ pub $name: AtomicU64,)+
        }

        impl Counters {
            /// Prometheus text; nothing until a datagram has come or gone.
            pub fn text(&self, out: &mut String) {
                let counts = [$((stringify!($name), concat!($($doc),+), self.$name.load(Relaxed)),)+];
                if counts.iter().all(|(_, _, count)| *count == 0) {
                    return;
                }
                for (name, help, count) in counts {
                    let help = help.trim().trim_end_matches('.');
                    let _ = writeln!(out, "# HELP stormdeck_cigi_{name}_total {help}");
                    let _ = writeln!(out, "# TYPE stormdeck_cigi_{name}_total counter");
                    let _ = writeln!(out, "stormdeck_cigi_{name}_total {count}");
                }
            }
        }
    };
}

counters! {
    /// CIGI messages of the host applied.
    messages,
    /// CIGI packets in them, those passed over not counted.
    packets,
    /// CIGI packets passed over: unknown, user-defined or not acted on.
    skipped,
    /// CIGI messages rejected whole: not as the standard says.
    rejected,
    /// Datagrams on the CIGI port from somebody who is not the host or not allowed.
    strangers,
    /// CIGI packets refused: a value out of range, or too many of something.
    refused,
    /// CIGI messages lost on the way, by their frame numbers.
    lost,
    /// CIGI messages that came late or twice.
    late,
    /// Start of Frame messages sent.
    frames,
    /// Answers sent to the CIGI host.
    answers,
    /// Answers to the CIGI host dropped because too many waited.
    answers_dropped,
    /// Datagrams to the CIGI host that the system refused.
    send_failures,
    /// CIGI hosts that fell silent.
    silences,
    /// Frames of synchronous operation for which no message of the host came in time.
    missed_frames,
}

impl Counters {
    /// One more.
    pub fn one(counter: &AtomicU64) {
        counter.fetch_add(1, Relaxed);
    }

    /// So many more.
    pub fn add(counter: &AtomicU64, count: u64) {
        counter.fetch_add(count, Relaxed);
    }
}
