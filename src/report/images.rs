//! Pictures of the report: tone-mapped pictures and error maps side by side, as PNG.

use super::subject::Stopped;
use crate::encode::{Format, encode_pixels};
use crate::frame::Pixels;
use crate::passes::tonemap::twin::filmic;
use glam::Vec3;

/// A picture of 8-bit sRGB pixels, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: usize,
    pixels: Vec<[u8; 3]>,
}

/// What an eye sees of linear luminance (cd/m2): exposed and tone-mapped as a frame is, but without its dither and not yet
/// coded for a screen, 0 to 1.
pub fn displayed(luminance: &[f32], exposure: f32) -> Vec<f32> {
    luminance
        .chunks_exact(3)
        .flat_map(|p| filmic((Vec3::new(p[0], p[1], p[2]) * exposure).max(Vec3::ZERO)).to_array())
        .collect()
}

/// The picture of displayed values.
pub fn picture(displayed: &[f32], width: usize) -> Image {
    let code = |v: f32| (srgb(v.clamp(0.0, 1.0)) * 255.0 + 0.5) as u8;
    Image { width, pixels: displayed.chunks_exact(3).map(|p| [code(p[0]), code(p[1]), code(p[2])]).collect() }
}

/// An error map: black for 0 over violet and orange to pale yellow for `most` and above; white where it is not a number.
pub fn error_map(errors: &[f32], width: usize, most: f32) -> Image {
    let pixel = |error: &f32| if error.is_nan() { [255; 3] } else { colour(error / most) };
    Image { width, pixels: errors.iter().map(pixel).collect() }
}

/// Pictures of one height side by side, each pixel drawn as a square of `scale`, as a PNG file.
///
/// # Errors
/// [`Stopped::Failed`]: the heights differ, or the codec refused.
pub fn side_by_side(images: &[Image], scale: usize) -> Result<Vec<u8>, Stopped> {
    const GAP: usize = 4;
    let scale = scale.max(1);
    let heights: Vec<usize> = images.iter().map(|i| i.pixels.len() / i.width.max(1)).collect();
    let height = heights.first().copied().unwrap_or(0);
    if heights.iter().any(|h| *h != height) {
        return Err(Stopped::Failed(format!("pictures of different heights: {heights:?}")));
    }
    let mut rgba = Vec::new();
    for y in 0..height * scale {
        for (n, image) in images.iter().enumerate() {
            if n > 0 {
                rgba.extend([128, 128, 128, 255].repeat(GAP));
            }
            for x in 0..image.width * scale {
                let [r, g, b] = image.pixels[x / scale + y / scale * image.width];
                rgba.extend([r, g, b, 255]);
            }
        }
    }
    let width = images.iter().map(|i| i.width * scale).sum::<usize>() + GAP * images.len().saturating_sub(1);
    encode_pixels(&Pixels::Srgb8(rgba), width as u32, (height * scale) as u32, Format::Png)
        .map_err(|error| Stopped::Failed(error.to_string()))
}

/// The sRGB code of a linear value (IEC 61966-2-1), 0 to 1.
fn srgb(v: f32) -> f32 {
    if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

/// Colours of rising lightness (after matplotlib's "inferno").
fn colour(share: f32) -> [u8; 3] {
    const STOPS: [[f32; 3]; 6] = [
        [0.0, 0.0, 4.0],
        [66.0, 10.0, 104.0],
        [147.0, 38.0, 103.0],
        [221.0, 81.0, 58.0],
        [252.0, 165.0, 10.0],
        [252.0, 255.0, 164.0],
    ];
    let at = share.clamp(0.0, 1.0) * (STOPS.len() - 1) as f32;
    let low = (at as usize).min(STOPS.len() - 2);
    std::array::from_fn(|c| (STOPS[low][c] + (STOPS[low + 1][c] - STOPS[low][c]) * (at - low as f32) + 0.5) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn greater_errors_are_lighter_and_what_is_no_number_is_white() {
        let map = error_map(&[0.0, 0.25, 0.5, 1.0, 7.0, f32::NAN], 6, 1.0);
        let sums: Vec<u32> = map.pixels.iter().map(|p| p.iter().map(|c| u32::from(*c)).sum()).collect();
        assert!(sums[0] < sums[1] && sums[1] < sums[2] && sums[2] < sums[3], "{sums:?}");
        assert_eq!((map.pixels[3], map.pixels[5]), (map.pixels[4], [255; 3]));
    }

    #[test]
    fn pictures_stand_side_by_side_and_unequal_ones_are_refused() {
        let one = error_map(&[0.0, 1.0, 0.5, 0.2], 2, 1.0);
        let file = side_by_side(&[one.clone(), one.clone()], 3).expect("a picture");
        let reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().expect("a PNG");
        // Two of 2 x 2 pixels, three times as large, with a gap of four.
        assert_eq!((reader.info().width, reader.info().height), (16, 6));
        assert!(side_by_side(&[one, error_map(&[0.0; 6], 2, 1.0)], 1).is_err());
    }

    #[test]
    fn black_is_black_and_plenty_of_light_is_white() {
        let shown = displayed(&[0.0, 0.0, 0.0, 1e6, 1e6, 1e6], 1.0);
        assert_eq!(picture(&shown, 2).pixels, [[0; 3], [255; 3]]);
    }
}
