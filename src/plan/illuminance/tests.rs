//! The light of a moment against what is measured; nothing steps, whatever moves; under a region its own weather rules.

use super::*;
use crate::clouds::CloudKind;
use crate::geo::frames::enu;
use crate::geo::wgs84::{from_ecef, to_ecef};
use crate::plan::scenes::{clear_day, layer, place, region, sun};
use crate::plan::{Output, plan};
use crate::world::snapshot::LayerState;
use glam::DVec3;

pub fn light(snapshot: &Snapshot) -> Illuminance {
    let eye = Eye::new(&snapshot.ownship, &snapshot.views[0], &snapshot.terrain);
    let regions = crate::plan::regions::near(snapshot, &eye, &mut Vec::new());
    Illuminance::new(snapshot, &eye, &snapshot.views[0], &regions)
}

/// Illuminance of the level ground, lux.
fn ground_lux(snapshot: &Snapshot) -> f64 {
    let light = light(snapshot);
    f64::from(light.ground.horizontal_lux(light.source.z).y)
}

fn ev(snapshot: &Snapshot) -> f32 {
    -light(snapshot).exposure.log2()
}

/// A moonless (new moon) moment with the sun at an elevation, the eye at the ground.
fn sunlit(elevation_deg: f64) -> Snapshot {
    let mut snapshot = clear_day();
    snapshot.ownship.position = place(47.0, 8.0, 2.0);
    snapshot = sun(snapshot, elevation_deg);
    snapshot.sky.moon_direction_ecef = snapshot.sky.sun_direction_ecef;
    snapshot.sky.moon_lit_fraction = 0.0;
    snapshot
}

/// The full moon at an elevation, the sun at -40 degrees.
fn moonlit(elevation_deg: f64) -> Snapshot {
    let moon = sun(sunlit(0.0), elevation_deg).sky.sun_direction_ecef;
    let mut snapshot = sunlit(-40.0);
    snapshot.sky.moon_direction_ecef = moon;
    snapshot.sky.moon_lit_fraction = 1.0;
    snapshot
}

fn overcast(kind: CloudKind, base_m: f64, thickness_m: f64) -> Vec<LayerState> {
    vec![LayerState { coverage: 1.0, ..layer(kind, base_m, thickness_m) }]
}

#[test]
fn a_low_sun_is_redder_at_a_towers_base_than_at_its_top_and_a_high_one_is_not() {
    let light_of = |elevation_deg: f64| light(&sun(clear_day(), elevation_deg));
    let [low, high] = [2.0, 60.0].map(light_of).map(|light| light.lower(1_000.0, 12_000.0));
    assert!(low.x > 2.0 * low.z && low.x < 0.8, "{low}");
    // By Beer's law over what of the molecules lies between, 1.0 - 0.27 of their columns at 60 degrees: blue light.
    let molecules = (-33.1e-6f32 * 8_000.0 * ((-0.125f32).exp() - (-1.5f32).exp()) / 60f32.to_radians().sin()).exp();
    assert!(high.z < molecules && high.z > 0.8 * molecules, "{high} {molecules}");
    assert_eq!(light_of(20.0).lower(3_000.0, 3_000.0), Vec3::ONE);
}

#[test]
fn the_ground_is_as_bright_as_it_is_outside() {
    // Within a factor of two: the figures are round and hold for no air and no cloud in particular.
    let within = |name: &str, lux: f64, [low, high]: [f64; 2]| {
        assert!(lux > low / 2.0 && lux < high * 2.0, "{name}: {lux} lx, outside it has {low} to {high}");
    };
    within("clear noon", ground_lux(&sunlit(60.0)), [1e5, 1e5]);
    for (kind, base_m, thickness_m) in [
        (CloudKind::Stratus, 300.0, 600.0),
        (CloudKind::Stratocumulus, 800.0, 800.0),
        (CloudKind::Nimbostratus, 800.0, 3_000.0),
    ] {
        let mut noon = sunlit(55.0);
        noon.weather.layers = overcast(kind, base_m, thickness_m);
        within(&format!("noon under {kind:?}"), ground_lux(&noon), [1e4, 2e4]);
    }
    // The upper limb at the horizon: the sun's centre half a disc and the refraction below it.
    within("sunset", ground_lux(&sunlit(-0.83)), [400.0, 400.0]);
    within("end of civil twilight", ground_lux(&sunlit(-6.0)), [3.0, 3.0]);
    within("full moon", ground_lux(&moonlit(50.0)), [0.1, 0.3]);
    within("moonless night", ground_lux(&sunlit(-40.0)), [6e-4, 2e-3]);
}

