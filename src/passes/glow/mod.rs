//! Glow: what a lens spreads of a light far brighter than the rest, around lightning.
//!
//! What it is: a point spread function of the shape of the glare equation of CIE 146:2002 (10 / a^3 + 5 / a^2 cd/m2 for one lux
//! at the eye, a degrees away; Spencer et al. 1995 draw glare so), and of the strength of a good lens: the picture is exposed
//! as by a camera, and whoever looks at it adds the glare of his own eye. How it is computed: as a
//! sum of Gaussians, each twice as wide as the one before, weighted by the share of light that the equation has around their width. How it
//! is stored: a pyramid of images, each half the size; going down each takes the weights 1 3 3 1 of the one before, coming up
//! it is spread by 3 1 to the one before, so that the light of each level is kept. The share that is spread is taken from the
//! light itself: the whole adds up to what was there, but for what falls beyond the picture's rim.

pub mod twin;

use bytemuck::{Pod, Zeroable};

/// What one step adds. Parameters; twin of `Glow` in `glow.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Glow {
    /// Share of its own level's light.
    pub weight: f32,
    /// Factor on everything: from the strokes' image to exposed light in the last step, else 1.
    pub gain: f32,
    /// Factor on the light scattered in the air: only in the last step, else 0.
    pub air_gain: f32,
    /// Pads to 16 bytes.
    pub pad: f32,
}

/// Levels at most, the picture itself among them.
pub const MOST_LEVELS: usize = 10;
/// Strength of the glow against that of a young eye: some per cent of the light in all, as the veiling glare index of good lenses
/// (ISO 9358); a whole eye's would hide a bolt at night in its own glare.
const LENS: f32 = 0.15;
/// Widest part of the glow that is drawn, as a standard deviation in degrees.
const WIDEST_DEG: f32 = 10.0;

/// Shares of the light that stays where it is and that is spread at each level, adding up to 1. `pixel_deg`: a pixel in
/// degrees; `size_px`: no level is smaller than a pixel.
pub fn weights(pixel_deg: f32, size_px: [u32; 2]) -> Vec<f32> {
    let mut weights = vec![1.0];
    for level in 1..MOST_LEVELS {
        // Variance of 1 3 3 1 on the way down and up: half of 4^level - 1 pixels squared.
        let sigma_deg = |level: f32| pixel_deg * (0.5 * (4.0_f32.powf(level) - 1.0)).max(0.0).sqrt();
        let least_side = size_px[0].min(size_px[1]) >> level;
        if sigma_deg(level as f32) > WIDEST_DEG || least_side < 2 {
            break;
        }
        // The light of the equation between half an octave below and above this width.
        let share = within(sigma_deg(level as f32 + 0.5)) - within(sigma_deg(level as f32 - 0.5));
        weights.push(LENS * share);
    }
    let spread: f32 = weights[1..].iter().sum();
    weights[0] = 1.0 - spread;
    weights
}

/// Share of a light that the glare equation has within an angle of at least 0.1 degrees, less a constant.
///
/// One lux in a degree's ring: 2 pi a (pi / 180)^2 (10 / a^3 + 5 / a^2), integrated.
fn within(degrees: f32) -> f32 {
    let a = degrees.max(0.1);
    let ring = std::f32::consts::TAU * (std::f32::consts::PI / 180.0).powi(2);
    ring * (5.0 * a.ln() - 10.0 / a)
}
