//! The reference executor: plays a plan with the twins, rows over all cores. Needs no graphics adapter.

use crate::clouds::density::DensityVolume;
use crate::clouds::{CloudKind, detail, modulation};
use crate::frame::Pixels;
use crate::passes::deck::field::{Textures, column_bounds};
use crate::passes::deck::twin::{OPAQUE, Prepared, walk};
use crate::passes::light::Light;
use crate::passes::sky::table::{TableParams, Texel, build};
use crate::passes::sky::twin as sky;
use crate::passes::{ground, light, tonemap};
use crate::plan::executor::{Executor, Fault, Finished};
use crate::plan::{FramePlan, Output};
use glam::{Vec3, Vec4};
use rayon::prelude::*;
use std::collections::VecDeque;
use std::sync::Arc;

/// Light volumes kept at once (8 MiB each), or as many as one picture needs.
const VOLUMES_KEPT: usize = 16;

/// Texels of a light volume.
type Volume = Vec<[u8; 4]>;

/// Plays plans on the CPU.
#[derive(Default)]
pub struct ReferenceExecutor {
    finished: VecDeque<Finished>,
    table: Option<(TableParams, Arc<Vec<Texel>>)>,
    volumes: VecDeque<((CloudKind, Light), Arc<Volume>)>,
    bounds: VecDeque<(CloudKind, Arc<Vec<u8>>)>,
}

