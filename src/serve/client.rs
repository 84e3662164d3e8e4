//! The client side of the protocol: what `stormdeck host` and the tests connect with.

use crate::wire::limits;
use futures_util::{SinkExt, StreamExt};
use std::time::Duration;
use tokio::net::TcpStream;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::tungstenite::http::HeaderValue;
use tokio_tungstenite::tungstenite::protocol::WebSocketConfig;
use tokio_tungstenite::tungstenite::{Error, Message};
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, connect_async_with_config};

/// A connection to a server.
pub struct Client {
    socket: WebSocketStream<MaybeTlsStream<TcpStream>>,
}

/// What a server sends.
#[derive(Clone, Debug, PartialEq)]
pub enum Incoming {
    /// A control message: JSON.
    Text(String),
    /// A frame: header and picture, for `wire::frames::decode`.
    Frame(Vec<u8>),
    /// The end, and the server's reason if it gave one.
    Closed(Option<String>),
}

/// Why there is no connection any more, or never was.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ClientError {
    /// The address is none, or the token holds characters that a header cannot.
    #[error("cannot ask {address}: {why}")]
    Address {
        /// What was given.
        address: String,
        /// What is wrong with it.
        why: String,
    },
    /// Nobody answers there, or the server turned the request away.
    #[error("cannot connect to {address}: {why}")]
    Connect {
        /// Where to.
        address: String,
        /// The reason, with the server's words if it gave any.
        why: String,
    },
    /// The connection broke.
    #[error("the connection broke: {0}")]
    Broken(String),
}

impl Client {
    /// Connects to `host:port` (or a whole `ws://host:port/path`), with the server's access token if it wants one.
    ///
    /// # Errors
    /// [`ClientError::Address`] or [`ClientError::Connect`].
    pub async fn connect(address: &str, token: Option<&str>) -> Result<Self, ClientError> {
        let wrong = |why: String| ClientError::Address { address: address.to_owned(), why };
        let url = if address.contains("://") { address.to_owned() } else { format!("ws://{address}/ws") };
        let mut request = url.into_client_request().map_err(|error| wrong(error.to_string()))?;
        if let Some(token) = token {
            let value = HeaderValue::from_str(&format!("Bearer {token}")).map_err(|error| wrong(error.to_string()))?;
            request.headers_mut().insert("authorization", value);
        }
        let largest = limits::FRAME_PAYLOAD_BYTES as usize + 4096;
        let config = WebSocketConfig::default().max_message_size(Some(largest)).max_frame_size(Some(largest));
        let connected = connect_async_with_config(request, Some(config), true).await;
        let (socket, _response) = connected.map_err(|error| {
            let why = match &error {
                Error::Http(response) => {
                    let words = response.body().as_deref().map(String::from_utf8_lossy).unwrap_or_default();
                    format!("{}: {}", response.status(), words.trim())
                }
                other => other.to_string(),
            };
            ClientError::Connect { address: address.to_owned(), why }
        })?;
        Ok(Self { socket })
    }

    /// Sends a control message.
    ///
    /// # Errors
    /// [`ClientError::Broken`].
    pub async fn send(&mut self, text: impl Into<String>) -> Result<(), ClientError> {
        let text: String = text.into();
        self.socket.send(Message::Text(text.into())).await.map_err(|error| ClientError::Broken(error.to_string()))
    }

    /// The next message or frame; waits for it. After [`Incoming::Closed`] nothing more comes.
    ///
    /// # Errors
    /// [`ClientError::Broken`].
    pub async fn next(&mut self) -> Result<Incoming, ClientError> {
        loop {
            return match self.socket.next().await {
                None => Ok(Incoming::Closed(None)),
                Some(Ok(Message::Text(text))) => Ok(Incoming::Text(text.as_str().to_owned())),
                Some(Ok(Message::Binary(bytes))) => Ok(Incoming::Frame(bytes.into())),
                Some(Ok(Message::Close(frame))) => {
                    Ok(Incoming::Closed(frame.map(|frame| frame.reason.as_str().to_owned())))
                }
                // Pings are answered by the socket itself.
                Some(Ok(Message::Ping(_) | Message::Pong(_) | Message::Frame(_))) => continue,
                Some(Err(error)) => Err(ClientError::Broken(error.to_string())),
            };
        }
    }

    /// As [`Client::next`]; `None` when nothing came in time.
    ///
    /// # Errors
    /// As [`Client::next`].
    pub async fn next_within(&mut self, limit: Duration) -> Result<Option<Incoming>, ClientError> {
        match tokio::time::timeout(limit, self.next()).await {
            Ok(incoming) => incoming.map(Some),
            Err(_) => Ok(None),
        }
    }

    /// Says goodbye.
    pub async fn close(mut self) {
        // A server that is gone already needs no goodbye.
        let _gone = self.socket.close(None).await;
    }
}
