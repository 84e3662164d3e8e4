//! The weather at a point: visibility from the field that is drawn, the rest from what the host has said of the air.

use super::air::{Air, AirLayer, AirMass};
use super::field::Field;
use crate::geo::Geodetic;
use crate::world::regions::weight_at;
use crate::world::snapshot::{LayerState, Snapshot, WeatherState};
use glam::Vec3;

/// Optical depth of a visibility: contrast of 5 %, as everywhere in the house.
const VISIBILITY_DEPTH: f64 = 2.996;
/// Fall of temperature with height in the troposphere (ISO 2533).
const LAPSE_K_PER_M: f64 = 0.0065;
/// Its top (ISO 2533); above, the temperature stays.
const TROPOPAUSE_M: f64 = 11_000.0;
/// g M / R of the standard atmosphere in K/m (ISO 2533: 9.80665 * 0.028964420 / 8.31432).
const GMR_K_PER_M: f64 = 0.034_163_2;
/// 0 degrees Celsius.
const ZERO_C_IN_K: f64 = 273.15;

/// Air at a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Conditions {
    /// Temperature, humidity, pressure and winds.
    pub air: AirMass,
    /// Meteorological visibility (5 % contrast) in what is there: cloud, haze, rain.
    pub visibility_m: f64,
    /// Aerosol by weather layer, in g/m3, where a layer is at the point.
    pub aerosols: Vec<(u8, f64)>,
}

/// The weather at a point.
pub fn conditions(snapshot: &Snapshot, air: &Air, point: &Geodetic) -> Conditions {
    let field = Field::around(snapshot, point);
    let cloud_per_m = f64::from(field.cloud_per_m(Vec3::Z, 0.0));
    let mut extinction_per_m = cloud_per_m + f64::from(field.haze_per_m());
    let mut mixed = carried(snapshot, point, standard(&air.global, point.altitude_m - air.sea_level_m));
    let mut aerosols = Vec::new();
    for (index, layer) in air.layers.iter().enumerate() {
        let (here, here_for_aerosol) = share(air, index, point);
        mixed = mix(&mixed, &layer.air, here);
        if let Some(visibility_m) = layer.visibility_m {
            extinction_per_m += here * VISIBILITY_DEPTH / visibility_m.max(1.0);
        }
        if here_for_aerosol > 0.0 {
            aerosols.push((layer.layer_id, layer.aerosol_g_per_m3 * here_for_aerosol));
        }
    }
    let visibility_m = VISIBILITY_DEPTH / extinction_per_m.max(1e-9);
    Conditions { air: mixed, visibility_m, aerosols }
}

/// The air everywhere at a height above mean sea level, after the standard atmosphere from what holds at sea level.
pub fn standard(sea_level: &AirMass, height_m: f64) -> AirMass {
    let low_m = height_m.min(TROPOPAUSE_M);
    let ground_k = (sea_level.temperature_c + ZERO_C_IN_K).max(1.0);
    let low_k = (ground_k - LAPSE_K_PER_M * low_m).max(1.0);
    let low_hpa = sea_level.pressure_hpa * (low_k / ground_k).powf(GMR_K_PER_M / LAPSE_K_PER_M);
    let pressure_hpa = low_hpa * (-GMR_K_PER_M * (height_m - low_m) / low_k).exp();
    AirMass { temperature_c: low_k - ZERO_C_IN_K, pressure_hpa, ..*sea_level }
}

/// Air with the wind that carries the clouds at a point, where it is inside a layer that is drawn.
fn carried(snapshot: &Snapshot, point: &Geodetic, air: AirMass) -> AirMass {
    let shares = snapshot.regions.iter().map(|region| region.presence * weight_at(&region.shape, point));
    let around: f64 = shares.clone().map(|share| 1.0 - share).product();
    let weathers = snapshot.regions.iter().map(|region| &region.weather).zip(shares);
    let by = |weather: &WeatherState| {
        let inside =
            |layer: &&LayerState| (layer.base_m..=layer.base_m + layer.thickness_m).contains(&point.altitude_m);
        weather.layers.iter().find(inside).map_or(air, |layer| AirMass {
            wind_speed_mps: layer.wind_speed_mps,
            wind_from_deg: layer.wind_from_deg,
            ..air
        })
    };
    // Each weather by its share of all, one after the other: the share of what has been mixed so far falls as it should.
    let mut total = around;
    weathers.fold(by(&snapshot.weather), |mixed, (weather, share)| {
        total += share;
        if share > 0.0 { mix(&mixed, &by(weather), share / total) } else { mixed }
    })
}

