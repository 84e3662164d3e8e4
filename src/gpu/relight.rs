//! The fields of flashes' light on the device: one texture, a field above the other, and their parameters.

mod sum;

use super::device::Gpu;
use super::textures::empty;
use crate::passes::relight::store::Store;
use crate::passes::relight::tables::Tables;
use crate::passes::relight::{FIELDS, Field, HEIGHT, Prepared, WIDTH};
use crate::plan::FramePlan;
use half::f16;
use std::sync::Arc;
use sum::SumPasses;

/// What the shaders of a picture read.
pub struct Bound {
    /// Parameters.
    pub lits: wgpu::Buffer,
    /// Quotients of all fields.
    pub quotients: wgpu::TextureView,
    /// Whether a field is still being made.
    pub provisional: bool,
}

/// Fields that are kept, and the texture that holds those of the last picture.
pub struct Fields {
    store: Store,
    /// Bound where no field is.
    dark: Option<wgpu::TextureView>,
    atlas: Option<Atlas>,
}

struct Atlas {
    texture: wgpu::Texture,
    sums: Option<SumPasses>,
    held: [Option<Arc<Field>>; FIELDS],
}

impl Fields {
    /// None yet, over these tables.
    pub fn new(tables: Arc<Tables>) -> Self {
        Self { store: Store::new(tables, true), dark: None, atlas: None }
    }

    /// The tables of virtual lights.
    pub fn tables(&self) -> Arc<Tables> {
        self.store.tables().clone()
    }

    /// Makes the fields of a plan and binds them.
    pub fn bind(&mut self, gpu: &Gpu, plan: &FramePlan) -> Bound {
        self.store.tables().set_most((plan.basis_memory_mib as usize) << 20);
        let prepared = Prepared::new(&mut self.store, &plan.lit, &plan.ahead, plan.waits);
        let lits = gpu.buffer("lits", bytemuck::bytes_of(&prepared.lits), wgpu::BufferUsages::STORAGE);
        let quotients = if prepared.fields.iter().any(Option::is_some) {
            self.atlas.get_or_insert_with(|| Atlas::new(gpu)).hold(gpu, &prepared.fields)
        } else {
            if self.store.is_empty() {
                self.atlas = None;
            }
            let dark = self.dark.get_or_insert_with(|| volume(gpu, [2, 2, 2]).create_view(&Default::default()));
            dark.clone()
        };
        Bound { lits, quotients, provisional: prepared.provisional }
    }
}

impl Atlas {
    fn new(gpu: &Gpu) -> Self {
        let texture = volume(gpu, [WIDTH as u32, WIDTH as u32, (HEIGHT * FIELDS) as u32]);
        Self { texture, sums: None, held: [const { None }; FIELDS] }
    }

    /// Uploads what is not there yet, or has it summed on the device.
    fn hold(&mut self, gpu: &Gpu, fields: &[Option<Arc<Field>>]) -> wgpu::TextureView {
        for (slot, (held, field)) in self.held.iter_mut().zip(fields).enumerate() {
            let Some(field) = field else { continue };
            if held.as_ref().is_none_or(|held| !Arc::ptr_eq(held, field)) {
                match &field.summed {
                    Some(summed) => {
                        let sums = self.sums.get_or_insert_with(|| SumPasses::new(gpu));
                        sums.run(gpu, summed, &self.texture, (slot * HEIGHT) as u32);
                    }
                    None => upload(gpu, &self.texture, slot, field),
                }
                *held = Some(field.clone());
            }
        }
        self.texture.create_view(&Default::default())
    }
}

fn volume(gpu: &Gpu, size: [u32; 3]) -> wgpu::Texture {
    use wgpu::TextureUsages as Usage;
    let usage = Usage::TEXTURE_BINDING | Usage::STORAGE_BINDING | Usage::COPY_DST | Usage::COPY_SRC;
    empty(gpu, "fields", wgpu::TextureFormat::Rgba16Float, size, usage)
}

fn upload(gpu: &Gpu, texture: &wgpu::Texture, slot: usize, field: &Field) {
    let texels: Vec<f16> = field.quotients.iter().flatten().map(|v| f16::from_f32(v.min(65_000.0))).collect();
    let [width, height, levels] = field.window.cells.map(|n| n as u32);
    let origin = wgpu::Origin3d { x: 0, y: 0, z: (slot * HEIGHT) as u32 };
    let to = wgpu::TexelCopyTextureInfo { origin, ..texture.as_image_copy() };
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(8 * width), rows_per_image: Some(height) };
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: levels };
    gpu.queue.write_texture(to, bytemuck::cast_slice(&texels), layout, size);
}
