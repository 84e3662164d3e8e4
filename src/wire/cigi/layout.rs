//! What a packet looks like on the wire, as data: where each field stands in CIGI 3.3 and in 4.0, and what becomes of it.
//!
//! Decoding, encoding, JSON and the pages under `protocol/` are all made from these tables.

use super::{ByteOrder, Direction, Version};
use crate::bytes::{Reader, TooShort, Writer};

/// One packet in both versions.
#[derive(Debug)]
pub struct Layout {
    /// Name of the Rust type.
    pub type_name: &'static str,
    /// Name, as in "View Control".
    pub name: &'static str,
    /// What it is for.
    pub meaning: &'static str,
    /// Who sends it.
    pub direction: Direction,
    /// Id and size in CIGI 3.3, if it has it.
    pub v3: Framing,
    /// Id and size in CIGI 4.0, if it has it.
    pub v4: Framing,
    /// Fields behind the header.
    pub fields: &'static [Field],
}

/// Id and size of a packet in one version.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Framing {
    /// Packet id.
    pub id: u16,
    /// Bytes with the header, a multiple of 8; the least for a packet that ends in text. 0: not in this version.
    pub size: usize,
    /// Most bytes.
    pub largest: usize,
    /// The name, where it is not that of the layout; else empty.
    pub name: &'static str,
}

/// One field in both versions.
#[derive(Debug)]
pub struct Field {
    /// Name.
    pub name: &'static str,
    /// Type.
    pub kind: Kind,
    /// Where it stands in CIGI 3.3.
    pub v3: Place,
    /// Where it stands in CIGI 4.0.
    pub v4: Place,
    /// What it says, with unit and range.
    pub meaning: &'static str,
    /// What this server makes of it.
    pub effect: Effect,
}

/// What this server makes of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// It is read and has this effect.
    Used(&'static str),
    /// It is read and has no effect, for this reason.
    Ignored(&'static str),
    /// The server sends this in it.
    Sent(&'static str),
}

/// A field that has an effect.
pub const fn used(effect: &'static str) -> Effect {
    Effect::Used(effect)
}

/// A field without effect.
pub const fn ignored(reason: &'static str) -> Effect {
    Effect::Ignored(reason)
}

/// A field of an answer.
pub const fn sent(what: &'static str) -> Effect {
    Effect::Sent(what)
}

/// The type of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One bit.
    Bool,
    /// Without sign; also for bit-fields.
    U8,
    /// With sign.
    I8,
    /// Without sign.
    U16,
    /// Without sign.
    U32,
    /// IEEE 754.
    F32,
    /// IEEE 754.
    F64,
    /// Text to the end of the packet, closed and filled up with NUL.
    Text,
}

/// Where a field stands in a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// First byte, counted from the packet's own first.
    pub byte: usize,
    /// Which part of it.
    pub part: Part,
    /// The name in this version, where it is not the field's; else empty.
    pub name: &'static str,
}

/// Which part of its bytes a field fills.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The version does not have the field.
    Absent,
    /// All bits of its type.
    Whole,
    /// Bits of one byte, counted from the least significant.
    Bits {
        /// Lowest bit.
        lowest: u8,
        /// How many.
        width: u8,
    },
    /// A bit for which implementations disagree about the byte: read from this byte or the next, written as bit 8 + n of a
    /// 16-bit number in the sender's byte order.
    Disputed {
        /// Bit.
        bit: u8,
    },
}

/// A field that fills its type from this byte on.
pub const fn at(byte: usize) -> Place {
    Place { byte, part: Part::Whole, name: "" }
}

/// One bit of a byte.
pub const fn bit(byte: usize, bit: u8) -> Place {
    bits(byte, bit, 1)
}

/// Some bits of a byte, from the lowest.
pub const fn bits(byte: usize, lowest: u8, width: u8) -> Place {
    Place { byte, part: Part::Bits { lowest, width }, name: "" }
}

/// A bit whose byte is disputed.
pub const fn disputed(byte: usize, bit: u8) -> Place {
    Place { byte, part: Part::Disputed { bit }, name: "" }
}

