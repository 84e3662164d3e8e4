//! The reference executor: plays the same plan with the twins, on the CPU.
