//! Plans of extreme snapshots are finite; textures stand still under a moving eye; what a scene does not need is left out.

mod needs;

use super::eye::Eye;
use super::scenes::{clear_day, cumulus_at, extremes, flash, layer, place, region, sun};
use super::*;
use crate::clouds::{density, modulation};
use crate::geo::Geodetic;
use crate::geo::wgs84::{from_ecef, to_ecef};
use crate::passes::common::stereographic;
use crate::passes::deck::field::{BOUNDS_WIDTH, Textures, margin};
use crate::passes::deck::{FLASHES, Layer};
use bytemuck::Pod;
use glam::{DQuat, DVec3, Vec2};

fn plan_of(snapshot: &Snapshot) -> FramePlan {
    plan(snapshot, &snapshot.views[0], Output::Srgb8)
}

fn eye_at(snapshot: &Snapshot, position: Geodetic) -> Eye {
    let mut ownship = snapshot.ownship;
    ownship.position = position;
    Eye::new(&ownship, &snapshot.views[0], &snapshot.terrain)
}

/// Whole numbers among the members read as tiny floats, which are finite too.
fn finite<T: Pod>(scene: &str, value: &T) {
    let numbers: &[f32] = bytemuck::cast_slice(std::slice::from_ref(value));
    let name = std::any::type_name::<T>();
    for (index, number) in numbers.iter().enumerate() {
        assert!(number.is_finite(), "{scene}: number {index} of {name} is {number}");
    }
}

#[test]
fn every_number_of_an_extreme_plan_is_finite() {
    for (scene, snapshot) in extremes() {
        let plan = plan_of(&snapshot);
        finite(&scene, &plan.camera);
        finite(&scene, &plan.sky);
        let table = &plan.table;
        finite(&scene, &[table.eye_m, table.horizon, table.haze_per_m, table.night_luminance, table.scale]);
        for light in &table.lights {
            finite(&scene, &[light.direction.to_array(), light.illuminance_lux.to_array()]);
        }
        plan.ground.iter().for_each(|ground| finite(&scene, ground));
        let casters = plan.shadow.iter().flat_map(|shadow| &shadow.casters);
        casters.for_each(|caster| finite(&scene, &caster.shadow));
        for layer in &plan.layers {
            finite(&scene, &layer.layer);
            for light in &layer.light {
                assert!(light.voxel_height_m.is_finite() && light.extinction_per_m.is_finite(), "{scene}: {light:?}");
            }
            assert_eq!(layer.light.len(), layer.layer.charts as usize, "{scene}");
            assert!((1..=3).contains(&layer.layer.charts), "{scene}");
        }
    }
}

#[test]
fn equal_snapshots_have_equal_plans() {
    for ((_, a), (_, b)) in extremes().into_iter().zip(extremes()) {
        assert_eq!(plan_of(&a), plan_of(&b));
    }
}

/// Chart, and coordinates of a ground point in the 16 km tile (m) and in the map (periods), as the passes find them.
fn coordinates(eye: &Eye, point: &Geodetic) -> Vec<(usize, Vec2, Vec2)> {
    let earth_m = eye.earth_m as f32;
    let (views, charts) = eye.charts(DQuat::IDENTITY, 300_000.0, f64::from(density::TILE_M));
    let z = stereographic(eye.place(point), earth_m, earth_m);
    let found = views.iter().zip(&charts).map(|(view, chart)| {
        let moved = chart.displacement(z);
        let map = Vec2::from(chart.map_origin) + modulation::coordinates(moved);
        (view.chart, density::TILE_M * chart.tile(moved), map)
    });
    found.collect()
}

/// Difference of two coordinates that repeat.
fn apart(a: Vec2, b: Vec2, period: f32) -> f32 {
    let d = a - b;
    (d - (d / period).round() * period).length()
}