/// Illuminance of the ground by a clear sky, lux: Seidelmann (ed.) 1992, "Explanatory Supplement to the Astronomical
/// Almanac", section 9.34, polynomials for the logarithm, within 5 % of the tables they stand for.
fn seidelmann_lux(elevation_deg: f64) -> f64 {
    let [a, b, c, d] = match elevation_deg {
        e if e >= 20.0 => [3.74, 3.97, -4.07, 1.47],
        e if e >= 5.0 => [3.05, 13.28, -45.98, 64.33],
        e if e >= -0.8 => [2.88, 22.26, -207.64, 1_034.30],
        e if e >= -5.0 => [2.88, 21.81, -258.11, -858.36],
        e if e >= -12.0 => [2.70, 12.17, -431.69, -1_899.83],
        _ => [13.84, 262.72, 1_447.42, 2_797.93],
    };
    let x = elevation_deg / 90.0;
    10f64.powf(a + x * (b + x * (c + x * d)))
}

#[test]
fn day_turns_to_night_along_the_published_curve() {
    // Known points of the curve, so that a slip in a coefficient shows.
    assert!((seidelmann_lux(-6.0) - 3.4).abs() < 0.1 && (seidelmann_lux(-12.0) - 0.008).abs() < 0.0005);
    for elevation_deg in -17..=90 {
        let (ours, published) = (ground_lux(&sunlit(elevation_deg.into())), seidelmann_lux(elevation_deg.into()));
        // Higher orders of scattering are taken to come alike from all sides, and there is no refraction (0.6 degrees at the
        // horizon, where a degree is a factor of two): together up to 45 %. Airglow adds to the sun's light in deep twilight.
        assert!((0.66..1.5).contains(&(ours / published)), "{elevation_deg} degrees: {ours} lx, published {published}");
    }
}

#[test]
fn no_elevation_of_sun_or_moon_makes_a_step() {
    let full_and_opposite = |elevation_deg: f64| {
        let mut snapshot = sunlit(elevation_deg);
        snapshot.sky.moon_direction_ecef = -snapshot.sky.sun_direction_ecef;
        snapshot.sky.moon_lit_fraction = 1.0;
        snapshot
    };
    let clouded = |elevation_deg: f64| {
        let mut snapshot = sunlit(elevation_deg);
        snapshot.weather.layers = overcast(CloudKind::Stratocumulus, 600.0, 800.0);
        snapshot
    };
    let scenes: [(&str, &dyn Fn(f64) -> Snapshot); 4] =
        [("sun", &sunlit), ("moon", &moonlit), ("sun and full moon", &full_and_opposite), ("overcast", &clouded)];
    for (name, scene) in scenes {
        let lux: Vec<f64> = (-90..=90).map(|e| ground_lux(&scene(e.into()))).collect();
        for (i, pair) in lux.windows(2).enumerate() {
            // The published curve is steepest at -8 degrees, where it rises 3.1 times in one; ours rises 3.5 times.
            let ratio = pair[1] / pair[0];
            assert!(
                (0.25..4.0).contains(&ratio),
                "{name} from {} degrees: {} to {} lx",
                i as i32 - 90,
                pair[0],
                pair[1]
            );
        }
        // And finely, where something begins or ends: 3.5 times a degree is 1.065 in a twentieth.
        for centre in [-21.1, -18.0, -2.9, -1.7, -0.6, 0.0, 1.1, 21.1] {
            let lux: Vec<f64> = (-10..=10).map(|k| ground_lux(&scene(centre + 0.05 * f64::from(k)))).collect();
            for pair in lux.windows(2) {
                assert!((0.93..1.075).contains(&(pair[1] / pair[0])), "{name} about {centre}: {} {}", pair[0], pair[1]);
            }
        }
    }
    // Sun and moon in one place, as in an eclipse: the light is the sun's.
    let mut eclipse = sunlit(40.0);
    eclipse.sky.moon_lit_fraction = 1.0;
    assert_eq!(ground_lux(&eclipse), ground_lux(&sunlit(40.0)));
}

