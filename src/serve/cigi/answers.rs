//! Answers to a host's questions, each a packet for the next Start of Frame.

use crate::geo::Geodetic;
use crate::geo::frames::ecef_from_body;
use crate::geo::wgs84::to_ecef;
use crate::outputs::air::Air;
use crate::outputs::conditions::conditions;
use crate::outputs::ground::{self, Surfaces, hat_hot};
use crate::outputs::sight::{Hider, Ray, Sight, sight};
use crate::units::deg;
use crate::wire::cigi::packets::{
    AerosolConcentrationResponse, EnvironmentalConditionsRequest, HatHotExtendedResponse, HatHotRequest,
    HatHotResponse, LineOfSightExtendedResponse, LineOfSightResponse, LineOfSightSegmentRequest,
    LineOfSightVectorRequest, Packet, WeatherConditionsResponse,
};
use crate::wire::cigi::scene::{Entities, half_turn};
use crate::wire::limits::SIGHT_RANGE_M;
use crate::world::snapshot::Snapshot;
use glam::DVec3;

/// The bit of a material in `material_mask`: code 1 is the lowest.
const fn bit(material: u32) -> u32 {
    1 << (material - 1)
}

/// What answers depend on.
pub struct Known {
    /// The world.
    pub snapshot: std::sync::Arc<Snapshot>,
    /// Where the host's entities are.
    pub entities: Entities,
    /// What it has said of the air.
    pub air: Air,
    /// Low four bits of its frame number.
    pub host_frame_number_lsn: u8,
}

impl Known {
    /// The answers to a question.
    pub fn answer(&self, question: &Packet) -> Vec<Packet> {
        match question {
            Packet::HatHotRequest(request) => vec![self.heights(request)],
            Packet::LineOfSightSegmentRequest(request) => vec![self.segment(request)],
            Packet::LineOfSightVectorRequest(request) => vec![self.vector(request)],
            Packet::EnvironmentalConditionsRequest(request) => self.weather(request),
            _ => Vec::new(),
        }
    }

    /// A point given above mean sea level, or in an entity's axes; `None`: there is no such place.
    fn point(&self, in_entity: bool, entity: u16, at: [f64; 3]) -> Option<Geodetic> {
        let [latitude_deg, longitude_deg, _] = at;
        let found = match in_entity {
            true => self.entities.point(entity, at),
            false if latitude_deg.abs() > 90.0 || longitude_deg.abs() > 360.0 => None,
            false => Some(self.entities.geodetic(at)),
        };
        // What the world's ownship may not reach has no weather and no ground to be told of.
        let [lowest_m, highest_m] = crate::world::limits::OWNSHIP_ALTITUDE_M;
        found.filter(|point| (lowest_m..=highest_m).contains(&point.altitude_m))
    }

    fn heights(&self, request: &HatHotRequest) -> Packet {
        const HOT: u8 = 1;
        const EXTENDED: u8 = 2;
        let at = [request.lat_xoff, request.lon_yoff, request.alt_zoff];
        let found = self
            .point(request.coordinate_system, request.entity_id, at)
            .and_then(|point| hat_hot(&self.snapshot.terrain, &point));
        let (hat_hot_id, host_frame_number_lsn) = (request.hat_hot_id, self.host_frame_number_lsn);
        let above_sea_level = |height_m: f64| height_m - self.air.sea_level_m;
        if request.request_type >= EXTENDED {
            let empty = HatHotExtendedResponse { hat_hot_id, host_frame_number_lsn, ..Default::default() };
            return match found {
                Some(found) if request.request_type == EXTENDED => HatHotExtendedResponse {
                    valid: true,
                    hat: found.hat_m,
                    hot: above_sea_level(found.hot_m),
                    material_code: found.material,
                    normal_vector_azimuth: half_turn(found.normal_azimuth_deg) as f32,
                    normal_vector_elevation: found.normal_elevation_deg as f32,
                    ..empty
                },
                _ => empty,
            }
            .into();
        }
        let response_type = request.request_type == HOT;
        let height = |found: &ground::HatHot| if response_type { above_sea_level(found.hot_m) } else { found.hat_m };
        HatHotResponse {
            hat_hot_id,
            valid: found.is_some(),
            response_type,
            host_frame_number_lsn,
            height: found.as_ref().map_or(0.0, height),
        }
        .into()
    }

