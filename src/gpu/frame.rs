//! One frame: from a plan to commands.

use super::GpuExecutor;
use super::device::Gpu;
use super::pipelines::{DeckVariant, Pipelines};
use super::resident::{Resident, VOLUMES_KEPT};
use super::ring::Content;
use super::targets::Target;
use crate::passes::common::Camera;
use crate::passes::deck::instances::instances;
use crate::passes::deck::sector::sector;
use crate::plan::{FramePlan, LayerPlan, Output};
use std::ops::Range;

/// Instances of the first batch: after each batch comes an occlusion pass, and what is nearest hides most.
const FIRST_BATCH: u32 = 2;

/// One layer ready to be drawn.
struct Deck {
    variant: DeckVariant,
    group: wgpu::BindGroup,
    instances: wgpu::Buffer,
    vertices: u32,
}

/// Instances of one layer to draw.
struct Draw {
    deck: usize,
    instances: Range<u32>,
}

/// Records and submits a plan, and enters its picture into the ring.
pub fn submit(executor: &mut GpuExecutor, ticket: u64, plan: &FramePlan) {
    let GpuExecutor { gpu, pipelines, resident, targets, ring } = executor;
    let (decks, draws) = decks(gpu, pipelines, resident, plan);
    for deck in &decks {
        pipelines.deck(gpu, deck.variant);
    }
    let target = targets.of(gpu, plan.size_px, plan.deck_scale);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let recorder = Recorder { gpu, target };
    let nothing = resident.nothing.clone();
    if !draws.is_empty() {
        let frame = frame_group(gpu, pipelines, resident, plan, &plan.camera.coarser(plan.deck_scale), &nothing);
        for (i, batch) in batches(&draws).iter().enumerate() {
            recorder.deck(&mut encoder, pipelines, &frame, &decks, batch, i == 0);
            recorder.cull(&mut encoder, pipelines);
        }
    }
    let deck = if draws.is_empty() { &nothing } else { &target.deck_view };
    let frame = frame_group(gpu, pipelines, resident, plan, &plan.camera, deck);
    recorder.behind(&mut encoder, pipelines, &frame, plan);
    let (texture, content) = match plan.output {
        Output::Srgb8 => {
            recorder.tonemap(&mut encoder, pipelines);
            (&target.picture, Content::Srgb8)
        }
        Output::LinearRgb => (&target.light, Content::Light { exposure: plan.camera.exposure }),
    };
    let copied = ring.copy(gpu, &mut encoder, texture, plan.size_px);
    let submission = gpu.queue.submit([encoder.finish()]);
    ring.enter(ticket, plan.size_px, content, copied, submission);
}

fn frame_group(
    gpu: &Gpu,
    pipelines: &Pipelines,
    resident: &mut Resident,
    plan: &FramePlan,
    camera: &Camera,
    deck: &wgpu::TextureView,
) -> wgpu::BindGroup {
    let camera = gpu.buffer("camera", bytemuck::bytes_of(camera), wgpu::BufferUsages::STORAGE);
    let sky = gpu.buffer("sky", bytemuck::bytes_of(&plan.sky), wgpu::BufferUsages::STORAGE);
    let table = resident.table(gpu, &plan.table);
    group(
        gpu,
        &pipelines.frame_layout,
        &[
            camera.as_entire_binding(),
            sky.as_entire_binding(),
            wgpu::BindingResource::TextureView(&table),
            wgpu::BindingResource::Sampler(&resident.clamped),
            wgpu::BindingResource::TextureView(&resident.map),
            wgpu::BindingResource::Sampler(&resident.repeated),
            wgpu::BindingResource::TextureView(deck),
        ],
    )
}

