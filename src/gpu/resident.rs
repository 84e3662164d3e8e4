//! What stays on the device between frames: textures of the house, the sky's table, and light volumes by their parameters.

use super::device::Gpu;
use super::frame::group;
use super::light;
use super::pipelines::Pipelines;
use super::relief::Grids;
use super::relight::Fields;
use super::textures::{empty, filled};
use crate::clouds::density::{self, DensityVolume};
use crate::clouds::{CloudKind, clearance, detail, modulation};
use crate::passes::deck::glow::{self, CityGlow, GlowWindow};
use crate::passes::light::volume::Volume;
use crate::passes::light::{Light, library};
use crate::passes::relight::tables::Tables;
use crate::passes::shadow::table as columns;
use crate::passes::shadow::{Columns, shade};
use crate::passes::sky::table::{self, TableParams};
use crate::passes::sky::{Stars, stars};
use crate::plan::GlowPlan;
use crate::plan::executor::Unused;
use std::collections::VecDeque;
use std::sync::Arc;

/// Light volumes kept at once (2 MiB for each theta in 8 bits), or as many as one picture needs.
pub const VOLUMES_KEPT: usize = 4;

/// A genus's shape values, and how far its places are from cloud.
#[derive(Clone)]
pub struct Shape {
    pub values: wgpu::TextureView,
    pub bounds: wgpu::TextureView,
}

/// Everything that stays.
pub struct Resident {
    pub map: wgpu::TextureView,
    pub detail: wgpu::TextureView,
    /// Heights around the eye.
    pub grids: Grids,
    /// A deck that hides nothing.
    pub nothing: wgpu::TextureView,
    /// Clamped, for the sky's table.
    pub clamped: wgpu::Sampler,
    /// Repeating along all axes.
    pub repeated: wgpu::Sampler,
    /// Repeating east and north, clamped upwards.
    pub tiled: wgpu::Sampler,
    /// Repeating, linear between levels too.
    pub levels: wgpu::Sampler,
    table: Option<(TableParams, wgpu::TextureView)>,
    shapes: VecDeque<(CloudKind, Shape)>,
    volumes: VecDeque<((CloudKind, Light), wgpu::TextureView)>,
    columns: VecDeque<((CloudKind, Columns), wgpu::TextureView)>,
    shades: Vec<wgpu::TextureView>,
    glow: Option<(GlowWindow, wgpu::TextureView)>,
    /// The stars' cells and the stars.
    stars: Option<[wgpu::Buffer; 2]>,
    /// Fields of flashes' light.
    pub fields: Fields,
    /// Pictures without clouds.
    cloudless: Unused,
}

