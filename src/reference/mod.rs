//! The reference executor: plays a plan with the twins, rows over all cores. Needs no graphics adapter.

pub mod converged;
mod images;
pub mod monte_carlo;
mod shell;

use crate::clouds::density::DensityVolume;
use crate::clouds::{CloudKind, detail, modulation};
use crate::frame::Pixels;
use crate::passes::deck::field::{Textures, empty_space};
use crate::passes::deck::glow::{self, GlowWindow};
use crate::passes::deck::twin::{OPAQUE, Prepared};
use crate::passes::light::Light;
use crate::passes::light::library;
use crate::passes::light::volume::{Texels, Volume};
use crate::passes::relief::Relief;
use crate::passes::relief::field::Grids;
use crate::passes::relief::window::{Tiles, Window, highest_m};
use crate::passes::relight::{self, Lits, store::Store, tables::Tables};
use crate::passes::shadow::table::{self, Table};
use crate::passes::shadow::twin::Caster;
use crate::passes::shadow::{Columns, shade};
use crate::passes::sky::table::{TableParams, Texel, build};
use crate::passes::sky::twin as sky;
use crate::passes::{beams, ground, stroke, tonemap};
use crate::plan::executor::{Executor, Fault, Finished, Unused};
use crate::plan::{FramePlan, LayerPlan, LayerShadow, Output};
use glam::{Vec3, Vec4};
use images::Image;
use rayon::prelude::*;
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

/// Light volumes kept at once (2 MiB for each theta in 8 bits), or as many as one picture needs.
const VOLUMES_KEPT: usize = 4;

/// Bytes of a flash's field: 16,384 cells of four numbers at most.
const FIELD_BYTES: usize = 256 * 1024;

/// Plays plans on the CPU.
#[derive(Default)]
pub struct ReferenceExecutor {
    finished: VecDeque<Finished>,
    table: Option<(TableParams, Arc<Vec<Texel>>)>,
    volumes: VecDeque<((CloudKind, Light), Arc<Volume>)>,
    bounds: VecDeque<(CloudKind, Arc<Vec<u8>>)>,
    shadows: VecDeque<((CloudKind, Columns), Arc<Table>)>,
    tiles: Tiles,
    nodes: Option<(Window, Arc<Vec<u32>>)>,
    light_tiles: Tiles,
    lights: Option<(Window, Arc<Vec<u32>>)>,
    glow: Option<(GlowWindow, Arc<Vec<glow::Texel>>)>,
    fields: Store,
    /// Pictures without clouds, and without ground that has heights, a shore or lamps.
    unused: [Unused; 2],
    /// Whether the last picture stands in for something still being made.
    provisional: bool,
}

impl ReferenceExecutor {
    /// An executor with nothing prepared yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// An executor with these tables of virtual lights, which it may share with others.
    pub fn with_tables(tables: Arc<Tables>) -> Self {
        Self { fields: Store::new(tables, false), ..Self::default() }
    }

    /// What is held for the pictures to come, by name, in bytes. What is nothing is left out.
    pub fn held(&self) -> Vec<(&'static str, usize)> {
        let volume = |volume: &Volume| match &volume.texels {
            Texels::Bytes(texels) => size_of_val(texels.as_slice()),
            Texels::Half(texels) => size_of_val(texels.as_slice()),
        };
        let table = |table: &Table| table.levels.iter().map(|level| size_of_val(level.as_slice())).sum::<usize>();
        let nodes =
            |kept: &Option<(Window, Arc<Vec<u32>>)>| kept.as_ref().map_or(0, |(_, n)| size_of_val(n.as_slice()));
        let all = [
            ("sky table", self.table.as_ref().map_or(0, |(_, table)| size_of_val(table.as_slice()))),
            ("light in clouds", self.volumes.iter().map(|(_, light)| volume(light)).sum()),
            ("empty space in clouds", self.bounds.iter().map(|(_, bounds)| bounds.len()).sum()),
            ("shadows", self.shadows.iter().map(|(_, shadow)| table(shadow)).sum()),
            ("heights and shores", nodes(&self.nodes) + self.tiles.bytes()),
            ("lamps", nodes(&self.lights) + self.light_tiles.bytes()),
            ("city glow", self.glow.as_ref().map_or(0, |(_, glow)| size_of_val(glow.as_slice()))),
            ("fields of flashes", self.fields.len() * FIELD_BYTES),
            ("tables of flashes", self.fields.tables().bytes()),
        ];
        all.into_iter().filter(|(_, bytes)| *bytes > 0).collect()
    }