#[test]
fn a_millimetre_of_the_eye_moves_no_texture() {
    let snapshot = clear_day();
    for (latitude_deg, longitude_deg) in [
        (90.0, 0.0),
        (-90.0, 0.0),
        (89.999_999, 30.0),
        (0.0, 180.0),
        (47.0, -180.0),
        (-60.0, 179.999_999),
        (10.0, 20.0),
    ] {
        let here = place(latitude_deg, longitude_deg, 1_000.0);
        let eye = eye_at(&snapshot, here);
        for (azimuth, distance_m) in [(0.3, 0.0), (1.0, 700.0), (2.5, 5_000.0), (4.0, 40_000.0)] {
            let (east, north) = f64::sin_cos(azimuth);
            let ground = from_ecef(eye.ground_ecef_m + eye.enu * DVec3::new(east, north, 0.0) * distance_m);
            let ground = Geodetic { altitude_m: 0.0, ..ground };
            let before = coordinates(&eye, &ground);
            for step in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y] {
                let there = from_ecef(to_ecef(&here) + step * 1e-3);
                let after = coordinates(&eye_at(&snapshot, there), &ground);
                // A picture of 640 pixels and 60 degrees.
                let pixel_m = 2.0 * 30.0f32.to_radians().tan() / 640.0 * (distance_m as f32).hypot(1_000.0);
                for (chart, tile, map) in &before {
                    let found = after.iter().find(|(other, _, _)| other == chart);
                    let (_, tile_after, map_after) = found.expect("a chart does not vanish at one step");
                    // f32 resolves 16 km to 1 mm and rounds a few times on the way; the map is 405 km to one period, which
                    // f32 resolves to 2.4 cm, against texels of 790 m, of which the ground's finest pattern takes a 60th.
                    let (tile_m, map_m) =
                        (apart(*tile, *tile_after, density::TILE_M), apart(*map, *map_after, 1.0) * modulation::TILE_M);
                    let at = format!("{latitude_deg} {longitude_deg}, {distance_m} m, {step}");
                    assert!(tile_m < 0.01 * pixel_m, "{at}: tile moved {tile_m} m, a pixel is {pixel_m} m");
                    assert!(map_m < 0.06 * pixel_m, "{at}: map moved {map_m} m, a pixel is {pixel_m} m");
                }
            }
        }
    }
}

#[test]
fn detail_stands_on_the_ground_while_the_eye_flies() {
    // Cloud of one shape value at its edge, without a map, so that only detail varies.
    let shape = vec![128u8; density::WIDTH * density::WIDTH * density::HEIGHT];
    let bounds = vec![255u8; BOUNDS_WIDTH * BOUNDS_WIDTH];
    for (latitude_deg, longitude_deg) in [(47.0, 8.0), (-20.0, 100.0), (89.0, 40.0)] {
        let here = place(latitude_deg, longitude_deg, 1_500.0);
        let snapshot = cumulus_at(here);
        let first = eye_at(&snapshot, here);
        let mut moved = snapshot.clone();
        let flown = to_ecef(&here) + first.enu * DVec3::new(300.0, 400.0, 0.0);
        moved.ownship.position = from_ecef(flown);
        let plans = [plan_of(&snapshot), plan_of(&moved)];
        let eyes = [first, eye_at(&snapshot, from_ecef(flown))];
        let textures = Textures::unlit(&shape, &bounds);
        let (mut change, mut detail) = (0.0f32, 0.0f32);
        for k in 0..200 {
            let (x, y) = (f64::from(k % 20) * 61.0, f64::from(k / 20) * 53.0);
            let point = from_ecef(eyes[0].ground_ecef_m + eyes[0].enu * DVec3::new(x, y, 1_500.0));
            let found = |i: usize, range_m: f32| {
                let edge = Layer { theta: 0.5, patchiness: 0.0, ..plans[i].layers[0].layer };
                let earth_m = eyes[i].earth_m as f32;
                margin(&edge, &textures, earth_m, eyes[i].place(&point), 1_500.0, range_m)
            };
            change += (found(0, 1_000.0) - found(1, 1_000.0)).abs();
            // Beyond its range there is no detail: the difference is the detail.
            detail += (found(0, 1_000.0) - found(0, 100_000.0)).abs();
        }
        // The sphere that stands for the Earth has one radius in all directions, the ellipsoid two that differ by up to 0.7 %:
        // of 500 m flown that is 3.5 m at most, a sixth of a texel of 22 m.
        assert!(detail > 1.0, "{latitude_deg}: there is detail to compare: {detail}");
        assert!(change < 0.2 * detail, "{latitude_deg}: changed {change} of {detail}");
    }
}

#[test]
fn a_region_at_the_antipode_is_not_over_the_eye() {
    for offset_deg in [0.0, 1e-9, 1e-3, 1.0] {
        let mut snapshot = cumulus_at(place(47.0, 8.0, 1_500.0));
        snapshot.regions.push(region(-47.0 + offset_deg, -172.0, 2_000_000.0, 1_000.0));
        let plan = plan_of(&snapshot);
        assert!(plan.layers.iter().all(|l| l.layer.regions == 0), "{offset_deg}: {:?}", plan.notes);
    }
}

