//! The report as CSV (RFC 4180): one line for each result, the machine on each line so that files can be joined.

use super::result::{CaseResult, Report};

const HEAD: &str = "subject,case,method,params,metric,reference,error,time_median_s,time_min_s,time_max_s,runs,memory_bytes,\
notes,machine,adapter,version,commit";

/// The results as comma-separated values, lines ended by CR LF, `params` as JSON, empty where there is no number.
pub fn csv(report: &Report) -> String {
    let mut text = format!("{HEAD}\r\n");
    for result in &report.results {
        text += &line(report, result).join(",");
        text += "\r\n";
    }
    text
}

fn line(report: &Report, result: &CaseResult) -> Vec<String> {
    let number = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:e}"));
    let params = serde_json::to_string(&result.params).unwrap_or_default();
    let time = result.time_s;
    let CaseResult { subject, case, method, error, .. } = result;
    vec![
        field(subject),
        field(case),
        field(method),
        field(&params),
        field(&error.metric),
        field(&error.reference),
        number(error.value),
        number(time.map(|t| t.median)),
        number(time.map(|t| t.min)),
        number(time.map(|t| t.max)),
        time.map_or_else(String::new, |t| t.runs.to_string()),
        result.memory_bytes.map_or_else(String::new, |bytes| bytes.to_string()),
        field(&result.notes.join("; ")),
        field(&report.machine),
        field(&report.adapter),
        field(&report.version),
        field(&report.commit),
    ]
}

/// One field: in quotes where it needs them. A text that a spreadsheet would run as a formula gets an apostrophe.
fn field(text: &str) -> String {
    let text = if text.starts_with(['=', '+', '-', '@']) { format!("'{text}") } else { text.to_owned() };
    let plain = !text.contains(['"', ',', '\r', '\n']);
    if plain { text } else { format!("\"{}\"", text.replace('"', "\"\"")) }
}

#[cfg(test)]
mod tests {
    use super::super::result::{Case, TimeSpread};
    use super::*;

    #[test]
    fn fields_are_quoted_where_they_must_be() {
        assert_eq!(field("plain text"), "plain text");
        assert_eq!(field("a,b"), "\"a,b\"");
        assert_eq!(field("say \"x\"\n"), "\"say \"\"x\"\"\n\"");
        assert_eq!(field("=1+1"), "'=1+1");
    }

    #[test]
    fn every_line_has_every_column() {
        let mut report = Report::new("none".into());
        let time = TimeSpread { median: 0.5, min: 0.25, max: 1.0, runs: 3 };
        let case = Case::new("case", "m").param("n", 8).time(time).memory(64).error("mse", "fine", 0.125);
        report.results = case.results("deck");
        report.results.extend(Case::new("case", "bare").results("deck"));
        (report.machine, report.commit) = ("cpu".into(), "abc".into());
        let text = csv(&report);
        let lines: Vec<&str> = text.split("\r\n").collect();
        let version = env!("CARGO_PKG_VERSION");
        let numbers = "1.25e-1,5e-1,2.5e-1,1e0,3,64";
        assert_eq!(lines[1], format!("deck,case,m,\"{{\"\"n\"\":8}}\",mse,fine,{numbers},,cpu,none,{version},abc"));
        assert_eq!(lines[2].split(',').count(), HEAD.split(',').count());
        assert_eq!(lines[3], "");
    }
}
