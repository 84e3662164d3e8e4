//! Numbers for operators: counted where things happen, read by `/metrics`, telemetry and the statistics query alike.

use super::cigi::counters::Counters;
use super::stages::{Stage, Stages};
use crate::frame::LatencyStamps;
use crate::passes::relight::tables::{Status, Tables};
use std::collections::{BTreeMap, VecDeque};
use std::fmt::Write as _;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// Everything that is counted.
pub(super) struct Metrics {
    start: Instant,
    /// Connections with a WebSocket.
    pub(super) clients: AtomicU64,
    /// 1 while somebody has the host role.
    pub(super) hosts: AtomicU64,
    /// Messages read.
    pub(super) messages: AtomicU64,
    /// Messages refused and answered.
    pub(super) refusals: AtomicU64,
    /// HTTP requests turned away at the door.
    pub(super) turned_away: AtomicU64,
    /// Messages of floods, refused without a word.
    pub(super) unsaid: AtomicU64,
    /// Our own failures.
    pub(super) faults: AtomicU64,
    /// Executors made after the first one.
    pub(super) executors_remade: AtomicU64,
    /// Connections ended because they were too slow or broke a rule.
    pub(super) disconnected: AtomicU64,
    /// Events and telemetry that a full queue could not take.
    pub(super) events_dropped: AtomicU64,
    /// Lockstep steps accepted and not yet answered.
    pub(super) steps_waiting: AtomicU64,
    /// Steps answered.
    pub(super) steps: AtomicU64,
    /// Frames being encoded.
    pub(super) encoding: AtomicU64,
    /// Encodings done, one for each frame and format.
    pub(super) encodings: AtomicU64,
    /// Frames waiting for clients, all together.
    pub(super) queued: AtomicU64,
    /// Bytes of pictures that steps hold.
    pub(super) step_bytes: AtomicU64,
    /// Objects that live on the graphics device.
    pub(super) gpu_objects: AtomicU64,
    /// Simulation time, bits of an f64.
    simulation_time: AtomicU64,
    /// The CIGI port.
    pub(super) cigi: Arc<Counters>,
    executor: Mutex<String>,
    tables: Mutex<Option<Arc<Tables>>>,
    views: Mutex<BTreeMap<String, ViewCounts>>,
    /// From the plan to the pixels.
    pub(super) render: Summary,
    /// One picture into one format.
    pub(super) encode: Summary,
    /// Where the time between a message and its frame goes.
    pub(super) stages: Arc<Stages>,
}

/// Counts of one view.
#[derive(Clone, Default)]
pub(super) struct ViewCounts {
    /// Frames drawn.
    pub(super) drawn: u64,
    /// Frames repeated because nothing had changed.
    pub(super) repeated: u64,
    /// Copies written to sockets.
    pub(super) sent: u64,
    /// Copies dropped because a client was slow.
    pub(super) dropped: u64,
    /// From reading the host's message to the pixels of the first frame that shows it.
    pub(super) delay: Samples,
    newest_received_us: u64,
    finished_us: VecDeque<u64>,
}

impl ViewCounts {
    /// A frame is out.
    pub(super) fn frame(&mut self, stamps: &LatencyStamps, repeated: bool) {
        if repeated {
            self.repeated += 1
        } else {
            self.drawn += 1
        }
        self.finished_us.push_back(stamps.finished_us);
        if self.finished_us.len() > RATE_FRAMES {
            self.finished_us.pop_front();
        }
        if stamps.received_us > self.newest_received_us {
            self.newest_received_us = stamps.received_us;
            self.delay.add_us(stamps.finished_us.saturating_sub(stamps.received_us));
        }
    }

    /// Frames in the second before `now_us`.
    pub(super) fn rate_hz(&self, now_us: u64) -> f64 {
        self.finished_us.iter().filter(|at| **at + 1_000_000 > now_us).count() as f64
    }
}

/// Frames of a view whose times are kept: more than there can be in a second.
const RATE_FRAMES: usize = 128;

