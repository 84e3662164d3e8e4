//! Weather layers and the regions that they may be bound to.

use crate::wire::cigi::layout::{absent, at, bit, bits, fixed, ignored, used};
use crate::wire::cigi::table::packets;

packets! {
    /// One weather layer: of the globe, of a region or of an entity.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |     id = 12      |    size = 56     |          entity_region_id           |
    ///    4 |     layer_id     |     humidity     | e e e e d c b a  | . . . g g g f f  |
    ///    8 |                              air_temperature                              |
    ///   12 |                             visibility_range                              |
    ///   16 |                              scud_frequency                               |
    ///   20 |                                 coverage                                  |
    ///   24 |                              base_elevation                               |
    ///   28 |                                 thickness                                 |
    ///   32 |                              transition_band                              |
    ///   36 |                           horizontal_wind_speed                           |
    ///   40 |                            vertical_wind_speed                            |
    ///   44 |                              wind_direction                               |
    ///   48 |                            barometric_pressure                            |
    ///   52 |                           aerosol_concentration                           |
    ///      a weather_enable, b scud_enable, c random_winds_enable, d random_lightning_enable
    ///      e cloud_type, f scope, g severity
    ///
    /// CIGI 4.0
    ///    0 |              size = 72              |             id = 0x000b             |
    ///    4 |     layer_id     |     humidity     | e e e e d c b a  | . . h g g g f f  |
    ///    8 |          entity_region_id           |        .         |        .         |
    ///   12 |                              air_temperature                              |
    ///   16 |                             visibility_range                              |
    ///   20 |                           bottom_scud_frequency                           |
    ///   24 |                                 coverage                                  |
    ///   28 |                              base_elevation                               |
    ///   32 |                                 thickness                                 |
    ///   36 |                          bottom_transition_band                           |
    ///   40 |                           horizontal_wind_speed                           |
    ///   44 |                            vertical_wind_speed                            |
    ///   48 |                              wind_direction                               |
    ///   52 |                            barometric_pressure                            |
    ///   56 |                           aerosol_concentration                           |
    ///   60 |                            top_scud_frequency                             |
    ///   64 |                            top_transition_band                            |
    ///   68 |        .         |        .         |        .         |        .         |
    ///      a weather_enable, b bottom_scud_enable, c random_winds_enable, d random_lightning_enable
    ///      e cloud_type, f scope, g severity, h top_scud_enable
    /// ```
    WeatherControl "Weather Control" HostToIg, fixed(12, 56), fixed(0x000b, 72), {
        /// Entity region id: entity id / region id; by scope; ignored (0) for Global.
        entity_region_id: u16, at(2), at(8), used("which region or entity");
        /// Layer id: 0 Ground Fog, 1-3 Cloud Layer 1-3, 4 Rain, 5 Snow, 6 Sleet, 7 Hail, 8 Sand, 9 Dust, 10-255 IG-
        /// defined; ignored for scope Entity.
        layer_id: u8, at(4), at(4), used("which layer: 0 ground fog, 1 to 3 and 11 to 15 cloud, 10 a strike of lightning each time; others count for answers alone");
        /// Humidity: %, 0..100.
        humidity: u8, at(5), at(5), used("answered by Weather Conditions in the layer");
        /// Weather enable: 0 Disable, 1 Enable.
        weather_enable: bool, bit(6, 0), bit(6, 0), used("0: the layer is gone");
        /// Bottom scud enable: 0 Disable, 1 Enable.
        bottom_scud_enable: bool, bit(6, 1).called("scud_enable"), bit(6, 1), used("whether scud hangs below the base");
        /// Random winds enable: 0 Disable, 1 Enable.
        random_winds_enable: bool, bit(6, 2), bit(6, 2), ignored("gusts move nothing that is drawn");
        /// Random lightning enable: 0 Disable, 1 Enable; rate/strength follow severity.
        random_lightning_enable: bool, bit(6, 3), bit(6, 3), used("a seeded storm in the extent of the layer");
        /// Cloud type: 0 None, 1 Altocumulus, 2 Altostratus, 3 Cirrocumulus, 4 Cirrostratus, 5 Cirrus, 6
        /// Cumulonimbus, 7 Cumulus, 8 Nimbostratus, 9 Stratocumulus, 10 Stratus, 11-15 Other.
        cloud_type: u8, bits(6, 4, 4), bits(6, 4, 4), used("one of ten genera; 0: no cloud; 11 to 15: stratocumulus, altostratus or cirrostratus by the height of the base");
        /// Scope: 0 Global, 1 Regional, 2 Entity.
        scope: u8, bits(7, 0, 2), bits(7, 0, 2), used("global, regional or of an entity");
        /// Severity: 0 least..5 most severe.
        severity: u8, bits(7, 2, 3), bits(7, 2, 3), used("rate and strength of the storm");
        /// Air temperature: deg C.
        air_temperature: f32, at(8), at(12), used("answered by Weather Conditions in the layer");
        /// Visibility range: m, >=0; inside the layer.
        visibility_range: f32, at(12), at(16), used("extinction in the layer: 2.996 / visibility (5 % contrast); 0: that of the genus");
        /// Bottom scud frequency: %, 0..100.
        bottom_scud_frequency: f32, at(16).called("scud_frequency"), at(20), used("coverage of the scud below the base");
        /// Coverage: %, 0..100.
        coverage: f32, at(20), at(24), used("share of the sky");
        /// Base elevation: m; MSL.
        base_elevation: f32, at(24), at(28), used("base");
        /// Thickness: m, >=0.
        thickness: f32, at(28), at(32), used("thickness");
        /// Bottom transition band: m, >=0; above and below the layer.
        bottom_transition_band: f32, at(32).called("transition_band"), at(36), used("thinner cloud below the base (3.3: and above the top)");
        /// Horizontal wind speed: m/s, >=0.
        horizontal_wind_speed: f32, at(36), at(40), used("drift of the layer");
        /// Vertical wind speed: m/s; + = updraft.
        vertical_wind_speed: f32, at(40), at(44), used("answered by Weather Conditions in the layer");
        /// Wind direction: deg, 0..360 or -180..180; FROM; CCL sends -180..180 here (other sources 0..360): accept
        /// both.
        wind_direction: f32, at(44), at(48), used("drift of the layer, modulo 360");
        /// Barometric pressure: mb (hPa), >=0.
        barometric_pressure: f32 = 1013.25, at(48), at(52), used("answered by Weather Conditions in the layer");
        /// Aerosol concentration: g/m^3, >=0.
        aerosol_concentration: f32, at(52), at(56), used("answered by Aerosol Concentration in the layer");
        /// Top scud enable: 0 Disable, 1 Enable; new in 4.0.
        top_scud_enable: bool, absent(), bit(7, 5), used("whether scud stands above the top");
        /// Top scud frequency: %, 0..100; new in 4.0.
        top_scud_frequency: f32, absent(), at(60), used("coverage of the scud above the top");
        /// Top transition band: m, >=0; new in 4.0.
        top_transition_band: f32, absent(), at(64), used("thinner cloud above the top");
    }

    /// A rounded rectangle on the globe with its own weather.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |     id = 11      |    size = 48     |              region_id              |
    ///    4 | . . e d c b a a  |        .         |        .         |        .         |
    ///    8 |                                 latitude                                  |
    ///   12 |                                (latitude)                                 |
    ///   16 |                                 longitude                                 |
    ///   20 |                                (longitude)                                |
    ///   24 |                                  size_x                                   |
    ///   28 |                                  size_y                                   |
    ///   32 |                               corner_radius                               |
    ///   36 |                                 rotation                                  |
    ///   40 |                           transition_perimeter                            |
    ///   44 |        .         |        .         |        .         |        .         |
    ///      a region_state, b merge_weather_properties, c merge_aerosol_concentrations, d merge_maritime_surface_conditions
    ///      e merge_terrestrial_surface_conditions
    ///
    /// CIGI 4.0
    ///    0 |              size = 48              |             id = 0x000a             |
    ///    4 | . . e d c b a a  |        .         |              region_id              |
    ///    8 |                                 latitude                                  |
    ///   12 |                                (latitude)                                 |
    ///   16 |                                 longitude                                 |
    ///   20 |                                (longitude)                                |
    ///   24 |                                  size_x                                   |
    ///   28 |                                  size_y                                   |
    ///   32 |                               corner_radius                               |
    ///   36 |                                 rotation                                  |
    ///   40 |                           transition_perimeter                            |
    ///   44 |        .         |        .         |        .         |        .         |
    ///      a region_state, b merge_weather_properties, c merge_aerosol_concentrations, d merge_maritime_surface_conditions
    ///      e merge_terrestrial_surface_conditions
    /// ```
    EnvironmentalRegionControl "Environmental Region Control" HostToIg, fixed(11, 48), fixed(0x000a, 48), {
        /// Region id: 0..65535.
        region_id: u16, at(2), at(6), used("which region");
        /// Region state: 0 Inactive, 1 Active, 2 Destroyed.
        region_state: u8, bits(4, 0, 2), bits(4, 0, 2), used("active: drawn; inactive: kept, not drawn; destroyed: forgotten with its layers");
        /// Merge weather properties: 0 Use Last, 1 Merge.
        merge_weather_properties: bool, bit(4, 2), bit(4, 2), used("0: its layers stand in place of the global ones; 1: added to them");
        /// Merge aerosol concentrations: 0 Use Last, 1 Merge.
        merge_aerosol_concentrations: bool, bit(4, 3), bit(4, 3), used("0: in place of the global ones; 1: added");
        /// Merge maritime surface conditions: 0 Use Last, 1 Merge.
        merge_maritime_surface_conditions: bool, bit(4, 4), bit(4, 4), ignored("the sea is flat and glitters as in a wind of 5 m/s");
        /// Merge terrestrial surface conditions: 0 Use Last, 1 Merge.
        merge_terrestrial_surface_conditions: bool, bit(4, 5), bit(4, 5), ignored("the ground has one look in all weathers");
        /// Latitude: deg, -90..90; centre.
        latitude: f64, at(8), at(8), used("centre");
        /// Longitude: deg, -180..180; centre.
        longitude: f64, at(16), at(16), used("centre");
        /// Size x: m, >0; extent along local X (north before rotation), without perimeter.
        size_x: f32, at(24), at(24), used("extent towards north before rotation");
        /// Size y: m, >0; extent along local Y.
        size_y: f32, at(28), at(28), used("extent towards east before rotation");
        /// Corner radius: m, 0..min(x,y)/2; 0 = rectangle.
        corner_radius: f32, at(32), at(32), used("rounding");
        /// Rotation: deg, -180..180; clockwise from true north.
        rotation: f32, at(36), at(36), used("rotation");
        /// Transition perimeter: m, >=0; width of the blend ring outside the region.
        transition_perimeter: f32, at(40), at(40), used("width of the blend outside");
    }
}