#[test]
fn a_black_target_at_the_visibility_has_a_contrast_of_five_per_cent() {
    let seen = |visibility_m: f64, range_m: f64| {
        let mut snapshot = sunlit(40.0);
        snapshot.weather.visibility_m = visibility_m;
        let plan = plan(&snapshot, &snapshot.views[0], Output::LinearRgb);
        // Air between adds what it adds to the sky behind: of a black target's contrast the share is left that passes.
        f64::from(plan.camera.air_transmittance(plan.camera.eye_m, range_m as f32))
    };
    for visibility_m in [50.0, 300.0, 4_000.0, 40_000.0, 200_000.0] {
        let contrast = seen(visibility_m, visibility_m);
        // The eye is 2 m up, where there is 0.2 % less haze than at sea level: 0.5 % of the contrast.
        assert!((contrast / 0.05 - 1.0).abs() < 0.01, "{visibility_m}: {contrast}");
    }
    // Beyond 250 km air by itself takes more: no haze is left to take away.
    let contrast = seen(300_000.0, 247_000.0);
    assert!((0.04..0.06).contains(&contrast), "{contrast}");
}

#[test]
fn poles_at_the_solstices_and_the_thickest_and_clearest_air_have_light() {
    for (latitude_deg, utc_s, lux) in [
        // The sun 23.4 degrees high all day, and as far below the horizon.
        (90.0, 1_782_010_000.0, 2e4..6e4),
        (-90.0, 1_782_010_000.0, 1e-4..0.5),
        (90.0, 1_797_885_000.0, 1e-4..0.5),
        (-90.0, 1_797_885_000.0, 2e4..6e4),
    ] {
        for hour in 0..24 {
            let mut snapshot = clear_day();
            snapshot.ownship.position = place(latitude_deg, 0.0, 2.0);
            let sky = crate::geo::celestial::sun_and_moon(utc_s + 3_600.0 * f64::from(hour));
            snapshot.sky.sun_direction_ecef = sky.sun_m.normalize();
            snapshot.sky.moon_direction_ecef = sky.moon_m.normalize();
            snapshot.sky.moon_lit_fraction = sky.moon_lit_fraction;
            let found = ground_lux(&snapshot);
            assert!(lux.contains(&found), "{latitude_deg}, hour {hour}: {found}");
        }
    }
    for (visibility_m, elevation_deg) in
        [(50.0, 60.0), (50.0, 0.0), (300_000.0, 60.0), (300_000.0, 0.0), (300_000.0, -6.0)]
    {
        let mut snapshot = sunlit(elevation_deg);
        snapshot.weather.visibility_m = visibility_m;
        // Fog of 1.2 km height and a depth of 70 lets through about a thirteenth as a diffuse slab does, less of grazing light.
        let share = ground_lux(&snapshot) / ground_lux(&sunlit(elevation_deg));
        assert!((0.004..1.5).contains(&share), "{visibility_m} m, {elevation_deg} degrees: {share}");
    }
}

#[test]
fn under_a_region_its_weather_rules_as_if_it_were_everywhere() {
    let two = || {
        let mut layers = vec![layer(CloudKind::Cumulus, 900.0, 800.0)];
        layers.extend(overcast(CloudKind::Altostratus, 4_000.0, 2_000.0));
        layers
    };
    for altitude_m in [10.0, 1_200.0, 5_000.0, 9_000.0] {
        let mut everywhere = sunlit(35.0);
        everywhere.ownship.position.altitude_m = altitude_m;
        let mut local = everywhere.clone();
        everywhere.weather.layers = two();
        local.weather.layers = vec![layer(CloudKind::Cirrus, 9_500.0, 500.0)];
        let mut own = region(47.0, 8.0, 60_000.0, 1_000.0);
        own.weather.layers = two();
        local.regions.push(own);
        let [a, b] = [&everywhere, &local].map(|s| plan(s, &s.views[0], Output::Srgb8));
        let (ga, gb) = (a.ground.unwrap(), b.ground.unwrap());
        assert_eq!((ga.light_lux, ga.sky_lux), (gb.light_lux, gb.sky_lux), "{altitude_m}");
        assert_eq!(a.camera.exposure, b.camera.exposure, "{altitude_m}");
        let own: Vec<_> = b.layers.iter().filter(|l| l.layer.region == 1).collect();
        assert_eq!(own.len(), 2);
        for (a, b) in a.layers.iter().zip(own) {
            let light = |l: &crate::passes::deck::Layer| (l.light_lux, l.sky_lux, l.ground_lux);
            assert_eq!(light(&a.layer), light(&b.layer), "{altitude_m}: {:?}", a.kind);
        }
    }
    // An altostratus above dims the cumulus below, which it would not from outside the region.
    let mut local = sunlit(35.0);
    let mut own = region(47.0, 8.0, 60_000.0, 1_000.0);
    own.weather.layers = two();
    local.regions.push(own);
    let direct = |snapshot: &Snapshot| plan(snapshot, &snapshot.views[0], Output::Srgb8).layers[0].layer.light_lux[1];
    let below = direct(&local);
    local.regions[0].weather.layers.truncate(1);
    assert!(below < 0.1 * direct(&local), "{below} {}", direct(&local));
}

