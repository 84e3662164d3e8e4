//! JPEG: for live pictures, where bytes and time count more than the last bit.

use super::{EncodeError, Format};
use jpeg_encoder::{ColorType, Encoder, SamplingFactor};

pub(super) fn encode(rgba: &[u8], width: u32, height: u32, quality: u8) -> Result<Vec<u8>, EncodeError> {
    let format = Format::Jpeg { quality };
    let (Ok(width_16), Ok(height_16)) = (u16::try_from(width), u16::try_from(height)) else {
        return Err(EncodeError::Size { format, width, height });
    };
    let mut out = Vec::with_capacity(rgba.len() / 8);
    let mut encoder = Encoder::new(&mut out, quality.clamp(1, 100));
    encoder.set_sampling_factor(SamplingFactor::F_2_2);
    encoder
        .encode(rgba, width_16, height_16, ColorType::Rgba)
        .map_err(|error| EncodeError::Codec(format!("{format:?}: {error}")))?;
    Ok(out)
}