fn group(gpu: &Gpu, layout: &wgpu::BindGroupLayout, resources: &[wgpu::BindingResource]) -> wgpu::BindGroup {
    let entries: Vec<_> = resources
        .iter()
        .enumerate()
        .map(|(i, resource)| wgpu::BindGroupEntry { binding: i as u32, resource: resource.clone() })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

/// The layers, and in which order their instances are drawn.
fn decks(gpu: &Gpu, pipelines: &Pipelines, resident: &mut Resident, plan: &FramePlan) -> (Vec<Deck>, Vec<Draw>) {
    let (eye_m, earth_m) = (plan.camera.eye_m, plan.camera.earth_m);
    let mut decks = Vec::new();
    let mut parts = Vec::new();
    for layer in &plan.layers {
        let found = instances(&layer.layer, layer.slices, earth_m, eye_m);
        let (near, far) = (found.near.len() as u32, found.far.len() as u32);
        let all = [found.near, found.far].concat();
        decks.push(deck(gpu, pipelines, resident, plan, layer, bytemuck::cast_slice(&all)));
        parts.push((near, near + far));
    }
    let draw = |deck: usize, far: bool| {
        let (near, all) = parts[deck];
        Draw { deck, instances: if far { near..all } else { 0..near } }
    };
    let lies = |i: &usize| {
        let layer = &plan.layers[*i].layer;
        (layer.base_m < eye_m, layer.base_m + layer.thickness_m > eye_m)
    };
    let below: Vec<usize> = (0..decks.len()).filter(|i| lies(i) == (true, false)).collect();
    let around: Vec<usize> = (0..decks.len()).filter(|i| lies(i) == (true, true)).collect();
    let above: Vec<usize> = (0..decks.len()).filter(|i| lies(i) == (false, true)).collect();
    // Near to far along any ray: the layer that the eye is in; falling through those below; rising through them again
    // beyond the ray's lowest point; then those above.
    let mut draws: Vec<Draw> = around.iter().map(|i| draw(*i, false)).collect();
    draws.extend(below.iter().rev().map(|i| draw(*i, false)));
    draws.extend(below.iter().chain(&around).map(|i| draw(*i, true)));
    draws.extend(above.iter().map(|i| draw(*i, false)));
    draws.retain(|d| !d.instances.is_empty());
    (decks, draws)
}

fn deck(
    gpu: &Gpu,
    pipelines: &Pipelines,
    resident: &mut Resident,
    plan: &FramePlan,
    layer: &LayerPlan,
    instances: &[u8],
) -> Deck {
    // Fewer than one picture needs would be made anew for each picture.
    let most = plan.layers.iter().map(|layer| layer.light.len()).sum::<usize>().max(VOLUMES_KEPT);
    let volumes: Vec<_> = layer.light.iter().map(|l| resident.volume(gpu, pipelines, layer.kind, l, most)).collect();
    let bounds = resident.bounds(gpu, layer.kind);
    let (sector, steps) = sector(&plan.camera);
    let uniform = gpu.buffer("layer", bytemuck::bytes_of(&layer.layer), wgpu::BufferUsages::STORAGE);
    let sector = gpu.buffer("sector", bytemuck::bytes_of(&sector), wgpu::BufferUsages::STORAGE);
    let volume = |i: usize| wgpu::BindingResource::TextureView(volumes.get(i).unwrap_or(&volumes[0]));
    let group = group(
        gpu,
        &pipelines.deck_layout,
        &[
            uniform.as_entire_binding(),
            sector.as_entire_binding(),
            volume(0),
            volume(1),
            volume(2),
            wgpu::BindingResource::TextureView(&bounds),
            wgpu::BindingResource::TextureView(&resident.detail),
            wgpu::BindingResource::Sampler(&resident.tiled),
        ],
    );
    let variant = DeckVariant {
        several_charts: layer.layer.charts > 1,
        regions: layer.layer.regions > 0,
        flashes: layer.layer.flashes > 0,
    };
    let instances = gpu.buffer("instances", instances, wgpu::BufferUsages::VERTEX);
    Deck { variant, group, instances, vertices: 2 * (steps + 1) }
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
                batch.push(Draw { deck: draw.deck, instances: rest.start..end });
            }
            rest.start = end;
        }
    }
    batches
}

/// Records passes into one target.
struct Recorder<'a> {
    gpu: &'a Gpu,
    target: &'a Target,
}

impl Recorder<'_> {
    /// A pass into the deck's targets, or into its depth alone.
    fn deck_pass<'e>(&self, encoder: &'e mut wgpu::CommandEncoder, light: bool, clear: bool) -> wgpu::RenderPass<'e> {
        let attachments = [Some(attachment(&self.target.deck_view, clear))];
        let depth_load = if clear { wgpu::LoadOp::Clear(1.0) } else { wgpu::LoadOp::Load };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("deck"),
            color_attachments: &attachments[..usize::from(light)],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.target.depth_view,
                depth_ops: Some(wgpu::Operations { load: depth_load, store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        })
    }

    fn deck(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pipelines: &mut Pipelines,
        frame: &wgpu::BindGroup,
        decks: &[Deck],
        batch: &[Draw],
        first: bool,
    ) {
        let mut pass = self.deck_pass(encoder, true, first);
        pass.set_bind_group(0, frame, &[]);
        for draw in batch {
            let deck = &decks[draw.deck];
            pass.set_pipeline(pipelines.deck(self.gpu, deck.variant));
            pass.set_bind_group(1, &deck.group, &[]);
            pass.set_vertex_buffer(0, deck.instances.slice(..));
            pass.draw(0..deck.vertices, draw.instances.clone());
        }
    }

    fn cull(&self, encoder: &mut wgpu::CommandEncoder, pipelines: &Pipelines) {
        let gathered = wgpu::BindingResource::TextureView(&self.target.deck_view);
        let group = group(self.gpu, &pipelines.image_layout, &[gathered]);
        let mut pass = self.deck_pass(encoder, false, false);
        pass.set_pipeline(&pipelines.cull);
        pass.set_bind_group(1, &group, &[]);
        pass.draw(0..3, 0..1);
    }

    fn behind(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pipelines: &Pipelines,
        frame: &wgpu::BindGroup,
        plan: &FramePlan,
    ) {
        let ground = plan.ground.as_ref().map(|ground| {
            let uniform = self.gpu.buffer("ground", bytemuck::bytes_of(ground), wgpu::BufferUsages::STORAGE);
            group(self.gpu, &pipelines.ground_layout, &[uniform.as_entire_binding()])
        });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("behind"),
            color_attachments: &[Some(attachment(&self.target.light_view, true))],
            ..Default::default()
        });
        pass.set_bind_group(0, frame, &[]);
        if let Some(ground) = &ground {
            pass.set_pipeline(&pipelines.ground);
            pass.set_bind_group(1, ground, &[]);
            pass.draw(0..3, 0..1);
        }
        pass.set_pipeline(&pipelines.sky);
        pass.draw(0..3, 0..1);
    }

    fn tonemap(&self, encoder: &mut wgpu::CommandEncoder, pipelines: &Pipelines) {
        let light = wgpu::BindingResource::TextureView(&self.target.light_view);
        let group = group(self.gpu, &pipelines.image_layout, &[light]);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("tonemap"),
            color_attachments: &[Some(attachment(&self.target.picture_view, true))],
            ..Default::default()
        });
        pass.set_pipeline(&pipelines.tonemap);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
    }
}

fn attachment(view: &wgpu::TextureView, clear: bool) -> wgpu::RenderPassColorAttachment<'_> {
    let load = if clear { wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT) } else { wgpu::LoadOp::Load };
    wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
    }
}
