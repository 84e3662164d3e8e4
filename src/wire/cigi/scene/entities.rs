//! Entities: where each is, whether on its own or attached to another, and how it moves between messages.

use super::{Moment, half_turn};
use crate::geo::frames::{ENU_NED, attitude_of, ecef_from_body, enu, ned_from_body};
use crate::geo::terrain::Terrain;
use crate::geo::wgs84::{from_ecef, to_ecef};
use crate::geo::{Attitude, Geodetic};
use crate::wire::cigi::packets::{EntityControl, EntityPosition, EntityState};
use crate::wire::limits::CIGI_ENTITIES;
use crate::world::command::{Command, Ownship};
use crate::world::event::Refused;
use crate::world::limits::{LATITUDE_DEG, PITCH_DEG, VELOCITY_MPS};
use glam::{DMat3, DQuat, DVec3};
use std::collections::{BTreeMap, BTreeSet};

/// Deepest chain of attachments that is followed; a longer one, or a circle, leaves the entity where it was.
const MOST_PARENTS: usize = 8;
/// Positions farther apart in time than this say nothing of the motion now.
const MOTION_S: f64 = 1.0;
/// Length of a tick of a time stamp.
const TICK_S: f64 = 1e-5;
/// `entity_state` of an entity that is destroyed.
const DESTROYED: u8 = 2;

/// `ground_ocean_clamp` of an entity that lies along the ground.
const CONFORMAL: u8 = 2;

/// The ownship's number.
pub const OWNSHIP: u16 = 0;

/// All entities.
#[derive(Clone, Debug)]
pub struct Entities {
    sea_level_m: f64,
    terrain: Terrain,
    known: BTreeMap<u16, Entity>,
    /// Those of which the world is to hear.
    changed: BTreeSet<u16>,
    gone: Vec<u16>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Entity {
    placed: Option<Place>,
    extrapolate: bool,
    /// Where it was at the last message with a valid time stamp, ECEF.
    last: Option<(DVec3, u32)>,
    velocity_mps: Option<DVec3>,
}

/// As the host has put it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    parent: Option<u16>,
    clamp: u8,
    attitude: Attitude,
    /// Latitude, longitude, altitude in degrees and metres above mean sea level; or an offset in the parent's body axes.
    at: [f64; 3],
}

/// Position and attitude, however the host gave them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Position above the ellipsoid.
    pub position: Geodetic,
    /// Attitude against the local north, east, down.
    pub attitude: Attitude,
}

impl Entities {
    /// None yet.
    pub fn new(sea_level_m: f64, terrain: Terrain) -> Self {
        Self { sea_level_m, terrain, known: BTreeMap::new(), changed: BTreeSet::new(), gone: Vec::new() }
    }

    /// Entity Control of CIGI 3.3.
    ///
    /// # Errors
    /// [`Refused`]: too many entities.
    pub fn control(&mut self, packet: &EntityControl, moment: &Moment) -> Result<(), Refused> {
        self.exist(packet.entity_id, packet.entity_state, packet.linear_extrapolation_interpolation_enable)?;
        if packet.entity_state != DESTROYED {
            let place = Place {
                parent: packet.attach_state.then_some(packet.parent_id),
                clamp: packet.ground_ocean_clamp,
                attitude: attitude([packet.yaw, packet.pitch, packet.roll]),
                at: [packet.lat_xoff, packet.lon_yoff, packet.alt_zoff],
            };
            self.place(packet.entity_id, place, moment)?;
        }
        Ok(())
    }

    /// Entity Control of CIGI 4.0.
    ///
    /// # Errors
    /// As [`Self::control`].
    pub fn state(&mut self, packet: &EntityState) -> Result<(), Refused> {
        self.exist(packet.entity_id, packet.entity_state, packet.linear_extrapolation_interpolation_enable)
    }

