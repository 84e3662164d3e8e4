//! Components and events: the part of the standard that an image generator fills with its own meaning.

use crate::wire::cigi::layout::{at, bits, fixed, sent, used, with_text};
use crate::wire::cigi::table::packets;

packets! {
    /// Sets a component that the image generator has defined; six words of data.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |      id = 4      |    size = 32     |            component_id             |
    ///    4 |             instance_id             | . . a a a a a a  | component_state  |
    ///    8 |                                  data_1                                   |
    ///   12 |                                  data_2                                   |
    ///   16 |                                  data_3                                   |
    ///   20 |                                  data_4                                   |
    ///   24 |                                  data_5                                   |
    ///   28 |                                  data_6                                   |
    ///      a component_class
    ///
    /// CIGI 4.0
    ///    0 |              size = 40              |             id = 0x0003             |
    ///    4 |            component_id             | . . a a a a a a  | component_state  |
    ///    8 |             instance_id             |        .         |        .         |
    ///   12 |        .         |        .         |        .         |        .         |
    ///   16 |                                  data_1                                   |
    ///   20 |                                  data_2                                   |
    ///   24 |                                  data_3                                   |
    ///   28 |                                  data_4                                   |
    ///   32 |                                  data_5                                   |
    ///   36 |                                  data_6                                   |
    ///      a component_class
    /// ```
    ComponentControl "Component Control" HostToIg, fixed(4, 32), fixed(0x0003, 40), {
        /// Component id: IG-defined; class 6: high byte = layer id.
        component_id: u16, at(2), at(4), used("19539 (0x4c53) is a lightning strike, 20300 (0x4f4c) the own ship's lights of a view; others have no meaning here");
        /// Instance id: entity/view/region/layer/event id by class.
        instance_id: u16, at(4), at(8), used("number of the strike, returned in Event Notification; the event's id in class 12, the view's in class 1");
        /// Component class: 0 Entity, 1 View, 2 View Group, 3 Sensor, 4 Regional Sea Surface, 5 Regional Terrain
        /// Surface, 6 Regional Layered Weather, 7 Global Sea Surface, 8 Global Terrain Surface, 9 Global Layered
        /// Weather, 10 Atmosphere, 11 Celestial Sphere, 12 Event, 13 System, 14 Symbol Surface, 15 Symbol.
        component_class: u8, bits(6, 0, 6), bits(6, 0, 6), used("13 System: strike; 12 Event: enables an event; 1 View: lights; others have no meaning here");
        /// Component state: 0..255.
        component_state: u8, at(7), at(7), used("1: strike, or event enabled; 0: event disabled; of lights bit 0 the landing lights, bit 1 the strobes");
        /// Data 1: byte-swapped as one 32-bit word whatever it holds.
        data_1: u32, at(8), at(16), used("strike: latitude, f64, high word");
        /// Data 2: as sent by the host.
        data_2: u32, at(12), at(20), used("strike: latitude, f64, low word");
        /// Data 3: as sent by the host.
        data_3: u32, at(16), at(24), used("strike: longitude, f64, high word");
        /// Data 4: as sent by the host.
        data_4: u32, at(20), at(28), used("strike: longitude, f64, low word");
        /// Data 5: as sent by the host.
        data_5: u32, at(24), at(32), used("strike: altitude, f32");
        /// Data 6: as sent by the host.
        data_6: u32, at(28), at(36), used("strike: peak current in kA, f32, negative: negative polarity");
    }

    /// As Component Control, with two words of data.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |      id = 5      |    size = 16     |            component_id             |
    ///    4 |             instance_id             | . . a a a a a a  | component_state  |
    ///    8 |                                  data_1                                   |
    ///   12 |                                  data_2                                   |
    ///      a component_class
    ///
    /// CIGI 4.0
    ///    0 |              size = 24              |             id = 0x0004             |
    ///    4 |            component_id             | . . a a a a a a  | component_state  |
    ///    8 |             instance_id             |        .         |        .         |
    ///   12 |        .         |        .         |        .         |        .         |
    ///   16 |                                  data_1                                   |
    ///   20 |                                  data_2                                   |
    ///      a component_class
    /// ```
    ShortComponentControl "Short Component Control" HostToIg, fixed(5, 16), fixed(0x0004, 24), {
        /// Component id: IG-defined.
        component_id: u16, at(2), at(4), used("19539 (0x4c53) is a lightning strike, 20300 (0x4f4c) the own ship's lights of a view; others have no meaning here");
        /// Instance id: as Component Control.
        instance_id: u16, at(4), at(8), used("number of the strike, returned in Event Notification; the event's id in class 12, the view's in class 1");
        /// Component class: as Component Control.
        component_class: u8, bits(6, 0, 6), bits(6, 0, 6), used("13 System: strike; 12 Event: enables an event; 1 View: lights; others have no meaning here");
        /// Component state: 0..255.
        component_state: u8, at(7), at(7), used("1: strike, or event enabled; 0: event disabled; of lights bit 0 the landing lights, bit 1 the strobes");
        /// Data 1: byte-swapped as one 32-bit word whatever it holds.
        data_1: u32, at(8), at(16), used("strike: global layer in whose extent it falls; 0: the first with cloud");
        /// Data 2: as sent by the host.
        data_2: u32, at(12), at(20), used("strike: peak current in kA, f32, 0: drawn by chance");
    }

    /// Something happened that the host may want to know.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |     id = 116     |    size = 16     |              event_id               |
    ///    4 |                               event_data_1                                |
    ///    8 |                               event_data_2                                |
    ///   12 |                               event_data_3                                |
    ///
    /// CIGI 4.0
    ///    0 |              size = 24              |             id = 0x0ff1             |
    ///    4 |              event_id               |        .         |        .         |
    ///    8 |                               event_data_1                                |
    ///   12 |                               event_data_2                                |
    ///   16 |                               event_data_3                                |
    ///   20 |        .         |        .         |        .         |        .         |
    /// ```
    EventNotification "Event Notification" IgToHost, fixed(116, 16), fixed(0x0ff1, 24), {
        /// Event id: IG-defined; enable/disable by Component Control class 12.
        event_id: u16, at(2), at(4), sent("19539: a strike is shown; 19540: a strike was over before a picture could show it");
        /// Event data 1: byte-swapped as one 32-bit word whatever it holds.
        event_data_1: u32, at(4), at(8), sent("number of the strike; 0: one of a storm or of layer 10");
        /// Event data 2: as sent by the host.
        event_data_2: u32, at(8), at(12), sent("peak current in kA, f32, negative: negative polarity; 0: drawn by chance");
        /// Event data 3: as sent by the host.
        event_data_3: u32, at(12), at(16), sent("number of the first picture that shows it, in its view; 0xffffffff: missed");
    }

    /// A text for a person at the host.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |     id = 117     |     size 8..     |             message_id              |
    ///    4 |                                  message                                  |
    ///
    /// CIGI 4.0
    ///    0 |              size 8..               |             id = 0x0ff0             |
    ///    4 |             message_id              |        .         |        .         |
    ///    8 |                                  message                                  |
    ///   12 |                                 (message)                                 |
    /// ```
    ImageGeneratorMessage "Image Generator Message" IgToHost, with_text(117, 8, 104), with_text(0x0ff0, 8, 65528), {
        /// Message id: IG-defined.
        message_id: u16, at(2), at(4), sent("1: a packet was refused");
        /// Message: ANSI text, NUL terminated; NUL padded; size = 8..104, multiple of 8 (text <= 99 chars + NUL).
        message: String, at(4), at(8), sent("which field, value and limit");
    }
}
