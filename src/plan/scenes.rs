//! Snapshots for tests: a plain day, and the worst that the limits of the world allow (and somewhat beyond).

use crate::clouds::CloudKind;
use crate::geo::frames::enu;
use crate::geo::terrain::Terrain;
use crate::geo::{Attitude, Geodetic};
use crate::lightning::flash::Light;
use crate::passes::relight::Lighting;
use crate::world::command::{Exposure, FlashKind, Polarity, RegionShape};
use crate::world::snapshot::{
    DeckForm, FlashState, LayerState, OwnshipState, Quality, RegionState, SkyState, Snapshot, ViewState, WeatherState,
};
use glam::{DQuat, DVec3};

/// A place by degrees and metres.
pub fn place(latitude_deg: f64, longitude_deg: f64, altitude_m: f64) -> Geodetic {
    Geodetic { latitude_rad: latitude_deg.to_radians(), longitude_rad: longitude_deg.to_radians(), altitude_m }
}

/// A clear day at 47 N 8 E, 1500 m; the sun at 50 degrees, the moon below the horizon; one view of 16 x 9.
pub fn clear_day() -> Snapshot {
    let view = ViewState {
        name: "main".into(),
        size_px: [16, 9],
        field_of_view_deg: 60.0,
        offset_m: [0.0; 3],
        attitude: Attitude::default(),
        exposure: Exposure::Automatic,
        frustum: None,
        mirror: [false; 2],
        lights: Default::default(),
        entity: 0,
        carrier: None,
    };
    let sky = SkyState {
        sun_direction_ecef: DVec3::Z,
        moon_direction_ecef: DVec3::NEG_Z,
        moon_lit_fraction: 0.5,
        sun_shines: true,
        moon_shines: true,
        starlight: 1.0,
    };
    let snapshot = Snapshot {
        number: 1,
        host_frame: 0,
        simulation_time_s: 0.0,
        shutter_s: [0.0, 0.016],
        utc_s: 0.0,
        ownship: OwnshipState { position: place(47.0, 8.0, 1_500.0), attitude: Attitude::default() },
        weather: WeatherState { layers: Vec::new(), visibility_m: 40_000.0 },
        regions: Vec::new(),
        views: vec![view],
        storms: Vec::new(),
        flashes: Vec::new(),
        sky,
        quality: Quality {
            slices: 8,
            deck_scale: 1,
            ring_ratio: 4.0,
            deck_form: DeckForm::Auto,
            light_encoding: Default::default(),
            relight: Lighting::Point,
            basis_memory_mib: 256,
        },
        terrain: Terrain::ELLIPSOID,
    };
    sun(snapshot, 50.0)
}

/// The same with the sun at an elevation, and the moon opposite.
pub fn sun(mut snapshot: Snapshot, elevation_deg: f64) -> Snapshot {
    let (up, north) = elevation_deg.to_radians().sin_cos();
    let direction = enu(&snapshot.ownship.position) * DVec3::new(0.0, north, up);
    snapshot.sky.sun_direction_ecef = direction;
    snapshot.sky.moon_direction_ecef = -direction;
    snapshot
}

/// A layer of half cover at a base.
pub fn layer(kind: CloudKind, base_m: f64, thickness_m: f64) -> LayerState {
    LayerState {
        kind,
        base_m,
        thickness_m,
        coverage: 0.5,
        density: 1.0,
        wind_speed_mps: 10.0,
        wind_from_deg: 270.0,
        drift: DQuat::IDENTITY,
    }
}

/// A flash of a gigacandela.
pub fn flash(position: Geodetic) -> FlashState {
    FlashState {
        id: 1,
        position,
        kind: FlashKind::IntraCloud,
        polarity: Polarity::Negative,
        peak_current_ka: 30.0,
        begin_s: 0.0,
        end_s: 0.5,
        intensity_cd: 1e9,
        seed: 1,
        ground_points_m: vec![[0.0; 2]],
        lights: vec![Light { channel: 0, branches: true, span: [0.0, 1.0], amount: 4.0 * std::f64::consts::PI * 1e9 }],
        channel: None,
    }
}

