//! Sixteen sources side by side: the vector type of the solver, and the choice of instruction set at run time.

use bytemuck::{Pod, Zeroable};

/// Sources solved together.
pub const LANES: usize = 16;

/// One number for each of [`LANES`] sources. Lanes never mix, and nothing is fused, so every instruction set gives the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Lanes(pub [f32; LANES]);

impl Lanes {
    /// Zero in every lane.
    pub const ZERO: Self = Self([0.0; LANES]);

    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(value: f32) -> Self {
        Self([value; LANES])
    }

    /// `self + weight * other`.
    #[inline(always)]
    #[must_use]
    pub fn plus(self, weight: f32, other: &Self) -> Self {
        let mut out = self;
        for (o, b) in out.0.iter_mut().zip(&other.0) {
            *o += weight * *b;
        }
        out
    }

    /// `self * other`, lane by lane.
    #[inline(always)]
    #[must_use]
    pub fn times(self, other: &Self) -> Self {
        let mut out = self;
        for (o, b) in out.0.iter_mut().zip(&other.0) {
            *o *= *b;
        }
        out
    }

    /// `self * weight`.
    #[inline(always)]
    #[must_use]
    pub fn scaled(self, weight: f32) -> Self {
        let mut out = self;
        for o in &mut out.0 {
            *o *= weight;
        }
        out
    }
}

/// A function whose body is compiled for several instruction sets and chosen at run time. The body must be `#[inline(always)]`.
macro_rules! dispatch {
    ($(#[$note:meta])* fn $name:ident($($arg:ident: $kind:ty),* $(,)?) => $body:path) => {
        $(#[$note])*
        pub fn $name($($arg: $kind),*) {
            crate::numeric::vector::vectorised(
                #[inline(always)]
                || $body($($arg),*),
            );
        }
    };
}
pub(super) use dispatch;