impl Metrics {
    pub(super) fn new(stages: Arc<Stages>) -> Self {
        let zero = AtomicU64::default;
        Self {
            start: Instant::now(),
            clients: zero(),
            hosts: zero(),
            messages: zero(),
            refusals: zero(),
            turned_away: zero(),
            unsaid: zero(),
            faults: zero(),
            executors_remade: zero(),
            disconnected: zero(),
            events_dropped: zero(),
            steps_waiting: zero(),
            steps: zero(),
            encoding: zero(),
            encodings: zero(),
            queued: zero(),
            step_bytes: zero(),
            gpu_objects: zero(),
            simulation_time: zero(),
            cigi: Arc::default(),
            executor: Mutex::default(),
            tables: Mutex::default(),
            views: Mutex::default(),
            render: Summary::default(),
            encode: Summary::default(),
            stages,
        }
    }

    /// Microseconds since the server started: the clock of all latency stamps. Never 0, which means "not there".
    pub(super) fn now_us(&self) -> u64 {
        self.start.elapsed().as_micros().try_into().unwrap_or(u64::MAX).max(1)
    }

    pub(super) fn set_simulation_time(&self, time_s: f64) {
        self.simulation_time.store(time_s.to_bits(), Relaxed);
    }

    pub(super) fn simulation_time_s(&self) -> f64 {
        f64::from_bits(self.simulation_time.load(Relaxed))
    }

    pub(super) fn set_executor(&self, description: String) {
        *lock(&self.executor) = description;
    }

    /// Takes the tables of virtual lights of what draws, to tell how far they are.
    pub(super) fn set_tables(&self, tables: Option<Arc<Tables>>) {
        *lock(&self.tables) = tables;
    }

    /// The tables of virtual lights of what draws, if it has any.
    pub(super) fn tables(&self) -> Option<Arc<Tables>> {
        lock(&self.tables).clone()
    }

    pub(super) fn executor(&self) -> String {
        lock(&self.executor).clone()
    }

    /// Changes the counts of a view.
    pub(super) fn count(&self, view: &str, change: impl FnOnce(&mut ViewCounts)) {
        let mut views = lock(&self.views);
        match views.get_mut(view) {
            Some(counts) => change(counts),
            None => change(views.entry(view.to_owned()).or_default()),
        }
    }

    /// Forgets the counts of views that are gone, so that names cannot pile up.
    pub(super) fn retain_views(&self, exists: impl Fn(&str) -> bool) {
        lock(&self.views).retain(|name, _| exists(name));
    }

    pub(super) fn views(&self) -> BTreeMap<String, ViewCounts> {
        lock(&self.views).clone()
    }

    /// Prometheus text.
    pub(super) fn text(&self) -> String {
        let mut out = String::with_capacity(4096);
        self.cigi.text(&mut out);
        let counters: [(&str, &str, u64); 10] = [
            ("messages_total", "Messages read from clients", self.messages.load(Relaxed)),
            ("refusals_total", "Messages refused with a reason", self.refusals.load(Relaxed)),
            ("flood_dropped_total", "Messages of floods refused in silence", self.unsaid.load(Relaxed)),
            ("turned_away_total", "Requests with a wrong origin, host or token", self.turned_away.load(Relaxed)),
            ("faults_total", "Failures of the server itself", self.faults.load(Relaxed)),
            ("executors_remade_total", "Executors made after a loss", self.executors_remade.load(Relaxed)),
            ("disconnected_total", "Clients disconnected for being stuck", self.disconnected.load(Relaxed)),
            ("events_dropped_total", "Events that full queues lost", self.events_dropped.load(Relaxed)),
            ("steps_total", "Lockstep steps answered", self.steps.load(Relaxed)),
            ("encodings_total", "Pictures encoded", self.encodings.load(Relaxed)),
        ];
        for (name, help, value) in counters {
            single(&mut out, name, help, "counter", value as f64);
        }
        let gauges: [(&str, &str, f64); 9] = [
            ("clients", "WebSocket clients", self.clients.load(Relaxed) as f64),
            ("hosts", "1 while a client is host", self.hosts.load(Relaxed) as f64),
            ("steps_waiting", "Lockstep steps not yet answered", self.steps_waiting.load(Relaxed) as f64),
            ("encoding", "Frames being encoded", self.encoding.load(Relaxed) as f64),
            ("client_queue_frames", "Frames waiting for clients", self.queued.load(Relaxed) as f64),
            (
                "step_bytes",
                "Bytes that pictures of steps hold until they are written",
                self.step_bytes.load(Relaxed) as f64,
            ),
            ("gpu_objects", "Buffers, textures and bind groups on the device", self.gpu_objects.load(Relaxed) as f64),
            ("simulation_time_seconds", "Time of the world", self.simulation_time_s()),
            ("uptime_seconds", "Since the server started", self.start.elapsed().as_secs_f64()),
        ];
        for (name, help, value) in gauges {
            single(&mut out, name, help, "gauge", value);
        }
        if let Some(tables) = self.tables() {
            tables_text(&mut out, &tables.status());
        }
        if let Some(bytes) = resident_bytes() {
            single(&mut out, "resident_bytes", "Resident memory", "gauge", bytes as f64);
        }
        head(&mut out, "executor_info", "What draws", "gauge");
        let _ = writeln!(out, "stormdeck_executor_info{{executor=\"{}\"}} 1", escape(&self.executor()));
        self.views_text(&mut out);
        self.render.text(&mut out, "render_seconds", "From plan to pixels");
        self.encode.text(&mut out, "encode_seconds", "One picture into one format");
        head(&mut out, "message_to_frame_seconds", "From a host's message to its first pixels", "summary");
        for (view, counts) in self.views() {
            counts.delay.text(&mut out, "message_to_frame_seconds", &format!("view=\"{}\"", escape(&view)));
        }
        self.stages_text(&mut out);
        out
    }

