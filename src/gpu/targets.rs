//! The targets of a picture size: the deck by itself with its depth, all light together, and the tone-mapped picture.

use super::device::Gpu;
use super::textures::empty;
use crate::plan::FramePlan;
use crate::world::snapshot::DeckForm;
use std::collections::VecDeque;

/// Sizes kept at once.
const KEPT: usize = 8;

/// Depth format of the occlusion test: two values are enough.
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// The tone-mapped picture, encoded by the shader.
pub const PICTURE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Light of strokes, of which each pixel has one value.
pub const STROKES_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R16Float;
/// Pictures of one size without a flash after which its images for strokes are dropped.
const STROKES_KEPT: u32 = 120;

/// Size in pixels, pixels to one of the deck, the deck's form, pixels to one of the shadows, and whether there is terrain.
type Key = ([u32; 2], u32, DeckForm, Option<u32>, bool);

/// Targets of one size.
pub struct Target {
    key: Key,
    /// The deck by itself; a second image only for the walking form, which reads one and writes the other.
    pub deck: Vec<wgpu::TextureView>,
    /// Pixels that are opaque, for the instanced form.
    pub occlusion: Option<wgpu::TextureView>,
    /// Share of the light that reaches the ground, where layers cast shadows.
    pub shadow: Option<wgpu::TextureView>,
    /// Range to the ground, where there is terrain.
    pub relief: Option<wgpu::TextureView>,
    pub light: wgpu::Texture,
    pub light_view: wgpu::TextureView,
    pub picture: wgpu::Texture,
    pub picture_view: wgpu::TextureView,
    /// While there are strokes to be drawn, and a while longer.
    pub strokes: Option<StrokeImages>,
}

/// Images for strokes.
pub struct StrokeImages {
    /// The strokes, then each level of their glow at half the size of the one before.
    pub levels: Vec<wgpu::TextureView>,
    /// What each level but the first has gathered from itself and those below it.
    pub gathered: Vec<wgpu::TextureView>,
    /// Light scattered in the air.
    pub air: wgpu::TextureView,
    air_size: [u32; 3],
    /// Pictures since the last with strokes.
    idle: u32,
}

/// Targets by size, the one used last first.
#[derive(Default)]
pub struct Targets {
    kept: VecDeque<Target>,
}

impl Targets {
    /// The targets of a plan.
    pub fn of(&mut self, gpu: &Gpu, plan: &FramePlan) -> &Target {
        let key =
            (plan.size_px, plan.deck_scale, plan.deck_form, plan.shadow.as_ref().map(|s| s.scale), plan.terrain());
        let at = self.kept.iter().position(|t| t.key == key);
        let mut target = at.and_then(|at| self.kept.remove(at)).unwrap_or_else(|| Target::new(gpu, key));
        target.make_room_for_strokes(gpu, plan);
        self.kept.push_front(target);
        self.kept.truncate(KEPT);
        &self.kept[0]
    }
}

impl Target {
    fn new(gpu: &Gpu, key: Key) -> Self {
        let (size_px, deck_scale, form, shadow_scale, terrain) = key;
        use wgpu::TextureUsages as Usage;
        let size = [size_px[0], size_px[1], 1];
        let coarser = |scale: u32| [size_px[0].div_ceil(scale), size_px[1].div_ceil(scale), 1];
        let coarse = coarser(deck_scale);
        let drawn = Usage::RENDER_ATTACHMENT | Usage::COPY_SRC;
        let read = drawn | Usage::TEXTURE_BINDING;
        let (images, deck_usage) = match form {
            DeckForm::Instanced => (1, read),
            DeckForm::Auto | DeckForm::Marched => (2, read | Usage::STORAGE_BINDING | Usage::COPY_DST),
        };
        let deck = || empty(gpu, "deck", gpu.light_format, coarse, deck_usage);
        let occlusion = || empty(gpu, "occlusion", DEPTH_FORMAT, coarse, Usage::RENDER_ATTACHMENT);
        let shadow = |scale| empty(gpu, "shadow", super::shadow::FORMAT, coarser(scale), read);
        let relief = || empty(gpu, "relief", super::relief::FORMAT, size, read);
        let light = empty(gpu, "light", gpu.light_format, size, read);
        let picture = empty(gpu, "picture", PICTURE_FORMAT, size, drawn);
        let view = |t: &wgpu::Texture| t.create_view(&wgpu::TextureViewDescriptor::default());
        Self {
            key,
            deck: (0..images).map(|_| view(&deck())).collect(),
            occlusion: (form == DeckForm::Instanced).then(|| view(&occlusion())),
            shadow: shadow_scale.map(|scale| view(&shadow(scale))),
            relief: terrain.then(|| view(&relief())),
            light_view: view(&light),
            light,
            picture_view: view(&picture),
            picture,
            strokes: None,
        }
    }

    fn make_room_for_strokes(&mut self, gpu: &Gpu, plan: &FramePlan) {
        let Some(strokes) = &plan.strokes else {
            self.strokes = self.strokes.take().filter(|images| images.idle < STROKES_KEPT);
            self.strokes.iter_mut().for_each(|images| images.idle += 1);
            return;
        };
        let air_size = [plan.size_px[0].div_ceil(strokes.air_scale), plan.size_px[1].div_ceil(strokes.air_scale), 1];
        let fits = |images: &StrokeImages| images.levels.len() == strokes.glow.len() && images.air_size == air_size;
        if !self.strokes.as_ref().is_some_and(fits) {
            self.strokes = Some(StrokeImages::new(gpu, plan.size_px, strokes.glow.len(), air_size));
        }
        self.strokes.iter_mut().for_each(|images| images.idle = 0);
    }
}

impl StrokeImages {
    fn new(gpu: &Gpu, size_px: [u32; 2], levels: usize, air_size: [u32; 3]) -> Self {
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
        let image = |label: &str, size: [u32; 3]| {
            empty(gpu, label, STROKES_FORMAT, size, usage).create_view(&wgpu::TextureViewDescriptor::default())
        };
        // Halves are rounded up, level by level.
        let mut sizes = vec![[size_px[0], size_px[1], 1]];
        for level in 1..levels {
            let [width, height, _] = sizes[level - 1];
            sizes.push([width.div_ceil(2), height.div_ceil(2), 1]);
        }
        Self {
            levels: sizes.iter().map(|size| image("strokes", *size)).collect(),
            gathered: sizes.iter().skip(1).map(|size| image("glow", *size)).collect(),
            air: image("airlight", air_size),
            air_size,
            idle: 0,
        }
    }
}
