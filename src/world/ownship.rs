//! The ownship between two messages of its host: carried on by its velocity for a stated time, then held.

use crate::geo::frames::{ENU_NED, attitude_of, ecef_from_body, enu};
use crate::geo::wgs84::{from_ecef, to_ecef};
use crate::geo::{Attitude, Geodetic};
use glam::{DQuat, DVec3};

use super::check;
use super::command::Ownship;
use super::event::Refused;
use super::limits;
use super::snapshot::OwnshipState;

/// The newest message and when it came.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LastKnown {
    message: Ownship,
    received_s: f64,
}

impl Default for LastKnown {
    fn default() -> Self {
        let message = Ownship {
            latitude_deg: 47.0,
            longitude_deg: 8.0,
            altitude_m: 1_500.0,
            yaw_deg: 0.0,
            pitch_deg: 0.0,
            roll_deg: 0.0,
            velocity_ned_mps: None,
            host_frame: 0,
        };
        Self { message, received_s: 0.0 }
    }
}

impl LastKnown {
    /// Takes a message.
    ///
    /// # Errors
    /// [`Refused`] for a value out of range or not finite.
    pub fn new(message: &Ownship, received_s: f64) -> Result<Self, Refused> {
        check::within("latitude_deg", message.latitude_deg, limits::LATITUDE_DEG)?;
        check::within("longitude_deg", message.longitude_deg, limits::LONGITUDE_DEG)?;
        check::within("altitude_m", message.altitude_m, limits::OWNSHIP_ALTITUDE_M)?;
        check::within("yaw_deg", message.yaw_deg, limits::TURN_DEG)?;
        check::within("pitch_deg", message.pitch_deg, limits::PITCH_DEG)?;
        check::within("roll_deg", message.roll_deg, limits::TURN_DEG)?;
        for (index, component) in message.velocity_ned_mps.iter().flatten().enumerate() {
            check::within(&format!("velocity_ned_mps[{index}]"), *component, limits::VELOCITY_MPS)?;
        }
        Ok(Self { message: *message, received_s })
    }

    /// The host's frame number.
    pub fn host_frame(&self) -> u32 {
        self.message.host_frame
    }

    /// Position and attitude at a time not before the message.
    ///
    /// The ownship moves straight on in ECEF (no pole and no meridian is special there) at its own rate of climb, and
    /// keeps its attitude against the local vertical: flying north over the pole, it flies south afterwards.
    pub fn at(&self, now_s: f64) -> OwnshipState {
        let message = &self.message;
        let position = Geodetic {
            latitude_rad: message.latitude_deg.to_radians(),
            longitude_rad: message.longitude_deg.to_radians(),
            altitude_m: message.altitude_m,
        };
        let attitude = Attitude {
            yaw_rad: message.yaw_deg.to_radians(),
            pitch_rad: message.pitch_deg.to_radians(),
            roll_rad: message.roll_deg.to_radians(),
        };
        let flown_s = (now_s - self.received_s).clamp(0.0, limits::EXTRAPOLATION_LIMIT_S);
        let Some(velocity) = message.velocity_ned_mps.filter(|_| flown_s > 0.0) else {
            return OwnshipState { position, attitude };
        };
        let [north, east, down] = velocity;
        let axes = enu(&position);
        let level = axes * DVec3::new(east, north, 0.0);
        let mut there = from_ecef(to_ecef(&position) + level * flown_s);
        there.altitude_m = position.altitude_m - down * flown_s;
        let new_axes = enu(&there);
        let tilt = DQuat::from_rotation_arc(axes.z_axis, new_axes.z_axis);
        let body = glam::DMat3::from_quat(tilt) * ecef_from_body(&position, &attitude);
        OwnshipState { position: there, attitude: attitude_of(&(ENU_NED * new_axes.transpose() * body)) }
    }
}

#[cfg(test)]
mod tests;
