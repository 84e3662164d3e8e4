//! Error against run time: every approximation of the house measured against its named reference.
//!
//! A *subject* (one file, one row of [`subjects`]) measures its methods case by case and hands each to [`Run::record`].
//! The report prints a table, writes JSON, CSV and one HTML page with plots, and holds results against stored bounds.

mod check;
mod compression;
mod csv;
mod deck;
mod empty_space;
mod encode;
mod figure;
mod glow;
mod html;
mod images;
mod latency;
mod lightning;
mod lit_cloud;
mod machine;
mod memory;
mod omission;
mod outputs;
mod pareto;
mod pivot;
mod relight;
mod result;
mod run;
mod scattering;
mod scene;
mod shadow;
mod sky;
mod stability;
mod subject;
mod table;
mod timing;
mod units;

pub use check::{Bounds, Verdict};
pub use figure::Figure;
pub use outputs::{OpenFailure, Outputs, Paths};
pub use result::{Case, CaseResult, ErrorValue, Report, TimeSpread};
pub use run::{Happening, run};
pub use subject::{Run, Stopped, Subject};
pub use table::table;
pub use timing::measure;

/// Every subject that `stormdeck report` knows, in the order in which they run. One line and one file each.
pub fn subjects() -> &'static [Subject] {
    &[
        deck::SUBJECT,
        shadow::SUBJECT,
        glow::SUBJECT,
        sky::SUBJECT,
        encode::SUBJECT,
        lightning::SUBJECT,
        scattering::SUBJECT,
        compression::SUBJECT,
        relight::SUBJECT,
        stability::SUBJECT,
        omission::SUBJECT,
        latency::SUBJECT,
    ]
}
