//! Textures from bytes in main memory.

use super::device::Gpu;

/// A texture with one mip level and these texels (rows without padding, x fastest).
pub fn filled(gpu: &Gpu, label: &str, format: wgpu::TextureFormat, size: [u32; 3], bytes: &[u8]) -> wgpu::TextureView {
    let texture = empty(gpu, label, format, size, wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST);
    let texel = format.block_copy_size(None).unwrap_or(4);
    gpu.queue.write_texture(
        texture.as_image_copy(),
        bytes,
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(size[0] * texel), rows_per_image: Some(size[1]) },
        extent(size),
    );
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// A texture of two dimensions, or of three where the depth is above 1.
pub fn empty(
    gpu: &Gpu,
    label: &str,
    format: wgpu::TextureFormat,
    size: [u32; 3],
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: extent(size),
        mip_level_count: 1,
        sample_count: 1,
        dimension: if size[2] > 1 { wgpu::TextureDimension::D3 } else { wgpu::TextureDimension::D2 },
        format,
        usage,
        view_formats: &[],
    })
}

fn extent(size: [u32; 3]) -> wgpu::Extent3d {
    wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: size[2] }
}
