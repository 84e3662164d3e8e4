//! A flash as geometry and time: strokes, photometry.

pub mod flash;
pub mod photometry;
pub mod random;
