//! The light pass on the device: one dispatch a slice, down and then up.

use super::device::Gpu;
use super::pipelines::Pipelines;
use super::textures::empty;
use crate::clouds::density::{HEIGHT, WIDTH};
use crate::passes::light::Light;

/// Format of a light volume (8 MiB each): square roots of shares, which 8 bits hold to 0.8 % at full light.
pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Bytes between two slices' numbers in their buffer (the least offset that WebGPU guarantees).
const STRIDE: u64 = 256;

/// Buffers that every light volume is computed with.
pub struct Scratch {
    above: wgpu::Buffer,
    below: wgpu::Buffer,
    slices: wgpu::Buffer,
}

impl Scratch {
    /// 17 MiB.
    pub fn new(gpu: &Gpu) -> Self {
        let storage = |label, slices: usize| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: (slices * WIDTH * WIDTH * 8) as u64,
                usage: wgpu::BufferUsages::STORAGE,
                mapped_at_creation: false,
            })
        };
        let mut numbers = vec![0u8; HEIGHT * STRIDE as usize];
        for z in 0..HEIGHT {
            numbers[z * STRIDE as usize..][..4].copy_from_slice(&(z as u32).to_le_bytes());
        }
        Self {
            above: storage("depths above", HEIGHT),
            below: storage("depths below", 2),
            slices: gpu.buffer("slice numbers", &numbers, wgpu::BufferUsages::STORAGE),
        }
    }
}

/// Computes the light volume of a shape and submits it.
pub fn compute(
    gpu: &Gpu,
    pipelines: &Pipelines,
    scratch: &Scratch,
    shape: &wgpu::TextureView,
    params: &Light,
) -> wgpu::TextureView {
    use wgpu::TextureUsages as Usage;
    let size = [WIDTH as u32, WIDTH as u32, HEIGHT as u32];
    let usage = Usage::STORAGE_BINDING | Usage::TEXTURE_BINDING | Usage::COPY_SRC;
    let volume = empty(gpu, "light volume", FORMAT, size, usage);
    let view = volume.create_view(&wgpu::TextureViewDescriptor::default());
    let parameters = gpu.buffer("light", bytemuck::bytes_of(params), wgpu::BufferUsages::STORAGE);
    let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
    let slice = wgpu::BufferBinding { buffer: &scratch.slices, offset: 0, size: wgpu::BufferSize::new(16) };
    let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("light"),
        layout: &pipelines.light_layout,
        entries: &[
            entry(0, parameters.as_entire_binding()),
            entry(1, wgpu::BindingResource::Buffer(slice)),
            entry(2, wgpu::BindingResource::TextureView(shape)),
            entry(3, scratch.above.as_entire_binding()),
            entry(4, scratch.below.as_entire_binding()),
            entry(5, wgpu::BindingResource::TextureView(&view)),
        ],
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        let groups = WIDTH as u32 / 16;
        let slices = 0..HEIGHT as u32;
        let mut run = |pipeline, z: u32| {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &group, &[z * STRIDE as u32]);
            pass.dispatch_workgroups(groups, groups, 1);
        };
        slices.clone().rev().for_each(|z| run(&pipelines.light_down, z));
        slices.for_each(|z| run(&pipelines.light_up, z));
    }
    gpu.queue.submit([encoder.finish()]);
    view
}
