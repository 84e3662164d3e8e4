//! The GPU executor: the only importer of wgpu.
//!
//! One frame is: the light volumes that are not resident, then the deck in batches from near to far with an occlusion
//! pass between them, then the shadows on the ground, ground and sky behind it, the channels of lightning with their glow,
//! then tone mapping and a copy into a slot of the read-back ring.
//! Everything is blended "under": a target's alpha is what is already hidden.

mod deck;
mod device;
mod frame;
mod instanced;
mod layouts;
mod light;
mod march;
mod pipelines;
mod relief;
mod relight;
mod resident;
mod ring;
mod shadow;
mod strokes;
mod targets;
mod textures;

#[cfg(test)]
mod tests;

use crate::passes::relight::tables::Tables;
use crate::plan::executor::{Executor, Fault, Finished};
use crate::plan::{FramePlan, Output};
use device::Gpu;
use pipelines::Pipelines;
use resident::Resident;
use ring::Ring;
use std::sync::Arc;
use targets::Targets;

/// All WGSL modules by name, as they are compiled: `common.wgsl` stands before those that use it.
pub fn shaders() -> Vec<(&'static str, String)> {
    pipelines::shaders()
}

/// The best adapter in one line: name, driver and back end.
///
/// # Errors
/// As [`GpuExecutor::new`].
pub fn adapter() -> Result<String, Fault> {
    Gpu::open().map(|gpu| gpu.name)
}

/// Plays plans on a graphics adapter.
pub struct GpuExecutor {
    gpu: Gpu,
    pipelines: Pipelines,
    resident: Resident,
    targets: Targets,
    ring: Ring,
}

impl GpuExecutor {
    /// Opens the best adapter and builds what every frame needs.
    ///
    /// # Errors
    /// [`Fault::NoAdapter`] where there is none, [`Fault::Unsupported`] where it cannot blend into float targets.
    pub fn new() -> Result<Self, Fault> {
        Self::with_tables(Arc::default())
    }

    /// As [`GpuExecutor::new`], with these tables of virtual lights, which it may share with others.
    ///
    /// # Errors
    /// As [`GpuExecutor::new`].
    pub fn with_tables(tables: Arc<Tables>) -> Result<Self, Fault> {
        let gpu = Gpu::open()?;
        let pipelines = Pipelines::new(&gpu);
        let resident = Resident::new(&gpu, tables);
        gpu.check()?;
        Ok(Self { gpu, pipelines, resident, targets: Targets::default(), ring: Ring::default() })
    }
}

impl Executor for GpuExecutor {
    fn describe(&self) -> String {
        format!("GPU executor on {}", self.gpu.name)
    }

    fn submit(&mut self, ticket: u64, plan: &FramePlan) -> Result<(), Fault> {
        self.gpu.check()?;
        let texel = match plan.output {
            Output::Srgb8 => targets::PICTURE_FORMAT,
            Output::LinearRgb => self.gpu.light_format,
        };
        self.gpu.fits(plan.size_px, texel.block_copy_size(None).unwrap_or(8))?;
        frame::submit(self, ticket, plan);
        self.gpu.check()
    }

    fn collect(&mut self, wait: bool) -> Result<Vec<Finished>, Fault> {
        let finished = self.ring.collect(&self.gpu, wait);
        self.gpu.check()?;
        finished
    }

    fn depth(&self) -> usize {
        ring::DEPTH
    }

    fn tables(&self) -> Option<Arc<Tables>> {
        Some(self.resident.fields.tables())
    }

    fn object_count(&self) -> usize {
        self.gpu.object_count()
    }
}
