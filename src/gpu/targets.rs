//! The targets of a picture size: light, depth and the tone-mapped picture.

use super::device::Gpu;
use super::textures::empty;
use std::collections::VecDeque;

/// Sizes kept at once.
const KEPT: usize = 8;

/// Depth format of the occlusion test: two values are enough.
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// The tone-mapped picture, encoded by the shader.
pub const PICTURE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Targets of one size.
pub struct Target {
    pub size_px: [u32; 2],
    pub light: wgpu::Texture,
    pub light_view: wgpu::TextureView,
    pub depth_view: wgpu::TextureView,
    pub picture: wgpu::Texture,
    pub picture_view: wgpu::TextureView,
}

/// Targets by size, the one used last first.
#[derive(Default)]
pub struct Targets {
    kept: VecDeque<Target>,
}

impl Targets {
    /// The targets of a size.
    pub fn of(&mut self, gpu: &Gpu, size_px: [u32; 2]) -> &Target {
        let at = self.kept.iter().position(|t| t.size_px == size_px);
        let target = at.and_then(|at| self.kept.remove(at)).unwrap_or_else(|| Target::new(gpu, size_px));
        self.kept.push_front(target);
        self.kept.truncate(KEPT);
        &self.kept[0]
    }

    /// Textures that live.
    pub fn count(&self) -> usize {
        3 * self.kept.len()
    }
}

impl Target {
    fn new(gpu: &Gpu, size_px: [u32; 2]) -> Self {
        use wgpu::TextureUsages as Usage;
        let size = [size_px[0], size_px[1], 1];
        let drawn = Usage::RENDER_ATTACHMENT | Usage::COPY_SRC;
        let light = empty(gpu, "light", gpu.light_format, size, drawn | Usage::TEXTURE_BINDING);
        let depth = empty(gpu, "occlusion", DEPTH_FORMAT, size, Usage::RENDER_ATTACHMENT);
        let picture = empty(gpu, "picture", PICTURE_FORMAT, size, drawn);
        let view = |t: &wgpu::Texture| t.create_view(&wgpu::TextureViewDescriptor::default());
        Self {
            size_px,
            light_view: view(&light),
            light,
            depth_view: view(&depth),
            picture_view: view(&picture),
            picture,
        }
    }
}
