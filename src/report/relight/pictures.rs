//! Pictures of a lit cloud by several methods: errors as an eye sees them, and what the paper's figures 6 and 7 show.

use super::super::figure::Figure;
use super::super::images::{Image, displayed, error_map, picture, side_by_side};
use super::super::lit_cloud::{bolt, cloud, failed};
use super::super::result::Case;
use super::super::subject::{Run, Stopped};
use super::table;
use crate::numeric::metrics::{flip, relative_mse};
use crate::scattering::basis::Basis;
use crate::scattering::medium::Medium;
use crate::scattering::relight::{Method, Relighter};
use crate::scattering::view::{self, Camera};

/// The density is drawn four times as fine as it is lit, as in the paper.
const FINER: usize = 4;
/// Pixels of a picture and cells' widths of a pixel.
const SIZE_PX: [usize; 2] = [160, 128];
const PIXEL: f64 = 0.22;
/// Decades of a cross section in pseudo colours.
const DECADES: f32 = 3.0;
/// Where the difference of two displayed pictures is drawn brightest, as in the paper: a tenth.
const DIFFERENCE: f32 = 0.1;

/// What is seen of one way of lighting.
struct Seen {
    method: Method,
    /// Grey of the three channels alike, W/(m^2 sr).
    light: Vec<f32>,
    /// Light that cells scatter in all, per cell of a level section.
    section: Vec<f32>,
}

/// Compares the pictures of a bolt of so many seed points and draws them.
pub fn compare(
    run: &mut Run,
    medium: &Medium,
    relighter: &Relighter,
    bases: &[Basis; 2],
    seeds: usize,
) -> Result<(), Stopped> {
    let fine = {
        let cells = medium.cells.map(|n| n * FINER);
        let edges = medium.spacing_m.map(|h| h / FINER as f64);
        let deepest = medium.greatest_cell_depth() / FINER as f64;
        cloud(cells, edges, deepest as f32)?
    };
    let points = bolt(medium.size_m(), seeds, 0);
    let directions = &relighter.directions();
    // From above and the south, half-way down.
    let eye = view::nearest(directions, [0.0, -0.7, 0.7]);
    let camera = Camera { towards: directions[eye], size_px: SIZE_PX, pixel_m: PIXEL * medium.spacing_m[0] };
    let mut all = Vec::new();
    for method in Method::ALL {
        let lit = relighter.relight(method, &points, table(method, bases)).map_err(failed)?.towards;
        let cells = medium.len();
        let seen = view::picture(&fine, medium, &lit[eye * cells..][..cells], &camera);
        let mean = relighter.mean(&lit);
        let [nx, ny, nz] = medium.cells;
        let level = nx * ny * (nz / 2);
        let section = (level..level + nx * ny).map(|i| mean[i] * medium.extinction_per_m[i]).collect();
        all.push(Seen { method, light: seen.iter().flat_map(|v| [*v as f32; 3]).collect(), section });
    }
    let Some(truth) = all.iter().find(|seen| seen.method == Method::Reference) else { return Ok(()) };
    // The brightest hundredth is nearly white.
    let mut sorted = truth.light.clone();
    sorted.sort_by(f32::total_cmp);
    let exposure = 2.0 / sorted[sorted.len() * 99 / 100].max(f32::MIN_POSITIVE);
    let shown = |seen: &Seen| displayed(&seen.light, exposure);
    for seen in all.iter().filter(|seen| seen.method != Method::Reference) {
        let made = Case::new(format!("pictures of a bolt of {seeds} seed points"), seen.method.name())
            .error("relative MSE (HDR)", "reference", relative_mse(&seen.light, &truth.light))
            .error("root mean square, tone mapped", "reference", rms(&shown(seen), &shown(truth)))
            .error("FLIP", "reference", flip(&shown(seen), &shown(truth), SIZE_PX[0]));
        run.record(made)?;
    }
    let of = |method: Method| all.iter().find(|seen| seen.method == method).unwrap_or(truth);
    let drawn = |method: Method| picture(&shown(of(method)), SIZE_PX[0]);
    let apart = |a: Method, b: Method| {
        let (a, b) = (shown(of(a)), shown(of(b)));
        let differences: Vec<f32> = a.chunks(3).zip(b.chunks(3)).map(|(a, b)| (a[0] - b[0]).abs()).collect();
        error_map(&differences, SIZE_PX[0], DIFFERENCE)
    };
    if seeds == 1 {
        let most = truth.section.iter().copied().fold(f32::MIN_POSITIVE, f32::max);
        let section = |method: Method| section(&of(method).section, medium.cells[0], most);
        let strip = [
            drawn(Method::Single),
            section(Method::Single),
            drawn(Method::Hybrid),
            section(Method::Hybrid),
            drawn(Method::Reference),
            section(Method::Reference),
            apart(Method::Hybrid, Method::Reference),
        ];
        let caption = "One bolt, as figure 6 of Dobashi et al. 2007: single scattering and a level cross section (light that cells \
                       scatter, three decades, brightest of the reference yellow); the same by hybrid; by the reference; difference of \
                       hybrid and reference, a tenth of the range yellow.";
        run.figure(Figure::png("Single and multiple scattering", caption, side_by_side(&strip, 2)?))?;
    }
    let strip = [
        drawn(Method::Point),
        drawn(Method::Basis),
        drawn(Method::Hybrid),
        drawn(Method::Reference),
        apart(Method::Basis, Method::Reference),
        apart(Method::Hybrid, Method::Reference),
    ];
    let caption = "As figure 7 of Dobashi et al. 2007: bare points, the published scheme, hybrid, reference; differences of the published \
                   scheme and of hybrid from the reference, a tenth of the range yellow.";
    run.figure(Figure::png(format!("A bolt of {seeds} seed points"), caption, side_by_side(&strip, 2)?))
}

/// A level section in pseudo colours of its logarithm, as high as the pictures.
fn section(light: &[f32], width: usize, most: f32) -> Image {
    let scale = SIZE_PX[1] * width / light.len().max(1);
    let value = |v: f32| (1.0 + (v / most).max(1e-9).log10() / DECADES).max(0.0);
    let (wide, high) = (width * scale, light.len() / width * scale);
    // Rows from the north.
    let pixels: Vec<f32> = (0..wide * high)
        .map(|i| {
            let (x, y) = (i % wide / scale, (high - 1 - i / wide) / scale);
            value(light[x + width * y])
        })
        .collect();
    error_map(&pixels, wide, 1.0)
}

fn rms(a: &[f32], b: &[f32]) -> f64 {
    let sum: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    (sum / a.len().max(1) as f64).sqrt()
}
