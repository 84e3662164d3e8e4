//! A message: one datagram of packets, walked from its first packet to its end, or rejected whole.

use super::layout::{self, Kind, Layout};
use super::others;
use super::packets::Packet;
use super::{ByteOrder, Direction, Version};
use crate::bytes::{Reader, TooShort};
use crate::wire::limits::CIGI_MESSAGE_BYTES;

/// Bytes of IG Control and of Start of Frame, in all versions that are understood.
const FIRST_PACKET_BYTES: usize = 24;
/// Packet sizes are multiples of this.
const GRAIN_BYTES: usize = 8;
/// `byte_swap_magic` of CIGI 3 in the receiver's byte order.
pub const BYTE_SWAP_MAGIC: u16 = 0x8000;

/// A decoded message, or one to be encoded.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// Version of all its packets.
    pub version: Version,
    /// Byte order of all its packets.
    pub byte_order: ByteOrder,
    /// The packets that are understood, in their order.
    pub packets: Vec<Packet>,
    /// The packets that were passed over.
    pub skipped: Vec<Skipped>,
}

/// A packet that was passed over by its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Skipped {
    /// Its id.
    pub packet_id: u16,
    /// First byte in the message.
    pub offset: usize,
    /// Bytes with the header.
    pub size: usize,
    /// Packets before it in [`Message::packets`].
    pub index: usize,
}

/// Why a message was rejected; nothing in it counts.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Rejected {
    /// Too few bytes for a first packet.
    #[error("{0} bytes: a message begins with a packet of {FIRST_PACKET_BYTES} bytes")]
    Short(usize),
    /// More bytes than a datagram has.
    #[error("{0} bytes: at most {CIGI_MESSAGE_BYTES}")]
    Long(usize),
    /// The first bytes are those of no first packet.
    #[error("begins with {0:02x?}: neither IG Control nor Start of Frame of CIGI 3.3 or 4.0")]
    NotCigi([u8; 5]),
    /// A version that is not understood.
    #[error("CIGI {major}.{minor}: understood are 3.2, 3.3 and 4.0")]
    Version {
        /// Major version.
        major: u8,
        /// Minor version.
        minor: u8,
    },
    /// CIGI 3: the byte order cannot be told.
    #[error("byte swap magic {0:02x?}: must be 00 80 (little endian) or 80 00 (big endian)")]
    Magic([u8; 2]),
    /// A packet's size cannot be.
    #[error("packet {packet_id} at byte {offset}: size {size} is not a positive multiple of {GRAIN_BYTES}")]
    Size {
        /// Id.
        packet_id: u16,
        /// Where the packet begins.
        offset: usize,
        /// The size it gives.
        size: usize,
    },
    /// A packet runs past the end.
    #[error("packet {packet_id} at byte {offset}: size {size}, but {left} bytes are left")]
    PastEnd {
        /// Id.
        packet_id: u16,
        /// Where the packet begins.
        offset: usize,
        /// The size it gives.
        size: usize,
        /// Bytes from there to the end.
        left: usize,
    },
    /// A standard packet has another size than the standard's.
    #[error("{packet} at byte {offset}: size {size}, must be {must}")]
    PacketSize {
        /// Name.
        packet: &'static str,
        /// Where the packet begins.
        offset: usize,
        /// The size it gives.
        size: usize,
        /// The size it has to have; the least, for a packet that ends in text.
        must: usize,
    },
    /// Only the first packet may be one of these.
    #[error("a second {packet} at byte {offset}: a message has one, and it comes first")]
    Second {
        /// Name.
        packet: &'static str,
        /// Where it begins.
        offset: usize,
    },
    /// A packet that the other side sends.
    #[error("{packet} at byte {offset}: it goes the other way")]
    Direction {
        /// Name.
        packet: &'static str,
        /// Where it begins.
        offset: usize,
    },
    /// Bytes are missing.
    #[error(transparent)]
    TooShort(#[from] TooShort),
}

