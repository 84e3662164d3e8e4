//! From a snapshot to the state message: radians to degrees, directions to what is seen from the ownship.

use super::{FlashOut, LayerOut, OwnshipOut, Player, RegionOut, SkyOut, StateMessage, ViewOut, WeatherOut};
use crate::geo::{Attitude, Geodetic};
use crate::units::deg;
use crate::wire::control::instant;
use crate::wire::control::storm::StormMessage;
use crate::world::snapshot::{
    FlashState, LayerState, OwnshipState, RegionState, SkyState, Snapshot, ViewState, WeatherState,
};
use glam::DVec3;

impl StateMessage {
    /// The message for a snapshot.
    pub fn new(seq: Option<u64>, snapshot: &Snapshot, player: Player) -> Self {
        Self {
            seq,
            snapshot: snapshot.number,
            host_frame: snapshot.host_frame,
            simulation_time_s: snapshot.simulation_time_s,
            shutter_s: snapshot.shutter_s,
            utc: instant::print(snapshot.utc_s),
            ownship: OwnshipOut::from(&snapshot.ownship),
            weather: WeatherOut::from(&snapshot.weather),
            regions: snapshot.regions.iter().map(RegionOut::from).collect(),
            views: snapshot.views.iter().map(ViewOut::from).collect(),
            storms: snapshot.storms.iter().map(StormMessage::from).collect(),
            flashes: snapshot.flashes.iter().map(FlashOut::from).collect(),
            sky: SkyOut::seen_from(&snapshot.ownship.position, &snapshot.sky),
            slices: snapshot.quality.slices,
            deck_scale: snapshot.quality.deck_scale,
            deck_form: snapshot.quality.deck_form.into(),
            light_encoding: snapshot.quality.light_encoding.into(),
            relight: snapshot.quality.relight.into(),
            ring_ratio: snapshot.quality.ring_ratio,
            player,
        }
    }
}

fn degrees(attitude: &Attitude) -> [f64; 3] {
    [deg(attitude.yaw_rad), deg(attitude.pitch_rad), deg(attitude.roll_rad)]
}

impl From<&OwnshipState> for OwnshipOut {
    fn from(ownship: &OwnshipState) -> Self {
        let [yaw_deg, pitch_deg, roll_deg] = degrees(&ownship.attitude);
        Self {
            latitude_deg: deg(ownship.position.latitude_rad),
            longitude_deg: deg(ownship.position.longitude_rad),
            altitude_m: ownship.position.altitude_m,
            yaw_deg,
            pitch_deg,
            roll_deg,
        }
    }
}

impl From<&WeatherState> for WeatherOut {
    fn from(weather: &WeatherState) -> Self {
        Self { layers: weather.layers.iter().map(LayerOut::from).collect(), visibility_m: weather.visibility_m }
    }
}

impl From<&LayerState> for LayerOut {
    fn from(layer: &LayerState) -> Self {
        Self {
            cloud_type: layer.kind.into(),
            base_m: layer.base_m,
            thickness_m: layer.thickness_m,
            coverage: layer.coverage,
            density: layer.density,
            wind_speed_mps: layer.wind_speed_mps,
            wind_from_deg: layer.wind_from_deg,
        }
    }
}

impl From<&RegionState> for RegionOut {
    fn from(region: &RegionState) -> Self {
        Self { shape: (&region.shape).into(), weather: WeatherOut::from(&region.weather), presence: region.presence }
    }
}

impl From<&ViewState> for ViewOut {
    fn from(view: &ViewState) -> Self {
        let [yaw_deg, pitch_deg, roll_deg] = degrees(&view.attitude);
        Self {
            name: view.name.clone(),
            size_px: view.size_px,
            field_of_view_deg: view.field_of_view_deg,
            offset_m: view.offset_m,
            yaw_deg,
            pitch_deg,
            roll_deg,
            landing_light: view.lights.landing,
            strobe: view.lights.strobe,
            exposure_ev100: view.exposure.into(),
        }
    }
}

impl From<&FlashState> for FlashOut {
    fn from(flash: &FlashState) -> Self {
        Self {
            flash: flash.id,
            latitude_deg: deg(flash.position.latitude_rad),
            longitude_deg: deg(flash.position.longitude_rad),
            altitude_m: flash.position.altitude_m,
            flash_type: flash.kind.into(),
            polarity: flash.polarity.into(),
            begin_s: flash.begin_s,
            end_s: flash.end_s,
            intensity_cd: flash.intensity_cd,
            ground_points_m: flash.ground_points_m.clone(),
        }
    }
}

impl SkyOut {
    /// Sun and moon as seen from a place.
    pub fn seen_from(place: &Geodetic, sky: &SkyState) -> Self {
        let [sun_elevation_deg, sun_azimuth_deg] = elevation_azimuth_deg(place, sky.sun_direction_ecef);
        let [moon_elevation_deg, moon_azimuth_deg] = elevation_azimuth_deg(place, sky.moon_direction_ecef);
        let moon_lit_fraction = sky.moon_lit_fraction;
        Self { sun_elevation_deg, sun_azimuth_deg, moon_elevation_deg, moon_azimuth_deg, moon_lit_fraction }
    }
}

fn elevation_azimuth_deg(place: &Geodetic, direction_ecef: DVec3) -> [f64; 2] {
    let (sin_lat, cos_lat) = place.latitude_rad.sin_cos();
    let (sin_lon, cos_lon) = place.longitude_rad.sin_cos();
    let up = DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat);
    let north = DVec3::new(-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat);
    let east = DVec3::new(-sin_lon, cos_lon, 0.0);
    let elevation = direction_ecef.dot(up).clamp(-1.0, 1.0).asin();
    let azimuth = direction_ecef.dot(east).atan2(direction_ecef.dot(north)).rem_euclid(std::f64::consts::TAU);
    [deg(elevation), deg(azimuth)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_light_over_the_north_pole_stands_at_the_latitude_in_the_north() {
        let place = Geodetic { latitude_rad: 0.7, longitude_rad: -2.0, altitude_m: 0.0 };
        let [elevation, azimuth] = elevation_azimuth_deg(&place, DVec3::Z);
        // Rounding of f64 alone.
        assert!((elevation - deg(0.7)).abs() < 1e-12);
        assert!(azimuth.min(360.0 - azimuth) < 1e-12);
        let [_, east] = elevation_azimuth_deg(&place, DVec3::new(2f64.sin(), (-2f64).cos(), 0.0));
        assert!((east - 90.0).abs() < 1e-9, "a light due east has azimuth 90: {east}");
    }
}
