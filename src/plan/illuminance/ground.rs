//! The light on the ground: under and between the clouds, above a sheet that ground reaches through, and what clouds send down of
//! the light of cities.

use super::Illuminance;
use super::column::{Column, GROUND_ALBEDO, Level, cover};
use crate::geo::terrain::Terrain;
use crate::passes::beams::{LAMPS, Lamp};
use crate::passes::common::smoothstep;
use crate::passes::deck::{FLASHES, Flash};
use crate::passes::ground::hills::FADE;
use crate::passes::ground::lights::CORE_LUMINANCE;
use crate::passes::ground::{FIELDS_TILE_M, Ground, glow};
use crate::plan::eye::Eye;
use crate::plan::shadow::{self, ShadowPlan};
use crate::plan::{PassNote, ReliefPlan, layers};
use crate::world::snapshot::LayerState;
use glam::{DQuat, Vec3};

/// Layers whose base lies lower may have ground above them, m, and less and less up to the second: few mountains are higher.
const REACHED_M: [f32; 2] = [5_500.0, 6_500.0];
/// Coverage from which on a layer counts as a sheet, and counts whole.
const LEAST_COVER: f32 = 0.05;
const CLOSED_COVER: f32 = 0.2;
/// Sine of the elevation below which a source casts no shadows of hills: behind the sea's horizon from the highest of them.
const SET: f32 = -0.05;
/// Below this share of the diffuse light the source's makes no shadow that could be seen.
const LEAST_SHARE: f32 = 2e-3;

/// One weather in sight: how much it rules at the eye, its layers, its column of light.
pub type Weather<'a> = (f32, &'a [LayerState], &'a Column);

/// Layers that ground may reach through, taken together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheet {
    /// Light above them.
    above: Level,
    base_m: f32,
    top_m: f32,
}

impl Sheet {
    /// That of the weathers in sight, if there is any. Layers and weathers count as far as they are there, so that nothing steps as
    /// they ease in.
    pub fn of(weathers: &[Weather]) -> Option<Self> {
        let (mut all, mut base_m, mut top_m) = (0.0, 0.0, 0.0);
        let mut parts = Vec::with_capacity(2 * weathers.len());
        for (share, layers, column) in weathers {
            let (mut there, mut base, mut top, mut above) = (0.0f32, 0.0f32, 0.0f32, column.ground);
            for (layer, light) in layers.iter().zip(&column.above) {
                let weight = smoothstep(LEAST_COVER, CLOSED_COVER, cover(layer))
                    * (1.0 - smoothstep(REACHED_M[0], REACHED_M[1], layer.base_m as f32));
                if weight > 0.0 {
                    let own_top = (layer.base_m + layer.thickness_m) as f32;
                    // The first layer sets the heights, those above it lift the top.
                    let first = there == 0.0;
                    base = if first { layer.base_m as f32 } else { base };
                    top = if first { own_top } else { top + (own_top - top).max(0.0) * weight };
                    above = Level::mixed([(1.0 - weight, above), (weight, *light)].into_iter());
                    there = there.max(weight);
                }
            }
            parts.push((*share, above));
            (all, base_m, top_m) = (all + share * there, base_m + share * there * base, top_m + share * there * top);
        }
        (all > 0.0).then(|| Self { above: Level::mixed(parts.into_iter()), base_m: base_m / all, top_m: top_m / all })
    }

    /// The light above with that of the source as it is between shadows, which the picture looks up.
    fn between_shadows(mut self, unshaded_lux: Vec3) -> Self {
        self.above.direct_lux = self.above.direct_lux.max(unshaded_lux);
        self
    }
}

/// Share of light from below that the clouds of the weathers send down again, and the height that they have for it, m.
pub fn underside(weathers: &[Weather]) -> [f32; 2] {
    let of = weathers.iter().map(|(share, _, column)| (*share, column.underside));
    let [back, moment] = of.fold([0.0; 2], |[back, moment], (share, [own, height_m])| {
        [back + share * own, moment + share * own * height_m]
    });
    [back, if back > 0.0 { moment / back } else { 0.0 }]
}

impl Illuminance {
    /// The light on ground between the clouds.
    pub fn between_clouds(&self) -> shadow::Light {
        let (direct_lux, diffuse_lux) = (self.unshaded_lux.y, self.ground.diffuse_lux.y);
        shadow::Light { source: self.source, direct_lux, diffuse_lux, gives_way: self.gives_way.clone() }
    }