    /// Forgets what the pictures have done without for long.
    fn forget(&mut self, plan: &FramePlan) {
        let [clouds, relief] = &mut self.unused;
        if clouds.is_due(!plan.layers.is_empty()) {
            (self.volumes, self.bounds, self.shadows) = (VecDeque::new(), VecDeque::new(), VecDeque::new());
            library::forget();
        }
        if relief.is_due(plan.relief.is_some()) {
            (self.nodes, self.tiles) = (None, Tiles::default());
        }
    }

    /// Draws a plan at once.
    pub fn draw(&mut self, plan: &FramePlan) -> Pixels {
        self.prepared(plan, |table, layers, casters, grids| picture(plan, table, layers, casters, grids))
    }

    /// Makes everything that a plan's pixels read, and hands it over: the table of scattered light, the
    /// layers, what casts shadows, and the heights around the eye.
    pub fn prepared<T>(
        &mut self,
        plan: &FramePlan,
        work: impl FnOnce(&[Texel], &[Prepared], &[Caster], Option<&Grids>) -> T,
    ) -> T {
        self.forget(plan);
        let table = self.table(&plan.table);
        self.fields.tables().set_most((plan.basis_memory_mib as usize) << 20);
        let fields = relight::Prepared::new(&mut self.fields, &plan.lit, &plan.ahead, plan.waits);
        self.provisional = fields.provisional;
        let lit = plan.glow.as_ref().map(|plan| (plan.glow, self.glow(&plan.window)));
        if plan.glow.is_none() {
            self.glow = None;
        }
        let most = plan.layers.iter().map(|layer| layer.light.len()).sum::<usize>().max(VOLUMES_KEPT);
        let mut volumes = Vec::new();
        let (mut bounds, mut shapes) = (Vec::new(), Vec::new());
        for layer in &plan.layers {
            volumes.push(layer.light.iter().map(|l| self.volume(layer.kind, l, most)).collect::<Vec<_>>());
            bounds.push(self.bounds(layer.kind));
            shapes.push(DensityVolume::of(layer.kind));
        }
        let lights: Vec<Vec<&Volume>> = volumes.iter().map(|v| v.iter().map(|volume| &**volume).collect()).collect();
        let shades: Vec<Option<Vec<f32>>> = plan.layers.iter().map(|layer| self.shade(plan, layer)).collect();
        let textures = |i: usize| Textures {
            shape: &shapes[i].shape,
            lights: &lights[i],
            bounds: &bounds[i],
            map: modulation::map(),
            detail: detail::volume(),
            shade: shades[i].as_deref(),
            glow: lit.as_ref().map(|(glow, table)| (glow, table.as_slice())),
        };
        let layers: Vec<Prepared> = plan
            .layers
            .iter()
            .enumerate()
            .map(|(i, layer)| Prepared::new(&layer.layer, textures(i)).lit_by(&fields))
            .collect();
        let shadows = plan.shadow.as_ref().map_or(&[][..], |shadow| &shadow.casters);
        let tables = self.shadows(plan, shadows);
        let nodes = plan.relief.as_ref().map(|relief| self.nodes(&relief.window));
        let lies = plan.relief.as_ref().zip(nodes.as_ref());
        let lies = lies.map(|(plan, nodes)| Relief { highest_m: highest_m(nodes), ..plan.relief });
        let lamps = plan.relief.as_ref().filter(|relief| relief.lights).map(|relief| self.lights(&relief.window));
        if lamps.is_none() {
            (self.lights, self.light_tiles) = (None, Tiles::default());
        }
        let lights = lamps.as_ref().map(|lights| lights.as_slice());
        let grids = lies.as_ref().zip(nodes.as_ref()).map(|(relief, nodes)| Grids { relief, nodes, lights });
        work(&table, &layers, &casters(plan, shadows, &tables), grids.as_ref())
    }

    /// The map of the shade on a layer.
    fn shade(&mut self, plan: &FramePlan, layer: &LayerPlan) -> Option<Vec<f32>> {
        if layer.shade.is_empty() {
            return None;
        }
        let tables = self.shadows(plan, &layer.shade);
        Some(shade::map(&layer.layer, &casters(plan, &layer.shade, &tables), plan.camera.earth_m))
    }

    fn table(&mut self, params: &TableParams) -> Arc<Vec<Texel>> {
        match &self.table {
            Some((kept, table)) if kept == params => table.clone(),
            _ => {
                let table = Arc::new(build(params));
                self.table = Some((*params, table.clone()));
                table
            }
        }
    }

