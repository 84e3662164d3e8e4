//! Pins the solver against what is exact (white furnace, no scattering, energy), against Monte Carlo, and at its extremes.

use super::*;
use crate::numeric::hash::{pcg3d, unit};
use crate::numeric::sphere::{Direction, Rule};
use crate::scattering::monte_carlo;
use crate::scattering::phase::Phase;

const GRAINS: u32 = 77;

/// A patchy cloud of greatest depth `depth` per longest edge: half of it empty or thin.
pub(in crate::scattering) fn patchy(cells: [usize; 3], spacing_m: [f64; 3], depth: f32) -> Medium {
    let edge = spacing_m.iter().copied().fold(0.0, f64::max) as f32;
    let values = (0..cells.iter().product::<usize>())
        .map(|i| {
            let at = [i % cells[0], i / cells[0] % cells[1], i / (cells[0] * cells[1])].map(|c| c as u32 / 2);
            let noise = unit(pcg3d(at[0], at[1], at[2] + GRAINS)[0]);
            (2.0 * noise - 0.8).clamp(0.0, 1.0) * depth / edge
        })
        .collect();
    Medium::new(cells, spacing_m, values, false).expect("a legal medium")
}

fn point(position_m: Direction) -> [PointSource; 1] {
    [PointSource { position_m, intensity: 1.0 }]
}

fn one(medium: &Medium, source: Direction, params: Params) -> (Light, Info) {
    let solver = Solver::new(medium, params).expect("legal parameters");
    let (mut lights, info) = solver.solve(&[&point(source)]).expect("a solution");
    (lights.remove(0), info)
}

fn relative(a: impl Iterator<Item = f64>, b: &[f64]) -> f64 {
    let (mut difference, mut whole) = (0.0, 0.0);
    for (a, b) in a.zip(b) {
        difference += (a - b) * (a - b);
        whole += b * b;
    }
    (difference / whole).sqrt()
}

/// Light of 1 from everywhere through cells that lose nothing must be 1 everywhere, however it is scattered.
#[test]
fn white_furnace() {
    let phases =
        [Phase::HenyeyGreenstein(0.0), Phase::HenyeyGreenstein(0.85), Phase::HenyeyGreenstein(-0.5), Phase::DECK];
    for (rule, cells, spacing) in [
        (Rule::Lebedev26, [8, 6, 4], [1.0, 1.0, 1.0]),
        (Rule::Lebedev26, [6, 6, 4], [4.0, 4.0, 1.0]),
        (Rule::Lebedev26, [1, 1, 1], [1.0, 1.0, 1.0]),
        (Rule::Lebedev50, [5, 4, 3], [1.0, 1.0, 1.0]),
        (Rule::Lebedev110, [4, 3, 2], [1.0, 1.0, 0.5]),
    ] {
        for phase in phases {
            for depth in [0.25, 1.0, 4.0] {
                let medium = patchy(cells, spacing, depth);
                let params = Params { rule, phase, albedo: 1.0, rays: 64, ..Params::default() };
                let mut operator = Solver::new(&medium, params).expect("legal").operator;
                let mut work = Work::new(&operator);
                let mut x = vec![Lanes::ZERO; medium.len() * operator.angles.moments];
                let mut b = x.clone();
                operator.incoming = 1.0;
                operator.apply(&x, None, &mut work, &mut b);
                operator.incoming = 0.0;
                let done = krylov::solve(
                    |x, out| operator.apply(x, None, &mut work, out),
                    &b,
                    &mut x,
                    (Method::BiCgStab, krylov::Holding::Sources),
                    1e-6,
                    500,
                );
                assert!(done.residual < 1e-5, "{done:?}");
                operator.incoming = 1.0;
                operator.apply(&x.clone(), None, &mut work, &mut x);
                // What is left is the iteration's residual times how long light stays, and f32.
                let worst = work.radiance.iter().map(|l| (l.0[0] - 1.0).abs()).fold(0.0, f32::max);
                assert!(worst < 5e-5, "{rule:?} {phase:?} {depth}: {worst}");
            }
        }
    }
}

