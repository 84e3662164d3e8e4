//! Shadows against closed forms, geometry, and an integration of the deck's own field along the light.

use super::table::{LEVELS, TEXEL_M, THETAS, Table, build, sample, theta};
use super::twin::Caster;
use super::*;
use crate::clouds::coverage::Coverage;
use crate::clouds::density::{DensityVolume, HEIGHT, TILE_M, WIDTH};
use crate::clouds::{CloudKind, detail, modulation, warp};
use crate::passes::common::Chart;
use crate::passes::deck::Layer;
use crate::passes::deck::field::{BOUNDS_WIDTH, Textures};
use bytemuck::Zeroable;
use glam::{Vec2, Vec3};

const EARTH_M: f32 = 6_371_000.0;
const BASE_M: f32 = 1_000.0;

/// Towards the light; azimuth clockwise from north.
fn towards(elevation_deg: f32, azimuth_deg: f32) -> Vec3 {
    let (elevation, azimuth) = (elevation_deg.to_radians(), azimuth_deg.to_radians());
    Vec3::new(azimuth.sin() * elevation.cos(), azimuth.cos() * elevation.cos(), elevation.sin())
}

/// The columns of a genus at its usual thickness.
fn columns(kind: CloudKind, light: Vec3) -> Columns {
    let look = kind.appearance();
    Columns {
        direction: light.into(),
        begin: 0.0,
        thickness_m: look.usual_thickness_m,
        extinction_per_m: look.extinction_per_m,
        edge: look.edge,
        pieces: 2,
        bounded: false,
    }
}

/// A layer over the ground, its chart without distortion.
fn layer(columns: &Columns, theta: f32, patchiness: f32) -> Layer {
    let mut layer = Layer::zeroed();
    layer.base_m = BASE_M;
    layer.thickness_m = columns.thickness_m;
    layer.light_direction = columns.direction;
    layer.extinction_per_m = columns.extinction_per_m;
    layer.inverse_edge = 1.0 / columns.edge;
    (layer.theta, layer.patchiness) = (theta, patchiness);
    layer.charts = 1;
    layer.chart = [Chart { tile_origin_m: [3_000.0, 11_000.0], map_origin: [0.31, 0.77], ..Chart::UNUSED }; 3];
    layer
}

fn caster<'a>(layer: &'a Layer, columns: &Columns, table: &'a Table) -> Caster<'a> {
    let shadow = columns.shadow(layer.base_m, layer.thickness_m);
    Caster { layer, shadow, tables: vec![table], map: modulation::map() }
}

/// A point of the ground.
fn ground(x: f32, y: f32) -> Vec3 {
    Vec3::new(x, y, -(x * x + y * y) / (2.0 * EARTH_M))
}

#[test]
fn a_uniform_slab_dims_the_light_exponentially() {
    let shape = vec![255u8; WIDTH * WIDTH * HEIGHT];
    for (elevation_deg, extinction_per_m) in [(90.0, 0.002), (50.0, 0.002), (30.0, 0.0005), (10.0, 0.0004)] {
        let light = towards(elevation_deg, 130.0);
        let columns = Columns { extinction_per_m, ..columns(CloudKind::Cumulus, light) };
        let table = build(&columns, &shape);
        // Whole everywhere: the shape value is 1, theta and edge together less.
        let layer = layer(&columns, 0.2, 0.0);
        let found = caster(&layer, &columns, &table).through(EARTH_M, ground(0.0, 0.0), 0.0);
        let expected = (-extinction_per_m * columns.thickness_m / light.z).exp();
        // Bytes hold a share to half of 1/255.
        assert!((found - expected).abs() < 0.002, "{elevation_deg} degrees: {found}, {expected}");
        // Twice as deep with the ground in the middle of it: half of the path is left.
        let half = Columns { begin: 0.5, ..columns };
        let found = sample(&build(&half, &shape), 0.3, 0.3, 0, 0.0)[0];
        assert!((found - expected.sqrt()).abs() < 0.002, "from half-way: {found}, {}", expected.sqrt());
    }
}

