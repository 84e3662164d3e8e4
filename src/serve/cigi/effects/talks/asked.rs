//! What a host asks for: strikes, and answers.

use super::weather::{conditions, deck, region};
use super::*;

/// Talks of the three ways to ask for a strike.
pub(super) fn strikes(talk: &mut Tell) {
    let words = |value: f64| ((value.to_bits() >> 32) as u32, value.to_bits() as u32);
    let ((data_1, data_2), (data_3, data_4)) = (words(47.1), words(8.1));
    let component = ComponentControl {
        component_id: STRIKE_COMPONENT,
        instance_id: 9,
        component_class: 13,
        component_state: 1,
        data_1,
        data_2,
        data_3,
        data_4,
        data_5: 3_000f32.to_bits(),
        data_6: (-30f32).to_bits(),
    };
    talk(Vec::new(), component.into(), Vec::new(), Vec::new());
    let short = ShortComponentControl {
        component_id: STRIKE_COMPONENT,
        instance_id: 9,
        component_class: 13,
        component_state: 1,
        data_1: 1,
        data_2: 30f32.to_bits(),
    };
    talk(vec![deck(1, 1_000.0).into(), deck(2, 3_000.0).into()], short.into(), Vec::new(), Vec::new());
    let strike = Strike {
        strike_id: 9,
        flags: 1,
        return_strokes: 2,
        latitude: 47.1,
        longitude: 8.1,
        altitude: 1_000.0,
        peak_current_ka: -30.0,
        channel_top_altitude: 5_000.0,
    };
    talk(Vec::new(), strike.into(), Vec::new(), Vec::new());
    let timed = TimedStrike {
        strike_id: 9,
        flags: 1,
        return_strokes: 2,
        latitude: 47.1,
        longitude: 8.1,
        altitude: 1_000.0,
        peak_current_ka: -30.0,
        channel_top_altitude: 5_000.0,
        delay: 0.1,
    };
    talk(Vec::new(), timed.into(), Vec::new(), Vec::new());
}

/// Talks of heights, lines of sight and the weather at a point.
pub(super) fn questions(two: &[Packet], talk: &mut Tell) {
    let around = || [two, &[deck(1, 1_000.0).into()]].concat();
    let heights = HatHotRequest {
        hat_hot_id: 5,
        request_type: 2,
        coordinate_system: true,
        entity_id: 1,
        lat_xoff: 100.0,
        lon_yoff: 50.0,
        alt_zoff: 20.0,
        ..Default::default()
    };
    // Pitched and rolled, so that each offset changes the height.
    let tilted = |packets: Vec<Packet>| {
        let tilt = |packet| match packet {
            Packet::EntityControl(entity) => EntityControl { pitch: 20.0, roll: 30.0, ..entity }.into(),
            Packet::EntityPosition(entity) => EntityPosition { pitch: 20.0, roll: 30.0, ..entity }.into(),
            other => other,
        };
        packets.into_iter().map(tilt).collect::<Vec<Packet>>()
    };
    talk(tilted(two.to_vec()), heights.into(), Vec::new(), Vec::new());
    // From above the deck to a point below the ground.
    let line = LineOfSightSegmentRequest {
        los_id: 6,
        request_type: true,
        alpha_threshold: 100,
        source_lat_xoff: 47.0,
        source_lon_yoff: 8.0,
        source_alt_zoff: 3_000.0,
        destination_lat_xoff: 47.02,
        destination_lon_yoff: 8.01,
        destination_alt_zoff: -200.0,
        material_mask: 5,
        ..Default::default()
    };
    let between = LineOfSightSegmentRequest {
        source_point_coordinate_system: true,
        destination_point_coordinate_system: true,
        destination_entity_id_valid: true,
        source_entity_id: 1,
        destination_entity_id: 2,
        source_lat_xoff: 5.0,
        source_lon_yoff: 6.0,
        source_alt_zoff: 7.0,
        destination_lat_xoff: 8.0,
        destination_lon_yoff: 9.0,
        destination_alt_zoff: 10.0,
        ..line.clone()
    };
    talk(around(), line.into(), Vec::new(), Vec::new());
    talk(around(), between.into(), Vec::new(), Vec::new());
    let ray = LineOfSightVectorRequest {
        los_id: 6,
        request_type: true,
        alpha_threshold: 100,
        azimuth: 40.0,
        elevation: -60.0,
        maximum_range: 9_000.0,
        source_lat_xoff: 47.0,
        source_lon_yoff: 8.0,
        source_alt_zoff: 3_000.0,
        material_mask: 1,
        ..Default::default()
    };
    // The ground hides; then cloud; then what would hide is too near; then the ground again, in the axes of an entity.
    let cloudy = LineOfSightVectorRequest { material_mask: 5, ..ray.clone() };
    let too_near = LineOfSightVectorRequest { minimum_range: 5_000.0, ..ray.clone() };
    let from_entity = LineOfSightVectorRequest {
        source_point_coordinate_system: true,
        entity_id: 1,
        source_lat_xoff: 5.0,
        source_lon_yoff: 6.0,
        source_alt_zoff: 7.0,
        ..ray.clone()
    };
    for ray in [ray, cloudy, too_near, from_entity] {
        talk(around(), ray.into(), Vec::new(), Vec::new());
    }
    let local = vec![region(1).into(), WeatherControl { entity_region_id: 1, scope: 1, ..deck(1, 1_000.0) }.into()];
    talk(local, conditions(1_300.0).into(), Vec::new(), Vec::new());
}
