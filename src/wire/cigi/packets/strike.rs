//! Our user-defined packets: a lightning strike with place, current, polarity, strokes and time.

use crate::wire::cigi::layout::{at, fixed, used};
use crate::wire::cigi::table::packets;

packets! {
    /// Lightning strikes with the next picture.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |     id = 201     |    size = 40     |              strike_id              |
    ///    4 |      flags       |  return_strokes  |        .         |        .         |
    ///    8 |                                 latitude                                  |
    ///   12 |                                (latitude)                                 |
    ///   16 |                                 longitude                                 |
    ///   20 |                                (longitude)                                |
    ///   24 |                                 altitude                                  |
    ///   28 |                                (altitude)                                 |
    ///   32 |                              peak_current_ka                              |
    ///   36 |                           channel_top_altitude                            |
    ///
    /// CIGI 4.0
    ///    0 |              size = 40              |             id = 0x8001             |
    ///    4 |              strike_id              |      flags       |  return_strokes  |
    ///    8 |                                 latitude                                  |
    ///   12 |                                (latitude)                                 |
    ///   16 |                                 longitude                                 |
    ///   20 |                                (longitude)                                |
    ///   24 |                                 altitude                                  |
    ///   28 |                                (altitude)                                 |
    ///   32 |                              peak_current_ka                              |
    ///   36 |                           channel_top_altitude                            |
    /// ```
    Strike "User-Defined 201" HostToIg, fixed(201, 40), fixed(0x8001, 40).called("User-Defined 0x8001"), {
        /// Strike id.
        strike_id: u16, at(2), at(4), used("number of the strike, returned in Event Notification");
        /// Flags: bit 0: cloud to ground, else inside the cloud.
        flags: u8, at(4), at(6), used("kind of flash");
        /// Return strokes: 0: drawn by chance.
        return_strokes: u8, at(5), at(7), used("number of strokes");
        /// Latitude: deg, -90..90.
        latitude: f64, at(8), at(8), used("place");
        /// Longitude: deg, -180..180.
        longitude: f64, at(16), at(16), used("place");
        /// Altitude: m above mean sea level.
        altitude: f64, at(24), at(24), used("height of the light");
        /// Peak current ka: kA; the sign is the polarity; 0: drawn by chance.
        peak_current_ka: f32, at(32), at(32), used("current of the first stroke and polarity");
        /// Channel top altitude: m above mean sea level.
        channel_top_altitude: f32, at(36), at(36), used("height of the light, where the altitude is that of the ground: half-way up the channel");
    }

    /// Lightning strikes a given time from now.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |     id = 202     |    size = 48     |              strike_id              |
    ///    4 |      flags       |  return_strokes  |        .         |        .         |
    ///    8 |                                 latitude                                  |
    ///   12 |                                (latitude)                                 |
    ///   16 |                                 longitude                                 |
    ///   20 |                                (longitude)                                |
    ///   24 |                                 altitude                                  |
    ///   28 |                                (altitude)                                 |
    ///   32 |                              peak_current_ka                              |
    ///   36 |                           channel_top_altitude                            |
    ///   40 |                                   delay                                   |
    ///   44 |        .         |        .         |        .         |        .         |
    ///
    /// CIGI 4.0
    ///    0 |              size = 48              |             id = 0x8002             |
    ///    4 |              strike_id              |      flags       |  return_strokes  |
    ///    8 |                                 latitude                                  |
    ///   12 |                                (latitude)                                 |
    ///   16 |                                 longitude                                 |
    ///   20 |                                (longitude)                                |
    ///   24 |                                 altitude                                  |
    ///   28 |                                (altitude)                                 |
    ///   32 |                              peak_current_ka                              |
    ///   36 |                           channel_top_altitude                            |
    ///   40 |                                   delay                                   |
    ///   44 |        .         |        .         |        .         |        .         |
    /// ```
    TimedStrike "User-Defined 202" HostToIg, fixed(202, 48), fixed(0x8002, 48).called("User-Defined 0x8002"), {
        /// Strike id.
        strike_id: u16, at(2), at(4), used("number of the strike, returned in Event Notification");
        /// Flags: bit 0: cloud to ground, else inside the cloud.
        flags: u8, at(4), at(6), used("kind of flash");
        /// Return strokes: 0: drawn by chance.
        return_strokes: u8, at(5), at(7), used("number of strokes");
        /// Latitude: deg, -90..90.
        latitude: f64, at(8), at(8), used("place");
        /// Longitude: deg, -180..180.
        longitude: f64, at(16), at(16), used("place");
        /// Altitude: m above mean sea level.
        altitude: f64, at(24), at(24), used("height of the light");
        /// Peak current ka: kA; the sign is the polarity; 0: drawn by chance.
        peak_current_ka: f32, at(32), at(32), used("current of the first stroke and polarity");
        /// Channel top altitude: m above mean sea level.
        channel_top_altitude: f32, at(36), at(36), used("height of the light, where the altitude is that of the ground: half-way up the channel");
        /// Delay: s, 0..3600.
        delay: f32, at(40), at(40), used("seconds of simulation from this message to the strike");
    }
}