/// The version does not have the field.
pub const fn absent() -> Place {
    Place { byte: 0, part: Part::Absent, name: "" }
}

impl Place {
    /// The same place under another name.
    pub const fn called(self, name: &'static str) -> Self {
        Self { name, ..self }
    }
}

/// A packet of fixed size.
pub const fn fixed(id: u16, size: usize) -> Framing {
    Framing { id, size, largest: size, name: "" }
}

/// A packet that ends in text.
pub const fn with_text(id: u16, size: usize, largest: usize) -> Framing {
    Framing { id, size, largest, name: "" }
}

/// The version does not have the packet.
pub const fn missing() -> Framing {
    fixed(0, 0)
}

impl Framing {
    /// The same packet under another name.
    pub const fn called(self, name: &'static str) -> Self {
        Self { name, ..self }
    }
}

impl Layout {
    /// Id and size in a version; `None`: it does not have the packet.
    pub fn framing(&self, version: Version) -> Option<Framing> {
        let framing = match version {
            Version::V3 => self.v3,
            Version::V4 => self.v4,
        };
        (framing.size > 0).then_some(framing)
    }

    /// The packet's name in a version.
    pub fn name_in(&self, version: Version) -> &'static str {
        self.framing(version).map(|framing| framing.name).filter(|name| !name.is_empty()).unwrap_or(self.name)
    }

    /// The fields that a version has, with their index in `fields`, their place and their name there.
    pub fn placed(&self, version: Version) -> impl Iterator<Item = (usize, &'static Field, Place, &'static str)> {
        self.fields.iter().enumerate().filter_map(move |(index, field)| {
            let place = match version {
                Version::V3 => field.v3,
                Version::V4 => field.v4,
            };
            let name = if place.name.is_empty() { field.name } else { place.name };
            (place.part != Part::Absent).then_some((index, field, place, name))
        })
    }
}

/// The value of any field.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A whole number; bits count as 0 and 1.
    Whole(i64),
    /// A 32-bit float.
    Single(f32),
    /// A 64-bit float.
    Double(f64),
    /// A text.
    Text(String),
}

/// A Rust type that a field may have.
pub trait Scalar: Sized {
    /// Its kind in the tables.
    const KIND: Kind;
    /// Its value.
    fn to_value(&self) -> Value;
    /// The value again; `None` if it does not fit.
    fn from_value(value: &Value) -> Option<Self>;
}

macro_rules! whole_numbers {
    ($($kind:ty => $name:ident,)+) => {$(
        impl Scalar for $kind {
            const KIND: Kind = Kind::$name;
            fn to_value(&self) -> Value {
                Value::Whole(i64::from(*self))
            }
            fn from_value(value: &Value) -> Option<Self> {
                match value {
                    Value::Whole(number) => Self::try_from(*number).ok(),
                    _ => None,
                }
            }
        }
    )+};
}

whole_numbers! { u8 => U8, i8 => I8, u16 => U16, u32 => U32, }

impl Scalar for bool {
    const KIND: Kind = Kind::Bool;
    fn to_value(&self) -> Value {
        Value::Whole(i64::from(*self))
    }
    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Whole(0) => Some(false),
            Value::Whole(1) => Some(true),
            _ => None,
        }
    }
}

impl Scalar for f32 {
    const KIND: Kind = Kind::F32;
    fn to_value(&self) -> Value {
        Value::Single(*self)
    }
    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Single(number) => Some(*number),
            _ => None,
        }
    }
}

impl Scalar for f64 {
    const KIND: Kind = Kind::F64;
    fn to_value(&self) -> Value {
        Value::Double(*self)
    }
    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Double(number) => Some(*number),
            _ => None,
        }
    }
}

impl Scalar for String {
    const KIND: Kind = Kind::Text;
    fn to_value(&self) -> Value {
        Value::Text(self.clone())
    }
    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Text(text) => Some(text.clone()),
            _ => None,
        }
    }
}

