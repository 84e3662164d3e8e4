//! The one result type of every subject, and the report: results with the machine on which they were measured.

use super::figure::Figure;
use super::machine;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;

/// Everything measured in one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Processor, threads and system.
    pub machine: String,
    /// Graphics adapter and driver, or why there is none.
    pub adapter: String,
    /// Version of stormdeck.
    pub version: String,
    /// Commit of the checkout, or "unknown".
    pub commit: String,
    /// One for each case, method, setting and metric.
    pub results: Vec<CaseResult>,
    /// Pictures for the HTML page.
    #[serde(skip)]
    pub figures: Vec<Figure>,
}

impl Report {
    /// A report without results from this machine.
    pub fn new(adapter: String) -> Self {
        Self {
            machine: machine::describe(),
            adapter,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: machine::commit(),
            results: Vec::new(),
            figures: Vec::new(),
        }
    }
}

/// One method with one setting on one case, its error by one metric and its run time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CaseResult {
    /// Subject, such as `deck`.
    pub subject: String,
    /// What was computed, such as `cumulus under`. Methods are compared within a case.
    pub case: String,
    /// Which method computed it.
    pub method: String,
    /// The method's settings.
    pub params: BTreeMap<String, Value>,
    /// How wrong it is.
    pub error: ErrorValue,
    /// How long it took; null where time was not measured.
    pub time_s: Option<TimeSpread>,
    /// Memory that the result needs while it is in use, where it is known.
    pub memory_bytes: Option<u64>,
    /// What a reader should know.
    pub notes: Vec<String>,
}

/// An error by one metric against one reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorValue {
    /// Name of the metric; smaller values are better.
    pub metric: String,
    /// What it was compared with.
    pub reference: String,
    /// The error; null where it is not finite or was not measured (a note says which).
    pub value: Option<f64>,
}

/// Run time over repetitions, in seconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimeSpread {
    /// Median.
    pub median: f64,
    /// Shortest.
    pub min: f64,
    /// Longest.
    pub max: f64,
    /// Number of repetitions.
    pub runs: u32,
}

impl TimeSpread {
    /// The spread of measured times in seconds; `None` for none. The median of an even number is the mean of the middle two.
    pub fn of(times_s: &[f64]) -> Option<Self> {
        let mut sorted = times_s.to_vec();
        sorted.sort_by(f64::total_cmp);
        let (min, max) = (*sorted.first()?, *sorted.last()?);
        let half = sorted.len() / 2;
        let median = if sorted.len() % 2 == 1 { sorted[half] } else { 0.5 * (sorted[half - 1] + sorted[half]) };
        Some(Self { median, min, max, runs: sorted.len() as u32 })
    }
}

/// A case on its way into the report: one setting of one method, with an error for each metric and reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    case: String,
    method: String,
    params: BTreeMap<String, Value>,
    errors: Vec<ErrorValue>,
    time_s: Option<TimeSpread>,
    memory_bytes: Option<u64>,
    notes: Vec<String>,
}

impl Case {
    /// A case that a method computed.
    pub fn new(case: impl Into<String>, method: impl Into<String>) -> Self {
        Self {
            case: case.into(),
            method: method.into(),
            params: BTreeMap::new(),
            errors: Vec::new(),
            time_s: None,
            memory_bytes: None,
            notes: Vec::new(),
        }
    }

    /// With a setting of the method.
    pub fn param(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.params.insert(name.to_owned(), value.into());
        self
    }

    /// With an error. May be called for several metrics and references; a value that is not finite is kept as "none",
    /// with a note.
    pub fn error(mut self, metric: &str, reference: &str, value: f64) -> Self {
        if !value.is_finite() {
            self.notes.push(format!("{metric} against {reference} is not finite"));
        }
        let value = value.is_finite().then_some(value);
        self.errors.push(ErrorValue { metric: metric.to_owned(), reference: reference.to_owned(), value });
        self
    }

    /// With its run time.
    pub fn time(mut self, time_s: TimeSpread) -> Self {
        self.time_s = Some(time_s);
        self
    }

    /// With the memory that it needs.
    pub fn memory(mut self, bytes: u64) -> Self {
        self.memory_bytes = Some(bytes);
        self
    }

    /// With a note for the reader.
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }

    /// One result for each error; a case without any gives one result without a value.
    pub(super) fn results(mut self, subject: &str) -> Vec<CaseResult> {
        if self.errors.is_empty() {
            self.errors.push(ErrorValue { metric: "none".into(), reference: "none".into(), value: None });
        }
        let errors = std::mem::take(&mut self.errors);
        let result = |error| CaseResult {
            subject: subject.to_owned(),
            case: self.case.clone(),
            method: self.method.clone(),
            params: self.params.clone(),
            error,
            time_s: self.time_s,
            memory_bytes: self.memory_bytes,
            notes: self.notes.clone(),
        };
        errors.into_iter().map(result).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spread_is_that_of_the_times() {
        let spread = TimeSpread::of(&[3.0, 1.0, 2.0, 10.0]).expect("times");
        assert_eq!(spread, TimeSpread { median: 2.5, min: 1.0, max: 10.0, runs: 4 });
        assert_eq!(TimeSpread::of(&[7.0]).map(|s| s.median), Some(7.0));
        assert_eq!(TimeSpread::of(&[]), None);
    }

    #[test]
    fn a_case_gives_one_result_for_each_error_and_hides_no_nan() {
        let case = Case::new("c", "m").param("slices", 32).error("mse", "fine", 0.5).error("flip", "fine", f64::NAN);
        let results = case.results("deck");
        assert_eq!(results.len(), 2);
        assert_eq!(results[0].error.value, Some(0.5));
        assert_eq!(results[1].error.value, None);
        assert!(results[1].notes[0].contains("not finite"), "{:?}", results[1].notes);
        assert_eq!(results[0].params["slices"], 32);
        assert_eq!(Case::new("c", "m").results("deck")[0].error.metric, "none");
    }

    #[test]
    fn a_report_survives_its_json() {
        let mut report = Report::new("none".into());
        report.results = Case::new("c", "m").param("a", "x").error("mse", "fine", 0.125).results("deck");
        let text = serde_json::to_string(&report).expect("a report");
        assert_eq!(serde_json::from_str::<Report>(&text).expect("the same"), report);
        for key in ["machine", "adapter", "version", "commit", "results"] {
            assert!(text.contains(&format!("\"{key}\":")), "{key}");
        }
    }
}
