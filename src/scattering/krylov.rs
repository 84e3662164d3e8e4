//! Solves `x = A x + b` for sixteen sources at once: source iteration, or BiCGStab where that is slow.

use super::lanes::{LANES, Lanes, dispatch};

/// How the solution was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Source iteration: one order of scattering after the other. Converges like the albedo of the whole cloud.
    SourceIteration,
    /// BiCGStab (van der Vorst 1992): two applications a step, for thick clouds.
    BiCgStab,
}

/// What the iteration did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iterations {
    /// The method that ended it.
    pub method: Method,
    /// Applications of the operator.
    pub applications: usize,
    /// Greatest of the lanes' residuals, relative to `b`.
    pub residual: f64,
    /// Whether it is within the tolerance.
    pub converged: bool,
}

type Scalars = [f64; LANES];

/// What the lanes hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holding {
    /// A source each: lanes never mix.
    Sources,
    /// Cells of one source: scalar products are over all of them.
    Cells,
}

impl Holding {
    /// Sums over what belongs together.
    fn joined(self, sums: Scalars) -> Scalars {
        match self {
            Self::Sources => sums,
            Self::Cells => [sums.iter().sum(); LANES],
        }
    }
}

/// Iterates until every lane's residual is `tolerance` of its `b`, or `most` applications are done. `x` is the start and the
/// solution. `operator(x, out)` computes `A x`.
pub fn solve(
    mut operator: impl FnMut(&[Lanes], &mut [Lanes]),
    b: &[Lanes],
    x: &mut [Lanes],
    (method, holding): (Method, Holding),
    tolerance: f64,
    most: usize,
) -> Iterations {
    let scale = holding.joined(dot_all(b, b)).map(f64::sqrt);
    let mut done = 0;
    let mut residual = f64::INFINITY;
    let mut used = method;
    while done < most {
        (done, residual) = match used {
            Method::SourceIteration => {
                source_iteration(&mut operator, b, x, (&scale, holding), tolerance, (done, most))
            }
            Method::BiCgStab => {
                let before = residual;
                let reached = bicgstab(&mut operator, b, x, (&scale, holding), tolerance, (done, most));
                // A method that has broken down is left for the one that cannot.
                if reached.1.is_nan() || reached.1 > before * 0.9 {
                    used = Method::SourceIteration;
                }
                reached
            }
        };
        if residual <= tolerance || !residual.is_finite() {
            break;
        }
    }
    Iterations { method: used, applications: done, residual, converged: residual <= tolerance }
}

fn worst(squares: &Scalars, scale: &Scalars) -> f64 {
    squares.iter().zip(scale).map(|(r, s)| if *s > 0.0 { r.sqrt() / s } else { 0.0 }).fold(0.0, |a, r| {
        // A NaN must win.
        if r > a || r.is_nan() { r } else { a }
    })
}

fn source_iteration(
    operator: &mut impl FnMut(&[Lanes], &mut [Lanes]),
    b: &[Lanes],
    x: &mut [Lanes],
    (scale, holding): (&Scalars, Holding),
    tolerance: f64,
    (mut done, most): (usize, usize),
) -> (usize, f64) {
    let mut next = vec![Lanes::ZERO; b.len()];
    let mut residual = f64::INFINITY;
    while done < most && residual > tolerance {
        operator(x, &mut next);
        let mut squares = [0.0; LANES];
        step_difference(b, &mut next, x, &mut squares);
        done += 1;
        residual = worst(&holding.joined(squares), scale);
        if residual.is_nan() {
            break;
        }
    }
    (done, residual)
}

