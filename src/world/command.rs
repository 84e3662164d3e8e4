//! Commands: everything that can change the world, in plain types with units in the names.
//!
//! A command has passed the limits of the wire (finite, in range); the world still refuses what contradicts its state
//! (an unknown view, a layer over another). Angles are degrees here because they come from and go back to people.

use crate::clouds::CloudKind;
use std::sync::Arc;

use super::timeline::Timeline;

pub use crate::lightning::flash::{FlashKind, Polarity, StrokeSpec};

/// One change of the world.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Where the ownship is.
    Ownship(Ownship),
    /// Where another entity is that may carry views; `None`: it is gone, and its views are the ownship's again.
    Entity {
        /// Its number, not 0, which is the ownship.
        id: u16,
        /// Where it is.
        place: Option<Ownship>,
    },
    /// What is seen in the sky beside the clouds.
    Sky(SkyEdit),
    /// New or changed weather, global or of one region.
    Weather(WeatherEdit),
    /// Removes a region and its weather, easing out.
    RemoveRegion {
        /// The region's name.
        name: String,
        /// Seconds over which it fades.
        transition_s: f64,
    },
    /// Date, time of day and the rate at which it runs.
    Time(TimeEdit),
    /// Makes a view or changes what is given of an existing one.
    View(ViewEdit),
    /// Removes a view.
    RemoveView {
        /// The view's name.
        name: String,
    },
    /// Lightning strikes.
    Strike(StrikeRequest),
    /// Begins a storm, or changes the one of that name.
    Storm(StormRequest),
    /// Ends a storm; flashes under way go on.
    RemoveStorm {
        /// The storm's name.
        name: String,
    },
    /// Loads, plays, pauses, seeks or speeds up a scenario.
    Scenario(ScenarioEdit),
}

/// Position, attitude and motion of the ownship.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ownship {
    /// WGS84 geodetic latitude, -90 to 90.
    pub latitude_deg: f64,
    /// WGS84 longitude, -180 to 180.
    pub longitude_deg: f64,
    /// Height above the WGS84 ellipsoid.
    pub altitude_m: f64,
    /// Heading of the nose from true north, clockwise seen from above.
    pub yaw_deg: f64,
    /// Nose above the horizon, -90 to 90.
    pub pitch_deg: f64,
    /// Right wing down is positive.
    pub roll_deg: f64,
    /// Velocity over ground `[north, east, down]` in m/s for extrapolation; `None`: the ownship stands still between messages.
    pub velocity_ned_mps: Option<[f64; 3]>,
    /// The host's own frame number, echoed in every frame that shows this message.
    pub host_frame: u32,
}

/// A full description of one cloud layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerSpec {
    /// Cloud type.
    pub kind: CloudKind,
    /// Height of the base above the ellipsoid.
    pub base_m: f64,
    /// Top minus base, positive.
    pub thickness_m: f64,
    /// Share of the sky hidden, 0 to 1.
    pub coverage: f64,
    /// Factor on the type's usual extinction (deck paper eq. 16, D); 1 is usual.
    pub density: f64,
    /// Wind speed.
    pub wind_speed_mps: f64,
    /// Direction that the wind comes from, from true north, clockwise.
    pub wind_from_deg: f64,
}

/// A change of one existing layer: what is `None` stays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LayerChange {
    /// Which layer, counted from the lowest base, from 0.
    pub index: usize,
    /// New type.
    pub kind: Option<CloudKind>,
    /// New base above the ellipsoid.
    pub base_m: Option<f64>,
    /// New thickness.
    pub thickness_m: Option<f64>,
    /// New coverage, 0 to 1.
    pub coverage: Option<f64>,
    /// New density factor.
    pub density: Option<f64>,
    /// New wind speed.
    pub wind_speed_mps: Option<f64>,
    /// New wind direction.
    pub wind_from_deg: Option<f64>,
}

/// A rounded rectangle on the globe.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionShape {
    /// Name by which later messages mean the same region.
    pub name: String,
    /// Centre, WGS84.
    pub latitude_deg: f64,
    /// Centre, WGS84.
    pub longitude_deg: f64,
    /// Full size across before rotation (towards east at rotation 0).
    pub size_east_m: f64,
    /// Full size along before rotation (towards north at rotation 0).
    pub size_north_m: f64,
    /// Radius of the rounded corners, at most half the smaller size.
    pub corner_radius_m: f64,
    /// Rotation clockwise seen from above.
    pub rotation_deg: f64,
    /// Width outside the outline over which the weather goes over into the surroundings.
    pub transition_m: f64,
}

/// Weather edits that land together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WeatherEdit {
    /// `None`: the global weather.
    pub region: Option<RegionShape>,
    /// Replaces the whole list of layers (up to eight).
    pub layers: Option<Vec<LayerSpec>>,
    /// Changes single layers, after `layers` has been applied.
    pub changes: Vec<LayerChange>,
    /// Meteorological visibility at the ground (5 % contrast).
    pub visibility_m: Option<f64>,
    /// Seconds over which the old weather eases into the new one.
    pub transition_s: f64,
}

/// A new clock setting: what is `None` stays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TimeEdit {
    /// Seconds since 1970-01-01T00:00:00 UTC (leap seconds not counted).
    pub utc_s: Option<f64>,
    /// Seconds of UTC per second of simulation; 0 stops the sun.
    pub rate: Option<f64>,
}

