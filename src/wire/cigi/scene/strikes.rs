//! Strikes that a host asks for, by a component or by a packet of our own; which events it wants to hear of; and the component
//! that is the own ship's lights.

use super::{Moment, Scene};
use crate::numeric::hash::{pcg3d, unit};
use crate::wire::cigi::packets::{ComponentControl, Packet, ShortComponentControl, Strike, TimedStrike};
use crate::world::command::{FlashKind, Polarity, StrikeRequest, StrokeSpec, Strokes};
use crate::world::event::Refused;

/// Component of class System (13) that is a lightning strike: "LS".
pub const STRIKE_COMPONENT: u16 = 0x4c53;
/// Event: a strike is seen for the first time.
pub const EVENT_STRIKE_SHOWN: u16 = STRIKE_COMPONENT;
/// Event: a strike was over before a picture could show it.
pub const EVENT_STRIKE_MISSED: u16 = STRIKE_COMPONENT + 1;

/// Component of class View (1) that is the own ship's lights: "OL".
pub const LIGHTS_COMPONENT: u16 = 0x4f4c;

const CLASS_VIEW: u8 = 1;
const CLASS_EVENT: u8 = 12;
const CLASS_SYSTEM: u8 = 13;
/// Usual interval between strokes, and median current of later strokes against that of the first (CIGRE TB 549: about 60 ms;
/// 12 kA after 31 kA).
const INTERVAL_S: f64 = 0.06;
const LATER_SHARE: f64 = 0.4;
/// Severity whose currents a strike without one has.
const USUAL_SEVERITY: u8 = 3;

/// A host's number for a strike, and the strike; `None`: there is no place for it.
pub type Asked = (u16, Option<StrikeRequest>);

impl Scene {
    /// Takes a component or a strike packet.
    pub(super) fn strike_or_event(&mut self, packet: &Packet, moment: &Moment) -> Result<Option<Asked>, Refused> {
        match packet {
            Packet::ComponentControl(packet) => self.component(packet, moment),
            Packet::ShortComponentControl(packet) => self.short_component(packet, moment),
            Packet::Strike(packet) => self.strike(packet, moment, None).map(Some),
            Packet::TimedStrike(TimedStrike {
                strike_id,
                flags,
                return_strokes,
                latitude,
                longitude,
                altitude,
                peak_current_ka,
                channel_top_altitude,
                delay,
            }) => {
                let (strike_id, flags, return_strokes) = (*strike_id, *flags, *return_strokes);
                let (latitude, longitude, altitude) = (*latitude, *longitude, *altitude);
                let (peak_current_ka, channel_top_altitude) = (*peak_current_ka, *channel_top_altitude);
                let strike = Strike {
                    strike_id,
                    flags,
                    return_strokes,
                    latitude,
                    longitude,
                    altitude,
                    peak_current_ka,
                    channel_top_altitude,
                };
                if !(0.0..=3_600.0).contains(delay) {
                    return Err(Refused::new("strike.delay", delay, "0 to 3600 s", "no time for a strike"));
                }
                self.strike(&strike, moment, Some(moment.now_s + f64::from(*delay))).map(Some)
            }
            _ => Ok(None),
        }
    }

    fn component(&mut self, packet: &ComponentControl, moment: &Moment) -> Result<Option<Asked>, Refused> {
        let on = packet.component_state != 0;
        self.event(packet.component_class, packet.instance_id, on);
        if is_lights(packet.component_class, packet.component_id) {
            return self.views.lights(packet.instance_id, packet.component_state).map(|()| None);
        }
        if !is_strike(packet.component_class, packet.component_id) || !on {
            return Ok(None);
        }
        let double = |high: u32, low: u32| f64::from_bits(u64::from(high) << 32 | u64::from(low));
        let strike = Strike {
            strike_id: packet.instance_id,
            flags: 1,
            return_strokes: 0,
            latitude: double(packet.data_1, packet.data_2),
            longitude: double(packet.data_3, packet.data_4),
            altitude: f32::from_bits(packet.data_5).into(),
            peak_current_ka: f32::from_bits(packet.data_6),
            channel_top_altitude: 0.0,
        };
        self.strike(&strike, moment, None).map(Some)
    }

