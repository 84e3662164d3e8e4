//! Subject `shadow`: what reaches the ground under single clouds, by each method against the integral along the light.

use super::figure::Figure;
use super::result::Case;
use super::subject::{Run, Stopped, Subject};
use super::timing::measure;
use crate::clouds::coverage::{Coverage, Threshold};
use crate::clouds::density::{DensityVolume, HEIGHT, TILE_M, WIDTH};
use crate::clouds::{CloudKind, modulation};
use crate::encode::{Format, encode_pixels};
use crate::frame::Pixels;
use crate::passes::common::{Chart, stereographic};
use crate::passes::deck::Layer;
use crate::passes::deck::field::{Textures, column_bounds};
use crate::passes::sampling::map_repeat;
use crate::passes::shadow::table::{TEXEL_M, Table, build};
use crate::passes::shadow::twin::Caster;
use crate::passes::shadow::{Columns, march};
use bytemuck::Zeroable;
use glam::{Vec2, Vec3};

/// Shadows on the ground.
pub const SUBJECT: Subject = Subject {
    name: "shadow",
    about: "shadows on the ground: tables of several resolutions, vertical columns, eq. 19 and coarse marching against the column integral",
    measure: cases,
};

const EARTH_M: f32 = 6_371_000.0;
const BASE_M: f32 = 1_000.0;
const REFERENCE: &str = "integral along the light";
const REFERENCE_STEPS: u32 = 512;

fn cases(run: &mut Run) -> Result<(), Stopped> {
    let all = [
        (CloudKind::Cumulus, 0.3, 60.0),
        (CloudKind::Cumulus, 0.6, 25.0),
        (CloudKind::Cumulus, 0.4, 8.0),
        (CloudKind::Stratocumulus, 0.6, 45.0),
        (CloudKind::Cumulonimbus, 0.4, 40.0),
        (CloudKind::Altocumulus, 0.5, 45.0),
        (CloudKind::Cirrus, 0.7, 35.0),
    ];
    for (kind, coverage, elevation_deg) in &all[..run.pick(2, all.len())] {
        let name = format!("{kind:?} covering {coverage}, sun at {elevation_deg} degrees");
        Sky::new(*kind, *coverage, *elevation_deg).measure(run, &name)?;
    }
    Ok(())
}

/// One layer over a flat chart, and what its shadows are made from.
struct Sky {
    layer: Layer,
    columns: Columns,
    threshold: Threshold,
    kind: CloudKind,
    bounds: Vec<u8>,
}

impl Sky {
    fn new(kind: CloudKind, coverage: f32, elevation_deg: f32) -> Self {
        let look = kind.appearance();
        let (up, flat) = elevation_deg.to_radians().sin_cos();
        let light = Vec3::new(0.6 * flat, -0.8 * flat, up);
        let voxel_height_m = look.usual_thickness_m / HEIGHT as f32;
        // As the plan has it: a sample at least for each texel that the path crosses.
        let pieces = ((voxel_height_m * flat / up / TEXEL_M).ceil() as u32).clamp(1, 8);
        let columns = Columns {
            direction: light.into(),
            begin: 0.0,
            thickness_m: look.usual_thickness_m,
            extinction_per_m: look.extinction_per_m,
            edge: look.edge,
            pieces,
            bounded: false,
        };
        let threshold = Coverage::of(kind).threshold(coverage);
        let mut layer = Layer::zeroed();
        (layer.base_m, layer.thickness_m) = (BASE_M, look.usual_thickness_m);
        (layer.light_direction, layer.extinction_per_m) = (light.into(), look.extinction_per_m);
        (layer.theta, layer.patchiness) = (threshold.offset, threshold.patchiness);
        (layer.inverse_edge, layer.charts) = (1.0 / look.edge, 1);
        layer.chart = [Chart { tile_origin_m: [3_000.0, 11_000.0], map_origin: [0.31, 0.77], ..Chart::UNUSED }; 3];
        Self { layer, columns, threshold, kind, bounds: column_bounds(&DensityVolume::of(kind).shape) }
    }

