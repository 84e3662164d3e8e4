//! What plays a plan: the contract of the GPU executor and the reference executor.

use crate::frame::Pixels;
use crate::passes::relight::tables::Tables;
use crate::plan::FramePlan;
use std::sync::Arc;
use std::time::Duration;

/// Our own failure (not a client's): said once in the log, counted, never silent.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// No adapter: install a driver (`deploy/install-vulkan` installs Mesa's software Vulkan) or use the reference executor.
    #[error(
        "no graphics adapter found; run deploy/install-vulkan for Mesa's software Vulkan, or use --executor reference"
    )]
    NoAdapter,
    /// The device was lost: the render thread makes a new executor and goes on.
    #[error("the graphics device was lost: {0}")]
    DeviceLost(String),
    /// The device refused the work of one picture (for want of memory, or against one of its rules) and would refuse it
    /// again. The render thread makes a new executor, without that picture.
    #[error("the graphics device refused a picture: {0}")]
    Rejected(String),
    /// The adapter cannot do what the plan needs: that picture is not drawn, the executor is as it was.
    #[error("the graphics adapter cannot do this: {0}")]
    Unsupported(String),
}

/// A picture that is ready.
#[derive(Clone, Debug)]
pub struct Finished {
    /// The number given to [`Executor::submit`].
    pub ticket: u64,
    /// The picture.
    pub pixels: Pixels,
    /// How long it took from the drawn picture to its pixels in main memory.
    pub read_back: Duration,
    /// Whether it stands in for one for which something is still being made.
    pub provisional: bool,
}

/// Pictures in a row that do without something before it is forgotten: ten seconds at 60 a second, so that a look aside or another
/// view does not have it made again.
pub const PATIENCE: u32 = 600;

/// Counts pictures in a row that did without something that is kept.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unused(u32);

impl Unused {
    /// Takes a picture that needs it or not: whether it is to be forgotten now.
    pub fn is_due(&mut self, needed: bool) -> bool {
        self.0 = if needed { 0 } else { self.0.saturating_add(1) };
        self.0 == PATIENCE
    }
}

/// Plays plans. Owned by the render thread alone.
pub trait Executor {
    /// One line for the log and the metrics: which executor on which adapter.
    fn describe(&self) -> String;

    /// Begins to draw; at most [`Executor::depth`] tickets may be under way.
    ///
    /// # Errors
    /// A [`Fault`]: the ticket then gives no picture.
    fn submit(&mut self, ticket: u64, plan: &FramePlan) -> Result<(), Fault>;

    /// Pictures that are ready, in the order of their submission. `wait`: blocks until the oldest one under way is ready.
    ///
    /// # Errors
    /// A [`Fault`]: the pictures under way are lost.
    fn collect(&mut self, wait: bool) -> Result<Vec<Finished>, Fault>;

    /// How many tickets may be under way at once (the read-back ring).
    fn depth(&self) -> usize;

    /// The tables of virtual lights that it draws flashes by, so that others can tell how far they are; `None`: it has none.
    fn tables(&self) -> Option<Arc<Tables>> {
        None
    }

    /// Buffers, textures, views and bind groups held on the device now; 0 where there is none. Flat in the long run.
    fn object_count(&self) -> usize {
        0
    }
}
