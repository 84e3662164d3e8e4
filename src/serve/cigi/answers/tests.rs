//! Answers as a host reads them: valid or not, in its own coordinates, by the threshold and the mask that it gave.

use super::*;
use crate::clouds::CloudKind;
use crate::geo::terrain::Terrain;
use crate::plan::scenes::{clear_day, layer};
use crate::wire::cigi::packets::EntityControl;
use crate::wire::cigi::scene::Moment;

const SEA_LEVEL_M: f64 = 48.0;
/// A mask of land alone.
const LAND: u32 = bit(ground::MATERIAL_LAND);

/// A closed deck of stratus from 1000 m to 1400 m above the ellipsoid, entity 1 at 47 N 8 E, 2000 m above sea level, heading east.
fn known() -> Known {
    let mut snapshot = clear_day();
    snapshot.weather.layers = vec![layer(CloudKind::Stratus, 1_000.0, 400.0)];
    snapshot.weather.layers[0].coverage = 1.0;
    let mut entities = Entities::new(SEA_LEVEL_M, Terrain::ELLIPSOID);
    let moment = Moment { host_frame: 1, timestamp: None, extrapolate: false, now_s: 0.0 };
    let entity = EntityControl {
        entity_id: 1,
        entity_state: 1,
        yaw: 90.0,
        lat_xoff: 47.0,
        lon_yoff: 8.0,
        alt_zoff: 2_000.0,
        ..Default::default()
    };
    entities.control(&entity, &moment).expect("room");
    let air = Air { sea_level_m: SEA_LEVEL_M, ..Air::default() };
    Known { snapshot: std::sync::Arc::new(snapshot), entities, air, host_frame_number_lsn: 5 }
}

fn heights(known: &Known, request: HatHotRequest) -> HatHotResponse {
    match known.answer(&request.into()).pop() {
        Some(Packet::HatHotResponse(answer)) => answer,
        other => panic!("{other:?}"),
    }
}

#[test]
fn heights_count_from_the_ground_and_from_sea_level() {
    let known = known();
    let at = HatHotRequest { lat_xoff: 47.0, lon_yoff: 8.0, alt_zoff: 500.0, ..Default::default() };
    // The bare ellipsoid lies 48 m below this sea level.
    let hat = heights(&known, at.clone());
    assert!(hat.valid && !hat.response_type && (hat.height - 548.0).abs() < 1e-9, "{hat:?}");
    let hot = heights(&known, HatHotRequest { request_type: 1, ..at.clone() });
    assert!(hot.valid && hot.response_type && (hot.height + 48.0).abs() < 1e-9, "{hot:?}");
    assert_eq!(hot.host_frame_number_lsn, 5);
    // 100 m below entity 1, which is level: Z points down.
    let below = HatHotRequest {
        coordinate_system: true,
        entity_id: 1,
        lat_xoff: 0.0,
        lon_yoff: 0.0,
        alt_zoff: 100.0,
        ..at.clone()
    };
    assert!((heights(&known, below.clone()).height - 1_948.0).abs() < 1e-6);
    for nowhere in [
        HatHotRequest { lat_xoff: 90.5, ..at.clone() },
        HatHotRequest { alt_zoff: 1e9, ..at.clone() },
        HatHotRequest { entity_id: 2, ..below },
    ] {
        let answer = heights(&known, nowhere);
        assert!(!answer.valid && answer.height == 0.0, "{answer:?}");
    }
    let odd = HatHotRequest { request_type: 3, ..at };
    match known.answer(&odd.into()).pop() {
        Some(Packet::HatHotExtendedResponse(answer)) => assert!(!answer.valid),
        other => panic!("{other:?}"),
    }
}