    fn segment(&self, request: &LineOfSightSegmentRequest) -> Packet {
        let source = [request.source_lat_xoff, request.source_lon_yoff, request.source_alt_zoff];
        let from = self.point(request.source_point_coordinate_system, request.source_entity_id, source);
        let other = request.destination_entity_id_valid;
        let carrier = if other { request.destination_entity_id } else { request.source_entity_id };
        let destination = [request.destination_lat_xoff, request.destination_lon_yoff, request.destination_alt_zoff];
        let to = self.point(request.destination_point_coordinate_system, carrier, destination);
        let ray = from.zip(to).map(|(from, to)| Ray::between(from, &to)).filter(|ray| ray.to_m <= SIGHT_RANGE_M.max);
        let found = ray.map(|ray| self.follow(ray, request.alpha_threshold, request.material_mask));
        let geodetic = !request.response_coordinate_system;
        let asked = Asked { los_id: request.los_id, segment: true, geodetic, entity: request.source_entity_id };
        self.seen(&asked, request.request_type, found)
    }

    fn vector(&self, request: &LineOfSightVectorRequest) -> Packet {
        let source = [request.source_lat_xoff, request.source_lon_yoff, request.source_alt_zoff];
        let from = self.point(request.source_point_coordinate_system, request.entity_id, source);
        let (azimuth, elevation) = (f64::from(request.azimuth).to_radians(), f64::from(request.elevation).to_radians());
        let (nearest, farthest) = (f64::from(request.minimum_range), f64::from(request.maximum_range));
        let sane = nearest >= 0.0 && farthest > nearest && f64::from(request.elevation).abs() <= 90.0;
        let ray = from.filter(|_| sane).and_then(|from| {
            let ray = Ray::towards(from, azimuth, elevation, nearest, farthest.min(SIGHT_RANGE_M.max));
            if !request.source_point_coordinate_system {
                return Some(ray);
            }
            let pose = self.entities.pose(request.entity_id)?;
            let level = elevation.cos();
            // Forward, right, down.
            let local = DVec3::new(level * azimuth.cos(), level * azimuth.sin(), -elevation.sin());
            let direction = (ecef_from_body(&pose.position, &pose.attitude) * local).normalize();
            Some(Ray { direction, ..ray })
        });
        let found = ray.map(|ray| self.follow(ray, request.alpha_threshold, request.material_mask));
        // A ray that meets nothing has no answer.
        let found = found.filter(|found| found.hider.is_some());
        let geodetic = !request.response_coordinate_system;
        let asked = Asked { los_id: request.los_id, segment: false, geodetic, entity: request.entity_id };
        self.seen(&asked, request.request_type, found)
    }

    fn follow(&self, ray: Ray, alpha_threshold: u8, material_mask: u32) -> Sight {
        // A mask of 0 says nothing of materials: all of them hide.
        let material_mask = if material_mask == 0 { u32::MAX } else { material_mask };
        let hides = |material: u32| material_mask & bit(material) != 0;
        let opaque = hides(ground::MATERIAL_CLOUD).then_some(f64::from(alpha_threshold) / 255.0);
        let surfaces = Surfaces { land: hides(ground::MATERIAL_LAND), water: hides(ground::MATERIAL_WATER) };
        sight(&self.snapshot, &Ray { opaque, surfaces, ..ray })
    }

