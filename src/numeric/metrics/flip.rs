//! FLIP: how strongly a viewer who flips between two pictures sees them differ (Andersson, Nilsson, Akenine-Möller,
//! Oskarsson, Åström and Fairchild 2020, "FLIP: A Difference Evaluator for Alternating Images", for low dynamic range).
//!
//! *How we compute it.* Both pictures go through the contrast sensitivity of the eye (section 4.1.1), into a
//! Hunt-adjusted L*a*b* (4.1.2), and their HyAB distance is mapped to 0..1 (4.1.3); differences of edges and points
//! (4.2) amplify it (4.3): `E = Ec^(1 - Ef)`. All in f64, borders repeat the outermost pixel.

use rayon::prelude::*;
use std::f64::consts::PI;

/// Pixels per degree of the paper's viewer: 0.7 m before a screen 0.7 m wide with 3840 pixels.
pub const PIXELS_PER_DEGREE: f64 = 67.020_643_276_582_25;

type Three = [f64; 3];

/// Exponent of the colour distance (the paper's `qc`).
const COLOUR_EXPONENT: f64 = 0.7;
/// Share of the greatest distance that is spread over `KNEE_VALUE` of the range (`pc`, `pt`).
const KNEE: f64 = 0.4;
const KNEE_VALUE: f64 = 0.95;
/// Exponent of the feature difference (`qf`).
const FEATURE_EXPONENT: f64 = 0.5;
/// Width of the feature detectors in degrees (`w`).
const FEATURE_DEGREES: f64 = 0.082;

/// The FLIP error of each pixel, 0 to 1. Pictures are linear sRGB (0 to 1, clamped) of `width` pixels a row.
///
/// Empty where the sizes do not belong together or a value is not a number.
pub fn flip_map(picture: &[f32], reference: &[f32], width: usize, pixels_per_degree: f64) -> Vec<f32> {
    let fits = |image: &[f32]| {
        width > 0 && !image.is_empty() && image.len().is_multiple_of(3 * width) && image.iter().all(|v| v.is_finite())
    };
    if picture.len() != reference.len() || !fits(picture) || !fits(reference) {
        return Vec::new();
    }
    let prepare = |image: &[f32]| -> Vec<Three> {
        let clamped = |v: f32| f64::from(v.clamp(0.0, 1.0));
        image.chunks_exact(3).map(|p| opponent([clamped(p[0]), clamped(p[1]), clamped(p[2])])).collect()
    };
    let images = [prepare(picture), prepare(reference)].map(|pixels| Image { pixels, width });
    let colours = images.each_ref().map(|image| image.seen(pixels_per_degree));
    let features = images.each_ref().map(|image| image.features(pixels_per_degree));
    let greatest = greatest_distance();
    (0..images[0].pixels.len())
        .into_par_iter()
        .map(|i| {
            let colour = spread(hyab(colours[0][i], colours[1][i]).powf(COLOUR_EXPONENT), greatest);
            let apart = |k: usize| (features[0][i][k] - features[1][i][k]).abs();
            let feature = (apart(0).max(apart(1)) / 2f64.sqrt()).powf(FEATURE_EXPONENT);
            colour.powf(1.0 - feature) as f32
        })
        .collect()
}

/// Mean of [`flip_map`] with the paper's viewer; NaN where there is no map.
pub fn flip(picture: &[f32], reference: &[f32], width: usize) -> f64 {
    let map = flip_map(picture, reference, width, PIXELS_PER_DEGREE);
    map.iter().map(|e| f64::from(*e)).sum::<f64>() / map.len() as f64
}

/// A picture in the opponent space YCxCz.
struct Image {
    pixels: Vec<Three>,
    width: usize,
}

impl Image {
    /// What the eye resolves, in Hunt-adjusted L*a*b*.
    fn seen(&self, pixels_per_degree: f64) -> Vec<Three> {
        // Sums of two Gaussians for each channel (table 1): heights and exponents.
        let channels = [[(1.0, 0.0047), (0.0, 1e-5)], [(1.0, 0.0053), (0.0, 1e-5)], [(34.1, 0.04), (13.5, 0.025)]];
        let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32;
        let filtered: Vec<Vec<f64>> = (0..3)
            .map(|channel| {
                let plane: Vec<f64> = self.pixels.iter().map(|p| p[channel]).collect();
                let (mut sum, mut weight) = (vec![0.0; plane.len()], 0.0);
                for (height, exponent) in channels[channel].into_iter().filter(|(height, _)| *height > 0.0) {
                    // A Gaussian of the distance is a product of one across and one along; the paper normalises the sum.
                    let height = height * (PI / exponent);
                    let tap = |x: i32| (-(PI * f64::from(x) / pixels_per_degree).powi(2) / exponent).exp();
                    let taps: Vec<f64> = (-radius..=radius).map(tap).collect();
                    let total: f64 = taps.iter().sum();
                    let smooth = self.convolved(&self.convolved(&plane, &taps, true), &taps, false);
                    sum.iter_mut().zip(&smooth).for_each(|(s, v)| *s += height * v);
                    weight += height * total * total;
                }
                sum.iter_mut().for_each(|s| *s /= weight);
                sum
            })
            .collect();
        (0..self.pixels.len()).map(|i| hunt_lab([filtered[0][i], filtered[1][i], filtered[2][i]])).collect()
    }

