//! Which executor draws, and why.

use super::Failure;
use crate::gpu::GpuExecutor;
use crate::passes::relight::cache::Cache;
use crate::passes::relight::tables::Tables;
use crate::plan::executor::{Executor, Fault};
use crate::reference::ReferenceExecutor;
use crate::settings::ExecutorChoice;
use std::path::Path;
use std::sync::Arc;

/// Tables of virtual lights that are kept in a folder of so many MiB, or nowhere beyond this program's life.
///
/// # Errors
/// [`Failure::Input`]: the folder cannot be read or made.
pub(super) fn tables(folder: Option<&Path>, most_mib: u32) -> Result<Arc<Tables>, Failure> {
    let open = |folder: &Path| {
        let cache = Cache::open(folder, u64::from(most_mib) << 20);
        cache.map(Arc::new).map_err(|why| Failure::Input(format!("basis_cache = {}: {why}", folder.display())))
    };
    Ok(Arc::new(Tables::new(folder.map(open).transpose()?)))
}

/// Makes the executor asked for; `auto` takes the GPU when an adapter is there. The second value says which and why.
///
/// # Errors
/// A [`Fault`]: the GPU was asked for, and there is no adapter or it cannot do the work.
pub(super) fn make(choice: ExecutorChoice, tables: &Arc<Tables>) -> Result<(Box<dyn Executor>, String), Fault> {
    let reference = || -> Box<dyn Executor> { Box::new(ReferenceExecutor::with_tables(tables.clone())) };
    let gpu = || -> Result<Box<dyn Executor>, Fault> { Ok(Box::new(GpuExecutor::with_tables(tables.clone())?)) };
    let (executor, why) = match choice {
        ExecutorChoice::Reference => (reference(), "as asked for".to_owned()),
        ExecutorChoice::Gpu => (gpu()?, "as asked for".to_owned()),
        ExecutorChoice::Auto => match gpu() {
            Ok(executor) => (executor, "a graphics adapter is there".to_owned()),
            Err(fault) => (reference(), fault.to_string()),
        },
    };
    let why = format!("{} ({why})", executor.describe());
    Ok((executor, why))
}

/// Reads the choice from the command line.
pub(super) fn choice(text: &str) -> Result<ExecutorChoice, String> {
    match text {
        "gpu" => Ok(ExecutorChoice::Gpu),
        "reference" => Ok(ExecutorChoice::Reference),
        "auto" => Ok(ExecutorChoice::Auto),
        _ => Err("gpu, reference or auto".to_owned()),
    }
}