    fn seen(&self, asked: &Asked, extended: bool, found: Option<Sight>) -> Packet {
        let (los_id, host_frame_number_lsn) = (asked.los_id, self.host_frame_number_lsn);
        let visible = asked.segment && found.is_some_and(|found| found.hider.is_none());
        let valid = found.is_some();
        let range = found.map_or(0.0, |found| found.range_m);
        if !extended {
            return LineOfSightResponse {
                los_id,
                valid,
                visible,
                host_frame_number_lsn,
                response_count: 1,
                range,
                ..Default::default()
            }
            .into();
        }
        let empty = LineOfSightExtendedResponse {
            los_id,
            host_frame_number_lsn,
            response_count: 1,
            alpha: 0,
            ..Default::default()
        };
        let Some(found) = found else { return empty.into() };
        let Some([lat_xoff, lon_yoff, alt_zoff]) = self.told(&found.point, asked) else { return empty.into() };
        let met = hat_hot(&self.snapshot.terrain, &found.point).filter(|_| found.hider == Some(Hider::Ground));
        let (material_code, [red, green, blue]) = match found.hider {
            // The usual albedo of land and water as a colour; clouds are white, and have no surface.
            Some(Hider::Ground) => match met.map_or(ground::MATERIAL_LAND, |met| met.material) {
                ground::MATERIAL_WATER => (ground::MATERIAL_WATER, [16, 28, 40]),
                material => (material, [92, 96, 72]),
            },
            Some(Hider::Cloud) => (ground::MATERIAL_CLOUD, [255; 3]),
            None => (0, [0; 3]),
        };
        LineOfSightExtendedResponse {
            valid,
            range_valid: true,
            visible,
            range,
            lat_xoff,
            lon_yoff,
            alt_zoff,
            red,
            green,
            blue,
            alpha: if found.hider == Some(Hider::Ground) { 255 } else { (found.opacity * 255.0).round() as u8 },
            material_code,
            normal_vector_azimuth: met.map_or(0.0, |met| half_turn(met.normal_azimuth_deg) as f32),
            normal_vector_elevation: met.map_or(0.0, |met| met.normal_elevation_deg as f32),
            ..empty
        }
        .into()
    }

    /// A point as the host wants it: above mean sea level, or in the axes of the entity that asked.
    fn told(&self, point: &Geodetic, asked: &Asked) -> Option<[f64; 3]> {
        if asked.geodetic {
            let altitude = point.altitude_m - self.air.sea_level_m;
            return Some([deg(point.latitude_rad), deg(point.longitude_rad), altitude]);
        }
        let pose = self.entities.pose(asked.entity)?;
        let axes = ecef_from_body(&pose.position, &pose.attitude);
        Some((axes.transpose() * (to_ecef(point) - to_ecef(&pose.position))).into())
    }

    fn weather(&self, request: &EnvironmentalConditionsRequest) -> Vec<Packet> {
        const WEATHER: u8 = 4;
        const AEROSOL: u8 = 8;
        let at = [request.latitude, request.longitude, request.altitude];
        let Some(point) = self.point(false, 0, at).filter(|_| request.request_type & (WEATHER | AEROSOL) != 0) else {
            return Vec::new();
        };
        let found = conditions(&self.snapshot, &self.air, &point);
        let request_id = request.request_id;
        let mut answers = Vec::new();
        if request.request_type & WEATHER != 0 {
            answers.push(
                WeatherConditionsResponse {
                    request_id,
                    humidity: found.air.humidity_percent.round().clamp(0.0, 100.0) as u8,
                    air_temperature: found.air.temperature_c as f32,
                    visibility_range: found.visibility_m as f32,
                    horizontal_wind_speed: found.air.wind_speed_mps as f32,
                    vertical_wind_speed: found.air.updraft_mps as f32,
                    wind_direction: found.air.wind_from_deg as f32,
                    barometric_pressure: found.air.pressure_hpa as f32,
                }
                .into(),
            );
        }
        if request.request_type & AEROSOL != 0 {
            answers.extend(found.aerosols.into_iter().map(|(layer_id, concentration)| {
                let aerosol_concentration = concentration as f32;
                Packet::from(AerosolConcentrationResponse { request_id, layer_id, aerosol_concentration })
            }));
        }
        answers
    }
}

/// What an answer to a line of sight depends on beside what was found.
struct Asked {
    los_id: u16,
    segment: bool,
    geodetic: bool,
    entity: u16,
}

#[cfg(test)]
mod tests;