#[test]
fn inside_a_region_its_own_visibility_rules() {
    let mut snapshot = clear_day();
    let haze = |s: &Snapshot| plan_of(s).camera.haze_per_m;
    let outside = haze(&snapshot);
    let mut own = region(47.0, 8.0, 10_000.0, 1_000.0);
    own.weather.visibility_m = 500.0;
    snapshot.regions.push(own);
    // 3.0 / visibility, less the molecules' part (5 % contrast).
    assert!((haze(&snapshot) * 500.0 - 2.99).abs() < 0.02, "{}", haze(&snapshot));
    snapshot.regions[0].presence = 0.5;
    let half = haze(&snapshot);
    assert!(half > outside && half < 2.9 / 500.0, "{half}");
    snapshot.regions[0].shape.latitude_deg = 48.0;
    assert_eq!(haze(&snapshot), outside);
}

/// Passes by name, kept or left out.
type Passes = &'static [(&'static str, bool)];

#[test]
fn what_a_scene_does_not_need_is_left_out() {
    let noon = cumulus_at(place(47.0, 8.0, 1_500.0));
    let mut overcast_night = sun(noon.clone(), -40.0);
    overcast_night.weather.layers = vec![layer(CloudKind::Stratus, 400.0, 600.0)];
    overcast_night.weather.layers[0].coverage = 1.0;
    // The moon opposite the sun makes shadows.
    let mut moonless = overcast_night.clone();
    moonless.sky.moon_shines = false;
    let mut stormy = noon.clone();
    stormy.flashes.push(flash(place(47.05, 8.0, 3_000.0)));
    let mut dark_flash = noon.clone();
    dark_flash.flashes.push(flash(place(47.05, 8.0, 3_000.0)));
    dark_flash.flashes[0].intensity_cd = 0.0;
    let mut out_of_sight = noon.clone();
    out_of_sight.regions.push(region(-10.0, 100.0, 50_000.0, 1_000.0));
    let mut near = noon.clone();
    near.regions.push(region(47.2, 8.0, 20_000.0, 1_000.0));
    let mut no_cloud = noon.clone();
    no_cloud.weather.layers[0].coverage = 0.0;
    let mut two = noon.clone();
    two.weather.layers.push(layer(CloudKind::Cirrus, 8_000.0, 500.0));
    two.weather.layers[0].density = 0.0;

    // Flashes of these scenes have no channel: `plan/stroke/tests.rs` has those that have.
    let always = |night| {
        let ground = [("ground", true), ("hills", false), ("glow on the ground", night)];
        [ground.as_slice(), &[("stars", night), ("sky", true), ("tonemap", true), ("stroke", false)]].concat()
    };
    let mut looking_up = noon.clone();
    looking_up.ownship.attitude.pitch_rad = 60f64.to_radians();
    let cases: [(&str, Snapshot, Passes); 10] = [
        ("clear day", clear_day(), &[("flash", false), ("deck", false), ("shadow", false)]),
        ("overcast night", overcast_night, &[("flash", false), ("deck", true), ("shadow", true)]),
        ("moonless night", moonless, &[("flash", false), ("deck", true), ("shadow", false)]),
        ("flash", stormy, &[("flash", true), ("deck", true), ("shadow", true)]),
        ("a flash without light", dark_flash, &[("flash", false), ("deck", true), ("shadow", true)]),
        ("region out of sight", out_of_sight, &[("region", false), ("flash", false), ("deck", true), ("shadow", true)]),
        (
            "region in sight",
            near,
            &[("region", true), ("flash", false), ("deck", true), ("deck", true), ("shadow", true)],
        ),
        ("no cloud", no_cloud, &[("flash", false), ("deck", false), ("deck", false), ("shadow", false)]),
        ("one layer of two", two, &[("flash", false), ("deck", false), ("deck", true), ("shadow", true)]),
        ("no ground in sight", looking_up, &[("flash", false), ("deck", true), ("shadow", false)]),
    ];

    for (name, snapshot, expected) in cases {
        let plan = plan_of(&snapshot);
        let found: Vec<(&str, bool)> = plan.notes.iter().map(|note| (note.pass, note.kept)).collect();
        let form: Passes = if expected.contains(&("deck", true)) { &[("form", true)] } else { &[] };
        // Over land with cities, on the bare ellipsoid.
        let night = name.contains("night");
        let coast = plan.notes.iter().any(|note| note.pass == "shore" && note.kept);
        let relief = [
            ("shore", coast),
            ("relief", false),
            ("lamps", night),
            ("city glow", night),
            ("beams on the ground", false),
        ];
        let mut expected: Vec<(&str, bool)> =
            expected.iter().chain(&relief).chain(&always(night)).chain(form).copied().collect();
        // Shade of one layer on another is told before the shadows on the ground.
        let shaded = plan.layers.iter().any(|l| !l.shade.is_empty());
        assert!(!shaded || plan.layers.len() > 1, "{name}");
        // No flash of these scenes has a channel that could light a cloud from inside.
        expected.insert(expected.iter().position(|note| note.0 == "flash").unwrap_or(0), ("relight", false));
        expected.insert(expected.iter().position(|note| note.0 == "shadow").unwrap_or(0), ("shade", shaded));
        // Nor does the own ship shine in any: `plan/beams.rs` has those in which it does.
        expected.insert(expected.iter().position(|note| note.0 == "shadow").unwrap_or(0), ("beams", false));
        assert_eq!(found, expected, "{name}");
        assert_eq!(plan.relief.as_ref().is_some_and(|relief| relief.lights), night, "{name}");
        assert_eq!(plan.glow.is_some(), night, "{name}");
        assert_eq!(plan.stars.is_some(), night, "{name}");
        // What the notes say is what the executors get.
        let kept = |pass: &str| found.iter().filter(|note| **note == (pass, true)).count();
        assert_eq!(plan.layers.len(), kept("deck"), "{name}");
        let casters = plan.shadow.as_ref().map_or(0, |shadow| shadow.casters.len());
        assert_eq!(casters, kept("shadow") * kept("deck"), "{name}");
        assert!(plan.layers.iter().all(|l| l.layer.flashes as usize == kept("flash")), "{name}");
        assert!(plan.layers.iter().all(|l| (l.layer.regions > 0) == (kept("region") > 0)), "{name}");
        assert!(plan.notes.iter().all(|note| !note.why.is_empty()), "{name}");
    }
    let linear = plan(&noon, &noon.views[0], Output::LinearRgb);
    assert!(linear.notes.iter().any(|note| note.pass == "tonemap" && !note.kept));
}

