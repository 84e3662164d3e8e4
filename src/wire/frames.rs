//! Frame messages: a fixed header, then the picture. `protocol/frames.md` is its byte table; a test holds both together.

use super::control::Format;
use super::limits;
use crate::bytes::{Reader, TooShort, Writer};
use crate::frame::LatencyStamps;

/// The first four bytes of every frame message.
pub const MAGIC: [u8; 4] = *b"SDFR";
/// Version of the header.
pub const VERSION: u16 = 1;
/// Length of the header that this version writes.
pub const HEADER_BYTES: usize = 128;
/// Bytes of the view's name.
const VIEW_BYTES: usize = 32;

/// Name, offset and length in bytes of every field, in order.
pub const FIELDS: &[(&str, usize, usize)] = &[
    ("magic", 0, 4),
    ("version", 4, 2),
    ("header_bytes", 6, 2),
    ("format", 8, 2),
    ("flags", 10, 2),
    ("width_px", 12, 4),
    ("height_px", 16, 4),
    ("host_frame", 20, 4),
    ("frame", 24, 8),
    ("view", 32, VIEW_BYTES),
    ("simulation_time_s", 64, 8),
    ("received_us", 72, 8),
    ("snapshot_us", 80, 8),
    ("submitted_us", 88, 8),
    ("finished_us", 96, 8),
    ("encoded_us", 104, 8),
    ("sent_us", 112, 8),
    ("dropped", 120, 4),
    ("payload_bytes", 124, 4),
];

const PROVISIONAL: u16 = 1;
const REPEATED: u16 = 2;
const LAST_OF_STEP: u16 = 4;

/// What a client is told about a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameHeader {
    /// Format of the picture.
    pub format: Format,
    /// Something was still being prepared and a stand-in was drawn.
    pub provisional: bool,
    /// Nothing had changed since the view's previous frame.
    pub repeated: bool,
    /// The last frame that this client gets of a lockstep step.
    pub last_of_step: bool,
    /// Width of the picture.
    pub width_px: u32,
    /// Height of the picture.
    pub height_px: u32,
    /// Frame number of the newest ownship message that the picture shows; 0 before the first.
    pub host_frame: u32,
    /// Number of the frame, rising by one for each frame of the view.
    pub frame: u64,
    /// The view's name.
    pub view: String,
    /// Simulation time.
    pub simulation_time_s: f64,
    /// Stations up to the finished picture.
    pub stamps: LatencyStamps,
    /// The bytes of the format were there, in microseconds since the server started.
    pub encoded_us: u64,
    /// The message was given to the socket, in microseconds since the server started.
    pub sent_us: u64,
    /// Frames of this subscription that were dropped so far because the client read too slowly.
    pub dropped: u32,
    /// Length of the picture that follows.
    pub payload_bytes: u32,
}

/// Why bytes are no frame message, or a header cannot be written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FrameError {
    /// The message ends too early.
    #[error(transparent)]
    TooShort(#[from] TooShort),
    /// It begins otherwise.
    #[error("not a frame message: it begins with {0:?}, not with SDFR")]
    Magic([u8; 4]),
    /// Another version of the header.
    #[error("frame header version {0}; this program reads version {VERSION}")]
    Version(u16),
    /// A field has a value that it cannot have.
    #[error("{field} = {value}: {limit}")]
    Field {
        /// The field.
        field: &'static str,
        /// Its value.
        value: String,
        /// What is allowed.
        limit: String,
    },
}

/// The bytes of a header.
///
/// # Errors
/// [`FrameError::Field`]: a value that a client would refuse.
pub fn encode_header(header: &FrameHeader) -> Result<Vec<u8>, FrameError> {
    check(header)?;
    let mut writer = Writer::with_capacity(HEADER_BYTES);
    writer.put(&MAGIC);
    writer.put_u16_le(VERSION);
    writer.put_u16_le(HEADER_BYTES as u16);
    writer.put_u16_le(match header.format {
        Format::Raw => 0,
        Format::Png => 1,
        Format::Jpeg => 2,
    });
    let flag = |is_set: bool, bit: u16| if is_set { bit } else { 0 };
    writer.put_u16_le(
        flag(header.provisional, PROVISIONAL)
            | flag(header.repeated, REPEATED)
            | flag(header.last_of_step, LAST_OF_STEP),
    );
    writer.put_u32_le(header.width_px);
    writer.put_u32_le(header.height_px);
    writer.put_u32_le(header.host_frame);
    writer.put_u64_le(header.frame);
    writer.put_padded(header.view.as_bytes(), VIEW_BYTES);
    writer.put_f64_le(header.simulation_time_s);
    writer.put_u64_le(header.stamps.received_us);
    writer.put_u64_le(header.stamps.snapshot_us);
    writer.put_u64_le(header.stamps.submitted_us);
    writer.put_u64_le(header.stamps.finished_us);
    writer.put_u64_le(header.encoded_us);
    writer.put_u64_le(header.sent_us);
    writer.put_u32_le(header.dropped);
    writer.put_u32_le(header.payload_bytes);
    Ok(writer.into_bytes())
}

