//! OpenEXR: the linear picture before exposure, in cd/m2, for measuring.

use super::{EncodeError, Format};
use exr::prelude::{Encoding, Image, Layer, LayerAttributes, SpecificChannels, WritableImage};
use std::io::Cursor;

pub(super) fn encode(rgb: &[f32], width: u32, height: u32) -> Result<Vec<u8>, EncodeError> {
    let (width, height) = (width as usize, height as usize);
    let channels = SpecificChannels::rgb(|at: exr::math::Vec2<usize>| {
        let first = (at.y() * width + at.x()) * 3;
        (rgb[first], rgb[first + 1], rgb[first + 2])
    });
    // ZIP in blocks of 16 rows: lossless, and what other programs read fastest.
    let encoding = Encoding { compression: exr::prelude::Compression::ZIP16, ..Encoding::FAST_LOSSLESS };
    let layer = Layer::new((width, height), LayerAttributes::default(), encoding, channels);
    let mut out = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .to_buffered(&mut out)
        .map_err(|error| EncodeError::Codec(format!("{:?}: {error}", Format::Exr)))?;
    Ok(out.into_inner())
}
