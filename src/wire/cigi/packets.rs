//! Every packet that is understood, as plain types; one file a subject.

mod component;
mod entity;
mod frame;
mod request;
mod response;
mod sky;
mod strike;
mod view;
mod weather;

pub use component::{ComponentControl, EventNotification, ImageGeneratorMessage, ShortComponentControl};
pub use entity::{AnimationControl, EntityControl, EntityPosition, EntityState};
pub use frame::{IgControl, StartOfFrame};
pub use request::{EnvironmentalConditionsRequest, HatHotRequest, LineOfSightSegmentRequest, LineOfSightVectorRequest};
pub use response::{
    AerosolConcentrationResponse, HatHotExtendedResponse, HatHotResponse, LineOfSightExtendedResponse,
    LineOfSightResponse, WeatherConditionsResponse,
};
pub use sky::{AtmosphereControl, CelestialSphereControl};
pub use strike::{Strike, TimedStrike};
pub use view::{ViewControl, ViewDefinition};
pub use weather::{EnvironmentalRegionControl, WeatherControl};

use super::Version;
use super::layout::{Layout, Value};
use super::table::Packed;

/// The enumeration of all packets, with what every packet can do.
macro_rules! one_of {
    ($($packet:ident,)+) => {
        /// Any packet.
        #[derive(Clone, Debug, PartialEq)]
        pub enum Packet {
            $(
                #[doc = concat!("[`", stringify!($packet), "`].")]
                $packet($packet),
            )+
        }

        /// The layouts of all packets, those of the host first.
        pub const LAYOUTS: &[&Layout] = &[$(&<$packet as Packed>::LAYOUT,)+];

        impl Packet {
            /// A packet of this id with every field at its default; `None`: the version has none that is understood.
            pub fn blank(version: Version, packet_id: u16) -> Option<Self> {
                $(
                    if <$packet as Packed>::LAYOUT.framing(version).is_some_and(|framing| framing.id == packet_id) {
                        return Some(Self::$packet($packet::default()));
                    }
                )+
                None
            }

            /// Where its fields stand.
            pub fn layout(&self) -> &'static Layout {
                match self {
                    $(Self::$packet(_) => const { &<$packet as Packed>::LAYOUT },)+
                }
            }

            /// The value of a field, by its index in the layout.
            pub fn field(&self, index: usize) -> Option<Value> {
                match self {
                    $(Self::$packet(packet) => packet.field(index),)+
                }
            }

            /// Sets a field by its index in the layout; false if the value does not fit its type.
            pub fn set_field(&mut self, index: usize, value: &Value) -> bool {
                match self {
                    $(Self::$packet(packet) => packet.set_field(index, value),)+
                }
            }
        }

        $(
            impl From<$packet> for Packet {
                fn from(packet: $packet) -> Self {
                    Self::$packet(packet)
                }
            }
        )+
    };
}

one_of! {
    IgControl,
    EntityControl,
    EntityState,
    EntityPosition,
    AnimationControl,
    ViewControl,
    ViewDefinition,
    CelestialSphereControl,
    AtmosphereControl,
    WeatherControl,
    EnvironmentalRegionControl,
    ComponentControl,
    ShortComponentControl,
    HatHotRequest,
    LineOfSightSegmentRequest,
    LineOfSightVectorRequest,
    EnvironmentalConditionsRequest,
    Strike,
    TimedStrike,
    StartOfFrame,
    HatHotResponse,
    HatHotExtendedResponse,
    LineOfSightResponse,
    LineOfSightExtendedResponse,
    WeatherConditionsResponse,
    AerosolConcentrationResponse,
    EventNotification,
    ImageGeneratorMessage,
}
