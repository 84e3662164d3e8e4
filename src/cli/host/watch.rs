//! Watches what comes back from a server and says what is wrong with it. Knows no socket: told what was sent and what
//! arrived, and when.

use super::picture::{jpeg_size, png_size};
use super::spread::Spread;
use crate::wire::control::Format;
use crate::wire::control::out::{EventMessage, Outbound};
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

/// Complaints kept in words; more are counted.
const KEPT: usize = 20;

/// A frame as it arrived.
pub(super) struct Arrived<'a> {
    pub(super) view: &'a str,
    pub(super) number: u64,
    pub(super) host_frame: u32,
    pub(super) simulation_time_s: f64,
    pub(super) size_px: [u32; 2],
    pub(super) format: Format,
    /// Frames of this view that the server dropped for this client so far.
    pub(super) dropped: u32,
    /// The encoded picture.
    pub(super) picture: &'a [u8],
    /// From reading the host message to giving the frame to the socket, by the server's stamps; `None`: no host message led to it.
    pub(super) server_delay: Option<Duration>,
}

/// What is known of one view.
#[derive(Debug, Default)]
struct View {
    /// Number, host frame and simulation time of the newest frame.
    newest: Option<(u64, u32, f64)>,
    frames: u64,
    skipped: u64,
    dropped: u32,
    first: Option<Duration>,
    last: Option<Duration>,
    /// How often the view has been made again and may begin to count from 1.
    restarts: u32,
}

/// Everything that was sent and came back.
#[derive(Debug, Default)]
pub(super) struct Watch {
    /// Sizes that the views must have; a change may still be on its way to frames that are.
    sizes: BTreeMap<String, BTreeSet<[u32; 2]>>,
    unanswered: BTreeMap<u64, &'static str>,
    /// When each host frame was sent, while no frame has shown it.
    ownships: BTreeMap<u32, Duration>,
    /// Host frames of this run that have been sent: the first and the newest.
    host_frames: Option<[u32; 2]>,
    views: BTreeMap<String, View>,
    /// From sending an ownship to having a frame that shows it.
    delay_ms: Spread,
    server_delay_ms: Spread,
    acknowledged: u64,
    strikes_shown: u64,
    complaints: Vec<String>,
    complaint_count: u64,
    /// Whether every frame must arrive: in lockstep none is dropped.
    lockstep: bool,
}

impl Watch {
    /// Watches a run in lockstep or a free one.
    pub(super) fn new(lockstep: bool) -> Self {
        Self { lockstep, ..Self::default() }
    }

    /// A message with this number goes out.
    pub(super) fn sent(&mut self, seq: u64, what: &'static str) {
        self.unanswered.insert(seq, what);
    }

    /// An ownship message with this frame number goes out.
    pub(super) fn sent_ownship(&mut self, host_frame: u32, now: Duration) {
        self.host_frames = Some([self.host_frames.map_or(host_frame, |[first, _]| first), host_frame]);
        self.ownships.insert(host_frame, now);
    }

    /// From now on frames of this view may have this size.
    pub(super) fn expect_size(&mut self, view: &str, size_px: [u32; 2]) {
        self.sizes.entry(view.to_owned()).or_default().insert(size_px);
    }

    /// A view of this name is made; if there was one before, its numbers begin again.
    pub(super) fn made(&mut self, view: &str) {
        if let Some(view) = self.views.get_mut(view) {
            view.restarts += 1;
        }
    }

    /// A control message of the server arrived.
    pub(super) fn control(&mut self, message: &Outbound) {
        match message {
            Outbound::Ack(ack) => self.answered("ack", ack.seq),
            Outbound::Stepped(stepped) => self.answered("stepped", stepped.seq),
            Outbound::Refused(refused) => {
                let what = refused.seq.and_then(|seq| self.unanswered.remove(&seq)).unwrap_or("a message");
                self.complain(format!(
                    "{what} was refused: {} = {}: {} (limit: {})",
                    refused.field, refused.value, refused.why, refused.limit
                ));
            }
            Outbound::Event(EventMessage::StrikeShown { .. }) => self.strikes_shown += 1,
            Outbound::Event(EventMessage::Fault { what }) => self.complain(format!("the server had a fault: {what}")),
            _ => {}
        }
    }

