//! Charts: the Moebius form against the plain projection, weights without a step, scale, and nothing that jumps.

use super::*;
use crate::geo::Geodetic;
use crate::geo::frames::enu;
use crate::geo::wgs84::to_ecef;

/// Evenly spread points (golden-angle spiral).
fn sphere(n: usize) -> impl Iterator<Item = DVec3> {
    (0..n).map(move |k| {
        let z = 1.0 - (2.0 * k as f64 + 1.0) / n as f64;
        let angle = k as f64 * 2.399_963_229_728_653;
        let level = (1.0 - z * z).sqrt();
        DVec3::new(level * angle.cos(), level * angle.sin(), z)
    })
}

/// Any eye axes at a unit direction.
fn axes_at(up: DVec3) -> DMat3 {
    let east = if up.z.abs() > 0.999_999 { DVec3::Y } else { DVec3::Z.cross(up).normalize() };
    DMat3::from_cols(east, up.cross(east), up)
}

/// A direction at an angle and azimuth from `up`.
fn away(axes: &DMat3, angle_rad: f64, azimuth_rad: f64) -> DVec3 {
    let (east, north) = azimuth_rad.sin_cos();
    *axes * DVec3::new(angle_rad.sin() * east, angle_rad.sin() * north, angle_rad.cos())
}

/// The plain projection of a pattern direction, from its definition.
fn direct_m(chart: usize, pattern: DVec3) -> DVec2 {
    let local = AXES[chart].transpose() * pattern;
    DVec2::new(local.x, local.y) * (2.0 * MEAN_RADIUS_M * CENTRE_SCALE / (1.0 + local.z))
}

fn global_weights(pattern: DVec3) -> Vec<f64> {
    blend(&AXES.iter().map(|axes| axes.z_axis.dot(pattern)).collect::<Vec<_>>())
}

#[test]
fn the_centres_are_those_of_the_pentakis_dodecahedron() {
    for (i, axes) in AXES.iter().enumerate() {
        assert!((axes.determinant() - 1.0).abs() < 1e-12);
        let mut gaps: Vec<f64> =
            (0..CHARTS).filter(|&j| j != i).map(|j| axes.z_axis.angle_between(AXES[j].z_axis).to_degrees()).collect();
        gaps.sort_by(f64::total_cmp);
        // Closed forms: vertex to face centre 37.377 degrees, face centre to face centre acos(sqrt(5)/3) = 41.810.
        if i < 12 {
            assert!(gaps[..5].iter().all(|gap| (gap - 37.377_368).abs() < 1e-5), "{i}: {gaps:?}");
        } else {
            assert!(gaps[..3].iter().all(|gap| (gap - 37.377_368).abs() < 1e-5), "{i}: {gaps:?}");
            assert!(gaps[3..6].iter().all(|gap| (gap - 41.810_315).abs() < 1e-5), "{i}: {gaps:?}");
        }
    }
}

#[test]
fn the_moebius_form_is_the_plain_projection() {
    let mut compared = 0;
    for (k, up) in sphere(300).enumerate() {
        let axes = axes_at(up);
        let drift = DQuat::from_scaled_axis(DVec3::new(0.3, -1.1, 0.7) * (k as f64 * 0.01));
        for view in charts_near(up, axes.x_axis, axes.y_axis, drift, 400_000.0) {
            for azimuth in 0..8 {
                let point = away(&axes, 400_000.0 / MEAN_RADIUS_M, f64::from(azimuth) * 0.8);
                let local = axes.transpose() * point * (MEAN_RADIUS_M + 3000.0);
                let error = view.coordinate_m(around_eye_m(local)) - direct_m(view.chart, drift.inverse() * point);
                // f64 holds 1e-9 m of the radius; a dozen operations make some times that.
                assert!(error.length() < 1e-6, "eye {k}: {error}");
                compared += 1;
            }
        }
    }
    assert!(compared >= 2400);
}

#[test]
fn a_coordinate_has_one_place() {
    for (k, up) in sphere(500).enumerate() {
        let axes = axes_at(up);
        for view in charts_near(up, axes.x_axis, axes.y_axis, DQuat::IDENTITY, 100_000.0) {
            let (latitude_rad, longitude_rad) = place_of(view.chart, view.origin_m);
            let back = enu(&Geodetic { latitude_rad, longitude_rad, altitude_m: 0.0 }).z_axis;
            // f64 of 6e6 m, a few times over.
            assert!((back - up).length() < 1e-14 * 10.0, "{k}: {back} {up}");
            // The same of the sphere's radius.
            assert!((coordinate_of(view.chart, up) - view.origin_m).length() < 1e-6, "{k}");
        }
    }
}

#[test]
fn weights_add_up_with_at_most_three_and_true_scale() {
    let (mut low, mut high, mut most) = (f64::MAX, f64::MIN, 0);
    for point in sphere(100_000) {
        let weights = global_weights(point);
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        most = most.max(weights.iter().filter(|&&w| w > 0.0).count());
        for (chart, _) in weights.iter().enumerate().filter(|(_, w)| **w > 0.0) {
            // Scale of the stereographic projection: 1 / cos^2(angle / 2) = 2 / (1 + cos angle).
            let scale = CENTRE_SCALE * 2.0 / (1.0 + AXES[chart].z_axis.dot(point));
            (low, high) = (low.min(scale), high.max(scale));
        }
    }
    assert_eq!(most, MOST_AT_ONCE);
    assert!(low > 0.97 && high < 1.03, "scale from {low} to {high}");
    assert!((CENTRE_SCALE..CENTRE_SCALE + 1e-3).contains(&low), "a centre was sampled: {low}");
}

