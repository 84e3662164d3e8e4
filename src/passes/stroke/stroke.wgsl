// Stretches of lightning channels as lines of light through a Gaussian. Twin: twin.rs.

struct Segment {
    from_px: vec2<f32>,
    to_px: vec2<f32>,
    light: f32,
    sigma_px: f32,
    share_from: f32,
    share_to: f32,
    node: u32,
    pad: u32,
}

struct Strokes {
    scale: f32,
    pad0: f32,
    pad1: f32,
    pad2: f32,
}

@group(1) @binding(0) var<storage, read> strokes: Strokes;
@group(1) @binding(1) var<storage, read> segments: array<Segment>;
@group(1) @binding(2) var<storage, read> nodes: array<Node>;

const REACH: f32 = 4.0;
const SHORTEST_PX: f32 = 0.05;

struct Corner {
    @builtin(position) at: vec4<f32>,
    @location(0) @interpolate(flat) segment: u32,
}

fn along_of(segment: Segment) -> vec2<f32> {
    let d = segment.to_px - segment.from_px;
    let l = length(d);
    return select(vec2<f32>(1.0, 0.0), d / max(l, 1e-6), l > 1e-6);
}

@vertex
fn stroke_vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Corner {
    let segment = segments[instance];
    let along = along_of(segment);
    let side = vec2<f32>(-along.y, along.x);
    // Two triangles: 0 1 2 and 3 2 1.
    let corner = select(index, 6u - index, index > 2u);
    let reach = REACH * segment.sigma_px;
    let far = (corner & 1u) == 1u;
    let place = select(segment.from_px - along * reach, segment.to_px + along * reach, far)
        + side * select(-reach, reach, corner > 1u);
    let clip = vec2<f32>(2.0 * place.x / camera.width_px - 1.0, 1.0 - 2.0 * place.y / camera.height_px);
    return Corner(vec4<f32>(clip, 0.5, 1.0), instance);
}

// Abramowitz and Stegun 7.1.26: to 1.5e-7.
fn erf_of(x: f32) -> f32 {
    let t = 1.0 / (1.0 + 0.3275911 * abs(x));
    let poly = t * (0.254829592 + t * (-0.284496736 + t * (1.421413741 + t * (-1.453152027 + t * 1.061405429))));
    return sign(x) * (1.0 - poly * exp(-x * x));
}

@fragment
fn stroke_fragment(corner: Corner) -> @location(0) f32 {
    let segment = segments[corner.segment];
    let along = along_of(segment);
    let d = corner.at.xy - segment.from_px;
    let s = dot(d, along);
    let h = dot(d, vec2<f32>(-along.y, along.x));
    let l = distance(segment.from_px, segment.to_px);
    let unit = 0.70710678 / segment.sigma_px;
    var profile = 0.5641896 * unit * exp(-h * h * unit * unit);
    if l < SHORTEST_PX {
        let off = (s - 0.5 * l) * unit;
        profile *= 0.5641896 * unit * exp(-off * off);
    } else {
        profile *= 0.5 * (erf_of(s * unit) - erf_of((s - l) * unit)) / l;
    }
    let share = mix(segment.share_from, segment.share_to, clamp(s / max(l, 1e-6), 0.0, 1.0));
    let passed = mix(nodes[segment.node].passed, nodes[segment.node + 1u].passed, share);
    return min(segment.light * profile * passed * strokes.scale, BRIGHTEST);
}
