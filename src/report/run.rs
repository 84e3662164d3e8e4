//! Runs subjects and keeps the report and its files up to date.

use super::outputs::Outputs;
use super::result::{CaseResult, Report};
use super::subject::{Item, Run, Stopped, Subject};

/// What the caller is told while it runs.
#[derive(Debug)]
pub enum Happening<'a> {
    /// A subject begins.
    Begins(&'a Subject),
    /// A case is measured: its results, one for each metric.
    Measured(&'a [CaseResult]),
    /// A subject ended before its last case.
    Failed(&'a Subject, &'a Stopped),
}

/// Runs the subjects one after the other into `report`. A subject that fails does not keep the others from running.
/// Answers how many failed.
///
/// # Errors
/// [`Stopped::Write`]: a file could not be written, and nothing more was run.
pub fn run(
    subjects: &[Subject],
    quick: bool,
    report: &mut Report,
    outputs: &mut Outputs,
    tell: &mut dyn FnMut(Happening),
) -> Result<usize, Stopped> {
    outputs.write(report)?;
    let mut failed = 0;
    for subject in subjects {
        tell(Happening::Begins(subject));
        let mut sink = |item: Item| {
            match item {
                Item::Case(case) => {
                    let results = case.results(subject.name);
                    tell(Happening::Measured(&results));
                    report.results.extend(results);
                }
                Item::Figure(mut figure) => {
                    figure.subject = subject.name.to_owned();
                    report.figures.push(figure);
                }
            }
            outputs.write(report)
        };
        match (subject.measure)(&mut Run::new(quick, &mut sink)) {
            Ok(()) => {}
            Err(stopped @ Stopped::Write { .. }) => return Err(stopped),
            Err(stopped) => {
                failed += 1;
                tell(Happening::Failed(subject, &stopped));
            }
        }
    }
    Ok(failed)
}

#[cfg(test)]
mod tests {
    use super::super::figure::Figure;
    use super::super::outputs::Paths;
    use super::super::result::Case;
    use super::*;

    const GOOD: Subject = Subject {
        name: "good",
        about: "two cases and a picture",
        measure: |run| {
            run.record(Case::new(run.pick("small", "large"), "m").error("e", "r", 1.0).error("f", "r", 2.0))?;
            run.figure(Figure::png("t", "c", vec![1]))?;
            run.record(Case::new("b", "m").error("e", "r", 2.0))
        },
    };
    const BAD: Subject = Subject {
        name: "bad",
        about: "fails after its first case",
        measure: |run| {
            run.record(Case::new("a", "m"))?;
            Err(Stopped::Failed("out of luck".into()))
        },
    };

    #[test]
    fn a_subject_that_fails_leaves_its_cases_and_the_others() {
        let mut report = Report::new("none".into());
        let mut told = Vec::new();
        let mut tell = |happening: Happening| {
            told.push(match happening {
                Happening::Begins(subject) => subject.name.to_owned(),
                Happening::Measured(results) => format!("{} results", results.len()),
                Happening::Failed(_, stopped) => stopped.to_string(),
            });
        };
        let failed = run(&[BAD, GOOD], true, &mut report, &mut Outputs::default(), &mut tell).expect("written");
        assert_eq!(failed, 1);
        assert_eq!(told, ["bad", "1 results", "out of luck", "good", "2 results", "1 results"]);
        assert_eq!(report.results.len(), 4);
        assert_eq!((report.results[1].subject.as_str(), report.results[1].case.as_str()), ("good", "small"));
        assert_eq!(report.figures[0].subject, "good");
    }

    #[test]
    fn files_are_rewritten_after_each_case() {
        let path = std::env::temp_dir().join(format!("stormdeck-run-{}.json", std::process::id()));
        let paths = Paths { json: Some(path.clone()), ..Paths::default() };
        let mut outputs = Outputs::open(&paths).expect("the file");
        let mut seen = Vec::new();
        let mut tell = |_: Happening| {
            let text = std::fs::read_to_string(&path).expect("the file");
            seen.push(serde_json::from_str::<Report>(&text).expect("a whole report").results.len());
        };
        run(&[GOOD], false, &mut Report::new("none".into()), &mut outputs, &mut tell).expect("written");
        // Told before the write of the case itself: at the beginning, then with nothing, then with two results.
        assert_eq!(seen, [0, 0, 2]);
        let _gone = std::fs::remove_file(&path);
    }
}
