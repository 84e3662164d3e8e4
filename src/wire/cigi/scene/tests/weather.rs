//! Layers, regions, entities' weather and storms by CIGI packets.

use super::*;

#[test]
fn all_ten_genera_and_the_rest() {
    let expected = [
        None,
        Some(CloudKind::Altocumulus),
        Some(CloudKind::Altostratus),
        Some(CloudKind::Cirrocumulus),
        Some(CloudKind::Cirrostratus),
        Some(CloudKind::Cirrus),
        Some(CloudKind::Cumulonimbus),
        Some(CloudKind::Cumulus),
        Some(CloudKind::Nimbostratus),
        Some(CloudKind::Stratocumulus),
        Some(CloudKind::Stratus),
        Some(CloudKind::Stratocumulus),
    ];
    for (cloud_type, expected) in (0..).zip(expected) {
        let mut host = Host::new();
        host.says([cloud(1, cloud_type, 1_000.0, 500.0).into()]);
        assert_eq!(host.sees().weather.layers.first().map(|layer| layer.kind), expected, "{cloud_type}");
    }
    let mut host = Host::new();
    host.says([cloud(0, 0, 0.0, 60.0).into(), cloud(5, 7, 3_000.0, 500.0).into()]);
    let kinds: Vec<CloudKind> = host.sees().weather.layers.iter().map(|layer| layer.kind).collect();
    assert_eq!(kinds, [CloudKind::Stratus], "fog is stratus, snow is no cloud");
}

#[test]
fn cumulonimbus_with_an_outline_is_a_storm_cell_that_stands_in_the_weather_around() {
    let mut host = Host::new();
    let region = EnvironmentalRegionControl {
        region_id: 4,
        region_state: 1,
        size_x: 40_000.0,
        size_y: 40_000.0,
        merge_weather_properties: true,
        ..Default::default()
    };
    let cell =
        WeatherControl { scope: 1, entity_region_id: 4, bottom_transition_band: 300.0, ..cloud(1, 6, 900.0, 11_000.0) };
    host.says([cloud(1, 7, 1_200.0, 800.0).into(), region.into(), cell.clone().into()]);
    let seen = host.sees();
    let kinds = |weather: &crate::world::snapshot::WeatherState| -> Vec<CloudKind> {
        weather.layers.iter().map(|layer| layer.kind).collect()
    };
    assert_eq!(kinds(&seen.weather), [CloudKind::Cumulus]);
    // No band of it, and no copy of the layers around.
    assert_eq!(kinds(&seen.regions[0].weather), [CloudKind::StormCell]);
    assert!(seen.regions[0].stands_in());
    // It has no scud: beside another layer of its own it could not stand in the weather around.
    host.says([WeatherControl { bottom_scud_enable: true, bottom_scud_frequency: 40.0, ..cell }.into()]);
    host.world.advance_to(1.0);
    let seen = host.sees();
    assert_eq!(kinds(&seen.regions[0].weather), [CloudKind::StormCell]);
    assert!(seen.regions[0].stands_in());
}

#[test]
fn a_layer_says_cover_heights_wind_and_visibility() {
    let mut host = Host::with(Convention { sea_level_m: 40.0, ..CONVENTION }, Version::V4);
    let layer = WeatherControl {
        coverage: 75.0,
        horizontal_wind_speed: 12.5,
        wind_direction: -45.0,
        visibility_range: 120.0,
        ..cloud(2, 10, 1_500.0, 400.0)
    };
    host.says([layer.clone().into()]);
    let seen = host.sees().weather.layers[0];
    assert_close([seen.coverage, seen.base_m, seen.thickness_m], [0.75, 1_540.0, 400.0], 1e-9);
    assert_close([seen.wind_speed_mps, seen.wind_from_deg], [12.5, 315.0], 1e-9);
    // Contrast of 5 % at 120 m: the extinction is -ln(0.05) / 120 m, to the four digits that the constant has.
    let extinction_per_m = seen.density * f64::from(CloudKind::Stratus.appearance().extinction_per_m);
    assert_close([extinction_per_m], [-(0.05_f64).ln() / 120.0], 1e-5);
    host.says([WeatherControl { weather_enable: false, ..layer }.into()]);
    host.world.advance_to(1.0);
    assert_eq!(host.sees().weather.layers, []);
}

