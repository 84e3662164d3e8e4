//! The source files on disk, and what is asked of each: an opening sentence and at most 500 lines.

use std::path::{Path, PathBuf};

/// Most lines of one file.
const MOST_LINES: usize = 500;

/// A source file: its path from the root of the repository, with `/`, and its text.
pub struct Source {
    pub path: String,
    pub text: String,
}

impl Source {
    /// A made-up file for the tests of the checkers.
    pub fn new(path: &str, text: &str) -> Self {
        Self { path: path.to_owned(), text: text.to_owned() }
    }
}

/// The root of the repository.
pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Every `.rs`, `.wgsl` and `.py` file under the given folders, by path.
pub fn sources(folders: &[&str]) -> Vec<Source> {
    let mut found = Vec::new();
    for folder in folders {
        collect(&root().join(folder), &mut found);
    }
    found.sort();
    found
        .into_iter()
        .map(|path| {
            let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
            let relative = path.strip_prefix(root()).expect("a file under the root");
            Source { path: relative.to_string_lossy().replace('\\', "/"), text }
        })
        .collect()
}

fn collect(folder: &Path, found: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries {
        let path = entry.expect("a readable folder").path();
        if path.is_dir() {
            collect(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs" || e == "wgsl" || e == "py") {
            found.push(path);
        }
    }
}

/// What is wrong with the form of these files.
pub fn complaints(sources: &[Source]) -> Vec<String> {
    let mut complaints = Vec::new();
    for Source { path, text } in sources {
        let lines = text.lines().count();
        if lines > MOST_LINES {
            complaints.push(format!("{path}: {lines} lines, at most {MOST_LINES}; split it by ideas"));
        }
        if !opens_with_a_sentence(path, text) {
            complaints.push(format!("{path}: does not open with what the file is"));
        }
    }
    complaints
}

fn opens_with_a_sentence(path: &str, text: &str) -> bool {
    let first = text.lines().find(|line| !line.starts_with("#!")).unwrap_or_default();
    let marker = match path.rsplit('.').next() {
        Some("rs") => "//! ",
        Some("wgsl") => "// ",
        _ => "\"\"\"",
    };
    first.strip_prefix(marker).is_some_and(|sentence| sentence.len() >= 10)
}

#[test]
fn a_file_without_a_header_or_too_long_is_found() {
    let long = "//! A long file, for the test.\n".to_owned() + &"//\n".repeat(MOST_LINES);
    let bad = [
        Source::new("src/a.rs", "use std::fmt;\n//! Too late for a header.\n"),
        Source::new("src/b.rs", "//! \n"),
        Source::new("src/c.wgsl", "fn main() {}\n"),
        Source::new("src/d.rs", &long),
        Source::new("src/e.rs", ""),
        Source::new("protocol/f.py", "#!/usr/bin/env python3\nimport sys\n"),
    ];
    for file in &bad {
        let found = complaints(std::slice::from_ref(file));
        assert_eq!(found.len(), 1, "{}: {found:?}", file.path);
    }
    let good = [
        Source::new("src/a.rs", "//! A file that says what it is.\nuse std::fmt;\n"),
        Source::new("src/a.wgsl", "// A shader that says what it is.\n"),
        Source::new("a.py", "#!/usr/bin/env python3\n\"\"\"A script that says what it is.\"\"\"\n"),
    ];
    assert_eq!(complaints(&good), Vec::<String>::new());
}
