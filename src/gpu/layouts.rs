//! The layouts of the bind groups that the pipelines read.

use super::device::Gpu;

/// One layout a kind of bind group.
pub struct Layouts {
    pub frame: wgpu::BindGroupLayout,
    pub deck: wgpu::BindGroupLayout,
    pub mesh: wgpu::BindGroupLayout,
    pub ground: wgpu::BindGroupLayout,
    pub relief: wgpu::BindGroupLayout,
    pub stars: wgpu::BindGroupLayout,
    pub shadow: wgpu::BindGroupLayout,
    pub image: wgpu::BindGroupLayout,
    pub march: wgpu::BindGroupLayout,
    pub nodes: wgpu::BindGroupLayout,
    pub strokes: wgpu::BindGroupLayout,
    pub glow: wgpu::BindGroupLayout,
}

impl Layouts {
    /// All of them.
    pub fn new(gpu: &Gpu) -> Self {
        use wgpu::TextureViewDimension::{D2, D2Array, D3};
        let layout = |label: &str, stages: wgpu::ShaderStages, kinds: &[wgpu::BindingType]| {
            let entries: Vec<_> = kinds
                .iter()
                .enumerate()
                .map(|(i, ty)| wgpu::BindGroupLayoutEntry {
                    binding: i as u32,
                    visibility: stages,
                    ty: *ty,
                    count: None,
                })
                .collect();
            gpu.device
                .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
        };
        let buffer =
            |ty, has_dynamic_offset| wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None };
        // Parameters stand in read-only storage, not in uniform buffers: with those, Mesa's lavapipe (22.3) went back to its
        // shader compiler at every change of a value and kept what it had made, up to 20 MiB a frame. It seems to inline
        // uniform values that a branch reads.
        let parameters = buffer(wgpu::BufferBindingType::Storage { read_only: true }, false);
        let storage = buffer(wgpu::BufferBindingType::Storage { read_only: false }, false);
        let texture = |view_dimension, filterable| wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable },
            view_dimension,
            multisampled: false,
        };
        let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        let drawing = wgpu::ShaderStages::VERTEX_FRAGMENT | wgpu::ShaderStages::COMPUTE;
        let volume = texture(D3, true);
        let columns = texture(D2Array, true);
        let written = |format, view_dimension| wgpu::BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::WriteOnly,
            format,
            view_dimension,
        };
        Self {
            frame: layout(
                "frame",
                drawing,
                &[
                    parameters,
                    parameters,
                    texture(D2, true),
                    sampler,
                    texture(D2, true),
                    sampler,
                    texture(D2, true),
                    texture(D2, false),
                    parameters,
                    volume,
                ],
            ),
            deck: layout(
                "deck",
                drawing,
                &[
                    parameters,
                    volume,
                    volume,
                    volume,
                    volume,
                    volume,
                    volume,
                    sampler,
                    texture(D2, true),
                    parameters,
                    texture(D2, true),
                ],
            ),
            mesh: layout("mesh", drawing, &[parameters]),
            ground: layout("ground", drawing, &[parameters, texture(D2, true)]),
            stars: layout("stars", drawing, &[parameters, parameters, parameters]),
            relief: layout("relief", drawing, &[parameters, parameters, parameters]),
            shadow: layout("shadow", drawing, &[parameters, columns, columns, columns, sampler]),
            image: layout("image", drawing, &[texture(D2, false)]),
            nodes: layout("nodes", wgpu::ShaderStages::COMPUTE, &[storage]),
            strokes: layout("strokes", drawing, &[parameters, parameters, parameters]),
            glow: layout("glow", drawing, &[parameters, texture(D2, false), texture(D2, false), texture(D2, false)]),
            march: layout(
                "march",
                wgpu::ShaderStages::COMPUTE,
                &[texture(D2, false), written(gpu.light_format, D2), parameters],
            ),
        }
    }
}

/// The layout of a pipeline that reads these groups, counted from 0.
pub fn pipeline_layout(gpu: &Gpu, groups: &[Option<&wgpu::BindGroupLayout>]) -> wgpu::PipelineLayout {
    let groups: Vec<_> = match groups {
        [first, None] => vec![*first],
        all => all.to_vec(),
    };
    gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &groups,
        immediate_size: 0,
    })
}
