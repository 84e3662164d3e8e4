//! Lightning's own passes on the device: what the clouds hide, the channels, light scattered in the air, glow.

use super::deck::Deck;
use super::device::Gpu;
use super::frame::{attachment, group};
use super::pipelines::Pipelines;
use super::targets::StrokeImages;
use crate::passes::glow::Glow;
use crate::plan::StrokePlan;

/// Invocations of a workgroup of the veil.
const GROUP: u32 = 64;

/// What the passes record from.
pub struct Scene<'a> {
    /// The channels.
    pub strokes: &'a StrokePlan,
    /// Factor from cd/m2 to exposed light.
    pub exposure: f32,
    /// Camera, sky and tables at the size of the picture.
    pub frame: &'a wgpu::BindGroup,
    /// The same at the size of the air's light.
    pub coarse: &'a wgpu::BindGroup,
    /// The layers of cloud in sight.
    pub decks: &'a [Deck],
    /// What is drawn into.
    pub images: &'a StrokeImages,
    /// The picture's light, which the strokes' is added to.
    pub light: &'a wgpu::TextureView,
    /// A single texel of nothing.
    pub nothing: &'a wgpu::TextureView,
}

/// Records all of them, each reading what the one before has written.
pub fn record(gpu: &Gpu, pipelines: &mut Pipelines, encoder: &mut wgpu::CommandEncoder, scene: &Scene) {
    let nodes = gpu.buffer("nodes", bytemuck::cast_slice(&scene.strokes.nodes), wgpu::BufferUsages::STORAGE);
    veil(gpu, pipelines, encoder, scene, &nodes);
    let (images, strokes) = (scene.images, scene.strokes);
    let bound = |parameters: &[u8], list: &[u8]| {
        let [parameters, list] =
            [parameters, list].map(|bytes| gpu.buffer("strokes", bytes, wgpu::BufferUsages::STORAGE));
        let resources = [parameters.as_entire_binding(), list.as_entire_binding(), nodes.as_entire_binding()];
        group(gpu, &pipelines.strokes_layout, &resources)
    };
    let channels = (!strokes.segments.is_empty())
        .then(|| bound(bytemuck::bytes_of(&strokes.strokes), bytemuck::cast_slice(&strokes.segments)));
    {
        let mut pass = begin(encoder, "strokes", &images.levels[0], true);
        if let Some(channels) = &channels {
            pass.set_pipeline(&pipelines.stroke);
            pass.set_bind_group(0, scene.frame, &[]);
            pass.set_bind_group(1, channels, &[]);
            pass.draw(0..6, 0..strokes.segments.len() as u32);
        }
    }
    let lights = (!strokes.sources.is_empty())
        .then(|| bound(bytemuck::bytes_of(&strokes.airlight), bytemuck::cast_slice(&strokes.sources)));
    {
        let mut pass = begin(encoder, "airlight", &images.air, true);
        if let Some(lights) = &lights {
            pass.set_pipeline(&pipelines.airlight);
            pass.set_bind_group(0, scene.coarse, &[]);
            pass.set_bind_group(1, lights, &[]);
            pass.draw(0..3, 0..1);
        }
    }
    glow(gpu, pipelines, encoder, scene);
}

/// What comes through the clouds from each node: a dispatch for each layer, one after the other.
fn veil(gpu: &Gpu, pipelines: &mut Pipelines, encoder: &mut wgpu::CommandEncoder, scene: &Scene, nodes: &wgpu::Buffer) {
    if scene.decks.is_empty() || scene.strokes.nodes.is_empty() {
        return;
    }
    let bound = group(gpu, &pipelines.nodes_layout, &[nodes.as_entire_binding()]);
    let mut pass =
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("veil"), ..Default::default() });
    pass.set_bind_group(0, scene.frame, &[]);
    pass.set_bind_group(2, &bound, &[]);
    for deck in scene.decks {
        pass.set_pipeline(pipelines.veil(gpu, deck.variant));
        pass.set_bind_group(1, &deck.group, &[]);
        pass.dispatch_workgroups((scene.strokes.nodes.len() as u32).div_ceil(GROUP), 1, 1);
    }
}

/// Down the levels, up again, and into the picture.
fn glow(gpu: &Gpu, pipelines: &Pipelines, encoder: &mut wgpu::CommandEncoder, scene: &Scene) {
    let Scene { strokes, images, nothing, .. } = *scene;
    let last = strokes.glow.len() - 1;
    let bound = |parameters: Glow, textures: [&wgpu::TextureView; 3]| {
        let parameters = gpu.buffer("glow", bytemuck::bytes_of(&parameters), wgpu::BufferUsages::STORAGE);
        let [fine, coarse, air] = textures.map(wgpu::BindingResource::TextureView);
        group(gpu, &pipelines.glow_layout, &[parameters.as_entire_binding(), fine, coarse, air])
    };
    let mut step = |pipeline, into, clear, group: wgpu::BindGroup| {
        let mut pass = begin(encoder, "glow", into, clear);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
    };
    let plain = |weight| Glow { weight, gain: 1.0, air_gain: 0.0, pad: 0.0 };
    for level in 1..=last {
        let group = bound(plain(1.0), [&images.levels[level - 1], nothing, nothing]);
        step(&pipelines.glow_down, &images.levels[level], true, group);
    }
    for level in (1..=last).rev() {
        let coarse = images.gathered.get(level).unwrap_or(nothing);
        let group = bound(plain(strokes.glow[level]), [&images.levels[level], coarse, nothing]);
        step(&pipelines.glow_up, &images.gathered[level - 1], true, group);
    }
    let parameters = Glow {
        weight: strokes.glow[0],
        gain: scene.exposure / strokes.strokes.scale,
        air_gain: scene.exposure / strokes.airlight.scale,
        pad: 0.0,
    };
    let coarse = images.gathered.first().unwrap_or(nothing);
    let group = bound(parameters, [&images.levels[0], coarse, &images.air]);
    step(&pipelines.glow_last, scene.light, false, group);
}

fn begin<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    label: &str,
    view: &wgpu::TextureView,
    clear: bool,
) -> wgpu::RenderPass<'e> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: &[Some(attachment(view, clear))],
        ..Default::default()
    })
}
