// The deck as instanced geometry: slabs between slices and between rings, near to far. Twin: twin.rs.

// Part of the horizon that the picture sees: first azimuth, step, and the number of steps.
struct Sector {
    first_rad: f32,
    step_rad: f32,
}

@group(2) @binding(0) var<storage, read> sector: Sector;

struct Passed {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) kind: u32,
    @location(1) @interpolate(flat) shells: vec4<f32>,
}

@vertex
fn deck_vertex(
    @builtin(vertex_index) index: u32,
    @location(0) kind: u32,
    @location(1) near_m: f32,
    @location(2) far_m: f32,
    @location(3) inner_m: f32,
    @location(4) outer_m: f32,
) -> Passed {
    let azimuth = sector.first_rad + f32(index >> 1u) * sector.step_rad;
    let upper = (index & 1u) == 1u;
    let ring = (kind & 3u) == 2u;
    let distance = select(select(inner_m, outer_m, upper), outer_m, ring);
    let height = select(far_m, select(near_m, far_m, upper), ring);
    let r = camera.earth_m + height;
    let z = height - distance * distance / (sqrt(max(r * r - distance * distance, 0.0)) + r) - camera.eye_m;
    let v = vec3<f32>(sin(azimuth) * distance, cos(azimuth) * distance, z);
    // In a lopsided frustum `forward` leans from the picture's axis towards its middle.
    let lean_x = dot(camera.forward, camera.right) / dot(camera.right, camera.right);
    let lean_y = dot(camera.forward, camera.up) / dot(camera.up, camera.up);
    let w = dot(v, camera.forward - lean_x * camera.right - lean_y * camera.up);
    let x = dot(v, camera.right) / dot(camera.right, camera.right) - lean_x * w;
    let y = dot(v, camera.up) / dot(camera.up, camera.up) - lean_y * w;
    var out: Passed;
    out.position = vec4<f32>(x, y, 0.5 * w, w);
    out.kind = kind;
    out.shells = vec4<f32>(near_m, far_m, inner_m, outer_m);
    return out;
}

// Whether rings carry the ray at a range; slabs carry what follows.
fn carried(up: f32, flat_share: f32, t: f32) -> bool {
    let r = camera.earth_m + camera.eye_m;
    let sine = max(abs((r * up + t) / (camera.earth_m + height_at(up, t))), 1e-4);
    let slice_ds = layer.spacing_m / sine;
    return slice_ds > t * RING_SHARE + RING_SLICES * layer.spacing_m && t * flat_share < layer.ring_last_m;
}

// The range between two at which slabs take over from rings.
fn switch_between(up: f32, flat_share: f32, near_t: f32, far_t: f32) -> f32 {
    var near = near_t;
    var far = far_t;
    for (var i = 0u; i < HALVINGS; i++) {
        let middle = 0.5 * (near + far);
        if carried(up, flat_share, middle) {
            near = middle;
        } else {
            far = middle;
        }
    }
    return 0.5 * (near + far);
}

// The piece of the pixel's ray that an instance stands for, as ranges; empty (far before near) where there is none.
fn piece_of(kind_bits: u32, shells: vec4<f32>, up: f32, flat_share: f32) -> vec2<f32> {
    let r = camera.earth_m + camera.eye_m;
    let lowest_t = max(-r * up, 0.0);
    let kind = kind_bits & 3u;
    let ring = kind == 2u;
    let slab = kind == 0u;
    var falling = (kind_bits & 4u) != 0u;
    var far_t = shells.w / max(flat_share, 1e-4);
    if ring {
        falling = far_t < lowest_t;
    } else {
        let t = crossings(up, shells.y);
        far_t = select(t.y, t.x, falling);
    }
    var near_t = shells.z / max(flat_share, 1e-4);
    var enters = false;
    if slab {
        let t = crossings(up, shells.x);
        near_t = select(t.y, t.x, falling);
        enters = near_t >= FAR;
    }
    // No piece begins sooner than the ray enters the layer on this leg.
    var from_t = 0.0;
    if falling {
        let top = layer.base_m + layer.thickness_m;
        if camera.eye_m > top {
            from_t = crossings(up, top).x;
        }
    } else {
        let begin = crossings(up, layer.base_m).y;
        if begin < FAR && (camera.eye_m < layer.base_m || up < 0.0) {
            from_t = begin;
        } else if slab {
            from_t = lowest_t;
        } else if camera.eye_m > layer.base_m + layer.thickness_m {
            // A ring's piece may hold the point where the ray turns inside the layer.
            from_t = crossings(up, layer.base_m + layer.thickness_m).x;
        }
    }
    near_t = select(max(near_t, from_t), from_t, enters);
    // Not met at all; falling though the ray rises; behind the ground, which only falling rays meet.
    let missed = far_t >= FAR || near_t >= far_t || (falling && up >= 0.0)
        || (up < 0.0 && far_t > crossings(up, 0.0).x);
    if missed {
        return vec2<f32>(0.0, -1.0);
    }
    // Rings carry the ray first, slabs the rest: the piece in which that changes is shared.
    let first = carried(up, flat_share, near_t);
    let last = carried(up, flat_share, far_t);
    if (slab && last) || (!slab && !first) {
        return vec2<f32>(0.0, -1.0);
    }
    // Whether the layer's own end is the piece's.
    let leaves = select(layer.base_m + layer.thickness_m, layer.base_m, falling);
    var whole = kind == 1u || (slab && abs(shells.y - leaves) < 0.01 * layer.spacing_m);
    if first && !last {
        let switched = switch_between(up, flat_share, near_t, far_t);
        near_t = select(near_t, switched, slab);
        far_t = select(switched, far_t, slab);
        whole = whole && slab;
    }
    // Pieces join at rungs, where all looks stand.
    return vec2<f32>(max(rung_before(near_t), from_t), select(max(rung_before(far_t), from_t), far_t, whole));
}

@fragment
fn deck_fragment(in: Passed) -> @location(0) vec4<f32> {
    let direction = ray_of(in.position.xy);
    let flat_share = sqrt(max(1.0 - direction.z * direction.z, 0.0));
    let piece = piece_of(in.kind, in.shells, direction.z, flat_share);
    let walked = walk(direction, piece, vec2<f32>(0.0), 1.0);
    return exposed(direction, walked.light, walked.hidden, 1.0 - walked.transmittance);
}