#[test]
fn a_lopsided_frustum_and_a_mirror_bend_the_rays_as_told() {
    let mut snapshot = scenes::clear_day();
    let level = plan(&snapshot, &snapshot.views[0], Output::Srgb8).camera;
    let axis = glam::Vec3::from(level.forward);
    let [left_deg, right_deg, top_deg, bottom_deg] = [-10.0, 40.0, 5.0, -20.0];
    snapshot.views[0].frustum = Some(crate::world::command::Frustum { left_deg, right_deg, top_deg, bottom_deg });
    let camera = plan(&snapshot, &snapshot.views[0], Output::Srgb8).camera;
    let [width, height] = [camera.width_px, camera.height_px];
    // The axis of the view lies where the tangents say: 10 degrees from the left side and 5 below the upper one.
    let share = |low: f64, high: f64| {
        let [low, high] = [low, high].map(|side: f64| side.to_radians().tan());
        (-low / (high - low)) as f32
    };
    let on_axis = camera.ray(share(left_deg, right_deg) * width, (1.0 - share(bottom_deg, top_deg)) * height);
    // Directions are f32: 1e-7, a few times over.
    assert!((on_axis - axis).length() < 1e-6, "{on_axis} {axis}");
    let at_left = camera.ray(0.0, (1.0 - share(bottom_deg, top_deg)) * height);
    assert!((at_left.dot(axis).acos().to_degrees() - 10.0).abs() < 1e-3);
    snapshot.views[0].mirror = [true, false];
    let mirrored = plan(&snapshot, &snapshot.views[0], Output::Srgb8).camera;
    assert!((mirrored.ray(3.0, 2.0) - camera.ray(width - 3.0, 2.0)).length() < 1e-6);
    snapshot.views[0].mirror = [false, true];
    let mirrored = plan(&snapshot, &snapshot.views[0], Output::Srgb8).camera;
    assert!((mirrored.ray(3.0, 2.0) - camera.ray(3.0, height - 2.0)).length() < 1e-6);
}