fn segment() -> LineOfSightSegmentRequest {
    LineOfSightSegmentRequest {
        los_id: 3,
        request_type: true,
        alpha_threshold: 128,
        source_lat_xoff: 47.0,
        source_lon_yoff: 8.0,
        source_alt_zoff: 3_000.0,
        destination_lat_xoff: 47.0,
        destination_lon_yoff: 8.0,
        destination_alt_zoff: 100.0,
        material_mask: u32::MAX,
        ..Default::default()
    }
}

fn seen(known: &Known, question: impl Into<Packet>) -> LineOfSightExtendedResponse {
    match known.answer(&question.into()).pop() {
        Some(Packet::LineOfSightExtendedResponse(answer)) => answer,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_segment_ends_at_cloud_by_its_threshold_and_mask() {
    let known = known();
    let hidden = seen(&known, segment());
    assert!(hidden.valid && !hidden.visible && hidden.range_valid, "{hidden:?}");
    assert_eq!((hidden.material_code, hidden.alpha, hidden.los_id), (ground::MATERIAL_CLOUD, 128, 3));
    // Hidden below the deck's top (1400 m above the ellipsoid: 1352 m above sea level), and not far below it.
    assert!((1_200.0..1_352.0).contains(&hidden.alt_zoff), "{hidden:?}");
    assert!((hidden.range - (3_000.0 - hidden.alt_zoff)).abs() < 1e-3, "straight down: {hidden:?}");
    // A mask without cloud, and a destination above the deck: visible up to the end.
    let through = seen(&known, LineOfSightSegmentRequest { material_mask: LAND, ..segment() });
    assert!(through.valid && through.visible && (through.range - 2_900.0).abs() < 1e-3, "{through:?}");
    let above = seen(&known, LineOfSightSegmentRequest { destination_alt_zoff: 1_500.0, ..segment() });
    assert!(above.valid && above.visible && above.alpha == 0, "{above:?}");
    // Under the ground the ground hides, 48 m under sea level.
    let buried = LineOfSightSegmentRequest { destination_alt_zoff: -500.0, material_mask: LAND, ..segment() };
    let buried = seen(&known, buried);
    assert_eq!((buried.visible, buried.material_code, buried.alpha), (false, ground::MATERIAL_LAND, 255));
    assert!((buried.alt_zoff + 48.0).abs() < 1e-3 && buried.normal_vector_elevation == 90.0, "{buried:?}");
}

#[test]
fn each_material_hides_by_its_own_bit() {
    let known = known();
    // Straight down to below the ground: 47 N 8 E is land, 56 N 3 E is sea.
    let over = |latitude: f64, longitude: f64, material_mask: u32| {
        let line = LineOfSightSegmentRequest {
            source_lat_xoff: latitude,
            source_lon_yoff: longitude,
            destination_lat_xoff: latitude,
            destination_lon_yoff: longitude,
            destination_alt_zoff: -400.0,
            material_mask,
            ..segment()
        };
        let answer = seen(&known, line);
        assert!(answer.valid, "{answer:?}");
        answer.material_code
    };
    let (land, water, cloud) = (1, 2, 4);
    for (mask, on_land, at_sea) in
        [(land, 1, 0), (water, 0, 2), (land | water, 1, 2), (cloud, 3, 3), (8, 0, 0), (0, 3, 3)]
    {
        assert_eq!([over(47.0, 8.0, mask), over(56.0, 3.0, mask)], [on_land, at_sea], "mask {mask}");
    }
}

#[test]
fn a_point_is_told_in_the_axes_of_the_entity_that_asks() {
    let known = known();
    // From 10 m before entity 1, which heads east, down to 1500 m above sea level: 500 m below it.
    let down = LineOfSightSegmentRequest {
        source_point_coordinate_system: true,
        destination_point_coordinate_system: true,
        response_coordinate_system: true,
        source_entity_id: 1,
        source_lat_xoff: 10.0,
        source_lon_yoff: 0.0,
        source_alt_zoff: 0.0,
        destination_lat_xoff: 10.0,
        destination_lon_yoff: 0.0,
        destination_alt_zoff: 500.0,
        ..segment()
    };
    let answer = seen(&known, down.clone());
    assert!(answer.valid && answer.visible, "{answer:?}");
    // Through ECEF at 6e6 m and back: 1e-8 m.
    let found = [answer.lat_xoff, answer.lon_yoff, answer.alt_zoff];
    assert!(found.iter().zip([10.0, 0.0, 500.0]).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
    let nobody = seen(&known, LineOfSightSegmentRequest { source_entity_id: 9, ..down.clone() });
    assert!(!nobody.valid && !nobody.visible && nobody.range == 0.0, "{nobody:?}");
    let other = LineOfSightSegmentRequest { destination_entity_id_valid: true, destination_entity_id: 9, ..down };
    assert!(!seen(&known, other).valid, "the destination hangs on nobody");
}

#[test]
fn a_ray_that_meets_nothing_or_has_no_length_has_no_valid_answer() {
    let known = known();
    let ray = LineOfSightVectorRequest {
        request_type: true,
        alpha_threshold: 128,
        azimuth: 20.0,
        elevation: -90.0,
        maximum_range: 5_000.0,
        source_lat_xoff: 47.0,
        source_lon_yoff: 8.0,
        source_alt_zoff: 3_000.0,
        material_mask: LAND,
        ..Default::default()
    };
    let down = seen(&known, ray.clone());
    assert!(down.valid && !down.visible && (down.range - 3_048.0).abs() < 1e-3, "{down:?}");
    for nothing in [
        LineOfSightVectorRequest { elevation: 30.0, ..ray.clone() },
        LineOfSightVectorRequest { maximum_range: 3_000.0, ..ray.clone() },
        LineOfSightVectorRequest { minimum_range: 4_000.0, ..ray.clone() },
        LineOfSightVectorRequest { minimum_range: 6_000.0, ..ray.clone() },
        LineOfSightVectorRequest { minimum_range: -1.0, ..ray.clone() },
        LineOfSightVectorRequest { elevation: -91.0, ..ray.clone() },
        LineOfSightVectorRequest { source_point_coordinate_system: true, entity_id: 9, ..ray.clone() },
    ] {
        let answer = seen(&known, nothing.clone());
        assert!(!answer.valid && answer.range == 0.0, "{nothing:?}: {answer:?}");
    }
    // By the axes of entity 1, which heads east: straight ahead is east, so that the point is as high and further east.
    let ahead = LineOfSightVectorRequest {
        source_point_coordinate_system: true,
        entity_id: 1,
        azimuth: 0.0,
        elevation: -20.0,
        maximum_range: 20_000.0,
        source_lat_xoff: 0.0,
        source_lon_yoff: 0.0,
        source_alt_zoff: 0.0,
        ..ray
    };
    let ahead = seen(&known, ahead);
    assert!(ahead.valid && ahead.lon_yoff > 8.05 && (ahead.lat_xoff - 47.0).abs() < 1e-3, "{ahead:?}");
}

#[test]
fn the_weather_is_answered_in_as_many_packets_as_were_asked_for() {
    let known = known();
    let ask = |request_type: u8, latitude: f64| {
        let request =
            EnvironmentalConditionsRequest { request_type, request_id: 7, latitude, longitude: 8.0, altitude: 1_152.0 };
        known.answer(&request.into())
    };
    match &ask(4, 47.0)[..] {
        [Packet::WeatherConditionsResponse(answer)] => {
            assert_eq!(answer.request_id, 7);
            // In the middle of the deck: its own visibility, far below the 20 km of haze and air.
            assert!(answer.visibility_range < 500.0, "{answer:?}");
        }
        other => panic!("{other:?}"),
    }
    assert_eq!(ask(8, 47.0), [], "no layer here has aerosol");
    assert_eq!((ask(3, 47.0).len(), ask(4, 91.0).len()), (0, 0), "no sea, no such place");
}