/// A whole message: the header, whose `payload_bytes` is set to the picture's length, and the picture.
///
/// # Errors
/// [`FrameError::Field`]: a value that a client would refuse.
pub fn encode_message(header: &FrameHeader, picture: &[u8]) -> Result<Vec<u8>, FrameError> {
    let payload_bytes = u32::try_from(picture.len()).unwrap_or(u32::MAX);
    let mut message = encode_header(&FrameHeader { payload_bytes, ..header.clone() })?;
    message.reserve_exact(picture.len());
    message.extend_from_slice(picture);
    Ok(message)
}

/// Header and picture of a message.
///
/// # Errors
/// [`FrameError`]: what is wrong with it.
pub fn decode_message(message: &[u8]) -> Result<(FrameHeader, &[u8]), FrameError> {
    let mut reader = Reader::new(message);
    let header = read_header(&mut reader)?;
    let picture = reader.rest();
    if picture.len() != header.payload_bytes as usize {
        let limit = format!("{} bytes follow the header", picture.len());
        return Err(wrong("payload_bytes", header.payload_bytes, limit));
    }
    Ok((header, picture))
}

/// The header at the front of these bytes.
///
/// # Errors
/// [`FrameError`]: what is wrong with it.
pub fn decode_header(bytes: &[u8]) -> Result<FrameHeader, FrameError> {
    read_header(&mut Reader::new(bytes))
}

/// Reads a header and stops behind it.
fn read_header(reader: &mut Reader) -> Result<FrameHeader, FrameError> {
    let magic = reader.take(4)?;
    if magic != MAGIC {
        return Err(FrameError::Magic([magic[0], magic[1], magic[2], magic[3]]));
    }
    let version = reader.u16_le()?;
    if version != VERSION {
        return Err(FrameError::Version(version));
    }
    let header_bytes = reader.u16_le()?;
    if usize::from(header_bytes) != HEADER_BYTES {
        return Err(wrong("header_bytes", header_bytes, format!("{HEADER_BYTES} in version {VERSION}")));
    }
    let format = match reader.u16_le()? {
        0 => Format::Raw,
        1 => Format::Png,
        2 => Format::Jpeg,
        other => return Err(wrong("format", other, "0 raw, 1 PNG, 2 JPEG")),
    };
    let flags = reader.u16_le()?;
    if flags & !(PROVISIONAL | REPEATED | LAST_OF_STEP) != 0 {
        return Err(wrong("flags", flags, "bits 0 to 2"));
    }
    let header = FrameHeader {
        format,
        provisional: flags & PROVISIONAL != 0,
        repeated: flags & REPEATED != 0,
        last_of_step: flags & LAST_OF_STEP != 0,
        width_px: reader.u32_le()?,
        height_px: reader.u32_le()?,
        host_frame: reader.u32_le()?,
        frame: reader.u64_le()?,
        view: view(reader.take(VIEW_BYTES)?)?,
        simulation_time_s: reader.f64_le()?,
        stamps: LatencyStamps {
            received_us: reader.u64_le()?,
            snapshot_us: reader.u64_le()?,
            submitted_us: reader.u64_le()?,
            finished_us: reader.u64_le()?,
        },
        encoded_us: reader.u64_le()?,
        sent_us: reader.u64_le()?,
        dropped: reader.u32_le()?,
        payload_bytes: reader.u32_le()?,
    };
    check(&header)?;
    Ok(header)
}

/// The name in its fixed field: what follows the first zero is zero.
fn view(field: &[u8]) -> Result<String, FrameError> {
    let length = field.iter().position(|&byte| byte == 0).unwrap_or(field.len());
    let (name, padding) = field.split_at(length);
    if padding.iter().any(|&byte| byte != 0) {
        return Err(wrong("view", String::from_utf8_lossy(field), "zeros behind the name"));
    }
    Ok(String::from_utf8_lossy(name).into_owned())
}

/// What holds of every header, whoever made it.
fn check(header: &FrameHeader) -> Result<(), FrameError> {
    let is_named = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if header.view.is_empty() || header.view.len() > VIEW_BYTES || !header.view.chars().all(is_named) {
        return Err(wrong("view", &header.view, format!("1 to {VIEW_BYTES} letters, digits, - and _")));
    }
    for (field, size_px) in [("width_px", header.width_px), ("height_px", header.height_px)] {
        if !(limits::SIZE_PX.min..=limits::SIZE_PX.max).contains(&u64::from(size_px)) {
            return Err(wrong(field, size_px, format!("{} to {}", limits::SIZE_PX.min, limits::SIZE_PX.max)));
        }
    }
    if !header.simulation_time_s.is_finite() {
        return Err(wrong("simulation_time_s", header.simulation_time_s, "a finite number"));
    }
    if header.payload_bytes > limits::FRAME_PAYLOAD_BYTES {
        return Err(wrong("payload_bytes", header.payload_bytes, format!("at most {}", limits::FRAME_PAYLOAD_BYTES)));
    }
    let raw_bytes = u64::from(header.width_px) * u64::from(header.height_px) * 4;
    if header.format == Format::Raw && u64::from(header.payload_bytes) != raw_bytes {
        return Err(wrong(
            "payload_bytes",
            header.payload_bytes,
            format!("{raw_bytes} for a raw picture of this size"),
        ));
    }
    Ok(())
}

fn wrong(field: &'static str, value: impl ToString, limit: impl Into<String>) -> FrameError {
    FrameError::Field { field, value: value.to_string(), limit: limit.into() }
}

#[cfg(test)]
mod tests;
