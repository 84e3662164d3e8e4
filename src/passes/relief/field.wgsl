// Height, slope and distance from the shore at a point around the eye, read from the window's grids. Twin: field.rs.

struct Relief {
    a: vec2<f32>,
    c: vec2<f32>,
    stretch: vec2<f32>,
    spacing_m: f32,
    highest_m: f32,
    level: array<vec4<f32>, 8>,
}

const LEVELS: u32 = 8u;
const WIDTH: u32 = 384u;
const LEVEL_NODES: f32 = 76.0;
const ITSELF: f32 = 0.6;
const HEIGHT_UNIT_M: f32 = 0.14496071;
const LOWEST_M: f32 = -500.0;

@group(2) @binding(0) var<storage, read> relief: Relief;
@group(2) @binding(1) var<storage, read> nodes: array<u32>;

// A place of the chart, from the eye, metres.
fn relief_place(p: vec3<f32>, radius: f32) -> vec2<f32> {
    return displacement(relief.a, relief.c, stereographic(p, radius) * relief.stretch);
}

// Which level a place is read from, as a number between two levels.
fn relief_level(place_m: vec2<f32>, range: f32) -> f32 {
    let nodes = max(length(place_m), 0.25 * range) / (LEVEL_NODES * relief.spacing_m);
    return min(log2(max(nodes, 1.0)), f32(LEVELS - 1u));
}

fn relief_node(i: u32) -> vec2<f32> {
    let bits = nodes[i];
    return vec2<f32>(f32(bits & 0xffffu), f32(bits >> 16u));
}

fn relief_of_level(level: u32, place_m: vec2<f32>) -> vec2<f32> {
    let lies = relief.level[level];
    let at = clamp(lies.xy + place_m / lies.z, vec2<f32>(0.0), vec2<f32>(f32(WIDTH - 1u) - 0.001));
    let low = floor(at);
    let f = at - low;
    let first = level * WIDTH * WIDTH + u32(low.y) * WIDTH + u32(low.x);
    let south = mix(relief_node(first), relief_node(first + 1u), f.x);
    let north = mix(relief_node(first + WIDTH), relief_node(first + WIDTH + 1u), f.x);
    let found = mix(south, north, f.y);
    return vec2<f32>(found.x * HEIGHT_UNIT_M + LOWEST_M, (found.y - 32768.0) * lies.w);
}

// Height and distance from the shore (above 0 on land) at a place of the chart.
fn relief_at(place_m: vec2<f32>, level: f32) -> vec2<f32> {
    let low = min(u32(level), LEVELS - 1u);
    let share = max((level - f32(low) - ITSELF) * (1.0 / (1.0 - ITSELF)), 0.0);
    var found = relief_of_level(low, place_m);
    if share > 0.0 && low + 1u < LEVELS {
        found = mix(found, relief_of_level(low + 1u, place_m), share);
    }
    return found;
}

// Rise of the ground to the east and to the north, in the eye's axes, over its level's spacing.
fn relief_slope(place_m: vec2<f32>, level: f32) -> vec2<f32> {
    let step_m = relief.spacing_m * exp2(level);
    let east = vec2<f32>(step_m, 0.0);
    let north = vec2<f32>(0.0, step_m);
    let along = vec2<f32>(
        relief_at(place_m + east, level).x - relief_at(place_m - east, level).x,
        relief_at(place_m + north, level).x - relief_at(place_m - north, level).x,
    ) * (0.5 / step_m);
    let a = relief.a;
    return vec2<f32>(a.x * along.x + a.y * along.y, a.x * along.y - a.y * along.x);
}
