//! Which points of a line a picture of given fineness needs: the order in which Douglas and Peucker's method takes them.
//!
//! Douglas and Peucker 1973: of the points between two that are kept, the one farthest from their chord comes next. Here the
//! distance itself is stored, made to fall from a split to those inside it, so that one comparison decides at any fineness.

use super::distance;

/// Distance at which each point of a line comes into a picture; infinite for its ends and for those that are `kept`.
pub(super) fn details(positions: &[[f64; 3]], kept: impl Fn(usize) -> bool) -> Vec<f64> {
    let last = positions.len() - 1;
    let mut details = vec![f64::INFINITY; positions.len()];
    let mut open = Vec::new();
    let mut from = 0;
    for to in 1..=last {
        if to == last || kept(to) {
            open.push((from, to, f64::INFINITY));
            from = to;
        }
    }
    // A stack and not recursion: a line may split unevenly all the way.
    while let Some((from, to, most)) = open.pop() {
        let farthest = (from + 1..to)
            .map(|k| (beside(positions[from], positions[to], positions[k]), k))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((aside, k)) = farthest {
            let detail = aside.min(most);
            details[k] = detail;
            open.push((from, k, detail));
            open.push((k, to, detail));
        }
    }
    details
}

/// Distance of a point from the piece between two.
fn beside(a: [f64; 3], b: [f64; 3], p: [f64; 3]) -> f64 {
    let along: [f64; 3] = std::array::from_fn(|axis| b[axis] - a[axis]);
    let off: [f64; 3] = std::array::from_fn(|axis| p[axis] - a[axis]);
    let dot = |u: [f64; 3], v: [f64; 3]| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    let share = (dot(off, along) / dot(along, along).max(1e-12)).clamp(0.0, 1.0);
    distance(p, std::array::from_fn(|axis| a[axis] + share * along[axis]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bend_comes_in_at_its_own_size_and_what_is_inside_it_later() {
        // A tooth of height 3 with a dent of about 1.06 in one flank.
        let line = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [3.0, 3.0, 0.0], [6.0, 0.0, 0.0]];
        let found = details(&line, |_| false);
        assert_eq!((found[0], found[3], found[2]), (f64::INFINITY, f64::INFINITY, 3.0));
        // From (1, 0) to the line through the origin and (3, 3): 1 / sqrt 2.
        assert!((found[1] - 0.5_f64.sqrt()).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn kept_points_are_kept_and_nothing_inside_comes_before_its_split() {
        let line: Vec<[f64; 3]> =
            (0..200).map(|k| [f64::from(k), 9.0 * f64::from(k * k % 37), f64::from(k * 7 % 11)]).collect();
        let found = details(&line, |k| k == 77);
        assert_eq!(found[77], f64::INFINITY);
        for finest in [0.5, 5.0, 50.0] {
            // What is left out lies within the finest distance of the line that is left.
            let mut from = 0;
            for to in (1..line.len()).filter(|&k| found[k] >= finest) {
                assert!((from..to).all(|k| beside(line[from], line[to], line[k]) < finest.max(1e-9)), "{from} {to}");
                from = to;
            }
        }
    }
}