impl Resident {
    /// Uploads what every frame reads; flashes are drawn by these tables.
    pub fn new(gpu: &Gpu, tables: Arc<Tables>) -> Self {
        use wgpu::AddressMode::{ClampToEdge, Repeat};
        use wgpu::MipmapFilterMode::{Linear, Nearest};
        let byte = wgpu::TextureFormat::R8Unorm;
        let (w, d) = (modulation::WIDTH as u32, detail::WIDTH as u32);
        let sampler = |horizontal, vertical, mipmap_filter| {
            gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                address_mode_u: horizontal,
                address_mode_v: horizontal,
                address_mode_w: vertical,
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter,
                ..Default::default()
            })
        };
        Self {
            map: filled(gpu, "map", byte, [w, w, 1], modulation::map()),
            detail: filled(gpu, "detail", byte, [d, d, d], detail::volume()),
            grids: Grids::default(),
            nothing: filled(gpu, "nothing", wgpu::TextureFormat::Rgba16Float, [1, 1, 1], &[0; 8]),
            clamped: sampler(ClampToEdge, ClampToEdge, Nearest),
            repeated: sampler(Repeat, Repeat, Nearest),
            tiled: sampler(Repeat, ClampToEdge, Nearest),
            levels: sampler(Repeat, Repeat, Linear),
            table: None,
            shapes: VecDeque::new(),
            volumes: VecDeque::new(),
            columns: VecDeque::new(),
            shades: Vec::new(),
            glow: None,
            stars: None,
            fields: Fields::new(tables),
            cloudless: Unused::default(),
        }
    }

    /// Takes a picture that has clouds or not: what only clouds need is forgotten when there have been none for long.
    pub fn clouds(&mut self, there: bool) {
        if self.cloudless.is_due(there) {
            (self.shapes, self.volumes, self.columns) = (VecDeque::new(), VecDeque::new(), VecDeque::new());
            self.shades = Vec::new();
            library::forget();
        }
    }

    /// The sky's table for these parameters.
    pub fn table(&mut self, gpu: &Gpu, params: &TableParams) -> wgpu::TextureView {
        match &self.table {
            Some((kept, view)) if kept == params => view.clone(),
            _ => {
                let texels = table::build(params);
                let width = 2 * table::WIDTH;
                let size = [width as u32, (texels.len() / width) as u32, 1];
                let format = wgpu::TextureFormat::Rgba16Float;
                let view = filled(gpu, "sky table", format, size, bytemuck::cast_slice(&texels));
                self.table = Some((*params, view.clone()));
                view
            }
        }
    }

    /// What the sky reads of the stars; where there are none, what no shader asks for.
    pub fn stars(&mut self, gpu: &Gpu, pipelines: &Pipelines, plan: Option<&Stars>) -> wgpu::BindGroup {
        let buffer = |bytes: &[u8]| gpu.buffer("stars", bytes, wgpu::BufferUsages::STORAGE);
        let Some(plan) = plan else {
            self.stars = None;
            let nothing = buffer(&[0; size_of::<Stars>()]);
            let resource = nothing.as_entire_binding();
            return group(gpu, &pipelines.stars_layout, &[resource.clone(), resource.clone(), resource]);
        };
        let [cells, stars] = self.stars.get_or_insert_with(|| {
            let table = stars::table();
            [bytemuck::cast_slice(&table.cells), bytemuck::cast_slice(&table.stars)].map(buffer)
        });
        let parameters = buffer(bytemuck::bytes_of(plan));
        let resources = [parameters.as_entire_binding(), cells.as_entire_binding(), stars.as_entire_binding()];
        group(gpu, &pipelines.stars_layout, &resources)
    }

    /// What the deck reads of city glow; where there is none, what no shader asks for.
    pub fn glow(&mut self, gpu: &Gpu, plan: Option<&GlowPlan>) -> (wgpu::Buffer, wgpu::TextureView) {
        let parameters = |bytes: &[u8]| gpu.buffer("glow", bytes, wgpu::BufferUsages::STORAGE);
        let Some(plan) = plan else {
            self.glow = None;
            return (parameters(&[0; size_of::<CityGlow>()]), self.nothing.clone());
        };
        let table = match &self.glow {
            Some((kept, table)) if *kept == plan.window => table.clone(),
            _ => {
                let size = [glow::WIDTH as u32, glow::WIDTH as u32, 1];
                let texels = glow::build(&plan.window);
                let bytes = bytemuck::cast_slice(texels.as_flattened());
                let table = filled(gpu, "glow", wgpu::TextureFormat::Rgba16Float, size, bytes);
                self.glow = Some((plan.window.clone(), table.clone()));
                table
            }
        };
        (parameters(bytemuck::bytes_of(&plan.glow)), table)
    }

    /// The light volume of a genus for these parameters; made where it is not resident. `most`: how many may stay.
    pub fn volume(&mut self, gpu: &Gpu, kind: CloudKind, params: &Light, most: usize) -> wgpu::TextureView {
        let key = (kind, *params);
        let found = self.volumes.iter().position(|(k, _)| *k == key).and_then(|at| self.volumes.remove(at));
        let entry = found.unwrap_or_else(|| (key, light::upload(gpu, &Volume::of(kind, params))));
        let view = entry.1.clone();
        self.volumes.push_front(entry);
        self.volumes.truncate(most);
        view
    }

    /// The table of what a genus lets through of the light; made where it is not resident. `most`: how many may stay.
    pub fn columns(&mut self, gpu: &Gpu, kind: CloudKind, params: &Columns, most: usize) -> wgpu::TextureView {
        let key = (kind, *params);
        let found = self.columns.iter().position(|(k, _)| *k == key).and_then(|at| self.columns.remove(at));
        let entry = found.unwrap_or_else(|| {
            let table = columns::build(params, &DensityVolume::of(kind).shape);
            (key, super::shadow::upload(gpu, &table))
        });
        let view = entry.1.clone();
        self.columns.push_front(entry);
        self.columns.truncate(most);
        view
    }

    /// The map of shade on layer `i` of the picture that is being recorded.
    pub fn shade(&mut self, gpu: &Gpu, i: usize) -> wgpu::TextureView {
        use wgpu::TextureUsages as Usage;
        while self.shades.len() <= i {
            let size = [shade::WIDTH as u32, shade::WIDTH as u32, 1];
            let usage = Usage::RENDER_ATTACHMENT | Usage::TEXTURE_BINDING;
            let image = empty(gpu, "shade", super::shadow::FORMAT, size, usage);
            self.shades.push(image.create_view(&wgpu::TextureViewDescriptor::default()));
        }
        self.shades[i].clone()
    }

    /// Shape values and bounds of a genus.
    pub fn shape(&mut self, gpu: &Gpu, kind: CloudKind) -> Shape {
        let at = self.shapes.iter().position(|(k, _)| *k == kind).unwrap_or_else(|| {
            let shape = &DensityVolume::of(kind).shape;
            let values = shape_values(gpu, shape);
            let size = [clearance::WIDTH as u32, clearance::WIDTH as u32, clearance::HEIGHT as u32];
            let bounds = filled(gpu, "bounds", wgpu::TextureFormat::Rgba8Unorm, size, &clearance::of(kind));
            self.shapes.push_back((kind, Shape { values, bounds }));
            self.shapes.len() - 1
        });
        self.shapes[at].1.clone()
    }
}

/// A density volume's shape values in f16: some samplers weigh 8-bit texels in 8 bits, and the threshold would make that
/// error visible.
pub fn shape_values(gpu: &Gpu, shape: &[u8]) -> wgpu::TextureView {
    let half: Vec<half::f16> = shape.iter().map(|v| half::f16::from_f32(f32::from(*v) / 255.0)).collect();
    let size = [density::WIDTH as u32, density::WIDTH as u32, density::HEIGHT as u32];
    filled(gpu, "shape", wgpu::TextureFormat::R16Float, size, bytemuck::cast_slice(&half))
}