/// The same snapshot from a place some metres east, north and up.
fn moved(snapshot: &Snapshot, metres: DVec3) -> Snapshot {
    let mut moved = snapshot.clone();
    let here = snapshot.ownship.position;
    moved.ownship.position = from_ecef(to_ecef(&here) + enu(&here) * metres);
    moved
}

#[test]
fn light_and_exposure_ease_over_a_regions_edge_and_through_a_layer() {
    let mut storm = sunlit(35.0);
    storm.ownship.position.altitude_m = 300.0;
    let mut own = region(47.0, 8.0, 10_000.0, 4_000.0);
    own.weather.layers = overcast(CloudKind::Cumulonimbus, 800.0, 9_000.0);
    storm.regions.push(own);
    let along: Vec<Snapshot> = (0..240).map(|k| moved(&storm, DVec3::new(50.0 * f64::from(k), 0.0, 0.0))).collect();
    let evs: Vec<f32> = along.iter().map(ev).collect();
    let lux: Vec<f64> = along.iter().map(ground_lux).collect();
    let largest = |v: &[f32]| v.windows(2).map(|p| (p[1] - p[0]).abs()).fold(0.0, f32::max);
    assert!(evs[239] - evs[0] > 2.0, "outside it is brighter: {} to {}", evs[0], evs[239]);
    // 4 EV and more over 80 steps of a smoothstep, logarithms steepest where it is dark.
    assert!(largest(&evs) < 0.35, "{}", largest(&evs));
    assert!(lux.windows(2).all(|p| p[1] >= 0.99 * p[0]), "outwards it grows lighter all the way");

    let mut climb = sunlit(35.0);
    climb.weather.layers = overcast(CloudKind::Stratus, 500.0, 300.0);
    let evs: Vec<f32> = (0..300).map(|k| ev(&moved(&climb, DVec3::new(0.0, 0.0, 4.0 * f64::from(k))))).collect();
    assert!(evs[299] - evs[0] > 0.4 && largest(&evs) < 0.06, "{} {}", evs[299] - evs[0], largest(&evs));

    let mut fading = storm.clone();
    let presence: Vec<f32> = (0..=100)
        .map(|k| {
            fading.regions[0].presence = f64::from(k) / 100.0;
            ev(&fading)
        })
        .collect();
    assert!(presence[0] > presence[100] + 2.0 && largest(&presence) < 0.5, "{}", largest(&presence));
}

#[test]
fn the_mean_of_two_weathers_rules_where_two_regions_overlap() {
    let mut both = sunlit(35.0);
    let mut alone = [both.clone(), both.clone()];
    for (i, kind) in [CloudKind::Stratus, CloudKind::Altostratus].into_iter().enumerate() {
        let mut own = region(47.0, 8.0, 60_000.0, 1_000.0);
        own.weather.layers = overcast(kind, 1_000.0, 500.0);
        both.regions.push(own.clone());
        alone[i].regions.push(own);
    }
    let [a, b] = alone.map(|s| ground_lux(&s));
    // Sums in f32.
    assert!((ground_lux(&both) / (0.5 * (a + b)) - 1.0).abs() < 1e-5);
}

/// The light on a cumulus layer of a snapshot: lux per colour, and towards the light.
fn on_cumulus(snapshot: &Snapshot) -> ([f32; 3], [f32; 3]) {
    let mut clouded = snapshot.clone();
    clouded.weather.layers = vec![layer(CloudKind::Cumulus, 1_500.0, 1_000.0)];
    let plan = plan(&clouded, &clouded.views[0], Output::LinearRgb);
    (plan.layers[0].layer.light_lux, plan.layers[0].layer.light_direction)
}

