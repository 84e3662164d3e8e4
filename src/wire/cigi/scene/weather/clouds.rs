//! One weather layer as clouds: genus, extinction from its visibility, scud, and the bands in which it thins out.

use crate::clouds::CloudKind;
use crate::outputs::air::{AirLayer, AirMass};
use crate::wire::cigi::Version;
use crate::wire::cigi::packets::WeatherControl;
use crate::world::command::{LayerSpec, RegionShape};
use crate::world::limits::{BASE_M, DENSITY, MAX_LAYERS, THICKNESS_M, WIND_SPEED_MPS};

/// Optical depth of a visibility: contrast of 5 %, as everywhere in the house.
const VISIBILITY_DEPTH: f64 = 2.996;
/// Thickness of scud.
const SCUD_M: f64 = 250.0;
/// Mean of a linear fall from whole to nothing: the extinction of a transition band.
const BAND_SHARE: f64 = 0.5;
/// Thinner pieces are left out.
const THINNEST_M: f64 = THICKNESS_M[0];

/// A layer and what hangs on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parts {
    /// The layer.
    pub layer: LayerSpec,
    /// Scud or a transition band below it.
    pub below: Option<LayerSpec>,
    /// The same above it.
    pub above: Option<LayerSpec>,
}

impl Parts {
    /// The same inside an outline, where cumulonimbus is one storm cell, which has no bands and no scud: it stands in the weather
    /// around, and beside other layers it could not.
    #[must_use]
    pub fn bounded(self) -> Self {
        if self.layer.kind != CloudKind::Cumulonimbus {
            return self;
        }
        let layer = LayerSpec { kind: CloudKind::StormCell, ..self.layer };
        Self { layer, below: None, above: None }
    }
}

/// Whether a layer of this number is drawn as cloud: ground fog, the three cloud layers, and 11 to 15, which are ours.
pub fn is_cloud(packet: &WeatherControl) -> bool {
    matches!(packet.layer_id, 0..=3 | 11..=15)
}

/// The genus of a layer. Fog is stratus; a type of the host's own goes by its height.
pub fn kind(packet: &WeatherControl) -> Option<CloudKind> {
    if packet.layer_id == 0 {
        return Some(CloudKind::Stratus);
    }
    Some(match packet.cloud_type {
        0 => return None,
        1 => CloudKind::Altocumulus,
        2 => CloudKind::Altostratus,
        3 => CloudKind::Cirrocumulus,
        4 => CloudKind::Cirrostratus,
        5 => CloudKind::Cirrus,
        6 => CloudKind::Cumulonimbus,
        7 => CloudKind::Cumulus,
        8 => CloudKind::Nimbostratus,
        9 => CloudKind::Stratocumulus,
        10 => CloudKind::Stratus,
        // The bounds between low, middle and high cloud in temperate latitudes (WMO International Cloud Atlas).
        _ if packet.base_elevation < 2_000.0 => CloudKind::Stratocumulus,
        _ if packet.base_elevation < 6_000.0 => CloudKind::Altostratus,
        _ => CloudKind::Cirrostratus,
    })
}

/// Transition bands below and above: CIGI 3.3 has one number for both.
fn bands(packet: &WeatherControl, version: Version) -> [f64; 2] {
    let below = f64::from(packet.bottom_transition_band).max(0.0);
    let above = match version {
        Version::V3 => below,
        Version::V4 => f64::from(packet.top_transition_band).max(0.0),
    };
    [below, above]
}

