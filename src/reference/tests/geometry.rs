//! The deck's geometry as an eye meets it: nothing pops on the way through, views join, no gap towards the horizon.

use super::*;
use crate::geo::Attitude;
use crate::world::command::{Exposure, Frustum};
use crate::world::snapshot::{LayerState, Snapshot};

/// The 8-bit picture of a snapshot's first view.
fn shown(executor: &mut ReferenceExecutor, snapshot: &Snapshot) -> Vec<u8> {
    match executor.draw(&plan(snapshot, &snapshot.views[0], Output::Srgb8)) {
        Pixels::Srgb8(pixels) => pixels,
        Pixels::LinearRgb(_) => panic!("not an 8-bit picture"),
    }
}

/// Greatest change of each pixel between two pictures, over its colours.
fn changes(one: &[u8], other: &[u8]) -> Vec<u8> {
    let pixel = |(a, b): (&[u8], &[u8])| (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap_or(0);
    one.chunks_exact(4).zip(other.chunks_exact(4)).map(pixel).collect()
}

#[test]
fn nothing_pops_on_the_way_through_base_slices_and_top() {
    let mut executor = ReferenceExecutor::new();
    let (mut pixels, mut beyond_4, mut beyond_12, mut worst) = (0usize, 0usize, 0usize, (0u8, String::new()));
    // In broken cumulus at two places, and in a whole sheet; the shells between groups of slices lie at thirds of the layer.
    for (kind, coverage, longitude_deg) in
        [(CloudKind::Cumulus, 0.5, 8.0), (CloudKind::Cumulus, 0.7, 8.3), (CloudKind::Stratus, 1.0, 8.0)]
    {
        for height_m in [1_000.0f64, 1_000.0 + 1_000.0 / 3.0, 1_500.0, 2_000.0] {
            let mut snapshot = cumulus_at(place(47.0, longitude_deg, height_m));
            (snapshot.weather.layers[0].kind, snapshot.weather.layers[0].coverage) = (kind, coverage);
            (snapshot.quality.slices, snapshot.quality.ring_ratio) = (32, 1.5);
            let view = &mut snapshot.views[0];
            (view.size_px, view.exposure) = ([40, 24], Exposure::Ev100(14.5));
            let mut before: Option<Vec<u8>> = None;
            for metre in -4..=4 {
                snapshot.ownship.position.altitude_m = height_m + f64::from(metre) + 0.25;
                let now = shown(&mut executor, &snapshot);
                if let Some(before) = before {
                    for change in changes(&before, &now) {
                        pixels += 1;
                        beyond_4 += usize::from(change > 4);
                        beyond_12 += usize::from(change > 12);
                        if change > worst.0 {
                            worst = (change, format!("{kind:?} near {height_m} m, step to {metre}"));
                        }
                    }
                }
                before = Some(now);
            }
        }
    }
    println!("{beyond_4} of {pixels} pixels change by more than 4/255, {beyond_12} by more than 12; at most {worst:?}");
    // A crisp edge a kilometre away moves by a milliradian in a metre, a fortieth of these pixels: whoever is beside a cloud sees
    // its outlines move by more than 4/255, and a pixel's one ray meets an outline or not. In 300 pixels one, and beyond 12/255 in
    // 6000 one.
    assert!(beyond_4 * 300 <= pixels, "{beyond_4} of {pixels} pixels");
    assert!(beyond_12 * 6000 <= pixels, "{beyond_12} of {pixels} pixels, {worst:?}");
}

#[test]
fn a_change_that_pops_is_noticed() {
    // The tester: fifty metres at once are no metre.
    let mut executor = ReferenceExecutor::new();
    let mut snapshot = cumulus_at(place(47.0, 8.0, 1_000.0));
    (snapshot.views[0].size_px, snapshot.views[0].exposure) = ([40, 24], Exposure::Ev100(14.5));
    let before = shown(&mut executor, &snapshot);
    snapshot.ownship.position.altitude_m += 50.0;
    let found = changes(&before, &shown(&mut executor, &snapshot));
    assert!(found.iter().filter(|c| **c > 12).count() > found.len() / 100);
}

/// A view turned to the right whose pixels' centres reach `half_deg` to each side, 33 pixels wide; `up`: tangent of its upper
/// edge.
fn turned(snapshot: &Snapshot, right_deg: f64, half_deg: f64, up: f64) -> Snapshot {
    const COLUMNS: u32 = 33;
    let mut turned = snapshot.clone();
    // Half a pixel beyond the outermost centres.
    let side = (half_deg.to_radians().tan() / (1.0 - 1.0 / f64::from(COLUMNS))).atan().to_degrees();
    let top = up.atan().to_degrees();
    let view = &mut turned.views[0];
    view.size_px = [COLUMNS, 20];
    view.attitude = Attitude { yaw_rad: right_deg.to_radians(), ..Attitude::default() };
    view.frustum = Some(Frustum { left_deg: -side, right_deg: side, top_deg: top, bottom_deg: -top });
    view.exposure = Exposure::Ev100(14.5);
    turned
}

/// Linear values of one column of a picture 33 pixels wide.
fn column(executor: &mut ReferenceExecutor, snapshot: &Snapshot, column: usize) -> Vec<[f32; 3]> {
    let Pixels::LinearRgb(values) = executor.draw(&plan(snapshot, &snapshot.views[0], Output::LinearRgb)) else {
        panic!("not linear")
    };
    values.chunks_exact(3 * 33).map(|row| [row[3 * column], row[3 * column + 1], row[3 * column + 2]]).collect()
}

#[test]
fn two_views_of_45_degrees_join_like_one_of_90() {
    let mut executor = ReferenceExecutor::new();
    let mut noticed = 0;
    for altitude_m in [400.0, 1_500.0, 3_000.0] {
        let mut snapshot = cumulus_at(place(47.0, 8.0, altitude_m));
        (snapshot.quality.slices, snapshot.quality.ring_ratio) = (32, 1.5);
        let half = 22.5f64;
        // Upper edge such that rows of both sizes look into the same directions where the views meet.
        let (narrow_up, wide_up) = (0.4, 0.4 * half.to_radians().cos());
        let left = column(&mut executor, &turned(&snapshot, -half, half, narrow_up), 32);
        let right = column(&mut executor, &turned(&snapshot, half, half, narrow_up), 0);
        let middle = column(&mut executor, &turned(&snapshot, 0.0, 45.0, wide_up), 16);
        let apart = |a: &[[f32; 3]], b: &[[f32; 3]]| {
            let channels = a.iter().flatten().zip(b.iter().flatten());
            channels.map(|(a, b)| (a - b).abs() / (0.5 * (a + b)).max(1.0)).fold(0.0, f32::max)
        };
        // Both look along the same directions, given by different axes: the last bits of f32 (6e-8) over ranges of 100 km
        // move a look by a centimetre, and an edge that is 10 m wide by a thousandth of its light.
        let seam = apart(&left, &right);
        assert!(seam < 0.01, "at {altitude_m} m: {seam}");
        // Steps are so many pixels long, and the wide view's are 8 % smaller: what steps of another length may change.
        let joined = apart(&left, &middle);
        assert!(joined < 0.08, "at {altitude_m} m: {joined}");
        // The tester: the next column is not the same.
        let next = column(&mut executor, &turned(&snapshot, half, half, narrow_up), 1);
        noticed += usize::from(apart(&left, &next) > 2.0 * seam.max(0.005));
    }
    // Inside a cloud columns may well be alike.
    assert!(noticed >= 2, "{noticed}");
}

/// Rays within a few degrees of the horizon that meet a stratus from 500 to 900 m and see through it, and those that see cloud
/// where there is none: elevation in degrees and opacity.
fn at_fault(altitude_m: f64, half_deg: f64, coverage: f64) -> Vec<(f64, f32)> {
    let earth_m = 6_371_000.0f64;
    let mut snapshot = cumulus_at(place(47.0, 8.0, altitude_m));
    snapshot.weather.layers[0] = LayerState { coverage, ..layer(CloudKind::Stratus, 500.0, 400.0) };
    snapshot.quality.slices = 32;
    let view = &mut snapshot.views[0];
    let rows = 160;
    view.size_px = [16, rows];
    view.frustum = Some(Frustum { left_deg: -20.0, right_deg: 20.0, top_deg: half_deg, bottom_deg: -half_deg });
    let planned = plan(&snapshot, &snapshot.views[0], Output::LinearRgb);
    let found = opacities(&planned);
    // Rays lower than the tangent to the top meet it from above; from below every ray meets the base.
    let dip_rad = |height_m: f64| ((earth_m + height_m) / (earth_m + altitude_m)).min(1.0).acos();
    let mut wrong = Vec::new();
    for (i, opacity) in found.iter().enumerate() {
        let ray = planned.camera.ray((i % 16) as f32 + 0.5, (i / 16) as f32 + 0.5);
        let elevation_rad = f64::from(ray.z).asin();
        let meets = if altitude_m > 900.0 {
            // The upper quarter closes softly: what goes below it is in whole cloud.
            elevation_rad < -dip_rad(780.0) - 0.05f64.to_radians()
        } else if altitude_m < 500.0 {
            // Above the ground's horizon.
            elevation_rad > -dip_rad(0.0) + 0.02f64.to_radians()
        } else {
            true
        };
        let clear = altitude_m > 900.0 && elevation_rad > -dip_rad(900.0) + 0.02f64.to_radians();
        // Whole cloud, walked until 0.4 % are left.
        if (meets && *opacity <= 0.98) || (clear && *opacity >= 1e-3) {
            wrong.push((elevation_rad.to_degrees(), *opacity));
        }
    }
    wrong
}

#[test]
fn no_gap_opens_at_grazing_angles() {
    // From under, from inside and from above.
    for (altitude_m, half_deg) in
        [(50.0, 4.0), (499.0, 4.0), (700.0, 4.0), (901.0, 4.0), (3_000.0, 4.0), (11_000.0, 6.0)]
    {
        let wrong = at_fault(altitude_m, half_deg, 1.0);
        assert!(wrong.is_empty(), "at {altitude_m} m: {wrong:?}");
    }
    // The tester: half a sky of cloud has gaps.
    assert!(!at_fault(3_000.0, 4.0, 0.5).is_empty());
}