/// How much of a layer's air, and of its aerosol, is at a point: 1 inside, falling over its bands and its region's transition;
/// less where a later region that keeps nothing of the weather around it lies over it.
fn share(air: &Air, index: usize, point: &Geodetic) -> (f64, f64) {
    let layer = &air.layers[index];
    let outline = |layer: &AirLayer| layer.region.as_ref().map_or(1.0, |region| weight_at(region, point));
    let there = within(layer, point.altitude_m) * outline(layer);
    let (mut left, mut left_aerosol) = (1.0, 1.0);
    for other in air.layers[index + 1..].iter().filter(|other| other.region.is_some() && other.region != layer.region) {
        let over = 1.0 - outline(other);
        left *= if other.merges { 1.0 } else { over };
        left_aerosol *= if other.merges_aerosol { 1.0 } else { over };
    }
    (there * left, there * left_aerosol)
}

/// 1 between base and top, falling to 0 over the bands.
fn within(layer: &AirLayer, altitude_m: f64) -> f64 {
    let side = |beyond_m: f64, band_m: f64| match beyond_m {
        beyond_m if beyond_m <= 0.0 => 1.0,
        _ if band_m <= 0.0 => 0.0,
        beyond_m => (1.0 - beyond_m / band_m).max(0.0),
    };
    side(layer.base_m - altitude_m, layer.below_m).min(side(altitude_m - layer.top_m, layer.above_m))
}

