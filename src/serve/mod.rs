//! The server, and the client side of its protocol: the only importer of tokio.

pub mod client;
mod signals;

pub use signals::shutdown_signal;

/// Runs a future to its end on a runtime of its own: the door for verbs that know no tokio.
///
/// # Errors
/// The runtime's threads could not be started.
pub fn block_on<F: Future>(future: F) -> std::io::Result<F::Output> {
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build()?;
    let output = runtime.block_on(future);
    // A drawing thread or an encoding that is still busy must not hold the process.
    runtime.shutdown_timeout(std::time::Duration::from_millis(200));
    Ok(output)
}
