//! What moves: entities and the views that they carry.

use super::*;

/// Talks of entities in a version's own packets.
pub(super) fn entities(version: Version, talk: &mut Tell) {
    // Entity 2 carries the view and hangs on entity 1.
    let carried = || {
        let view = ViewControl { entity_id: 2, ..Default::default() };
        [entity(version, 1, [47.5, 8.5, 2_000.0]), vec![view.into()]].concat()
    };
    let [lat_xoff, lon_yoff, alt_zoff] = THERE;
    match version {
        Version::V3 => {
            let alone = EntityControl {
                entity_state: 1,
                linear_extrapolation_interpolation_enable: true,
                roll: 3.0,
                pitch: 4.0,
                yaw: 50.0,
                lat_xoff,
                lon_yoff,
                alt_zoff,
                ..Default::default()
            };
            let attached = EntityControl {
                entity_id: 2,
                attach_state: true,
                parent_id: 1,
                lat_xoff: 10.0,
                lon_yoff: 5.0,
                alt_zoff: -2.0,
                ..alone.clone()
            };
            talk(Vec::new(), alone.into(), Vec::new(), Vec::new());
            talk(carried(), attached.into(), Vec::new(), Vec::new());
        }
        Version::V4 => {
            let still = EntityState { entity_state: 1, ..Default::default() };
            let moving = EntityState { linear_extrapolation_interpolation_enable: true, ..still.clone() };
            let place = EntityPosition { lat_xoff, lon_yoff, alt_zoff, ..Default::default() };
            talk(vec![still.into()], moving.into(), vec![place.clone().into()], Vec::new());
            let alone = EntityPosition { roll: 3.0, pitch: 4.0, yaw: 50.0, ..place };
            let attached = EntityPosition {
                entity_id: 2,
                attach_state: true,
                parent_id: 1,
                lat_xoff: 10.0,
                lon_yoff: 5.0,
                alt_zoff: -2.0,
                ..alone.clone()
            };
            talk(Vec::new(), alone.into(), Vec::new(), Vec::new());
            talk(carried(), attached.into(), Vec::new(), Vec::new());
            talk(Vec::new(), AnimationControl::default().into(), Vec::new(), Vec::new());
        }
    }
}

/// Talks of View Control and View Definition.
pub(super) fn views(two: &[Packet], talk: &mut Tell) {
    let control = ViewControl {
        view_id: 1,
        x_offset_enable: true,
        y_offset_enable: true,
        z_offset_enable: true,
        roll_enable: true,
        pitch_enable: true,
        yaw_enable: true,
        entity_id: 2,
        x_offset: 2.0,
        y_offset: 1.5,
        z_offset: -1.0,
        roll: 2.0,
        pitch: 3.0,
        yaw: 30.0,
        ..Default::default()
    };
    let definition = ViewDefinition {
        view_id: 1,
        left_enable: true,
        right_enable: true,
        top_enable: true,
        bottom_enable: true,
        near: 1.0,
        far: 1e5,
        left: -20.0,
        right: 25.0,
        top: 15.0,
        bottom: -12.0,
        ..Default::default()
    };
    let member = ViewDefinition { group_id: 3, ..definition.clone() };
    talk([two, &[member.into()]].concat(), control.clone().into(), Vec::new(), Vec::new());
    let group = ViewControl { group_id: 1, ..control };
    talk(two.to_vec(), definition.into(), Vec::new(), vec![group.into()]);
}
