//! Twin of `sky.wgsl`: what is seen along a ray behind everything else, in cd/m2.

use super::Sky;
use super::table::{Texel, coordinates, sample};
use crate::passes::common::smoothstep;
use glam::Vec3;

/// Luminance of the air along a ray (to the ground below the horizon) and its transmittance.
pub fn air(sky: &Sky, table: &[Texel], direction: Vec3) -> (Vec3, f32) {
    let [r, g, b, passed] = sample(table, coordinates(direction, sky.horizon));
    (Vec3::new(r, g, b) * sky.table_scale, passed)
}

/// Luminance of the discs of sun and moon along a ray.
pub fn discs(sky: &Sky, direction: Vec3) -> Vec3 {
    disc(direction, sky.sun_direction, sky.sun_cosine) * Vec3::from(sky.sun_luminance)
        + disc(direction, sky.moon_direction, sky.moon_cosine) * Vec3::from(sky.moon_luminance)
}

/// Share of a disc that a ray meets, with an edge of a tenth of its radius.
fn disc(direction: Vec3, towards: [f32; 3], cosine: f32) -> f32 {
    // 1 - cos by the chord, which f32 holds where the cosine itself is 1 - 1e-5.
    let chord = direction - Vec3::from(towards);
    let apart = 0.5 * chord.length_squared();
    1.0 - smoothstep(0.81 * (1.0 - cosine), 1.21 * (1.0 - cosine), apart)
}