/// Which lights of the sky there are: what is `None` stays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SkyEdit {
    /// Whether the sun shines.
    pub sun: Option<bool>,
    /// Whether the moon shines.
    pub moon: Option<bool>,
    /// Light of the stars, 0 (none) to 1 (as it is).
    pub starlight: Option<f64>,
}

/// The sides of a picture as angles from its axis: left and bottom are normally negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frustum {
    /// Left side, less than the right one.
    pub left_deg: f64,
    /// Right side.
    pub right_deg: f64,
    /// Upper side.
    pub top_deg: f64,
    /// Lower side, less than the upper one.
    pub bottom_deg: f64,
}

/// Automatic or fixed exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// From the scene's illuminance, a function of the snapshot.
    Automatic,
    /// Exposure value at ISO 100.
    Ev100(f64),
}

/// Whether a view is made or changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ViewAction {
    /// Makes a view: refused when the name is taken.
    #[default]
    Create,
    /// Changes a view: refused when there is none of that name.
    Change,
}

/// A new view (everything but the name has a default) or a change of one (what is `None` stays).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ViewEdit {
    /// Make or change.
    pub action: ViewAction,
    /// Name: letters, digits, `-` and `_`.
    pub name: String,
    /// Width and height in pixels.
    pub size_px: Option<[u32; 2]>,
    /// Horizontal field of view.
    pub field_of_view_deg: Option<f64>,
    /// Eye point in body axes `[forward, right, down]`.
    pub offset_m: Option<[f64; 3]>,
    /// Attitude of the view against the body.
    pub yaw_deg: Option<f64>,
    /// Attitude of the view against the body.
    pub pitch_deg: Option<f64>,
    /// Attitude of the view against the body.
    pub roll_deg: Option<f64>,
    /// Exposure.
    pub exposure: Option<Exposure>,
    /// Whether the own ship's landing lights shine.
    pub landing_light: Option<bool>,
    /// Whether its strobes flash.
    pub strobe: Option<bool>,
    /// The sides of the picture, in place of the field of view; the picture fills them whatever its size in pixels.
    pub frustum: Option<Frustum>,
    /// Whether the picture is mirrored, left to right and top to bottom.
    pub mirror: Option<[bool; 2]>,
    /// The entity that carries the view; 0 is the ownship.
    pub entity: Option<u16>,
}

/// Strokes of a flash.
#[derive(Clone, Debug, PartialEq)]
pub enum Strokes {
    /// Number, intervals and currents drawn from the published distributions by the seed.
    Sample,
    /// Given one by one, in rising order of delay.
    Given(Vec<StrokeSpec>),
}

/// A flash that is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct StrikeRequest {
    /// Place, WGS84.
    pub latitude_deg: f64,
    /// Place, WGS84.
    pub longitude_deg: f64,
    /// Height of the light's centre above the ellipsoid; `None`: in the lowest cloud layer, or 2000 m when there is none.
    pub altitude_m: Option<f64>,
    /// Simulation time, not in the past; `None`: now, which is the beginning of the next picture's shutter interval (in a
    /// scenario: the entry's own time).
    pub at_s: Option<f64>,
    /// Type.
    pub kind: FlashKind,
    /// Polarity.
    pub polarity: Polarity,
    /// Peak current of the first stroke; `None`: drawn by the seed.
    pub peak_current_ka: Option<f64>,
    /// Strokes.
    pub strokes: Strokes,
    /// Whether the flash begins with its stepped leader, faintly, and not with its first return stroke.
    pub leader: bool,
    /// Seed of everything that is drawn by chance.
    pub seed: u64,
}

/// A storm: a seeded schedule of flashes over a rounded rectangle of ground.
#[derive(Clone, Debug, PartialEq)]
pub struct StormRequest {
    /// Name by which later messages mean the same storm.
    pub name: String,
    /// Centre, WGS84.
    pub latitude_deg: f64,
    /// Centre, WGS84.
    pub longitude_deg: f64,
    /// Full size towards east before rotation.
    pub size_east_m: f64,
    /// Full size towards north before rotation.
    pub size_north_m: f64,
    /// Radius of the rounded corners, at most half the smaller size.
    pub corner_radius_m: f64,
    /// Rotation clockwise seen from above.
    pub rotation_deg: f64,
    /// Height of the flashes' light above the ellipsoid; `None`: as for a [`StrikeRequest`].
    pub altitude_m: Option<f64>,
    /// Mean rate; the flashes come in bursts.
    pub flashes_per_minute: f64,
    /// Share of the flashes that do not come to the ground.
    pub inside_share: f64,
    /// Share of the flashes to ground that are positive.
    pub positive_share: f64,
    /// Factor on the peak currents of the published distributions.
    pub current_factor: f64,
    /// Seed of the schedule.
    pub seed: u64,
}

/// What is asked of the scenario player.
#[derive(Clone, Debug, PartialEq)]
pub enum ScenarioEdit {
    /// Replaces the world by the scenario's start and plays it.
    Load(Arc<Timeline>),
    /// Lets the time run.
    Play,
    /// Stops the time.
    Pause,
    /// Goes to a simulation time, forwards or backwards.
    Seek {
        /// Simulation time in seconds, at least 0.
        at_s: f64,
    },
    /// Seconds of simulation per second of wall clock.
    Speed {
        /// Factor, 0 to the limit.
        factor: f64,
    },
}