    fn measure(&self, run: &mut Run, name: &str) -> Result<(), Stopped> {
        let side = run.pick(48, 160);
        let runs = run.pick(2, 5);
        let points: Vec<Vec3> = (0..side * side)
            .map(|k| Vec2::new((k % side) as f32, (k / side) as f32) * (2.0 * TILE_M / side as f32))
            .map(|at| at.extend(-at.length_squared() / (2.0 * EARTH_M)))
            .collect();
        let volume = DensityVolume::of(self.kind);
        let textures = Textures::unlit(&volume.shape, &self.bounds);
        let marched = |steps: u32| -> Vec<f32> {
            points.iter().map(|p| march::through(&self.layer, &textures, EARTH_M, *p, steps)).collect()
        };
        let truth = marched(REFERENCE_STEPS);
        let mut record = |case: Case, found: &[f32]| {
            let differences = || found.iter().zip(&truth).map(|(found, truth)| f64::from(found - truth));
            let mean = |sum: f64| sum / truth.len() as f64;
            let apart = mean(differences().map(f64::abs).sum());
            let bias = mean(differences().sum()).abs();
            run.record(case.error("mean difference of the share", REFERENCE, apart).error(
                "difference of the mean share",
                REFERENCE,
                bias,
            ))
        };
        for steps in [8, 32, 128] {
            let (found, time_s) = measure(runs, || marched(steps));
            record(Case::new(name, "march").param("steps", steps).time(time_s), &found)?;
        }
        let (table, building_s) = measure(runs, || build(&self.columns, &volume.shape));
        let building = format!("making the table takes {:.1} ms (median)", 1e3 * building_s.median);
        for level in 0..5 {
            let read = || self.read(&self.columns, &table, &points, TEXEL_M * f32::from(1u16 << level));
            let (found, time_s) = measure(runs, read);
            let case = Case::new(name, "table").param("texels", WIDTH >> level).time(time_s).memory(memory(&table));
            record(if level == 0 { case.note(&building) } else { case }, &found)?;
        }
        // One table for all directions: the column above the path's middle, as long as the slanted path.
        let upright = Columns {
            direction: [0.0, 0.0, 1.0],
            extinction_per_m: self.columns.extinction_per_m / self.columns.direction[2],
            ..self.columns
        };
        let columns = build(&upright, &volume.shape);
        let (found, time_s) = measure(runs, || self.read(&upright, &columns, &points, TEXEL_M));
        record(Case::new(name, "vertical columns").time(time_s).memory(memory(&columns)), &found)?;
        let texture = greatest(&volume.shape);
        let (eq19, time_s) = measure(runs, || self.eq19(&texture, &points));
        let note = "T_S is the greatest shape value of each column, placed under the middle of the light's path; D = 1";
        record(Case::new(name, "eq. 19").time(time_s).memory(texture.len() as u64).note(note), &eq19)?;
        let mean = truth.iter().sum::<f32>() / truth.len() as f32;
        let note = "no single shadows: their true mean everywhere";
        record(Case::new(name, "uniform").note(note), &vec![mean; truth.len()])?;
        let found = self.read(&self.columns, &table, &points, 0.0);
        run.figure(figure(name, side, [&truth, &found, &eq19])?)
    }

    fn read(&self, columns: &Columns, table: &Table, points: &[Vec3], footprint_m: f32) -> Vec<f32> {
        let shadow = columns.shadow(BASE_M, columns.thickness_m);
        let caster = Caster { layer: &self.layer, shadow, tables: vec![table], map: modulation::map() };
        points.iter().map(|p| caster.through(EARTH_M, *p, footprint_m)).collect()
    }

