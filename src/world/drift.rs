//! Drift: where the wind has carried a layer's pattern. A wind is a rigid rotation about the Earth's centre.
//!
//! Places on the globe stand for the directions of their zeniths, as with charts. At a reference point P (unit vector) a
//! wind of velocity v at radius R turns the pattern with the angular velocity omega = P x v / R. A rotation leaves no seam
//! anywhere on the globe. While the wind is constant the drift is `exp(omega (t - t0)) R0`, evaluated directly from t0, so
//! that ten years in one go are as exact as ten seconds. From one wind to another it is
//! `exp(omega_new a) exp(omega_old b) R0`, with a and b the seconds of the new and of the old wind (closed integrals of the
//! easing): position and velocity are continuous through beginning and end.

use crate::geo::Geodetic;
use crate::geo::frames::enu;
use crate::geo::wgs84::MEAN_RADIUS_M;
use glam::{DQuat, DVec2, DVec3};

use super::ease::{Span, mix};

/// A wind as it is given: where, how fast, and from where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wind {
    /// The point at which speed and direction are meant.
    pub reference: Geodetic,
    /// Height above the mean sphere at which it blows.
    pub height_m: f64,
    /// Speed.
    pub speed_mps: f64,
    /// Direction that it comes from, clockwise from north.
    pub from_deg: f64,
}

impl Wind {
    /// Velocity over ground `[east, north]`: where it blows to.
    pub fn velocity_mps(&self) -> DVec2 {
        let (sin, cos) = self.from_deg.to_radians().sin_cos();
        DVec2::new(-sin, -cos) * self.speed_mps
    }

    /// Angular velocity of the pattern about the Earth's centre in rad/s, ECEF axes.
    pub fn angular_velocity(&self) -> DVec3 {
        let axes = enu(&self.reference);
        let velocity = self.velocity_mps();
        axes.z_axis.cross(axes.x_axis * velocity.x + axes.y_axis * velocity.y) / (MEAN_RADIUS_M + self.height_m)
    }
}

/// A pattern carried by a wind that may be changing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    start: DQuat,
    old_velocity_mps: DVec2,
    old_turn: DVec3,
    wind: Wind,
    turn: DVec3,
    span: Span,
}

impl Drift {
    /// A pattern that lies as it was made at `now_s` and is carried by `wind` from then on.
    pub fn new(wind: Wind, now_s: f64) -> Self {
        let turn = wind.angular_velocity();
        let span = Span { begin_s: now_s, length_s: 0.0 };
        Self { start: DQuat::IDENTITY, old_velocity_mps: wind.velocity_mps(), old_turn: turn, wind, turn, span }
    }

    /// The rotation that has brought the pattern to where it is.
    pub fn at(&self, now_s: f64) -> DQuat {
        // sin and cos reduce the angle exactly, so a thousand radians (ten years) cost only the rounding of the product.
        let (old_s, new_s) = self.span.seconds_of_old_and_new(now_s);
        let turned = DQuat::from_scaled_axis(self.turn * new_s) * DQuat::from_scaled_axis(self.old_turn * old_s);
        (turned * self.start).normalize()
    }

    /// Angular velocity now in rad/s, ECEF axes: the exact derivative of [`Drift::at`].
    pub fn turn_at(&self, now_s: f64) -> DVec3 {
        let weight = self.span.smooth(now_s);
        let (_, new_s) = self.span.seconds_of_old_and_new(now_s);
        self.turn * weight + DQuat::from_scaled_axis(self.turn * new_s) * self.old_turn * (1.0 - weight)
    }

    /// Speed and direction from which it blows, at the reference point; at rest exactly as they were given.
    pub fn wind_at(&self, now_s: f64) -> (f64, f64) {
        if self.span.done(now_s) {
            return (self.wind.speed_mps, self.wind.from_deg);
        }
        let velocity = self.velocity_at(now_s);
        (velocity.length(), (-velocity.x).atan2(-velocity.y).to_degrees().rem_euclid(360.0))
    }

    /// The wind that blows or is on its way.
    pub fn target(&self) -> &Wind {
        &self.wind
    }

    /// Turns to a new wind from the present one; the pattern goes on from where it is. The same wind again changes
    /// nothing, unless it is wanted sooner.
    pub fn aim(&mut self, wind: Wind, span: Span) {
        if wind == self.wind && span.end_s() >= self.span.end_s() {
            return;
        }
        let now_s = span.begin_s;
        *self = Self {
            start: self.at(now_s),
            old_velocity_mps: self.velocity_at(now_s),
            old_turn: self.turn_at(now_s),
            turn: wind.angular_velocity(),
            wind,
            span,
        };
    }

    fn velocity_at(&self, now_s: f64) -> DVec2 {
        let weight = self.span.smooth(now_s);
        let (old, new) = (self.old_velocity_mps, self.wind.velocity_mps());
        DVec2::new(mix(old.x, new.x, weight), mix(old.y, new.y, weight))
    }
}

#[cfg(test)]
mod tests;
