//! GPU against twin, pass by pass.
