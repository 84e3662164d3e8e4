//! A frame: the finished picture of one view at one moment, with what a client needs to trust it.

use std::sync::Arc;

/// What a picture is made of. Rows run from the top, pixels from the left, both without padding.
#[derive(Clone, Debug, PartialEq)]
pub enum Pixels {
    /// `width * height * 4` bytes: red, green, blue (sRGB-encoded) and 255.
    Srgb8(Vec<u8>),
    /// `width * height * 3` linear values: luminance per channel in cd/m2 (before exposure and tone mapping).
    LinearRgb(Vec<f32>),
}

/// When a frame passed the stations of the flow, in microseconds since the server started.
///
/// `received` is 0 when no host message led to this frame (free running without a host).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LatencyStamps {
    /// The newest host message that this frame shows had been read from its socket.
    pub received_us: u64,
    /// The snapshot was taken.
    pub snapshot_us: u64,
    /// The executor was given the plan.
    pub submitted_us: u64,
    /// The pixels were back in main memory.
    pub finished_us: u64,
}

/// The picture of one view at one moment.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Name of the view.
    pub view: String,
    /// Rises by one for each frame of this view.
    pub number: u64,
    /// Frame number that the host gave with the newest ownship message shown here; 0 before the first.
    pub host_frame: u32,
    /// Simulation time in seconds.
    pub simulation_time_s: f64,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The pixels; shared, because a repeated frame is its predecessor's picture under a new number.
    pub pixels: Arc<Pixels>,
    /// True when something was still being prepared and a stand-in was drawn.
    pub provisional: bool,
    /// True when nothing had changed since the view's previous frame, whose pixels these are.
    pub repeated: bool,
    /// Stations passed.
    pub stamps: LatencyStamps,
}
