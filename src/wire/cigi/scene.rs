//! What the host has said so far, and the commands that follow from it: the meaning of the packets, without a socket or a clock.
//!
//! Entities, views, regions and layers keep their state until it is changed, so the scene keeps it and tells the world what
//! is new after each message. A packet with a number that is none (NaN, infinity) is refused as a whole; what is finite and
//! out of range is refused by the world, or brought to the nearest limit where the standard says a percentage.

mod entities;
mod sky;
mod storm;
mod strikes;
mod views;
mod weather;

pub use entities::Entities;
pub use strikes::{EVENT_STRIKE_MISSED, EVENT_STRIKE_SHOWN, STRIKE_COMPONENT};
pub use views::MAIN;

use super::layout::Value;
use super::packets::{Packet, ViewControl, ViewDefinition};
use super::{Message, Version};
use crate::geo::terrain::Terrain;
use crate::outputs::air::Air;
use crate::world::command::{Command, StrikeRequest};
use crate::world::event::Refused;
use sky::Sky;
use std::collections::BTreeSet;
use views::Views;
use weather::Weather;

/// What the meaning of packets depends on beside the packets.
#[derive(Clone, Debug, PartialEq)]
pub struct Convention {
    /// Height of mean sea level above the WGS 84 ellipsoid: CIGI gives altitudes above mean sea level.
    pub sea_level_m: f64,
    /// Seed of storms, and of what a strike does not say.
    pub seed: u64,
    /// Width and height of the pictures: CIGI has no word for them.
    pub size_px: [u32; 2],
    /// The ground, on which entities are clamped.
    pub terrain: Terrain,
}

/// The message's own circumstances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// The host's frame number.
    pub host_frame: u32,
    /// The host's time stamp in 10-microsecond ticks, where it is valid.
    pub timestamp: Option<u32>,
    /// Whether entities move on between messages, where they want it too.
    pub extrapolate: bool,
    /// Simulation time at which the message is applied.
    pub now_s: f64,
}

/// What follows from a message.
#[derive(Clone, Debug, PartialEq)]
pub enum Consequence {
    /// The world changes.
    Command(Command),
    /// Lightning strikes, under the host's number for it.
    Strike {
        /// The host's number.
        strike_id: u16,
        /// The flash.
        request: StrikeRequest,
    },
    /// A question, to be answered with a Start of Frame.
    Question(Packet),
    /// A packet does not count.
    Refused(Refused),
}

/// Everything that the host has said.
#[derive(Clone, Debug)]
pub struct Scene {
    convention: Convention,
    entities: Entities,
    views: Views,
    sky: Sky,
    weather: Weather,
    muted: BTreeSet<u16>,
}

impl Scene {
    /// Nothing said yet; the world is as new.
    pub fn new(convention: Convention) -> Self {
        Self {
            entities: Entities::new(convention.sea_level_m, convention.terrain.clone()),
            views: Views::new(convention.size_px),
            sky: Sky::default(),
            weather: Weather::new(convention.sea_level_m, convention.seed),
            muted: BTreeSet::new(),
            convention,
        }
    }

    /// Where the entities are.
    pub fn entities(&self) -> &Entities {
        &self.entities
    }

    /// What the host has said of the air, for answers.
    pub fn air(&self) -> Air {
        self.weather.air(&self.entities)
    }

    /// Whether the host wants to hear of an event.
    pub fn wants(&self, event_id: u16) -> bool {
        !self.muted.contains(&event_id)
    }