    fn answered(&mut self, kind: &str, seq: Option<u64>) {
        match seq.and_then(|seq| self.unanswered.remove(&seq)) {
            Some(_) => self.acknowledged += 1,
            None => self.complain(format!("{kind} with seq {seq:?}, which nothing waits for")),
        }
    }

    /// A frame arrived. Frames from before this run's first ownship were under way already and are nobody's fault.
    pub(super) fn frame(&mut self, frame: &Arrived<'_>, now: Duration) {
        let name = frame.view;
        let is_ours = self.host_frames.is_some_and(|[first, newest]| (first..=newest).contains(&frame.host_frame));
        if !is_ours {
            if self.views.contains_key(name) {
                self.complain(format!("{name}: host frame {} was never sent", frame.host_frame));
            }
            return;
        }
        let view = self.views.entry(name.to_owned()).or_default();
        let mut before = view.newest.replace((frame.number, frame.host_frame, frame.simulation_time_s));
        view.frames += 1;
        view.dropped = frame.dropped;
        view.first.get_or_insert(now);
        view.last = Some(now);
        if view.restarts > 0 && before.is_some_and(|(number, ..)| frame.number <= number) {
            view.restarts -= 1;
            before = None;
        }
        if let Some((number, host_frame, time_s)) = before {
            view.skipped += frame.number.saturating_sub(number + 1);
            if frame.number <= number || (self.lockstep && frame.number != number + 1) {
                self.complain(format!("{name}: frame {} follows frame {number}", frame.number));
            }
            if frame.host_frame < host_frame {
                self.complain(format!("{name}: host frame {} follows host frame {host_frame}", frame.host_frame));
            }
            if frame.simulation_time_s < time_s {
                self.complain(format!("{name}: time {} s follows {time_s} s", frame.simulation_time_s));
            }
        }
        self.check_picture(frame);
        if let Some(sent) = self.ownships.get(&frame.host_frame).copied() {
            self.delay_ms.add((now - sent).as_secs_f64() * 1e3);
            if let Some(delay) = frame.server_delay {
                self.server_delay_ms.add(delay.as_secs_f64() * 1e3);
            }
        }
        // Shown for the first time counts; later frames of the same message only show how rarely the host spoke.
        self.ownships = self.ownships.split_off(&frame.host_frame.saturating_add(1));
    }

    fn check_picture(&mut self, frame: &Arrived<'_>) {
        let [width, height] = frame.size_px;
        let inside = match frame.format {
            Format::Png => png_size(frame.picture),
            Format::Jpeg => jpeg_size(frame.picture),
            Format::Raw => {
                (frame.picture.len() as u64 == 4 * u64::from(width) * u64::from(height)).then_some(frame.size_px)
            }
        };
        if inside != Some(frame.size_px) {
            self.complain(format!(
                "{}: frame {} is {inside:?} pixels inside, its header says {:?}",
                frame.view, frame.number, frame.size_px
            ));
        }
        if self.sizes.get(frame.view).is_some_and(|sizes| !sizes.contains(&frame.size_px)) {
            self.complain(format!("{}: frame {} has a size that nobody asked for", frame.view, frame.number));
        }
    }

    /// Something is wrong.
    pub(super) fn complain(&mut self, complaint: String) {
        self.complaint_count += 1;
        if self.complaints.len() < KEPT {
            self.complaints.push(complaint);
        }
    }

    /// Whether every message was answered.
    pub(super) fn all_answered(&self) -> bool {
        self.unanswered.is_empty()
    }

