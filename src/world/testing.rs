//! Commands that tests begin from and change in the one thing that they are about.

use super::command::{Command, FlashKind, LayerSpec, Ownship, Polarity, StrikeRequest, Strokes, TimeEdit};
use crate::clouds::CloudKind;

/// An eye 600 m over 47 N 8 E that looks north, level, at rest.
pub const EYE: Ownship = Ownship {
    latitude_deg: 47.0,
    longitude_deg: 8.0,
    altitude_m: 600.0,
    yaw_deg: 0.0,
    pitch_deg: 0.0,
    roll_deg: 0.0,
    velocity_ned_mps: None,
    host_frame: 1,
};

/// Cumulus from 1000 to 2200 m, half cover, in a light wind from the west.
pub const CUMULUS: LayerSpec = LayerSpec {
    kind: CloudKind::Cumulus,
    base_m: 1_000.0,
    thickness_m: 1_200.0,
    coverage: 0.5,
    density: 1.0,
    wind_speed_mps: 5.0,
    wind_from_deg: 270.0,
};

/// A strike to ground two kilometres north of the eye, at once.
pub const STRIKE: StrikeRequest = StrikeRequest {
    latitude_deg: 47.02,
    longitude_deg: 8.0,
    altitude_m: None,
    at_s: None,
    kind: FlashKind::CloudToGround,
    polarity: Polarity::Negative,
    peak_current_ka: Some(30.0),
    strokes: Strokes::Sample,
    leader: false,
    seed: 3,
};

/// 2026-06-21T23:00:00Z, where the clock then stands: over the eye it is night.
pub const NIGHT: Command = Command::Time(TimeEdit { utc_s: Some(1_782_082_800.0), rate: Some(0.0) });