#[test]
fn a_view_is_where_its_carrier_is_and_lights_can_be_put_out() {
    let mut snapshot = scenes::clear_day();
    let elsewhere = crate::geo::Geodetic { altitude_m: 5_000.0, ..snapshot.ownship.position };
    let carrier = crate::world::snapshot::OwnshipState { position: elsewhere, ..snapshot.ownship };
    snapshot.views[0].carrier = Some(carrier);
    let carried = plan(&snapshot, &snapshot.views[0], Output::Srgb8);
    assert!((carried.camera.eye_m - 5_000.0).abs() < 1.0);
    assert!(carried.sky.sun_luminance[1] > 0.0);
    snapshot.sky.sun_shines = false;
    let dark = plan(&snapshot, &snapshot.views[0], Output::Srgb8);
    assert_eq!(dark.sky.sun_luminance, [0.0; 3]);
}

#[test]
fn an_eye_in_the_ground_is_lifted_and_told() {
    let note = |altitude_m| {
        let plan = plan_of(&cumulus_at(place(47.0, 8.0, altitude_m)));
        (plan.camera.eye_m, plan.notes.into_iter().find(|note| note.pass == "eye").map(|note| note.why))
    };
    assert_eq!(note(1.6).1, None);
    let (eye_m, why) = note(-1_000.0);
    // f32 holds the height of the eye, the ellipsoid is met in f64 to a nanometre.
    assert!(
        (eye_m - 1.5).abs() < 1e-6 && why.as_deref().is_some_and(|why| why.contains("1001.5 m too low")),
        "{why:?}"
    );
}

#[test]
fn a_flash_that_leaves_the_brightest_gives_no_light_at_the_cut() {
    let far = |k: usize| flash(place(47.3 + 0.01 * k as f64, 8.0, 3_000.0));
    let mut snapshot = clear_day();
    snapshot.flashes = (0..FLASHES).map(far).collect();
    let drawn = |s: &Snapshot| plan_of(s).ground.unwrap().flash.map(|f| f.intensity);
    let all = drawn(&snapshot);
    assert!(all.iter().all(|i| *i == all[0]), "as many as there may be are drawn as they are");
    // One more, as strong at the eye as the weakest: of both nothing is left, so that it does not matter which is drawn.
    snapshot.flashes.push(snapshot.flashes[FLASHES - 1].clone());
    let more = drawn(&snapshot);
    assert_eq!(more[FLASHES - 1], 0.0);
    assert!(more[0] > 0.5 * all[0], "{} of {}", more[0], all[0]);
    assert!(more.windows(2).all(|pair| pair[0] >= pair[1]), "brightest first");
    // And continuously: a flash without light takes nothing away.
    snapshot.flashes[FLASHES].intensity_cd = 1e-3;
    let none = drawn(&snapshot);
    assert!(none.iter().zip(&all).all(|(a, b)| (a / b - 1.0).abs() < 1e-6));
}

#[test]
fn pictures_of_every_size_that_is_taken_have_a_plan() {
    for (size_px, field_of_view_deg) in
        [([16, 16], 170.0), ([16, 8_192], 170.0), ([8_192, 16], 1.0), ([8_192, 4_096], 60.0), ([8_192, 8_192], 170.0)]
    {
        let mut snapshot = cumulus_at(place(47.0, 8.0, 1_500.0));
        (snapshot.views[0].size_px, snapshot.views[0].field_of_view_deg) = (size_px, field_of_view_deg);
        let plan = plan_of(&snapshot);
        assert_eq!(plan.size_px, size_px);
        finite(&format!("{size_px:?}"), &plan.camera);
        let [width, height] = size_px.map(|n| n as f32);
        for (x, y) in [(0.5, 0.5), (width - 0.5, height - 0.5), (0.5 * width, 0.5 * height)] {
            let ray = plan.camera.ray(x, y);
            // A direction of f32 has a length of 1 to a few units in the last place.
            assert!((ray.length() - 1.0).abs() < 1e-6, "{size_px:?} at {x} {y}: {ray}");
        }
        assert_eq!(plan.layers.len(), 1);
    }
}

#[test]
fn ten_years_of_wind_carry_the_cloud_and_no_wind_does_not() {
    let charts = |weather| {
        let mut snapshot = cumulus_at(place(47.0, 8.0, 1_500.0));
        snapshot.weather = weather;
        plan_of(&snapshot).layers[0].layer.chart.map(|chart| chart.tile_origin_m)
    };
    let still = charts(scenes::blown_for_ten_years(0.0));
    assert_eq!(still, charts(cumulus_at(place(47.0, 8.0, 1_500.0)).weather), "a calm of ten years moves nothing");
    assert_ne!(still, charts(scenes::blown_for_ten_years(150.0)));
    assert_eq!(charts(scenes::blown_for_ten_years(150.0)), charts(scenes::blown_for_ten_years(150.0)));
}
