//! The ten cloud genera, and the storm cell, and what makes each look like itself.

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
    /// One cumulonimbus, bounded by the region that it stands in (see [`super::cell`]): no genus that a sky is filled with.
    StormCell,
}

/// What makes a genus look like itself. Lengths in metres, extinction in 1/m; the rest are shares of the shape value,
/// which runs from 0 to 1 and is cut off at theta (deck paper eq. 14-16).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Appearance {
    /// Extinction where the cloud is fully there, `sigma_ref` (1/m), at density 1.
    pub extinction_per_m: f32,
    /// Thickness at which coverage is calibrated.
    pub usual_thickness_m: f32,
    /// Elements across the 16 km tile, east and north.
    pub elements: [u32; 2],
    /// Share of cellular (heaped) against gradient (smooth) noise, 0 to 1.
    pub heaped: f32,
    /// Amplitude of the erosion by finer noise.
    pub erosion: f32,
    /// Height share over which the base goes from nothing to whole.
    pub base_softness: f32,
    /// How much the shape value falls from base to top.
    pub taper: f32,
    /// Height share over which the top closes.
    pub top_softness: f32,
    /// How far the upper quarter spreads out in the shape of an anvil, 0 to 1.
    pub anvil: f32,
    /// Shape value from edge to fully there.
    pub edge: f32,
    /// Share of the large 2D map in theta.
    pub patchiness: f32,
    /// Amplitude of the detail finer than a voxel (see [`super::detail`]): what its values of 0 to 1 are multiplied by.
    pub detail: f32,
    /// Period of the detail along the tile's axes and upwards, m: heaps are a sixth of it and less.
    pub detail_tile_m: [f32; 3],
    /// How far large heaps reach through the layer upwards: 0, they are as tall as wide; 1, they are columns.
    pub columnar: f32,
    /// Share of fibres, drawn out along the first axis, in the shape, 0 to 1.
    pub fibrous: f32,
}

impl CloudKind {
    /// Genera and the storm cell: one more than any [`CloudKind::index`].
    pub const COUNT: usize = 11;

    /// All genera, in the order of the International Cloud Atlas's low to high.
    pub const ALL: [Self; 10] = [
        Self::Stratus,
        Self::Stratocumulus,
        Self::Cumulus,
        Self::Cumulonimbus,
        Self::Nimbostratus,
        Self::Altostratus,
        Self::Altocumulus,
        Self::Cirrus,
        Self::Cirrocumulus,
        Self::Cirrostratus,
    ];

    /// The genus's appearance. Extinctions after the table in the project's facts (extinction is about
    /// 3 LWC / (2 rho_w r_e) in the geometric limit).
    pub fn appearance(self) -> Appearance {
        let a = |extinction_per_m, usual_thickness_m, elements, heaped, erosion| Appearance {
            extinction_per_m,
            usual_thickness_m,
            elements,
            heaped,
            erosion,
            base_softness: 0.10,
            taper: 0.25,
            top_softness: 0.25,
            anvil: 0.0,
            edge: 0.16,
            patchiness: 0.35,
            detail: erosion,
            detail_tile_m: [1_400.0; 3],
            columnar: 0.0,
            fibrous: 0.0,
        };
        match self {
            Self::Stratus => {
                let sheet = a(0.04, 400.0, [7, 7], 0.15, 0.12);
                Appearance {
                    base_softness: 0.15,
                    taper: 0.05,
                    edge: 0.45,
                    detail: 0.22,
                    detail_tile_m: [3_000.0, 3_000.0, 1_000.0],
                    ..sheet
                }
            }
            Self::Stratocumulus => {
                Appearance { taper: 0.18, edge: 0.18, detail: 0.34, ..a(0.04, 500.0, [7, 12], 0.75, 0.22) }
            }
            Self::Cumulus => {
                let heaps = a(0.06, 1200.0, [12, 12], 0.85, 0.30);
                Appearance { base_softness: 0.08, taper: 0.42, edge: 0.12, detail: 0.38, ..heaps }
            }
            Self::Cumulonimbus => {
                let tower = a(0.08, 8000.0, [3, 3], 0.8, 0.20);
                Appearance {
                    base_softness: 0.04,
                    taper: 0.30,
                    top_softness: 0.10,
                    anvil: 1.0,
                    edge: 0.10,
                    detail: 0.24,
                    detail_tile_m: [3_600.0; 3],
                    columnar: 0.7,
                    patchiness: 0.42,
                    ..tower
                }
            }
            Self::Nimbostratus => {
                let sheet = a(0.05, 3000.0, [4, 4], 0.2, 0.15);
                Appearance {
                    base_softness: 0.15,
                    taper: 0.05,
                    edge: 0.5,
                    detail: 0.22,
                    detail_tile_m: [4_000.0, 4_000.0, 1_500.0],
                    ..sheet
                }
            }
            Self::Altostratus => {
                let veil = a(0.015, 1000.0, [4, 6], 0.1, 0.12);
                Appearance {
                    base_softness: 0.15,
                    taper: 0.05,
                    edge: 0.6,
                    detail: 0.20,
                    detail_tile_m: [5_000.0, 3_000.0, 1_500.0],
                    ..veil
                }
            }
            Self::Altocumulus => Appearance {
                taper: 0.20,
                edge: 0.25,
                detail: 0.30,
                detail_tile_m: [900.0; 3],
                ..a(0.03, 400.0, [40, 36], 0.85, 0.2)
            },
            Self::Cirrus => {
                let fibres = a(0.002, 1000.0, [3, 14], 0.05, 0.25);
                Appearance {
                    taper: 0.0,
                    edge: 0.22,
                    fibrous: 1.0,
                    detail: 0.35,
                    detail_tile_m: [9_000.0, 1_500.0, 6_000.0],
                    ..fibres
                }
            }
            Self::Cirrocumulus => {
                Appearance { taper: 0.1, edge: 0.4, detail_tile_m: [900.0; 3], ..a(0.001, 500.0, [90, 92], 0.9, 0.2) }
            }
            Self::Cirrostratus => {
                let veil = a(0.0006, 1500.0, [6, 8], 0.0, 0.1);
                Appearance { taper: 0.0, edge: 0.9, detail_tile_m: [9_000.0, 3_000.0, 6_000.0], ..veil }
            }
            // Its shape is its own: of these only extinction, thickness (of a cell of 12 km in a square of 40 km, brought to the
            // tile's scale), fine detail and the edge count.
            Self::StormCell => Appearance {
                edge: 0.05,
                patchiness: 0.0,
                detail: 0.09,
                detail_tile_m: [6_000.0; 3],
                ..a(0.08, 4800.0, [14, 14], 0.8, 0.05)
            },
        }
    }

    /// Whether it is bounded by its region: the tile is one cloud, and repeats nowhere.
    pub fn is_bounded(self) -> bool {
        self == Self::StormCell
    }

    /// Index in [`CloudKind::ALL`]; the storm cell's comes after them.
    pub fn index(self) -> usize {
        self as usize
    }
}
