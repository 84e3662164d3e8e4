//! Regions: rounded rectangles on the globe with their own weather, that fade in, move and fade out without a jump.

use crate::geo::Geodetic;
use crate::geo::frames::{Curvature, enu};
use crate::units::wrap_pi;
use glam::{DQuat, DVec2, DVec3};

use super::check;
use super::command::{RegionShape, WeatherEdit};
use super::ease::{Eased, Scale, Span, mix, smoothstep};
use super::event::Refused;
use super::limits;
use super::snapshot::RegionState;
use super::weather::Weather;

/// A region with its past and its future.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Region {
    old_shape: RegionShape,
    shape: RegionShape,
    span: Span,
    presence: Eased,
    weather: Weather,
}

impl Region {
    /// The region at a time not before its last edit.
    pub fn at(&self, now_s: f64) -> RegionState {
        RegionState {
            shape: self.shape_at(now_s),
            weather: self.weather.at(now_s),
            presence: self.presence.at(now_s),
            turning: self.weather.turning(now_s),
        }
    }

    /// Its own weather.
    pub fn weather(&self) -> &Weather {
        &self.weather
    }

    fn gone(&self, now_s: f64) -> bool {
        self.leaving() && self.presence.done(now_s)
    }

    /// Whether it is fading out.
    pub fn leaving(&self) -> bool {
        self.presence.target() == 0.0
    }

    fn shape_at(&self, now_s: f64) -> RegionShape {
        let (old, new) = (&self.old_shape, &self.shape);
        let weight = self.span.smooth(now_s);
        if weight >= 1.0 || old == new {
            return new.clone();
        }
        let (from, to) = (enu(&centre(old)).z_axis, enu(&centre(new)).z_axis);
        let there = DQuat::IDENTITY.slerp(DQuat::from_rotation_arc(from, to), weight) * from;
        let (latitude_deg, longitude_deg) = if weight <= 0.0 {
            (old.latitude_deg, old.longitude_deg)
        } else {
            (there.z.atan2(there.x.hypot(there.y)).to_degrees(), there.y.atan2(there.x).to_degrees())
        };
        let turn_deg = wrap_pi((new.rotation_deg - old.rotation_deg).to_radians()).to_degrees();
        RegionShape {
            name: new.name.clone(),
            latitude_deg,
            longitude_deg,
            size_east_m: mix(old.size_east_m, new.size_east_m, weight),
            size_north_m: mix(old.size_north_m, new.size_north_m, weight),
            corner_radius_m: mix(old.corner_radius_m, new.corner_radius_m, weight),
            rotation_deg: old.rotation_deg + turn_deg * weight,
            transition_m: mix(old.transition_m, new.transition_m, weight),
        }
    }
}

/// Makes or changes the region that `shape` names. A new one begins as a copy of the weather around it, changed at
/// once by the edit, and fades in over the edit's transition.
///
/// # Errors
/// [`Refused`], and nothing has changed: a value out of range, a bad name, too many regions, or as [`Weather::edit`].
pub(super) fn edit(
    regions: &mut Vec<Region>,
    shape: &RegionShape,
    edit: &WeatherEdit,
    around: &Weather,
    now_s: f64,
) -> Result<(), Refused> {
    check_shape(shape)?;
    check::within("transition_s", edit.transition_s, limits::TRANSITION_S)?;
    let span = Span { begin_s: now_s, length_s: edit.transition_s };
    let here = centre(shape);
    if let Some(region) = regions.iter_mut().find(|region| region.shape.name == shape.name && !region.gone(now_s)) {
        region.weather.edit(edit, &here, now_s)?;
        if *shape != region.shape || span.end_s() < region.span.end_s() {
            region.old_shape = region.shape_at(now_s);
            region.shape = shape.clone();
            region.span = span;
        }
        region.presence.aim(1.0, span);
        return Ok(());
    }
    let alive = regions.iter().filter(|region| !region.gone(now_s)).count();
    check::at_most("region", alive + 1, limits::MAX_REGIONS, "regions (those fading out count too)")?;
    let mut weather = around.clone();
    weather.edit(&WeatherEdit { transition_s: 0.0, ..edit.clone() }, &here, now_s)?;
    let mut presence = Eased::resting(0.0, Scale::Linear);
    presence.aim(1.0, span);
    regions.retain(|region| !region.gone(now_s));
    regions.push(Region { old_shape: shape.clone(), shape: shape.clone(), span, presence, weather });
    Ok(())
}

