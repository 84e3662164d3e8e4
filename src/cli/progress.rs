//! How far a long piece of work is: one line that rewrites itself on a terminal, nothing elsewhere.

use std::io::{IsTerminal, Write};

/// A line on stderr that shows how many of a number of things are done. Gone when dropped.
pub(super) struct Progress {
    what: &'static str,
    total: usize,
    shown: bool,
}

impl Progress {
    /// Begins; shows nothing unless stderr is a terminal and there is more than one thing to do.
    pub(super) fn new(what: &'static str, total: usize) -> Self {
        Self { what, total, shown: total > 1 && std::io::stderr().is_terminal() }
    }

    /// `done` of the things are done.
    pub(super) fn show(&self, done: usize) {
        if self.shown {
            const WIDTH: usize = 30;
            let filled = WIDTH * done / self.total.max(1);
            let bar = "#".repeat(filled) + &"-".repeat(WIDTH - filled);
            // A terminal that went away is no reason to stop the work.
            let _ = write!(std::io::stderr(), "\r{} [{bar}] {done}/{}", self.what, self.total);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if self.shown {
            let _ = write!(std::io::stderr(), "\r\x1b[K");
        }
    }
}