    /// Frames of the view that has the fewest; 0 before each of `views` has one.
    pub(super) fn fewest_frames(&self, views: &[String]) -> u64 {
        views.iter().map(|v| self.views.get(v).map_or(0, |view| view.frames)).min().unwrap_or(0)
    }

    /// The run is over: what is still missing becomes a complaint.
    pub(super) fn end(&mut self, views: &[String]) {
        for (seq, what) in std::mem::take(&mut self.unanswered) {
            self.complain(format!("{what} with seq {seq} was never answered"));
        }
        for view in views {
            if !self.views.contains_key(view) {
                self.complain(format!("{view}: no frame arrived"));
            }
        }
    }

    /// The summary: one line a view, the delays, and what was wrong. The second value: how many complaints.
    pub(super) fn summary(&self) -> (String, u64) {
        let mut lines = Vec::new();
        for (name, view) in &self.views {
            let span_s = (view.last.unwrap_or_default() - view.first.unwrap_or_default()).as_secs_f64();
            let rate = if span_s > 0.0 { (view.frames - 1) as f64 / span_s } else { 0.0 };
            let View { frames, skipped, dropped, .. } = view;
            lines.push(format!(
                "view {name}: {frames} frames, {rate:.1} a second; {skipped} not sent, {dropped} of them dropped"
            ));
        }
        let delay = |spread: &Spread| match (spread.percentile(0.5), spread.percentile(0.99)) {
            (Some(median), Some(p99)) => format!("median {median:.1} ms, p99 {p99:.1} ms ({} frames)", spread.count()),
            _ => "not measured".to_owned(),
        };
        lines.push(format!("message to frame received: {}", delay(&self.delay_ms)));
        lines.push(format!("of which in the server: {}", delay(&self.server_delay_ms)));
        lines.push(format!("{} messages answered, {} strikes shown", self.acknowledged, self.strikes_shown));
        lines.extend(self.complaints.iter().map(|c| format!("wrong: {c}")));
        if self.complaint_count > self.complaints.len() as u64 {
            lines.push(format!("and {} more", self.complaint_count - self.complaints.len() as u64));
        }
        (lines.join("\n"), self.complaint_count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::control::out::{Ack, Refusal};
    use crate::world::event::Refused;

    const MS: Duration = Duration::from_millis(1);

    fn frame<'a>(number: u64, host_frame: u32, picture: &'a [u8]) -> Arrived<'a> {
        let server_delay = Some(2 * MS);
        let (size_px, format) = ([2, 1], Format::Raw);
        let (view, simulation_time_s, dropped) = ("out", 1.0, 0);
        Arrived { view, number, host_frame, simulation_time_s, size_px, format, dropped, picture, server_delay }
    }

    /// A watch that has seen one good frame, and the number of complaints after `change`.
    fn complaints_after(lockstep: bool, change: impl FnOnce(&mut Watch)) -> u64 {
        let mut watch = Watch::new(lockstep);
        watch.expect_size("out", [2, 1]);
        watch.sent(1, "ownship");
        watch.sent_ownship(5, MS);
        watch.frame(&frame(10, 5, &[0; 8]), 4 * MS);
        watch.control(&Outbound::Ack(Ack { seq: Some(1), flash: None }));
        change(&mut watch);
        watch.end(&["out".to_owned()]);
        watch.summary().1
    }

    #[test]
    fn a_good_run_has_no_complaints_and_its_delay_is_measured() {
        assert_eq!(complaints_after(false, |watch| watch.frame(&frame(12, 5, &[0; 8]), 5 * MS)), 0);
        assert_eq!(complaints_after(true, |watch| watch.frame(&frame(11, 5, &[0; 8]), 5 * MS)), 0);
        complaints_after(false, |watch| {
            watch.frame(&frame(12, 5, &[0; 8]), 9 * MS);
            let (text, _) = watch.summary();
            assert!(text.contains("received: median 3.0 ms, p99 3.0 ms (1 frames)"), "{text}");
            assert!(text.contains("view out: 2 frames, 200.0 a second; 1 not sent"), "{text}");
        });
    }