/// A layer as clouds; `None`: it has none.
pub fn parts(packet: &WeatherControl, version: Version, sea_level_m: f64) -> Option<Parts> {
    let kind = kind(packet).filter(|_| is_cloud(packet))?;
    let coverage = (f64::from(packet.coverage) / 100.0).clamp(0.0, 1.0);
    if coverage == 0.0 || packet.thickness <= 0.0 {
        return None;
    }
    let base_m = (f64::from(packet.base_elevation) + sea_level_m).clamp(BASE_M[0], BASE_M[1]);
    let thickness_m = f64::from(packet.thickness).clamp(THICKNESS_M[0], THICKNESS_M[1]);
    let usual = f64::from(kind.appearance().extinction_per_m);
    // A visibility of 0 says nothing: the usual extinction of the genus.
    let asked = VISIBILITY_DEPTH / f64::from(packet.visibility_range) / usual;
    let density = if packet.visibility_range > 0.0 { asked.clamp(DENSITY[0], DENSITY[1]) } else { 1.0 };
    let layer = LayerSpec {
        kind,
        base_m,
        thickness_m,
        coverage,
        density,
        wind_speed_mps: f64::from(packet.horizontal_wind_speed).clamp(WIND_SPEED_MPS[0], WIND_SPEED_MPS[1]),
        wind_from_deg: f64::from(packet.wind_direction).rem_euclid(360.0),
    };
    let scud = |enabled: bool, frequency: f32| {
        let coverage = (f64::from(frequency) / 100.0).clamp(0.0, 1.0);
        (enabled && coverage > 0.0).then_some((CloudKind::Stratus, coverage, SCUD_M, 1.0))
    };
    let band = |width_m: f64| (width_m >= THINNEST_M).then_some((kind, coverage, width_m, density * BAND_SHARE));
    let piece = |(kind, coverage, thickness_m, density): (CloudKind, f64, f64, f64), base_m: f64| {
        let thickness_m = thickness_m.clamp(THICKNESS_M[0], THICKNESS_M[1]);
        LayerSpec { kind, coverage, thickness_m, density, base_m, ..layer }
    };
    let [below, above] = bands(packet, version);
    let below = scud(packet.bottom_scud_enable, packet.bottom_scud_frequency).or_else(|| band(below));
    let above = scud(packet.top_scud_enable, packet.top_scud_frequency).or_else(|| band(above));
    Some(Parts {
        layer,
        below: below.map(|below| piece(below, base_m - below.2)),
        above: above.map(|above| piece(above, base_m + thickness_m)),
    })
}

/// The layers of the world: those of a list, and of `around` what does not touch them. Layers do not overlap: one that
/// reaches into the next ends there, and scud and bands are left out where there is no room.
pub fn specs(list: &[Parts], around: &[LayerSpec]) -> Vec<LayerSpec> {
    let top = |spec: &LayerSpec| spec.base_m + spec.thickness_m;
    let mut main: Vec<LayerSpec> = list.iter().map(|parts| parts.layer).collect();
    main.sort_by(|a, b| a.base_m.total_cmp(&b.base_m));
    let mut placed: Vec<LayerSpec> = Vec::new();
    for spec in main {
        if let Some(below) = placed.last_mut() {
            below.thickness_m = below.thickness_m.min(spec.base_m - below.base_m);
        }
        placed.retain(|spec| spec.thickness_m >= THINNEST_M);
        placed.push(spec);
    }
    placed.truncate(MAX_LAYERS);
    let hanging = list.iter().flat_map(|parts| [parts.below, parts.above]).flatten();
    for spec in hanging.chain(around.iter().copied()) {
        // Bases at the very bottom of the world leave no room below.
        let free = placed.iter().all(|other| top(&spec) <= other.base_m + 1e-6 || spec.base_m >= top(other) - 1e-6);
        if free && placed.len() < MAX_LAYERS && spec.base_m >= BASE_M[0] && spec.base_m <= BASE_M[1] {
            placed.push(spec);
        }
    }
    placed.sort_by(|a, b| a.base_m.total_cmp(&b.base_m));
    // Bases and tops that meet do so exactly, whatever the rounding.
    for index in 1..placed.len() {
        let ceiling_m = placed[index].base_m;
        let below = &mut placed[index - 1];
        below.thickness_m = below.thickness_m.min(ceiling_m - below.base_m);
        while below.base_m + below.thickness_m > ceiling_m {
            below.thickness_m = below.thickness_m.next_down();
        }
    }
    placed
}

/// What a layer says of its air.
pub fn air_layer(
    packet: &WeatherControl,
    version: Version,
    sea_level_m: f64,
    region: Option<RegionShape>,
    merges: bool,
    merges_aerosol: bool,
) -> AirLayer {
    let base_m = f64::from(packet.base_elevation) + sea_level_m;
    let [below_m, above_m] = bands(packet, version);
    let drawn = parts(packet, version, sea_level_m).is_some();
    AirLayer {
        layer_id: packet.layer_id,
        region,
        merges,
        merges_aerosol,
        base_m,
        top_m: base_m + f64::from(packet.thickness).max(0.0),
        below_m,
        above_m,
        air: AirMass {
            temperature_c: packet.air_temperature.into(),
            humidity_percent: f64::from(packet.humidity.min(100)),
            pressure_hpa: packet.barometric_pressure.into(),
            wind_speed_mps: f64::from(packet.horizontal_wind_speed).max(0.0),
            updraft_mps: packet.vertical_wind_speed.into(),
            wind_from_deg: f64::from(packet.wind_direction).rem_euclid(360.0),
        },
        visibility_m: (!drawn && packet.visibility_range > 0.0).then_some(packet.visibility_range.into()),
        aerosol_g_per_m3: f64::from(packet.aerosol_concentration).max(0.0),
    }
}
