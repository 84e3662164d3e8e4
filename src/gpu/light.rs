//! Light volumes on the device: made on the processor for both executors (see `passes::light`), stored as they are encoded.

use super::device::Gpu;
use super::textures::filled;
use crate::passes::light::volume::{Texels, Volume};
use crate::passes::light::{HEIGHT, WIDTH};

/// A volume as a texture, its thetas one above the other.
pub fn upload(gpu: &Gpu, volume: &Volume) -> wgpu::TextureView {
    let size = [WIDTH as u32, WIDTH as u32, HEIGHT as u32 * volume.nodes];
    match &volume.texels {
        Texels::Bytes(texels) => filled(gpu, "light", wgpu::TextureFormat::Rgba8Unorm, size, texels.as_flattened()),
        Texels::Half(texels) => {
            filled(gpu, "light", wgpu::TextureFormat::Rgba16Float, size, bytemuck::cast_slice(texels))
        }
    }
}