#[test]
fn against_monte_carlo_where_clouds_are_thin() {
    let medium = patchy([14, 14, 4], [1.0; 3], 1.0);
    for (asymmetry, source) in [(0.0, [7.3, 6.7, 1.9]), (0.85, [7.3, 6.7, 1.9]), (0.6, [7.2, 6.6, -2.0])] {
        let phase = Phase::HenyeyGreenstein(asymmetry);
        let (light, info) = one(&medium, source, Params { phase, albedo: 0.99, ..Params::default() });
        let directions = Rule::Lebedev26.set().directions;
        let mc = monte_carlo::Params { photons: 100_000, seed: 1, albedo: 0.99, phase, ground: None, directions };
        let reference = monte_carlo::point_source(&medium, source, &mc);
        let rate = light.fluence.iter().zip(&medium.extinction_per_m).map(|(f, s)| 0.99 * f64::from(f * s));
        let noise = relative(reference.error.iter().zip(&reference.total).map(|(e, t)| e + t), &reference.total);
        // The stated bound of 0.10 for the ray effect of 26 directions and the flat light in a cell; the reference's noise.
        let error = relative(rate, &reference.total);
        assert!(error < 0.10 + noise, "{asymmetry} {source:?}: {error}, noise {noise}, {info:?}");
        let cells = medium.len();
        let b = light.towards.iter().enumerate().map(|(i, v)| f64::from(v * medium.extinction_per_m[i % cells]));
        let towards: Vec<f64> = reference.towards.iter().map(|v| f64::from(*v)).collect();
        let error = relative(b, &towards);
        // Directions resolve a lobe of 0.85 by means over a 26th of the sphere: the bound of the radiance, 0.35.
        assert!(error < 0.20 + 3.0 * noise, "{asymmetry} {source:?}: {error}");
        assert!(light.energy.imbalance.abs() < 0.02, "{:?}", light.energy);
        let escaped = light.energy.escaped_direct + light.energy.escaped_diffuse;
        assert!((escaped - reference.escaped.mean).abs() < 0.02 + 4.0 * reference.escaped.error);
    }
}

#[test]
fn against_monte_carlo_in_a_real_deck() {
    // Stratocumulus in cells of 500 m: 10 and more free paths per cell, hardly any absorption.
    let medium = patchy([10, 10, 3], [500.0; 3], 12.0);
    let source = [2600.0, 2400.0, 700.0];
    let phase = Phase::HenyeyGreenstein(0.85);
    let (light, info) = one(&medium, source, Params { phase, ..Params::default() });
    let mc = monte_carlo::Params { photons: 10_000, seed: 1, albedo: 0.9999, phase, ground: None, directions: vec![] };
    let reference = monte_carlo::point_source(&medium, source, &mc);
    let rate = light.fluence.iter().zip(&medium.extinction_per_m).map(|(f, s)| 0.9999 * f64::from(f * s));
    let error = relative(rate, &reference.total);
    // The light of the source's own cell is a straight line in it where the truth has a peak: 0.3 is asked.
    assert!(error < 0.3, "{error} {info:?}");
    assert!(light.energy.imbalance.abs() < 0.01, "{:?}", light.energy);
}

#[test]
fn flat_cells_agree_with_monte_carlo_too() {
    for flat in [0.5, 0.125] {
        let medium = patchy([8, 8, 8], [1.0, 1.0, flat], 1.0);
        let source = [4.1, 3.8, 3.3 * flat];
        let phase = Phase::HenyeyGreenstein(0.6);
        let (light, _) = one(&medium, source, Params { phase, albedo: 0.99, rays: 4096, ..Params::default() });
        let mc =
            monte_carlo::Params { photons: 150_000, seed: 1, albedo: 0.99, phase, ground: None, directions: vec![] };
        let reference = monte_carlo::point_source(&medium, source, &mc);
        let rate = light.fluence.iter().zip(&medium.extinction_per_m).map(|(f, s)| 0.99 * f64::from(f * s));
        let noise = relative(reference.error.iter().zip(&reference.total).map(|(e, t)| e + t), &reference.total);
        let error = relative(rate, &reference.total);
        assert!(error < 0.10 + noise, "{flat}: {error} {noise}");
    }
}

