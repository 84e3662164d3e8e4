//! Pins what each way of lighting gets wrong by how much, that energy is kept, and that a deck's second tile stays dark.

use super::*;
use crate::scattering::basis::tests::small;
use crate::scattering::compress::{Packing, Width};
use crate::scattering::ordinates::Params;

fn bolt(from: Direction, to: Direction, n: usize) -> Vec<PointSource> {
    (0..n)
        .map(|i| {
            let t = (i as f64 + 0.5) / n as f64;
            let bend = 0.3 * (7.0 * t).sin();
            let position_m = [
                from[0] + t * (to[0] - from[0]) + bend,
                from[1] + t * (to[1] - from[1]) - bend,
                from[2] + t * (to[2] - from[2]),
            ];
            PointSource { position_m, intensity: 1.0 / n as f64 }
        })
        .collect()
}

fn relative(a: &[f32], b: &[f32]) -> f64 {
    let sum = |f: &dyn Fn(usize) -> f64| (0..b.len()).map(f).sum::<f64>();
    (sum(&|i| f64::from(a[i] - b[i]).powi(2)) / sum(&|i| f64::from(b[i]).powi(2))).sqrt()
}

#[test]
fn hybrid_beats_the_published_scheme_and_both_beat_less() {
    let recipe = small(Content::Total, false);
    let solver = Solver::new(&recipe.medium, recipe.params).expect("legal");
    let relighter = Relighter::new(&recipe.medium, &solver);
    let total = Basis::bake(recipe.clone()).expect("baked");
    let diffuse = Basis::bake(small(Content::Diffuse, false)).expect("baked");
    let points = bolt([2.2, 3.1, 3.4], [6.1, 4.4, -0.5], 40);
    let table = |m: Method| match m.table() {
        Some(Content::Total) => Some(&total),
        Some(Content::Diffuse) => Some(&diffuse),
        None => None,
    };
    let lit = |m| relighter.relight(m, &points, table(m)).expect("lit").towards;
    let truth = lit(Method::Reference);
    let errors: Vec<f64> = Method::ALL.iter().map(|m| relative(&lit(*m), &truth)).collect();
    let [point, single, basis, hybrid, solve, reference] = errors[..] else { panic!() };
    assert_eq!(reference, 0.0);
    // Merged points and fewer rays; then the table on a coarse grid of lights; then eq. 6 smearing the source itself.
    assert!(solve < 0.12 && hybrid < 0.15 && basis < 2.0 && hybrid < 0.5 * basis, "{errors:?}");
    assert!(single > hybrid && point > hybrid, "{errors:?}");
}

#[test]
fn cells_in_the_lanes_collect_what_sources_in_the_lanes_do() {
    // Sixteen cells a row: the form with cells in the lanes serves. A cell more a row: the other does.
    let medium = crate::scattering::ordinates::tests::patchy([16, 16, 4], [1.0; 3], 2.0);
    let solver = Solver::new(&medium, Params { rays: 256, ..Params::default() }).expect("legal");
    let points = bolt([6.2, 7.1, 3.4], [8.1, 8.4, -0.5], 12);
    let (lights, _) = solver.solve(&[&points]).expect("solved");
    let direct = solver.direct(&points);
    let [one, lane] = [solver.collect(&direct, &lights[0].diffuse), solver.collect_lane(&direct, &lights[0].diffuse)];
    // The order of sums.
    assert!(relative(&one, &lane) < 1e-5, "{}", relative(&one, &lane));
    // And both are the light that was solved, up to the residual.
    assert!(relative(&one, &lights[0].towards) < 1e-3, "{}", relative(&one, &lights[0].towards));
}

#[test]
fn a_light_on_a_virtual_light_is_the_table_itself() {
    let mut recipe = small(Content::Total, false);
    recipe.packing = Packing { threshold: 0.0, width: Width::F32 };
    let basis = Basis::bake(recipe.clone()).expect("baked");
    let solver = Solver::new(&recipe.medium, recipe.params).expect("legal");
    let relighter = Relighter::new(&recipe.medium, &solver);
    let points = [PointSource { position_m: recipe.lights.position_m(31), intensity: 2.0 }];
    let table = relighter.relight(Method::Basis, &points, Some(&basis)).expect("lit");
    let truth = relighter.relight(Method::Reference, &points, None).expect("lit");
    // Rounding of Haar in f32; the lanes of a batch stop together, a single one stops alone (residual 1e-4).
    assert!(relative(&table.towards, &truth.towards) < 1e-3);
}