/// A square region with cumulus of its own.
pub fn region(latitude_deg: f64, longitude_deg: f64, size_m: f64, transition_m: f64) -> RegionState {
    RegionState {
        shape: RegionShape {
            name: "region".into(),
            latitude_deg,
            longitude_deg,
            size_east_m: size_m,
            size_north_m: size_m,
            corner_radius_m: 0.5 * size_m,
            rotation_deg: 30.0,
            transition_m,
        },
        weather: WeatherState { layers: vec![layer(CloudKind::Cumulus, 1_200.0, 900.0)], visibility_m: 40_000.0 },
        presence: 1.0,
        turning: None,
    }
}

/// A day under broken cumulus with its eye at a place.
pub fn cumulus_at(position: Geodetic) -> Snapshot {
    let mut snapshot = clear_day();
    snapshot.ownship.position = position;
    snapshot.weather.layers.push(layer(CloudKind::Cumulus, 1_000.0, 1_000.0));
    sun(snapshot, 50.0)
}

/// A change of a scene.
type Change = fn(&mut Snapshot);

/// What strains a plan, each with its name.
pub fn extremes() -> Vec<(String, Snapshot)> {
    let mut scenes = Vec::new();
    for (latitude_deg, longitude_deg) in
        [(90.0, 0.0), (-90.0, 77.0), (89.999_999_9, -180.0), (0.0, 180.0), (47.0, -180.0), (-33.0, 179.999_999_9)]
    {
        let name = format!("at {latitude_deg} {longitude_deg}");
        scenes.push((name, cumulus_at(place(latitude_deg, longitude_deg, 1_500.0))));
    }
    // 1000 and 2000 m are the layer's base and top, between them the plane of a slice; a space station is at 400 km.
    let slice_m = 1_000.0 + 3.0 * 1_000.0 / 7.0;
    for altitude_m in
        [-1_000.0, -500.0, 0.0, 1.0, 2.0, 1_000.0, slice_m, 2_000.0, 30_000.0, 100_000.0, 101_000.0, 400_000.0]
    {
        for pitch_deg in [-90.0f64, 0.0] {
            let mut snapshot = cumulus_at(place(47.0, 8.0, altitude_m));
            snapshot.ownship.attitude.pitch_rad = pitch_deg.to_radians();
            scenes.push((format!("at {altitude_m} m, pitch {pitch_deg}"), snapshot));
        }
    }
    for elevation_deg in [-90.0, -18.0, -0.1, 0.0, 0.1, 90.0] {
        let high = cumulus_at(place(47.0, 8.0, 1_500.0));
        scenes.push((format!("sun at {elevation_deg}"), sun(high, elevation_deg)));
    }
    let changes: [(&str, Change); 34] = [
        ("a layer of 1 m", |s| s.weather.layers[0].thickness_m = 1.0),
        ("a layer of 1 cm", |s| s.weather.layers[0].thickness_m = 0.01),
        ("a layer of 20 km below sea level", |s| {
            s.weather.layers[0] = layer(CloudKind::Cumulonimbus, -500.0, 20_000.0)
        }),
        ("a layer of 18 km", |s| s.weather.layers[0] = layer(CloudKind::Cumulonimbus, 500.0, 18_000.0)),
        ("a layer below the ground, the eye on it", |s| {
            s.weather.layers[0] = layer(CloudKind::Stratus, -500.0, 400.0);
            s.ownship.position.altitude_m = 1.0;
        }),
        ("two layers that overlap", |s| s.weather.layers.push(layer(CloudKind::Stratocumulus, 1_400.0, 900.0))),
        ("two layers in one place", |s| s.weather.layers.push(s.weather.layers[0])),
        ("density 0", |s| s.weather.layers[0].density = 0.0),
        ("coverage 0", |s| s.weather.layers[0].coverage = 0.0),
        ("coverage 1", |s| s.weather.layers[0].coverage = 1.0),
        ("density 1e-300", |s| s.weather.layers[0].density = 1e-300),
        ("density 100", |s| s.weather.layers[0].density = 100.0),
        ("visibility 50 m", |s| s.weather.visibility_m = 50.0),
        ("a region over the pole", |s| {
            s.ownship.position = place(89.99, 120.0, 1_500.0);
            s.regions.push(region(90.0, 0.0, 50_000.0, 5_000.0));
        }),
        ("a region across the 180th meridian", |s| {
            s.ownship.position = place(47.0, 179.99, 1_500.0);
            s.regions.push(region(47.0, -179.95, 50_000.0, 5_000.0));
        }),
        ("two regions over one another", |s| {
            s.regions = vec![region(47.0, 8.0, 20_000.0, 5_000.0), region(47.05, 8.05, 20_000.0, 5_000.0)];
        }),
        ("mountains above the cloud base", |s| {
            s.terrain = Terrain::procedural();
            s.ownship.position = place(46.5, 8.0, 3_500.0);
        }),
        ("a great city under the eye, by night", |s| {
            s.ownship.position = place(35.69, 139.69, 300.0);
            *s = sun(s.clone(), -30.0);
        }),
        ("visibility 10 m", |s| s.weather.visibility_m = 10.0),
        ("visibility 300 km", |s| s.weather.visibility_m = 300_000.0),
        ("field of view 1 degree", |s| s.views[0].field_of_view_deg = 1.0),
        ("field of view 170 degrees", |s| s.views[0].field_of_view_deg = 170.0),
        ("one pixel", |s| s.views[0].size_px = [1, 1]),
        ("a tall picture at a coarse deck", |s| {
            (s.views[0].size_px, s.views[0].field_of_view_deg, s.quality.deck_scale) = ([16, 640], 170.0, 4);
        }),
        ("one slice", |s| s.quality.slices = 1),
        ("512 slices", |s| s.quality.slices = 512),
        ("512 slices, close rings", |s| (s.quality.slices, s.quality.ring_ratio) = (512, 1.01)),
        ("EV 24", |s| s.views[0].exposure = Exposure::Ev100(24.0)),
        ("EV -12", |s| s.views[0].exposure = Exposure::Ev100(-12.0)),
        ("a region at the antipode", |s| s.regions.push(region(-47.0, -172.0, 2_000_000.0, 0.0))),
        ("huge regions all round", |s| s.regions = vec![region(47.0, 8.0, 2_000_000.0, 500_000.0); 16]),
        ("a tiny region around the eye", |s| s.regions.push(region(47.0, 8.0, 100.0, 0.0))),
        ("a flash at the eye", |s| s.flashes.push(flash(place(47.0, 8.0, 1_500.0)))),
        ("flashes at the antipode and in the ground", |s| {
            s.flashes = vec![flash(place(-47.0, -172.0, 25_000.0)), flash(place(47.0, 8.0, -500.0))];
        }),
    ];
    for (name, change) in changes {
        let mut snapshot = cumulus_at(place(47.0, 8.0, 1_500.0));
        change(&mut snapshot);
        scenes.push((name.into(), snapshot));
    }
    for wind_speed_mps in [0.0, 150.0] {
        let mut snapshot = cumulus_at(place(47.0, 8.0, 1_500.0));
        snapshot.weather = blown_for_ten_years(wind_speed_mps);
        scenes.push((format!("ten years of {wind_speed_mps} m/s"), snapshot));
    }
    scenes
}

/// Cumulus that a wind from the west-south-west has carried for ten years: a rotation about the Earth's centre.
pub fn blown_for_ten_years(wind_speed_mps: f64) -> WeatherState {
    let frame = enu(&place(47.0, 8.0, 0.0));
    let towards = 70f64.to_radians();
    let axis = frame.z_axis.cross(frame.x_axis * towards.sin() + frame.y_axis * towards.cos());
    let drift = DQuat::from_axis_angle(axis, wind_speed_mps / 6_371_000.0 * 3_652.5 * 86_400.0);
    let cumulus = layer(CloudKind::Cumulus, 1_000.0, 1_000.0);
    let blown = LayerState { wind_speed_mps, wind_from_deg: 250.0, drift, ..cumulus };
    WeatherState { layers: vec![blown], visibility_m: 40_000.0 }
}