#[test]
fn without_albedo_nothing_is_scattered_and_direct_light_is_left() {
    let medium = patchy([6, 6, 4], [1.0; 3], 1.0);
    let (light, _) = one(&medium, [3.2, 2.9, 2.0], Params { albedo: 0.0, ..Params::default() });
    assert!(light.towards.iter().all(|v| *v == 0.0) && light.diffuse.iter().all(|v| *v == 0.0));
    assert!(light.fluence.iter().all(|v| *v > 0.0));
    assert!(light.energy.imbalance.abs() < 0.01 && light.energy.escaped_diffuse == 0.0);
}

#[test]
fn extremes_stay_finite_and_keep_energy() {
    let sources = [
        [3.5, 3.5, 1.5],
        [3.0, 3.0, 1.0],
        [0.0, 0.0, 0.0],
        [3.5, 3.5, 2.0],
        [7.0, 7.0, 3.0],
        [-4.0, 3.0, 1.0],
        [3.0, 3.0, -5000.0],
    ];
    for depth in [0.0, 1e-6, 16.0, 1e4] {
        for asymmetry in [-0.9, 0.0, 0.99] {
            for albedo in [0.9, 1.0] {
                let medium = patchy([7, 7, 3], [1.0; 3], depth);
                let params =
                    Params { phase: Phase::HenyeyGreenstein(asymmetry), albedo, rays: 512, ..Params::default() };
                let solver = Solver::new(&medium, params).expect("legal");
                let points = sources.map(point);
                let lanes: Vec<&[PointSource]> = points.iter().map(|p| &p[..]).collect();
                match solver.solve(&lanes) {
                    Ok((lights, info)) => {
                        assert!(info.residual <= 1e-4);
                        for (light, source) in lights.iter().zip(sources) {
                            let all = light.towards.iter().chain(&light.fluence).chain(&light.diffuse);
                            assert!(all.copied().all(f32::is_finite), "{depth} {asymmetry} {source:?}");
                            // Far cells are cones: a source that looks along a thick face misjudges what enters.
                            let bound = if source[0] < 0.0 || depth > 100.0 { 0.3 } else { 0.03 };
                            assert!(
                                light.energy.imbalance.abs() < bound,
                                "{depth} {asymmetry} {albedo} {source:?} {:?}",
                                light.energy
                            );
                        }
                    }
                    // Light that is never absorbed in cells 10,000 deep: said, not hidden.
                    Err(SolveError::NoConvergence { .. }) if depth == 1e4 => {}
                    Err(other) => panic!("{depth} {asymmetry} {albedo}: {other}"),
                }
            }
        }
    }
}

#[test]
fn one_cell_one_layer_and_an_empty_cloud() {
    for cells in [[1, 1, 1], [9, 9, 1], [1, 1, 9], [1, 9, 2]] {
        let medium = Medium::new(cells, [1.0; 3], vec![0.5; cells.iter().product()], false).expect("legal");
        let (light, _) = one(&medium, [0.4, 0.5, 0.6], Params { albedo: 0.9, ..Params::default() });
        assert!(light.energy.imbalance.abs() < 0.02 && light.energy.absorbed > 0.01, "{cells:?} {:?}", light.energy);
    }
    let empty = Medium::new([5, 5, 2], [1.0; 3], vec![0.0; 50], false).expect("legal");
    let (light, _) = one(&empty, [2.5, 2.5, 1.0], Params::default());
    assert!((light.energy.escaped_direct - 1.0).abs() < 1e-9 && light.energy.escaped_diffuse == 0.0);
}

