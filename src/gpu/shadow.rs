//! The shadows on the device: each layer that casts one multiplies an image of what reaches the ground, or a lower layer.

use super::deck::Scene;
use super::device::Gpu;
use super::frame::{attachment, group};
use super::pipelines::Pipelines;
use super::resident::{Resident, VOLUMES_KEPT};
use crate::clouds::density::WIDTH;
use crate::passes::shadow::table::{LAYERS, Table};
use crate::plan::{FramePlan, LayerPlan, LayerShadow};

/// Format of the image: a share from 0 to 1, which f16 holds to 0.05 %.
pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R16Float;

/// For each layer that casts a shadow on the ground, what its draw reads beside the layer itself.
pub fn casters(gpu: &Gpu, pipelines: &Pipelines, resident: &mut Resident, plan: &FramePlan) -> Vec<wgpu::BindGroup> {
    let casters = plan.shadow.as_ref().map_or(&[][..], |shadow| &shadow.casters);
    casters.iter().map(|caster| bound(gpu, pipelines, resident, plan, caster)).collect()
}

fn bound(
    gpu: &Gpu,
    pipelines: &Pipelines,
    resident: &mut Resident,
    plan: &FramePlan,
    caster: &LayerShadow,
) -> wgpu::BindGroup {
    // Fewer than one picture needs would be made anew for each picture.
    let most = plan.tables().max(VOLUMES_KEPT);
    let kind = plan.layers[caster.layer].kind;
    let tables: Vec<_> = caster.columns.iter().map(|c| resident.columns(gpu, kind, c, most)).collect();
    let parameters = gpu.buffer("shadow", bytemuck::bytes_of(&caster.shadow), wgpu::BufferUsages::STORAGE);
    let table = |i: usize| wgpu::BindingResource::TextureView(tables.get(i).unwrap_or(&tables[0]));
    let sampler = wgpu::BindingResource::Sampler(&resident.levels);
    let resources = [parameters.as_entire_binding(), table(0), table(1), table(2), sampler];
    group(gpu, &pipelines.shadow_layout, &resources)
}

/// For each layer the map of the shade on it, to be drawn, where higher ones shade it.
pub fn shades(gpu: &Gpu, resident: &mut Resident, plan: &FramePlan) -> Vec<Option<wgpu::TextureView>> {
    let one = |(i, layer): (usize, &LayerPlan)| (!layer.shade.is_empty()).then(|| resident.shade(gpu, i));
    plan.layers.iter().enumerate().map(one).collect()
}

/// Records the maps of shade.
pub fn record_shades(
    gpu: &Gpu,
    pipelines: &mut Pipelines,
    resident: &mut Resident,
    encoder: &mut wgpu::CommandEncoder,
    scene: &Scene,
    shades: &[Option<wgpu::TextureView>],
) {
    for (layer, image) in scene.plan.layers.iter().zip(shades) {
        let Some(image) = image else { continue };
        let groups: Vec<_> = layer.shade.iter().map(|c| bound(gpu, pipelines, resident, scene.plan, c)).collect();
        draw(gpu, pipelines, encoder, scene, image, (&layer.shade, &groups), true);
    }
}

/// Records the shadows. The scene's frame has a camera of their scale and the deck where it hides ground.
pub fn record(
    gpu: &Gpu,
    pipelines: &mut Pipelines,
    encoder: &mut wgpu::CommandEncoder,
    scene: &Scene,
    casters: &[wgpu::BindGroup],
) {
    let (Some(shadow), Some(image)) = (&scene.plan.shadow, &scene.target.shadow) else { return };
    draw(gpu, pipelines, encoder, scene, image, (&shadow.casters, casters), false);
}

/// Draws what layers let through into an image, each multiplying what the others have left.
fn draw(
    gpu: &Gpu,
    pipelines: &mut Pipelines,
    encoder: &mut wgpu::CommandEncoder,
    scene: &Scene,
    image: &wgpu::TextureView,
    (casters, groups): (&[LayerShadow], &[wgpu::BindGroup]),
    on_layer: bool,
) {
    let untouched = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::WHITE), store: wgpu::StoreOp::Store };
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("shadow"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment { ops: untouched, ..attachment(image, true) })],
        ..Default::default()
    });
    pass.set_bind_group(0, scene.frame, &[]);
    for (caster, group) in casters.iter().zip(groups) {
        let deck = &scene.decks[caster.layer];
        pass.set_pipeline(match on_layer {
            true => pipelines.shade(gpu, deck.variant),
            false => pipelines.shadow(gpu, deck.variant),
        });
        pass.set_bind_group(1, &deck.group, &[]);
        pass.set_bind_group(2, group, &[]);
        pass.draw(0..3, 0..1);
    }
}

/// A table as a texture: `LAYERS` layers of all its levels.
pub fn upload(gpu: &Gpu, table: &Table) -> wgpu::TextureView {
    let size = |width: usize| wgpu::Extent3d {
        width: width as u32,
        height: width as u32,
        depth_or_array_layers: LAYERS as u32,
    };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("shadow columns"),
        size: size(WIDTH),
        mip_level_count: table.levels.len() as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (level, texels) in table.levels.iter().enumerate() {
        let width = WIDTH >> level;
        let to = wgpu::TexelCopyTextureInfo { mip_level: level as u32, ..texture.as_image_copy() };
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(4 * width as u32),
            rows_per_image: Some(width as u32),
        };
        gpu.queue.write_texture(to, texels.as_flattened(), layout, size(width));
    }
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
