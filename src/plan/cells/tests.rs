//! Storm cells in a plan: where their volume lies, what bounds them, and what they leave of the weather around.

use super::*;
use crate::clouds::density::DensityVolume;
use crate::passes::deck::field::{Textures, column_bounds, margin};
use crate::plan::scenes::{cumulus_at, layer, place, region};
use crate::plan::{FramePlan, Output, plan};
use crate::world::snapshot::{RegionState, Snapshot};
use glam::{Vec2, Vec3};

/// A cell of 12 km in a region of 40 km about a place, its anvil towards the east.
fn cell(latitude_deg: f64, longitude_deg: f64) -> RegionState {
    let mut region = region(latitude_deg, longitude_deg, 40_000.0, 2_000.0);
    region.weather.layers = vec![layer(CloudKind::StormCell, 800.0, 12_000.0)];
    region.weather.layers[0].coverage = 1.0;
    region
}

fn with_cell(altitude_m: f64, cell: RegionState) -> Snapshot {
    let mut snapshot = cumulus_at(place(47.0, 8.0, altitude_m));
    snapshot.regions.push(cell);
    snapshot
}

fn plan_of(snapshot: &Snapshot) -> FramePlan {
    plan(snapshot, &snapshot.views[0], Output::LinearRgb)
}

fn eye_of(snapshot: &Snapshot) -> Eye {
    Eye::new(&snapshot.ownship, &snapshot.views[0], &snapshot.terrain)
}

#[test]
fn the_tile_is_the_square_its_first_axis_downwind() {
    // Near and far, at a pole, across the 180th meridian.
    for (latitude_deg, longitude_deg, from_deg) in
        [(47.2, 8.3, 270.0), (48.0, 9.5, 0.0), (46.5, 7.0, 200.0), (90.0, 0.0, 30.0), (0.2, 179.95, 270.0)]
    {
        let mut region = cell(latitude_deg, longitude_deg);
        region.weather.layers[0].wind_from_deg = from_deg;
        let mut snapshot = with_cell(1_500.0, region.clone());
        if latitude_deg > 89.0 {
            snapshot.ownship.position = place(89.5, 120.0, 1_500.0);
        } else if longitude_deg > 179.0 {
            snapshot.ownship.position = place(0.0, -179.9, 1_500.0);
        }
        let eye = eye_of(&snapshot);
        let cell = Cell::of(&region.weather.layers[0], &region.shape).expect("a cell");
        let (_, charts) = cell.charts(&eye);
        let centre = enu(&place(latitude_deg, longitude_deg, 0.0));
        let (sin, cos) = f64::to_radians(from_deg + 180.0).sin_cos();
        let downwind = centre.x_axis * sin + centre.y_axis * cos;
        for share in [-0.45, 0.0, 0.3] {
            let angle = share * 40_000.0 / MEAN_RADIUS_M;
            let there = eye.direction((centre.z_axis + downwind * angle).normalize()) * eye.earth_m as f32;
            let p = there - Vec3::new(0.0, 0.0, eye.earth_m as f32);
            let z = crate::passes::common::stereographic(p, eye.earth_m as f32, eye.earth_m as f32);
            let tile = charts[0].tile(charts[0].displacement(z));
            // The earth's radius differs by 0.3 % from the mean one; f32 of places 150 km away: some metres.
            assert!((tile - Vec2::new(0.5 + share as f32, 0.5)).length() < 3e-3, "{latitude_deg} {share}: {tile}");
        }
        let outline = cell.outline(1.0, &eye);
        assert_eq!(outline.corner_m, 0.0);
        assert!((Vec2::from(outline.core_m) - 20_000.0).length() < 1.0);
    }
}

#[test]
fn no_cloud_of_a_cell_is_outside_of_its_bound_and_much_is_inside() {
    let snapshot = with_cell(1_500.0, cell(47.4, 8.2));
    let plan = plan_of(&snapshot);
    let drawn = plan.layers.iter().find(|layer| layer.kind == CloudKind::StormCell).expect("the cell is in sight");
    let volume = DensityVolume::of(drawn.kind);
    let bounds = column_bounds(&volume.shape);
    let textures = Textures::unlit(&volume.shape, &bounds);
    let (mut inside, mut outside) = (0, 0);
    for i in 0..40_000 {
        let [x, y, h] = crate::numeric::hash::pcg3d(i, 7, 9).map(crate::numeric::hash::unit);
        let (east, north) = (200_000.0 * (x - 0.5), 200_000.0 * (y - 0.5));
        let height = 800.0 + 12_000.0 * h;
        let p = Vec3::new(east, north, height - (east * east + north * north) / (2.0 * plan.camera.earth_m));
        if margin(&drawn.layer, &textures, plan.camera.earth_m, p, height, 1e5) > 0.0 {
            let direction = (p - Vec3::new(0.0, 0.0, plan.camera.eye_m)).normalize();
            let t = (p - Vec3::new(0.0, 0.0, plan.camera.eye_m)).length();
            let [from, to] = drawn.layer.bounded(plan.camera.eye_m, direction);
            inside += usize::from((from..to).contains(&t));
            outside += usize::from(!(from..to).contains(&t));
        }
    }
    // Of 40,000 places in 200 x 200 km one in 25 lies in the square, a fifth of it in the cell.
    assert!(inside > 100 && outside == 0, "{inside} {outside}");
    // A ray the other way meets nothing, and the surroundings' layer has no bound.
    let [from, to] = drawn.layer.bounded(plan.camera.eye_m, Vec3::NEG_Y);
    assert!(from.max(0.0) >= to);
    assert_eq!(plan.layers.iter().find(|l| l.layer.region == 0).map(|l| l.layer.bound_radius_m), Some(0.0));
}

