//! The passes: one folder each. `mod.rs` declares the parameters, `NAME.wgsl` runs on the GPU, `twin.rs` is the same on
//! the CPU. `common.wgsl` and its twin [`common`] hold what several passes share.
//!
//! Axes of every pass: east, north, up at the eye's ground point; metres, f32, relative to that point. The Earth is a
//! sphere of the local mean radius of curvature. Luminance is in cd/m2 until `exposure` scales it.

pub mod airlight;
pub mod beams;
pub mod common;
pub mod cull;
pub mod deck;
pub mod glow;
pub mod ground;
pub mod light;
pub mod relief;
pub mod relight;
pub mod sampling;
pub mod shadow;
pub mod sky;
pub mod stroke;
pub mod tonemap;
pub mod veil;