#[test]
fn light_is_linear_in_its_sources_and_lanes_do_not_mix() {
    let medium = patchy([8, 8, 4], [1.0; 3], 2.0);
    let solver = Solver::new(&medium, Params { tolerance: 1e-6, ..Params::default() }).expect("legal");
    let (a, b) = ([3.3, 4.1, 2.2], [6.5, 1.5, -1.0]);
    let both = [PointSource { position_m: a, intensity: 2.0 }, PointSource { position_m: b, intensity: 0.5 }];
    let (lights, _) = solver.solve(&[&point(a), &both, &point(b), &[]]).expect("solved");
    let sum: Vec<f64> =
        lights[0].towards.iter().zip(&lights[2].towards).map(|(a, b)| f64::from(2.0 * a + 0.5 * b)).collect();
    let error = relative(lights[1].towards.iter().map(|v| f64::from(*v)), &sum);
    // The iterations stop at residuals of 1e-6; where one source's cell is far from the other, the tilt of its far light
    // over that cell is left out.
    assert!(error < 1e-3, "{error}");
    assert!(lights[3].towards.iter().all(|v| *v == 0.0));
}

#[test]
fn both_iterations_find_the_same_light() {
    let medium = patchy([8, 8, 4], [1.0; 3], 3.0);
    let solve = |method| {
        let params = Params { method: Some(method), albedo: 0.99, tolerance: 1e-5, ..Params::default() };
        one(&medium, [4.4, 3.6, 1.2], params)
    };
    let ((slow, many), (fast, few)) = (solve(Method::SourceIteration), solve(Method::BiCgStab));
    let reference: Vec<f64> = slow.fluence.iter().map(|v| f64::from(*v)).collect();
    // Residuals of 1e-5 times how long light stays.
    assert!(relative(fast.fluence.iter().map(|v| f64::from(*v)), &reference) < 3e-4);
    assert!(few.sweeps < many.sweeps && few.method == Method::BiCgStab, "{few:?} {many:?}");
}

#[test]
fn a_window_leaves_the_second_tile_dark() {
    // A tile that repeats: the light of a source in its window ends at the window's edge and is not found again on the
    // other side, unlike in a medium whose light repeats with it.
    let mut tile = patchy([12, 12, 3], [1.0; 3], 0.5);
    tile.periodic = true;
    let source = [0.5, 0.5, 1.5];
    let (window, corner) = tile.window(source);
    assert_eq!(corner, [-6, -6]);
    let moved = [source[0] + 6.0, source[1] + 6.0, source[2]];
    let (light, _) = one(&window, moved, Params { albedo: 0.9, ..Params::default() });
    let at = |cell: [usize; 3]| f64::from(light.fluence[window.index(cell)]);
    let distance = |cell: [usize; 3]| (cell[0] as f64 + 0.5 - moved[0]).hypot(cell[1] as f64 + 0.5 - moved[1]);
    // The corners of the window are the places of the tile nearest to the source's images: dark as their distance.
    for corner in [[0, 0, 1], [11, 0, 1], [0, 11, 1], [11, 11, 1]] {
        assert!(at(corner) < at([6, 6, 1]) / (distance(corner) * distance(corner)), "{corner:?}");
    }
    assert!(light.energy.escaped_direct + light.energy.escaped_diffuse > 0.3);
}

#[test]
fn ground_lights_the_cloud_from_below_as_monte_carlo_says() {
    let medium = patchy([8, 8, 3], [1.0; 3], 1.0);
    let source = [4.2, 3.9, 1.4];
    let phase = Phase::HenyeyGreenstein(0.6);
    let mut rates = Vec::new();
    for ground in [None, Some(Ground { albedo: 0.8, depth_m: 0.5 })] {
        let (light, _) = one(&medium, source, Params { phase, albedo: 0.99, ground, ..Params::default() });
        let mc = monte_carlo::Params {
            photons: 100_000,
            seed: 4,
            albedo: 0.99,
            phase,
            ground: ground.map(|g| (g.albedo, g.depth_m)),
            directions: vec![],
        };
        let reference = monte_carlo::point_source(&medium, source, &mc);
        let rate = |v: &Light| -> f64 {
            v.fluence.iter().zip(&medium.extinction_per_m).map(|(f, s)| 0.99 * f64::from(f * s)).sum()
        };
        rates.push([rate(&light), reference.total.iter().sum::<f64>()]);
    }
    let gain = [rates[1][0] / rates[0][0], rates[1][1] / rates[0][1]];
    // Slanting light meets the ground at whole directions of the set: a few per cent of the gain.
    assert!(gain[1] > 1.08 && (gain[0] - gain[1]).abs() < 0.25 * (gain[1] - 1.0), "{gain:?}");
}

