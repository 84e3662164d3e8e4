//! Subject `encode`: what each picture format loses, how long it takes, and how many bytes it makes.

use super::result::Case;
use super::scene::{EyePoint, layer, picture, snapshot};
use super::subject::{Run, Stopped, Subject};
use super::timing::measure;
use crate::clouds::CloudKind;
use crate::encode::{Format, encode_pixels};
use crate::frame::Pixels;
use crate::numeric::metrics::{relative_mse, rms_of_codes};
use crate::plan::Output;
use crate::world::DEFAULT_QUALITY;
use crate::world::snapshot::Quality;

/// Picture formats.
pub const SUBJECT: Subject = Subject {
    name: "encode",
    about: "picture formats: what they lose against the pixels given, time and bytes",
    measure: cases,
};

const QUALITIES: [u8; 7] = [30, 50, 70, 80, 90, 95, 100];

fn cases(run: &mut Run) -> Result<(), Stopped> {
    let size_px = run.pick([320, 180], [1280, 720]);
    let eye = EyePoint { altitude_m: 500.0, pitch_deg: 8.0, size_px, field_of_view_deg: 60.0 };
    let quality = Quality { slices: 16, deck_scale: 2, ring_ratio: 1.5, ..DEFAULT_QUALITY };
    let weather = snapshot(eye, &[layer(CloudKind::Cumulus, 1000.0, 1200.0)], quality)?;
    let size = format!("{} x {}", size_px[0], size_px[1]);
    let runs = run.pick(3, 15);

    let tonemapped = picture(&weather, Output::Srgb8)?;
    // Raw pixels are not compared: they are a copy, which no format beats.
    let lossy = QUALITIES.map(|quality| ("JPEG", quality, Format::Jpeg { quality }));
    for (name, quality, format) in [("PNG", 0, Format::Png)].into_iter().chain(lossy) {
        let (bytes, time_s) = encoded(&tonemapped, size_px, format, runs)?;
        let error = rms_of_codes(&decoded(format, &bytes)?, &rgb(&tonemapped));
        let mut case = Case::new(format!("tone-mapped, {size}"), name).time(time_s).memory(bytes.len() as u64);
        if quality > 0 {
            case = case.param("quality", quality);
        }
        run.record(case.error("RMS of sRGB codes", "the pixels given", error))?;
    }
    let linear = picture(&weather, Output::LinearRgb)?;
    let (bytes, time_s) = encoded(&linear, size_px, Format::Exr, runs)?;
    let error = relative_mse(&decoded_linear(Format::Exr, &bytes)?, values(&linear));
    let case = Case::new(format!("linear, {size}"), "EXR").time(time_s).memory(bytes.len() as u64);
    run.record(case.error("relative MSE", "the pixels given", error))
}

fn encoded(
    pixels: &Pixels,
    [width, height]: [u32; 2],
    format: Format,
    runs: u32,
) -> Result<(Vec<u8>, super::TimeSpread), Stopped> {
    let (bytes, time_s) = measure(runs, || encode_pixels(pixels, width, height, format));
    bytes.map(|bytes| (bytes, time_s)).map_err(|error| Stopped::Failed(error.to_string()))
}

fn rgb(pixels: &Pixels) -> Vec<u8> {
    match pixels {
        Pixels::Srgb8(rgba) => rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect(),
        Pixels::LinearRgb(_) => Vec::new(),
    }
}

fn values(pixels: &Pixels) -> &[f32] {
    match pixels {
        Pixels::LinearRgb(values) => values,
        Pixels::Srgb8(_) => &[],
    }
}

/// Red, green and blue of an 8-bit picture file, by decoders that are not ours.
fn decoded(format: Format, bytes: &[u8]) -> Result<Vec<u8>, Stopped> {
    let wrong = |error: &dyn std::fmt::Display| Stopped::Failed(format!("{format:?} does not decode: {error}"));
    match format {
        Format::Raw => Ok(bytes.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect()),
        Format::Png => {
            let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().map_err(|e| wrong(&e))?;
            let mut rgb = vec![0; reader.output_buffer_size().unwrap_or(0)];
            reader.next_frame(&mut rgb).map_err(|e| wrong(&e))?;
            Ok(rgb)
        }
        Format::Jpeg { .. } => zune_jpeg::JpegDecoder::new(zune_jpeg::zune_core::bytestream::ZCursor::new(bytes))
            .decode()
            .map_err(|e| wrong(&e)),
        Format::Exr => Err(wrong(&"it holds linear values")),
    }
}

/// The values of a linear picture file.
fn decoded_linear(format: Format, bytes: &[u8]) -> Result<Vec<f32>, Stopped> {
    if format == Format::Raw {
        let value = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
        return Ok(bytes.chunks_exact(4).map(value).collect());
    }
    use exr::prelude::*;
    let wrong = |error: exr::error::Error| Stopped::Failed(format!("{format:?} does not decode: {error}"));
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![0f32; size.width() * size.height() * 3]),
            |(width, values), at, (r, g, b): (f32, f32, f32)| {
                values[(at.y() * *width + at.x()) * 3..][..3].copy_from_slice(&[r, g, b]);
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(std::io::Cursor::new(bytes))
        .map_err(wrong)?;
    Ok(image.layer_data.channel_data.pixels.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decoders_give_back_what_was_encoded() {
        let codes: Vec<u8> = (0..8 * 4).flat_map(|i| [i as u8 * 7, 3 * i as u8, 200, 255]).collect();
        let pixels = Pixels::Srgb8(codes);
        for format in [Format::Raw, Format::Png] {
            let bytes = encode_pixels(&pixels, 8, 4, format).expect("encoded");
            assert_eq!(decoded(format, &bytes).expect("decoded"), rgb(&pixels));
        }
        let linear = Pixels::LinearRgb((0..8 * 4 * 3).map(|i| 0.37 * i as f32).collect());
        for format in [Format::Raw, Format::Exr] {
            let bytes = encode_pixels(&linear, 8, 4, format).expect("encoded");
            assert_eq!(decoded_linear(format, &bytes).expect("decoded"), values(&linear));
        }
        assert!(decoded(Format::Png, b"no picture").is_err());
    }
}
