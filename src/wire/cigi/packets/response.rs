//! Answers to the host's questions.

use crate::wire::cigi::layout::{at, bit, bits, fixed, sent};
use crate::wire::cigi::table::packets;

packets! {
    /// Answers a HAT/HOT Request for one height.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |     id = 102     |    size = 16     |             hat_hot_id              |
    ///    4 | c c c c . . b a  |        .         |        .         |        .         |
    ///    8 |                                  height                                   |
    ///   12 |                                 (height)                                  |
    ///      a valid, b response_type, c host_frame_number_lsn
    ///
    /// CIGI 4.0
    ///    0 |              size = 16              |             id = 0x0fff             |
    ///    4 | c c c c . . b a  |        .         |             hat_hot_id              |
    ///    8 |                                  height                                   |
    ///   12 |                                 (height)                                  |
    ///      a valid, b response_type, c host_frame_number_lsn
    /// ```
    HatHotResponse "HAT/HOT Response" IgToHost, fixed(102, 16), fixed(0x0fff, 16), {
        /// Hat hot id: from request.
        hat_hot_id: u16, at(2), at(6), sent("of the request");
        /// Valid: 0 Invalid, 1 Valid.
        valid: bool, bit(4, 0), bit(4, 0), sent("1, or 0 when there is no answer");
        /// Response type: 0 HAT, 1 HOT.
        response_type: bool, bit(4, 1), bit(4, 1), sent("as asked");
        /// Host frame number lsn: 0..15; low 4 bits of the Host Frame Number of the last IG Control used
        /// (meaningful for periodic requests).
        host_frame_number_lsn: u8, bits(4, 4, 4), bits(4, 4, 4), sent("low four bits of the host frame number that the answer belongs to");
        /// Height: m; HAT or HOT.
        height: f64, at(8), at(8), sent("height above terrain, or of terrain above mean sea level; 0 when not valid");
    }

    /// Answers a HAT/HOT Request of type Extended.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |     id = 103     |    size = 40     |             hat_hot_id              |
    ///    4 | b b b b . . . a  |        .         |        .         |        .         |
    ///    8 |                                    hat                                    |
    ///   12 |                                   (hat)                                   |
    ///   16 |                                    hot                                    |
    ///   20 |                                   (hot)                                   |
    ///   24 |                               material_code                               |
    ///   28 |                           normal_vector_azimuth                           |
    ///   32 |                          normal_vector_elevation                          |
    ///   36 |        .         |        .         |        .         |        .         |
    ///      a valid, b host_frame_number_lsn
    ///
    /// CIGI 4.0
    ///    0 |              size = 40              |             id = 0x0ffe             |
    ///    4 | b b b b . . . a  |        .         |             hat_hot_id              |
    ///    8 |                                    hat                                    |
    ///   12 |                                   (hat)                                   |
    ///   16 |                                    hot                                    |
    ///   20 |                                   (hot)                                   |
    ///   24 |                               material_code                               |
    ///   28 |                           normal_vector_azimuth                           |
    ///   32 |                          normal_vector_elevation                          |
    ///   36 |        .         |        .         |        .         |        .         |
    ///      a valid, b host_frame_number_lsn
    /// ```
    HatHotExtendedResponse "HAT/HOT Extended Response" IgToHost, fixed(103, 40), fixed(0x0ffe, 40), {
        /// Hat hot id: from request.
        hat_hot_id: u16, at(2), at(6), sent("of the request");
        /// Valid: 0 Invalid, 1 Valid.
        valid: bool, bit(4, 0), bit(4, 0), sent("1, or 0 when there is no answer");
        /// Host frame number lsn: 0..15; low 4 bits of the Host Frame Number of the last IG Control used
        /// (meaningful for periodic requests).
        host_frame_number_lsn: u8, bits(4, 4, 4), bits(4, 4, 4), sent("low four bits of the host frame number that the answer belongs to");
        /// Hat: m; height of test point above terrain.
        hat: f64, at(8), at(8), sent("height above terrain");
        /// Hot: m; terrain height above MSL.
        hot: f64, at(16), at(16), sent("height of terrain");
        /// Material code: IG-defined.
        material_code: u32, at(24), at(24), sent("1 land, 2 water");
        /// Normal vector azimuth: deg, -180..180.
        normal_vector_azimuth: f32, at(28), at(28), sent("of the ground");
        /// Normal vector elevation: deg, -90..90.
        normal_vector_elevation: f32, at(32), at(32), sent("of the ground");
    }

    /// Answers a basic line of sight request.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |     id = 104     |    size = 16     |               los_id                |
    ///    4 | d d d d . c b a  |  response_count  |              entity_id              |
    ///    8 |                                   range                                   |
    ///   12 |                                  (range)                                  |
    ///      a valid, b entity_id_valid, c visible, d host_frame_number_lsn
    ///
    /// CIGI 4.0
    ///    0 |              size = 24              |             id = 0x0ffd             |
    ///    4 |               los_id                |              entity_id              |
    ///    8 | d d d d . c b a  |  response_count  |        .         |        .         |
    ///   12 |        .         |        .         |        .         |        .         |
    ///   16 |                                   range                                   |
    ///   20 |                                  (range)                                  |
    ///      a valid, b entity_id_valid, c visible, d host_frame_number_lsn
    /// ```
    LineOfSightResponse "Line of Sight Response" IgToHost, fixed(104, 16), fixed(0x0ffd, 24), {
        /// Los id: from request.
        los_id: u16, at(2), at(4), sent("of the request");
        /// Valid: 0 Invalid, 1 Valid; 0 = no intersection / cannot compute.
        valid: bool, bit(4, 0), bit(8, 0), sent("1, or 0 when there is no answer");
        /// Entity id valid: 0 Invalid, 1 Valid; intersection is with an entity.
        entity_id_valid: bool, bit(4, 1), bit(8, 1), sent("0: entities are not drawn and hide nothing");
        /// Visible: 0 Occluded, 1 Visible; segment requests only.
        visible: bool, bit(4, 2), bit(8, 2), sent("1 when nothing hides the destination");
        /// Host frame number lsn: 0..15; low 4 bits of the Host Frame Number of the last IG Control used
        /// (meaningful for periodic requests).
        host_frame_number_lsn: u8, bits(4, 4, 4), bits(8, 4, 4), sent("low four bits of the host frame number that the answer belongs to");
        /// Response count: 1..255; number of response packets for this request.
        response_count: u8 = 1, at(5), at(9), sent("1");
        /// Entity id: entity id; if entity_id_valid.
        entity_id: u16, at(6), at(6), sent("0");
        /// Range: m, >=0.
        range: f64, at(8), at(16), sent("from the source to what hides, or to the destination");
    }

    /// Answers an extended line of sight request.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |     id = 105     |    size = 56     |               los_id                |
    ///    4 | e e e e d c b a  |  response_count  |              entity_id              |
    ///    8 |                                   range                                   |
    ///   12 |                                  (range)                                  |
    ///   16 |                                 lat_xoff                                  |
    ///   20 |                                (lat_xoff)                                 |
    ///   24 |                                 lon_yoff                                  |
    ///   28 |                                (lon_yoff)                                 |
    ///   32 |                                 alt_zoff                                  |
    ///   36 |                                (alt_zoff)                                 |
    ///   40 |       red        |      green       |       blue       |      alpha       |
    ///   44 |                               material_code                               |
    ///   48 |                           normal_vector_azimuth                           |
    ///   52 |                          normal_vector_elevation                          |
    ///      a valid, b entity_id_valid, c range_valid, d visible
    ///      e host_frame_number_lsn
    ///
    /// CIGI 4.0
    ///    0 |              size = 64              |             id = 0x0ffc             |
    ///    4 |               los_id                |              entity_id              |
    ///    8 | e e e e d c b a  |  response_count  |        .         |        .         |
    ///   12 |        .         |        .         |        .         |        .         |
    ///   16 |                                   range                                   |
    ///   20 |                                  (range)                                  |
    ///   24 |                                 lat_xoff                                  |
    ///   28 |                                (lat_xoff)                                 |
    ///   32 |                                 lon_yoff                                  |
    ///   36 |                                (lon_yoff)                                 |
    ///   40 |                                 alt_zoff                                  |
    ///   44 |                                (alt_zoff)                                 |
    ///   48 |       red        |      green       |       blue       |      alpha       |
    ///   52 |                               material_code                               |
    ///   56 |                           normal_vector_azimuth                           |
    ///   60 |                          normal_vector_elevation                          |
    ///      a valid, b entity_id_valid, c range_valid, d visible
    ///      e host_frame_number_lsn
    /// ```
    LineOfSightExtendedResponse "Line of Sight Extended Response" IgToHost, fixed(105, 56), fixed(0x0ffc, 64), {
        /// Los id: from request.
        los_id: u16, at(2), at(4), sent("of the request");
        /// Valid: 0 Invalid, 1 Valid.
        valid: bool, bit(4, 0), bit(8, 0), sent("1, or 0 when there is no answer");
        /// Entity id valid: 0 Invalid, 1 Valid.
        entity_id_valid: bool, bit(4, 1), bit(8, 1), sent("0: entities are not drawn and hide nothing");
        /// Range valid: 0 Invalid, 1 Valid.
        range_valid: bool, bit(4, 2), bit(8, 2), sent("1 when there is a point");
        /// Visible: 0 Occluded, 1 Visible; segment requests only.
        visible: bool, bit(4, 3), bit(8, 3), sent("1 when nothing hides the destination");
        /// Host frame number lsn: 0..15; low 4 bits of the Host Frame Number of the last IG Control used
        /// (meaningful for periodic requests).
        host_frame_number_lsn: u8, bits(4, 4, 4), bits(8, 4, 4), sent("low four bits of the host frame number that the answer belongs to");
        /// Response count: 1..255.
        response_count: u8 = 1, at(5), at(9), sent("1");
        /// Entity id: entity id.
        entity_id: u16, at(6), at(6), sent("0");
        /// Range: m, >=0; distance from source point.
        range: f64, at(8), at(16), sent("from the source to what hides, or to the destination");
        /// Lat xoff: deg / m, lat -90..90 / any; geodetic if entity_id_valid=0 or request asked Geodetic; else
        /// entity X/Y/Z.
        lat_xoff: f64, at(16), at(24), sent("the point");
        /// Lon yoff: deg / m, lon -180..180 / any; geodetic longitude, or Y offset.
        lon_yoff: f64, at(24), at(32), sent("the point");
        /// Alt zoff: m; altitude above MSL (or above terrain when clamped), or Z offset (Z down).
        alt_zoff: f64, at(32), at(40), sent("the point");
        /// Red: 0..255.
        red: u8, at(40), at(48), sent("colour of what hides");
        /// Green: 0..255.
        green: u8, at(41), at(49), sent("colour of what hides");
        /// Blue: 0..255.
        blue: u8, at(42), at(50), sent("colour of what hides");
        /// Alpha: 0..255.
        alpha: u8 = 255, at(43), at(51), sent("opacity up to the point, of 255");
        /// Material code: IG-defined.
        material_code: u32, at(44), at(52), sent("1 land, 2 water, 3 cloud, 0 nothing hides");
        /// Normal vector azimuth: deg, -180..180.
        normal_vector_azimuth: f32, at(48), at(56), sent("of the surface");
        /// Normal vector elevation: deg, -90..90.
        normal_vector_elevation: f32, at(52), at(60), sent("of the surface");
    }

    /// Air at a point.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |     id = 109     |    size = 32     |    request_id    |     humidity     |
    ///    4 |                              air_temperature                              |
    ///    8 |                             visibility_range                              |
    ///   12 |                           horizontal_wind_speed                           |
    ///   16 |                            vertical_wind_speed                            |
    ///   20 |                              wind_direction                               |
    ///   24 |                            barometric_pressure                            |
    ///   28 |        .         |        .         |        .         |        .         |
    ///
    /// CIGI 4.0
    ///    0 |              size = 32              |             id = 0x0ff8             |
    ///    4 |    request_id    |     humidity     |        .         |        .         |
    ///    8 |                              air_temperature                              |
    ///   12 |                             visibility_range                              |
    ///   16 |                           horizontal_wind_speed                           |
    ///   20 |                            vertical_wind_speed                            |
    ///   24 |                              wind_direction                               |
    ///   28 |                            barometric_pressure                            |
    /// ```
    WeatherConditionsResponse "Weather Conditions Response" IgToHost, fixed(109, 32), fixed(0x0ff8, 32), {
        /// Request id: from request.
        request_id: u8, at(2), at(4), sent("of the request");
        /// Humidity: %, 0..100.
        humidity: u8, at(3), at(5), sent("at the point");
        /// Air temperature: deg C.
        air_temperature: f32, at(4), at(8), sent("at the point");
        /// Visibility range: m, >=0.
        visibility_range: f32, at(8), at(12), sent("2.996 / extinction of the field that is drawn, haze and cloud (5 % contrast)");
        /// Horizontal wind speed: m/s, >=0.
        horizontal_wind_speed: f32, at(12), at(16), sent("at the point");
        /// Vertical wind speed: m/s; + = updraft.
        vertical_wind_speed: f32, at(16), at(20), sent("at the point");
        /// Wind direction: deg, 0..360; direction the wind blows FROM, from true north.
        wind_direction: f32, at(20), at(24), sent("at the point");
        /// Barometric pressure: mb (hPa), >=0.
        barometric_pressure: f32, at(24), at(28), sent("at the point");
    }

    /// Aerosol of one weather layer at a point.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |     id = 110     |     size = 8     |    request_id    |     layer_id     |
    ///    4 |                           aerosol_concentration                           |
    ///
    /// CIGI 4.0
    ///    0 |              size = 16              |             id = 0x0ff7             |
    ///    4 |    request_id    |     layer_id     |        .         |        .         |
    ///    8 |                           aerosol_concentration                           |
    ///   12 |        .         |        .         |        .         |        .         |
    /// ```
    AerosolConcentrationResponse "Aerosol Concentration Response" IgToHost, fixed(110, 8), fixed(0x0ff7, 16), {
        /// Request id: from request.
        request_id: u8, at(2), at(4), sent("of the request");
        /// Layer id: weather layer.
        layer_id: u8, at(3), at(5), sent("a layer at the point");
        /// Aerosol concentration: g/m^3, >=0; one packet per layer at the point.
        aerosol_concentration: f32, at(4), at(8), sent("of that layer");
    }
}
