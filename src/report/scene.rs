//! Scenes that subjects measure: one eye over the same place under weather of their own.

use super::subject::Stopped;
use crate::clouds::CloudKind;
use crate::frame::Pixels;
use crate::plan::{FramePlan, Output, plan};
use crate::reference::ReferenceExecutor;
use crate::world::World;
use crate::world::command::{Command, LayerSpec, Ownship, TimeEdit, WeatherEdit};
use crate::world::snapshot::{Quality, Snapshot};

/// A layer of a genus at half cover and usual density, without wind.
pub fn layer(kind: CloudKind, base_m: f64, thickness_m: f64) -> LayerSpec {
    LayerSpec { kind, base_m, thickness_m, coverage: 0.5, density: 1.0, wind_speed_mps: 0.0, wind_from_deg: 0.0 }
}

/// An eye at 47 N 8 E that looks north-east.
#[derive(Clone, Copy, Debug)]
pub struct EyePoint {
    /// Height above the ellipsoid.
    pub altitude_m: f64,
    /// Pitch, positive upwards.
    pub pitch_deg: f64,
    /// Width and height in pixels.
    pub size_px: [u32; 2],
    /// Horizontal field of view.
    pub field_of_view_deg: f64,
}

/// The world at an eye point under these layers, as the scenario's clock starts.
///
/// # Errors
/// [`Stopped::Failed`]: the world refused a layer.
pub fn snapshot(eye: EyePoint, layers: &[LayerSpec], quality: Quality) -> Result<Snapshot, Stopped> {
    snapshot_after(eye, layers, quality, 0.0)
}

/// The same after so many seconds of simulation.
///
/// # Errors
/// [`Stopped::Failed`]: the world refused a layer.
pub fn snapshot_after(
    eye: EyePoint,
    layers: &[LayerSpec],
    quality: Quality,
    after_s: f64,
) -> Result<Snapshot, Stopped> {
    taken(eye, layers, quality, None, after_s)
}

/// The same at another time of day.
///
/// # Errors
/// [`Stopped::Failed`]: the world refused a layer or the time.
pub fn snapshot_at(eye: EyePoint, layers: &[LayerSpec], quality: Quality, utc_s: f64) -> Result<Snapshot, Stopped> {
    taken(eye, layers, quality, Some(utc_s), 0.0)
}

fn taken(
    eye: EyePoint,
    layers: &[LayerSpec],
    quality: Quality,
    utc_s: Option<f64>,
    after_s: f64,
) -> Result<Snapshot, Stopped> {
    let mut world = World::new();
    world.set_quality(quality);
    let ownship = Ownship {
        latitude_deg: 47.0,
        longitude_deg: 8.0,
        altitude_m: eye.altitude_m,
        yaw_deg: 70.0,
        pitch_deg: eye.pitch_deg,
        roll_deg: 0.0,
        velocity_ned_mps: None,
        host_frame: 0,
    };
    let weather = WeatherEdit { layers: Some(layers.to_vec()), ..Default::default() };
    let time = TimeEdit { utc_s, rate: None };
    for command in [Command::Ownship(ownship), Command::Weather(weather), Command::Time(time)] {
        world.apply(command).map_err(|refused| Stopped::Failed(refused.to_string()))?;
    }
    world.advance_to(after_s);
    let mut snapshot = world.snapshot(1.0 / 60.0);
    for view in &mut snapshot.views {
        view.size_px = eye.size_px;
        view.field_of_view_deg = eye.field_of_view_deg;
    }
    Ok(snapshot)
}

/// The plan of the first view.
///
/// # Errors
/// [`Stopped::Failed`]: the snapshot has no view.
pub fn plan_of(snapshot: &Snapshot, output: Output) -> Result<FramePlan, Stopped> {
    let view = snapshot.views.first().ok_or_else(|| Stopped::Failed("the snapshot has no view".into()))?;
    Ok(plan(snapshot, view, output))
}

/// The 8-bit picture of a snapshot, drawn by the reference executor.
///
/// # Errors
/// As [`plan_of`].
pub fn picture(snapshot: &Snapshot, output: Output) -> Result<Pixels, Stopped> {
    Ok(ReferenceExecutor::new().draw(&plan_of(snapshot, output)?))
}
