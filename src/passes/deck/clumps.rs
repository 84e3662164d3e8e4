//! Density that varies inside the cloud around the eye, so that a pilot who flies through it sees it pass; twin of the functions of
//! the same names in `field.wgsl`, and of what `relieved` does near the eye in `lit.wgsl`.
//!
//! *What it is.* Clumps of two sizes, read from the detail volume: 1 on the mean, and faded where many lie behind each other, so that
//! light volumes, shadows and far clouds need not know them.

use super::Layer;
use super::field::{Textures, fine};
use crate::passes::common::{smoothstep, stereographic};
use glam::{Vec2, Vec3};

/// Ranges between which the variation of density inside the cloud fades, m: farther away many clumps lie behind each other.
pub const VARIED_M: [f32; 2] = [150.0, 600.0];
/// Steps of the walk for each usual one where clumps are: with 32 slices the shortest is 12 m, less than half of the smallest.
pub const RUNGS: f32 = 3.0;
/// Least density of a clump; the greatest is as far above 1.
const LEAST_VARIED: f32 = 0.1;
/// How far towards the light the clumps lie that shade a place, m.
const CLUMP_SHADE_M: f32 = 80.0;
/// What a clump of twice the density takes of the light that comes through it, as an exponent: of the light deep in a cloud the net
/// flux is a sixth or so, and the light falls by `3 (1 - g) sigma` times it (diffusion, sigma 0.05/m, g 0.85).
const CLUMP_SHADE: f32 = 1.0;

/// How much of density's variation inside the cloud is left at a range.
fn variation(layer: &Layer, t_m: f32) -> f32 {
    let [near_m, far_m] = VARIED_M;
    if t_m < far_m { layer.varied * (1.0 - smoothstep(near_m, far_m, t_m)) } else { 0.0 }
}

/// Clumps of two sizes at a place, 0 on the mean: more water where positive.
fn clumps(layer: &Layer, textures: &Textures, z: Vec2, height_m: f32) -> f32 {
    [1.0, layer.clumps_finer].iter().map(|times| fine(layer, textures, z, height_m, *times)).sum()
}

/// Density at a place in the cloud, `t_m` from the eye, over the layer's own: 1 on the mean, and 1 where it is far away.
pub fn varied(layer: &Layer, textures: &Textures, earth_m: f32, p: Vec3, height_m: f32, t_m: f32) -> f32 {
    let share = variation(layer, t_m);
    if share == 0.0 {
        return 1.0;
    }
    let z = stereographic(p, earth_m, earth_m + height_m);
    (1.0 + share * clumps(layer, textures, z, height_m)).clamp(LEAST_VARIED, 2.0 - LEAST_VARIED)
}

/// What clumps leave of the source's light at a place `t_m` from the eye: less where more water lies towards the light.
pub fn shaded(layer: &Layer, textures: &Textures, earth_m: f32, p: Vec3, height_m: f32, t_m: f32) -> f32 {
    let share = variation(layer, t_m);
    if share == 0.0 {
        return 1.0;
    }
    let towards = Vec3::from(layer.light_direction) * CLUMP_SHADE_M;
    let z = stereographic(p, earth_m, earth_m + height_m) + towards.truncate();
    (-CLUMP_SHADE * share * fine(layer, textures, z, height_m + towards.z, 1.0)).exp()
}