/// Fades a region out.
///
/// # Errors
/// [`Refused`] when there is none of that name (or it is fading out already), or the transition is out of range.
pub(super) fn remove(regions: &mut Vec<Region>, name: &str, transition_s: f64, now_s: f64) -> Result<(), Refused> {
    check::within("transition_s", transition_s, limits::TRANSITION_S)?;
    regions.retain(|region| !region.gone(now_s));
    match regions.iter_mut().find(|region| region.shape.name == name && !region.leaving()) {
        Some(region) => {
            region.presence.aim(0.0, Span { begin_s: now_s, length_s: transition_s });
            Ok(())
        }
        None => {
            let there: Vec<&str> =
                regions.iter().filter(|region| !region.leaving()).map(|region| region.shape.name.as_str()).collect();
            let limit =
                if there.is_empty() { "there is none".to_string() } else { format!("one of: {}", there.join(", ")) };
            Err(Refused::new("name", name, limit, "no such region"))
        }
    }
}

/// The regions at a time not before the last edit, in the order in which they were made.
pub(super) fn at(regions: &[Region], now_s: f64) -> Vec<RegionState> {
    regions.iter().filter(|region| !region.gone(now_s)).map(|region| region.at(now_s)).collect()
}

/// How much of a region's weather rules at a point: 1 inside its outline, 0 beyond its transition, smooth between.
///
/// Distances are measured around the region's centre (azimuthal equidistant) on the sphere that fits the Earth there.
pub fn weight_at(shape: &RegionShape, point: &Geodetic) -> f64 {
    let outside_m = signed_distance_m(shape, point);
    if outside_m <= 0.0 {
        1.0
    } else if outside_m >= shape.transition_m {
        0.0
    } else {
        1.0 - smoothstep(outside_m / shape.transition_m)
    }
}

/// Distance of a point from the outline over ground: negative inside.
pub fn signed_distance_m(shape: &RegionShape, point: &Geodetic) -> f64 {
    let centre = centre(shape);
    let local: DVec3 = enu(&centre).transpose() * enu(point).z_axis;
    let level = DVec2::new(local.x, local.y);
    let distance_m = level.length().atan2(local.z) * Curvature::at(centre.latitude_rad).mean_m();
    let flat = level.normalize_or_zero() * distance_m;
    let (sin, cos) = shape.rotation_deg.to_radians().sin_cos();
    let turned = DVec2::new(flat.x * cos - flat.y * sin, flat.x * sin + flat.y * cos);
    let half = DVec2::new(shape.size_east_m, shape.size_north_m) / 2.0;
    let beyond = turned.abs() - half + shape.corner_radius_m;
    beyond.max(DVec2::ZERO).length() + beyond.max_element().min(0.0) - shape.corner_radius_m
}

fn centre(shape: &RegionShape) -> Geodetic {
    Geodetic {
        latitude_rad: shape.latitude_deg.to_radians(),
        longitude_rad: shape.longitude_deg.to_radians(),
        altitude_m: 0.0,
    }
}

fn check_shape(shape: &RegionShape) -> Result<(), Refused> {
    check::name("region.name", &shape.name)?;
    for (field, value, limit) in [
        ("region.latitude_deg", shape.latitude_deg, limits::LATITUDE_DEG),
        ("region.longitude_deg", shape.longitude_deg, limits::LONGITUDE_DEG),
        ("region.size_east_m", shape.size_east_m, limits::REGION_SIZE_M),
        ("region.size_north_m", shape.size_north_m, limits::REGION_SIZE_M),
        ("region.rotation_deg", shape.rotation_deg, limits::TURN_DEG),
        ("region.transition_m", shape.transition_m, limits::REGION_TRANSITION_M),
    ] {
        check::within(field, value, limit)?;
    }
    let most_m = shape.size_east_m.min(shape.size_north_m) / 2.0;
    check::within("region.corner_radius_m", shape.corner_radius_m, [0.0, most_m])
}

#[cfg(test)]
mod tests;
