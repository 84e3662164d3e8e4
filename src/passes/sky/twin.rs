//! Twin of `sky.wgsl`: what is seen along a ray behind everything else, in cd/m2.

use super::table::{Texel, before_clouds, coordinates, sample};
use super::{Sky, Stars, stars};
use crate::passes::common::smoothstep;
use glam::Vec3;

/// Luminance of the air along a ray (to the ground below the horizon) and its transmittance.
pub fn air(sky: &Sky, table: &[Texel], direction: Vec3) -> (Vec3, f32) {
    let [r, g, b, passed] = sample(table, coordinates(direction, sky.horizon));
    (Vec3::new(r, g, b) * sky.table_scale, passed)
}

/// Luminance that an endless column of the air along a ray would have before the clouds: what haze before things tends to.
pub fn endless(sky: &Sky, table: &[Texel], direction: Vec3) -> Vec3 {
    match before_clouds(table) {
        Some(near) => air(sky, near, direction).0,
        None => {
            let (light, passed) = air(sky, table, direction);
            light / (1.0 - passed).max(0.02)
        }
    }
}

/// Light of the dark side of the moon from the Earth, as a share of the lit one's.
const EARTHSHINE: f32 = 0.000_3;

/// Luminance of the discs of sun and moon along a ray; the moon may stand before the sun.
pub fn discs(sky: &Sky, direction: Vec3) -> Vec3 {
    let moon = disc(direction, sky.moon_direction, sky.moon_cosine);
    let mut light = Vec3::from(sky.sun_luminance) * (disc(direction, sky.sun_direction, sky.sun_cosine) * (1.0 - moon));
    if moon > 0.0 {
        // Where on the moon's ball the ray ends, and how the sun stands there.
        let towards = Vec3::from(sky.moon_direction);
        let off = (direction - towards) / (2.0 * (1.0 - sky.moon_cosine)).sqrt();
        let normal = off - towards * (1.0 - off.length_squared()).max(0.0).sqrt();
        let lit = smoothstep(-0.05, 0.20, normal.dot(Vec3::from(sky.sun_direction)));
        light += Vec3::from(sky.moon_luminance) * (moon * (EARTHSHINE + lit));
    }
    light
}

/// Luminance of the stars along a ray, given what the air lets through of it.
pub fn starlight(stars: &Stars, sky: &Sky, direction: Vec3, passed: f32) -> Vec3 {
    let hidden = disc(direction, sky.moon_direction, sky.moon_cosine);
    stars::luminance(stars, stars::table(), direction) * (passed * (1.0 - hidden))
}

/// Share of a disc that a ray meets, with an edge of a tenth of its radius.
fn disc(direction: Vec3, towards: [f32; 3], cosine: f32) -> f32 {
    // 1 - cos by the chord, which f32 holds where the cosine itself is 1 - 1e-5.
    let chord = direction - Vec3::from(towards);
    let apart = 0.5 * chord.length_squared();
    1.0 - smoothstep(0.81 * (1.0 - cosine), 1.21 * (1.0 - cosine), apart)
}
