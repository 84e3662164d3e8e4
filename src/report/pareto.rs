//! The Pareto front of error and time: what no other method beats in one without losing in the other.

/// For each `(error, time)` whether it is on the front: no other is at least as good in both and better in one. Pairs
/// with a missing or non-finite half are not on it, and beat nobody.
pub fn front(points: &[(Option<f64>, Option<f64>)]) -> Vec<bool> {
    let finite = |v: Option<f64>| v.filter(|v| v.is_finite());
    let whole: Vec<Option<(f64, f64)>> = points.iter().map(|(e, t)| finite(*e).zip(finite(*t))).collect();
    let beats = |a: (f64, f64), b: (f64, f64)| a.0 <= b.0 && a.1 <= b.1 && a != b;
    whole.iter().map(|p| p.is_some_and(|p| !whole.iter().flatten().any(|other| beats(*other, p)))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(points: &[(f64, f64)]) -> Vec<bool> {
        front(&points.iter().map(|(e, t)| (Some(*e), Some(*t))).collect::<Vec<_>>())
    }

    #[test]
    fn what_is_beaten_in_one_and_equal_in_the_other_is_not_on_the_front() {
        assert_eq!(of(&[(1.0, 4.0), (2.0, 2.0), (4.0, 1.0)]), [true; 3]);
        assert_eq!(of(&[(1.0, 4.0), (1.0, 5.0), (2.0, 4.0), (3.0, 3.0)]), [true, false, false, true]);
        assert_eq!(of(&[(1.0, 1.0), (1.0, 1.0)]), [true, true], "equals do not beat each other");
        assert_eq!(of(&[(0.0, 1.0), (2.0, 2.0)]), [true, false]);
        assert_eq!(of(&[]), [false; 0]);
    }

    #[test]
    fn what_has_no_number_is_not_on_the_front_and_beats_nobody() {
        let points = [(None, Some(0.0)), (Some(f64::NAN), Some(0.0)), (Some(1.0), None), (Some(2.0), Some(1.0))];
        assert_eq!(front(&points), [false, false, false, true]);
    }
}
