// Glow of the strokes: a pyramid of images going down, and its levels added coming up. Twin: twin.rs.

struct Glow {
    weight: f32,
    gain: f32,
    air_gain: f32,
    pad: f32,
}

@group(0) @binding(0) var<storage, read> glow: Glow;
// Going down: the finer level. Coming up: the level's own image.
@group(0) @binding(1) var fine: texture_2d<f32>;
// Coming up: what the coarser levels have gathered.
@group(0) @binding(2) var coarse: texture_2d<f32>;
// In the last step: light scattered in the air.
@group(0) @binding(3) var scattered: texture_2d<f32>;

const GLOW_COLOUR: vec3<f32> = vec3<f32>(0.80, 0.90, 1.25);
// Brightest exposed value that is added: with what is behind it stays below what f16 holds.
const BRIGHTEST_ADDED: f32 = 5000.0;

// Nothing lies beyond an image's rim.
fn fine_at(at: vec2<i32>) -> f32 {
    let size = vec2<i32>(textureDimensions(fine));
    let inside = all(at >= vec2<i32>(0)) && all(at < size);
    return select(0.0, textureLoad(fine, clamp(at, vec2<i32>(0), size - 1), 0).r, inside);
}

fn coarse_at(at: vec2<i32>) -> f32 {
    let size = vec2<i32>(textureDimensions(coarse));
    let inside = all(at >= vec2<i32>(0)) && all(at < size);
    return select(0.0, textureLoad(coarse, clamp(at, vec2<i32>(0), size - 1), 0).r, inside);
}

fn row_of_fine(x: i32, y: i32) -> f32 {
    return 0.125 * (fine_at(vec2<i32>(x - 1, y)) + fine_at(vec2<i32>(x + 2, y)))
        + 0.375 * (fine_at(vec2<i32>(x, y)) + fine_at(vec2<i32>(x + 1, y)));
}

// The coarser level at a pixel of the finer one: three quarters of the texel that it lies in, a quarter of the nearest other.
fn spread(at: vec2<i32>) -> f32 {
    let near = at >> vec2<u32>(1u);
    let other = near + select(vec2<i32>(-1), vec2<i32>(1), (at & vec2<i32>(1)) == vec2<i32>(1));
    return 0.5625 * coarse_at(near) + 0.1875 * (coarse_at(vec2<i32>(other.x, near.y)) + coarse_at(vec2<i32>(near.x, other.y)))
        + 0.0625 * coarse_at(other);
}

fn scattered_at(at: vec2<i32>) -> f32 {
    let size = vec2<i32>(textureDimensions(scattered));
    return textureLoad(scattered, clamp(at, vec2<i32>(0), size - 1), 0).r;
}

// Light scattered in the air, smooth between the texels of its image, which has the picture's sides.
fn air_at(pixel: vec2<f32>) -> f32 {
    let place = pixel * vec2<f32>(textureDimensions(scattered)) / vec2<f32>(textureDimensions(fine)) - 0.5;
    let corner = floor(place);
    let f = place - corner;
    let c = vec2<i32>(corner);
    let low = mix(scattered_at(c), scattered_at(c + vec2<i32>(1, 0)), f.x);
    let high = mix(scattered_at(c + vec2<i32>(0, 1)), scattered_at(c + vec2<i32>(1, 1)), f.x);
    return mix(low, high, f.y);
}

fn covering(index: u32) -> vec4<f32> {
    return vec4<f32>(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.5, 1.0);
}

@vertex
fn glow_down_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return covering(index);
}

@vertex
fn glow_up_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return covering(index);
}

@vertex
fn glow_last_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return covering(index);
}

@fragment
fn glow_down_fragment(@builtin(position) at: vec4<f32>) -> @location(0) f32 {
    let x = 2 * i32(at.x);
    let y = 2 * i32(at.y);
    return 0.125 * (row_of_fine(x, y - 1) + row_of_fine(x, y + 2)) + 0.375 * (row_of_fine(x, y) + row_of_fine(x, y + 1));
}

@fragment
fn glow_up_fragment(@builtin(position) at: vec4<f32>) -> @location(0) f32 {
    let here = vec2<i32>(at.xy);
    return glow.weight * fine_at(here) + spread(here);
}

@fragment
fn glow_last_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let here = vec2<i32>(at.xy);
    let light = (glow.weight * fine_at(here) + spread(here)) * glow.gain + air_at(at.xy) * glow.air_gain;
    return vec4<f32>(min(GLOW_COLOUR * light, vec3<f32>(BRIGHTEST_ADDED)), 0.0);
}
