//! Words of the protocol for the kinds that the world knows.

use crate::clouds::CloudKind;
use crate::passes::light::encoding::Encoding;
use crate::passes::relight::Lighting;
use crate::world::command::{FlashKind, Polarity};
use crate::world::snapshot::DeckForm;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Two enums of the same variants, one with names for the wire, and the way between them.
macro_rules! mirrored {
    ($(#[$meta:meta])* $name:ident = $kind:ty { $($(#[$doc:meta])* $variant:ident),+ $(,)? }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum $name { $($(#[$doc])* $variant),+ }

        impl From<$name> for $kind {
            fn from(name: $name) -> Self {
                match name { $($name::$variant => Self::$variant),+ }
            }
        }

        impl From<$kind> for $name {
            fn from(kind: $kind) -> Self {
                match kind { $(<$kind>::$variant => Self::$variant),+ }
            }
        }
    };
}

mirrored! {
    /// Cloud genus, or a single storm cell.
    CloudType = CloudKind {
        /// Featureless grey sheet.
        Stratus,
        /// Rolls and patches with thin gaps.
        Stratocumulus,
        /// Flat base, heaped tops.
        Cumulus,
        /// Tower and anvil.
        Cumulonimbus,
        /// Thick dark sheet.
        Nimbostratus,
        /// Grey veil.
        Altostratus,
        /// Small regular elements.
        Altocumulus,
        /// Fibres.
        Cirrus,
        /// Ripples.
        Cirrocumulus,
        /// Halo veil.
        Cirrostratus,
        /// One cumulonimbus that fills its region, its anvil downwind; coverage is how far it has grown. In regions only.
        StormCell,
    }
}

mirrored! {
    /// Where a flash goes.
    FlashType = FlashKind {
        /// Cloud to ground.
        CloudToGround,
        /// Inside one cloud.
        IntraCloud,
        /// From cloud to cloud.
        CloudToCloud,
    }
}

mirrored! {
    /// Sign of the charge brought down.
    PolarityName = Polarity {
        /// The usual case.
        Negative,
        /// Rarer, stronger, mostly of one stroke.
        Positive,
    }
}

mirrored! {
    /// How a GPU draws the deck.
    DeckFormName = DeckForm {
        /// Whichever measured faster.
        Auto,
        /// Instanced geometry.
        Instanced,
        /// One walk a pixel.
        Marched,
    }
}

mirrored! {
    /// How the light inside the deck is stored.
    LightEncodingName = Encoding {
        /// Beam, diffuse light, what passes, and skylight, in 8 bits each.
        Shares8,
        /// The same in f16.
        Shares16,
        /// Mean and flux vector of the source's light, in f16.
        Harmonics,
        /// Mean and flux vector in 8 bits, as in the deck paper.
        Paper,
    }
}

mirrored! {
    /// How flashes light the clouds, roughly from cheap to dear.
    RelightName = Lighting {
        /// Bare points: intensity over distance squared, nothing in between.
        Point,
        /// Direct light scattered once.
        Single,
        /// The published scheme: tables of virtual lights, made in the background for each piece of cloud that is struck.
        Basis,
        /// Direct light of each channel, and tables for what is scattered more often.
        Hybrid,
        /// One solve for each channel; nothing is baked.
        Solve,
        /// One solve with every point of the channel for itself.
        Reference,
    }
}