impl ReferenceExecutor {
    /// An executor with nothing prepared yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Draws a plan at once.
    pub fn draw(&mut self, plan: &FramePlan) -> Pixels {
        let table = self.table(&plan.table);
        let most = plan.layers.iter().map(|layer| layer.light.len()).sum::<usize>().max(VOLUMES_KEPT);
        let mut volumes = Vec::new();
        let (mut bounds, mut shapes) = (Vec::new(), Vec::new());
        for layer in &plan.layers {
            volumes.push(layer.light.iter().map(|l| self.volume(layer.kind, l, most)).collect::<Vec<_>>());
            bounds.push(self.bounds(layer.kind));
            shapes.push(DensityVolume::of(layer.kind));
        }
        let slices: Vec<Vec<&[[u8; 4]]>> = volumes.iter().map(|v| v.iter().map(|t| t.as_slice()).collect()).collect();
        let layers: Vec<Prepared> = plan
            .layers
            .iter()
            .enumerate()
            .map(|(i, layer)| {
                let textures = Textures {
                    shape: &shapes[i].shape,
                    lights: &slices[i],
                    bounds: &bounds[i],
                    map: modulation::map(),
                    detail: detail::volume(),
                };
                Prepared::new(&layer.layer, layer.slices, textures)
            })
            .collect();
        picture(plan, &table, &layers)
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

    fn volume(&mut self, kind: CloudKind, params: &Light, most: usize) -> Arc<Volume> {
        keep(&mut self.volumes, (kind, *params), most, || light::twin::light(params, &DensityVolume::of(kind).shape))
    }

    fn bounds(&mut self, kind: CloudKind) -> Arc<Vec<u8>> {
        keep(&mut self.bounds, kind, CloudKind::ALL.len(), || column_bounds(&DensityVolume::of(kind).shape))
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

fn picture(plan: &FramePlan, table: &[Texel], layers: &[Prepared]) -> Pixels {
    let [width, height] = plan.size_px.map(|n| n as usize);
    let deck = DeckImage::new(plan, table, layers);
    match plan.output {
        Output::Srgb8 => {
            let mut bytes = vec![0u8; width * height * 4];
            bytes.par_chunks_mut(width * 4).enumerate().for_each(|(y, row)| {
                for (x, pixel) in row.chunks_exact_mut(4).enumerate() {
                    let exposed = luminance(plan, table, &deck, x, y) * plan.camera.exposure;
                    pixel.copy_from_slice(&tonemap::twin::tonemap(exposed, x as u32, y as u32));
                }
            });
            Pixels::Srgb8(bytes)
        }
        Output::LinearRgb => {
            let mut values = vec![0f32; width * height * 3];
            values.par_chunks_mut(width * 3).enumerate().for_each(|(y, row)| {
                for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
                    pixel.copy_from_slice(&luminance(plan, table, &deck, x, y).to_array());
                }
            });
            Pixels::LinearRgb(values)
        }
    }
}

/// The deck by itself, at its own resolution: luminance and what it hides.
struct DeckImage {
    size: [usize; 2],
    texels: Vec<Vec4>,
}

impl DeckImage {
    fn new(plan: &FramePlan, table: &[Texel], layers: &[Prepared]) -> Self {
        if layers.is_empty() {
            return Self { size: [1, 1], texels: vec![Vec4::ZERO] };
        }
        let camera = plan.camera.coarser(plan.deck_scale);
        let legs = plan.legs();
        let size = [camera.width_px as usize, camera.height_px as usize];
        let mut texels = vec![Vec4::ZERO; size[0] * size[1]];
        texels.par_chunks_mut(size[0]).enumerate().for_each(|(y, row)| {
            for (x, texel) in row.iter_mut().enumerate() {
                let direction = camera.ray(x as f32 + 0.5, y as f32 + 0.5);
                let end_m = ground::twin::range(&camera, direction);
                let (air, passed) = sky::air(&plan.sky, table, direction);
                // Luminance that an endless column of this air would have: what haze in front of things tends to.
                let endless = air / (1.0 - passed).max(0.02);
                let gathered = walk(&camera, layers, &legs, direction, end_m, endless);
                *texel = gathered.luminance.extend(1.0 - gathered.transmittance);
            }
        });
        Self { size, texels }
    }

    /// Bilinear, clamped; coordinates in the whole picture, 0 to 1.
    fn at(&self, u: f32, v: f32) -> Vec4 {
        let [width, height] = self.size;
        let (x, y) = (u * width as f32 - 0.5, v * height as f32 - 0.5);
        let (x0, y0) = (x.floor(), y.floor());
        let texel = |dx: i32, dy: i32| {
            let column = (x0 as i32 + dx).clamp(0, width as i32 - 1) as usize;
            let row = (y0 as i32 + dy).clamp(0, height as i32 - 1) as usize;
            self.texels[column + row * width]
        };
        let low = texel(0, 0).lerp(texel(1, 0), x - x0);
        low.lerp(texel(0, 1).lerp(texel(1, 1), x - x0), y - y0)
    }
}

/// Luminance of one pixel, cd/m2 per colour.
fn luminance(plan: &FramePlan, table: &[Texel], deck: &DeckImage, x: usize, y: usize) -> Vec3 {
    let at = [x as f32 + 0.5, y as f32 + 0.5];
    let gathered = deck.at(at[0] / plan.camera.width_px, at[1] / plan.camera.height_px);
    let shows = 1.0 - gathered.w;
    if shows < OPAQUE {
        return gathered.truncate();
    }
    let direction = plan.camera.ray(at[0], at[1]);
    let (air, passed) = sky::air(&plan.sky, table, direction);
    let end_m = ground::twin::range(&plan.camera, direction);
    let behind = match &plan.ground {
        Some(g) if end_m.is_finite() => {
            air + passed * ground::twin::luminance(g, modulation::map(), &plan.camera, direction, end_m, 1.0)
        }
        _ => air + sky::discs(&plan.sky, direction),
    };
    gathered.truncate() + behind * shows
}

impl Executor for ReferenceExecutor {
    fn describe(&self) -> String {
        format!("reference executor on {} threads", rayon::current_num_threads())
    }

    fn submit(&mut self, ticket: u64, plan: &FramePlan) -> Result<(), Fault> {
        let pixels = self.draw(plan);
        self.finished.push_back(Finished { ticket, pixels });
        Ok(())
    }

    fn collect(&mut self, _wait: bool) -> Result<Vec<Finished>, Fault> {
        Ok(self.finished.drain(..).collect())
    }

    fn depth(&self) -> usize {
        1
    }
}

#[cfg(test)]
mod tests;
