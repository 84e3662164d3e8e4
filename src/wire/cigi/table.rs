//! The macro by which a packet is described once: from it come the plain type and its [`Layout`](super::layout::Layout).

use super::layout::{Layout, Value};

/// A packet type made by [`packets!`].
pub trait Packed: Default {
    /// Where its fields stand.
    const LAYOUT: Layout;
    /// The value of a field, by its index in the layout.
    fn field(&self, index: usize) -> Option<Value>;
    /// Sets a field by its index in the layout; false if the value does not fit its type or there is no such field.
    fn set_field(&mut self, index: usize, value: &Value) -> bool;
}

/// One type a packet. A packet is written as
///
/// ```text
/// /// What it is for. Then bit diagrams, which a test compares with the places below.
/// Name "Name On Paper" Direction, framing in 3.3, framing in 4.0 {
///     /// What the field says, unit and range.
///     field: type = default, place in 3.3, place in 4.0, what this server makes of it;
/// }
/// ```
macro_rules! packets {
    (@default) => { Default::default() };
    (@default $value:expr) => { $value };
    ($(
        $(#[doc = $doc:literal])+
        $packet:ident $name:literal $direction:ident, $framing3:expr, $framing4:expr, {$(
            $(#[doc = $says:literal])+
            $field:ident: $kind:ty $(= $default:expr)?, $place3:expr, $place4:expr, $effect:expr;
        )+}
    )+) => {$(
        $(#[doc = $doc])+
        #[derive(Clone, Debug, PartialEq)]
        pub struct $packet {$(
            $(#[doc = $says])+
            pub $field: $kind,
        )+}

        impl Default for $packet {
            fn default() -> Self {
                Self { $($field: $crate::wire::cigi::table::packets!(@default $($default)?),)+ }
            }
        }

        impl $crate::wire::cigi::table::Packed for $packet {
            const LAYOUT: $crate::wire::cigi::layout::Layout = $crate::wire::cigi::layout::Layout {
                type_name: stringify!($packet),
                name: $name,
                meaning: concat!($($doc, "\n"),+),
                direction: $crate::wire::cigi::Direction::$direction,
                v3: $framing3,
                v4: $framing4,
                fields: &[$($crate::wire::cigi::layout::Field {
                    name: stringify!($field),
                    kind: <$kind as $crate::wire::cigi::layout::Scalar>::KIND,
                    v3: $place3,
                    v4: $place4,
                    meaning: concat!($($says),+),
                    effect: $effect,
                }),+],
            };

            fn field(&self, index: usize) -> Option<$crate::wire::cigi::layout::Value> {
                let mut at = 0..;
                $(if at.next() == Some(index) {
                    return Some($crate::wire::cigi::layout::Scalar::to_value(&self.$field));
                })+
                None
            }

            fn set_field(&mut self, index: usize, value: &$crate::wire::cigi::layout::Value) -> bool {
                let mut at = 0..;
                $(if at.next() == Some(index) {
                    return match $crate::wire::cigi::layout::Scalar::from_value(value) {
                        Some(value) => {
                            self.$field = value;
                            true
                        }
                        None => false,
                    };
                })+
                false
            }
        }
    )+};
}

pub(super) use packets;