#[test]
fn the_full_moon_lights_clouds_from_where_it_stands() {
    let full = moonlit(50.0);
    let (lux, towards) = on_cumulus(&full);
    let sine = 50f32.to_radians().sin();
    assert!((towards[2] - sine).abs() < 1e-3, "{towards:?}");
    // A full moon at the zenith outside the air gives 0.32 lx at most; the ground has 0.1 to 0.3 lx of it.
    assert!((0.1..0.35).contains(&lux[1]), "{lux:?}");
    let mut put_out = full.clone();
    put_out.sky.moon_shines = false;
    assert!(on_cumulus(&put_out).0[1] < 1e-3 * lux[1]);
    let mut half = full;
    half.sky.moon_lit_fraction = 0.5;
    let share = on_cumulus(&half).0[1] / lux[1];
    // Half of the disc gives 2.5 magnitudes less, a tenth of the light (Allen 1973).
    assert!((0.07..0.12).contains(&share), "{share}");
}

#[test]
fn a_white_layer_below_lights_the_one_above() {
    let from_below = |lower: Vec<LayerState>| {
        let mut noon = sunlit(55.0);
        noon.weather.layers = lower;
        noon.weather.layers.push(layer(CloudKind::Altocumulus, 4_500.0, 400.0));
        let plan = plan(&noon, &noon.views[0], Output::LinearRgb);
        plan.layers.last().map_or(0.0, |l| l.layer.ground_lux[1]) * 4.0 * std::f32::consts::PI
    };
    // Over open ground of albedo 0.13 under about 90 klx; over a sheet that sends back about two thirds of it.
    let (ground, sheet) = (from_below(Vec::new()), from_below(overcast(CloudKind::Stratocumulus, 800.0, 800.0)));
    assert!((8e3..1.4e4).contains(&ground) && (4e4..8e4).contains(&sheet), "{ground} {sheet}");
}

#[test]
fn a_low_sun_lights_clouds_red_and_high_ones_longest() {
    let red = |elevation_deg: f64| {
        let (lux, _) = on_cumulus(&sunlit(elevation_deg));
        lux[0] / lux[2]
    };
    let along: Vec<f32> = [60.0, 30.0, 10.0, 5.0, 2.0, 0.5].map(red).to_vec();
    assert!(along.windows(2).all(|w| w[1] > w[0]) && along[0] < 1.5 && along[5] > 3.0, "{along:?}");
    // Just after sunset at the ground, a cirrus 10 km up still has the sun.
    let mut dusk = sunlit(-1.5);
    dusk.weather.layers = vec![layer(CloudKind::Cirrus, 10_000.0, 500.0)];
    let high = plan(&dusk, &dusk.views[0], Output::LinearRgb).layers[0].layer.light_lux;
    let low = on_cumulus(&sunlit(-1.5)).0;
    assert!(high[0] > 5.0 * low[0].max(1.0), "{high:?} {low:?}");
}

/// The ground's parameters of a plan.
fn ground_of(snapshot: &Snapshot) -> crate::passes::ground::Ground {
    plan(snapshot, &snapshot.views[0], Output::LinearRgb).ground.expect("ground is in sight")
}