/// Why a message cannot be encoded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unencodable {
    /// The version does not have the packet.
    #[error("CIGI {version} has no {packet}")]
    NotInVersion {
        /// The packet's name.
        packet: &'static str,
        /// The version's name.
        version: &'static str,
    },
    /// A value is beyond its bits.
    #[error("{packet}: {field} = {value} is not in {least} to {most}")]
    Range {
        /// The packet's name.
        packet: &'static str,
        /// The field's name.
        field: &'static str,
        /// The value given.
        value: i64,
        /// Smallest.
        least: i64,
        /// Largest.
        most: i64,
    },
    /// A text has too many characters or ones that cannot be sent.
    #[error("{packet}: {field} has {length} characters; at most {most}, each of ISO 8859-1 and none NUL")]
    Text {
        /// The packet's name.
        packet: &'static str,
        /// The field's name.
        field: &'static str,
        /// Its length.
        length: usize,
        /// The longest that fits.
        most: usize,
    },
}

/// What the first bytes say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Opening {
    /// Who sends it.
    pub direction: Direction,
    /// Version.
    pub version: Version,
    /// Byte order.
    pub byte_order: ByteOrder,
}

/// Version, byte order and direction from the first packet; the first test of any datagram, and a cheap one.
///
/// # Errors
/// [`Rejected`]: no first packet of a version that is understood.
pub fn opening(message: &[u8]) -> Result<Opening, Rejected> {
    if message.len() > CIGI_MESSAGE_BYTES {
        return Err(Rejected::Long(message.len()));
    }
    let Some(first) = message.first_chunk::<FIRST_PACKET_BYTES>() else { return Err(Rejected::Short(message.len())) };
    let [b0, b1, b2, b3, b4, b5, b6, b7, ..] = *first;
    if matches!((b0, b1), (1 | 101, 24 | 16)) && matches!(b2, 1..=3) {
        let direction = if b0 == 1 { Direction::HostToIg } else { Direction::IgToHost };
        let minor = if b0 == 1 { b4 >> 4 } else { b5 >> 4 };
        if (b1, b2) != (24, 3) || !matches!(minor, 2 | 3) {
            return Err(Rejected::Version { major: b2, minor });
        }
        let byte_order = match [b6, b7] {
            [0x00, 0x80] => ByteOrder::Little,
            [0x80, 0x00] => ByteOrder::Big,
            magic => return Err(Rejected::Magic(magic)),
        };
        return Ok(Opening { direction, version: Version::V3, byte_order });
    }
    let byte_order = match [b0, b1] {
        [0x18, 0x00] => ByteOrder::Little,
        [0x00, 0x18] => ByteOrder::Big,
        _ => return Err(Rejected::NotCigi([b0, b1, b2, b3, b4])),
    };
    let direction = match [b2, b3] {
        [0x00, 0x00] => Direction::HostToIg,
        [0xff, 0xff] => Direction::IgToHost,
        _ => return Err(Rejected::NotCigi([b0, b1, b2, b3, b4])),
    };
    match (b4, b7 >> 4) {
        (4, 0) => Ok(Opening { direction, version: Version::V4, byte_order }),
        (major, minor) => Err(Rejected::Version { major, minor }),
    }
}

/// Decodes a whole message.
///
/// # Errors
/// [`Rejected`]: any part of it is not as the standard says; then nothing of it counts.
pub fn decode(message: &[u8]) -> Result<Message, Rejected> {
    let Opening { direction, version, byte_order } = opening(message)?;
    let mut first = true;
    walk(message, version, byte_order, |layout, offset| {
        let packet = layout.name_in(version);
        let opens = others::opens_a_message(layout.name);
        if opens && !std::mem::take(&mut first) {
            return Err(Rejected::Second { packet, offset });
        }
        if layout.direction != direction { Err(Rejected::Direction { packet, offset }) } else { Ok(()) }
    })
}

/// Decodes packets that stand alone, of either direction.
///
/// # Errors
/// [`Rejected`]: any part of them is not as the standard says.
pub fn decode_packets(packets: &[u8], version: Version, byte_order: ByteOrder) -> Result<Message, Rejected> {
    if packets.len() > CIGI_MESSAGE_BYTES {
        return Err(Rejected::Long(packets.len()));
    }
    walk(packets, version, byte_order, |_, _| Ok(()))
}

