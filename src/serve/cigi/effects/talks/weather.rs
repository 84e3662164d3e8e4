//! The sky and the weather: what is said of them, and what is asked.

use super::*;

/// A closed deck of one layer.
pub(super) fn deck(layer_id: u8, base_elevation: f32) -> WeatherControl {
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

/// A region around the ownship.
pub(super) fn region(region_id: u16) -> EnvironmentalRegionControl {
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

/// A question for the weather over the ownship.
pub(super) fn conditions(altitude: f64) -> EnvironmentalConditionsRequest {
    EnvironmentalConditionsRequest { request_type: 12, request_id: 5, latitude: 47.0, longitude: 8.0, altitude }
}

/// Talks of the sky and the air everywhere.
pub(super) fn sky(talk: &mut Tell) {
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

/// Talks of layers and regions.
pub(super) fn weather(talk: &mut Tell) {
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
