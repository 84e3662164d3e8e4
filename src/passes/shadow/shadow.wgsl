// What one layer lets through of the light: to the ground that each pixel sees, and to the top of a lower layer.
// Stands behind field.wgsl. Twins: twin.rs, shade.rs.

struct Shadow {
    height_m: f32,
    theta_low: f32,
    inverse_step: f32,
    at_m: f32,
    near_m: f32,
    span: f32,
    pad0: f32,
    pad1: f32,
}

const LAYERS: f32 = 8.0;
const ENTRIES: f32 = 24.0;
const COARSEST: f32 = 8.0;
const TEXEL_M: f32 = 62.5;
const DISC_RAD: f32 = 0.0093;
const SHADE_WIDTH: f32 = 256.0;

@group(2) @binding(0) var<storage, read> shadow: Shadow;
@group(2) @binding(1) var columns0: texture_2d_array<f32>;
@group(2) @binding(2) var columns1: texture_2d_array<f32>;
@group(2) @binding(3) var columns2: texture_2d_array<f32>;
// Repeating, linear between texels and between levels.
@group(2) @binding(4) var levels: sampler;

fn four_thetas(chart: u32, tile: vec2<f32>, part: u32, level: f32) -> vec4<f32> {
    if SEVERAL_CHARTS {
        if chart == 1u {
            return textureSampleLevel(columns1, levels, tile, part, level);
        }
        if chart == 2u {
            return textureSampleLevel(columns2, levels, tile, part, level);
        }
    }
    return textureSampleLevel(columns0, levels, tile, part, level);
}

// The transmittance between the two entries around the theta that rules at a place of a chart.
fn column(chart: u32, z: vec2<f32>, shift: f32, level: f32) -> f32 {
    let moved = displacement(layer.chart[chart].a, layer.chart[chart].c, z);
    let tile = tile_of(layer.chart[chart].tile_origin_m, layer.chart[chart].warp, moved);
    let place = layer.chart[chart].map_origin + map_coordinates(moved);
    let theta = layer.theta + layer.patchiness * textureSampleLevel(map, repeated, place, 0.0).r + shift;
    let entry = clamp((theta - shadow.theta_low) * shadow.inverse_step, 0.0, ENTRIES);
    let part = min(floor(entry * (1.0 / 3.0)), LAYERS - 1.0);
    let near = max(1.0 - abs(entry - 3.0 * part - vec4<f32>(0.0, 1.0, 2.0, 3.0)), vec4<f32>(0.0));
    return dot(four_thetas(chart, tile, u32(part), level), near);
}

// What the layer lets through to a point at a height, as a mean over a footprint.
fn through(p: vec3<f32>, height: f32, footprint: f32) -> f32 {
    let b = dot(p + vec3<f32>(0.0, 0.0, camera.earth_m), layer.light_direction);
    // Nor has ground above the layer's middle any of its shadow.
    if b <= 0.0 || height >= shadow.height_m {
        return 1.0;
    }
    // Along the light to the layer's middle.
    let c = (shadow.height_m - height) * (2.0 * camera.earth_m + shadow.height_m + height);
    let distance = c / (b + sqrt(b * b + c));
    let q = p + layer.light_direction * distance;
    let radius = camera.earth_m + shadow.height_m;
    let z = stereographic(q, radius);
    var shift = 0.0;
    if REGIONS {
        shift = region_shift(z);
        if shift >= 1.0 {
            return 1.0;
        }
    }
    let blur = length(vec2<f32>(distance * DISC_RAD, footprint));
    let level = min(log2(max(blur * (1.0 / TEXEL_M), 1.0)), COARSEST);
    var found = 0.0;
    if SEVERAL_CHARTS {
        let weights = chart_weights((q + vec3<f32>(0.0, 0.0, camera.earth_m)) / radius);
        if weights.x > 0.0 {
            found += weights.x * column(0u, z, shift, level);
        }
        if weights.y > 0.0 {
            found += weights.y * column(1u, z, shift, level);
        }
        if weights.z > 0.0 {
            found += weights.z * column(2u, z, shift, level);
        }
    } else {
        found = column(0u, z, shift, level);
    }
    return found;
}

@vertex
fn shadow_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return covering(index);
}

@fragment
fn shadow_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let direction = ray_of(at.xy);
    let t = ground_range(at.xy, direction.z);
    var passed = 1.0;
    // Pixels without ground, and ground that the deck hides, need no shadow.
    if t < FAR && 1.0 - deck_over(at.xy).a >= OPAQUE {
        let p = direction * t + vec3<f32>(0.0, 0.0, camera.eye_m);
        let from_centre = p + vec3<f32>(0.0, 0.0, camera.earth_m);
        let pixel = 2.0 * length(camera.up) / camera.height_px;
        let footprint = t * pixel / sqrt(max(-dot(direction, normalize(from_centre)), 1e-3));
        var height = 0.0;
        if TERRAIN {
            height = height_at(direction.z, t);
        }
        passed = through(p, height, footprint);
    }
    return vec4<f32>(passed);
}

// The map of the shade on a lower layer: what this layer lets through to its top.
@vertex
fn shade_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return covering(index);
}

@fragment
fn shade_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let place = at.xy * (2.0 / SHADE_WIDTH) - 1.0;
    let share = length(place);
    let distance = shadow.near_m * (exp(share / shadow.span) - 1.0);
    // Stereographic coordinates as a tangent of half the angle at the Earth's centre.
    let tangent = place * (distance / (max(share, 1e-6) * 2.0 * camera.earth_m));
    let fall = 2.0 / (1.0 + dot(tangent, tangent));
    let radius = camera.earth_m + shadow.at_m;
    let p = vec3<f32>(tangent * (fall * radius), shadow.at_m - radius * fall * dot(tangent, tangent));
    let texel = (distance + shadow.near_m) * (2.0 / (SHADE_WIDTH * shadow.span));
    return vec4<f32>(through(p, shadow.at_m, texel));
}