    /// The heights of a window; made where they are not those of the picture before.
    fn nodes(&mut self, window: &Window) -> Arc<Vec<u32>> {
        match &self.nodes {
            Some((kept, nodes)) if kept == window => nodes.clone(),
            _ => {
                let nodes = Arc::new(self.tiles.nodes(window));
                self.nodes = Some((window.clone(), nodes.clone()));
                nodes
            }
        }
    }

    /// The lights of cities in a window.
    fn lights(&mut self, window: &Window) -> Arc<Vec<u32>> {
        match &self.lights {
            Some((kept, lights)) if kept == window => lights.clone(),
            _ => {
                let lights = Arc::new(self.light_tiles.filled(window, ground::lights::tile));
                self.lights = Some((window.clone(), lights.clone()));
                lights
            }
        }
    }

    /// The glow table of a window.
    fn glow(&mut self, window: &GlowWindow) -> Arc<Vec<glow::Texel>> {
        match &self.glow {
            Some((kept, table)) if kept == window => table.clone(),
            _ => {
                let table = Arc::new(glow::build(window));
                self.glow = Some((window.clone(), table.clone()));
                table
            }
        }
    }

    fn volume(&mut self, kind: CloudKind, params: &Light, most: usize) -> Arc<Volume> {
        keep(&mut self.volumes, (kind, *params), most, || Volume::of(kind, params))
    }

    /// The tables of layers that cast shadows.
    fn shadows(&mut self, plan: &FramePlan, casters: &[LayerShadow]) -> Vec<Vec<Arc<Table>>> {
        let most = plan.tables().max(VOLUMES_KEPT);
        let of = |caster: &LayerShadow| {
            let kind = plan.layers[caster.layer].kind;
            let mut table = |columns: &Columns| {
                let make = || table::build(columns, &DensityVolume::of(kind).shape);
                keep(&mut self.shadows, (kind, *columns), most, make)
            };
            caster.columns.iter().map(&mut table).collect()
        };
        casters.iter().map(of).collect()
    }

    fn bounds(&mut self, kind: CloudKind) -> Arc<Vec<u8>> {
        keep(&mut self.bounds, kind, CloudKind::COUNT, || empty_space(kind))
    }
}

/// Looks a key up and moves it to the front; makes the value where it is not kept, and drops the one used longest ago.
fn keep<K: PartialEq, V>(kept: &mut VecDeque<(K, Arc<V>)>, key: K, most: usize, make: impl FnOnce() -> V) -> Arc<V> {
    let entry = match kept.iter().position(|(k, _)| *k == key).and_then(|at| kept.remove(at)) {
        Some(entry) => entry,
        None => (key, Arc::new(make())),
    };
    let value = entry.1.clone();
    kept.push_front(entry);
    kept.truncate(most);
    value
}

/// The picture of a plan from what [`ReferenceExecutor::prepared`] hands over, or from layers changed to compare with.
pub fn picture(
    plan: &FramePlan,
    table: &[Texel],
    layers: &[Prepared],
    casters: &[Caster],
    grids: Option<&Grids>,
) -> Pixels {
    let [width, height] = plan.size_px.map(|n| n as usize);
    let ranges = images::ranges(plan, grids);
    let ranges = ranges.as_ref();
    let deck = images::deck(plan, table, layers, ranges);
    let shadow = images::shadow(plan, casters, &deck, ranges);
    let strokes = images::strokes(plan, layers);
    let lits = layers.first().and_then(|layer| layer.lit).map(|lit| &lit.lits);
    let behind = Scene { plan, table, grids, ranges, deck: &deck, shadow: &shadow, strokes: strokes.as_ref(), lits };
    match plan.output {
        Output::Srgb8 => {
            let mut bytes = vec![0u8; width * height * 4];
            bytes.par_chunks_mut(width * 4).enumerate().for_each(|(y, row)| {
                for (x, pixel) in row.chunks_exact_mut(4).enumerate() {
                    let exposed = behind.seen(x, y) * plan.camera.exposure;
                    pixel.copy_from_slice(&tonemap::twin::tonemap(exposed, x as u32, y as u32));
                }
            });
            Pixels::Srgb8(bytes)
        }
        Output::LinearRgb => {
            let mut values = vec![0f32; width * height * 3];
            values.par_chunks_mut(width * 3).enumerate().for_each(|(y, row)| {
                for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
                    pixel.copy_from_slice(&behind.seen(x, y).to_array());
                }
            });
            Pixels::LinearRgb(values)
        }
    }
}