    fn stages_text(&self, out: &mut String) {
        head(out, "stage_seconds", "From a host's message to its frame, by stage", "summary");
        for stage in Stage::ALL {
            let mut samples = Samples::default();
            self.stages.newest_us(stage).into_iter().for_each(|us| samples.add_us(us));
            if samples.kept() > 0 {
                samples.text(out, "stage_seconds", &format!("stage=\"{}\"", stage.name()));
            }
        }
    }

    fn views_text(&self, out: &mut String) {
        type Field = fn(&ViewCounts) -> u64;
        let fields: [(&str, &str, Field); 4] = [
            ("frames_drawn_total", "Frames drawn", |c| c.drawn),
            ("frames_repeated_total", "Frames repeated because nothing had changed", |c| c.repeated),
            ("frames_sent_total", "Copies written to sockets", |c| c.sent),
            ("frames_dropped_total", "Copies dropped because a client was slow", |c| c.dropped),
        ];
        let views = self.views();
        for (name, help, field) in fields {
            head(out, name, help, "counter");
            for (view, counts) in &views {
                let _ = writeln!(out, "stormdeck_{name}{{view=\"{}\"}} {}", escape(view), field(counts));
            }
        }
    }
}

fn tables_text(out: &mut String, status: &Status) {
    let counters = [
        ("basis_lights_baked_total", "Virtual lights baked", status.baked),
        ("basis_lights_read_total", "Virtual lights read from the cache of tables", status.read),
        ("basis_files_refused_total", "Files of the cache that were damaged or foreign", status.refused),
    ];
    counters.into_iter().for_each(|(name, help, value)| single(out, name, help, "counter", value as f64));
    let gauges = [
        ("basis_lights", "Virtual lights that are there, of the tables in memory", status.lights),
        ("basis_lights_in_all", "Virtual lights of the tables in memory when all are baked", status.of),
        ("basis_baking", "1 while tables are baked in the background", u64::from(status.baking)),
        ("basis_memory_bytes", "Memory of the tables", status.memory_bytes),
        ("basis_cache_bytes", "Bytes of the cache of tables", status.cache_bytes),
    ];
    gauges.into_iter().for_each(|(name, help, value)| single(out, name, help, "gauge", value as f64));
}

fn head(out: &mut String, name: &str, help: &str, kind: &str) {
    let _ = writeln!(out, "# HELP stormdeck_{name} {help}\n# TYPE stormdeck_{name} {kind}");
}

fn single(out: &mut String, name: &str, help: &str, kind: &str, value: f64) {
    head(out, name, help, kind);
    let _ = writeln!(out, "stormdeck_{name} {value}");
}