#[test]
fn no_cloud_casts_no_shadow_and_a_turned_away_ground_has_none() {
    let light = towards(40.0, 200.0);
    let columns = columns(CloudKind::Cumulus, light);
    let table = build(&columns, &DensityVolume::of(CloudKind::Cumulus).shape);
    for theta in [1.0, 1.5] {
        let layer = layer(&columns, theta, 0.0);
        for k in 0..50 {
            let p = ground(k as f32 * 731.0, k as f32 * 377.0);
            assert_eq!(caster(&layer, &columns, &table).through(EARTH_M, p, 0.0), 1.0, "theta {theta}");
        }
    }
    // Beyond the terminator.
    let down = Layer { light_direction: towards(-1.0, 0.0).into(), ..layer(&columns, 0.0, 0.0) };
    assert_eq!(caster(&down, &columns, &table).through(EARTH_M, ground(0.0, 0.0), 0.0), 1.0);
}

/// A ball of cloud in the middle of the tile's base half.
fn ball() -> (Vec<u8>, Vec2, f32) {
    let centre = [128.0, 100.0, 8.0];
    let shape = (0..WIDTH * WIDTH * HEIGHT).map(|i| {
        let at = [i % WIDTH, (i / WIDTH) % WIDTH, i / (WIDTH * WIDTH)].map(|v| v as f32 + 0.5);
        // Five texels wide and as tall in metres, at a voxel height of 37.5 m.
        let d = Vec3::new(at[0] - centre[0], at[1] - centre[1], (at[2] - centre[2]) * 0.6);
        if d.length() < 4.0 { 255 } else { 0 }
    });
    (shape.collect(), Vec2::new(centre[0], centre[1]) * TEXEL_M, centre[2] / HEIGHT as f32)
}

#[test]
fn the_shadow_lies_away_from_the_sun_by_height_over_tangent() {
    let (shape, centre, share) = ball();
    for (elevation_deg, azimuth_deg) in [(60.0, 90.0), (35.0, 200.0), (20.0, 330.0)] {
        let light = towards(elevation_deg, azimuth_deg);
        let columns = Columns { extinction_per_m: 0.05, pieces: 4, ..columns(CloudKind::Cumulus, light) };
        let table = build(&columns, &shape);
        let mut layer = layer(&columns, 0.3, 0.0);
        // The ball stands above the origin.
        layer.chart[0].tile_origin_m = (centre - warp::shift_m(&layer.chart[0].warp, Vec2::ZERO)).into();
        let caster = caster(&layer, &columns, &table);
        let height_m = BASE_M + share * columns.thickness_m;
        let expected = -Vec2::new(light.x, light.y) / light.z * height_m;
        let (mut sum, mut weight) = (Vec2::ZERO, 0.0);
        for k in 0..80 * 80 {
            let at = expected + (Vec2::new((k % 80) as f32, (k / 80) as f32) - 39.5) * 25.0;
            let dark = 1.0 - caster.through(EARTH_M, ground(at.x, at.y), 0.0);
            (sum, weight) = (sum + at * dark, weight + dark);
        }
        assert!(weight > 50.0, "there is a shadow: {weight}");
        // Ground 3.5 km away lies 1 m lower, which the light passes in 3 m; the sum is over points 25 m apart; on their crests
        // the waves that move the tile turn by 16 * 1.3 km / (60 km)^2, a hundredth in 1.5 km.
        let off = sum / weight - expected;
        assert!(off.length() < 16.0, "{elevation_deg}, {azimuth_deg}: off by {off} m");
        // And the ball itself casts none where it stands.
        assert!(caster.through(EARTH_M, ground(0.0, 0.0), 0.0) > 0.99);
    }
}

