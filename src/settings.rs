//! Settings: the configuration file checked as a whole, all complaints at once.