    fn short_component(&mut self, packet: &ShortComponentControl, moment: &Moment) -> Result<Option<Asked>, Refused> {
        let on = packet.component_state != 0;
        self.event(packet.component_class, packet.instance_id, on);
        if is_lights(packet.component_class, packet.component_id) {
            return self.views.lights(packet.instance_id, packet.component_state).map(|()| None);
        }
        if !is_strike(packet.component_class, packet.component_id) || !on {
            return Ok(None);
        }
        let current = signed_current(f32::from_bits(packet.data_2))?;
        let layer_id = u8::try_from(packet.data_1)
            .map_err(|_| Refused::new("strike.data_1", packet.data_1, "0 to 255", "no weather layer"))?;
        let storm = self.weather.storm_of_layer(layer_id, USUAL_SEVERITY, &self.entities);
        let request = storm.map(|storm| {
            let drawn = storm.one(moment);
            let (polarity, peak) = current.unwrap_or((drawn.polarity, None));
            StrikeRequest { polarity, peak_current_ka: peak.or(drawn.peak_current_ka), ..drawn }
        });
        Ok(Some((packet.instance_id, request)))
    }

    /// Component class Event: whether the host wants to hear of it.
    fn event(&mut self, component_class: u8, event_id: u16, on: bool) {
        if component_class != CLASS_EVENT || !matches!(event_id, EVENT_STRIKE_SHOWN | EVENT_STRIKE_MISSED) {
            return;
        }
        if on {
            self.muted.remove(&event_id);
        } else {
            self.muted.insert(event_id);
        }
    }

    fn strike(&self, packet: &Strike, moment: &Moment, at_s: Option<f64>) -> Result<Asked, Refused> {
        let finite = [packet.latitude, packet.longitude, packet.altitude, packet.channel_top_altitude.into()];
        if let Some(value) = finite.into_iter().find(|value| !value.is_finite()) {
            return Err(Refused::new("strike", value, "finite numbers", "no place for a strike"));
        }
        let (polarity, peak) = signed_current(packet.peak_current_ka)?.unwrap_or((Polarity::Negative, None));
        let sea_level_m = self.convention.sea_level_m;
        let top = f64::from(packet.channel_top_altitude);
        // The light's middle; an altitude of 0 without a top says only where, not how high.
        let altitude_m = match (packet.altitude, top > packet.altitude) {
            (altitude, true) => Some(0.5 * (altitude + top) + sea_level_m),
            (0.0, false) => None,
            (altitude, false) => Some(altitude + sea_level_m),
        };
        let seed = self.convention.seed ^ u64::from(moment.host_frame) << 16 ^ u64::from(packet.strike_id);
        let strokes = match (packet.return_strokes, peak) {
            (0, _) => Strokes::Sample,
            (count, peak) => Strokes::Given(strokes(count, peak.unwrap_or(31.0), seed)),
        };
        let request = StrikeRequest {
            latitude_deg: packet.latitude,
            longitude_deg: super::half_turn(packet.longitude),
            altitude_m,
            at_s,
            kind: if packet.flags & 1 != 0 { FlashKind::CloudToGround } else { FlashKind::IntraCloud },
            polarity,
            peak_current_ka: peak,
            strokes,
            leader: false,
            seed,
        };
        Ok((packet.strike_id, Some(request)))
    }
}

fn is_lights(component_class: u8, component_id: u16) -> bool {
    component_class == CLASS_VIEW && component_id == LIGHTS_COMPONENT
}

fn is_strike(component_class: u8, component_id: u16) -> bool {
    component_class == CLASS_SYSTEM && component_id == STRIKE_COMPONENT
}

/// Polarity and peak current from a current with a sign; `None`: 0, which says nothing.
fn signed_current(current_ka: f32) -> Result<Option<(Polarity, Option<f64>)>, Refused> {
    let current_ka = f64::from(current_ka);
    if !current_ka.is_finite() {
        return Err(Refused::new("strike.peak_current_ka", current_ka, "a finite number", "no current"));
    }
    let polarity = if current_ka > 0.0 { Polarity::Positive } else { Polarity::Negative };
    Ok((current_ka != 0.0).then_some((polarity, Some(current_ka.abs()))))
}

/// So many strokes, the later ones weaker, at intervals that vary by the seed.
fn strokes(count: u8, first_ka: f64, seed: u64) -> Vec<StrokeSpec> {
    let mut delay_s = 0.0;
    (0..u32::from(count))
        .map(|number| {
            if number > 0 {
                let [chance, ..] = pcg3d(seed as u32, (seed >> 32) as u32, number);
                delay_s += INTERVAL_S * f64::from(0.5 + unit(chance));
            }
            StrokeSpec {
                delay_s,
                peak_current_ka: if number == 0 { first_ka } else { (first_ka * LATER_SHARE).max(0.1) },
                ..StrokeSpec::default()
            }
        })
        .collect()
}