/// What a pixel is made from.
struct Scene<'a> {
    plan: &'a FramePlan,
    table: &'a [Texel],
    grids: Option<&'a Grids<'a>>,
    ranges: Option<&'a Image<f32>>,
    deck: &'a Image<Vec4>,
    shadow: &'a Image<f32>,
    strokes: Option<&'a Image<f32>>,
    lits: Option<&'a Lits>,
}

impl Scene<'_> {
    /// Luminance of one pixel with the strokes over it, cd/m2 per colour.
    fn seen(&self, x: usize, y: usize) -> Vec3 {
        let at = x + y * self.plan.size_px[0] as usize;
        let strokes = self.strokes.map_or(Vec3::ZERO, |strokes| stroke::COLOUR * strokes.texels[at]);
        self.luminance(x, y) + strokes + self.beams(x, y)
    }

    /// What of the own ship's lights is scattered towards the eye.
    fn beams(&self, x: usize, y: usize) -> Vec3 {
        let Some(lit) = &self.plan.beams else { return Vec3::ZERO };
        let at = [x as f32 + 0.5, y as f32 + 0.5];
        let direction = self.plan.camera.ray(at[0], at[1]);
        Vec3::splat(beams::twin::luminance(
            lit,
            direction,
            images::range(self.ranges, &self.plan.camera, at, direction),
        ))
    }

    /// Luminance of one pixel without them, cd/m2 per colour.
    fn luminance(&self, x: usize, y: usize) -> Vec3 {
        let Self { plan, table, grids, ranges, deck, shadow, lits, .. } = *self;
        let at = [x as f32 + 0.5, y as f32 + 0.5];
        let [u, v] = [at[0] / plan.camera.width_px, at[1] / plan.camera.height_px];
        let gathered = deck.at(u, v);
        let shows = 1.0 - gathered.w;
        if shows < OPAQUE {
            return gathered.truncate();
        }
        let direction = plan.camera.ray(at[0], at[1]);
        let (air, passed) = sky::air(&plan.sky, table, direction);
        let camera = &plan.camera;
        let end_m = images::range(ranges, camera, at, direction);
        let behind = match &plan.ground {
            Some(ground) if end_m.is_finite() => {
                let terrain = plan.terrain();
                let place =
                    ground::twin::Place { ground, map: modulation::map(), grids: grids.copied(), lits, terrain };
                let seen = place.luminance(camera, direction, end_m, shadow.at(u, v));
                if terrain {
                    // Air up to ground that may stand before the sky.
                    let passed_here = camera.air_transmittance(camera.height_at(direction.z, end_m), end_m);
                    let before = if direction.z < plan.sky.horizon {
                        air / (1.0 - passed).max(0.02)
                    } else {
                        sky::endless(&plan.sky, table, direction)
                    };
                    seen * passed_here + before * (1.0 - passed_here)
                } else {
                    air + passed * seen
                }
            }
            _ => {
                let stars = plan.stars.as_ref();
                let stars = stars.map_or(Vec3::ZERO, |stars| sky::starlight(stars, &plan.sky, direction, passed));
                air + sky::discs(&plan.sky, direction) + stars
            }
        };
        gathered.truncate() + behind * shows
    }
}

fn casters<'a>(plan: &'a FramePlan, casters: &'a [LayerShadow], tables: &'a [Vec<Arc<Table>>]) -> Vec<Caster<'a>> {
    let caster = |(caster, tables): (&'a LayerShadow, &'a Vec<Arc<Table>>)| Caster {
        layer: &plan.layers[caster.layer].layer,
        shadow: caster.shadow,
        tables: tables.iter().map(Arc::as_ref).collect(),
        map: modulation::map(),
    };
    casters.iter().zip(tables).map(caster).collect()
}

impl Executor for ReferenceExecutor {
    fn describe(&self) -> String {
        format!("reference executor on {} threads", rayon::current_num_threads())
    }

    fn submit(&mut self, ticket: u64, plan: &FramePlan) -> Result<(), Fault> {
        let pixels = self.draw(plan);
        let provisional = self.provisional;
        self.finished.push_back(Finished { ticket, pixels, provisional, read_back: Duration::ZERO });
        Ok(())
    }

    fn collect(&mut self, _wait: bool) -> Result<Vec<Finished>, Fault> {
        Ok(self.finished.drain(..).collect())
    }

    fn depth(&self) -> usize {
        1
    }

    fn tables(&self) -> Option<Arc<Tables>> {
        Some(self.fields.tables().clone())
    }
}

#[cfg(test)]
pub(crate) mod tests;
