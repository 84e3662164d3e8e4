//! The plan: what one frame needs, as a value. Pure, no I/O, cannot fail.

pub mod executor;

use crate::world::snapshot::{Snapshot, ViewState};

/// What one frame of one view needs: the passes in order with their parameters, and why each is there or not.
#[derive(Clone, Debug, PartialEq)]
pub struct FramePlan {
    /// Width and height in pixels.
    pub size_px: [u32; 2],
    /// One line a pass: kept or left out, and why.
    pub notes: Vec<PassNote>,
}

/// One line of the explanation of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PassNote {
    /// Name of the pass.
    pub pass: &'static str,
    /// Whether it runs.
    pub kept: bool,
    /// The sentence that explains it.
    pub why: String,
}

/// What form the picture takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Output {
    /// Tone-mapped, 8 bits, sRGB.
    Srgb8,
    /// Linear luminance in cd/m2, before exposure.
    LinearRgb,
}

/// The plan of one view of a snapshot.
pub fn plan(snapshot: &Snapshot, view: &ViewState, output: Output) -> FramePlan {
    let _ = (snapshot, output);
    FramePlan { size_px: view.size_px, notes: Vec::new() }
}
