//! What a host is told beside pictures.
