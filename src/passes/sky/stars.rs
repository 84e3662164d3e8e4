//! Stars behind the night sky: points of the catalogue, found by the cell of the sky that a ray looks into.
//!
//! *What it is.* The directions are those of the catalogue; a ray is turned into its axes. *How we store it.* The faces of a cube
//! around the eye are cut into cells; each lists the stars that a pixel of it may see. *How we read it back.* A star is spread
//! over about a pixel, with the same light whatever the pixel.

use super::Stars;
use crate::geo::stars::all;
use crate::passes::common::smoothstep;
use glam::Vec3;
use std::sync::LazyLock;

/// Cells of a cube's face each way: 2.8 degrees each in its middle.
pub const CELLS: usize = 32;
/// A star is listed in each cell nearer than this angle: three times the widest spread.
const REACH_RAD: f32 = 0.006;
/// Spread (standard deviation) of a star's light at most, and in pixels.
const WIDEST_RAD: f32 = 0.002;
const SPREAD_PIXELS: f32 = 0.6;

/// The catalogue by cells.
pub struct Table {
    /// For each cell where its list begins, one more at the end; then the lists of all cells.
    pub cells: Vec<u32>,
    /// For each star its direction and illuminance in lux, then its colour.
    pub stars: Vec<[f32; 4]>,
}

/// The table, made when it is first asked for.
pub fn table() -> &'static Table {
    static TABLE: LazyLock<Table> = LazyLock::new(Table::new);
    &TABLE
}

/// Spread of a star for pixels of this angle, rad.
pub fn spread_rad(pixel_rad: f32) -> f32 {
    (SPREAD_PIXELS * pixel_rad).min(WIDEST_RAD)
}

impl Table {
    fn new() -> Self {
        let mut lists = vec![Vec::new(); 6 * CELLS * CELLS];
        let mut stars = Vec::new();
        for (i, star) in all().enumerate() {
            let direction = star.direction.as_vec3();
            // The cells of the corners of a small cube about the star: all that its light may reach.
            let mut cells: Vec<usize> = (0..27)
                .map(|k| {
                    cell(
                        direction
                            + Vec3::new((k % 3) as f32 - 1.0, (k / 3 % 3) as f32 - 1.0, (k / 9) as f32 - 1.0)
                                * REACH_RAD,
                    )
                })
                .collect();
            cells.sort_unstable();
            cells.dedup();
            cells.into_iter().for_each(|cell| lists[cell].push(i as u32));
            let colour = colour(star.colour as f32);
            stars.push(direction.extend(star.illuminance_lux as f32).to_array());
            stars.push(colour.extend(0.0).to_array());
        }
        let mut cells = Vec::with_capacity(lists.len() + 1);
        let mut begin = lists.len() as u32 + 1;
        for list in &lists {
            cells.push(begin);
            begin += list.len() as u32;
        }
        cells.push(begin);
        cells.extend(lists.into_iter().flatten());
        Self { cells, stars }
    }
}

/// Colour of a colour index, luminance 1 in the mean: blue-white below 0, orange above 1.5.
fn colour(index: f32) -> Vec3 {
    let warm = smoothstep(-0.2, 1.6, index);
    Vec3::new(0.80, 0.98, 1.45).lerp(Vec3::new(1.45, 0.93, 0.50), warm)
}

/// The cell of a direction.
pub fn cell(direction: Vec3) -> usize {
    let size = direction.abs();
    let (axis, largest) = match size {
        size if size.x >= size.y && size.x >= size.z => (0, size.x),
        size if size.y >= size.z => (1, size.y),
        size => (2, size.z),
    };
    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3].map(|other| {
        let share = 0.5 + 0.5 * direction[other] / largest;
        ((share * CELLS as f32) as usize).min(CELLS - 1)
    });
    let face = 2 * axis + usize::from(direction[axis] < 0.0);
    (face * CELLS + v) * CELLS + u
}

/// Luminance of the stars along a ray (east, north, up) outside the air, cd/m2 per colour.
pub fn luminance(stars: &Stars, table: &Table, direction: Vec3) -> Vec3 {
    let [x, y, z] = [stars.x, stars.y, stars.z].map(Vec3::from);
    let turned = Vec3::new(x.dot(direction), y.dot(direction), z.dot(direction));
    let cell = cell(turned);
    let mut sum = Vec3::ZERO;
    for at in table.cells[cell]..table.cells[cell + 1] {
        let star = 2 * table.cells[at as usize] as usize;
        let [sx, sy, sz, lux] = table.stars[star];
        let [r, g, b, _] = table.stars[star + 1];
        let chord = turned - Vec3::new(sx, sy, sz);
        sum += Vec3::new(r, g, b) * (lux * (-chord.length_squared() * stars.sharpness).exp());
    }
    sum * stars.strength
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Looking along the catalogue's own axes, with pixels of an angle.
    fn plain(pixel_rad: f32) -> Stars {
        let spread = spread_rad(pixel_rad);
        Stars {
            x: [1.0, 0.0, 0.0],
            sharpness: 0.5 / (spread * spread),
            y: [0.0, 1.0, 0.0],
            strength: 1.0 / (std::f32::consts::TAU * spread * spread),
            z: [0.0, 0.0, 1.0],
            pad0: 0.0,
        }
    }

    #[test]
    fn every_ray_near_a_star_finds_it() {
        let table = table();
        let stars = plain(0.0016);
        for star in table.stars.chunks_exact(2).step_by(7) {
            let towards = Vec3::new(star[0][0], star[0][1], star[0][2]);
            let (across, along) = towards.any_orthonormal_pair();
            for k in 0..8 {
                // Two standard deviations off, in all directions: e^-2 of the star's middle, or more where others shine too.
                let angle = k as f32 * 0.785;
                let off = (across * angle.cos() + along * angle.sin()) * (2.0 * spread_rad(0.0016));
                let found = luminance(&stars, table, (towards + off).normalize());
                let own = star[0][3] * stars.strength * 0.135 * star[1][1];
                assert!(found.y > 0.98 * own, "{towards} {k}: {found} {own}");
            }
        }
    }

    #[test]
    fn a_stars_light_is_its_illuminance_whatever_the_pixel() {
        let table = table();
        let sirius = Vec3::new(table.stars[0][0], table.stars[0][1], table.stars[0][2]);
        let (across, along) = sirius.any_orthonormal_pair();
        for pixel_rad in [0.0005f32, 0.0016] {
            let stars = plain(pixel_rad);
            let step = 0.3 * spread_rad(pixel_rad);
            let mut sum = Vec3::ZERO;
            for i in -20..=20 {
                for j in -20..=20 {
                    let off = (across * i as f32 + along * j as f32) * step;
                    sum += luminance(&stars, table, (sirius + off).normalize()) * (step * step);
                }
            }
            // A Gaussian summed over six standard deviations each way in steps of 0.3: exact but for f32 chords (1 % at 5e-4 rad).
            let expected = table.stars[0][3] * table.stars[1][1];
            assert!((sum.y / expected - 1.0).abs() < 0.02, "{pixel_rad}: {} {expected}", sum.y);
        }
    }
}
