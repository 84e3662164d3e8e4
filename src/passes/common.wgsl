// What several passes share: the camera, the haze, charts. Twin: common.rs. Stands before every other shader.

struct Camera {
    right: vec3<f32>,
    width_px: f32,
    up: vec3<f32>,
    height_px: f32,
    forward: vec3<f32>,
    eye_m: f32,
    earth_m: f32,
    exposure: f32,
    haze_per_m: f32,
    air_per_m: f32,
}

struct Sky {
    sun_direction: vec3<f32>,
    sun_cosine: f32,
    sun_luminance: vec3<f32>,
    horizon: f32,
    moon_direction: vec3<f32>,
    moon_cosine: f32,
    moon_luminance: vec3<f32>,
    table_scale: f32,
}

struct Chart {
    tile_origin_m: vec2<f32>,
    map_origin: vec2<f32>,
    a: vec2<f32>,
    c: vec2<f32>,
    w: vec3<f32>,
    zone: f32,
    warp: vec4<f32>,
}

struct Flash {
    position_m: vec3<f32>,
    intensity: f32,
}

// A place in the sky, and how much of its light comes through the clouds to the eye: of the passes for lightning.
struct Node {
    position_m: vec3<f32>,
    passed: f32,
}

const TILE_M: f32 = 16000.0;
// The waves that move the tile, as in clouds::warp.
const WARP_EAST: vec4<f32> = vec4<f32>(1.308378e-5, 3.655636e-6, -7.800198e-6, -1.402771e-5);
const WARP_NORTH: vec4<f32> = vec4<f32>(8.496709e-6, 1.364302e-5, 1.599278e-5, 9.461809e-6);
const WARP_EASTWARD_M: vec4<f32> = vec4<f32>(-708.0, -1255.7, -1168.4, -727.0);
const WARP_NORTHWARD_M: vec4<f32> = vec4<f32>(1090.3, 336.5, -569.9, -1077.7);
const HAZE_SCALE_M: f32 = 1200.0;
const AIR_SCALE_M: f32 = 8000.0;
const FAR: f32 = 1e30;
const MAP_TILE_M: f32 = 404941.88;
const MAP_ROTATION: vec2<f32> = vec2<f32>(0.8960525, 0.4439481);
const FLASH_CAP_M: f32 = 200.0;
const FLASH_COLOUR: vec3<f32> = vec3<f32>(0.80, 0.90, 1.25);
const RIM: f32 = 0.94;
// Brightest exposed value: an f16 target holds 65504.
const BRIGHTEST: f32 = 60000.0;

@group(0) @binding(0) var<storage, read> camera: Camera;
@group(0) @binding(1) var<storage, read> sky: Sky;
@group(0) @binding(2) var sky_table: texture_2d<f32>;
@group(0) @binding(3) var clamped: sampler;
@group(0) @binding(4) var map: texture_2d<f32>;
@group(0) @binding(5) var repeated: sampler;
// The deck by itself, exposed: light, and what it hides.
@group(0) @binding(6) var deck_image: texture_2d<f32>;

// Range at which each pixel's ray meets the ground, where that is more than a sphere.
@group(0) @binding(7) var relief_image: texture_2d<f32>;
override TERRAIN: bool = false;

const OPAQUE: f32 = 0.004;

fn deck_over(pixel: vec2<f32>) -> vec4<f32> {
    return textureSampleLevel(deck_image, clamped, pixel / vec2<f32>(camera.width_px, camera.height_px), 0.0);
}

fn ray_of(pixel: vec2<f32>) -> vec3<f32> {
    let sx = 2.0 * pixel.x / camera.width_px - 1.0;
    let sy = 1.0 - 2.0 * pixel.y / camera.height_px;
    return normalize(camera.forward + camera.right * sx + camera.up * sy);
}

fn height_at(up: f32, t: f32) -> f32 {
    let r = camera.earth_m + camera.eye_m;
    let d = 2.0 * t * r * up + t * t;
    return camera.eye_m + d / (sqrt(max(r * r + d, 0.0)) + r);
}

// Ranges at which a ray crosses the shell at a height: going down and going up; FAR where it does not.
fn crossings(up: f32, height: f32) -> vec2<f32> {
    let b = (camera.earth_m + camera.eye_m) * up;
    let c = (camera.eye_m - height) * (2.0 * camera.earth_m + camera.eye_m + height);
    let disc = b * b - c;
    if disc < 0.0 {
        return vec2<f32>(FAR, FAR);
    }
    let root = sqrt(disc);
    if c > 0.0 {
        if b >= 0.0 {
            return vec2<f32>(FAR, FAR);
        }
        return vec2<f32>(c / (root - b), root - b);
    }
    if b > 0.0 {
        return vec2<f32>(FAR, -c / (root + b));
    }
    return vec2<f32>(FAR, root - b);
}