fn bicgstab(
    operator: &mut impl FnMut(&[Lanes], &mut [Lanes]),
    b: &[Lanes],
    x: &mut [Lanes],
    (scale, holding): (&Scalars, Holding),
    tolerance: f64,
    (mut done, most): (usize, usize),
) -> (usize, f64) {
    let n = b.len();
    let dot_all = |a: &[Lanes], b: &[Lanes]| holding.joined(dot_all(a, b));
    let mut r = vec![Lanes::ZERO; n];
    let mut v = vec![Lanes::ZERO; n];
    let mut t = vec![Lanes::ZERO; n];
    // r = b + A x - x
    operator(x, &mut r);
    done += 1;
    update(&mut r, &[1.0; LANES], b);
    update(&mut r, &[-1.0; LANES], x);
    let shadow = r.clone();
    let mut p = r.clone();
    let mut rho = dot_all(&shadow, &r);
    let mut residual = worst(&dot_all(&r, &r), scale);
    let (start, mut best) = (residual, residual);
    while done + 2 <= most && residual > tolerance {
        apply_minus(operator, &p, &mut v);
        let alpha = ratio(&rho, &dot_all(&shadow, &v));
        update(&mut r, &alpha.map(|a| -a), &v);
        apply_minus(operator, &r, &mut t);
        let omega = ratio(&dot_all(&t, &r), &dot_all(&t, &t));
        update(x, &alpha, &p);
        update(x, &omega, &r);
        update(&mut r, &omega.map(|o| -o), &t);
        done += 2;
        let squares = dot_all(&r, &r);
        residual = worst(&squares, scale);
        if residual.is_nan() || residual > 1e3 * start.max(1e-30) {
            return (done, f64::INFINITY);
        }
        best = best.min(residual);
        let next = dot_all(&shadow, &r);
        let mut beta = ratio(&next, &rho);
        for l in 0..LANES {
            beta[l] *= if omega[l] == 0.0 { 0.0 } else { alpha[l] / omega[l] };
            // A lane that is there stops moving, or it would divide rounding by rounding.
            if squares[l].sqrt() <= 0.1 * tolerance * scale[l] {
                beta[l] = 0.0;
            }
        }
        rho = next;
        // p = r + beta (p - omega v)
        update(&mut p, &omega.map(|o| -o), &v);
        combine(&mut p, &beta, &r);
        if residual <= tolerance {
            break;
        }
        if residual > 30.0 * best {
            // Lost its way: begin again from here.
            break;
        }
    }
    // The recurrence drifts from the truth in f32: the caller goes on until the true residual is small.
    operator(x, &mut t);
    done += 1;
    let mut squares = [0.0; LANES];
    step_difference(b, &mut t, x, &mut squares);
    (done, worst(&holding.joined(squares), scale))
}

fn apply_minus(operator: &mut impl FnMut(&[Lanes], &mut [Lanes]), x: &[Lanes], out: &mut [Lanes]) {
    operator(x, out);
    combine(out, &[-1.0; LANES], x);
}

fn ratio(a: &Scalars, b: &Scalars) -> Scalars {
    std::array::from_fn(|l| if b[l].abs() > 1e-300 { a[l] / b[l] } else { 0.0 })
}

fn dot_all(a: &[Lanes], b: &[Lanes]) -> Scalars {
    let mut out = [0.0; LANES];
    dot(a, b, &mut out);
    out
}

dispatch! {
    /// Scalar products lane by lane: f32 within blocks of 256, f64 between them.
    fn dot(a: &[Lanes], b: &[Lanes], out: &mut Scalars) => dot_body
}
dispatch! {
    /// `x += factor y`.
    fn update(x: &mut [Lanes], factor: &Scalars, y: &[Lanes]) => update_body
}
dispatch! {
    /// `x = factor x + y`.
    fn combine(x: &mut [Lanes], factor: &Scalars, y: &[Lanes]) => combine_body
}
dispatch! {
    /// `next += b`, squares of `next - x`, then `x = next`.
    fn step_difference(b: &[Lanes], next: &mut [Lanes], x: &mut [Lanes], squares: &mut Scalars) => step_body
}

#[inline(always)]
fn dot_body(a: &[Lanes], b: &[Lanes], out: &mut Scalars) {
    for (a, b) in a.chunks(256).zip(b.chunks(256)) {
        let mut sum = Lanes::ZERO;
        for (a, b) in a.iter().zip(b) {
            sum = sum.plus(1.0, &a.times(b));
        }
        for (o, s) in out.iter_mut().zip(sum.0) {
            *o += f64::from(s);
        }
    }
}

#[inline(always)]
fn update_body(x: &mut [Lanes], factor: &Scalars, y: &[Lanes]) {
    let factor = Lanes(factor.map(|f| f as f32));
    for (x, y) in x.iter_mut().zip(y) {
        *x = x.plus(1.0, &y.times(&factor));
    }
}

#[inline(always)]
fn combine_body(x: &mut [Lanes], factor: &Scalars, y: &[Lanes]) {
    let factor = Lanes(factor.map(|f| f as f32));
    for (x, y) in x.iter_mut().zip(y) {
        *x = x.times(&factor).plus(1.0, y);
    }
}

