//! Conversations in which each field of one packet has something to say.

use super::*;

/// A conversation around one packet: what is said before it, with it and after it, each a message.
pub struct Talk {
    before: Vec<Packet>,
    /// The packet that is changed.
    pub packet: Packet,
    beside: Vec<Packet>,
    after: Vec<Packet>,
}

impl Talk {
    /// The messages, with another packet in the place of the one that is changed.
    pub fn messages(&self, version: Version, packet: &Packet) -> Vec<Vec<Packet>> {
        let is_control = matches!(packet, Packet::IgControl(_));
        let with = if is_control { vec![packet.clone()] } else { vec![control(version, 2).into(), packet.clone()] };
        vec![
            [vec![control(version, 1).into()], self.before.clone()].concat(),
            [with, self.beside.clone()].concat(),
            [vec![control(version, 3).into()], self.after.clone()].concat(),
        ]
    }
}

/// The IG Control of a message; half a second passes between two.
fn control(version: Version, number: u32) -> IgControl {
    let [major_version, minor_version] = version.numbers();
    IgControl {
        major_version,
        minor_version,
        ig_mode: 1,
        timestamp_valid: true,
        extrapolation_interpolation_enable: true,
        host_frame_number: number,
        timestamp: 50_000 * number,
        ..Default::default()
    }
}

/// An entity in a version's own packets; it moves on between messages.
fn entity(version: Version, entity_id: u16, [lat_xoff, lon_yoff, alt_zoff]: [f64; 3]) -> Vec<Packet> {
    let linear_extrapolation_interpolation_enable = true;
    match version {
        Version::V3 => vec![
            EntityControl {
                entity_id,
                entity_state: 1,
                linear_extrapolation_interpolation_enable,
                lat_xoff,
                lon_yoff,
                alt_zoff,
                ..Default::default()
            }
            .into(),
        ],
        Version::V4 => vec![
            EntityState { entity_id, entity_state: 1, linear_extrapolation_interpolation_enable, ..Default::default() }
                .into(),
            EntityPosition { entity_id, lat_xoff, lon_yoff, alt_zoff, ..Default::default() }.into(),
        ],
    }
}

const HERE: [f64; 3] = [47.0, 8.0, 900.0];
/// 22 m further on.
const THERE: [f64; 3] = [47.000_2, 8.0, 900.0];

/// A closed deck of one layer.
fn deck(layer_id: u8, base_elevation: f32) -> WeatherControl {
    WeatherControl {
        layer_id,
        weather_enable: true,
        cloud_type: 10,
        coverage: 100.0,
        base_elevation,
        thickness: 600.0,
        air_temperature: 4.0,
        horizontal_wind_speed: 7.0,
        wind_direction: 200.0,
        aerosol_concentration: 2.0,
        ..Default::default()
    }
}

fn region(region_id: u16) -> EnvironmentalRegionControl {
    EnvironmentalRegionControl {
        region_id,
        region_state: 1,
        merge_weather_properties: true,
        merge_aerosol_concentrations: true,
        latitude: 47.0,
        longitude: 8.0,
        size_x: 20_000.0,
        size_y: 30_000.0,
        corner_radius: 2_000.0,
        rotation: 20.0,
        transition_perimeter: 3_000.0,
        ..Default::default()
    }
}

fn conditions(altitude: f64) -> EnvironmentalConditionsRequest {
    EnvironmentalConditionsRequest { request_type: 12, request_id: 5, latitude: 47.0, longitude: 8.0, altitude }
}

/// All conversations in a version.
pub fn talks(version: Version) -> Vec<Talk> {
    let ownship = entity(version, 0, HERE);
    let two = [entity(version, 1, [47.01, 8.01, 2_500.0]), entity(version, 2, [47.02, 8.0, 700.0])].concat();
    let mut all = vec![Talk {
        before: ownship.clone(),
        packet: IgControl { database_number: 1, ..control(version, 2) }.into(),
        beside: entity(version, 0, THERE),
        after: Vec::new(),
    }];
    let mut talk = |before: Vec<Packet>, packet: Packet, beside: Vec<Packet>, after: Vec<Packet>| {
        all.push(Talk { before: [ownship.clone(), before].concat(), packet, beside, after });
    };
    entities(version, &mut talk);
    views(&two, &mut talk);
    sky(&mut talk);
    weather(&mut talk);
    strikes(&mut talk);
    questions(&two, &mut talk);
    all
}

type Tell<'a> = dyn FnMut(Vec<Packet>, Packet, Vec<Packet>, Vec<Packet>) + 'a;

fn entities(version: Version, talk: &mut Tell) {
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

fn views(two: &[Packet], talk: &mut Tell) {
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

fn sky(talk: &mut Tell) {
    let celestial = CelestialSphereControl {
        hour: 12,
        minute: 30,
        continuous_time_of_day_enable: true,
        sun_enable: true,
        moon_enable: true,
        star_field_enable: true,
        date_time_valid: true,
        date: 6_212_026,
        star_field_intensity: 50.0,
        seconds: 15.0,
    };
    talk(Vec::new(), celestial.into(), Vec::new(), Vec::new());
    let atmosphere = AtmosphereControl {
        global_humidity: 40,
        global_air_temperature: 12.0,
        global_visibility_range: 9_000.0,
        global_horizontal_wind_speed: 5.0,
        global_vertical_wind_speed: 1.0,
        global_wind_direction: 90.0,
        ..Default::default()
    };
    talk(Vec::new(), atmosphere.into(), Vec::new(), vec![conditions(600.0).into()]);
}

fn weather(talk: &mut Tell) {
    let asked = || vec![conditions(1_300.0).into(), conditions(3_200.0).into()];
    let scud = WeatherControl {
        entity_region_id: 1,
        scope: 1,
        humidity: 70,
        visibility_range: 400.0,
        bottom_scud_enable: true,
        bottom_scud_frequency: 40.0,
        top_scud_enable: true,
        top_scud_frequency: 30.0,
        vertical_wind_speed: 2.0,
        barometric_pressure: 880.0,
        ..deck(1, 1_000.0)
    };
    let bands = WeatherControl {
        bottom_scud_enable: false,
        top_scud_enable: false,
        bottom_transition_band: 200.0,
        top_transition_band: 150.0,
        ..scud.clone()
    };
    let storm = WeatherControl { random_lightning_enable: true, severity: 4, ..deck(1, 1_000.0) };
    talk(vec![region(1).into()], scud.into(), Vec::new(), asked());
    talk(vec![region(1).into()], bands.into(), Vec::new(), asked());
    talk(Vec::new(), storm.into(), Vec::new(), asked());
    let layers =
        vec![deck(2, 3_000.0).into(), WeatherControl { entity_region_id: 1, scope: 1, ..deck(1, 1_000.0) }.into()];
    talk(layers, region(1).into(), Vec::new(), asked());
}

fn strikes(talk: &mut Tell) {
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

fn questions(two: &[Packet], talk: &mut Tell) {
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
