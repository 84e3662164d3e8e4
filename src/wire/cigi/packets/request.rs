//! Questions of the host: heights, lines of sight, weather at a point.

use crate::wire::cigi::layout::{at, bit, bits, fixed, used};
use crate::wire::cigi::table::packets;

packets! {
    /// Asks for the height above terrain, of terrain, or both.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |     id = 24      |    size = 32     |             hat_hot_id              |
    ///    4 | . . . . . b a a  |  update_period   |              entity_id              |
    ///    8 |                                 lat_xoff                                  |
    ///   12 |                                (lat_xoff)                                 |
    ///   16 |                                 lon_yoff                                  |
    ///   20 |                                (lon_yoff)                                 |
    ///   24 |                                 alt_zoff                                  |
    ///   28 |                                (alt_zoff)                                 |
    ///      a request_type, b coordinate_system
    ///
    /// CIGI 4.0
    ///    0 |              size = 40              |             id = 0x0017             |
    ///    4 |             hat_hot_id              |              entity_id              |
    ///    8 | . . . . . b a a  |  update_period   |        .         |        .         |
    ///   12 |        .         |        .         |        .         |        .         |
    ///   16 |                                 lat_xoff                                  |
    ///   20 |                                (lat_xoff)                                 |
    ///   24 |                                 lon_yoff                                  |
    ///   28 |                                (lon_yoff)                                 |
    ///   32 |                                 alt_zoff                                  |
    ///   36 |                                (alt_zoff)                                 |
    ///      a request_type, b coordinate_system
    /// ```
    HatHotRequest "HAT/HOT Request" HostToIg, fixed(24, 32), fixed(0x0017, 40), {
        /// Hat hot id: 0..65535; copied to the response.
        hat_hot_id: u16, at(2), at(4), used("copied into the answer");
        /// Request type: 0 HAT, 1 HOT, 2 Extended; 2 is answered by the Extended Response.
        request_type: u8, bits(4, 0, 2), bits(8, 0, 2), used("HAT, HOT or both");
        /// Coordinate system: 0 Geodetic, 1 Entity.
        coordinate_system: bool, bit(4, 2), bit(8, 2), used("how the point is given");
        /// Update period: frames, 0..255; 0 = one response; n>0 = a response every n-th frame until cancelled (same
        /// id, period 0) or entity destroyed.
        update_period: u8, at(5), at(9), used("0: once; n: every n-th frame");
        /// Entity id: entity id; if coordinate_system = Entity.
        entity_id: u16, at(6), at(6), used("the entity whose axes the point is in");
        /// Lat xoff: deg / m, lat -90..90 / any; geodetic latitude, or X offset in the parent/entity frame.
        lat_xoff: f64, at(8), at(16), used("the point");
        /// Lon yoff: deg / m, lon -180..180 / any; geodetic longitude, or Y offset.
        lon_yoff: f64, at(16), at(24), used("the point");
        /// Alt zoff: m; altitude above MSL (or above terrain when clamped), or Z offset (Z down).
        alt_zoff: f64, at(24), at(32), used("the point");
    }

    /// Asks what hides one point from another.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |     id = 25      |    size = 64     |               los_id                |
    ///    4 | . . . e d c b a  | alpha_threshold  |          source_entity_id           |
    ///    8 |                              source_lat_xoff                              |
    ///   12 |                             (source_lat_xoff)                             |
    ///   16 |                              source_lon_yoff                              |
    ///   20 |                             (source_lon_yoff)                             |
    ///   24 |                              source_alt_zoff                              |
    ///   28 |                             (source_alt_zoff)                             |
    ///   32 |                           destination_lat_xoff                            |
    ///   36 |                          (destination_lat_xoff)                           |
    ///   40 |                           destination_lon_yoff                            |
    ///   44 |                          (destination_lon_yoff)                           |
    ///   48 |                           destination_alt_zoff                            |
    ///   52 |                          (destination_alt_zoff)                           |
    ///   56 |                               material_mask                               |
    ///   60 |  update_period   |        .         |        destination_entity_id        |
    ///      a request_type, b source_point_coordinate_system, c destination_point_coordinate_system, d response_coordinate_system
    ///      e destination_entity_id_valid
    ///
    /// CIGI 4.0
    ///    0 |              size = 72              |             id = 0x0018             |
    ///    4 |               los_id                |          source_entity_id           |
    ///    8 | . . . e d c b a  | alpha_threshold  |        destination_entity_id        |
    ///   12 |  update_period   |        .         |        .         |        .         |
    ///   16 |                              source_lat_xoff                              |
    ///   20 |                             (source_lat_xoff)                             |
    ///   24 |                              source_lon_yoff                              |
    ///   28 |                             (source_lon_yoff)                             |
    ///   32 |                              source_alt_zoff                              |
    ///   36 |                             (source_alt_zoff)                             |
    ///   40 |                           destination_lat_xoff                            |
    ///   44 |                          (destination_lat_xoff)                           |
    ///   48 |                           destination_lon_yoff                            |
    ///   52 |                          (destination_lon_yoff)                           |
    ///   56 |                           destination_alt_zoff                            |
    ///   60 |                          (destination_alt_zoff)                           |
    ///   64 |                               material_mask                               |
    ///   68 |        .         |        .         |        .         |        .         |
    ///      a request_type, b source_point_coordinate_system, c destination_point_coordinate_system, d response_coordinate_system
    ///      e destination_entity_id_valid
    /// ```
    LineOfSightSegmentRequest "Line of Sight Segment Request" HostToIg, fixed(25, 64), fixed(0x0018, 72), {
        /// Los id: 0..65535; shared id space with Vector Request.
        los_id: u16, at(2), at(4), used("copied into the answer");
        /// Request type: 0 Basic, 1 Extended; selects LOS Response or LOS Extended Response.
        request_type: bool, bit(4, 0), bit(8, 0), used("basic or extended answer");
        /// Source point coordinate system: 0 Geodetic, 1 Entity.
        source_point_coordinate_system: bool, bit(4, 1), bit(8, 1), used("how the source is given");
        /// Destination point coordinate system: 0 Geodetic, 1 Entity.
        destination_point_coordinate_system: bool, bit(4, 2), bit(8, 2), used("how the destination is given");
        /// Response coordinate system: 0 Geodetic, 1 Entity.
        response_coordinate_system: bool, bit(4, 3), bit(8, 3), used("how the extended answer gives the point");
        /// Destination entity id valid: 0 Not Valid, 1 Valid; if dest. system = Entity: 0 = relative to source
        /// entity, 1 = to destination entity.
        destination_entity_id_valid: bool, bit(4, 4), bit(8, 4), used("whether the destination is in the axes of another entity");
        /// Alpha threshold: 0..255; minimum opacity that counts as an intersection.
        alpha_threshold: u8, at(5), at(9), used("opacity of cloud, of 255, that hides");
        /// Source entity id: entity id.
        source_entity_id: u16, at(6), at(6), used("axes of the source");
        /// Source lat xoff: deg / m, lat -90..90 / any; geodetic latitude, or X offset in the parent/entity frame.
        source_lat_xoff: f64, at(8), at(16), used("the source");
        /// Source lon yoff: deg / m, lon -180..180 / any; geodetic longitude, or Y offset.
        source_lon_yoff: f64, at(16), at(24), used("the source");
        /// Source alt zoff: m; altitude above MSL (or above terrain when clamped), or Z offset (Z down).
        source_alt_zoff: f64, at(24), at(32), used("the source");
        /// Destination lat xoff: deg / m, lat -90..90 / any; geodetic latitude, or X offset in the parent/entity
        /// frame.
        destination_lat_xoff: f64, at(32), at(40), used("the destination");
        /// Destination lon yoff: deg / m, lon -180..180 / any; geodetic longitude, or Y offset.
        destination_lon_yoff: f64, at(40), at(48), used("the destination");
        /// Destination alt zoff: m; altitude above MSL (or above terrain when clamped), or Z offset (Z down).
        destination_alt_zoff: f64, at(48), at(56), used("the destination");
        /// Material mask: bit mask; material ranges that count; IG-defined.
        material_mask: u32, at(56), at(64), used("bit 0 land, bit 1 water, bit 2 cloud: what may hide; 0: all");
        /// Update period: frames, 0..255; 0 = one response; n>0 = a response every n-th frame until cancelled (same
        /// id, period 0) or entity destroyed.
        update_period: u8, at(60), at(12), used("0: once; n: every n-th frame");
        /// Destination entity id: entity id.
        destination_entity_id: u16, at(62), at(10), used("axes of the destination");
    }

    /// Asks what a ray meets first.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |     id = 26      |    size = 56     |               los_id                |
    ///    4 | . . . . . c b a  | alpha_threshold  |              entity_id              |
    ///    8 |                                  azimuth                                  |
    ///   12 |                                 elevation                                 |
    ///   16 |                               minimum_range                               |
    ///   20 |                               maximum_range                               |
    ///   24 |                              source_lat_xoff                              |
    ///   28 |                             (source_lat_xoff)                             |
    ///   32 |                              source_lon_yoff                              |
    ///   36 |                             (source_lon_yoff)                             |
    ///   40 |                              source_alt_zoff                              |
    ///   44 |                             (source_alt_zoff)                             |
    ///   48 |                               material_mask                               |
    ///   52 |  update_period   |        .         |        .         |        .         |
    ///      a request_type, b source_point_coordinate_system, c response_coordinate_system
    ///
    /// CIGI 4.0
    ///    0 |              size = 64              |             id = 0x0019             |
    ///    4 |               los_id                |              entity_id              |
    ///    8 | . . . . . c b a  | alpha_threshold  |  update_period   |        .         |
    ///   12 |        .         |        .         |        .         |        .         |
    ///   16 |                                  azimuth                                  |
    ///   20 |                                 elevation                                 |
    ///   24 |                               minimum_range                               |
    ///   28 |                               maximum_range                               |
    ///   32 |                              source_lat_xoff                              |
    ///   36 |                             (source_lat_xoff)                             |
    ///   40 |                              source_lon_yoff                              |
    ///   44 |                             (source_lon_yoff)                             |
    ///   48 |                              source_alt_zoff                              |
    ///   52 |                             (source_alt_zoff)                             |
    ///   56 |                               material_mask                               |
    ///   60 |        .         |        .         |        .         |        .         |
    ///      a request_type, b source_point_coordinate_system, c response_coordinate_system
    /// ```
    LineOfSightVectorRequest "Line of Sight Vector Request" HostToIg, fixed(26, 56), fixed(0x0019, 64), {
        /// Los id: 0..65535.
        los_id: u16, at(2), at(4), used("copied into the answer");
        /// Request type: 0 Basic, 1 Extended.
        request_type: bool, bit(4, 0), bit(8, 0), used("basic or extended answer");
        /// Source point coordinate system: 0 Geodetic, 1 Entity.
        source_point_coordinate_system: bool, bit(4, 1), bit(8, 1), used("how the source is given");
        /// Response coordinate system: 0 Geodetic, 1 Entity.
        response_coordinate_system: bool, bit(4, 2), bit(8, 2), used("how the extended answer gives the point");
        /// Alpha threshold: 0..255; minimum opacity that counts as an intersection.
        alpha_threshold: u8, at(5), at(9), used("opacity of cloud, of 255, that hides");
        /// Entity id: entity id.
        entity_id: u16, at(6), at(6), used("axes of the source");
        /// Azimuth: deg, -180..180; from north, or from entity X axis.
        azimuth: f32, at(8), at(16), used("direction");
        /// Elevation: deg, -90..90; + up.
        elevation: f32, at(12), at(20), used("direction");
        /// Minimum range: m, >=0.
        minimum_range: f32, at(16), at(24), used("nothing nearer hides");
        /// Maximum range: m, > minimum.
        maximum_range: f32, at(20), at(28), used("nothing farther hides");
        /// Source lat xoff: deg / m, lat -90..90 / any; geodetic latitude, or X offset in the parent/entity frame.
        source_lat_xoff: f64, at(24), at(32), used("the source");
        /// Source lon yoff: deg / m, lon -180..180 / any; geodetic longitude, or Y offset.
        source_lon_yoff: f64, at(32), at(40), used("the source");
        /// Source alt zoff: m; altitude above MSL (or above terrain when clamped), or Z offset (Z down).
        source_alt_zoff: f64, at(40), at(48), used("the source");
        /// Material mask: bit mask.
        material_mask: u32, at(48), at(56), used("bit 0 land, bit 1 water, bit 2 cloud: what may hide; 0: all");
        /// Update period: frames, 0..255; 0 = one response; n>0 = a response every n-th frame until cancelled (same
        /// id, period 0) or entity destroyed.
        update_period: u8, at(52), at(10), used("0: once; n: every n-th frame");
    }

    /// Asks for the weather at a point.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |     id = 28      |    size = 32     | . . . . a a a a  |    request_id    |
    ///    4 |        .         |        .         |        .         |        .         |
    ///    8 |                                 latitude                                  |
    ///   12 |                                (latitude)                                 |
    ///   16 |                                 longitude                                 |
    ///   20 |                                (longitude)                                |
    ///   24 |                                 altitude                                  |
    ///   28 |                                (altitude)                                 |
    ///      a request_type
    ///
    /// CIGI 4.0
    ///    0 |              size = 32              |             id = 0x001b             |
    ///    4 | . . . . a a a a  |    request_id    |        .         |        .         |
    ///    8 |                                 latitude                                  |
    ///   12 |                                (latitude)                                 |
    ///   16 |                                 longitude                                 |
    ///   20 |                                (longitude)                                |
    ///   24 |                                 altitude                                  |
    ///   28 |                                (altitude)                                 |
    ///      a request_type
    /// ```
    EnvironmentalConditionsRequest "Environmental Conditions Request" HostToIg, fixed(28, 32), fixed(0x001b, 32), {
        /// Request type: bit mask: 1 Maritime, 2 Terrestrial, 4 Weather, 8 Aerosol; OR of the bits.
        request_type: u8 = 1, bits(2, 0, 4), bits(4, 0, 4), used("4 weather and 8 aerosol are answered; 1 maritime and 2 terrestrial are not");
        /// Request id: 0..255; copied to every response.
        request_id: u8, at(3), at(5), used("copied into the answer");
        /// Latitude: deg, -90..90.
        latitude: f64, at(8), at(8), used("the point");
        /// Longitude: deg, -180..180.
        longitude: f64, at(16), at(16), used("the point");
        /// Altitude: m; MSL; used for weather and aerosol.
        altitude: f64, at(24), at(24), used("the point");
    }
}