    /// Entity Position of CIGI 4.0.
    ///
    /// # Errors
    /// As [`Self::control`].
    pub fn position(&mut self, packet: &EntityPosition, moment: &Moment) -> Result<(), Refused> {
        let place = Place {
            parent: packet.attach_state.then_some(packet.parent_id),
            clamp: packet.ground_ocean_clamp,
            attitude: attitude([packet.yaw, packet.pitch, packet.roll]),
            at: [packet.lat_xoff, packet.lon_yoff, packet.alt_zoff],
        };
        self.place(packet.entity_id, place, moment)
    }

    /// Where an entity is; `None`: it was never placed, or its parents are not there.
    pub fn pose(&self, id: u16) -> Option<Pose> {
        self.pose_within(id, MOST_PARENTS)
    }

    /// The point at an offset `[x, y, z]` (forward, right, down) in an entity's axes.
    pub fn point(&self, id: u16, offset_m: [f64; 3]) -> Option<Geodetic> {
        let pose = self.pose(id)?;
        let axes = ecef_from_body(&pose.position, &pose.attitude);
        Some(from_ecef(to_ecef(&pose.position) + axes * DVec3::from(offset_m)))
    }

    /// A point given above mean sea level.
    pub fn geodetic(&self, [latitude_deg, longitude_deg, altitude_m]: [f64; 3]) -> Geodetic {
        Geodetic {
            latitude_rad: latitude_deg.clamp(LATITUDE_DEG[0], LATITUDE_DEG[1]).to_radians(),
            longitude_rad: half_turn(longitude_deg).to_radians(),
            altitude_m: altitude_m + self.sea_level_m,
        }
    }

    fn exist(&mut self, id: u16, state: u8, extrapolate: bool) -> Result<(), Refused> {
        if state == DESTROYED {
            self.destroy(id);
            return Ok(());
        }
        self.entry(id)?.extrapolate = extrapolate;
        self.changed.insert(id);
        Ok(())
    }

    /// An entity, made if there is room for it.
    fn entry(&mut self, id: u16) -> Result<&mut Entity, Refused> {
        if self.known.len() >= CIGI_ENTITIES && !self.known.contains_key(&id) {
            let limit = format!("{CIGI_ENTITIES} entities");
            return Err(Refused::new("entity_id", id, limit, "destroy others first"));
        }
        Ok(self.known.entry(id).or_default())
    }

    /// Forgets an entity and those attached to it.
    fn destroy(&mut self, id: u16) {
        self.known.remove(&id);
        self.gone.push(id);
        let children = |(child, entity): (&u16, &Entity)| {
            entity.placed.is_some_and(|place| place.parent == Some(id)).then_some(*child)
        };
        let children: Vec<u16> = self.known.iter().filter_map(children).collect();
        children.into_iter().for_each(|child| self.destroy(child));
    }

    fn place(&mut self, id: u16, place: Place, moment: &Moment) -> Result<(), Refused> {
        self.entry(id)?.placed = Some(place);
        self.changed.insert(id);
        let Some(pose) = self.pose(id) else { return Ok(()) };
        let entity = self.entry(id)?;
        let here = to_ecef(&pose.position);
        match (moment.timestamp, entity.last) {
            (Some(now), Some((there, then))) if now != then => {
                // Ticks wrap around after 12 hours.
                let passed_s = f64::from(now.wrapping_sub(then)) * TICK_S;
                let velocity = (here - there) / passed_s;
                let motion = passed_s <= MOTION_S && velocity.length() < VELOCITY_MPS[1];
                entity.velocity_mps = motion.then_some(velocity);
                entity.last = Some((here, now));
            }
            (Some(now), _) => entity.last = Some((here, now)),
            (None, _) => (entity.velocity_mps, entity.last) = (None, None),
        }
        Ok(())
    }

