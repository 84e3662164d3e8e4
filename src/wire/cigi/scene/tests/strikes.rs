//! Strikes by components, packets of our own and weather; and which events are wanted.

use super::*;

#[test]
fn strikes_by_component_by_packet_and_by_weather() {
    let mut host = Host::new();
    host.moment.now_s = 0.0;
    let words = |value: f64| [(value.to_bits() >> 32) as u32, value.to_bits() as u32];
    let ([data_1, data_2], [data_3, data_4]) = (words(47.269212), words(11.404102));
    let component = ComponentControl {
        component_id: STRIKE_COMPONENT,
        instance_id: 7,
        component_class: 13,
        component_state: 1,
        data_1,
        data_2,
        data_3,
        data_4,
        data_5: 1234.5_f32.to_bits(),
        data_6: (-31.25_f32).to_bits(),
    };
    let packet = Strike {
        strike_id: 8,
        flags: 0,
        return_strokes: 3,
        latitude: 47.0,
        longitude: 191.0,
        altitude: 500.0,
        peak_current_ka: 100.0,
        channel_top_altitude: 8_500.0,
    };
    let timed = TimedStrike { strike_id: 9, flags: 1, delay: 2.5, latitude: 1.0, ..Default::default() };
    host.says([
        ownship(47.0, 8.0, 500.0).into(),
        cloud(1, 6, 1_000.0, 8_000.0).into(),
        component.clone().into(),
        packet.into(),
        timed.into(),
        ShortComponentControl {
            component_id: STRIKE_COMPONENT,
            instance_id: 10,
            component_class: 13,
            component_state: 1,
            data_1: 1,
            data_2: 45.0_f32.to_bits(),
        }
        .into(),
        WeatherControl { layer_id: weather::LIGHTNING_LAYER, weather_enable: true, severity: 2, ..Default::default() }
            .into(),
        // Not ours: another component, and one that is off.
        ComponentControl { component_id: 5, ..component.clone() }.into(),
        ComponentControl { component_state: 0, ..component.clone() }.into(),
    ]);
    assert_eq!(host.refused, []);
    let [a, b, c, d, e] = host.strikes.as_slice() else { panic!("five strikes: {:?}", host.strikes) };
    assert_eq!([a.0, b.0, c.0, d.0, e.0], [7, 8, 9, 10, 0]);
    assert_eq!((a.1.latitude_deg, a.1.longitude_deg, a.1.altitude_m), (47.269212, 11.404102, Some(1234.5)));
    assert_eq!(
        (a.1.polarity, a.1.peak_current_ka, a.1.kind),
        (Polarity::Negative, Some(31.25), FlashKind::CloudToGround)
    );
    assert_eq!((b.1.longitude_deg, b.1.altitude_m, b.1.polarity), (-169.0, Some(4_500.0), Polarity::Positive));
    assert!(
        matches!(&b.1.strokes, Strokes::Given(strokes) if strokes.len() == 3 && strokes[0].peak_current_ka == 100.0)
    );
    assert_eq!((c.1.at_s, c.1.altitude_m, c.1.peak_current_ka), (Some(2.5), None, None));
    assert_eq!((d.1.polarity, d.1.peak_current_ka), (Polarity::Positive, Some(45.0)));
    assert!((d.1.latitude_deg - 47.0).abs() < 0.3 && e.1.altitude_m == Some(5_000.0));
    // Words that are no numbers, and a place where there is nothing.
    host.says([
        ComponentControl { data_1: u32::MAX, ..component.clone() }.into(),
        ComponentControl { data_6: f32::NAN.to_bits(), ..component }.into(),
        WeatherControl { layer_id: 10, weather_enable: true, scope: 1, entity_region_id: 3, ..Default::default() }
            .into(),
    ]);
    assert_eq!((host.refused.len(), host.strikes.len()), (3, 5), "{:?}", host.refused);
}

#[test]
fn events_are_muted_and_wanted_by_component() {
    let mut host = Host::new();
    let event = |component_state| -> Packet {
        let instance_id = EVENT_STRIKE_SHOWN;
        ShortComponentControl { instance_id, component_class: 12, component_state, ..Default::default() }.into()
    };
    assert!(host.scene.wants(EVENT_STRIKE_SHOWN));
    host.says([event(0)]);
    assert!(!host.scene.wants(EVENT_STRIKE_SHOWN) && host.scene.wants(EVENT_STRIKE_MISSED));
    host.says([event(1)]);
    assert!(host.scene.wants(EVENT_STRIKE_SHOWN));
}