    #[test]
    fn everything_wrong_is_found() {
        type Change = fn(&mut Watch);
        let wrong: &[(&str, Change)] = &[
            ("a number again", |w| w.frame(&frame(10, 5, &[0; 8]), MS * 5)),
            ("a lower number", |w| w.frame(&frame(9, 5, &[0; 8]), MS * 5)),
            ("an older host frame", |w| {
                w.sent_ownship(6, MS);
                w.frame(&frame(11, 6, &[0; 8]), MS * 5);
                w.frame(&frame(12, 5, &[0; 8]), MS * 5);
            }),
            ("a host frame from before", |w| w.frame(&frame(11, 4, &[0; 8]), MS * 5)),
            ("numbers that begin again twice", |w| {
                w.made("out");
                w.frame(&frame(1, 5, &[0; 8]), MS * 5);
                w.frame(&frame(1, 5, &[0; 8]), MS * 5);
            }),
            ("a host frame from nowhere", |w| w.frame(&frame(11, 6, &[0; 8]), MS * 5)),
            ("an earlier time", |w| w.frame(&Arrived { simulation_time_s: 0.9, ..frame(11, 5, &[0; 8]) }, MS * 5)),
            ("a short picture", |w| w.frame(&frame(11, 5, &[0; 7]), MS * 5)),
            ("no PNG", |w| w.frame(&Arrived { format: Format::Png, ..frame(11, 5, &[0; 8]) }, MS * 5)),
            ("another size", |w| w.frame(&Arrived { size_px: [1, 2], ..frame(11, 5, &[0; 8]) }, MS * 5)),
            ("no answer", |w| w.sent(2, "weather")),
            ("an answer to nothing", |w| w.control(&Outbound::Ack(Ack { seq: Some(3), flash: None }))),
            ("an answer twice", |w| w.control(&Outbound::Ack(Ack { seq: Some(1), flash: None }))),
            ("an answer without a number", |w| w.control(&Outbound::Ack(Ack { seq: None, flash: None }))),
            ("a refusal", |w| {
                w.sent(2, "time");
                w.control(&Outbound::Refused(Refusal::new(Some(2), Refused::new("a", 1, "b", "c"), 0)));
            }),
            ("a fault", |w| w.control(&Outbound::Event(EventMessage::Fault { what: "x".into() }))),
            ("a view without frames", |w| w.end(&["other".to_owned()])),
        ];
        for (what, change) in wrong {
            assert_eq!(complaints_after(false, change), 1, "{what}");
        }
        assert_eq!(complaints_after(true, |w| w.frame(&frame(12, 5, &[0; 8]), MS * 5)), 1, "a gap in lockstep");
    }

    #[test]
    fn frames_from_before_the_run_and_views_made_again_are_no_fault() {
        let mut watch = Watch::new(true);
        watch.frame(&frame(7, 900, &[0; 3]), MS);
        watch.sent_ownship(5, MS);
        watch.frame(&frame(8, 901, &[0; 3]), MS);
        watch.frame(&frame(9, 5, &[0; 8]), MS);
        watch.made("out");
        watch.frame(&frame(1, 5, &[0; 8]), MS);
        watch.frame(&frame(2, 5, &[0; 8]), MS);
        watch.end(&["out".to_owned()]);
        assert_eq!(watch.summary().1, 0, "{}", watch.summary().0);
    }

    #[test]
    fn a_flood_of_complaints_is_counted_not_kept() {
        let mut watch = Watch::new(false);
        (0..1000).for_each(|n| watch.complain(n.to_string()));
        let (text, count) = watch.summary();
        assert_eq!(count, 1000);
        assert!(text.ends_with("and 980 more"), "{text}");
    }
}
