//! Straight rays through a box of cells.

use super::medium::Medium;
use crate::numeric::sphere::Direction;

/// The stretch of a ray inside the box, as distances from its start (m); none when it misses.
pub fn clip(medium: &Medium, from_m: Direction, d: Direction) -> Option<[f64; 2]> {
    let size = medium.size_m();
    let (mut near, mut far) = (0.0_f64, f64::INFINITY);
    for k in 0..3 {
        if d[k] == 0.0 {
            if from_m[k] < 0.0 || from_m[k] > size[k] {
                return None;
            }
            continue;
        }
        let (a, b) = (-from_m[k] / d[k], (size[k] - from_m[k]) / d[k]);
        near = near.max(a.min(b));
        far = far.min(a.max(b));
    }
    (far > near).then_some([near, far])
}

/// Visits the cells on a ray in order (Amanatides and Woo 1987): cell, distances of entry and exit (m). The visitor says
/// whether to go on. The direction is a unit vector.
#[inline(always)]
pub fn walk(medium: &Medium, from_m: Direction, d: Direction, mut visit: impl FnMut(usize, f64, f64) -> bool) {
    let Some([near, far]) = clip(medium, from_m, d) else { return };
    let n = medium.cells;
    let stride = [1, n[0], n[0] * n[1]];
    let mut at = [0_usize; 3];
    let mut next = [f64::INFINITY; 3];
    let mut step = [f64::INFINITY; 3];
    let mut cell = 0;
    for k in 0..3 {
        let h = medium.spacing_m[k];
        let place = (from_m[k] + d[k] * near) / h;
        at[k] = (place.max(0.0) as usize).min(n[k] - 1);
        // A start on a face belongs to the cell that the ray goes into.
        if d[k] < 0.0 && place <= at[k] as f64 && at[k] > 0 {
            at[k] -= 1;
        }
        if d[k] != 0.0 {
            let face = if d[k] > 0.0 { at[k] + 1 } else { at[k] };
            next[k] = (face as f64 * h - from_m[k]) / d[k];
            step[k] = h / d[k].abs();
        }
        cell += at[k] * stride[k];
    }
    let mut t = near;
    loop {
        let k = if next[0] < next[1] {
            if next[0] < next[2] { 0 } else { 2 }
        } else if next[1] < next[2] {
            1
        } else {
            2
        };
        let end = next[k].min(far).max(t);
        if !visit(cell, t, end) || end >= far {
            return;
        }
        t = end;
        next[k] += step[k];
        if d[k] > 0.0 {
            at[k] += 1;
            if at[k] >= n[k] {
                return;
            }
            cell += stride[k];
        } else {
            if at[k] == 0 {
                return;
            }
            at[k] -= 1;
            cell -= stride[k];
        }
    }
}

/// Optical depth between a point and a distance along a ray.
pub fn depth(medium: &Medium, from_m: Direction, d: Direction, distance_m: f64) -> f64 {
    let mut sum = 0.0;
    walk(medium, from_m, d, |cell, a, b| {
        sum += f64::from(medium.extinction_per_m[cell]) * (b.min(distance_m) - a).max(0.0);
        // Beyond a depth of 100 nothing is left in f32.
        b < distance_m && sum < 100.0
    });
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::sphere::fibonacci;

    #[test]
    fn a_ray_passes_every_cell_once_and_its_pieces_are_its_length() {
        let m = Medium::new([4, 5, 3], [1.0, 2.0, 0.5], vec![1.0; 60], false).expect("legal");
        for from in [[1.7, 3.3, 0.9], [0.0, 0.0, 0.0], [2.0, 4.0, 1.0], [-3.0, 5.0, 0.2], [4.0, 10.0, 1.5]] {
            for d in fibonacci(200).into_iter().chain([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]]) {
                let mut last = None;
                let mut sum = 0.0;
                walk(&m, from, d, |cell, a, b| {
                    assert!(b >= a && last != Some(cell));
                    let centre = m.centre_m(cell);
                    for k in 0..3 {
                        let middle = from[k] + d[k] * 0.5 * (a + b);
                        assert!((middle - centre[k]).abs() <= 0.5 * m.spacing_m[k] + 1e-9, "{from:?} {d:?} {cell}");
                    }
                    last = Some(cell);
                    sum += b - a;
                    true
                });
                let length = clip(&m, from, d).map_or(0.0, |[a, b]| b - a);
                assert!((sum - length).abs() < 1e-9, "{from:?} {d:?}: {sum} {length}");
                assert!((depth(&m, from, d, 1.0) - depth(&m, from, d, 0.5) >= -1e-12));
            }
        }
    }
}