#[test]
fn shadows_are_what_the_deck_lets_through() {
    for (kind, coverage, elevation_deg) in [
        (CloudKind::Cumulus, 0.3, 50.0),
        (CloudKind::Cumulus, 0.6, 25.0),
        (CloudKind::Stratocumulus, 0.6, 60.0),
        (CloudKind::Cirrus, 0.7, 35.0),
    ] {
        let columns = columns(kind, towards(elevation_deg, 140.0));
        let shape = &DensityVolume::of(kind).shape;
        let table = build(&columns, shape);
        let threshold = Coverage::of(kind).threshold(coverage);
        let layer = layer(&columns, threshold.offset, threshold.patchiness);
        let bounds = vec![255u8; BOUNDS_WIDTH * BOUNDS_WIDTH];
        let (map, detail) = (modulation::map(), detail::volume());
        let textures = Textures { shape, lights: &[], bounds: &bounds, map, detail, shade: None, glow: None };
        let caster = caster(&layer, &columns, &table);
        let (mut ours, mut truth, mut apart, points) = (0.0, 0.0, 0.0, 60 * 60);
        for k in 0..points {
            // Over two tiles, so that the map varies too.
            let at = Vec2::new((k % 60) as f32, (k / 60) as f32) * (2.0 * TILE_M / 60.0);
            let found = caster.through(EARTH_M, ground(at.x, at.y), 0.0);
            let marched = march::through(&layer, &textures, EARTH_M, ground(at.x, at.y), 256);
            (ours, truth, apart) = (ours + found, truth + marched, apart + (found - marched).abs());
        }
        let [ours, truth, apart] = [ours, truth, apart].map(|sum| sum / points as f32);
        println!("{kind:?} {coverage} {elevation_deg}: mean {ours:.4}, marched {truth:.4}, apart {apart:.4}");
        // Edges are a texel of 62.5 m soft, and theta is taken half-way through the layer: single points at the edges of
        // clouds differ, more of them the flatter the light; the mean does not. The waves that move the tile turn the light's
        // way in it by up to a tenth, which the table does not know: at 25 degrees 130 m at base and top.
        assert!((ours - truth).abs() < 0.01, "{kind:?}: mean {ours}, marched {truth}");
        assert!(apart < 0.07, "{kind:?}: {apart} apart on the mean");
    }
}

#[test]
fn coarser_levels_keep_the_mean() {
    let columns = columns(CloudKind::Cumulus, towards(45.0, 10.0));
    let table = build(&columns, &DensityVolume::of(CloudKind::Cumulus).shape);
    let mean = |level: usize, layer: usize| {
        let width = WIDTH >> level;
        let texels = &table.levels[level][layer * width * width..][..width * width];
        texels.iter().map(|t| f64::from(t[1])).sum::<f64>() / (255 * width * width) as f64
    };
    assert_eq!(table.levels.len(), LEVELS);
    for layer in 0..table::LAYERS {
        // Rounding to bytes: half a code where a level is one texel.
        (1..LEVELS).for_each(|level| assert!((mean(level, layer) - mean(0, layer)).abs() < 0.0021, "{level} {layer}"));
    }
    // Neighbouring parts share a theta, and less of the cloud is left from one theta to the next.
    for k in 0..table::LAYERS - 1 {
        assert_eq!(sample(&table, 0.4, 0.7, k, 2.3)[3], sample(&table, 0.4, 0.7, k + 1, 2.3)[0]);
        assert!(mean(0, k) <= mean(0, k + 1));
    }
    assert_eq!([theta(0, 0.16), theta(THETAS - 1, 0.16)], [-0.16, 1.0]);
}

#[test]
fn a_footprint_blurs_to_the_mean() {
    let columns = columns(CloudKind::Cumulus, towards(45.0, 10.0));
    let table = build(&columns, &DensityVolume::of(CloudKind::Cumulus).shape);
    let layer = layer(&columns, 0.45, 0.0);
    let caster = caster(&layer, &columns, &table);
    let along = |footprint_m: f32| -> Vec<f32> {
        (0..400).map(|k| caster.through(EARTH_M, ground(k as f32 * 40.0, 0.0), footprint_m)).collect()
    };
    let spread = |values: &[f32]| {
        let mean = values.iter().sum::<f32>() / values.len() as f32;
        (values.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / values.len() as f32).sqrt()
    };
    let spreads = [0.0, 600.0, 1_500.0, 16_000.0].map(|footprint_m| spread(&along(footprint_m)));
    assert!(spreads.windows(2).all(|w| w[1] < 0.9 * w[0]), "{spreads:?}");
    assert!(spreads[3] < 0.01, "{spreads:?}");
}
