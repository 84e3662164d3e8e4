//! The deck as one walk a pixel: a dispatch for each layer on the way down, then for each on the way up.

use super::deck::Scene;
use super::device::Gpu;
use super::frame::group;
use super::pipelines::Pipelines;
use crate::plan::FramePlan;

/// Pixels of a workgroup each way.
const GROUP: u32 = 8;

/// Records the deck and returns which of the target's two images it ends in: each dispatch reads one and writes the other.
pub fn record(gpu: &Gpu, pipelines: &mut Pipelines, encoder: &mut wgpu::CommandEncoder, scene: &Scene) -> usize {
    let Scene { plan, frame, decks, target, nothing } = *scene;
    let legs = legs(plan);
    let images = |leg: usize| {
        let before = if leg == 0 { nothing } else { &target.deck[(leg - 1) % 2] };
        let [before, after] = [before, &target.deck[leg % 2]].map(wgpu::BindingResource::TextureView);
        group(gpu, &pipelines.march_layout, &[before, after])
    };
    let groups: Vec<_> = (0..legs.len()).map(images).collect();
    let size = target.deck[0].texture().size();
    let mut pass =
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("deck"), ..Default::default() });
    pass.set_bind_group(0, frame, &[]);
    for (i, (layer, falling)) in legs.iter().enumerate() {
        let deck = &decks[*layer];
        pass.set_pipeline(pipelines.march(gpu, deck.variant, *falling));
        pass.set_bind_group(1, &deck.group, &[]);
        pass.set_bind_group(2, &groups[i], &[]);
        pass.dispatch_workgroups(size.width.div_ceil(GROUP), size.height.div_ceil(GROUP), 1);
    }
    (legs.len() + 1) % 2
}

/// Layers and whether on the way down, near to far along any ray: downwards the highest layer below the eye first;
/// upwards, also beyond the ray's lowest point, the lowest first.
fn legs(plan: &FramePlan) -> Vec<(usize, bool)> {
    let layers = plan.layers.iter().enumerate();
    let down = layers.clone().rev().filter(|(_, l)| l.layer.base_m < plan.camera.eye_m).map(|(i, _)| (i, true));
    down.chain(layers.map(|(i, _)| (i, false))).collect()
}