#[test]
fn scud_and_transition_bands_hang_on_the_layer_where_there_is_room() {
    let banded = WeatherControl { bottom_transition_band: 100.0, ..cloud(1, 10, 1_000.0, 400.0) };
    for (version, expected) in [(Version::V3, vec![900.0, 1_000.0, 1_400.0]), (Version::V4, vec![900.0, 1_000.0])] {
        let mut host = Host::with(CONVENTION, version);
        host.says([banded.clone().into()]);
        let layers = host.sees().weather.layers;
        assert_close(layers.iter().map(|layer| layer.base_m), expected, 1e-9);
        assert_close([layers[0].density / layers[1].density], [0.5], 1e-9);
    }
    let mut host = Host::with(CONVENTION, Version::V4);
    let scud = WeatherControl {
        bottom_scud_enable: true,
        bottom_scud_frequency: 30.0,
        top_scud_enable: true,
        top_scud_frequency: 20.0,
        ..cloud(1, 9, 1_000.0, 400.0)
    };
    host.says([scud.into(), cloud(2, 2, 1_500.0, 300.0).into()]);
    let layers = host.sees().weather.layers;
    assert_close(layers.iter().map(|layer| layer.base_m), [750.0, 1_000.0, 1_500.0], 1e-9);
    assert_close([layers[0].coverage], [0.3], 1e-7);
}

#[test]
fn layers_that_overlap_are_fitted_and_never_refused() {
    let mut host = Host::new();
    host.says([
        cloud(1, 7, 1_000.0, 3_000.0).into(),
        cloud(2, 2, 2_500.3, 700.7).into(),
        cloud(3, 5, 2_500.3, 9.0).into(),
    ]);
    let layers = host.sees().weather.layers;
    assert!(layers.windows(2).all(|pair| pair[0].base_m + pair[0].thickness_m <= pair[1].base_m), "{layers:?}");
    assert_eq!(layers.len(), 2, "one of two with the same base");
    // Everything at the limits: still no refusal.
    let wild = WeatherControl {
        coverage: 1e30,
        horizontal_wind_speed: -3.0,
        visibility_range: 1e-30,
        bottom_transition_band: 1e20,
        ..cloud(1, 6, -1e9, 1e9)
    };
    host.says([wild.into()]);
    host.sees();
}

#[test]
fn a_region_has_its_own_weather_and_merges_when_asked() {
    let region = |merge| EnvironmentalRegionControl {
        region_id: 515,
        region_state: 1,
        merge_weather_properties: merge,
        latitude: 47.25,
        longitude: 11.5,
        size_x: 40_000.0,
        size_y: 25_000.0,
        corner_radius: 5_000.0,
        rotation: 0.0,
        transition_perimeter: 2_500.0,
        ..Default::default()
    };
    let over = WeatherControl { scope: 1, entity_region_id: 515, ..cloud(2, 10, 600.0, 300.0) };
    for (merge, bases) in [(false, vec![600.0]), (true, vec![600.0, 3_000.0])] {
        let mut host = Host::new();
        host.says([cloud(1, 1, 3_000.0, 300.0).into(), region(merge).into(), over.clone().into()]);
        let seen = host.sees();
        let state = &seen.regions[0];
        assert_close(state.weather.layers.iter().filter(|l| l.coverage > 0.0).map(|layer| layer.base_m), bases, 1e-9);
        // 19.9 km north of the centre is inside the 40 km, 19.9 km east is beyond the 25 km.
        let point = |north_m: f64, east_m: f64| crate::geo::Geodetic {
            latitude_rad: (47.25 + north_m / 111_180.0_f64).to_radians(),
            longitude_rad: (11.5 + east_m / (111_320.0 * 47.25_f64.to_radians().cos())).to_radians(),
            altitude_m: 0.0,
        };
        assert!(signed_distance_m(&state.shape, &point(19_900.0, 0.0)) < 0.0);
        assert!(signed_distance_m(&state.shape, &point(0.0, 19_900.0)) > 7_000.0);
        host.says([EnvironmentalRegionControl { region_state: 0, ..region(merge) }.into()]);
        host.world.advance_to(1.0);
        assert_eq!(host.sees().regions.len(), 0, "inactive");
        host.says([region(merge).into()]);
        assert_eq!(host.sees().regions.len(), 1, "its layers were kept");
        host.says([EnvironmentalRegionControl { region_state: 2, ..region(merge) }.into()]);
        host.world.advance_to(2.0);
        host.says([region(merge).into()]);
        let own =
            host.sees().regions[0].weather.layers.iter().any(|layer| layer.base_m == 600.0 && layer.coverage > 0.0);
        assert!(!own, "destroyed with its layers");
    }
}

#[test]
fn an_entitys_weather_goes_with_it() {
    let mut host = Host::new();
    let entity = |longitude| -> Packet { EntityControl { entity_id: 9, ..ownship(47.0, longitude, 0.0) }.into() };
    let storm = WeatherControl { scope: 2, entity_region_id: 9, layer_id: 77, ..cloud(77, 6, 1_000.0, 8_000.0) };
    host.says([entity(8.0), storm.into()]);
    assert_close([host.sees().regions[0].shape.longitude_deg], [8.0], 1e-9);
    host.says([entity(8.1)]);
    host.world.advance_to(1.0);
    assert_close([host.sees().regions[0].shape.longitude_deg], [8.1], 1e-9);
    assert_eq!(host.says([entity(8.100_1)]), 0, "7.6 m are not worth a command");
}

