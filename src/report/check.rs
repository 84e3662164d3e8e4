//! Stored bounds: what a report must not exceed. A bound that nothing measured fits is broken too.
//!
//! A file of bounds is JSON: `{"bounds": [{"subject": "deck", "case": "under", "method": "slices", "params": {"slices": 32},
//! "metric": "relative MSE", "reference": "converged", "max_error": 0.01}]}`. Selectors that are left out fit everything.

use super::result::{CaseResult, Report};
use super::units;
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// Bounds read from a file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bounds {
    bounds: Vec<Bound>,
}

/// What some results must keep to.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Bound {
    subject: String,
    case: Option<String>,
    method: Option<String>,
    #[serde(default)]
    params: BTreeMap<String, Value>,
    metric: Option<String>,
    reference: Option<String>,
    max_error: Option<f64>,
    /// Upper bound of the median. Times depend on the machine: prefer `faster_than`.
    max_time_s: Option<f64>,
    max_memory_bytes: Option<u64>,
    faster_than: Option<FasterThan>,
    /// Only for whole runs: a quick one does not measure it.
    #[serde(default)]
    whole_run_only: bool,
}

/// The median time of the named method on the same case is at least `ratio` times as long.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct FasterThan {
    method: String,
    #[serde(default)]
    params: BTreeMap<String, Value>,
    ratio: f64,
}

/// What came of a check.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdict {
    /// Limits that were compared with a result.
    pub compared: usize,
    /// Bounds whose subject was not run, or that are for whole runs only.
    pub left_out: usize,
    /// What is wrong, one sentence each.
    pub broken: Vec<String>,
}

impl Verdict {
    /// Whether every bound holds; false when nothing was compared at all.
    pub fn holds(&self) -> bool {
        self.broken.is_empty() && self.compared > 0
    }
}

impl Bounds {
    /// Reads bounds.
    ///
    /// # Errors
    /// A sentence with the line: not JSON, an unknown field, a bound without a limit, or no bound at all.
    pub fn parse(text: &str) -> Result<Self, String> {
        let bounds: Self = serde_json::from_str(text).map_err(|error| error.to_string())?;
        if bounds.bounds.is_empty() {
            return Err("holds no bounds".to_owned());
        }
        let empty = bounds.bounds.iter().position(|b| {
            b.max_error.is_none() && b.max_time_s.is_none() && b.max_memory_bytes.is_none() && b.faster_than.is_none()
        });
        match empty {
            Some(at) => {
                Err(format!("bounds[{at}] sets no limit (max_error, max_time_s, max_memory_bytes, faster_than)"))
            }
            None => Ok(bounds),
        }
    }

    /// Holds a report of these subjects against the bounds.
    pub fn check(&self, report: &Report, subjects: &[&str], quick: bool) -> Verdict {
        let mut verdict = Verdict::default();
        for (at, bound) in self.bounds.iter().enumerate() {
            if !subjects.contains(&bound.subject.as_str()) || (quick && bound.whole_run_only) {
                verdict.left_out += 1;
                continue;
            }
            let fitting: Vec<&CaseResult> = report.results.iter().filter(|result| bound.fits(result)).collect();
            if fitting.is_empty() {
                verdict.broken.push(format!("bounds[{at}] ({}): nothing measured fits it", bound.subject));
            }
            for result in fitting {
                bound.compare(report, result, &mut verdict);
            }
        }
        if verdict.compared == 0 && verdict.broken.is_empty() {
            verdict.broken.push("no bound is about anything that was run".to_owned());
        }
        verdict
    }
}

impl Bound {
    fn fits(&self, result: &CaseResult) -> bool {
        let is = |wanted: &Option<String>, found: &str| wanted.as_deref().is_none_or(|wanted| wanted == found);
        self.subject == result.subject
            && is(&self.case, &result.case)
            && is(&self.method, &result.method)
            && is(&self.metric, &result.error.metric)
            && is(&self.reference, &result.error.reference)
            && holds_all(&result.params, &self.params)
    }

    fn compare(&self, report: &Report, result: &CaseResult, verdict: &mut Verdict) {
        let params = serde_json::to_string(&result.params).unwrap_or_default();
        let name = format!("{} / {} / {} {params}", result.subject, result.case, result.method);
        let mut limit = |what: &str, value: Option<f64>, most: f64, shown: fn(f64) -> String| {
            verdict.compared += 1;
            // Written so that a value that is missing, or not a number, breaks the bound.
            if !value.is_some_and(|value| value <= most) {
                let value = value.map_or_else(|| "none".to_owned(), shown);
                verdict.broken.push(format!("{name}: {what} is {value}, at most {}", shown(most)));
            }
        };
        if let Some(most) = self.max_error {
            let what = format!("{} against {}", result.error.metric, result.error.reference);
            limit(&what, result.error.value, most, units::number);
        }
        if let Some(most) = self.max_time_s {
            limit("median time", result.time_s.map(|t| t.median), most, units::time);
        }
        if let Some(most) = self.max_memory_bytes {
            limit("memory", result.memory_bytes.map(|bytes| bytes as f64), most as f64, |v| units::bytes(v as u64));
        }
        if let Some(faster) = &self.faster_than {
            let other = report.results.iter().find(|other| {
                other.subject == result.subject
                    && other.case == result.case
                    && other.method == faster.method
                    && holds_all(&other.params, &faster.params)
                    && other.time_s.is_some()
            });
            let times = result.time_s.zip(other.and_then(|other| other.time_s));
            let share = times.map(|(own, other)| own.median / other.median);
            limit(&format!("time over that of {}", faster.method), share, 1.0 / faster.ratio, units::number);
        }
    }
}

