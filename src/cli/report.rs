//! `stormdeck report`: error against run time, as a table, JSON, CSV and one HTML page, held against stored bounds.

use super::Failure;
use super::scenario::text_of;
use crate::gpu;
use crate::report::{self, Bounds, Happening, Outputs, Paths, Report, Subject, Verdict};
use std::path::{Path, PathBuf};

/// Longest file of bounds, in bytes.
const BOUNDS_BYTES: usize = 1 << 20;

/// Measures error against run time of every approximation, each against its named reference.
#[derive(Debug, clap::Args)]
pub(super) struct Options {
    /// What to measure; everything when none is named. `--list` shows what there is.
    #[arg(value_name = "SUBJECT")]
    subjects: Vec<String>,
    /// Fewer and smaller cases: seconds instead of minutes.
    #[arg(long)]
    quick: bool,
    /// Writes the results as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Writes the results as comma-separated values.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Writes one self-contained page with plots.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Holds the results against the bounds of this file; ends with 1 when one is broken.
    #[arg(long, value_name = "FILE")]
    check: Option<PathBuf>,
    /// Shows the subjects and ends.
    #[arg(long)]
    list: bool,
}

/// Runs the subjects asked for.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    if options.list {
        for subject in report::subjects() {
            println!("{:<12} {}", subject.name, subject.about);
        }
        return Ok(());
    }
    let subjects = chosen(&options.subjects)?;
    let bounds = options.check.as_deref().map(bounds).transpose()?;
    let paths = Paths { json: options.json.clone(), csv: options.csv.clone(), html: options.html.clone() };
    let mut outputs = Outputs::open(&paths).map_err(|failure| Failure::Input(failure.to_string()))?;
    let adapter = gpu::adapter().unwrap_or_else(|fault| format!("none: {fault}"));
    let mut report = Report::new(adapter);
    eprintln!("{}; adapter: {}", report.machine, report.adapter);
    let outcome = report::run(&subjects, options.quick, &mut report, &mut outputs, &mut tell);
    print!("{}", report::table(&report.results));
    let failed = outcome.map_err(|stopped| Failure::Run(stopped.to_string()))?;
    if let Some((path, bounds)) = options.check.as_deref().zip(bounds) {
        let names: Vec<&str> = subjects.iter().map(|subject| subject.name).collect();
        judge(path, &bounds.check(&report, &names, options.quick))?;
    }
    match failed {
        0 => Ok(()),
        n => Err(Failure::Run(format!("{n} of {} subjects did not end", subjects.len()))),
    }
}

/// The subjects of these names, each once, in the order in which the report knows them; all without names.
fn chosen(names: &[String]) -> Result<Vec<Subject>, Failure> {
    let known = report::subjects();
    let unknown: Vec<&str> =
        names.iter().map(String::as_str).filter(|name| known.iter().all(|s| s.name != *name)).collect();
    if !unknown.is_empty() {
        let known: Vec<&str> = known.iter().map(|s| s.name).collect();
        return Err(Failure::Input(format!("no subject `{}`; there are: {}", unknown.join("`, `"), known.join(", "))));
    }
    Ok(known.iter().filter(|s| names.is_empty() || names.iter().any(|name| name == s.name)).copied().collect())
}

fn bounds(path: &Path) -> Result<Bounds, Failure> {
    let text = text_of(path, BOUNDS_BYTES)?;
    Bounds::parse(&text).map_err(|why| Failure::Input(format!("{}: {why}", path.display())))
}

/// One line on stderr for each thing that happens: the report itself goes to stdout.
fn tell(happening: Happening) {
    match happening {
        Happening::Begins(subject) => eprintln!("{}: {}", subject.name, subject.about),
        Happening::Measured(results) => {
            if let Some(result) = results.first() {
                let params: Vec<String> = result.params.iter().map(|(name, value)| format!("{name}={value}")).collect();
                let time = result.time_s.map_or_else(String::new, |t| format!(", {:.3e} s", t.median));
                eprintln!("  {}: {} {}{time}", result.case, result.method, params.join(" "));
            }
        }
        Happening::Failed(subject, stopped) => eprintln!("{} did not end: {stopped}", subject.name),
    }
}

fn judge(path: &Path, verdict: &Verdict) -> Result<(), Failure> {
    if verdict.holds() {
        println!("{}: {} limits kept, {} bounds left out", path.display(), verdict.compared, verdict.left_out);
        return Ok(());
    }
    let lines = verdict.broken.join("\n");
    Err(Failure::Run(format!("{}: {} broken\n{lines}", path.display(), verdict.broken.len())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn subjects_are_chosen_by_name_and_unknown_ones_refused() {
        let all = report::subjects();
        assert_eq!(chosen(&[]).map(|s| s.len()).ok(), Some(all.len()));
        let one = all[0].name.to_owned();
        assert_eq!(chosen(&[one.clone(), one]).map(|s| s.len()).ok(), Some(1));
        assert!(matches!(chosen(&["weather".to_owned()]), Err(Failure::Input(text)) if text.contains(all[0].name)));
    }
}
