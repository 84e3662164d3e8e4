//! The deck as instanced geometry: near to far in batches, with an occlusion pass after each.

use super::deck::Scene;
use super::device::Gpu;
use super::frame::{attachment, group};
use super::pipelines::Pipelines;
use super::targets::Target;
use crate::passes::deck::instances::instances;
use crate::passes::deck::sector::sector;
use crate::plan::FramePlan;
use std::ops::Range;

/// Instances of the first batch: after each batch comes an occlusion pass, and what is nearest hides most.
const FIRST_BATCH: u32 = 2;

/// Instances of one layer to draw.
struct Draw {
    layer: usize,
    instances: Range<u32>,
}

/// Records the deck into its target.
pub fn record(gpu: &Gpu, pipelines: &mut Pipelines, encoder: &mut wgpu::CommandEncoder, scene: &Scene) {
    let Scene { plan, frame, decks, target, .. } = *scene;
    for deck in decks {
        pipelines.deck(gpu, deck.variant);
    }
    let (buffers, draws) = draws(gpu, plan);
    let (sector, steps) = sector(&plan.camera);
    let sector = gpu.buffer("sector", bytemuck::bytes_of(&sector), wgpu::BufferUsages::STORAGE);
    let mesh = group(gpu, &pipelines.mesh_layout, &[sector.as_entire_binding()]);
    let gathered = wgpu::BindingResource::TextureView(&target.deck[0]);
    let gathered = group(gpu, &pipelines.image_layout, &[gathered]);
    for (i, batch) in batches(&draws).iter().enumerate() {
        let mut pass = begin(encoder, target, true, i == 0);
        pass.set_bind_group(0, frame, &[]);
        pass.set_bind_group(2, &mesh, &[]);
        for draw in batch {
            let deck = &decks[draw.layer];
            pass.set_pipeline(pipelines.deck(gpu, deck.variant));
            pass.set_bind_group(1, &deck.group, &[]);
            pass.set_vertex_buffer(0, buffers[draw.layer].slice(..));
            pass.draw(0..2 * (steps + 1), draw.instances.clone());
        }
        drop(pass);
        let mut pass = begin(encoder, target, false, false);
        pass.set_pipeline(&pipelines.cull);
        pass.set_bind_group(1, &gathered, &[]);
        pass.draw(0..3, 0..1);
    }
}

/// A pass into the deck's targets, or into its depth alone.
fn begin<'e>(encoder: &'e mut wgpu::CommandEncoder, target: &Target, light: bool, clear: bool) -> wgpu::RenderPass<'e> {
    let attachments = [Some(attachment(&target.deck[0], clear))];
    let depth_load = if clear { wgpu::LoadOp::Clear(1.0) } else { wgpu::LoadOp::Load };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("deck"),
        color_attachments: &attachments[..usize::from(light)],
        depth_stencil_attachment: target.occlusion.as_ref().map(|view| wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(wgpu::Operations { load: depth_load, store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        }),
        ..Default::default()
    })
}

/// The instances of each layer, and in which order they are drawn.
fn draws(gpu: &Gpu, plan: &FramePlan) -> (Vec<wgpu::Buffer>, Vec<Draw>) {
    let (eye_m, earth_m) = (plan.camera.eye_m, plan.camera.earth_m);
    let (mut buffers, mut parts) = (Vec::new(), Vec::new());
    for layer in &plan.layers {
        let found = instances(&layer.layer, layer.slices, earth_m, eye_m);
        let (near, far) = (found.near.len() as u32, found.far.len() as u32);
        let all = [found.near, found.far].concat();
        buffers.push(gpu.buffer("instances", bytemuck::cast_slice(&all), wgpu::BufferUsages::VERTEX));
        parts.push((near, near + far));
    }
    let draw = |layer: usize, far: bool| {
        let (near, all) = parts[layer];
        Draw { layer, instances: if far { near..all } else { 0..near } }
    };
    let lies = |i: &usize| {
        let layer = &plan.layers[*i].layer;
        (layer.base_m < eye_m, layer.base_m + layer.thickness_m > eye_m)
    };
    let layers = 0..plan.layers.len();
    let below: Vec<usize> = layers.clone().filter(|i| lies(i) == (true, false)).collect();
    let around: Vec<usize> = layers.clone().filter(|i| lies(i) == (true, true)).collect();
    let above: Vec<usize> = layers.filter(|i| lies(i) == (false, true)).collect();
    // Near to far along any ray: the layer that the eye is in; falling through those below; rising through them again
    // beyond the ray's lowest point; then those above.
    let mut draws: Vec<Draw> = around.iter().map(|i| draw(*i, false)).collect();
    draws.extend(below.iter().rev().map(|i| draw(*i, false)));
    draws.extend(below.iter().chain(&around).map(|i| draw(*i, true)));
    draws.extend(above.iter().map(|i| draw(*i, false)));
    draws.retain(|d| !d.instances.is_empty());
    (buffers, draws)
}

/// Cuts the draws into batches, each half as large again as the one before.
fn batches(draws: &[Draw]) -> Vec<Vec<Draw>> {
    let (mut batches, mut size, mut room) = (Vec::new(), FIRST_BATCH, 0);
    for draw in draws {
        let mut rest = draw.instances.clone();
        while !rest.is_empty() {
            if room == 0 {
                batches.push(Vec::new());
                room = size;
                size += size.div_ceil(2);
            }
            let end = rest.end.min(rest.start + room);
            room -= end - rest.start;
            if let Some(batch) = batches.last_mut() {
                batch.push(Draw { layer: draw.layer, instances: rest.start..end });
            }
            rest.start = end;
        }
    }
    batches
}
