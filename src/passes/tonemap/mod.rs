//! Tone mapping: luminance to 8-bit sRGB.
//!
//! A filmic curve on each channel (toe, linear middle, soft shoulder), then the sRGB transfer function and half a code
//! of noise that depends on the pixel alone, so that a smooth sky shows no bands.

pub mod twin;
