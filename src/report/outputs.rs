//! The report's files: opened before the run, so that a wrong path costs no hours, and rewritten after each case, so that
//! a run that is broken off leaves what it had.

use super::result::Report;
use super::subject::Stopped;
use super::{csv, html};
use std::fs::{File, OpenOptions};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Where the report goes, beside the terminal.
#[derive(Clone, Debug, Default)]
pub struct Paths {
    /// JSON.
    pub json: Option<PathBuf>,
    /// Comma-separated values.
    pub csv: Option<PathBuf>,
    /// One self-contained page.
    pub html: Option<PathBuf>,
}

/// A file that cannot be opened for writing.
#[derive(Debug, thiserror::Error)]
#[error("{path}: cannot be written: {error}")]
pub struct OpenFailure {
    path: String,
    error: std::io::Error,
}

type Format = fn(&Report) -> String;

/// Files ready to be written.
#[derive(Default)]
pub struct Outputs {
    files: Vec<(PathBuf, File, Format)>,
}

impl Outputs {
    /// Opens every file; they are made where they are missing and keep what they hold until the first write.
    ///
    /// # Errors
    /// [`OpenFailure`] for the first that cannot be written.
    pub fn open(paths: &Paths) -> Result<Self, OpenFailure> {
        let wanted: [(&Option<PathBuf>, Format); 3] =
            [(&paths.json, json), (&paths.csv, csv::csv), (&paths.html, html::page)];
        let mut files = Vec::new();
        for (path, format) in wanted {
            let Some(path) = path else { continue };
            let opened = OpenOptions::new().write(true).create(true).truncate(false).open(path);
            let file = opened.map_err(|error| OpenFailure { path: path.display().to_string(), error })?;
            files.push((path.clone(), file, format));
        }
        Ok(Self { files })
    }

    /// Rewrites every file with the report as it is now.
    pub(super) fn write(&mut self, report: &Report) -> Result<(), Stopped> {
        for (path, file, format) in &mut self.files {
            let wrong = |error| Stopped::Write { path: Path::display(path).to_string(), error };
            rewrite(file, &format(report)).map_err(wrong)?;
        }
        Ok(())
    }
}

fn json(report: &Report) -> String {
    // A report is text, numbers and lists: nothing that JSON cannot hold.
    serde_json::to_string_pretty(report).unwrap_or_default() + "\n"
}

fn rewrite(file: &mut File, text: &str) -> std::io::Result<()> {
    file.seek(SeekFrom::Start(0))?;
    file.write_all(text.as_bytes())?;
    // A device such as /dev/stdout has no length to set.
    if file.metadata()?.is_file() {
        file.set_len(text.len() as u64)?;
    }
    file.flush()
}

#[cfg(test)]
mod tests {
    use super::super::result::Case;
    use super::*;

    #[test]
    fn files_hold_the_report_of_the_last_write_and_nothing_after_it() {
        let folder = std::env::temp_dir().join(format!("stormdeck-outputs-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let at = |name: &str| Some(folder.join(name));
        let paths = Paths { json: at("r.json"), csv: at("r.csv"), html: at("r.html") };
        let mut outputs = Outputs::open(&paths).expect("files");
        let mut report = Report::new("none".into());
        report.results = Case::new("a long case ".repeat(50), "m").error("mse", "fine", 1.0).results("deck");
        outputs.write(&report).expect("written");
        report.results = Case::new("short", "m").error("mse", "fine", 1.0).results("deck");
        outputs.write(&report).expect("rewritten");
        let text = |name: &str| std::fs::read_to_string(folder.join(name)).expect("the file");
        assert_eq!(serde_json::from_str::<Report>(&text("r.json")).expect("the report"), report);
        assert!(text("r.csv").ends_with("\r\n") && !text("r.csv").contains("a long case"));
        assert!(text("r.html").trim_end().ends_with("</html>"));
        let missing = Paths { json: at("no folder/r.json"), ..Paths::default() };
        assert!(Outputs::open(&missing).is_err());
        let _gone = std::fs::remove_dir_all(&folder);
    }
}