#[test]
fn ground_above_a_closed_sheet_is_lit_as_without_it() {
    let mut snapshot = sunlit(40.0);
    snapshot.terrain = crate::geo::terrain::Terrain::procedural();
    snapshot.ownship.position = place(46.5, 8.0, 4_500.0);
    let clear = ground_of(&snapshot);
    snapshot.weather.layers = overcast(CloudKind::Stratus, 1_000.0, 500.0);
    let sheet = ground_of(&snapshot);
    assert_eq!((sheet.sheet_base_m, sheet.sheet_top_m), (1_000.0, 1_500.0));
    let sum = |light: [f32; 3], sky: [f32; 3]| light[1] * sheet.light_direction[2] + sky[1];
    let (above, without) = (sum(sheet.above_light_lux, sheet.above_sky_lux), sum(clear.light_lux, clear.sky_lux));
    // At 1,500 m there is less haze in the way: 10 % more from the sun, and some less from the sky.
    assert!((above / without - 1.0).abs() < 0.15, "{above} {without}");
    // As it was, by what comes through the sheet as diffuse light on top of an unshaded sun.
    let old = sum(sheet.light_lux, sheet.sky_lux);
    assert!(old > 1.15 * without, "{old} {without}");
    // Higher clouds shade ground above the sheet once: the shadows are looked up, so the light between them is whole.
    let veil = layer(CloudKind::Altostratus, 8_000.0, 1_000.0);
    snapshot.weather.layers.push(LayerState { coverage: 0.5, ..veil });
    let veiled = ground_of(&snapshot);
    assert!(
        veiled.above_light_lux[1] > 0.99 * clear.light_lux[1],
        "{:?} {:?}",
        veiled.above_light_lux,
        clear.light_lux
    );
    // A layer that eases in between steps nothing.
    let mut last = veiled;
    for percent in 0..=30 {
        let between = layer(CloudKind::Stratocumulus, 3_000.0, 1_000.0);
        let mut easing = snapshot.clone();
        easing.weather.layers.insert(1, LayerState { coverage: f64::from(percent) / 100.0, ..between });
        let now = ground_of(&easing);
        assert!(
            now.sheet_base_m == 1_000.0 && (now.sheet_top_m - last.sheet_top_m).abs() < 0.12 * 2_500.0,
            "{percent} %"
        );
        last = now;
    }
    assert_eq!(last.sheet_top_m, 4_000.0);
    // A veil of cirrus above all mountains is no sheet, nor is anything over level ground.
    snapshot.weather.layers = overcast(CloudKind::Cirrostratus, 8_000.0, 500.0);
    assert!(ground_of(&snapshot).sheet_top_m > 1e5);
    snapshot.weather.layers = overcast(CloudKind::Stratus, 1_000.0, 500.0);
    snapshot.terrain = crate::geo::terrain::Terrain::ELLIPSOID;
    assert!(ground_of(&snapshot).sheet_top_m > 1e5);
}

#[test]
fn an_overcast_over_a_city_lights_the_ground_by_some_tenths_of_a_lux() {
    let mut snapshot = sunlit(-40.0);
    snapshot.ownship.position = place(48.857, 2.352, 300.0);
    let lux = |snapshot: &Snapshot| ground_of(snapshot).glow_lux;
    assert_eq!(lux(&snapshot), 0.0, "no cloud sends anything down");
    snapshot.weather.layers = overcast(CloudKind::Stratocumulus, 800.0, 500.0);
    let night = lux(&snapshot);
    // Kyba et al. 2011 (PLoS ONE 6, e17307) found Berlin's overcast sky ten times as bright as its clear one, which makes about 0.1
    // lx in the city; lamps of 525 cd m2 upwards a m2 of core cannot give more than pi times 0.167 lx.
    assert!((0.1..0.6).contains(&night), "{night}");
    // More under a thicker deck, less under a broken one, nothing by day or at sea.
    let with = |change: &dyn Fn(&mut Snapshot)| {
        let mut changed = snapshot.clone();
        change(&mut changed);
        lux(&changed)
    };
    assert!(with(&|s| s.weather.layers[0].thickness_m = 1_500.0) > night);
    assert!(with(&|s| s.weather.layers[0].coverage = 0.4) < 0.6 * night);
    assert_eq!(with(&|s| *s = sun(s.clone(), 30.0)), 0.0);
    assert_eq!(with(&|s| s.ownship.position = place(45.0, -30.0, 300.0)), 0.0);
    // A higher base is read from a coarser level.
    let level = |base_m: f64| {
        let mut changed = snapshot.clone();
        changed.weather.layers[0].base_m = base_m;
        ground_of(&changed).glow_level
    };
    assert!((level(1_600.0) - level(800.0) - 1.0).abs() < 1e-3);
}

#[test]
fn hills_shade_each_other_only_where_a_low_light_meets_heights() {
    let at = |terrain: crate::geo::terrain::Terrain, sun_deg: f64| {
        let mut snapshot = sunlit(sun_deg);
        snapshot.terrain = terrain;
        snapshot.ownship.position = place(46.5, 8.0, 4_500.0);
        ground_of(&snapshot).hills
    };
    use crate::geo::terrain::Terrain;
    assert_eq!([5.0, 30.0, 60.0, -40.0].map(|sun_deg| at(Terrain::procedural(), sun_deg)), [1, 1, 0, 0]);
    assert_eq!(at(Terrain::ELLIPSOID, 5.0), 0);
}
