//! Bytes and nothing but bytes: limits, JSON control messages, scenario files, the binary frame header.
