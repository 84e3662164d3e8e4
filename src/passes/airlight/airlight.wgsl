// Light of lightning that the air scatters once towards the eye. Twin: twin.rs.

struct Source {
    position_m: vec3<f32>,
    intensity_cd: f32,
    width_m: f32,
    node: u32,
    pad0: f32,
    pad1: f32,
}

struct Airlight {
    scale: f32,
    sources: u32,
    pad0: f32,
    pad1: f32,
}

@group(1) @binding(0) var<storage, read> airlight: Airlight;
@group(1) @binding(1) var<storage, read> sources: array<Source>;
@group(1) @binding(2) var<storage, read> nodes: array<Node>;

const AIRLIGHT_STEPS: u32 = 12u;
const FARTHEST_M: f32 = 150000.0;
const HAZE_ASYMMETRY: f32 = 0.76;
const HAZE_ALBEDO: f32 = 0.9;

fn haze_phase(cosine: f32) -> f32 {
    let f = HAZE_ASYMMETRY;
    let d = 1.0 + f * f - 2.0 * f * cosine;
    return 0.07957747 * 1.5 * (1.0 - f * f) / (2.0 + f * f) * (1.0 + cosine * cosine) / (d * sqrt(d));
}

fn scattered(direction: vec3<f32>, end: f32, source: Source) -> f32 {
    let away = source.position_m - vec3<f32>(0.0, 0.0, camera.eye_m);
    let nearest = dot(away, direction);
    let off = away - direction * nearest;
    let d = sqrt(dot(off, off) + source.width_m * source.width_m);
    let first = atan(-nearest / d);
    let width = (atan((end - nearest) / d) - first) / f32(AIRLIGHT_STEPS);
    var sum = 0.0;
    for (var i = 0u; i < AIRLIGHT_STEPS; i++) {
        let angle = first + (f32(i) + 0.5) * width;
        let cosine = max(cos(angle), 1e-4);
        let sine = sin(angle);
        let t = clamp(nearest + d * sine / cosine, 0.0, end);
        let height = max(height_at(direction.z, t), 0.0);
        let haze = camera.haze_per_m * exp(-height / HAZE_SCALE_M);
        let air = camera.air_per_m * exp(-height / AIR_SCALE_M);
        let towards = HAZE_ALBEDO * haze * haze_phase(-sine) + air * 0.0596831 * (1.0 + sine * sine);
        sum += towards * exp(-(haze + air) * d / cosine) * air_transmittance(height, t);
    }
    return source.intensity_cd / d * width * sum;
}

@vertex
fn airlight_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return covering(index);
}

@fragment
fn airlight_fragment(@builtin(position) at: vec4<f32>) -> @location(0) f32 {
    let direction = ray_of(at.xy);
    let end = min(crossings(direction.z, 0.0).x, FARTHEST_M);
    var sum = 0.0;
    for (var i = 0u; i < airlight.sources; i++) {
        sum += scattered(direction, end, sources[i]) * nodes[sources[i].node].passed;
    }
    return min(sum * airlight.scale, BRIGHTEST);
}
