//! The server, and the client side of its protocol: the only importer of tokio.