fn walk(
    message: &[u8],
    version: Version,
    byte_order: ByteOrder,
    mut allow: impl FnMut(&Layout, usize) -> Result<(), Rejected>,
) -> Result<Message, Rejected> {
    let (mut packets, mut skipped) = (Vec::new(), Vec::new());
    let mut reader = Reader::new(message);
    while !reader.rest().is_empty() {
        let offset = reader.offset();
        let (packet_id, size) = header(&mut Reader::new(reader.rest()), version, byte_order)?;
        if size == 0 || size % GRAIN_BYTES != 0 {
            return Err(Rejected::Size { packet_id, offset, size });
        }
        let left = reader.rest().len();
        let bytes = reader.take(size).map_err(|_| Rejected::PastEnd { packet_id, offset, size, left })?;
        match Packet::blank(version, packet_id) {
            Some(mut packet) => {
                let layout = packet.layout();
                let sizes = layout.framing(version).map_or(0..=0, |framing| framing.size..=framing.largest);
                if !sizes.contains(&size) {
                    // Somebody else's packet may have the number that we chose for ours.
                    if others::is_user_defined(version, packet_id) {
                        skipped.push(Skipped { packet_id, offset, size, index: packets.len() });
                        continue;
                    }
                    let packet = layout.name_in(version);
                    return Err(Rejected::PacketSize { packet, offset, size, must: *sizes.start() });
                }
                allow(layout, offset)?;
                for (index, field, place, _) in layout.placed(version) {
                    let value = layout::read(bytes, field.kind, place, byte_order)?;
                    packet.set_field(index, &value);
                }
                packets.push(packet);
            }
            None => skipped.push(Skipped { packet_id, offset, size, index: packets.len() }),
        }
    }
    Ok(Message { version, byte_order, packets, skipped })
}

/// Id and size of a packet.
fn header(reader: &mut Reader, version: Version, byte_order: ByteOrder) -> Result<(u16, usize), TooShort> {
    Ok(match (version, byte_order) {
        (Version::V3, _) => (u16::from(reader.u8()?), usize::from(reader.u8()?)),
        (Version::V4, ByteOrder::Little) => {
            let size = reader.u16_le()?;
            (reader.u16_le()?, usize::from(size))
        }
        (Version::V4, ByteOrder::Big) => {
            let size = reader.u16_be()?;
            (reader.u16_be()?, usize::from(size))
        }
    })
}

/// Encodes the packets of a message behind one another; what was skipped is not there.
///
/// # Errors
/// [`Unencodable`]: a packet that the version does not have, or a value beyond its bits.
pub fn encode(message: &Message) -> Result<Vec<u8>, Unencodable> {
    let mut bytes = Vec::new();
    for packet in &message.packets {
        bytes.extend(encode_packet(packet, message.version, message.byte_order)?);
    }
    Ok(bytes)
}

/// Encodes one packet. Bytes that carry no field are 0.
///
/// # Errors
/// [`Unencodable`].
pub fn encode_packet(packet: &Packet, version: Version, byte_order: ByteOrder) -> Result<Vec<u8>, Unencodable> {
    let layout = packet.layout();
    let name = layout.name_in(version);
    let Some(framing) = layout.framing(version) else {
        return Err(Unencodable::NotInVersion { packet: name, version: version.name() });
    };
    let mut size = framing.size;
    for (index, field, place, called) in layout.placed(version) {
        match packet.field(index) {
            Some(layout::Value::Text(text)) => {
                let most = framing.largest - place.byte - 1;
                let length = text.chars().count();
                if length > most || text.chars().any(|c| c == '\0' || u8::try_from(c).is_err()) {
                    return Err(Unencodable::Text { packet: name, field: called, length, most });
                }
                size = size.max((place.byte + length + 1).next_multiple_of(GRAIN_BYTES));
            }
            Some(layout::Value::Whole(value)) => {
                let [least, most] = field.kind.range(place);
                if !(least..=most).contains(&value) {
                    return Err(Unencodable::Range { packet: name, field: called, value, least, most });
                }
            }
            _ => {}
        }
    }
    let mut bytes = vec![0; size];
    let whole = |number: usize| layout::Value::Whole(number as i64);
    match version {
        Version::V3 => {
            layout::write(&mut bytes, &whole(framing.id.into()), Kind::U8, layout::at(0), byte_order);
            layout::write(&mut bytes, &whole(size), Kind::U8, layout::at(1), byte_order);
        }
        Version::V4 => {
            layout::write(&mut bytes, &whole(size), Kind::U16, layout::at(0), byte_order);
            layout::write(&mut bytes, &whole(framing.id.into()), Kind::U16, layout::at(2), byte_order);
        }
    }
    for (index, field, place, _) in layout.placed(version) {
        if let Some(value) = packet.field(index) {
            layout::write(&mut bytes, &value, field.kind, place, byte_order);
        }
    }
    Ok(bytes)
}
