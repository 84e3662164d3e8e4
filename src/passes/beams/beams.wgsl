// Light of the own ship's lamps that cloud and haze scatter once towards the eye. Twin: twin.rs.

struct Lamp {
    position_m: vec3<f32>,
    intensity_cd: f32,
    axis: vec3<f32>,
    narrowness: f32,
}

struct Beams {
    lamps: u32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
    lamp: array<Lamp, 4>,
    extinction_per_m: array<f32, 20>,
}

@group(1) @binding(0) var<storage, read> beams: Beams;

const LOOKS: u32 = 20u;
const NEAREST_M: f32 = 1.5;
const RATIO: f32 = 1.3417;
const TAKEN: f32 = 0.2775;
// A ray passes a lamp no nearer than its glass.
const GLASS_M2: f32 = 0.04;

// The phase function of droplets that the sun's light has in the deck.
fn droplets(cosine: f32) -> f32 {
    let f = vec2<f32>(0.75, -0.20);
    let d = 1.0 + f * f - 2.0 * f * cosine;
    let lobes = 1.5 * (1.0 - f * f) / (2.0 + f * f) * (1.0 + cosine * cosine) / (d * sqrt(d));
    return 0.07957747 * (0.96 * lobes.x + 0.04 * lobes.y);
}

// Intensity in a direction: a Gaussian of the angle from the axis.
fn shines(lamp: Lamp, towards: vec3<f32>) -> f32 {
    let away = towards - lamp.axis;
    return lamp.intensity_cd * exp(-dot(away, away) * lamp.narrowness);
}

fn beams_along(direction: vec3<f32>, end: f32) -> f32 {
    var sum = 0.0;
    var depth = 0.0;
    var begin = 0.0;
    for (var k = 0u; k < LOOKS; k++) {
        // Each look stands for the stretch between the middles, by ratio, to its neighbours.
        let t = NEAREST_M * pow(RATIO, f32(k));
        let until = min(t * sqrt(RATIO), end);
        let ds = max(until - begin, 0.0);
        let extinction = beams.extinction_per_m[k];
        let at = min(t, 0.5 * (begin + until));
        let before = depth + 0.5 * extinction * ds;
        for (var i = 0u; i < beams.lamps; i++) {
            let lamp = beams.lamp[i];
            let way = direction * at - lamp.position_m;
            let squared = max(dot(way, way), GLASS_M2);
            let distance = sqrt(squared);
            let towards = way / distance;
            // From the lamp it is as thick as from the eye, metre for metre.
            let passed = exp(-TAKEN * before * (1.0 + distance / max(at, 1e-3)));
            sum += shines(lamp, towards) * droplets(-dot(towards, direction)) * extinction * ds * passed / squared;
        }
        depth += extinction * ds;
        begin = max(until, begin);
    }
    return sum;
}

@vertex
fn beams_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return covering(index);
}

@fragment
fn beams_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let direction = ray_of(at.xy);
    let seen = beams_along(direction, ground_range(at.xy, direction.z)) * camera.exposure;
    return vec4<f32>(vec3<f32>(min(seen, BRIGHTEST)), 0.0);
}
