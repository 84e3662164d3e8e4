//! A flash as geometry and time: strokes, photometry.
