//! The directions for which light is tabulated: a triangular grid over the upper half of the sphere, denser towards the horizon,
//! between whose corners the light is interpolated. So volumes are made anew only when the light enters another
//! triangle, and what is drawn depends on its direction alone.

/// Distance of the grid's lines in the stereographic plane: 2.3 degrees at the zenith, 1.15 degrees at the horizon.
const STEP: f32 = 0.02;
/// Weights are whole shares of one over this: about a tenth of a degree, 25 seconds of the sun's way.
pub const SHARES: u32 = 16;
/// Light below 4 degrees is taken at 4: its path through a whole tile would repeat the tile.
pub const LEAST_UP: f32 = 0.07;
/// Corners of the grid may lie a little lower.
const LEAST_CORNER_UP: f32 = 0.05;

/// A direction of the grid, and its part in the interpolation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Corner {
    /// Place in the stereographic plane, in steps.
    pub at: [i32; 2],
    /// Weight in [`SHARES`]; those of three corners add up to it.
    pub weight: u32,
}

/// The corners around a direction (x, y, up), greatest weight first.
pub fn corners(direction: [f32; 3]) -> [Corner; 3] {
    let up = direction[2].max(LEAST_UP);
    let flat = (1.0 - up * up).max(0.0).sqrt() / direction[0].hypot(direction[1]).max(1e-6);
    // In whole shares of a step, so that weights are whole too.
    let fine = |v: f32| (v * flat.min(1e6) / (1.0 + up) / STEP * SHARES as f32).round() as i32;
    let [u, v] =
        if direction[0].hypot(direction[1]) < 1e-6 { [0; 2] } else { [fine(direction[0]), fine(direction[1])] };
    let shares = SHARES as i32;
    let (i, j) = (u.div_euclid(shares), v.div_euclid(shares));
    let (fu, fv) = (u.rem_euclid(shares), v.rem_euclid(shares));
    let corner = |di: i32, dj: i32, weight: i32| Corner { at: [i + di, j + dj], weight: weight.max(0) as u32 };
    let mut found = if fu + fv <= shares {
        [corner(0, 0, shares - fu - fv), corner(1, 0, fu), corner(0, 1, fv)]
    } else {
        [corner(1, 1, fu + fv - shares), corner(0, 1, shares - fu), corner(1, 0, shares - fv)]
    };
    // A fixed order, so that corners of no weight do not tell equal directions apart.
    found.sort_by_key(|c| (std::cmp::Reverse(c.weight), c.at));
    found
}

impl Corner {
    /// Its direction (x, y, up).
    pub fn direction(&self) -> [f32; 3] {
        let [x, y] = self.at.map(|n| n as f32 * STEP);
        let r2 = x * x + y * y;
        let up = ((1.0 - r2) / (1.0 + r2)).max(LEAST_CORNER_UP);
        let length = r2.sqrt().max(1e-9);
        let flat = (1.0 - up * up).sqrt() / length;
        if r2 == 0.0 { [0.0, 0.0, 1.0] } else { [x * flat, y * flat, up] }
    }
}

/// The corner that a direction among these will need next: beyond the edge that it is near, if it is near one.
pub fn next(corners: &[Corner; 3]) -> Option<[i32; 2]> {
    let [a, b, c] = corners;
    (c.weight * 4 <= SHARES).then(|| [a.at[0] + b.at[0] - c.at[0], a.at[1] + b.at[1] - c.at[1]])
}
