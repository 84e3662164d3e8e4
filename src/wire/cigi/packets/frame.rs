//! The first packet of every message: IG Control from the host, Start of Frame from the image generator.

use crate::wire::cigi::layout::{absent, at, bit, bits, disputed, fixed, ignored, sent, used};
use crate::wire::cigi::table::packets;

packets! {
    /// Opens a message of the host: mode, frame numbers and time.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |      id = 1      |    size = 24     |  major_version   | database_number  |
    ///    4 | d d d d c b a a  |        .         |           byte_swap_magic           |
    ///    8 |                             host_frame_number                             |
    ///   12 |                                 timestamp                                 |
    ///   16 |                           last_ig_frame_number                            |
    ///   20 |        .         |        .         |        .         |        .         |
    ///      a ig_mode, b timestamp_valid, c extrapolation_interpolation_enable, d minor_version
    ///
    /// CIGI 4.0
    ///    0 |              size = 24              |             id = 0x0000             |
    ///    4 |  major_version   | database_number  | . . . . . . . e  | d d d d c b a a  |
    ///    8 |                             host_frame_number                             |
    ///   12 |                           last_ig_frame_number                            |
    ///   16 |                                 timestamp                                 |
    ///   20 |        .         |        .         |        .         |        .         |
    ///      a ig_mode, b timestamp_valid, c extrapolation_interpolation_enable, d minor_version
    ///      e entity_type_substitution_enable
    /// ```
    IgControl "IG Control" HostToIg, fixed(1, 24), fixed(0x0000, 24), {
        /// Major version: 3 or 4.
        major_version: u8, at(2), at(4), used("tells the version");
        /// Database number: 0 none/acknowledge, 1..127 load; ignored in Reset/Standby.
        database_number: i8, at(3), at(5), used("asks for a database, or acknowledges");
        /// Ig mode: 0 Reset/Standby, 1 Operate, 2 Debug; mode request.
        ig_mode: u8, bits(4, 0, 2), bits(7, 0, 2), used("the mode asked for");
        /// Timestamp valid: 0 Invalid, 1 Valid; must be 1 in asynchronous operation.
        timestamp_valid: bool, bit(4, 2), bit(7, 2), used("whether the time stamp counts");
        /// Extrapolation interpolation enable: 0 Disable, 1 Enable; global switch (3.3).
        extrapolation_interpolation_enable: bool, bit(4, 3), bit(7, 3), used("with the flag of an entity: it moves on between messages");
        /// Minor version: 3 (2 is accepted alike), in 4.0 0.
        minor_version: u8, bits(4, 4, 4), bits(7, 4, 4), used("tells the version; 3.2 and 3.3 are alike");
        /// Byte swap magic: 0x8000; bytes 00 80 = little endian, 80 00 = big endian.
        byte_swap_magic: u16 = 0x8000, at(6), absent(), used("tells the byte order");
        /// Host frame number: 0..2^32-1; +1 per host message.
        host_frame_number: u32, at(8), at(8), used("returned in Start of Frame; gaps count as lost messages");
        /// Timestamp: 10 us, wraps after ~11.9 h.
        timestamp: u32, at(12), at(16), used("time between positions, from which motion follows");
        /// Last ig frame number: 0..2^32-1; IG Frame Number of the last SOF received.
        last_ig_frame_number: u32, at(16), at(12), used("delay of the host in our frames; in synchronous operation whether the newest Start of Frame is answered");
        /// Entity type substitution enable: 0 Disable, 1 Enable; IG may substitute an unknown entity type.
        entity_type_substitution_enable: bool, absent(), bit(6, 0), ignored("no models are drawn");
    }

    /// Opens a message of the image generator: its mode, frame numbers and time.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |     id = 101     |    size = 24     |  major_version   | database_number  |
    ///    4 |  ig_status_code  | d d d d c b a a  |           byte_swap_magic           |
    ///    8 |                              ig_frame_number                              |
    ///   12 |                                 timestamp                                 |
    ///   16 |                          last_host_frame_number                           |
    ///   20 |        .         |        .         |        .         |        .         |
    ///      a ig_mode, b timestamp_valid, c earth_reference_model, d minor_version
    ///
    /// CIGI 4.0
    ///    0 |              size = 24              |             id = 0xffff             |
    ///    4 |  major_version   | database_number  |        .         | d d d d c b a a  |
    ///    8 |                              ig_frame_number                              |
    ///   12 |                                 timestamp                                 |
    ///   16 |                          last_host_frame_number                           |
    ///   20 | . . . . . g f e  |        .         |        .         |        .         |
    ///      a ig_mode, b timestamp_valid, c earth_reference_model, d minor_version
    ///      e overframing, f paging, g excessive_variable_length_data
    /// ```
    StartOfFrame "Start of Frame" IgToHost, fixed(101, 24), fixed(0xffff, 24), {
        /// Major version: 3 or 4.
        major_version: u8, at(2), at(4), sent("3 or 4");
        /// Database number: 0 IG-controlled, 1..127 loaded, -1..-127 loading, -128 not available.
        database_number: i8, at(3), at(5), sent("0, or the state of the database asked for");
        /// Ig status code: 0 normal, 1..255 IG-specific error.
        ig_status_code: u8, at(4), absent(), sent("0");
        /// Ig mode: 0 Reset/Standby, 1 Operate, 2 Debug, 3 Offline Maintenance; current mode.
        ig_mode: u8, bits(5, 0, 2), bits(7, 0, 2), sent("the mode now");
        /// Timestamp valid: 0 Invalid, 1 Valid.
        timestamp_valid: bool, bit(5, 2), bit(7, 2), sent("1");
        /// Earth reference model: 0 WGS 84, 1 Host-Defined.
        earth_reference_model: bool, bit(5, 3), bit(7, 3), sent("0: WGS 84");
        /// Minor version: 3 (2 is accepted alike), in 4.0 0.
        minor_version: u8, bits(5, 4, 4), bits(7, 4, 4), sent("3, or 0 in 4.0");
        /// Byte swap magic: 0x8000.
        byte_swap_magic: u16 = 0x8000, at(6), absent(), sent("0x8000");
        /// Ig frame number: 0..2^32-1; +1 per SOF.
        ig_frame_number: u32, at(8), at(8), sent("+1 a message");
        /// Timestamp: 10 us, wraps after ~11.9 h.
        timestamp: u32, at(12), at(12), sent("10 microsecond ticks since the server began");
        /// Last host frame number: 0..2^32-1; Host Frame Number of the last IG Control received.
        last_host_frame_number: u32, at(16), at(16), sent("of the last IG Control received");
        /// Overframing: 0/1; position disputed,.
        overframing: bool, absent(), disputed(20, 0), sent("1 when this message is later than half a frame");
        /// Paging: 0/1.
        paging: bool, absent(), disputed(20, 1), sent("0: nothing is paged in");
        /// Excessive variable length data: 0/1.
        excessive_variable_length_data: bool, absent(), disputed(20, 2), sent("1 when answers wait because they did not fit one datagram");
    }
}