    /// Strengths of edges and of points at each pixel.
    fn features(&self, pixels_per_degree: f64) -> Vec<[f64; 2]> {
        let luma: Vec<f64> = self.pixels.iter().map(|p| (p[0] + 16.0) / 116.0).collect();
        let deviation = 0.5 * FEATURE_DEGREES * pixels_per_degree;
        let radius = (3.0 * deviation).ceil() as i32;
        let gaussian = |x: f64| (-x * x / (2.0 * deviation * deviation)).exp();
        let taps =
            |shape: &dyn Fn(f64) -> f64| -> Vec<f64> { (-radius..=radius).map(|x| shape(f64::from(x))).collect() };
        let across = taps(&gaussian);
        let total: f64 = across.iter().sum();
        let across: Vec<f64> = across.iter().map(|v| v / total).collect();
        let edge = normalised(&taps(&|x| -x * gaussian(x)));
        let point = normalised(&taps(&|x| (x * x / (deviation * deviation) - 1.0) * gaussian(x)));
        let strength = |along: &[f64]| -> Vec<f64> {
            let x = self.convolved(&self.convolved(&luma, along, true), &across, false);
            let y = self.convolved(&self.convolved(&luma, &across, true), along, false);
            x.iter().zip(&y).map(|(x, y)| x.hypot(*y)).collect()
        };
        let (edges, points) = (strength(&edge), strength(&point));
        edges.into_iter().zip(points).map(|(edge, point)| [edge, point]).collect()
    }

    /// A plane convolved along its rows or its columns.
    fn convolved(&self, plane: &[f64], taps: &[f64], along_row: bool) -> Vec<f64> {
        let (width, height) = (self.width as i32, (plane.len() / self.width) as i32);
        let radius = (taps.len() / 2) as i32;
        let mut out = vec![0.0; plane.len()];
        out.par_chunks_mut(self.width).enumerate().for_each(|(y, row)| {
            for (x, value) in row.iter_mut().enumerate() {
                let (x, y) = (x as i32, y as i32);
                *value = taps
                    .iter()
                    .zip(-radius..)
                    .map(|(tap, d)| {
                        let (x, y) = if along_row { (x + d, y) } else { (x, y + d) };
                        tap * plane[(x.clamp(0, width - 1) + y.clamp(0, height - 1) * width) as usize]
                    })
                    .sum();
            }
        });
        out
    }
}

/// Positive and negative taps scaled so that each add up to one.
fn normalised(taps: &[f64]) -> Vec<f64> {
    let positive: f64 = taps.iter().filter(|v| **v > 0.0).sum();
    let negative: f64 = -taps.iter().filter(|v| **v < 0.0).sum::<f64>();
    taps.iter().map(|v| if *v > 0.0 { v / positive } else { v / negative }).collect()
}

/// Linear sRGB to XYZ (IEC 61966-2-1, D65), as fractions of the paper's code.
const TO_XYZ: [Three; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];

