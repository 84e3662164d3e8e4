//! Formats: from pixels to the bytes of a picture file. Pure functions; the server runs them on its blocking pool.

mod exr;
mod jpeg;
mod png;

use crate::frame::{Frame, Pixels};

/// A picture format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Format {
    /// The pixels as they are: 4 bytes (red, green, blue, 255) or, for linear pictures, three little-endian f32 a pixel.
    Raw,
    /// PNG, 8 bits, RGB, marked sRGB; lossless, with the fastest compression that still compresses.
    Png,
    /// JPEG, 4:2:0.
    Jpeg {
        /// 1 (smallest) to 100 (best).
        quality: u8,
    },
    /// OpenEXR, linear RGB, 32-bit float, in cd/m2.
    Exr,
}

impl Format {
    /// The media type for HTTP.
    pub fn media_type(self) -> &'static str {
        match self {
            Self::Raw => "application/octet-stream",
            Self::Png => "image/png",
            Self::Jpeg { .. } => "image/jpeg",
            Self::Exr => "image/x-exr",
        }
    }
}

/// Why a picture could not be encoded.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EncodeError {
    /// Tone-mapped formats take 8-bit pixels, EXR takes linear ones.
    #[error("{format:?} needs {needs} pixels; draw the picture with that output")]
    WrongPixels {
        /// What was asked for.
        format: Format,
        /// What it is made from.
        needs: &'static str,
    },
    /// The number of values does not belong to this width and height.
    #[error("{width}x{height} pixels need {expected} values, found {found}")]
    WrongLength {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// Values that the size asks for.
        expected: usize,
        /// Values found.
        found: usize,
    },
    /// The format cannot hold a picture of this size (JPEG: 65,535 pixels a side; all: at least one pixel).
    #[error("{format:?} cannot hold {width}x{height} pixels")]
    Size {
        /// What was asked for.
        format: Format,
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },
    /// The codec said no.
    #[error("encoding failed: {0}")]
    Codec(String),
}

/// The bytes of `frame` in `format`.
///
/// # Errors
/// [`EncodeError`]: the pixels are of the wrong kind or number for the format.
pub fn encode(frame: &Frame, format: Format) -> Result<Vec<u8>, EncodeError> {
    encode_pixels(&frame.pixels, frame.width, frame.height, format)
}

/// The bytes of a picture of `width` by `height` pixels in `format`.
///
/// # Errors
/// As [`encode`].
pub fn encode_pixels(pixels: &Pixels, width: u32, height: u32, format: Format) -> Result<Vec<u8>, EncodeError> {
    if width == 0 || height == 0 {
        return Err(EncodeError::Size { format, width, height });
    }
    let (channels, found) = match pixels {
        Pixels::Srgb8(bytes) => (4, bytes.len()),
        Pixels::LinearRgb(values) => (3, values.len()),
    };
    let expected = width as usize * height as usize * channels;
    if expected != found {
        return Err(EncodeError::WrongLength { width, height, expected, found });
    }
    match (format, pixels) {
        (Format::Raw, Pixels::Srgb8(rgba)) => Ok(rgba.clone()),
        (Format::Raw, Pixels::LinearRgb(rgb)) => Ok(rgb.iter().flat_map(|value| value.to_le_bytes()).collect()),
        (Format::Png, Pixels::Srgb8(rgba)) => png::encode(rgba, width, height),
        (Format::Jpeg { quality }, Pixels::Srgb8(rgba)) => jpeg::encode(rgba, width, height, quality),
        (Format::Exr, Pixels::LinearRgb(rgb)) => exr::encode(rgb, width, height),
        (Format::Exr, Pixels::Srgb8(_)) => Err(EncodeError::WrongPixels { format, needs: "linear" }),
        (Format::Png | Format::Jpeg { .. }, Pixels::LinearRgb(_)) => {
            Err(EncodeError::WrongPixels { format, needs: "tone-mapped 8-bit" })
        }
    }
}

#[cfg(test)]
mod tests;
