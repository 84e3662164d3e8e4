//! Conversations in which each field of one packet has something to say.

use super::*;

mod asked;
mod moving;
mod weather;

/// A conversation around one packet: what is said before it, with it and after it, each a message.
pub struct Talk {
    before: Vec<Packet>,
    /// The packet that is changed.
    pub packet: Packet,
    beside: Vec<Packet>,
    after: Vec<Packet>,
}

impl Talk {
    /// The messages, with another packet in the place of the one that is changed.
    pub fn messages(&self, version: Version, packet: &Packet) -> Vec<Vec<Packet>> {
        let is_control = matches!(packet, Packet::IgControl(_));
        let with = if is_control { vec![packet.clone()] } else { vec![control(version, 2).into(), packet.clone()] };
        vec![
            [vec![control(version, 1).into()], self.before.clone()].concat(),
            [with, self.beside.clone()].concat(),
            [vec![control(version, 3).into()], self.after.clone()].concat(),
        ]
    }
}

/// The IG Control of a message; half a second passes between two.
fn control(version: Version, number: u32) -> IgControl {
    let [major_version, minor_version] = version.numbers();
    IgControl {
        major_version,
        minor_version,
        ig_mode: 1,
        timestamp_valid: true,
        extrapolation_interpolation_enable: true,
        host_frame_number: number,
        timestamp: 50_000 * number,
        ..Default::default()
    }
}

/// An entity in a version's own packets; it moves on between messages.
fn entity(version: Version, entity_id: u16, [lat_xoff, lon_yoff, alt_zoff]: [f64; 3]) -> Vec<Packet> {
    let linear_extrapolation_interpolation_enable = true;
    match version {
        Version::V3 => vec![
            EntityControl {
                entity_id,
                entity_state: 1,
                linear_extrapolation_interpolation_enable,
                lat_xoff,
                lon_yoff,
                alt_zoff,
                ..Default::default()
            }
            .into(),
        ],
        Version::V4 => vec![
            EntityState { entity_id, entity_state: 1, linear_extrapolation_interpolation_enable, ..Default::default() }
                .into(),
            EntityPosition { entity_id, lat_xoff, lon_yoff, alt_zoff, ..Default::default() }.into(),
        ],
    }
}

const HERE: [f64; 3] = [47.0, 8.0, 900.0];
/// 22 m further on.
const THERE: [f64; 3] = [47.000_2, 8.0, 900.0];

/// All conversations in a version.
pub fn talks(version: Version) -> Vec<Talk> {
    let ownship = entity(version, 0, HERE);
    let two = [entity(version, 1, [47.01, 8.01, 2_500.0]), entity(version, 2, [47.02, 8.0, 700.0])].concat();
    let mut all = vec![Talk {
        before: ownship.clone(),
        packet: IgControl { database_number: 1, ..control(version, 2) }.into(),
        beside: entity(version, 0, THERE),
        after: Vec::new(),
    }];
    let mut talk = |before: Vec<Packet>, packet: Packet, beside: Vec<Packet>, after: Vec<Packet>| {
        all.push(Talk { before: [ownship.clone(), before].concat(), packet, beside, after });
    };
    moving::entities(version, &mut talk);
    moving::views(&two, &mut talk);
    weather::sky(&mut talk);
    weather::weather(&mut talk);
    asked::strikes(&mut talk);
    asked::questions(&two, &mut talk);
    all
}

type Tell<'a> = dyn FnMut(Vec<Packet>, Packet, Vec<Packet>, Vec<Packet>) + 'a;
