//! Occlusion: stops the deck where nothing more can be seen.
//!
//! Between batches of instances, pixels that are opaque are moved to the front of the depth range, so that the early
//! depth test refuses what follows. It changes no luminance by more than the share [`crate::passes::deck::twin::OPAQUE`].
//!
//! No twin: on the CPU the walk along a ray simply stops (`deck::twin::walk`), which the comparison of the deck covers.
