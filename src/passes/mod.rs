//! The passes: one folder each, with its parameters, its shader and its twin on the CPU.
