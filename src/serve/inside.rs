//! A server inside this process with one watcher, for whoever wants to measure it from a thread of their own.

use super::client::{Client, ClientError, Incoming};
use super::render_thread::ExecutorFactory;
use super::stages::Stages;
use super::{ServeError, block_on, run_measured};
use crate::settings::Settings;
use std::net::SocketAddr;
use std::sync::Arc;
use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

/// Serves on a free port of this machine while `work` runs on a thread of its own; a watcher takes the pictures of the view
/// "main" as JPEG. Gives what `work` gives.
///
/// # Errors
/// [`ServeError`]: the server cannot run, or its watcher is turned away.
pub fn with_server<T: Send + 'static>(
    settings: Settings,
    factory: ExecutorFactory,
    stages: Arc<Stages>,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, ServeError> {
    block_on(async move {
        let listener = TcpListener::bind(SocketAddr::from(([127, 0, 0, 1], 0))).await?;
        let (address, stop) = (listener.local_addr()?, CancellationToken::new());
        let serving = run_measured(listener, settings, factory, stop.clone().cancelled_owned(), stages);
        let session = async {
            let _ends = stop.clone().drop_guard();
            let mut watcher = watcher(address).await.map_err(std::io::Error::other)?;
            let mut working = tokio::task::spawn_blocking(work);
            loop {
                tokio::select! {
                    done = &mut working => break done.map_err(std::io::Error::other),
                    frame = watcher.next() => {
                        frame.map_err(std::io::Error::other)?;
                    }
                }
            }
        };
        let (served, worked) = tokio::join!(serving, session);
        served?;
        worked.map_err(ServeError::System)
    })?
}

async fn watcher(address: SocketAddr) -> Result<Client, ClientError> {
    let mut client = Client::connect(&address.to_string(), None).await?;
    for text in [
        r#"{"type": "hello", "protocol": "stormdeck.v1", "role": "watcher"}"#,
        r#"{"type": "subscribe", "view": "main", "format": "jpeg"}"#,
    ] {
        client.send(text).await?;
        if let Incoming::Text(answer) = client.next().await?
            && answer.contains(r#""type":"refused""#)
        {
            return Err(ClientError::Broken(answer));
        }
    }
    Ok(client)
}
