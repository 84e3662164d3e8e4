//! How pipelines are made: their blending, depth tests and fixed state.

use crate::gpu::device::Gpu;
use crate::gpu::targets::DEPTH_FORMAT;
use crate::passes::deck::Instance;

/// What is nearer is there already: new light comes through what the target's alpha still lets pass.
pub(super) fn under(format: wgpu::TextureFormat) -> wgpu::ColorTargetState {
    let component = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::OneMinusDstAlpha,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    };
    let blend = Some(wgpu::BlendState { color: component, alpha: component });
    wgpu::ColorTargetState { format, blend, write_mask: wgpu::ColorWrites::ALL }
}

/// What was there is written over.
pub(super) fn replaced(format: wgpu::TextureFormat) -> wgpu::ColorTargetState {
    wgpu::ColorTargetState { format, blend: None, write_mask: wgpu::ColorWrites::ALL }
}

/// Each layer passes a share of what the others have left.
pub(super) fn multiplied(format: wgpu::TextureFormat) -> wgpu::ColorTargetState {
    let component = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::Dst,
        dst_factor: wgpu::BlendFactor::Zero,
        operation: wgpu::BlendOperation::Add,
    };
    let blend = Some(wgpu::BlendState { color: component, alpha: component });
    wgpu::ColorTargetState { format, blend, write_mask: wgpu::ColorWrites::ALL }
}

/// Light adds up.
pub(super) fn added(format: wgpu::TextureFormat) -> wgpu::ColorTargetState {
    let component = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    };
    let blend = Some(wgpu::BlendState { color: component, alpha: component });
    wgpu::ColorTargetState { format, blend, write_mask: wgpu::ColorWrites::ALL }
}

/// Everything drawn lies at depth 0.5 and passes where nothing has been marked.
pub(super) fn tested() -> wgpu::DepthStencilState {
    depth(false, wgpu::CompareFunction::LessEqual)
}

/// Marks opaque pixels at depth 0.
pub(super) fn marked() -> wgpu::DepthStencilState {
    depth(true, wgpu::CompareFunction::Always)
}

fn depth(write: bool, compare: wgpu::CompareFunction) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH_FORMAT,
        depth_write_enabled: Some(write),
        depth_compare: Some(compare),
        stencil: Default::default(),
        bias: Default::default(),
    }
}

/// A compute pipeline whose label is its entry point.
pub(super) fn compute(
    gpu: &Gpu,
    entry: &str,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    compilation_options: wgpu::PipelineCompilationOptions,
) -> wgpu::ComputePipeline {
    gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry),
        layout: Some(layout),
        module,
        entry_point: Some(entry),
        compilation_options,
        cache: None,
    })
}

/// A render pipeline whose entry points are `name_vertex` and `name_fragment`; the deck's draws instances.
pub(super) fn render(
    gpu: &Gpu,
    name: &str,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    target: Option<wgpu::ColorTargetState>,
    depth_stencil: Option<wgpu::DepthStencilState>,
    constants: &[(&str, f64)],
) -> wgpu::RenderPipeline {
    let instances = wgpu::VertexBufferLayout {
        array_stride: size_of::<Instance>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![0 => Uint32, 1 => Float32, 2 => Float32, 3 => Float32, 4 => Float32],
    };
    let instanced = name == "deck";
    let buffers = [Some(instances)];
    let compilation_options = wgpu::PipelineCompilationOptions { constants, ..Default::default() };
    let targets: Vec<_> = target.into_iter().map(Some).collect();
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(name),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(&format!("{name}_vertex")),
            compilation_options: compilation_options.clone(),
            buffers: &buffers[..usize::from(instanced)],
        },
        primitive: wgpu::PrimitiveState {
            topology: if instanced {
                wgpu::PrimitiveTopology::TriangleStrip
            } else {
                wgpu::PrimitiveTopology::TriangleList
            },
            ..Default::default()
        },
        depth_stencil,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(&format!("{name}_fragment")),
            compilation_options,
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}
