//! One frame: from a plan to commands.

use super::GpuExecutor;
use super::deck::{Scene, decks};
use super::device::Gpu;
use super::pipelines::{GroundVariant, Pipelines};
use super::relight::Bound;
use super::resident::Resident;
use super::ring::Content;
use super::targets::Target;
use super::{instanced, march, relief, shadow, strokes};
use crate::passes::common::Camera;
use crate::plan::{FramePlan, Output};
use crate::world::snapshot::DeckForm;

/// Records and submits a plan, and enters its picture into the ring.
pub fn submit(executor: &mut GpuExecutor, ticket: u64, plan: &FramePlan) {
    let GpuExecutor { gpu, pipelines, resident, targets, ring } = executor;
    let lit = resident.fields.bind(gpu, plan);
    let shades = shadow::shades(gpu, resident, plan);
    let decks = decks(gpu, pipelines, resident, plan, &shades);
    let target = targets.of(gpu, plan);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let nothing = resident.nothing.clone();
    resident.clouds(!plan.layers.is_empty());
    let grids = resident.grids.group(gpu, pipelines, plan.relief.as_ref());
    if plan.terrain() {
        let blank = Behind { deck: &nothing, relief: &nothing };
        let frame = frame_group(gpu, pipelines, resident, (plan, &lit), &plan.camera, blank);
        relief::record(pipelines, &mut encoder, target, &frame, &grids);
    }
    let ranges = target.relief.as_ref().unwrap_or(&nothing);
    let mut deck = &nothing;
    if !decks.is_empty() {
        let frame = frame_group(
            gpu,
            pipelines,
            resident,
            (plan, &lit),
            &plan.camera.coarser(plan.deck_scale),
            Behind { deck: &nothing, relief: ranges },
        );
        let scene = Scene { plan, frame: &frame, decks: &decks, target, nothing: &nothing };
        shadow::record_shades(gpu, pipelines, resident, &mut encoder, &scene, &shades);
        let image = match plan.deck_form {
            DeckForm::Instanced => {
                instanced::record(gpu, pipelines, &mut encoder, &scene);
                0
            }
            DeckForm::Auto | DeckForm::Marched => march::record(gpu, pipelines, &mut encoder, &scene),
        };
        deck = &target.deck[image];
    }
    if let Some(shadows) = &plan.shadow {
        // What the deck hides is read by its neighbours where a texel is larger than a pixel.
        let hiding = if shadows.scale == 1 { deck } else { &nothing };
        let frame = frame_group(
            gpu,
            pipelines,
            resident,
            (plan, &lit),
            &plan.camera.coarser(shadows.scale),
            Behind { deck: hiding, relief: ranges },
        );
        let scene = Scene { plan, frame: &frame, decks: &decks, target, nothing: &nothing };
        let casters = shadow::casters(gpu, pipelines, resident, plan);
        shadow::record(gpu, pipelines, &mut encoder, &scene, &casters);
    }
    let stars = resident.stars(gpu, pipelines, plan.stars.as_ref());
    let recorder = Recorder { gpu, target, nothing: &nothing, grids: &grids, stars: &stars };
    let frame = frame_group(gpu, pipelines, resident, (plan, &lit), &plan.camera, Behind { deck, relief: ranges });
    recorder.behind(&mut encoder, pipelines, &frame, plan);
    if let (Some(planned), Some(images)) = (&plan.strokes, &target.strokes) {
        let camera = plan.camera.coarser(planned.air_scale);
        let behind = Behind { deck: &nothing, relief: ranges };
        let coarse = frame_group(gpu, pipelines, resident, (plan, &lit), &camera, behind);
        let scene = strokes::Scene {
            strokes: planned,
            exposure: plan.camera.exposure,
            frame: &frame,
            coarse: &coarse,
            decks: &decks,
            images,
            light: &target.light_view,
            nothing: &nothing,
        };
        strokes::record(gpu, pipelines, &mut encoder, &scene);
    }
    let (texture, content) = match plan.output {
        Output::Srgb8 => {
            recorder.tonemap(&mut encoder, pipelines);
            (&target.picture, Content::Srgb8)
        }
        Output::LinearRgb => (&target.light, Content::Light { exposure: plan.camera.exposure }),
    };
    let copied = ring.copy(gpu, &mut encoder, texture, plan.size_px);
    let submission = gpu.queue.submit([encoder.finish()]);
    ring.enter(ticket, plan.size_px, (content, lit.provisional), copied, submission);
}

