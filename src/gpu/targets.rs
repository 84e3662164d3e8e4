//! The targets of a picture size: the deck by itself with its depth, all light together, and the tone-mapped picture.

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
    key: ([u32; 2], u32),
    pub deck_view: wgpu::TextureView,
    pub depth_view: wgpu::TextureView,
    pub light: wgpu::Texture,
    pub light_view: wgpu::TextureView,
    pub picture: wgpu::Texture,
    pub picture_view: wgpu::TextureView,
}

/// Targets by size, the one used last first.
#[derive(Default)]
pub struct Targets {
    kept: VecDeque<Target>,
}

impl Targets {
    /// The targets of a size, with a deck of `deck_scale` times fewer pixels each way.
    pub fn of(&mut self, gpu: &Gpu, size_px: [u32; 2], deck_scale: u32) -> &Target {
        let at = self.kept.iter().position(|t| t.key == (size_px, deck_scale));
        let target = at.and_then(|at| self.kept.remove(at)).unwrap_or_else(|| Target::new(gpu, size_px, deck_scale));
        self.kept.push_front(target);
        self.kept.truncate(KEPT);
        &self.kept[0]
    }
}

impl Target {
    fn new(gpu: &Gpu, size_px: [u32; 2], deck_scale: u32) -> Self {
        use wgpu::TextureUsages as Usage;
        let size = [size_px[0], size_px[1], 1];
        let coarse = [size_px[0].div_ceil(deck_scale), size_px[1].div_ceil(deck_scale), 1];
        let drawn = Usage::RENDER_ATTACHMENT | Usage::COPY_SRC;
        let read = drawn | Usage::TEXTURE_BINDING;
        let deck = empty(gpu, "deck", gpu.light_format, coarse, read);
        let depth = empty(gpu, "occlusion", DEPTH_FORMAT, coarse, Usage::RENDER_ATTACHMENT);
        let light = empty(gpu, "light", gpu.light_format, size, read);
        let picture = empty(gpu, "picture", PICTURE_FORMAT, size, drawn);
        let view = |t: &wgpu::Texture| t.create_view(&wgpu::TextureViewDescriptor::default());
        Self {
            key: (size_px, deck_scale),
            deck_view: view(&deck),
            light_view: view(&light),
            light,
            depth_view: view(&depth),
            picture_view: view(&picture),
            picture,
        }
    }
}
