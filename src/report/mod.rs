//! Error against run time.
