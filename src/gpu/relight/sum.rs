//! Sums of tables as compute passes (`passes::relight::sum`): from coefficients straight into the texture that the deck reads.

use crate::gpu::device::Gpu;
use crate::gpu::frame::group;
use crate::gpu::pipelines;
use crate::passes::relight::sum::{SumHead, Summed};

/// The two passes; made when the first table is summed.
pub struct SumPasses {
    layout: wgpu::BindGroupLayout,
    sum: wgpu::ComputePipeline,
    store: wgpu::ComputePipeline,
}

impl SumPasses {
    /// Compiles them.
    pub fn new(gpu: &Gpu) -> Self {
        Self::from_source(gpu, pipelines::SUM)
    }

    /// The same from a given source, so that a test can break it.
    pub fn from_source(gpu: &Gpu, source: &str) -> Self {
        let stage = wgpu::ShaderStages::COMPUTE;
        let buffer = |read_only| wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let texture = wgpu::BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::WriteOnly,
            format: wgpu::TextureFormat::Rgba16Float,
            view_dimension: wgpu::TextureViewDimension::D3,
        };
        let kinds = std::iter::repeat_n(buffer(true), 6).chain([buffer(false), texture]);
        let entries: Vec<_> = kinds
            .enumerate()
            .map(|(i, ty)| wgpu::BindGroupLayoutEntry { binding: i as u32, visibility: stage, ty, count: None })
            .collect();
        let layout = gpu
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("sum"), entries: &entries });
        let pipeline_layout = crate::gpu::layouts::pipeline_layout(gpu, &[Some(&layout)]);
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("sum"),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let pipeline = |entry| {
            gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(entry),
                compilation_options: Default::default(),
                cache: None,
            })
        };
        let (sum, store) = (pipeline("sum"), pipeline("store"));
        Self { layout, sum, store }
    }

    /// Sums a field into the texture, from this level on.
    pub fn run(&self, gpu: &Gpu, summed: &Summed, texture: &wgpu::Texture, slot: u32) {
        use wgpu::BufferUsages as Usage;
        let read = |bytes: &[u8]| gpu.buffer("sum", bytes, Usage::STORAGE);
        let head = SumHead { slot, ..summed.head };
        let components = summed.shares.len();
        let fields = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("fields of a sum"),
            size: (4 * components * summed.in_air.len()) as u64,
            usage: Usage::STORAGE,
            mapped_at_creation: false,
        });
        let lists = [
            read(bytemuck::bytes_of(&head)),
            read(bytemuck::cast_slice(&summed.parts)),
            read(bytemuck::cast_slice(&summed.places)),
            read(bytemuck::cast_slice(&summed.values)),
            read(bytemuck::cast_slice(&summed.shares)),
            read(bytemuck::cast_slice(&summed.in_air)),
            fields,
        ];
        let view = texture.create_view(&Default::default());
        let mut resources: Vec<_> = lists.iter().map(|list| list.as_entire_binding()).collect();
        resources.push(wgpu::BindingResource::TextureView(&view));
        let group = group(gpu, &self.layout, &resources);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_bind_group(0, &group, &[]);
        pass.set_pipeline(&self.sum);
        pass.dispatch_workgroups(components as u32, 1, 1);
        pass.set_pipeline(&self.store);
        let [x, y, z] = summed.head.cells.map(|n| n.div_ceil(4));
        pass.dispatch_workgroups(x, y, z);
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
    }
}

#[cfg(test)]
mod tests;