#[test]
fn a_limit_that_is_too_low_is_an_error_with_what_was_reached() {
    let medium = patchy([8, 8, 4], [1.0; 3], 8.0);
    let solver = Solver::new(&medium, Params { most_sweeps: 3, albedo: 1.0, ..Params::default() }).expect("legal");
    match solver.solve(&[&point([4.0, 4.0, 2.0])]) {
        Err(SolveError::NoConvergence { residual, sweeps, .. }) => assert!(residual > 1e-4 && sweeps <= 4),
        other => panic!("{other:?}"),
    }
}

#[test]
fn bad_values_are_refused_by_name() {
    let medium = patchy([2, 2, 2], [1.0; 3], 1.0);
    let base = Params::default();
    for (params, name) in [
        (Params { albedo: 1.01, ..base }, "albedo"),
        (Params { albedo: f64::NAN, ..base }, "albedo"),
        (Params { tolerance: 0.0, ..base }, "tolerance"),
        (Params { most_sweeps: 0, ..base }, "most_sweeps"),
        (Params { rays: 1, ..base }, "rays"),
        (Params { phase: Phase::HenyeyGreenstein(-1.0), ..base }, "phase"),
        (Params { ground: Some(Ground { albedo: 2.0, depth_m: 0.0 }), ..base }, "ground.albedo"),
        (Params { ground: Some(Ground { albedo: 0.2, depth_m: -1.0 }), ..base }, "ground.depth_m"),
    ] {
        match Solver::new(&medium, params) {
            Err(SolveError::Parameter { field, .. }) => assert_eq!(field, name),
            _ => panic!("{name} was let through"),
        }
    }
    let solver = Solver::new(&medium, base).expect("legal");
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refused = solver.solve(&[&[PointSource { position_m: [1.0; 3], intensity: bad }]]);
        assert!(matches!(refused, Err(SolveError::Source { field: "intensity", .. })));
        let far = if bad == 0.0 { 1e9 } else { bad * 1e9 };
        let refused = solver.solve(&[&[PointSource { position_m: [1.0, far, 0.0], intensity: 1.0 }]]);
        assert!(matches!(refused, Err(SolveError::Source { field: "position_m", .. })));
    }
    let nothing: &[PointSource] = &[];
    assert!(matches!(solver.solve(&[nothing; 17]), Err(SolveError::Lanes(17))));
    assert!(solver.solve(&[]).is_ok());
}

#[test]
fn thick_cells_around_the_source_agree_with_monte_carlo_by_early_collisions() {
    let medium = patchy([14, 14, 4], [1.0; 3], 4.0);
    // In a corner of its cell.
    let source = [7.2, 6.8, 1.85];
    for asymmetry in [0.0, 0.6, 0.85] {
        let phase = Phase::HenyeyGreenstein(asymmetry);
        let params = Params { phase, albedo: 0.99, ..Params::default() };
        let mc =
            monte_carlo::Params { photons: 40_000, seed: 3, albedo: 0.99, phase, ground: None, directions: vec![] };
        let reference = monte_carlo::point_source(&medium, source, &mc);
        let error = |solver: &Solver| {
            let (lights, _) = solver.solve(&[&point(source)]).expect("solved");
            let rate = lights[0].fluence.iter().zip(&medium.extinction_per_m).map(|(f, s)| 0.99 * f64::from(f * s));
            relative(rate, &reference.total)
        };
        let mut solver = Solver::new(&medium, params).expect("legal");
        let with = error(&solver);
        solver.early = None;
        let without = error(&solver);
        // Asked: 0.30 for isotropic light, else 0.20. Noise of both, and a cell's light as a straight line beyond the ball.
        assert!(with < 0.12, "{asymmetry}: {with}");
        // A mean and a straight line a cell put too much into the source's own.
        assert!(without > 1.5 * with, "{asymmetry}: {without} {with}");
    }
}
