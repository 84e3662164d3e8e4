//! A deck as numbers: types, density, optics, light, slices and modulation. Knows no clock, no client and no GPU.

/// Cloud genera (WMO International Cloud Atlas), as CIGI's weather packets and METAR name them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum CloudKind {
    /// St: featureless grey sheet.
    Stratus,
    /// Sc: rolls and patches with thin gaps.
    Stratocumulus,
    /// Cu: flat base, heaped tops.
    Cumulus,
    /// Cb: tower and anvil.
    Cumulonimbus,
    /// Ns: thick dark sheet.
    Nimbostratus,
    /// As: grey veil.
    Altostratus,
    /// Ac: small regular elements.
    Altocumulus,
    /// Ci: fibres.
    Cirrus,
    /// Cc: ripples.
    Cirrocumulus,
    /// Cs: halo veil.
    Cirrostratus,
}