#[test]
fn far_away_a_small_region_lies_in_its_bound_as_well() {
    // 250 km east on the equator, where the sphere that outlines lie on differs most from the ellipsoid.
    let mut snapshot = cumulus_at(place(0.0, 8.0, 10_000.0));
    let mut small = region(0.0, 10.246, 4_000.0, 100.0);
    small.weather.layers = vec![layer(CloudKind::Stratus, 1_000.0, 2_000.0)];
    small.weather.layers[0].coverage = 1.0;
    snapshot.regions.push(small);
    let plan = plan_of(&snapshot);
    let drawn = plan.layers.iter().find(|layer| layer.layer.region == 1).expect("the region is in sight");
    let volume = DensityVolume::of(drawn.kind);
    let bounds = column_bounds(&volume.shape);
    let textures = Textures::unlit(&volume.shape, &bounds);
    let (mut inside, mut outside) = (0, 0);
    for i in 0..40_000 {
        let [x, y, h] = crate::numeric::hash::pcg3d(i, 11, 13).map(crate::numeric::hash::unit);
        let (angle, north) = ((250_000.0 + 8_000.0 * (x - 0.5)) / plan.camera.earth_m, 8_000.0 * (y - 0.5));
        let height = 1_000.0 + 2_000.0 * h;
        let radius = plan.camera.earth_m + height;
        let up = radius * angle.cos() - plan.camera.earth_m - north * north / (2.0 * plan.camera.earth_m);
        let p = Vec3::new(radius * angle.sin(), north, up);
        if margin(&drawn.layer, &textures, plan.camera.earth_m, p, height, 1e6) > 0.0 {
            let way = p - Vec3::new(0.0, 0.0, plan.camera.eye_m);
            let [from, to] = drawn.layer.bounded(plan.camera.eye_m, way.normalize());
            inside += usize::from((from..to).contains(&way.length()));
            outside += usize::from(!(from..to).contains(&way.length()));
        }
    }
    assert!(inside > 1_000 && outside == 0, "{inside} {outside}");
}

#[test]
fn a_cell_stands_in_the_weather_around_and_other_regions_take_its_place() {
    let of = |snapshot: &Snapshot| {
        let plan = plan_of(snapshot);
        let around = plan.layers.iter().find(|l| l.layer.region == 0).expect("cumulus around").layer;
        around.outline[0].presence
    };
    assert_eq!(of(&with_cell(1_500.0, cell(47.1, 8.0))), 0.0);
    assert_eq!(of(&with_cell(1_500.0, region(47.1, 8.0, 40_000.0, 2_000.0))), 1.0);
    // Where it rules it is the darker the more it has grown, and the exposure follows.
    let exposure = |growth: f64| {
        let mut cell = cell(47.0, 8.0);
        cell.weather.layers[0].coverage = growth;
        plan_of(&with_cell(500.0, cell)).camera.exposure
    };
    assert!(exposure(1.0) > 1.1 * exposure(0.3), "{} {}", exposure(1.0), exposure(0.3));
}

#[test]
fn a_cell_that_turns_into_other_clouds_lets_the_weather_around_go_without_a_step() {
    // Half-way the weather around is half gone, and so is the light of its column.
    let mut half = with_cell(1_500.0, cell(47.0, 8.0));
    let exposure = |turning| {
        half.regions[0].turning = turning;
        plan_of(&half).camera.exposure
    };
    let [none, some, all] = [None, Some(0.5), Some(1.0)].map(exposure);
    assert!((none.min(all)..=none.max(all)).contains(&some), "{none} {some} {all}");
    half.regions[0].turning = Some(0.5);
    let around = plan_of(&half).layers.iter().find(|l| l.layer.region == 0).expect("cumulus around").layer;
    assert_eq!(around.outline[0].presence, 0.5);
}

#[test]
fn at_the_edge_of_sight_a_cell_goes_without_a_step() {
    // Moved away north by 2 km a step beyond where its top sinks under the horizon (about 530 km for an eye at 1.5 km; sight ends at
    // 300 km): when it leaves the plan it is all beyond the range at which its layer is drawn.
    let mut gone = false;
    for k in 0..40 {
        let snapshot = with_cell(1_500.0, cell(49.6 + 0.018 * f64::from(k), 8.0));
        let plan = plan_of(&snapshot);
        let drawn = plan.layers.iter().find(|layer| layer.kind == CloudKind::StormCell);
        gone |= drawn.is_none();
        if let Some(drawn) = drawn {
            assert!(!gone, "it does not come back");
            assert!(bytemuck::bytes_of(&drawn.layer).chunks_exact(4).count() > 0);
            let middle = Vec3::from(drawn.layer.bound_m);
            assert!(middle.is_finite() && drawn.layer.bound_radius_m.is_finite());
            let nearest_m = Vec2::new(middle.x, middle.y).length() - 20_000.0 - 2_000.0;
            assert!(nearest_m < drawn.layer.extent_m, "{nearest_m}");
        }
    }
    assert!(gone);
}