#[test]
fn weights_have_no_step_and_the_zone_is_10_km_wide() {
    for (from, to) in [(0, None), (12, Some(37.4)), (12, Some(41.8))] {
        let start = AXES[from].z_axis;
        let to = (0..CHARTS)
            .filter(|&j| j != from)
            .filter(|&j| to.is_none_or(|gap: f64| (start.angle_between(AXES[j].z_axis).to_degrees() - gap).abs() < 0.1))
            .min_by(|&i, &j| start.angle_between(AXES[i].z_axis).total_cmp(&start.angle_between(AXES[j].z_axis)))
            .unwrap();
        let angle = start.angle_between(AXES[to].z_axis);
        let across = start.cross(AXES[to].z_axis).normalize();
        let step_m = 50.0;
        let steps = (angle * MEAN_RADIUS_M / step_m) as usize;
        let mut before = global_weights(start);
        let mut zone_m = 0.0;
        for k in 1..=steps {
            let point = DQuat::from_axis_angle(across, k as f64 * step_m / MEAN_RADIUS_M) * start;
            let now = global_weights(point);
            // A weight goes from 0 to 1 over 9.6 km or more, steepest at the ends of the zone: twice the mean slope.
            for (a, b) in before.iter().zip(&now) {
                assert!((a - b).abs() < 2.0 * step_m / 9_600.0, "step {k}: {a} to {b}");
            }
            zone_m += if now.iter().filter(|&&w| w > 0.0).count() > 1 { step_m } else { 0.0 };
            before = now;
        }
        assert!((9_300.0..11_000.0).contains(&zone_m), "{from} to {to}: {zone_m}");
    }
}

#[test]
fn every_chart_with_weight_within_the_extent_is_listed() {
    let reach = 400_000.0 / MEAN_RADIUS_M;
    for up in sphere(3_000) {
        let axes = axes_at(up);
        let views = charts_near(up, axes.x_axis, axes.y_axis, DQuat::IDENTITY, 400_000.0);
        assert!(!views.is_empty() && views.windows(2).all(|pair| pair[0].w.z >= pair[1].w.z));
        for k in 0..24 {
            let point = away(&axes, reach * f64::from(k % 3 + 1) / 3.0, f64::from(k) * 0.7);
            let global = global_weights(point);
            let local = weights(&views, axes.transpose() * point);
            for (chart, weight) in global.iter().enumerate() {
                let listed = views.iter().position(|view| view.chart == chart).map_or(0.0, |place| local[place]);
                // Differences of cosines to 1e-15, over BLEND.
                assert!((listed - weight).abs() < 1e-12, "chart {chart}: {listed} {weight}");
            }
        }
    }
}

#[test]
fn a_ground_point_keeps_its_coordinate_while_the_eye_flies() {
    let drift = DQuat::from_scaled_axis(DVec3::new(0.02, 0.5, -0.3));
    let at = |latitude_deg: f64, longitude_deg: f64| Geodetic {
        latitude_rad: latitude_deg.to_radians(),
        longitude_rad: longitude_deg.to_radians(),
        altitude_m: 0.0,
    };
    // Over the pole, along and across the 180th meridian, round the equator, with the ground point near the middle.
    let over_pole = |s: f64| if s < 0.5 { at(88.0 + 4.0 * s, 40.0) } else { at(92.0 - 4.0 * s, -140.0) };
    let across = |s: f64| at(-17.0, if s < 0.5 { 178.0 + 4.0 * s } else { -182.0 + 4.0 * s });
    let along = |s: f64| at(10.0 + 4.0 * s, 180.0);
    let flights: [(&dyn Fn(f64) -> Geodetic, Geodetic); 3] =
        [(&over_pole, at(89.9, 10.0)), (&across, at(-17.1, 179.99)), (&along, at(12.0, -179.99))];
    for (flight, ground) in flights {
        let ground = to_ecef(&ground);
        let mut fixed: [Option<DVec2>; CHARTS] = [None; CHARTS];
        let mut seen = 0;
        for k in 0..=200 {
            let eye = flight(f64::from(k) / 200.0);
            let geodetic = enu(&eye);
            let up = to_ecef(&eye).normalize();
            let views = charts_near(up, geodetic.x_axis, geodetic.y_axis, drift, 400_000.0);
            let axes = DMat3::from_cols(geodetic.x_axis, up.cross(geodetic.x_axis), up);
            let local = axes.transpose() * ground;
            for view in &views {
                let now = view.coordinate_m(around_eye_m(local));
                let first = *fixed[view.chart].get_or_insert(now);
                assert!(
                    (now - first).length() < 1e-6,
                    "step {k}, chart {}: moved {}",
                    view.chart,
                    (now - first).length()
                );
                seen += 1;
            }
        }
        assert!(seen > 200);
    }
}