    /// Light for ground with shadows: the source's is that between clouds. Clouds stop more of it than the columns know, who
    /// know no flanks and no slant; that share is scattered and comes down as diffuse light, so that the mean over much
    /// ground stays what the exposure is made for.
    fn shaded(&self, shadows: &ShadowPlan) -> Level {
        let stopped = |(column, through): (&Column, &f32)| column.ground.direct_lux - self.unshaded_lux * *through;
        let stopped = self.columns.iter().zip(&shadows.through).map(stopped);
        let more: Vec3 = stopped.zip(&self.shares).map(|(lux, share)| lux * *share).sum();
        let diffuse_lux = self.ground.diffuse_lux + more * self.source.z.max(0.0);
        Level { direct_lux: self.unshaded_lux, diffuse_lux: diffuse_lux.max(0.5 * self.ground.diffuse_lux) }
    }

    /// The ground, if it is in sight. Without shadows, the source's light is what the layers let through of it on the whole.
    /// `lamps`: those of the own ship that light it.
    pub fn ground(
        &self,
        eye: &Eye,
        shadows: Option<&ShadowPlan>,
        relief: Option<&ReliefPlan>,
        flashes: &[Flash],
        lamps: &[Lamp],
        notes: &mut Vec<PassNote>,
    ) -> Option<Ground> {
        notes.push(PassNote { pass: "ground", kept: true, why: "the ground is below the eye".into() });
        let light = shadows.map_or(self.ground, |shadows| self.shaded(shadows));
        let (near, chart) = eye.charts(DQuat::IDENTITY, layers::extent_m(eye, 0.0), f64::from(FIELDS_TILE_M));
        let mut flash = [Flash::default(); FLASHES];
        flash[..flashes.len()].copy_from_slice(flashes);
        let mut lamp = [Lamp::default(); LAMPS];
        lamp[..lamps.len()].copy_from_slice(lamps);
        let hills = self.hills(relief, &light, notes);
        let [glow_lux, glow_level] = self.glow(relief, notes);
        let sheet = self.sheet.map(|sheet| match shadows {
            Some(_) => sheet.between_shadows(self.unshaded_lux),
            None => sheet,
        });
        let sheet = sheet.unwrap_or(Sheet { above: light, base_m: 1e6, top_m: 2e6 });
        Some(Ground {
            light_lux: light.direct_lux.into(),
            flashes: flashes.len() as u32,
            light_direction: self.source.into(),
            city_luminance: CORE_LUMINANCE * self.night,
            sky_lux: light.diffuse_lux.into(),
            charts: near.len() as u32,
            snow_m: snow_line_m(eye.position.latitude_rad),
            shore_m: if Terrain::is_land(&eye.position) { 1e5 } else { -1e5 },
            glow_lux,
            glow_level,
            above_light_lux: sheet.above.direct_lux.into(),
            sheet_base_m: sheet.base_m,
            above_sky_lux: sheet.above.diffuse_lux.into(),
            sheet_top_m: sheet.top_m,
            lamps: lamps.len() as u32,
            hills: u32::from(hills),
            pad0: 0,
            pad1: 0,
            lamp,
            chart,
            flash,
        })
    }

    /// Whether hills shade each other.
    fn hills(&self, relief: Option<&ReliefPlan>, light: &Level, notes: &mut Vec<PassNote>) -> bool {
        let above = self.sheet.map_or(0.0, |sheet| sheet.above.direct_lux.y);
        let direct = light.direct_lux.y.max(above);
        let (kept, why) = match relief {
            Some(relief) if relief.rays => match self.source.z {
                z if z > FADE[1] => (false, "sun or moon stands so high that hills shade nothing"),
                z if z < SET || direct < LEAST_SHARE * light.diffuse_lux.y => {
                    (false, "neither sun nor moon lights the hills")
                }
                _ => (true, "sun or moon stands low"),
            },
            _ => (false, "the ground has no heights"),
        };
        notes.push(PassNote { pass: "hills", kept, why: why.into() });
        kept
    }

    /// What the clouds send down of the light of cities, lux where lamps shine as in a core, and the level that is as smooth.
    fn glow(&self, relief: Option<&ReliefPlan>, notes: &mut Vec<PassNote>) -> [f32; 2] {
        let [back, height_m] = self.underside;
        let lit = relief.filter(|relief| relief.lights && back > 0.0);
        let why = if lit.is_some() { "clouds send down light of cities" } else { "no clouds over lamps" };
        notes.push(PassNote { pass: "glow on the ground", kept: lit.is_some(), why: why.into() });
        lit.map_or([0.0; 2], |relief| {
            // What comes back from the ground goes up again.
            let lux = std::f32::consts::PI * CORE_LUMINANCE * self.night * back / (1.0 - GROUND_ALBEDO * back);
            [lux, glow::level(height_m, relief.relief.spacing_m)]
        })
    }
}

/// Height above which snow lies in summer: 5 km on the equator, 2.9 km in the Alps, sea level at 72 degrees (a parabola
/// through Porter 1975's and later snow lines, which scatter by half a kilometre).
fn snow_line_m(latitude_rad: f64) -> f32 {
    let share = latitude_rad.to_degrees() / 72.0;
    (5_000.0 * (1.0 - share * share)).max(-2_000.0) as f32
}