    /// Equation 19 as printed, kept between 0 and 1.
    fn eq19(&self, texture: &[u8], points: &[Vec3]) -> Vec<f32> {
        let chart = &self.layer.chart[0];
        let light = Vec3::from(self.layer.light_direction);
        let height_m = BASE_M + 0.5 * self.layer.thickness_m;
        let at = |p: &Vec3| {
            let q = *p + light * (height_m / light.z);
            let moved = chart.displacement(stereographic(q, EARTH_M, EARTH_M + height_m));
            let tile = chart.tile(moved);
            let place = Vec2::from(chart.map_origin) + modulation::coordinates(moved);
            let above = map_repeat(modulation::map(), modulation::WIDTH, place.x, place.y);
            let theta = self.threshold.offset + self.threshold.patchiness * above;
            1.0 - (map_repeat(texture, WIDTH, tile.x, tile.y) - theta).clamp(0.0, 1.0)
        };
        points.iter().map(at).collect()
    }
}

fn memory(table: &Table) -> u64 {
    table.levels.iter().map(|level| 4 * level.len() as u64).sum()
}

/// Greatest shape value of each column.
fn greatest(shape: &[u8]) -> Vec<u8> {
    let columns = WIDTH * WIDTH;
    (0..columns).map(|i| (0..HEIGHT).map(|z| shape[i + z * columns]).max().unwrap_or(0)).collect()
}

/// Maps side by side, and the difference of the table from the first.
fn figure(name: &str, side: usize, [truth, table, eq19]: [&[f32]; 3]) -> Result<Figure, Stopped> {
    let error: Vec<f32> = table.iter().zip(truth).map(|(a, b)| (a - b).abs()).collect();
    let maps = [truth, table, &error, eq19];
    let mut rgba = Vec::with_capacity(4 * maps.len() * side * side);
    // North is up.
    for y in (0..side).rev() {
        for value in maps.iter().flat_map(|map| &map[y * side..][..side]) {
            // Shares of light, encoded roughly as sRGB.
            let code = (value.clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0 + 0.5) as u8;
            rgba.extend([code, code, code, 255]);
        }
    }
    let (width, height) = ((maps.len() * side) as u32, side as u32);
    let png = encode_pixels(&Pixels::Srgb8(rgba), width, height, Format::Png);
    let png = png.map_err(|error| Stopped::Failed(error.to_string()))?;
    let caption = "32 km of ground: the integral, the table, the difference of the two, and equation 19";
    Ok(Figure::png(name, caption, png))
}

#[cfg(test)]
mod tests {
    use super::super::result::CaseResult;
    use super::super::subject::Item;
    use super::*;

    #[test]
    fn the_table_is_nearer_to_the_integral_than_a_texture_and_finer_ones_nearer_still() {
        let mut found: Vec<CaseResult> = Vec::new();
        let mut sink = |item: Item| {
            if let Item::Case(case) = item {
                found.extend(case.results("shadow"));
            }
            Ok(())
        };
        let mut run = Run::new(true, &mut sink);
        Sky::new(CloudKind::Cumulus, 0.3, 60.0).measure(&mut run, "cumulus").expect("measured");
        let error = |method: &str, texels: Option<u64>| {
            let apart = |r: &&CaseResult| r.error.metric.starts_with("mean difference");
            let own = |r: &&CaseResult| r.method == method && texels.is_none_or(|n| r.params["texels"] == n);
            found.iter().filter(apart).find(own).and_then(|r| r.error.value).expect("a value")
        };
        let table = [256, 64, 16].map(|texels| error("table", Some(texels)));
        assert!(table.windows(2).all(|w| w[0] < w[1]), "{table:?}");
        // The waves that move the tile turn the light's way in it by up to a tenth: 35 m at base and top.
        assert!(table[0] < 0.06 && error("eq. 19", None) > 3.0 * table[0], "{table:?} {}", error("eq. 19", None));
        // Eight steps through 1200 m miss what is thinner; the uniform ground has none of the pattern.
        assert!(error("march", None) > 0.002 && error("uniform", None) > 4.0 * table[0]);
    }
}
