// Shadows of hills and mountains on the ground. Stands before ground.wgsl. Twin: hills.rs.

override HILLS: bool = true;

const HILL_STEPS: u32 = 40u;
const HILL_FIRST_NODES: f32 = 1.5;
const HILL_FARTHEST_M: f32 = 60000.0;
const HILL_SOFT: f32 = 0.012;
const HILL_COARSE: f32 = 0.4;

// Share of the source's light that hills let through to a point of the ground.
fn through_hills(light: vec3<f32>, up: vec3<f32>, p: vec3<f32>, height: f32, t: f32) -> f32 {
    let sine = dot(up, light);
    let fade = 1.0 - smoothstep(0.55, 0.65, sine);
    let own = relief_level(relief_place(p, camera.earth_m + height), t);
    let first = HILL_FIRST_NODES * relief.spacing_m * exp2(own);
    // As far as the lower edge of its softness has to rise over all ground.
    let last = clamp((relief.highest_m - height) / max(sine - HILL_SOFT, 0.01), 2.0 * first, max(HILL_FARTHEST_M, 2.0 * first));
    let growth = pow(last / first, 1.0 / f32(HILL_STEPS));
    // The least angle by which the ray clears the ground.
    var least = 1.0;
    var along = first;
    for (var k = 0u; k < HILL_STEPS; k++) {
        let q = p + light * along;
        // Over the sphere, without taking one large radius from another.
        let above = dot(q, q) + 2.0 * q.z * camera.earth_m;
        let height_here = above / (camera.earth_m + sqrt(camera.earth_m * camera.earth_m + above));
        let there = relief_place(q, camera.earth_m + height_here);
        let coarse = log2(max(HILL_COARSE * along * (growth - 1.0) / relief.spacing_m, 1.0));
        let read = min(max(relief_level(there, t), coarse), f32(LEVELS - 1u));
        least = min(least, (height_here - relief_at(there, read).x) / along);
        along *= growth;
    }
    return 1.0 - fade * (1.0 - smoothstep(-HILL_SOFT, HILL_SOFT, least));
}
