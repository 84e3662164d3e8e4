//! The ground below a box: a diffuse reflector at some depth, lit and lighting by planes of columns.

use super::lanes::Lanes;

/// A diffuse ground. Light that meets it beyond the columns of the box, or leaves it past the box, is lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Share of the light that it sends back by Lambert's law, 0 to 1.
    pub albedo: f64,
    /// Distance below the box, m.
    pub depth_m: f64,
    /// Edges of the columns, m.
    pub spacing_m: [f64; 2],
}

impl Surface {
    /// Columns that light of a direction moves between the box's lower face and the ground: on the way down forwards,
    /// on the way up as well.
    pub fn shift(&self, d: [f64; 3]) -> [f64; 2] {
        let time = self.depth_m / d[2].abs();
        [d[0] * time / self.spacing_m[0], d[1] * time / self.spacing_m[1]]
    }
}

/// Adds `weight` times a plane moved by a shift (in columns, bilinear between them) to another; nothing comes from outside.
#[inline(always)]
pub fn displace(plane: &[Lanes], [nx, ny]: [usize; 2], shift: [f64; 2], weight: f32, out: &mut [Lanes]) {
    let whole = shift.map(f64::floor);
    if whole[0].abs() > nx as f64 + 1.0 || whole[1].abs() > ny as f64 + 1.0 {
        return;
    }
    let part = [shift[0] - whole[0], shift[1] - whole[1]];
    for j in 0..2 {
        for i in 0..2 {
            let share = (if i == 1 { part[0] } else { 1.0 - part[0] }) * (if j == 1 { part[1] } else { 1.0 - part[1] });
            if share < 1e-9 {
                continue;
            }
            let (dx, dy) = (whole[0] as isize + i, whole[1] as isize + j);
            for y in 0..ny {
                let Some(from_y) = y.checked_add_signed(-dy).filter(|y| *y < ny) else { continue };
                for x in 0..nx {
                    let Some(from_x) = x.checked_add_signed(-dx).filter(|x| *x < nx) else { continue };
                    out[x + nx * y] = out[x + nx * y].plus(weight * share as f32, &plane[from_x + nx * from_y]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_moves_with_its_light_and_loses_what_leaves() {
        let mut plane = vec![Lanes::ZERO; 12];
        plane[1 + 4] = Lanes::splat(1.0);
        let mut out = vec![Lanes::ZERO; 12];
        displace(&plane, [4, 3], [1.25, 0.0], 2.0, &mut out);
        assert_eq!((out[2 + 4].0[0], out[3 + 4].0[0]), (1.5, 0.5));
        let sum = |plane: &[Lanes]| plane.iter().map(|p| p.0[0]).sum::<f32>();
        assert_eq!(sum(&out), 2.0);
        let mut gone = vec![Lanes::ZERO; 12];
        displace(&plane, [4, 3], [0.0, 1e9], 1.0, &mut gone);
        displace(&plane, [4, 3], [-2.0, 0.0], 1.0, &mut gone);
        assert_eq!(sum(&gone), 0.0);
    }

    #[test]
    fn slanted_light_shifts_by_the_depth() {
        let surface = Surface { albedo: 0.3, depth_m: 100.0, spacing_m: [50.0, 100.0] };
        assert_eq!(surface.shift([0.6, 0.0, -0.8]), [1.5, 0.0]);
    }
}
