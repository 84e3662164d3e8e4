// Exposed linear light to 8-bit sRGB. Twin: twin.rs.

@group(0) @binding(0) var linear_light: texture_2d<f32>;

fn pcg3d(v_in: vec3<u32>) -> vec3<u32> {
    var v = v_in * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> vec3<u32>(16u);
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    return v;
}

const TOWARDS_MEAN: f32 = 0.2;
const HALF: f32 = 0.4946;

fn mean(v: vec3<f32>) -> f32 {
    return (v.x + v.y + v.z) * (1.0 / 3.0);
}

fn filmic(c: vec3<f32>) -> vec3<f32> {
    let x = mix(c, vec3<f32>(mean(c)), TOWARDS_MEAN) * (1.0 / HALF);
    let power = min(x * sqrt(x), vec3<f32>(1e6));
    let y = power / (power + 1.0);
    return clamp((y - TOWARDS_MEAN * mean(y)) * (1.0 / (1.0 - TOWARDS_MEAN)), vec3<f32>(0.0), vec3<f32>(1.0));
}

fn srgb(v: vec3<f32>) -> vec3<f32> {
    return select(1.055 * pow(v, vec3<f32>(1.0 / 2.4)) - 0.055, 12.92 * v, v <= vec3<f32>(0.0031308));
}

@vertex
fn tonemap_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.5, 1.0);
}

@fragment
fn tonemap_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<u32>(at.xy);
    let colour = textureLoad(linear_light, pixel, 0).rgb;
    let noise = vec3<f32>(pcg3d(vec3<u32>(pixel, 0u)) >> vec3<u32>(8u)) * (1.0 / 16777216.0) - 0.5;
    let code = srgb(filmic(max(colour, vec3<f32>(0.0)))) * 255.0 + noise + 0.5;
    // The target rounds to the nearest code; the twin truncates. Half a code was added for it, so take the floor here.
    return vec4<f32>(floor(clamp(code, vec3<f32>(0.0), vec3<f32>(255.0))) / 255.0, 1.0);
}
