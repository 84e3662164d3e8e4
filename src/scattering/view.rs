//! What scattered light looks like: radiance along straight lines through cells, at cells and as a picture from far away.

use super::medium::Medium;
use super::rays::walk;
use crate::numeric::sphere::{Direction, dot};
use rayon::prelude::*;

/// Radiance that arrives at every cell's centre along every direction, W/(m^2 sr): directions times cells. `towards` is scattered light
/// per unit of extinction in the same order; a cell is even in itself.
pub fn arriving(medium: &Medium, towards: &[f32], directions: &[Direction]) -> Vec<f64> {
    let cells = medium.len();
    let fields = directions.par_iter().zip(towards.par_chunks(cells));
    fields
        .flat_map_iter(|(d, field)| {
            let back = d.map(|x| -x);
            (0..cells).map(move |cell| {
                let mut seen = Seen::default();
                walk(medium, medium.centre_m(cell), back, |at, near, far| {
                    seen.pass(f64::from(medium.extinction_per_m[at]) * (far - near), f64::from(field[at]))
                });
                seen.radiance
            })
        })
        .collect()
}

/// Light collected from near to far.
struct Seen {
    radiance: f64,
    transmitted: f64,
}

impl Default for Seen {
    fn default() -> Self {
        Self { radiance: 0.0, transmitted: 1.0 }
    }
}

impl Seen {
    /// Passes an optical depth that sends `source` (per unit of depth); says whether anything behind it is seen.
    fn pass(&mut self, depth: f64, source: f64) -> bool {
        let through = (-depth).exp();
        self.radiance += self.transmitted * (1.0 - through) * source;
        self.transmitted *= through;
        self.transmitted > 1e-6
    }
}

/// A far eye: it sees light of one direction, so that its lines of sight are parallel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Direction of the light that it sees (away from the cloud); not straight up or down.
    pub towards: Direction,
    /// Pixels across and down.
    pub size_px: [usize; 2],
    /// Width of a pixel, m.
    pub pixel_m: f64,
}

/// Radiance of every pixel, rows from the top, W/(m^2 sr), with the middle of the box in the middle of the picture. The density is
/// that of `drawn`, as fine as it is; the light is that of the box `lit`, of the same size and coarser: scattered light per unit of
/// extinction towards the eye, one value a cell, read linearly.
pub fn picture(drawn: &Medium, lit: &Medium, light: &[f32], camera: &Camera) -> Vec<f64> {
    let d = camera.towards;
    let level = d[0].hypot(d[1]).max(1e-9);
    let right = [-d[1] / level, d[0] / level, 0.0];
    let up = [-d[0] * d[2] / level, -d[1] * d[2] / level, level];
    let size = drawn.size_m();
    let away = size.iter().map(|s| s * s).sum::<f64>().sqrt();
    let [width, height] = camera.size_px;
    let pixel = |i: usize| {
        let across = ((i % width) as f64 + 0.5 - 0.5 * width as f64) * camera.pixel_m;
        let above = (0.5 * height as f64 - 0.5 - (i / width) as f64) * camera.pixel_m;
        let from: Direction = std::array::from_fn(|k| 0.5 * size[k] + right[k] * across + up[k] * above + d[k] * away);
        let back = d.map(|x| -x);
        let mut seen = Seen::default();
        walk(drawn, from, back, |at, near, far| {
            let depth = f64::from(drawn.extinction_per_m[at]) * (far - near);
            if depth <= 0.0 {
                return true;
            }
            let middle = std::array::from_fn(|k| from[k] + back[k] * 0.5 * (near + far));
            seen.pass(depth, linear(lit, light, middle))
        });
        seen.radiance
    };
    (0..width * height).into_par_iter().map(pixel).collect()
}

