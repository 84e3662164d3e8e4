// Light inside a deck, slice by slice. Twin: twin.rs. One dispatch a slice: `down` from the top, then `up` from the base.

struct Light {
    direction: vec3<f32>,
    theta: f32,
    voxel_m: f32,
    voxel_height_m: f32,
    extinction_per_m: f32,
    inverse_edge: f32,
    pieces: u32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

struct Slice {
    z: u32,
}

const WIDTH: i32 = 256;
const HEIGHT: i32 = 32;
const AREA: i32 = 65536;
const ASYMMETRY: f32 = 0.85;
const FORWARD_SHARE: f32 = 0.55;
const DIFFUSE_RANGE: f32 = 5.0;

@group(0) @binding(0) var<storage, read> light: Light;
@group(0) @binding(1) var<storage, read> slice: Slice;
@group(0) @binding(2) var shape: texture_3d<f32>;
// Depths towards the light and the zenith above each voxel, slice by slice.
@group(0) @binding(3) var<storage, read_write> above: array<vec2<f32>>;
// The same below, for two slices in turn.
@group(0) @binding(4) var<storage, read_write> below: array<vec2<f32>>;
@group(0) @binding(5) var volume: texture_storage_3d<rgba8unorm, write>;

fn extinction_of(value: f32) -> f32 {
    return light.extinction_per_m * clamp((value - light.theta) * light.inverse_edge, 0.0, 1.0);
}

fn value_at(x: i32, y: i32, z: i32) -> f32 {
    return textureLoad(shape, vec3<i32>(x & (WIDTH - 1), y & (WIDTH - 1), z), 0).r;
}

fn index_of(x: i32, y: i32) -> i32 {
    return (x & (WIDTH - 1)) + (y & (WIDTH - 1)) * WIDTH;
}

fn bilinear_value(at: vec2<f32>, z: i32) -> f32 {
    let corner = floor(at);
    let f = at - corner;
    let c = vec2<i32>(corner);
    let low = mix(value_at(c.x, c.y, z), value_at(c.x + 1, c.y, z), f.x);
    let high = mix(value_at(c.x, c.y + 1, z), value_at(c.x + 1, c.y + 1, z), f.x);
    return mix(low, high, f.y);
}

fn depth(going_down: bool, x: i32, y: i32, z: i32) -> vec2<f32> {
    if going_down {
        return above[index_of(x, y) + z * AREA];
    }
    return below[index_of(x, y) + (z & 1) * AREA];
}

// Depths of slice `to` from its neighbour `source`; sign 1: the light comes from there, -1: it goes there.
fn step_from(x: i32, y: i32, source: i32, to: i32, sign: f32) -> vec2<f32> {
    let going_down = sign > 0.0;
    let slant = light.voxel_height_m / light.direction.z;
    let shift = sign * light.direction.xy * slant / light.voxel_m;
    let here = vec2<f32>(f32(x), f32(y));
    var along = 0.0;
    for (var piece = 0u; piece < light.pieces; piece++) {
        let s = (f32(piece) + 0.5) / f32(light.pieces);
        let at = here + s * shift;
        along += extinction_of(mix(bilinear_value(at, to), bilinear_value(at, source), s));
    }
    along *= slant / f32(light.pieces);
    let from_at = here + shift;
    let corner = floor(from_at);
    let f = from_at - corner;
    let c = vec2<i32>(corner);
    let low = mix(depth(going_down, c.x, c.y, source).x, depth(going_down, c.x + 1, c.y, source).x, f.x);
    let high = mix(depth(going_down, c.x, c.y + 1, source).x, depth(going_down, c.x + 1, c.y + 1, source).x, f.x);
    let from_light = mix(low, high, f.y);
    let around = depth(going_down, x - 1, y, source).y + depth(going_down, x + 1, y, source).y
        + depth(going_down, x, y - 1, source).y + depth(going_down, x, y + 1, source).y;
    let sky = 0.4 * depth(going_down, x, y, source).y + 0.15 * around;
    let value = 0.5 * (value_at(x, y, source) + value_at(x, y, to));
    return vec2<f32>(from_light + along, sky + extinction_of(value) * light.voxel_height_m);
}

fn slab(over: f32, under: f32, mu: f32) -> f32 {
    let total = over + under;
    let reduced = 1.0 - ASYMMETRY;
    let passed = ((2.0 / 3.0 + mu) + (2.0 / 3.0 - mu) * exp(-total / mu)) / (4.0 / 3.0 + reduced * total);
    let whole = mu * passed * (2.0 + 3.0 * reduced * under);
    return max(whole - exp(-over / mu), 0.0) * (1.0 - exp(-2.0 * reduced * total));
}

fn between(near: f32, far: f32) -> f32 {
    let reduced = 1.0 - ASYMMETRY;
    return (4.0 / 3.0) / (4.0 / 3.0 + reduced * (near + far)) * (2.0 + 3.0 * reduced * far);
}

@compute @workgroup_size(16, 16)
fn light_down(@builtin(global_invocation_id) id: vec3<u32>) {
    let x = i32(id.x);
    let y = i32(id.y);
    let z = i32(slice.z);
    var found = vec2<f32>(0.0);
    if z < HEIGHT - 1 {
        found = step_from(x, y, z + 1, z, 1.0);
    }
    above[index_of(x, y) + z * AREA] = found;
}

@compute @workgroup_size(16, 16)
fn light_up(@builtin(global_invocation_id) id: vec3<u32>) {
    let x = i32(id.x);
    let y = i32(id.y);
    let z = i32(slice.z);
    var under = vec2<f32>(0.0);
    if z > 0 {
        under = step_from(x, y, z - 1, z, -1.0);
    }
    below[index_of(x, y) + (z & 1) * AREA] = under;
    let over = above[index_of(x, y) + z * AREA];
    let value = value_at(x, y, z);
    let own = 0.5 * extinction_of(value) * light.voxel_height_m;
    let mu = light.direction.z;
    let forward = exp(-(1.0 - FORWARD_SHARE) * over.x);
    let diffuse = slab(over.x * mu, under.x * mu + own, mu) / DIFFUSE_RANGE;
    let from_sky = between(over.y, under.y + own) / DIFFUSE_RANGE;
    let from_ground = between(under.y + own, over.y) / DIFFUSE_RANGE;
    let shares = sqrt(clamp(vec4<f32>(forward, diffuse, from_sky, from_ground), vec4<f32>(0.0), vec4<f32>(1.0)));
    // Rounded as the twin rounds, which is not left to the device.
    textureStore(volume, vec3<i32>(x, y, z), floor(shares * 255.0 + 0.5) / 255.0);
}
