//! The state message: a snapshot and the player, in the units that people use.

use super::super::instant;
use super::super::names::{CloudType, FlashType, PolarityName};
use super::super::view::ExposureJson;
use crate::geo::{Attitude, Geodetic};
use crate::units::deg;
use crate::world::snapshot::{
    FlashState, LayerState, OwnshipState, RegionState, SkyState, Snapshot, ViewState, WeatherState,
};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The world at one moment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StateMessage {
    /// Number of the `query`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seq: Option<u64>,
    /// Number of the snapshot, rising.
    pub snapshot: u64,
    /// Frame number of the newest ownship message; 0 before the first.
    pub host_frame: u32,
    /// Simulation time.
    pub simulation_time_s: f64,
    /// Begin and end of the interval whose light a frame gathers.
    pub shutter_s: [f64; 2],
    /// Instant, RFC 3339.
    pub utc: String,
    /// Where the ownship is now.
    pub ownship: OwnshipOut,
    /// The global weather as it is now (in the middle of a transition: between old and new).
    pub weather: WeatherOut,
    /// Regions in the order in which they were made.
    pub regions: Vec<RegionOut>,
    /// The views, by name.
    pub views: Vec<ViewOut>,
    /// Flashes that shine or will soon.
    pub flashes: Vec<FlashOut>,
    /// Sun and moon, seen from the ownship.
    pub sky: SkyOut,
    /// Slices per cloud layer.
    pub slices: u32,
    /// Ratio between the radii of neighbouring billboard rings.
    pub ring_ratio: f64,
    /// The scenario player.
    pub player: Player,
}

/// Where the ownship is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OwnshipOut {
    /// WGS84 latitude.
    pub latitude_deg: f64,
    /// WGS84 longitude.
    pub longitude_deg: f64,
    /// Height above the ellipsoid.
    pub altitude_m: f64,
    /// Heading from true north.
    pub yaw_deg: f64,
    /// Nose up.
    pub pitch_deg: f64,
    /// Right wing down.
    pub roll_deg: f64,
}

/// Weather as it is now.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WeatherOut {
    /// Layers, lowest base first.
    pub layers: Vec<LayerOut>,
    /// Meteorological visibility at the ground.
    pub visibility_m: f64,
}

/// A layer as it is now.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LayerOut {
    /// Cloud type.
    pub cloud_type: CloudType,
    /// Base above the ellipsoid.
    pub base_m: f64,
    /// Top minus base.
    pub thickness_m: f64,
    /// Share of the sky hidden, 0 to 1.
    pub coverage: f64,
    /// Factor on the type's usual extinction.
    pub density: f64,
    /// Wind speed.
    pub wind_speed_mps: f64,
    /// Direction that the wind comes from.
    pub wind_from_deg: f64,
}

/// A region as it is now.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RegionOut {
    /// Outline.
    pub shape: super::super::region::RegionJson,
    /// Its own weather.
    pub weather: WeatherOut,
    /// 0 (not there) to 1 (fully there).
    pub presence: f64,
}

/// A view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ViewOut {
    /// Name.
    pub name: String,
    /// Width and height in pixels.
    pub size_px: [u32; 2],
    /// Horizontal field of view.
    pub field_of_view_deg: f64,
    /// Eye point in body axes, forward, right, down.
    pub offset_m: [f64; 3],
    /// Yaw against the body.
    pub yaw_deg: f64,
    /// Pitch against the body.
    pub pitch_deg: f64,
    /// Roll against the body.
    pub roll_deg: f64,
    /// Exposure value at ISO 100, or `"automatic"`.
    pub exposure_ev100: ExposureJson,
}

/// A flash.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FlashOut {
    /// Number.
    pub flash: u64,
    /// WGS84 latitude of the centre of its light.
    pub latitude_deg: f64,
    /// WGS84 longitude.
    pub longitude_deg: f64,
    /// Height above the ellipsoid.
    pub altitude_m: f64,
    /// Type.
    pub flash_type: FlashType,
    /// Polarity.
    pub polarity: PolarityName,
    /// Simulation time at which it begins.
    pub begin_s: f64,
    /// Simulation time at which its last light ends.
    pub end_s: f64,
    /// Mean luminous intensity over the shutter interval.
    pub intensity_cd: f64,
}

/// Sun and moon, seen from the ownship (without refraction).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SkyOut {
    /// Height of the sun above the horizontal plane.
    pub sun_elevation_deg: f64,
    /// Direction of the sun from true north.
    pub sun_azimuth_deg: f64,
    /// Height of the moon above the horizontal plane.
    pub moon_elevation_deg: f64,
    /// Direction of the moon from true north.
    pub moon_azimuth_deg: f64,
    /// Lit share of the moon's disc, 0 to 1.
    pub moon_lit_fraction: f64,
}

/// The scenario player.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Player {
    /// Name of the scenario loaded.
    pub scenario: Option<String>,
    /// Whether time runs.
    pub playing: bool,
    /// Seconds of simulation per second of wall clock.
    pub speed: f64,
    /// Simulation time at which the scenario ends.
    pub duration_s: Option<f64>,
}

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
            flashes: snapshot.flashes.iter().map(FlashOut::from).collect(),
            sky: SkyOut::seen_from(&snapshot.ownship.position, &snapshot.sky),
            slices: snapshot.quality.slices,
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