#[inline(always)]
fn step_body(b: &[Lanes], next: &mut [Lanes], x: &mut [Lanes], squares: &mut Scalars) {
    for ((b, next), x) in b.chunks(256).zip(next.chunks_mut(256)).zip(x.chunks_mut(256)) {
        let mut sum = Lanes::ZERO;
        for ((b, next), x) in b.iter().zip(next).zip(x) {
            *next = next.plus(1.0, b);
            let difference = next.plus(-1.0, x);
            sum = sum.plus(1.0, &difference.times(&difference));
            *x = *next;
        }
        for (o, s) in squares.iter_mut().zip(sum.0) {
            *o += f64::from(s);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mixing of neighbours on a line that loses a little: like scattering. Lane `l` loses more.
    fn line(x: &[Lanes], out: &mut [Lanes]) {
        let n = x.len();
        for i in 0..n {
            let (a, b) = (x[i.saturating_sub(1)], x[(i + 1).min(n - 1)]);
            let mut sum = a.plus(1.0, &b).scaled(0.495);
            sum.0.iter_mut().enumerate().for_each(|(l, v)| *v *= 1.0 - 0.01 * l as f32);
            out[i] = sum;
        }
    }

    #[test]
    fn both_methods_find_the_solution_in_every_lane() {
        let n = 200;
        let mut b = vec![Lanes::ZERO; n];
        // Lane 15 has no source.
        for l in 0..LANES - 1 {
            b[7 * l + 20].0[l] = 1.0 + l as f32;
        }
        let mut solutions = Vec::new();
        for method in [Method::SourceIteration, Method::BiCgStab] {
            let mut x = vec![Lanes::ZERO; n];
            let info = solve(line, &b, &mut x, (method, Holding::Sources), 1e-4, 5000);
            assert!(info.converged && info.method == method, "{info:?}");
            let mut ax = vec![Lanes::ZERO; n];
            line(&x, &mut ax);
            for i in 0..n {
                for l in 0..LANES {
                    // The residual's norm is 1e-4 of that of b, which is at most 16.
                    assert!((x[i].0[l] - ax[i].0[l] - b[i].0[l]).abs() < 1.6e-3, "{method:?} {i} {l}");
                }
            }
            assert!(x.iter().all(|v| v.0[15] == 0.0));
            solutions.push((x, info.applications));
        }
        assert!(solutions[1].1 * 3 < solutions[0].1, "BiCGStab is for this: {:?}", [solutions[0].1, solutions[1].1]);
    }

    #[test]
    fn lanes_that_are_cells_are_solved_as_one() {
        // A chain through all lanes: the last cell of an entry is the neighbour of the first of the next.
        let chain = |x: &[Lanes], out: &mut [Lanes]| {
            let flat: Vec<f32> = x.iter().flat_map(|v| v.0).collect();
            let n = flat.len();
            for (i, out) in out.iter_mut().flat_map(|v| &mut v.0).enumerate() {
                *out = 0.495 * (flat[i.saturating_sub(1)] + flat[(i + 1).min(n - 1)]);
            }
        };
        let mut b = vec![Lanes::ZERO; 20];
        b[3].0[5] = 1.0;
        let mut found = Vec::new();
        for method in [Method::SourceIteration, Method::BiCgStab] {
            let mut x = vec![Lanes::ZERO; 20];
            let info = solve(chain, &b, &mut x, (method, Holding::Cells), 1e-5, 3000);
            assert!(info.converged && info.method == method, "{info:?}");
            found.push((x, info.applications));
        }
        for (a, b) in found[0].0.iter().zip(&found[1].0).flat_map(|(a, b)| a.0.iter().zip(&b.0).collect::<Vec<_>>()) {
            // Both residuals are 1e-5; what is lost is a hundredth a step, so that errors are up to a hundred times that.
            assert!((a - b).abs() < 2e-3, "{a} {b}");
        }
        assert!(found[1].1 * 3 < found[0].1);
    }

    #[test]
    fn a_limit_is_kept_and_told_and_a_growing_operator_is_noticed() {
        let b = vec![Lanes::splat(1.0); 50];
        for method in [Method::SourceIteration, Method::BiCgStab] {
            let mut x = vec![Lanes::ZERO; 50];
            let info = solve(line, &b, &mut x, (method, Holding::Sources), 1e-9, 7);
            assert!(!info.converged && info.applications <= 8 && info.residual > 1e-9, "{info:?}");
        }
        let grow = |x: &[Lanes], out: &mut [Lanes]| {
            for (o, x) in out.iter_mut().zip(x) {
                *o = x.scaled(1e20);
            }
        };
        let mut x = vec![Lanes::ZERO; 50];
        assert!(!solve(grow, &b, &mut x, (Method::SourceIteration, Holding::Sources), 1e-4, 100).converged);
    }
}