fn holds_all(params: &BTreeMap<String, Value>, wanted: &BTreeMap<String, Value>) -> bool {
    // Numbers are compared as numbers: 32 fits 32.0.
    let same = |a: &Value, b: &Value| a == b || a.as_f64().zip(b.as_f64()).is_some_and(|(a, b)| a == b);
    wanted.iter().all(|(name, value)| params.get(name).is_some_and(|found| same(found, value)))
}

#[cfg(test)]
mod tests {
    use super::super::result::{Case, TimeSpread};
    use super::*;

    fn report() -> Report {
        let mut report = Report::new("none".into());
        for (method, n, error, seconds) in [("fast", 8, 0.1, 1.0), ("plain", 8, 0.0, 3.0), ("nan", 8, f64::NAN, 1.0)] {
            let time_s = TimeSpread { median: seconds, min: seconds, max: seconds, runs: 1 };
            let case = Case::new("c", method).param("n", n).time(time_s).memory(100).error("mse", "fine", error);
            report.results.extend(case.results("deck"));
        }
        report
    }

    fn broken(bound: &str) -> usize {
        let bounds = Bounds::parse(&format!("{{\"bounds\": [{bound}]}}")).expect("bounds");
        bounds.check(&report(), &["deck"], false).broken.len()
    }

    #[test]
    fn bounds_that_hold_and_bounds_that_break() {
        let rows = [
            (r#"{"subject": "deck", "method": "fast", "max_error": 0.1}"#, 0),
            (r#"{"subject": "deck", "method": "fast", "max_error": 0.09}"#, 1),
            (r#"{"subject": "deck", "method": "fast", "params": {"n": 8.0}, "metric": "mse", "max_time_s": 1.0}"#, 0),
            (r#"{"subject": "deck", "method": "fast", "max_time_s": 0.9, "max_memory_bytes": 99}"#, 2),
            (r#"{"subject": "deck", "method": "nan", "max_error": 1e9}"#, 1),
            (r#"{"subject": "deck", "max_error": 1.0}"#, 1),
            (r#"{"subject": "deck", "method": "fast", "params": {"n": 9}, "max_error": 1}"#, 1),
            (r#"{"subject": "deck", "reference": "coarse", "max_error": 1}"#, 1),
            (r#"{"subject": "deck", "method": "fast", "faster_than": {"method": "plain", "ratio": 2.5}}"#, 0),
            (r#"{"subject": "deck", "method": "fast", "faster_than": {"method": "plain", "ratio": 3.5}}"#, 1),
            (r#"{"subject": "deck", "method": "fast", "faster_than": {"method": "gone", "ratio": 1}}"#, 1),
        ];
        for (bound, expected) in rows {
            assert_eq!(broken(bound), expected, "{bound}");
        }
    }

    #[test]
    fn a_check_that_compares_nothing_fails() {
        let text = r#"{"bounds": [{"subject": "deck", "max_error": 1, "whole_run_only": true}]}"#;
        let bounds = Bounds::parse(text).expect("bounds");
        for (subjects, quick) in [(vec!["encode"], false), (vec!["deck"], true)] {
            let verdict = bounds.check(&report(), &subjects, quick);
            assert!(!verdict.holds() && verdict.left_out == 1, "{verdict:?}");
        }
    }

    #[test]
    fn the_bounds_of_the_repository_are_right_and_about_known_subjects() {
        let text = include_str!("../../benches/bounds.json");
        let bounds = Bounds::parse(text).expect("bounds");
        let known = crate::report::subjects();
        assert!(bounds.bounds.iter().all(|bound| known.iter().any(|subject| subject.name == bound.subject)));
    }

    #[test]
    fn a_wrong_file_is_refused() {
        for (text, why) in [
            ("{", "EOF"),
            (r#"{"bounds": []}"#, "no bounds"),
            (r#"{"bounds": [{"subject": "deck"}]}"#, "no limit"),
            (r#"{"bounds": [{"subject": "deck", "max_eror": 1}]}"#, "max_eror"),
            (r#"{"bounds": [{"max_error": 1}]}"#, "subject"),
        ] {
            let complaint = Bounds::parse(text).expect_err(text);
            assert!(complaint.contains(why), "{complaint}");
        }
    }
}
