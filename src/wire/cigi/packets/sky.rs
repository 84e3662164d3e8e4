//! The sky and the air everywhere: time, sun, moon, stars, haze.

use crate::wire::cigi::layout::{absent, at, bit, bits, fixed, ignored, used};
use crate::wire::cigi::table::packets;

packets! {
    /// Date, time of day, sun, moon and stars.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |      id = 9      |    size = 16     |       hour       |      minute      |
    ///    4 | . . . e d c b a  |        .         |        .         |        .         |
    ///    8 |                                   date                                    |
    ///   12 |                           star_field_intensity                            |
    ///      a ephemeris_model_enable, b sun_enable, c moon_enable, d star_field_enable
    ///      e date_time_valid
    ///
    /// CIGI 4.0
    ///    0 |              size = 24              |             id = 0x0008             |
    ///    4 | . . . e d c b a  |        .         |       hour       |      minute      |
    ///    8 |                                  seconds                                  |
    ///   12 |                                   date                                    |
    ///   16 |                           star_field_intensity                            |
    ///   20 |        .         |        .         |        .         |        .         |
    ///      a continuous_time_of_day_enable, b sun_enable, c moon_enable, d star_field_enable
    ///      e date_time_valid
    /// ```
    CelestialSphereControl "Celestial Sphere Control" HostToIg, fixed(9, 16), fixed(0x0008, 24), {
        /// Hour: h, 0..23; UTC.
        hour: u8, at(2), at(6), used("time of day, UTC");
        /// Minute: min, 0..59.
        minute: u8, at(3), at(7), used("time of day, UTC");
        /// Continuous time of day enable: 0 Disable, 1 Enable; 1 = IG advances time of day itself.
        continuous_time_of_day_enable: bool, bit(4, 0).called("ephemeris_model_enable"), bit(4, 0), used("1: time runs; 0: it stands");
        /// Sun enable: 0 Disable, 1 Enable.
        sun_enable: bool, bit(4, 1), bit(4, 1), used("0: no sun and no sunlight");
        /// Moon enable: 0 Disable, 1 Enable.
        moon_enable: bool, bit(4, 2), bit(4, 2), used("0: no moon");
        /// Star field enable: 0 Disable, 1 Enable.
        star_field_enable: bool, bit(4, 3), bit(4, 3), used("0: no starlight");
        /// Date time valid: 0 Invalid, 1 Valid; 0 = ignore hour, minute, date.
        date_time_valid: bool, bit(4, 4), bit(4, 4), used("whether date and time count");
        /// Date: MMDDYYYY decimal; month*1000000 + day*10000 + year.
        date: u32 = 1_012_000, at(8), at(12), used("the date, UTC");
        /// Star field intensity: %, 0..100.
        star_field_intensity: f32, at(12), at(16), used("how much the stars add to the light of the night; they are not drawn one by one");
        /// Seconds: s, 0..59.999..; new in 4.0.
        seconds: f32, absent(), at(8), used("time of day, UTC");
    }

    /// The air where no weather layer says otherwise.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |     id = 10      |    size = 32     | . . . . . . . a  | global_humidity  |
    ///    4 |                          global_air_temperature                           |
    ///    8 |                          global_visibility_range                          |
    ///   12 |                       global_horizontal_wind_speed                        |
    ///   16 |                        global_vertical_wind_speed                         |
    ///   20 |                           global_wind_direction                           |
    ///   24 |                        global_barometric_pressure                         |
    ///   28 |        .         |        .         |        .         |        .         |
    ///      a atmospheric_model_enable
    ///
    /// CIGI 4.0
    ///    0 |              size = 32              |             id = 0x0009             |
    ///    4 | a b b b b b b b  |        .         |        .         |        .         |
    ///    8 |                          global_air_temperature                           |
    ///   12 |                          global_visibility_range                          |
    ///   16 |                       global_horizontal_wind_speed                        |
    ///   20 |                        global_vertical_wind_speed                         |
    ///   24 |                           global_wind_direction                           |
    ///   28 |                        global_barometric_pressure                         |
    ///      a atmospheric_model_enable, b global_humidity
    /// ```
    AtmosphereControl "Atmosphere Control" HostToIg, fixed(10, 32), fixed(0x0009, 32), {
        /// Atmospheric model enable: 0 Disable, 1 Enable; sensor radiance model.
        atmospheric_model_enable: bool, bit(2, 0), bit(4, 7), ignored("the sky is always computed");
        /// Global humidity: %, 0..100.
        global_humidity: u8 = 30, at(3), bits(4, 0, 7), used("answered by Weather Conditions");
        /// Global air temperature: deg C.
        global_air_temperature: f32, at(4), at(8), used("answered by Weather Conditions");
        /// Global visibility range: m, >=0.
        global_visibility_range: f32 = 64_373.76, at(8), at(12), used("haze");
        /// Global horizontal wind speed: m/s, >=0.
        global_horizontal_wind_speed: f32, at(12), at(16), used("answered by Weather Conditions outside layers");
        /// Global vertical wind speed: m/s; + = updraft.
        global_vertical_wind_speed: f32, at(16), at(20), used("answered by Weather Conditions outside layers");
        /// Global wind direction: deg, 0..360; direction the wind blows FROM, from true north.
        global_wind_direction: f32, at(20), at(24), used("answered by Weather Conditions outside layers");
        /// Global barometric pressure: mb (hPa), >=0.
        global_barometric_pressure: f32 = 1013.25, at(24), at(28), used("answered by Weather Conditions: pressure at mean sea level");
    }
}
