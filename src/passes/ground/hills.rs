//! Twin of `hills.wgsl`: shadows of hills and mountains on the ground.
//!
//! *What it is.* The share of the source's light that the ground itself lets through to a point of it. *How it is computed.* From
//! the point towards the light over the grids of the relief, by steps that grow with the way, at levels as coarse as the steps;
//! how near the ray passes over the ground, as an angle, tells how much of it is let through. So edges are soft, by more than
//! the sun's half degree: what is coarser than a step has no edge. Clouds and air are not shaded by hills.

use crate::passes::common::{Camera, smoothstep};
use crate::passes::relief::LEVELS;
use crate::passes::relief::field::{Grids, level, place};
use glam::Vec3;

/// Steps towards the light.
const STEPS: u32 = 40;
/// The first step is so many nodes long.
const FIRST_NODES: f32 = 1.5;
/// Ground farther away shades nothing, m.
const FARTHEST_M: f32 = 60_000.0;
/// Half the width of an edge, as an angle (radians).
const SOFT: f32 = 0.012;
/// Nodes of the level that a step reads, as a share of the step.
const COARSE: f32 = 0.4;
/// Sines of the elevations between which shadows fade: a source that stands higher has none that would be seen.
pub const FADE: [f32; 2] = [0.55, 0.65];

/// Share of the source's light that hills let through to a point `p` (east, north, height over the tangent plane), which stands at a height
/// over the sphere, whose normal to the sphere is `up` and whose range from the eye is `t_m`.
pub fn through(grids: &Grids, camera: &Camera, light: Vec3, up: Vec3, p: Vec3, height_m: f32, t_m: f32) -> f32 {
    let sine = up.dot(light);
    let fade = 1.0 - smoothstep(FADE[0], FADE[1], sine);
    let relief = grids.relief;
    let own = level(relief, place(relief, p, camera.earth_m, camera.earth_m + height_m), t_m);
    let first_m = FIRST_NODES * relief.spacing_m * own.exp2();
    // As far as the lower edge of its softness has to rise over all ground.
    let last_m =
        ((relief.highest_m - height_m) / (sine - SOFT).max(0.01)).clamp(2.0 * first_m, FARTHEST_M.max(2.0 * first_m));
    let growth = (last_m / first_m).powf(1.0 / STEPS as f32);
    // The least angle by which the ray clears the ground.
    let (mut least, mut along) = (1.0f32, first_m);
    for _ in 0..STEPS {
        let q = p + light * along;
        // Over the sphere, without taking one large radius from another.
        let above = q.length_squared() + 2.0 * q.z * camera.earth_m;
        let height = above / (camera.earth_m + (camera.earth_m * camera.earth_m + above).sqrt());
        let there = place(relief, q, camera.earth_m, camera.earth_m + height);
        let step_m = along * (growth - 1.0);
        let coarse = (COARSE * step_m / relief.spacing_m).max(1.0).log2();
        let read = level(relief, there, t_m).max(coarse).min((LEVELS - 1) as f32);
        least = least.min((height - grids.at(there, read).x) / along);
        along *= growth;
    }
    1.0 - fade * (1.0 - smoothstep(-SOFT, SOFT, least))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geo::terrain::LOWEST_M;
    use crate::passes::relief::window::{HEIGHT_UNIT_M, WIDTH};
    use crate::passes::relief::{LEVELS, Relief};

    const SPACING_M: f32 = 30.0;

    /// A ridge of a height from north to south, its crest 5 km west of the eye and 1.5 km from its feet.
    fn ridge(height_m: f32) -> (Relief, Vec<u32>) {
        let middle = (WIDTH / 2) as f32;
        let relief = Relief {
            a: [1.0, 0.0],
            c: [0.0; 2],
            stretch: [1.0; 2],
            spacing_m: SPACING_M,
            highest_m: height_m + 1.0,
            level: std::array::from_fn(|level| [middle, middle, SPACING_M * (1u32 << level) as f32, 1.0]),
        };
        let node = |i: usize| {
            let (level, x) = (i / (WIDTH * WIDTH), i % WIDTH);
            let east_m = (x as f32 - middle) * SPACING_M * (1u32 << level) as f32;
            let high = f64::from(height_m * (1.0 - (east_m + 5_000.0).abs() / 1_500.0).max(0.0));
            ((high - LOWEST_M) / HEIGHT_UNIT_M).round() as u32 | 32_768 << 16
        };
        (relief, (0..LEVELS * WIDTH * WIDTH).map(node).collect())
    }

    fn camera() -> Camera {
        Camera {
            right: [1.0, 0.0, 0.0],
            width_px: 64.0,
            up: [0.0, 0.0, 0.5],
            height_px: 32.0,
            forward: [0.0, 1.0, 0.0],
            eye_m: 1_000.0,
            earth_m: 6_371_000.0,
            exposure: 1.0,
            haze_per_m: 0.0,
            air_per_m: 0.0,
        }
    }

    #[test]
    fn a_ridge_throws_a_shadow_as_long_as_the_sun_is_low() {
        let (relief, nodes) = ridge(500.0);
        let grids = Grids { relief: &relief, nodes: &nodes, lights: None };
        let at = |east_m: f32, elevation_deg: f32, from_west: f32| {
            let (sine, cosine) = elevation_deg.to_radians().sin_cos();
            let light = Vec3::new(-from_west * cosine, 0.0, sine);
            let p = Vec3::new(east_m, 0.0, -east_m * east_m / (2.0 * 6_371_000.0));
            let up = (p + Vec3::new(0.0, 0.0, 6_371_000.0)).normalize();
            through(&grids, &camera(), light, up, p, 0.0, 1_200.0)
        };
        for elevation_deg in [3.0f32, 6.0, 9.0] {
            // From the crest, whose height long steps see as that of a mean over their way.
            let length_m = 500.0 / elevation_deg.to_radians().tan();
            let [near, far] = [0.5, 1.3].map(|share| at(-5_000.0 + share * length_m, elevation_deg, 1.0));
            assert!(near < 0.05 && far > 0.95, "{elevation_deg}: {near} {far}");
            assert_eq!(at(-5_000.0 + 0.5 * length_m, elevation_deg, -1.0), 1.0, "the sun on the other side");
        }
        // A sun as high as the shadows end has none.
        assert_eq!(at(-3_400.0, 42.0, 1.0), 1.0);
        // It goes without a step while the sun rises by a twentieth of a degree each: an edge is 1.4 degrees wide, and where steps fall on the
        // slope moves it by as much again.
        let over: Vec<f32> = (0..400).map(|k| at(-1_000.0, 1.0 + 0.05 * k as f32, 1.0)).collect();
        let step = over.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f32::max);
        assert!(over[0] < 0.01 && over[399] == 1.0 && step < 0.25, "{step}");
    }

    #[test]
    fn level_ground_shades_nothing() {
        let (relief, nodes) = ridge(0.0);
        let grids = Grids { relief: &relief, nodes: &nodes, lights: None };
        for elevation_deg in [1.5f32, 3.0, 30.0] {
            let (sine, cosine) = elevation_deg.to_radians().sin_cos();
            let found = through(&grids, &camera(), Vec3::new(0.0, cosine, sine), Vec3::Z, Vec3::ZERO, 0.0, 1_000.0);
            assert_eq!(found, 1.0, "{elevation_deg}");
        }
    }
}
