//! The layers of a plan on the device: parameters, volumes, and which variant of the shaders they need.

use super::device::Gpu;
use super::frame::group;
use super::pipelines::{DeckVariant, Pipelines};
use super::resident::{Resident, VOLUMES_KEPT};
use super::targets::Target;
use crate::plan::{FramePlan, LayerPlan};

/// One layer ready to be drawn.
pub struct Deck {
    /// What of the shaders it needs.
    pub variant: DeckVariant,
    /// Its parameters and textures.
    pub group: wgpu::BindGroup,
}

/// What both forms of the deck pass record from.
pub struct Scene<'a> {
    /// The plan.
    pub plan: &'a FramePlan,
    /// Camera, sky and tables.
    pub frame: &'a wgpu::BindGroup,
    /// Its layers.
    pub decks: &'a [Deck],
    /// What they are drawn into.
    pub target: &'a Target,
    /// A single texel that hides nothing: reads beyond it give nothing.
    pub nothing: &'a wgpu::TextureView,
}

/// The layers of a plan, in its order.
/// `shades`: for each the map of its shade, where higher layers shade it.
pub fn decks(
    gpu: &Gpu,
    pipelines: &Pipelines,
    resident: &mut Resident,
    plan: &FramePlan,
    shades: &[Option<wgpu::TextureView>],
) -> Vec<Deck> {
    // Fewer than one picture needs would be made anew for each picture.
    let most = plan.layers.iter().map(|layer| layer.light.len()).sum::<usize>().max(VOLUMES_KEPT);
    let glow = resident.glow(gpu, plan.glow.as_ref());
    let (lit, layers) = (!plan.lit.is_empty(), plan.layers.iter().zip(shades));
    let decks = layers.map(|(layer, shade)| {
        let mut deck = deck(gpu, pipelines, resident, (layer, shade.as_ref(), lit), &glow, most);
        (deck.variant.terrain, deck.variant.glow) = (plan.terrain(), plan.glow.is_some());
        deck
    });
    decks.collect()
}

fn deck(
    gpu: &Gpu,
    pipelines: &Pipelines,
    resident: &mut Resident,
    (layer, shade, lit): (&LayerPlan, Option<&wgpu::TextureView>, bool),
    glow: &(wgpu::Buffer, wgpu::TextureView),
    most_volumes: usize,
) -> Deck {
    let volumes: Vec<_> = layer.light.iter().map(|l| resident.volume(gpu, layer.kind, l, most_volumes)).collect();
    let shape = resident.shape(gpu, layer.kind);
    let parameters = gpu.buffer("layer", bytemuck::bytes_of(&layer.layer), wgpu::BufferUsages::STORAGE);
    let volume = |i: usize| wgpu::BindingResource::TextureView(volumes.get(i).unwrap_or(&volumes[0]));
    let group = group(
        gpu,
        &pipelines.deck_layout,
        &[
            parameters.as_entire_binding(),
            wgpu::BindingResource::TextureView(&shape.values),
            volume(0),
            volume(1),
            volume(2),
            wgpu::BindingResource::TextureView(&shape.bounds),
            wgpu::BindingResource::TextureView(&resident.detail),
            wgpu::BindingResource::Sampler(&resident.tiled),
            wgpu::BindingResource::TextureView(shade.unwrap_or(&resident.nothing)),
            glow.0.as_entire_binding(),
            wgpu::BindingResource::TextureView(&glow.1),
        ],
    );
    let variant = DeckVariant {
        several_charts: layer.layer.charts > 1,
        regions: layer.layer.regions > 0,
        clumps: layer.layer.varied > 0.0,
        leaps: !gpu.software,
        flashes: layer.layer.flashes > 0 || lit,
        light: layer.layer.encoding(),
        shaded: shade.is_some(),
        terrain: false,
        glow: false,
    };
    Deck { variant, group }
}