/// Images that a frame's passes read of one another.
struct Behind<'a> {
    deck: &'a wgpu::TextureView,
    relief: &'a wgpu::TextureView,
}

fn frame_group(
    gpu: &Gpu,
    pipelines: &Pipelines,
    resident: &mut Resident,
    (plan, lit): (&FramePlan, &Bound),
    camera: &Camera,
    images: Behind,
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
            wgpu::BindingResource::TextureView(images.deck),
            wgpu::BindingResource::TextureView(images.relief),
            lit.lits.as_entire_binding(),
            wgpu::BindingResource::TextureView(&lit.quotients),
        ],
    )
}

/// A bind group of these resources, bound from 0.
pub fn group(gpu: &Gpu, layout: &wgpu::BindGroupLayout, resources: &[wgpu::BindingResource]) -> wgpu::BindGroup {
    let entries: Vec<_> = resources
        .iter()
        .enumerate()
        .map(|(i, resource)| wgpu::BindGroupEntry { binding: i as u32, resource: resource.clone() })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

/// Records passes into one target.
struct Recorder<'a> {
    gpu: &'a Gpu,
    target: &'a Target,
    nothing: &'a wgpu::TextureView,
    grids: &'a wgpu::BindGroup,
    stars: &'a wgpu::BindGroup,
}

impl Recorder<'_> {
    fn behind(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pipelines: &mut Pipelines,
        frame: &wgpu::BindGroup,
        plan: &FramePlan,
    ) {
        let ground = plan.ground.as_ref().map(|ground| {
            let parameters = self.gpu.buffer("ground", bytemuck::bytes_of(ground), wgpu::BufferUsages::STORAGE);
            let shadow = self.target.shadow.as_ref().unwrap_or(self.nothing);
            let resources = [parameters.as_entire_binding(), wgpu::BindingResource::TextureView(shadow)];
            (GroundVariant::of(ground, plan), group(self.gpu, &pipelines.ground_layout, &resources))
        });
        let beams = plan.beams.as_ref().map(|beams| {
            let parameters = self.gpu.buffer("beams", bytemuck::bytes_of(beams), wgpu::BufferUsages::STORAGE);
            group(self.gpu, &pipelines.mesh_layout, &[parameters.as_entire_binding()])
        });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("behind"),
            color_attachments: &[Some(attachment(&self.target.light_view, true))],
            ..Default::default()
        });
        pass.set_bind_group(0, frame, &[]);
        if let Some((variant, ground)) = &ground {
            pass.set_pipeline(pipelines.ground(self.gpu, *variant));
            pass.set_bind_group(1, ground, &[]);
            pass.set_bind_group(2, self.grids, &[]);
            pass.draw(0..3, 0..1);
        }
        pass.set_pipeline(pipelines.sky(self.gpu, plan.terrain(), plan.stars.is_some()));
        pass.set_bind_group(1, self.stars, &[]);
        pass.draw(0..3, 0..1);
        if let Some(beams) = &beams {
            pass.set_pipeline(pipelines.beams(self.gpu, plan.terrain()));
            pass.set_bind_group(1, beams, &[]);
            pass.draw(0..3, 0..1);
        }
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

/// A colour attachment, cleared to nothing or kept.
pub fn attachment(view: &wgpu::TextureView, clear: bool) -> wgpu::RenderPassColorAttachment<'_> {
    let load = if clear { wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT) } else { wgpu::LoadOp::Load };
    wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
    }
}
