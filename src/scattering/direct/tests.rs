//! Pins direct light against what is known in closed form and by fine sums, and that its energy is kept.

use super::*;
use crate::numeric::sphere::Rule;

fn light(medium: &Medium, source: Direction) -> Direct {
    let angles = Angles::new(Rule::Lebedev26);
    let phase = Phase::HenyeyGreenstein(0.5);
    let rays = Rays::new(2048, &angles, phase);
    let mut direct = Direct::dark(medium.len(), &angles, medium.cells[0] * medium.cells[1]);
    let with = With { angles: &angles, rays: &rays, phase, early: None, ground_depth_m: Some(0.5) };
    direct.add(medium, &[(source, 1.0)], with);
    direct
}

/// Power that collides in the box, from the zeroth moments.
fn collided(medium: &Medium, direct: &Direct) -> f64 {
    (0..medium.len())
        .map(|c| f64::from(direct.moments[c * 16]) * (4.0 * PI).sqrt() * f64::from(medium.extinction_per_m[c]))
        .sum::<f64>()
        * medium.cell_volume_m3()
}

#[test]
fn what_collides_and_what_leaves_is_what_was_sent() {
    for sigma in [0.0, 0.1, 1.0, 8.0, 1e4] {
        let medium = Medium::new([12, 12, 6], [1.0; 3], vec![sigma; 864], false).expect("legal");
        for source in [[6.5, 6.5, 3.5], [6.0, 6.0, 3.0], [5.7, 6.2, 3.4], [0.3, 0.2, 5.9], [6.1, 5.8, -3.0]] {
            let direct = light(&medium, source);
            let sum = (collided(&medium, &direct) + direct.escaped_w) / (4.0 * PI);
            // Counted along the rays; the moments are f32. Where nearly all is far, the scale has its limits.
            let bound = if source[2] < 0.0 { 0.02 } else { 1e-3 };
            assert!((sum - 1.0).abs() < bound, "{sigma} {source:?}: {sum}");
            assert!(direct.moments.iter().chain(&direct.towards).all(|v| v.is_finite()));
        }
    }
}

#[test]
fn a_cell_that_a_sharp_peak_meets_scatters_the_mean_of_it() {
    // Clear cells behind each other on an axis, which is a direction of the set: the peak points at it.
    let medium = Medium::new([15, 5, 5], [1.0; 3], vec![0.0; 375], false).expect("legal");
    let (source, forward) = ([2.5, 2.5, 2.5], [1.0, 0.0, 0.0]);
    let angles = Angles::new(Rule::Lebedev26);
    let ahead = angles.set.nearest(forward);
    for asymmetry in [0.85, 0.95] {
        let phase = Phase::HenyeyGreenstein(asymmetry);
        let mut direct = Direct::dark(medium.len(), &angles, 0);
        let rays = Rays::new(2048, &angles, phase);
        let with = With { angles: &angles, rays: &rays, phase, early: None, ground_depth_m: None };
        direct.add(&medium, &[(source, 1.0)], with);
        for distance in [4.0, 7.0, 11.0] {
            let cell = medium.index([2 + distance as usize, 2, 2]);
            // The mean of phase function over distance squared, by 20 x 20 x 20 parts.
            let part = |i: usize| (i as f64 + 0.5) / 20.0 - 0.5;
            let mean = (0..8000)
                .map(|i| {
                    let v = [distance + part(i % 20), part(i / 20 % 20), part(i / 400)];
                    let r2 = dot(v, v);
                    phase.value(v[0] / r2.sqrt()) / r2
                })
                .sum::<f64>()
                / 8000.0;
            let found = f64::from(direct.towards[ahead * medium.len() + cell]);
            // Three parts an edge at most, one of them in the middle of the peak.
            let bound = if asymmetry > 0.9 { 0.2 } else { 0.1 };
            assert!((found / mean - 1.0).abs() < bound, "{asymmetry} {distance}: {found} {mean}");
            let alone = phase.value(1.0) / (distance * distance);
            assert!(alone > 1.2 * mean || distance > 5.0 && asymmetry < 0.9 || distance > 8.0, "{alone} {mean}");
        }
    }
}

#[test]
fn the_cell_around_a_source_has_the_mean_of_the_inverse_square() {
    // Mean of 1/r^2 over a unit cube around its centre: the integral over a face of 3 / (x^2 + y^2 + 1/4), 7.674214.
    let medium = Medium::new([9, 9, 9], [1.0; 3], vec![0.0; 729], false).expect("legal");
    let direct = light(&medium, [4.5; 3]);
    let mean = f64::from(direct.moments[medium.index([4; 3]) * 16]) * (4.0 * PI).sqrt();
    assert!((mean / 7.674_214 - 1.0).abs() < 1e-3, "{mean}");
    // A far cell has the square of its distance, but for the spread of a cell at four cells' distance.
    let far = f64::from(direct.moments[medium.index([8, 4, 4]) * 16]) * (4.0 * PI).sqrt();
    assert!((far * 16.0 - 1.0).abs() < 0.02, "{far}");
}

#[test]
fn the_ground_gets_the_cosine_over_the_square() {
    let medium = Medium::new([3, 3, 2], [1.0; 3], vec![0.2; 18], false).expect("legal");
    let direct = light(&medium, [1.5, 1.5, 10.0]);
    let tau = 0.2 * 2.0;
    let exact = f64::exp(-tau) / (10.5 * 10.5 + 0.08);
    assert!((f64::from(direct.ground[4]) / exact - 1.0).abs() < 1e-5);
}

#[test]
fn early_collisions_keep_energy() {
    // Nothing is absorbed: what leaves, and what collides beyond the ball, is what was sent.
    for (sigma, cosine) in [(2.0, 0.0), (4.0, 0.6), (20.0, 0.85), (1e4, 0.0)] {
        let medium = Medium::new([12, 12, 6], [1.0, 1.0, 0.5], vec![sigma; 864], false).expect("legal");
        let angles = Angles::new(Rule::Lebedev26);
        let phase = Phase::HenyeyGreenstein(cosine);
        let rays = Rays::new(1024, &angles, phase);
        let early = Early::new(&medium, &[1.0, cosine]);
        assert!(early.is_some());
        for source in [[6.5, 6.5, 1.5], [6.9, 6.1, 2.4], [0.2, 0.1, 2.9], [6.1, 5.8, -0.4]] {
            let mut direct = Direct::dark(medium.len(), &angles, 0);
            direct.add(
                &medium,
                &[(source, 1.0)],
                With { angles: &angles, rays: &rays, phase, early, ground_depth_m: None },
            );
            let left = direct.escaped_w + direct.escaped_early_w;
            let sum = (collided(&medium, &direct) + left) / (4.0 * PI);
            // Photons that play for a tenth of their weight: the root of a few thousand over ten thousand, three times. Cones
            // that look into cells ten deep from outside misjudge what enters.
            let bound = if source[2] < 0.0 { 0.06 } else { 0.015 };
            assert!((sum - 1.0).abs() < bound, "{sigma} {cosine} {source:?}: {sum}");
            assert!(direct.settled.iter().chain(&direct.arrived).all(|v| v.is_finite()));
        }
    }
    let thin = Medium::new([4, 4, 2], [1.0; 3], vec![1.0; 32], false).expect("legal");
    assert_eq!(Early::new(&thin, &[1.0, 0.0]), None);
    let black = Medium::new([4, 4, 2], [1.0; 3], vec![9.0; 32], false).expect("legal");
    assert_eq!(Early::new(&black, &[0.0, 0.0]), None);
}