fn escape(label: &str) -> String {
    label.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n")
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Resident memory of this process in bytes, where the system says so.
pub(super) fn resident_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.trim().trim_end_matches("kB").trim().parse::<u64>().ok().map(|kilobytes| kilobytes * 1024)
}

/// Durations that several threads add to.
#[derive(Default)]
pub(super) struct Summary {
    samples: Mutex<Samples>,
}

impl Summary {
    pub(super) fn add_us(&self, duration_us: u64) {
        lock(&self.samples).add_us(duration_us);
    }

    fn text(&self, out: &mut String, name: &str, help: &str) {
        head(out, name, help, "summary");
        lock(&self.samples).text(out, name, "");
    }
}

/// Durations: how many, their sum, and quantiles of the newest thousand.
#[derive(Clone, Default)]
pub(super) struct Samples {
    count: u64,
    sum_us: u64,
    newest_us: Vec<u64>,
}

/// How many durations quantiles are taken from.
const KEPT: usize = 1024;

impl Samples {
    pub(super) fn add_us(&mut self, duration_us: u64) {
        let slot = (self.count % KEPT as u64) as usize;
        self.count += 1;
        self.sum_us = self.sum_us.saturating_add(duration_us);
        match self.newest_us.get_mut(slot) {
            Some(old) => *old = duration_us,
            None => self.newest_us.push(duration_us),
        }
    }

    /// How many durations the quantiles are taken from.
    pub(super) fn kept(&self) -> usize {
        self.newest_us.len()
    }

    /// The quantile in seconds (nearest rank), 0 when there is no sample.
    pub(super) fn quantile_s(&self, share: f64) -> f64 {
        let mut sorted = self.newest_us.clone();
        sorted.sort_unstable();
        let rank = (share * sorted.len() as f64).ceil() as usize;
        sorted.get(rank.saturating_sub(1)).map_or(0.0, |us| *us as f64 * 1e-6)
    }

    fn text(&self, out: &mut String, name: &str, label: &str) {
        let comma = if label.is_empty() { "" } else { "," };
        for share in [0.5, 0.9, 0.99] {
            let value = self.quantile_s(share);
            let _ = writeln!(out, "stormdeck_{name}{{{label}{comma}quantile=\"{share}\"}} {value}");
        }
        let labels = if label.is_empty() { String::new() } else { format!("{{{label}}}") };
        let _ = writeln!(out, "stormdeck_{name}_sum{labels} {}", self.sum_us as f64 * 1e-6);
        let _ = writeln!(out, "stormdeck_{name}_count{labels} {}", self.count);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_the_nearest_rank_of_the_newest() {
        let mut summary = Samples::default();
        assert_eq!(summary.quantile_s(0.5), 0.0);
        (0..KEPT).for_each(|_| summary.add_us(9_000_000));
        (1..=1024).for_each(|us| summary.add_us(us));
        assert_eq!(summary.quantile_s(0.5), 512e-6);
        assert_eq!(summary.quantile_s(0.99), 1014.0 * 1e-6);
    }

    #[test]
    fn text_has_each_number_with_its_view_and_escapes_names() {
        let metrics = Metrics::new(Arc::default());
        metrics.stages.add_us(Stage::Plan, 250);
        metrics.set_executor("a \"fast\" one".into());
        assert!(!metrics.text().contains("basis_lights"));
        metrics.set_tables(Some(Arc::default()));
        metrics.count("nose", |c| c.dropped += 3);
        metrics.messages.fetch_add(5, Relaxed);
        let text = metrics.text();
        assert!(text.contains("stormdeck_frames_dropped_total{view=\"nose\"} 3\n"), "{text}");
        assert!(text.contains("stormdeck_messages_total 5\n"), "{text}");
        assert!(text.contains("stormdeck_basis_lights_baked_total 0\n"), "{text}");
        assert!(text.contains("stage_seconds{stage=\"plan\",quantile=\"0.5\"} 0.00025\n"), "{text}");
        assert!(text.contains("executor=\"a \\\"fast\\\" one\""), "{text}");
        metrics.retain_views(|_| false);
        assert!(!metrics.text().contains("nose"));
    }
}