#[test]
fn random_lightning_is_a_seeded_storm_inside_its_extent() {
    let mut host = Host::new();
    let region = EnvironmentalRegionControl {
        region_id: 1,
        region_state: 1,
        latitude: 47.0,
        longitude: 8.0,
        size_x: 30_000.0,
        size_y: 10_000.0,
        corner_radius: 5_000.0,
        rotation: 30.0,
        ..Default::default()
    };
    let storm = WeatherControl {
        scope: 1,
        entity_region_id: 1,
        random_lightning_enable: true,
        severity: 5,
        ..cloud(1, 6, 1_000.0, 8_000.0)
    };
    host.says([region.into(), storm.clone().into()]);
    let storms = host.sees().storms;
    assert_eq!(storms.len(), 1);
    let found = &storms[0];
    assert_eq!((found.name.as_str(), found.latitude_deg, found.longitude_deg), ("cigi-region-1-1", 47.0, 8.0));
    assert_eq!((found.size_east_m, found.size_north_m, found.corner_radius_m), (10_000.0, 30_000.0, 5_000.0));
    assert_eq!((found.rotation_deg, found.altitude_m), (30.0, Some(5_000.0)));
    assert_eq!((found.flashes_per_minute, found.current_factor), (30.0, 1.3));
    assert_eq!(host.says([storm.clone().into()]), 0, "said again it goes on");
    let weak = WeatherControl { severity: 0, ..storm.clone() };
    host.says([weak.into()]);
    assert_eq!(host.sees().storms[0].flashes_per_minute, 1.0);
    host.says([WeatherControl { random_lightning_enable: false, ..storm }.into()]);
    assert_eq!(host.sees().storms, []);
}

#[test]
fn of_many_regions_and_storms_the_world_has_those_near_the_ownship() {
    let mut host = Host::new();
    let storm =
        WeatherControl { scope: 1, random_lightning_enable: true, severity: 5, ..cloud(1, 6, 1_000.0, 8_000.0) };
    let mut all: Vec<Packet> = vec![ownship(47.0, 25.1, 900.0).into()];
    for id in 0..40_u16 {
        let region = EnvironmentalRegionControl {
            region_id: id,
            region_state: 1,
            latitude: 47.0,
            longitude: f64::from(id),
            size_x: 30_000.0,
            size_y: 10_000.0,
            ..Default::default()
        };
        all.extend([region.into(), WeatherControl { entity_region_id: id, ..storm.clone() }.into()]);
    }
    host.says(all);
    // 32 regions and 16 storms, as many on either side of the ownship as there are.
    for (at, there, raging) in [(25.1, 8..40_u16, 18..34_u16), (3.0, 0..32, 0..16)] {
        host.says([ownship(47.0, at, 900.0).into()]);
        host.world.advance_to(30.0 - at);
        let (mut regions, mut storms): (Vec<_>, Vec<_>) = (
            host.sees().regions.iter().map(|region| region.shape.name.clone()).collect(),
            host.sees().storms.iter().map(|storm| storm.name.clone()).collect(),
        );
        regions.sort();
        storms.sort();
        let named = |ids: std::ops::Range<u16>, name: fn(u16) -> String| {
            let mut names: Vec<_> = ids.map(name).collect();
            names.sort();
            names
        };
        assert_eq!(regions, named(there, |id| format!("region-{id}")));
        assert_eq!(storms, named(raging, |id| format!("cigi-region-{id}-1")));
    }
    // To and fro between two places where others are nearest by a little: nothing comes or goes.
    for at in [20.2, 20.8] {
        host.says([ownship(47.0, at, 900.0).into()]);
    }
    for to_and_fro in 0..6 {
        let at = if to_and_fro % 2 == 0 { 20.2 } else { 20.8 };
        assert!(host.says([ownship(47.0, at, 900.0).into()]) <= 1, "the ownship moves, and nothing else");
    }
    assert!(host.refused.is_empty(), "{:?}", host.refused);
}

#[test]
fn a_storm_of_the_global_weather_goes_with_the_ownship_in_steps() {
    let mut host = Host::new();
    let storm = WeatherControl { random_lightning_enable: true, severity: 5, ..cloud(3, 6, 1_000.0, 8_000.0) };
    host.says([ownship(47.0, 8.0, 900.0).into(), storm.into()]);
    assert_eq!(host.sees().storms[0].latitude_deg, 47.0);
    host.says([ownship(47.02, 8.0, 900.0).into()]);
    assert_eq!(host.sees().storms[0].latitude_deg, 47.0, "2.2 km of 60 are not worth a command");
    host.says([ownship(47.1, 8.0, 900.0).into()]);
    assert_eq!(host.sees().storms[0].latitude_deg, 47.1);
}