/// Goes over from one air to another; winds as vectors, so that north and north do not make south.
fn mix(a: &AirMass, b: &AirMass, share: f64) -> AirMass {
    let between = |a: f64, b: f64| a + (b - a) * share;
    let wind = |air: &AirMass| {
        let (sin, cos) = air.wind_from_deg.to_radians().sin_cos();
        [air.wind_speed_mps * cos, air.wind_speed_mps * sin]
    };
    let ([an, ae], [bn, be]) = (wind(a), wind(b));
    let (north, east) = (between(an, bn), between(ae, be));
    let calm = north == 0.0 && east == 0.0;
    AirMass {
        temperature_c: between(a.temperature_c, b.temperature_c),
        humidity_percent: between(a.humidity_percent, b.humidity_percent),
        pressure_hpa: between(a.pressure_hpa, b.pressure_hpa),
        wind_speed_mps: north.hypot(east),
        updraft_mps: between(a.updraft_mps, b.updraft_mps),
        wind_from_deg: if calm {
            between(a.wind_from_deg, b.wind_from_deg)
        } else {
            east.atan2(north).to_degrees().rem_euclid(360.0)
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::scenes::{clear_day, place, region};

    #[test]
    fn the_standard_atmosphere_is_that_of_its_tables() {
        // ISO 2533, tables of temperature (K) and pressure (hPa) by geopotential height.
        for (height_m, kelvin, hpa) in
            [(0.0, 288.15, 1_013.25), (5_000.0, 255.65, 540.20), (11_000.0, 216.65, 226.32), (15_000.0, 216.65, 120.45)]
        {
            let air = standard(&AirMass::default(), height_m);
            // The table is rounded to the last digit printed.
            assert!((air.temperature_c + 273.15 - kelvin).abs() < 0.006, "{height_m}: {air:?}");
            assert!((air.pressure_hpa - hpa).abs() < 0.006, "{height_m}: {air:?}");
        }
    }

    fn layer(base_m: f64, temperature_c: f64) -> AirLayer {
        AirLayer {
            layer_id: 4,
            region: None,
            merges: true,
            merges_aerosol: true,
            base_m,
            top_m: base_m + 1_000.0,
            below_m: 200.0,
            above_m: 0.0,
            air: AirMass { temperature_c, wind_speed_mps: 10.0, wind_from_deg: 350.0, ..AirMass::default() },
            visibility_m: Some(2_000.0),
            aerosol_g_per_m3: 2.5,
        }
    }

    #[test]
    fn a_layer_rules_inside_and_fades_over_its_band() {
        let mut snapshot = clear_day();
        snapshot.weather.layers.clear();
        let global = AirMass { wind_speed_mps: 10.0, wind_from_deg: 10.0, ..AirMass::default() };
        let air = Air { global, sea_level_m: 0.0, layers: vec![layer(2_000.0, -20.0)] };
        let at = |altitude_m: f64| conditions(&snapshot, &air, &place(47.0, 8.0, altitude_m));
        assert_eq!((at(2_500.0).air.temperature_c, at(2_500.0).aerosols), (-20.0, vec![(4, 2.5)]));
        // Half-way down the band: half of each, aerosol too; and the wind goes from 350 to 10 by way of north.
        let half = at(1_900.0);
        let around = standard(&global, 1_900.0);
        assert!((half.air.temperature_c - 0.5 * (around.temperature_c - 20.0)).abs() < 1e-9);
        assert_eq!(half.aerosols, [(4, 1.25)]);
        assert!(half.air.wind_from_deg < 1e-9 || half.air.wind_from_deg > 360.0 - 1e-9, "{half:?}");
        assert_eq!((at(3_001.0).aerosols.len(), at(1_799.0).aerosols.len()), (0, 0));
        // Extinctions add: 2.996 / 2000 m and the haze of the clear day.
        let clear = conditions(&snapshot, &Air::default(), &place(47.0, 8.0, 2_500.0)).visibility_m;
        let expected = 1.0 / (1.0 / 2_000.0 + 1.0 / clear);
        assert!((at(2_500.0).visibility_m / expected - 1.0).abs() < 1e-9);
    }

    #[test]
    fn inside_a_layer_blows_the_wind_that_carries_its_clouds() {
        let mut snapshot = clear_day();
        let deck = LayerState { wind_speed_mps: 12.0, wind_from_deg: 250.0, ..layer_state(1_000.0) };
        snapshot.weather.layers = vec![deck];
        let wind = |altitude_m: f64| {
            let found = conditions(&snapshot, &Air::default(), &place(47.0, 8.0, altitude_m)).air;
            (found.wind_speed_mps, found.wind_from_deg)
        };
        let (speed, from) = wind(1_200.0);
        // A vector of length 12 turned into speed and direction and back: rounding alone.
        assert!((speed - 12.0).abs() < 1e-12 && (from - 250.0).abs() < 1e-9, "{speed} {from}");
        assert_eq!((wind(900.0).0, wind(2_100.0).0), (0.0, 0.0), "nobody has said anything of the air around it");
    }

    #[test]
    fn a_wind_that_is_the_same_on_both_sides_of_a_transition_is_the_same_in_it() {
        let mut snapshot = clear_day();
        let deck = LayerState { wind_speed_mps: 12.0, wind_from_deg: 250.0, ..layer_state(1_000.0) };
        snapshot.weather.layers = vec![deck];
        let mut region = region(47.0, 8.0, 20_000.0, 10_000.0);
        region.weather.layers = vec![deck];
        snapshot.regions = vec![region.clone(), region];
        let speed = |snapshot: &Snapshot, longitude_deg: f64| {
            conditions(snapshot, &Air::default(), &place(47.0, longitude_deg, 1_500.0)).air.wind_speed_mps
        };
        // Inside, in the transition, outside; two regions over one another.
        let places = [8.0, 8.17, 8.19, 8.21, 8.6];
        for longitude_deg in places {
            assert!((speed(&snapshot, longitude_deg) - 12.0).abs() < 1e-9, "{longitude_deg}");
        }
        // Still air inside: the wind falls from outside in.
        snapshot.regions.iter_mut().for_each(|region| region.weather.layers.clear());
        let falling = places.map(|longitude_deg| speed(&snapshot, longitude_deg));
        assert!(falling.windows(2).all(|pair| pair[0] <= pair[1]), "{falling:?}");
        assert!(
            falling[0] < 1e-9 && falling[2] > 0.1 && falling[2] < 11.9 && (falling[4] - 12.0).abs() < 1e-9,
            "{falling:?}"
        );
    }

    fn layer_state(base_m: f64) -> LayerState {
        crate::plan::scenes::layer(crate::clouds::CloudKind::Cumulus, base_m, 1_000.0)
    }

    #[test]
    fn haze_near_the_ground_is_the_visibility_that_was_asked_for() {
        let mut snapshot = clear_day();
        snapshot.weather.layers.clear();
        snapshot.weather.visibility_m = 8_000.0;
        let found = conditions(&snapshot, &Air::default(), &place(47.0, 8.0, 2.0)).visibility_m;
        // At 2 m of a haze that falls to 1/e in 1200 m, less than 0.2 % away; f32 on the way.
        assert!((found / 8_000.0 - 1.0).abs() < 0.002, "{found}");
    }
}
