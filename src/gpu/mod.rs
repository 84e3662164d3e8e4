//! The GPU executor: the only importer of wgpu.
