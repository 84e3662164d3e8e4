//! CIGI 3.3 and 4.0: the Common Image Generator Interface, bytes to plain packets and back, in either byte order.
//!
//! A message is one datagram: packets one behind the other, each a multiple of 8 bytes, the first an IG Control (host to
//! image generator) or a Start of Frame (back). [`packets`] describes each packet once; [`message`] walks a message;
//! [`json`] shows one; [`describe`] writes the pages of `protocol/`. The meaning of the packets is not known here.

pub mod describe;
pub mod json;
pub mod layout;
pub mod message;
pub mod others;
pub mod packets;
pub mod scene;
pub mod table;

pub use message::{Message, Rejected, Skipped, decode, decode_packets, encode};
pub use packets::Packet;

/// A version of the standard. The minor versions 2 and 3 of CIGI 3 are alike on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// CIGI 3.2 and 3.3.
    V3,
    /// CIGI 4.0 (SISO-STD-013).
    V4,
}

/// Which end of a number comes first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ByteOrder {
    /// Least significant byte first.
    #[default]
    Little,
    /// Most significant byte first.
    Big,
}

/// Who sends a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From the host.
    HostToIg,
    /// From the image generator.
    IgToHost,
}

impl Version {
    /// Both.
    pub const ALL: [Self; 2] = [Self::V3, Self::V4];

    /// As people write it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::V3 => "3.3",
            Self::V4 => "4.0",
        }
    }

    /// Major and minor version that we send.
    pub const fn numbers(self) -> [u8; 2] {
        match self {
            Self::V3 => [3, 3],
            Self::V4 => [4, 0],
        }
    }

    /// Bytes of a packet's header.
    pub const fn header_bytes(self) -> usize {
        match self {
            Self::V3 => 2,
            Self::V4 => 4,
        }
    }
}

impl ByteOrder {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Little, Self::Big];

    /// As people write it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Little => "little",
            Self::Big => "big",
        }
    }
}

#[cfg(test)]
mod tests;
