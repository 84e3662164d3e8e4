//! The deck as one walk a pixel: a dispatch for each leg, near to far, or for both of a layer where one follows the other.

use super::deck::Scene;
use super::device::Gpu;
use super::frame::group;
use super::pipelines::{Pipelines, Ways};
use crate::passes::deck::spans::Leg;

/// Pixels of a workgroup each way.
const GROUP: u32 = 8;
/// The shader takes rows of workgroups in this many turns.
const TURNS: u32 = 8;

/// Records the deck and returns which of the target's two images it ends in: each dispatch reads one and writes the other.
pub fn record(gpu: &Gpu, pipelines: &mut Pipelines, encoder: &mut wgpu::CommandEncoder, scene: &Scene) -> usize {
    let Scene { plan, frame, decks, target, nothing } = *scene;
    let walks = walks(&plan.legs());
    let images = |walk: usize| {
        let before = if walk == 0 { nothing } else { &target.deck[(walk - 1) % 2] };
        let [before, after] = [before, &target.deck[walk % 2]].map(wgpu::BindingResource::TextureView);
        let heights = bytemuck::bytes_of(&walks[walk].0.heights);
        let heights = gpu.buffer("heights", heights, wgpu::BufferUsages::STORAGE);
        group(gpu, &pipelines.march_layout, &[before, after, heights.as_entire_binding()])
    };
    let groups: Vec<_> = (0..walks.len()).map(images).collect();
    let size = target.deck[0].texture().size();
    let mut pass =
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("deck"), ..Default::default() });
    pass.set_bind_group(0, frame, &[]);
    for ((leg, ways), images) in walks.iter().zip(&groups) {
        let deck = &decks[leg.layer];
        pass.set_pipeline(pipelines.march(gpu, deck.variant, *ways));
        pass.set_bind_group(1, &deck.group, &[]);
        pass.set_bind_group(2, images, &[]);
        pass.dispatch_workgroups(size.width.div_ceil(GROUP), size.height.div_ceil(GROUP).next_multiple_of(TURNS), 1);
    }
    (walks.len() + 1) % 2
}

/// Legs with the ways that one dispatch walks. Where a layer's way up follows its own way down, one does both: each pixel of each
/// dispatch costs something, also where it meets nothing.
fn walks(legs: &[Leg]) -> Vec<(Leg, Ways)> {
    let mut walks: Vec<(Leg, Ways)> = Vec::new();
    for leg in legs {
        match walks.last_mut() {
            Some((before, ways))
                if !leg.falling && !ways.rising && before.layer == leg.layer && before.heights == leg.heights =>
            {
                ways.rising = true;
            }
            _ => walks.push((*leg, Ways { falling: leg.falling, rising: !leg.falling })),
        }
    }
    walks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::passes::deck::spans::legs;

    #[test]
    fn a_layers_ways_down_and_up_are_one_walk_where_one_follows_the_other() {
        let told = |layers: &[[f32; 2]], eye_m: f32| -> Vec<(usize, bool, bool)> {
            walks(&legs(layers, eye_m)).iter().map(|(leg, ways)| (leg.layer, ways.falling, ways.rising)).collect()
        };
        let layers = [[1000.0, 2000.0], [3000.0, 3500.0]];
        assert_eq!(told(&layers, 500.0), [(0, false, true), (1, false, true)]);
        assert_eq!(told(&layers, 9000.0), [(1, true, false), (0, true, true), (1, false, true)]);
        // Of layers that share heights only the lowest span is met twice in a row.
        let walks = told(&[[900.0, 9_000.0], [1200.0, 1700.0]], 9_500.0);
        assert_eq!(walks.iter().filter(|(_, falling, rising)| *falling && *rising).count(), 1, "{walks:?}");
    }
}
