//! The deck as one walk a pixel: a dispatch for each leg, near to far.

use super::deck::Scene;
use super::device::Gpu;
use super::frame::group;
use super::pipelines::Pipelines;

/// Pixels of a workgroup each way.
const GROUP: u32 = 8;
/// The shader takes rows of workgroups in this many turns.
const TURNS: u32 = 8;

/// Records the deck and returns which of the target's two images it ends in: each dispatch reads one and writes the other.
pub fn record(gpu: &Gpu, pipelines: &mut Pipelines, encoder: &mut wgpu::CommandEncoder, scene: &Scene) -> usize {
    let Scene { plan, frame, decks, target, nothing } = *scene;
    let legs = plan.legs();
    let images = |leg: usize| {
        let before = if leg == 0 { nothing } else { &target.deck[(leg - 1) % 2] };
        let [before, after] = [before, &target.deck[leg % 2]].map(wgpu::BindingResource::TextureView);
        let heights = bytemuck::bytes_of(&legs[leg].heights);
        let heights = gpu.buffer("heights", heights, wgpu::BufferUsages::STORAGE);
        group(gpu, &pipelines.march_layout, &[before, after, heights.as_entire_binding()])
    };
    let groups: Vec<_> = (0..legs.len()).map(images).collect();
    let size = target.deck[0].texture().size();
    let mut pass =
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("deck"), ..Default::default() });
    pass.set_bind_group(0, frame, &[]);
    for (leg, images) in legs.iter().zip(&groups) {
        let deck = &decks[leg.layer];
        pass.set_pipeline(pipelines.march(gpu, deck.variant, leg.falling));
        pass.set_bind_group(1, &deck.group, &[]);
        pass.set_bind_group(2, images, &[]);
        pass.dispatch_workgroups(size.width.div_ceil(GROUP), size.height.div_ceil(GROUP).next_multiple_of(TURNS), 1);
    }
    (legs.len() + 1) % 2
}