    /// Takes the packets of a message after its IG Control, in their order.
    pub fn take(&mut self, message: &Message, moment: &Moment) -> Vec<Consequence> {
        let mut out = Vec::new();
        let mut strikes = Vec::new();
        for packet in &message.packets {
            if let Some(refused) = not_finite(packet, message.version) {
                out.push(Consequence::Refused(refused));
                continue;
            }
            let taken = match packet {
                Packet::EntityControl(packet) => self.entities.control(packet, moment),
                Packet::EntityState(packet) => self.entities.state(packet),
                Packet::EntityPosition(packet) => self.entities.position(packet, moment),
                Packet::ViewControl(packet) => self.views.control(packet),
                Packet::ViewDefinition(packet) => self.views.define(packet),
                Packet::CelestialSphereControl(packet) => self.sky.control(packet).map(|commands| {
                    out.extend(commands.into_iter().map(Consequence::Command));
                }),
                Packet::AtmosphereControl(packet) => {
                    self.weather.atmosphere(packet);
                    Ok(())
                }
                Packet::EnvironmentalRegionControl(packet) => self.weather.region(packet),
                Packet::WeatherControl(packet) => self.weather.layer(packet, message.version).map(|lightning| {
                    strikes.extend(lightning.map(|place| {
                        let storm = self.weather.storm_at(place, packet.severity, &self.entities);
                        (0, storm.map(|storm| storm.one(moment)))
                    }));
                }),
                Packet::ComponentControl(_)
                | Packet::ShortComponentControl(_)
                | Packet::Strike(_)
                | Packet::TimedStrike(_) => self.strike_or_event(packet, moment).map(|strike| strikes.extend(strike)),
                Packet::HatHotRequest(_)
                | Packet::LineOfSightSegmentRequest(_)
                | Packet::LineOfSightVectorRequest(_)
                | Packet::EnvironmentalConditionsRequest(_) => {
                    out.push(Consequence::Question(packet.clone()));
                    Ok(())
                }
                // IG Control belongs to the handshake; animations move nothing that is drawn; the rest are answers.
                _ => Ok(()),
            };
            out.extend(taken.err().map(Consequence::Refused));
        }
        let (carriers, anew) = (self.views.carriers(), self.views.changed());
        out.extend(self.entities.commands(moment, &carriers, anew).into_iter().map(Consequence::Command));
        out.extend(self.views.commands().into_iter().map(Consequence::Command));
        out.extend(self.weather.commands(&self.entities).into_iter().map(Consequence::Command));
        // Strikes last, so that they find the clouds of the same message.
        out.extend(strikes.into_iter().map(|(strike_id, strike)| match strike {
            Some(request) => Consequence::Strike { strike_id, request },
            None => {
                let limit = "a region or entity that is there, or a layer with weather";
                Consequence::Refused(Refused::new("strike", strike_id, limit, "there is no place for this strike"))
            }
        }));
        out
    }
}

/// The first number of a packet that is none, unless the packet says that it does not count.
fn not_finite(packet: &Packet, version: Version) -> Option<Refused> {
    let counts: &dyn Fn(&str) -> bool = match packet {
        Packet::ViewControl(packet) => &|name| view_control_counts(packet, name),
        Packet::ViewDefinition(packet) => &|name| view_definition_counts(packet, name),
        _ => &|_| true,
    };
    let layout = packet.layout();
    layout.placed(version).find_map(|(index, _, _, name)| {
        let value = match packet.field(index)? {
            Value::Single(value) => f64::from(value),
            Value::Double(value) => value,
            _ => return None,
        };
        (!value.is_finite() && counts(name)).then(|| {
            let field = format!("{}.{name}", layout.name_in(version));
            Refused::new(field, value, "a finite number", "the packet is left out")
        })
    })
}

fn view_control_counts(packet: &ViewControl, name: &str) -> bool {
    match name {
        "x_offset" => packet.x_offset_enable,
        "y_offset" => packet.y_offset_enable,
        "z_offset" => packet.z_offset_enable,
        "roll" => packet.roll_enable,
        "pitch" => packet.pitch_enable,
        "yaw" => packet.yaw_enable,
        _ => true,
    }
}

fn view_definition_counts(packet: &ViewDefinition, name: &str) -> bool {
    match name {
        "left" => packet.left_enable,
        "right" => packet.right_enable,
        "top" => packet.top_enable,
        "bottom" => packet.bottom_enable,
        // The near and far planes have no effect.
        _ => false,
    }
}

/// An angle brought into [-180, 180]; one that is there already stays as it is.
pub fn half_turn(angle_deg: f64) -> f64 {
    if angle_deg.abs() <= 180.0 { angle_deg } else { (angle_deg + 180.0).rem_euclid(360.0) - 180.0 }
}

#[cfg(test)]
mod tests;
