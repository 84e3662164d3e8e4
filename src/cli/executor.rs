//! Which executor draws, and why.

use crate::gpu::GpuExecutor;
use crate::plan::executor::{Executor, Fault};
use crate::reference::ReferenceExecutor;
use crate::settings::ExecutorChoice;

/// Makes the executor asked for; `auto` takes the GPU when an adapter is there. The second value says which and why.
///
/// # Errors
/// A [`Fault`]: the GPU was asked for, and there is no adapter or it cannot do the work.
pub(super) fn make(choice: ExecutorChoice) -> Result<(Box<dyn Executor>, String), Fault> {
    let reference = || -> Box<dyn Executor> { Box::new(ReferenceExecutor::new()) };
    let gpu = || -> Result<Box<dyn Executor>, Fault> { Ok(Box::new(GpuExecutor::new()?)) };
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
