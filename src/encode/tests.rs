//! Every format is pinned by decoding what was encoded, with a decoder that is not ours.

use super::*;
use ::exr::prelude::{ReadChannels, ReadLayers};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;

/// A smooth picture: JPEG is meant for these, and every pixel differs from its neighbours.
fn gradient(width: u32, height: u32) -> Vec<u8> {
    (0..height).flat_map(|y| (0..width).flat_map(move |x| [x as u8 * 3, y as u8 * 5, (x + y) as u8, 255])).collect()
}

#[test]
fn png_gives_back_every_pixel() {
    let rgba = gradient(37, 21);
    let bytes = encode_pixels(&Pixels::Srgb8(rgba.clone()), 37, 21, Format::Png).unwrap();
    let mut reader = ::png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut decoded = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut decoded).unwrap();
    assert_eq!((info.width, info.height, info.color_type), (37, 21, ::png::ColorType::Rgb));
    let expected: Vec<u8> = rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
    assert_eq!(decoded, expected);
}

#[test]
fn jpeg_is_near_and_better_quality_is_nearer() {
    let rgba = gradient(40, 24);
    let error_at = |quality| {
        let bytes = encode_pixels(&Pixels::Srgb8(rgba.clone()), 40, 24, Format::Jpeg { quality }).unwrap();
        let mut decoder = JpegDecoder::new(ZCursor::new(bytes));
        let decoded = decoder.decode().unwrap();
        let info = decoder.info().unwrap();
        assert_eq!((info.width, info.height), (40, 24));
        let expected = rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]);
        let sum: u32 = decoded.iter().zip(expected).map(|(a, b)| u32::from(a.abs_diff(b))).sum();
        f64::from(sum) / decoded.len() as f64
    };
    // Quantisation at quality 95 and halved colour resolution on a ramp of 3 to 5 steps a pixel: about one step's width.
    assert!(error_at(95) < 5.0, "{}", error_at(95));
    assert!(error_at(95) < error_at(20), "{} {}", error_at(95), error_at(20));
}

#[test]
fn exr_gives_back_every_value_including_the_sun() {
    let mut rgb: Vec<f32> = (0..11 * 7 * 3).map(|i| i as f32 * 0.37).collect();
    rgb[5] = 1.6e9;
    let bytes = encode_pixels(&Pixels::LinearRgb(rgb.clone()), 11, 7, Format::Exr).unwrap();
    let image = ::exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![0.0_f32; size.area() * 3]),
            |(width, values), at, (r, g, b): (f32, f32, f32)| {
                let first = (at.y() * *width + at.x()) * 3;
                values[first..first + 3].copy_from_slice(&[r, g, b]);
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(std::io::Cursor::new(bytes))
        .unwrap();
    let (width, values) = &image.layer_data.channel_data.pixels;
    assert_eq!((*width, values), (11, &rgb));
}

#[test]
fn raw_is_the_pixels() {
    let rgba = gradient(3, 2);
    assert_eq!(encode_pixels(&Pixels::Srgb8(rgba.clone()), 3, 2, Format::Raw).unwrap(), rgba);
    let linear = encode_pixels(&Pixels::LinearRgb(vec![1.0, -2.5, 0.0]), 1, 1, Format::Raw).unwrap();
    assert_eq!(linear, [0, 0, 0x80, 0x3f, 0, 0, 0x20, 0xc0, 0, 0, 0, 0]);
}

#[test]
fn what_does_not_fit_is_said_and_not_drawn() {
    let eight = Pixels::Srgb8(gradient(2, 2));
    assert!(matches!(encode_pixels(&eight, 2, 2, Format::Exr), Err(EncodeError::WrongPixels { needs: "linear", .. })));
    assert!(matches!(
        encode_pixels(&eight, 3, 2, Format::Png),
        Err(EncodeError::WrongLength { expected: 24, found: 16, .. })
    ));
    assert!(matches!(encode_pixels(&eight, 0, 2, Format::Png), Err(EncodeError::Size { .. })));
    let linear = Pixels::LinearRgb(vec![0.0; 3]);
    assert!(matches!(encode_pixels(&linear, 1, 1, Format::Png), Err(EncodeError::WrongPixels { .. })));
    let wide = Pixels::Srgb8(vec![255; 70_000 * 4]);
    assert!(matches!(encode_pixels(&wide, 70_000, 1, Format::Jpeg { quality: 80 }), Err(EncodeError::Size { .. })));
}