    fn pose_within(&self, id: u16, parents: usize) -> Option<Pose> {
        let place = self.known.get(&id)?.placed?;
        let Some(parent) = place.parent else {
            let mut position = self.geodetic(place.at);
            let mut attitude = place.attitude;
            if place.clamp != 0 {
                position.altitude_m = self.terrain.height_m(&position) + place.at[2];
            }
            if place.clamp == CONFORMAL {
                let tilt = DMat3::from_quat(DQuat::from_rotation_arc(DVec3::Z, self.terrain.normal(&position)));
                attitude = attitude_of(&(ENU_NED * tilt * ENU_NED * ned_from_body(&attitude)));
            }
            return Some(Pose { position, attitude });
        };
        let parent = self.pose_within(parent, parents.checked_sub(1)?)?;
        let axes = ecef_from_body(&parent.position, &parent.attitude);
        let position = from_ecef(to_ecef(&parent.position) + axes * DVec3::from(place.at));
        let turned = axes * ned_from_body(&place.attitude);
        Some(Pose { position, attitude: attitude_of(&(ENU_NED * enu(&position).transpose() * turned)) })
    }

    /// What the world is to hear of the ownship and of the entities that carry views: those that moved, or hang on one that
    /// did, and those that are gone. `anew`: of all of them, since views have changed.
    pub fn commands(&mut self, moment: &Moment, carriers: &BTreeSet<u16>, anew: bool) -> Vec<Command> {
        let heard = |id: &u16| *id == OWNSHIP || carriers.contains(id);
        let mut commands: Vec<Command> =
            self.gone.drain(..).filter(|id| *id != OWNSHIP).map(|id| Command::Entity { id, place: None }).collect();
        let moved = std::mem::take(&mut self.changed);
        for (id, entity) in self.known.iter().filter(|(id, _)| heard(id)) {
            if !(moved.contains(id) || self.hangs_on(*id, &moved) || anew && *id != OWNSHIP) {
                continue;
            }
            let Some(pose) = self.pose(*id) else { continue };
            let velocity = entity.velocity_mps.filter(|_| moment.extrapolate && entity.extrapolate);
            let ownship = ownship(&pose, velocity, moment.host_frame);
            commands.push(if *id == OWNSHIP {
                Command::Ownship(ownship)
            } else {
                Command::Entity { id: *id, place: Some(ownship) }
            });
        }
        commands
    }

    fn hangs_on(&self, id: u16, moved: &BTreeSet<u16>) -> bool {
        let mut id = id;
        for _ in 0..MOST_PARENTS {
            match self.known.get(&id).and_then(|entity| entity.placed?.parent) {
                Some(parent) if moved.contains(&parent) => return true,
                Some(parent) => id = parent,
                None => return false,
            }
        }
        false
    }
}

fn attitude([yaw, pitch, roll]: [f32; 3]) -> Attitude {
    Attitude {
        yaw_rad: half_turn(f64::from(yaw)).to_radians(),
        pitch_rad: f64::from(pitch).to_radians(),
        roll_rad: half_turn(f64::from(roll)).to_radians(),
    }
}

/// A pose as the world takes it. Rounding at the very limits is taken back.
fn ownship(pose: &Pose, velocity_mps: Option<DVec3>, host_frame: u32) -> Ownship {
    let pitch_deg = pose.attitude.pitch_rad.to_degrees();
    let close = |value: f64, limit: f64| if (value.abs() - limit).abs() < 1e-9 { limit.copysign(value) } else { value };
    Ownship {
        latitude_deg: pose.position.latitude_rad.to_degrees(),
        longitude_deg: pose.position.longitude_rad.to_degrees(),
        altitude_m: pose.position.altitude_m,
        yaw_deg: pose.attitude.yaw_rad.to_degrees(),
        pitch_deg: close(pitch_deg, PITCH_DEG[1]),
        roll_deg: pose.attitude.roll_rad.to_degrees(),
        velocity_ned_mps: velocity_mps.map(|velocity| {
            let local = ENU_NED * enu(&pose.position).transpose() * velocity;
            [local.x, local.y, local.z]
        }),
        host_frame,
    }
}