fn times(matrix: &[Three; 3], v: Three) -> Three {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// XYZ over those of white.
fn relative_xyz(linear: Three) -> Three {
    let (xyz, white) = (times(&TO_XYZ, linear), times(&TO_XYZ, [1.0; 3]));
    [xyz[0] / white[0], xyz[1] / white[1], xyz[2] / white[2]]
}

/// YCxCz of a linear colour (a linear form of L*a*b*).
fn opponent(linear: Three) -> Three {
    let [x, y, z] = relative_xyz(linear);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Hunt-adjusted L*a*b* of a YCxCz colour, brought into the range of linear sRGB.
fn hunt_lab(ycxcz: Three) -> Three {
    let y = (ycxcz[0] + 16.0) / 116.0;
    let (x, z) = (y + ycxcz[1] / 500.0, y - ycxcz[2] / 200.0);
    let white = times(&TO_XYZ, [1.0; 3]);
    let linear = times(&inverse(&TO_XYZ), [x * white[0], y * white[1], z * white[2]]).map(|v| v.clamp(0.0, 1.0));
    adjusted_lab(linear)
}

/// L*a*b* of a linear colour with a* and b* scaled by lightness (the Hunt effect).
fn adjusted_lab(linear: Three) -> Three {
    const EDGE: f64 = 6.0 / 29.0;
    let f = |t: f64| if t > EDGE.powi(3) { t.cbrt() } else { t / (3.0 * EDGE * EDGE) + 4.0 / 29.0 };
    let [x, y, z] = relative_xyz(linear).map(f);
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// HyAB distance: that of lightness plus that of colour.
fn hyab(a: Three, b: Three) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// The greatest distance, that of green and blue, with the exponent.
fn greatest_distance() -> f64 {
    hyab(adjusted_lab([0.0, 1.0, 0.0]), adjusted_lab([0.0, 0.0, 1.0])).powf(COLOUR_EXPONENT)
}

/// Spreads a distance over 0 to 1, most of it for the small ones.
fn spread(distance: f64, greatest: f64) -> f64 {
    let knee = KNEE * greatest;
    if distance < knee {
        distance * KNEE_VALUE / knee
    } else {
        KNEE_VALUE + (distance - knee) / (greatest - knee) * (1.0 - KNEE_VALUE)
    }
}

fn inverse(m: &[Three; 3]) -> [Three; 3] {
    let minor = |r: usize, c: usize| {
        let (r1, r2, c1, c2) = ((r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3);
        m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]
    };
    let determinant: f64 = (0..3).map(|c| m[0][c] * minor(0, c)).sum();
    std::array::from_fn(|r| std::array::from_fn(|c| minor(c, r) / determinant))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn even(colour: [f32; 3], pixels: usize) -> Vec<f32> {
        colour.into_iter().cycle().take(3 * pixels).collect()
    }

    #[test]
    fn even_pictures_by_hand() {
        // Without edges FLIP is the spread of the HyAB distance. Black and white: |100 - 0|^0.7 = 25.1189 over the
        // greatest distance of 41.2760, above the knee of 16.5104: 0.95 + 0.05 * 8.6085 / 24.7656 = 0.967380.
        let (black, white) = (even([0.0; 3], 64), even([1.0; 3], 64));
        // Cut off at four digits.
        assert!((greatest_distance() - 41.2760).abs() < 1.5e-4, "{}", greatest_distance());
        // Printed to six digits.
        assert!((flip(&black, &white, 8) - 0.967_380).abs() < 5e-7, "{}", flip(&black, &white, 8));
        // Two greys of L* = 50 and 51: a distance of 1 below the knee: 0.95 / 16.5104 = 0.057540.
        let grey = |lightness: f64| even([((lightness + 16.0) / 116.0).powi(3) as f32; 3], 64);
        let found = flip(&grey(50.0), &grey(51.0), 8);
        // The greys are f32: 6e-8 of a lightness of 50, raised to 0.7 and scaled.
        assert!((found - 0.057_540).abs() < 2e-6, "{found}");
        assert_eq!(flip(&grey(50.0), &grey(50.0), 8), 0.0);
    }

    #[test]
    fn hunt_adjusted_lab_of_red_by_hand() {
        // CIE L*a*b* (D65) of sRGB red is 53.24, 80.09, 67.20 (published); a* and b* times 0.5324.
        let [l, a, b] = adjusted_lab([1.0, 0.0, 0.0]);
        assert!((l - 53.24).abs() < 0.01 && (a - 42.64).abs() < 0.02 && (b - 35.78).abs() < 0.02, "{l} {a} {b}");
        let back = hunt_lab(opponent([0.2, 0.5, 0.7]));
        let straight = adjusted_lab([0.2, 0.5, 0.7]);
        // There and back by an inverse matrix in f64.
        assert!((0..3).all(|i| (back[i] - straight[i]).abs() < 1e-9));
    }

    #[test]
    fn a_moved_line_is_seen_where_it_was_and_where_it_is() {
        let (width, height) = (48, 32);
        let line = |at: usize| -> Vec<f32> {
            (0..width * height).flat_map(|i| [if i % width == at { 1.0 } else { 0.2 }; 3]).collect()
        };
        let map = flip_map(&line(16), &line(32), width, PIXELS_PER_DEGREE);
        let row = &map[10 * width..11 * width];
        // Features raise the difference on both lines above anything between or beside them.
        let most = |range: std::ops::Range<usize>| row[range].iter().fold(0.0f32, |a, b| a.max(*b));
        assert!(row[16] > 0.5 && row[32] > 0.5, "{row:?}");
        assert!(row[24] < 0.1 * row[16] && most(0..4) < 0.1 * row[16], "{row:?}");
        // The same in columns: nothing is said twice by a transposed index.
        let transposed: Vec<f32> =
            (0..width * height).flat_map(|i| [if i / 32 == 16 && i % 32 < 32 { 1.0 } else { 0.2f32 }; 3]).collect();
        let other: Vec<f32> = (0..width * height).flat_map(|i| [if i / 32 == 32 { 1.0 } else { 0.2f32 }; 3]).collect();
        let turned = flip_map(&transposed, &other, 32, PIXELS_PER_DEGREE);
        assert!((0..width).all(|y| (turned[y * 32 + 10] - row[y]).abs() < 1e-6));
    }

    #[test]
    fn what_cannot_be_compared_is_not_zero() {
        assert!(flip(&[], &[], 1).is_nan());
        assert!(flip(&[0.0; 6], &[0.0; 3], 1).is_nan());
        assert!(flip(&[0.0; 6], &[0.0; 6], 0).is_nan());
        assert!(flip(&[f32::NAN, 0.0, 0.0], &[0.0; 3], 1).is_nan());
    }
}