#[test]
fn a_deck_is_lit_in_one_place_only_and_the_same_everywhere() {
    let recipe = small(Content::Total, true);
    let basis = Basis::bake(recipe.clone()).expect("baked");
    let solver = Solver::new(&recipe.medium, recipe.params).expect("legal");
    let relighter = Relighter::new(&recipe.medium, &solver);
    let near = bolt([3.0, 3.3, 3.0], [3.4, 3.0, 1.0], 10);
    // The same bolt three tiles east and two south: the same light, three tiles on.
    let far: Vec<PointSource> = near
        .iter()
        .map(|p| PointSource { position_m: [p.position_m[0] + 24.0, p.position_m[1] - 16.0, p.position_m[2]], ..*p })
        .collect();
    for method in [Method::Single, Method::Basis, Method::Solve] {
        let table = method.table().map(|_| &basis);
        let a = relighter.relight(method, &near, table).expect("lit");
        let b = relighter.relight(method, &far, table).expect("lit");
        assert_eq!([b.corner[0] - a.corner[0], b.corner[1] - a.corner[1]], [24, -16]);
        // Positions three tiles away have two bits less.
        assert!(relative(&a.towards, &b.towards) < 1e-4, "{method:?}");
    }
    let solved = relighter.relight(Method::Solve, &near, None).expect("lit").towards;
    let summed = relighter.relight(Method::Basis, &near, Some(&basis)).expect("lit").towards;
    // Eq. 6 smears the source over its eight lights: the light as a whole is still there.
    let sum = |v: &[f32]| v.iter().map(|x| f64::from(*x)).sum::<f64>();
    assert!((sum(&summed) / sum(&solved) - 1.0).abs() < 0.35, "{}", sum(&summed) / sum(&solved));
}

#[test]
fn few_points_many_points_none_and_bad_ones() {
    let recipe = small(Content::Diffuse, false);
    let solver = Solver::new(&recipe.medium, recipe.params).expect("legal");
    let relighter = Relighter::new(&recipe.medium, &solver);
    let table = Basis::bake(recipe.clone()).expect("baked");
    let many = bolt([2.0, 2.0, 3.0], [6.0, 5.0, -1.0], 100_000);
    assert!(merge(&many, 0.5).len() < 60);
    let power: f64 = merge(&many, 0.5).iter().map(|p| p.intensity).sum();
    assert!((power - 1.0).abs() < 1e-9);
    for points in [&many[..], &many[..1], &[]] {
        for method in [Method::Point, Method::Single, Method::Hybrid, Method::Solve] {
            if method == Method::Point && points.len() > 1 {
                continue;
            }
            let lit = relighter.relight(method, points, method.table().map(|_| &table)).expect("lit");
            assert!(lit.towards.iter().all(|v| v.is_finite() && *v >= 0.0), "{method:?}");
            assert_eq!(lit.towards.iter().all(|v| *v == 0.0), points.is_empty(), "{method:?}");
        }
    }
    for intensity in [0.0, -1.0, f64::NAN] {
        let bad = [PointSource { position_m: [1.0; 3], intensity }];
        assert!(matches!(relighter.relight(Method::Point, &bad, None), Err(RelightError::Solve(_))));
    }
    assert!(matches!(relighter.relight(Method::Basis, &many[..1], Some(&table)), Err(RelightError::Table("basis", _))));
    assert!(matches!(relighter.relight(Method::Hybrid, &many[..1], None), Err(RelightError::Table("hybrid", _))));
    let outside = [PointSource { position_m: [-9.0, 4.0, 1.0], intensity: 1.0 }];
    assert_eq!(relighter.relight(Method::Hybrid, &outside, Some(&table)).expect("lit").outside, 1);
}

#[test]
fn a_solve_that_does_not_converge_falls_back_and_says_so() {
    let medium = crate::scattering::ordinates::tests::patchy([8, 8, 4], [1.0; 3], 8.0);
    let params = Params { most_sweeps: 3, albedo: 1.0, rays: 256, ..Params::default() };
    let solver = Solver::new(&medium, params).expect("legal");
    let points = bolt([2.0, 2.0, 3.0], [6.0, 5.0, 0.0], 5);
    let lit = Relighter::new(&medium, &solver).relight(Method::Solve, &points, None).expect("lit");
    assert!(lit.method == Method::Single && matches!(lit.fallback, Some(SolveError::NoConvergence { .. })));
    assert!(lit.towards.iter().any(|v| *v > 0.0));
}
