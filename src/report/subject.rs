//! What a subject is, and what it is given to work with.

use super::figure::Figure;
use super::result::Case;

/// Something whose error is measured against its run time.
#[derive(Clone, Copy, Debug)]
pub struct Subject {
    /// Name on the command line.
    pub name: &'static str,
    /// One sentence: what is compared with what.
    pub about: &'static str,
    /// Measures every case. With [`Run::quick`] in a few seconds, else in a few minutes at most.
    pub measure: fn(&mut Run) -> Result<(), Stopped>,
}

/// Why a subject ended before its last case.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Stopped {
    /// A file of the report could not be written.
    #[error("{path}: cannot be written: {error}")]
    Write {
        /// The file.
        path: String,
        /// The system's complaint.
        error: std::io::Error,
    },
    /// The subject could not go on.
    #[error("{0}")]
    Failed(String),
}

/// One run of one subject: takes its results as they come.
pub struct Run<'a> {
    quick: bool,
    sink: &'a mut dyn FnMut(Item) -> Result<(), Stopped>,
}

/// What a subject hands over.
pub(super) enum Item {
    Case(Case),
    Figure(Figure),
}

impl<'a> Run<'a> {
    pub(super) fn new(quick: bool, sink: &'a mut dyn FnMut(Item) -> Result<(), Stopped>) -> Self {
        Self { quick, sink }
    }

    /// Whether fewer and smaller cases are asked for.
    pub fn quick(&self) -> bool {
        self.quick
    }

    /// The value for a quick run, or the one for a whole run.
    pub fn pick<T>(&self, quick: T, whole: T) -> T {
        if self.quick { quick } else { whole }
    }

    /// Hands a measured case over; every file of the report is rewritten with it.
    ///
    /// # Errors
    /// [`Stopped::Write`]: pass it on, the run is over.
    pub fn record(&mut self, case: Case) -> Result<(), Stopped> {
        (self.sink)(Item::Case(case))
    }

    /// Hands a picture for the HTML page over.
    ///
    /// # Errors
    /// [`Stopped::Write`]: pass it on, the run is over.
    pub fn figure(&mut self, figure: Figure) -> Result<(), Stopped> {
        (self.sink)(Item::Figure(figure))
    }
}