// Range at which the ray of a pixel meets the ground; FAR where it does not.
fn ground_range(pixel: vec2<f32>, up: f32) -> f32 {
    if TERRAIN {
        let size = vec2<f32>(textureDimensions(relief_image));
        let share = pixel / vec2<f32>(camera.width_px, camera.height_px);
        let at = min(floor(share * size), size - 1.0);
        return textureLoad(relief_image, vec2<u32>(at), 0).r;
    }
    return crossings(up, 0.0).x;
}

fn mean_density(a: f32, b: f32, scale: f32) -> f32 {
    let d = abs(b - a) / scale;
    let lower = exp(-min(a, b) / scale);
    if d < 1e-2 {
        return lower * (1.0 - 0.5 * d);
    }
    return lower * (1.0 - exp(-d)) / d;
}

fn air_transmittance(height: f32, t: f32) -> f32 {
    let depth = camera.haze_per_m * mean_density(camera.eye_m, height, HAZE_SCALE_M)
        + camera.air_per_m * mean_density(camera.eye_m, height, AIR_SCALE_M);
    return exp(-depth * t);
}

fn complex_mul(a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
}

// Displacement from the eye's ground point in a chart of a point with stereographic coordinate z.
fn displacement(chart_a: vec2<f32>, chart_c: vec2<f32>, z: vec2<f32>) -> vec2<f32> {
    let one_minus = vec2<f32>(1.0, 0.0) - complex_mul(chart_c, z);
    let inverse = vec2<f32>(one_minus.x, -one_minus.y) / dot(one_minus, one_minus);
    return complex_mul(complex_mul(chart_a, z), inverse);
}

// Place in the tile, in periods, of a point displaced in a chart whose waves and origin are given.
fn tile_of(origin_m: vec2<f32>, warp: vec4<f32>, moved: vec2<f32>) -> vec2<f32> {
    let phase = warp + WARP_EAST * moved.x + WARP_NORTH * moved.y;
    let f = phase - floor(phase + 0.5);
    let wave = f * (8.0 - 16.0 * abs(f));
    // Negative phases: no waves.
    let waves = select(1.0, 0.0, warp.x < 0.0);
    let shift = waves * vec2<f32>(dot(wave, WARP_EASTWARD_M), dot(wave, WARP_NORTHWARD_M));
    return (origin_m + moved + shift) * (1.0 / TILE_M);
}

fn stereographic(p: vec3<f32>, radius: f32) -> vec2<f32> {
    return p.xy * (2.0 * camera.earth_m / (radius + camera.earth_m + p.z));
}

fn map_coordinates(chart_m: vec2<f32>) -> vec2<f32> {
    let r = MAP_ROTATION;
    return vec2<f32>(r.x * chart_m.x - r.y * chart_m.y, r.y * chart_m.x + r.x * chart_m.y) / MAP_TILE_M;
}

// What the sky's table tells of a ray, in one of its pairs of discs.
fn air_in(direction: vec3<f32>, pair: f32, pairs: f32) -> vec4<f32> {
    let over = direction.z - sky.horizon;
    let span = select(1.0 + sky.horizon, 1.0 - sky.horizon, over >= 0.0);
    let s = sqrt(min(abs(over) / span, 1.0));
    let disc = direction.xy * ((1.0 - s) * RIM / max(length(direction.xy), 1e-6));
    let u = 0.25 + 0.25 * disc.x + select(0.5, 0.0, over >= 0.0);
    let v = (0.5 + 0.5 * disc.y + pair) / pairs;
    let found = textureSampleLevel(sky_table, clamped, vec2<f32>(u, v), 0.0);
    return vec4<f32>(found.rgb * sky.table_scale, found.a);
}

// One, and under clouds a second one for the air before them. A pair is twice as wide as high.
fn air_pairs() -> f32 {
    let size = vec2<f32>(textureDimensions(sky_table));
    return 2.0 * size.y / size.x;
}

// Luminance of the air along a ray and its transmittance.
fn air_along(direction: vec3<f32>) -> vec4<f32> {
    return air_in(direction, 0.0, air_pairs());
}

// Luminance that an endless column of the air along a ray would have.
fn endless_air(air: vec4<f32>) -> vec3<f32> {
    return air.rgb / max(1.0 - air.a, 0.02);
}

// The same of the air before the clouds.
fn air_before_clouds(direction: vec3<f32>) -> vec3<f32> {
    let pairs = air_pairs();
    if pairs > 1.5 {
        return air_in(direction, 1.0, pairs).rgb;
    }
    return endless_air(air_along(direction));
}

// A triangle that covers the picture.
fn covering(index: u32) -> vec4<f32> {
    return vec4<f32>(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.5, 1.0);
}