impl Kind {
    /// Bytes that it fills; a text fills what is there.
    pub const fn bytes(self) -> usize {
        match self {
            Self::Bool | Self::U8 | Self::I8 => 1,
            Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
            Self::Text => 0,
        }
    }

    /// Smallest and largest whole number of a field of this kind at this place.
    pub fn range(self, place: Place) -> [i64; 2] {
        match (place.part, self) {
            (Part::Bits { width, .. }, _) => [0, (1 << width) - 1],
            (Part::Disputed { .. }, _) | (_, Self::Bool) => [0, 1],
            (_, Self::I8) => [i8::MIN.into(), i8::MAX.into()],
            (_, Self::U8) => [0, u8::MAX.into()],
            (_, Self::U16) => [0, u16::MAX.into()],
            _ => [0, u32::MAX.into()],
        }
    }
}

/// Reads one field of a packet.
///
/// # Errors
/// [`TooShort`]: the packet ends before the field does.
pub fn read(packet: &[u8], kind: Kind, place: Place, order: ByteOrder) -> Result<Value, TooShort> {
    let mut reader = Reader::new(packet);
    reader.take(place.byte)?;
    let little = order == ByteOrder::Little;
    let whole = match (place.part, kind) {
        (Part::Bits { lowest, width }, _) => i64::from(reader.u8()? >> lowest & (0xff >> (8 - width))),
        (Part::Disputed { bit }, _) => i64::from((reader.u8()? | reader.u8()?) >> bit & 1),
        (_, Kind::Bool | Kind::U8) => i64::from(reader.u8()?),
        (_, Kind::I8) => i64::from(i8::from_ne_bytes([reader.u8()?])),
        (_, Kind::U16) => i64::from(if little { reader.u16_le()? } else { reader.u16_be()? }),
        (_, Kind::U32) => i64::from(if little { reader.u32_le()? } else { reader.u32_be()? }),
        (_, Kind::F32) => return Ok(Value::Single(if little { reader.f32_le()? } else { reader.f32_be()? })),
        (_, Kind::F64) => return Ok(Value::Double(if little { reader.f64_le()? } else { reader.f64_be()? })),
        (_, Kind::Text) => {
            // One byte, one character (ISO 8859-1), so that any text comes back byte for byte.
            return Ok(Value::Text(
                reader.rest().iter().take_while(|byte| **byte != 0).copied().map(char::from).collect(),
            ));
        }
    };
    Ok(Value::Whole(whole))
}

/// Writes one field into a packet that is long enough; bits beyond the field's width are cut off.
pub fn write(packet: &mut [u8], value: &Value, kind: Kind, place: Place, order: ByteOrder) {
    let little = order == ByteOrder::Little;
    let mut writer = Writer::with_capacity(8);
    match (place.part, value) {
        (Part::Bits { lowest, width }, Value::Whole(number)) => {
            let mask = 0xff >> (8 - width);
            packet[place.byte] |= (*number as u8 & mask) << lowest;
            return;
        }
        (Part::Disputed { bit }, Value::Whole(number)) => {
            packet[place.byte + usize::from(little)] |= (*number as u8 & 1) << bit;
            return;
        }
        (_, Value::Whole(number)) => match (kind, little) {
            (Kind::U16, true) => writer.put_u16_le(*number as u16),
            (Kind::U16, false) => writer.put_u16_be(*number as u16),
            (Kind::U32, true) => writer.put_u32_le(*number as u32),
            (Kind::U32, false) => writer.put_u32_be(*number as u32),
            _ => writer.put_u8(*number as u8),
        },
        (_, Value::Single(number)) if little => writer.put_f32_le(*number),
        (_, Value::Single(number)) => writer.put_f32_be(*number),
        (_, Value::Double(number)) if little => writer.put_f64_le(*number),
        (_, Value::Double(number)) => writer.put_f64_be(*number),
        (_, Value::Text(text)) => text.chars().for_each(|c| writer.put_u8(u8::try_from(c).unwrap_or(b'?'))),
    }
    let bytes = writer.into_bytes();
    packet[place.byte..place.byte + bytes.len()].copy_from_slice(&bytes);
}