/// A value between the middles of cells, constant beyond the last.
fn linear(medium: &Medium, values: &[f32], position_m: Direction) -> f64 {
    let mut low = [0; 3];
    let mut part = [0.0; 3];
    for k in 0..3 {
        let last = medium.cells[k] - 1;
        let at = (position_m[k] / medium.spacing_m[k] - 0.5).clamp(0.0, last as f64);
        low[k] = (at as usize).min(last.saturating_sub(1));
        part[k] = at - low[k] as f64;
    }
    let mut sum = 0.0;
    for corner in 0..8 {
        let step = [corner & 1, corner >> 1 & 1, corner >> 2];
        let weight: f64 = (0..3).map(|k| if step[k] == 1 { part[k] } else { 1.0 - part[k] }).product();
        if weight > 0.0 {
            sum += weight * f64::from(values[medium.index(std::array::from_fn(|k| low[k] + step[k]))]);
        }
    }
    sum
}

/// The direction of a set that comes nearest to a wanted one.
pub fn nearest(directions: &[Direction], wanted: Direction) -> usize {
    let along = |m: &usize| dot(directions[*m], wanted);
    (0..directions.len()).max_by(|a, b| along(a).total_cmp(&along(b))).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::sphere::Rule;

    /// A box of even depth with a source of 3 everywhere.
    fn even(cells: [usize; 3], spacing_m: [f64; 3]) -> (Medium, Vec<f32>) {
        let count = cells.iter().product();
        (Medium::new(cells, spacing_m, vec![0.25; count], false).expect("legal"), vec![3.0; count])
    }

    #[test]
    fn even_light_in_an_even_box_is_beers_law_in_every_direction() {
        let (medium, field) = even([4, 6, 3], [1.0, 0.5, 2.0]);
        let directions = Rule::Lebedev26.set().directions;
        let found = arriving(&medium, &field.repeat(26), &directions);
        for (m, d) in directions.iter().enumerate() {
            for cell in 0..medium.len() {
                let (at, size) = (medium.centre_m(cell), medium.size_m());
                // Back along the direction to the first face.
                let way = (0..3)
                    .filter(|k| d[*k].abs() > 1e-12)
                    .map(|k| if d[k] > 0.0 { at[k] / d[k] } else { (at[k] - size[k]) / d[k] })
                    .fold(f64::INFINITY, f64::min);
                let exact = 3.0 * (1.0 - (-0.25 * way).exp());
                // Rounding of f64.
                assert!((found[m * medium.len() + cell] - exact).abs() < 1e-9, "{d:?} {cell}");
            }
        }
    }

    #[test]
    fn a_picture_sees_the_whole_box_once_and_the_light_where_it_is() {
        let (drawn, _) = even([16, 16, 8], [0.5, 0.5, 0.5]);
        let (lit, mut light) = even([4, 4, 2], [2.0, 2.0, 2.0]);
        let camera = Camera { towards: [0.0, -1.0, 0.0], size_px: [40, 24], pixel_m: 0.25 };
        let seen = picture(&drawn, &lit, &light, &camera);
        let at = |x: usize, y: usize| seen[x + 40 * y];
        // Level lines of sight through 8 m of it, and past it.
        assert!((at(20, 12) - 3.0 * (1.0 - (-2.0_f64).exp())).abs() < 1e-9);
        assert_eq!((at(0, 12), at(20, 0)), (0.0, 0.0));
        // Brighter in the east: an eye in the south that looks north has it on the right; and what is low is low.
        (0..32).filter(|i| i % 4 == 3 && *i < 16).for_each(|i| light[i] = 30.0);
        let seen = picture(&drawn, &lit, &light, &camera);
        let at = |x: usize, y: usize| seen[x + 40 * y];
        assert!(at(34, 18) > 5.0 * at(6, 18) && at(34, 18) > 2.0 * at(34, 6), "{} {}", at(34, 18), at(34, 6));
        assert_eq!(nearest(&[[1.0, 0.0, 0.0], [0.0, 0.6, 0.8]], [0.1, 0.0, 1.0]), 1);
    }
}
