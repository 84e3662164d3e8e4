//! The reference executor: plays a plan with the twins, rows over all cores. Needs no graphics adapter.

use crate::clouds::density::DensityVolume;
use crate::clouds::{CloudKind, detail, modulation};
use crate::frame::Pixels;
use crate::passes::deck::field::{Textures, column_bounds};
use crate::passes::deck::twin::{Prepared, walk};
use crate::passes::light::Light;
use crate::passes::sky::table::{TableParams, Texel, build};
use crate::passes::sky::twin as sky;
use crate::passes::{ground, light, tonemap};
use crate::plan::executor::{Executor, Fault, Finished};
use crate::plan::{FramePlan, Output};
use glam::Vec3;
use rayon::prelude::*;
use std::collections::VecDeque;
use std::sync::Arc;

/// Light volumes kept at once (8 MiB each).
const VOLUMES_KEPT: usize = 16;

/// Plays plans on the CPU.
#[derive(Default)]
pub struct ReferenceExecutor {
    finished: VecDeque<Finished>,
    table: Option<(TableParams, Arc<Vec<Texel>>)>,
    volumes: VecDeque<((CloudKind, Light), Arc<Vec<[u8; 4]>>)>,
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
        let mut volumes = Vec::new();
        let mut bounds = Vec::new();
        for layer in &plan.layers {
            volumes.push(layer.light.iter().map(|l| self.volume(layer.kind, l)).collect::<Vec<_>>());
            bounds.push(self.bounds(layer.kind));
        }
        let slices: Vec<Vec<&[[u8; 4]]>> = volumes.iter().map(|v| v.iter().map(|t| t.as_slice()).collect()).collect();
        let layers: Vec<Prepared> = plan
            .layers
            .iter()
            .enumerate()
            .map(|(i, layer)| {
                let textures = Textures {
                    volumes: &slices[i],
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

    fn volume(&mut self, kind: CloudKind, params: &Light) -> Arc<Vec<[u8; 4]>> {
        keep(&mut self.volumes, (kind, *params), VOLUMES_KEPT, || {
            light::twin::light(params, &DensityVolume::of(kind).shape)
        })
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
    match plan.output {
        Output::Srgb8 => {
            let mut bytes = vec![0u8; width * height * 4];
            bytes.par_chunks_mut(width * 4).enumerate().for_each(|(y, row)| {
                for (x, pixel) in row.chunks_exact_mut(4).enumerate() {
                    let exposed = luminance(plan, table, layers, x, y) * plan.camera.exposure;
                    pixel.copy_from_slice(&tonemap::twin::tonemap(exposed, x as u32, y as u32));
                }
            });
            Pixels::Srgb8(bytes)
        }
        Output::LinearRgb => {
            let mut values = vec![0f32; width * height * 3];
            values.par_chunks_mut(width * 3).enumerate().for_each(|(y, row)| {
                for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
                    pixel.copy_from_slice(&luminance(plan, table, layers, x, y).to_array());
                }
            });
            Pixels::LinearRgb(values)
        }
    }
}

/// Luminance of one pixel, cd/m2 per colour.
fn luminance(plan: &FramePlan, table: &[Texel], layers: &[Prepared], x: usize, y: usize) -> Vec3 {
    let direction = plan.camera.ray(x as f32 + 0.5, y as f32 + 0.5);
    let (air, passed) = sky::air(&plan.sky, table, direction);
    let end_m = ground::twin::range(&plan.camera, direction);
    // Luminance that an endless column of this air would have: what haze in front of things tends to.
    let endless = air / (1.0 - passed).max(0.02);
    let gathered = walk(&plan.camera, layers, direction, end_m, endless);
    let mut behind = air;
    if gathered.transmittance > crate::passes::deck::twin::OPAQUE {
        match &plan.ground {
            Some(g) if end_m.is_finite() => {
                let seen = ground::twin::luminance(g, modulation::map(), &plan.camera, direction, end_m, 1.0);
                behind += seen * passed;
            }
            _ => behind += sky::discs(&plan.sky, direction),
        }
    }
    gathered.luminance + behind * gathered.transmittance
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
