//! The relief on the device: grids of heights around the eye, and the pass that finds each pixel's range to the ground.

use super::device::Gpu;
use super::frame::{attachment, group};
use super::pipelines::Pipelines;
use super::targets::Target;
use crate::passes::ground::lights::tile;
use crate::passes::relief::Relief;
use crate::passes::relief::window::{Tiles, Window, highest_m};
use crate::plan::ReliefPlan;
use crate::plan::executor::Unused;

/// Format of the ranges, in metres.
pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// Grids that stay between frames.
#[derive(Default)]
pub struct Grids {
    tiles: Tiles,
    unused: Unused,
    kept: Option<(Window, wgpu::Buffer, f32)>,
    light_tiles: Tiles,
    lights: Option<(Window, wgpu::Buffer)>,
}

impl Grids {
    /// What the passes read of a plan's relief; where there is none, a single node that no shader asks for.
    pub fn group(&mut self, gpu: &Gpu, pipelines: &Pipelines, plan: Option<&ReliefPlan>) -> wgpu::BindGroup {
        let storage = wgpu::BufferUsages::STORAGE;
        if self.unused.is_due(plan.is_some()) {
            self.tiles = Tiles::default();
        }
        let Some(plan) = plan else {
            (self.kept, self.lights, self.light_tiles) = (None, None, Tiles::default());
            let [relief, node] = [size_of::<Relief>(), 4].map(|size| gpu.buffer("no relief", &vec![0; size], storage));
            let resources = [relief.as_entire_binding(), node.as_entire_binding(), node.as_entire_binding()];
            return group(gpu, &pipelines.relief_layout, &resources);
        };
        if self.kept.as_ref().is_none_or(|(window, ..)| *window != plan.window) {
            let nodes = self.tiles.nodes(&plan.window);
            let buffer = gpu.buffer("nodes", bytemuck::cast_slice(&nodes), storage);
            self.kept = Some((plan.window.clone(), buffer, highest_m(&nodes)));
        }
        if !plan.lights {
            (self.lights, self.light_tiles) = (None, Tiles::default());
        } else if self.lights.as_ref().is_none_or(|(window, _)| *window != plan.window) {
            let lights = self.light_tiles.filled(&plan.window, tile);
            self.lights = Some((plan.window.clone(), gpu.buffer("lights", bytemuck::cast_slice(&lights), storage)));
        }
        let dark = gpu.buffer("no lights", &[0; 4], storage);
        let lights = self.lights.as_ref().map_or(&dark, |(_, lights)| lights);
        let (_, nodes, highest_m) = self.kept.as_ref().expect("just made");
        let relief = Relief { highest_m: *highest_m, ..plan.relief };
        let relief = gpu.buffer("relief", bytemuck::bytes_of(&relief), storage);
        group(
            gpu,
            &pipelines.relief_layout,
            &[relief.as_entire_binding(), nodes.as_entire_binding(), lights.as_entire_binding()],
        )
    }
}

/// Records the pass into its target, where a plan has one.
pub fn record(
    pipelines: &Pipelines,
    encoder: &mut wgpu::CommandEncoder,
    target: &Target,
    frame: &wgpu::BindGroup,
    grids: &wgpu::BindGroup,
) {
    let Some(image) = &target.relief else { return };
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("relief"),
        color_attachments: &[Some(attachment(image, true))],
        ..Default::default()
    });
    pass.set_pipeline(&pipelines.relief);
    pass.set_bind_group(0, frame, &[]);
    pass.set_bind_group(2, grids, &[]);
    pass.draw(0..3, 0..1);
}
