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
    // Rings, and the first slab, begin no sooner than the ray enters the layer on this leg.
    if !slab || enters {
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
    }
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
    if first && !last {
        let switched = switch_between(up, flat_share, near_t, far_t);
        return vec2<f32>(select(near_t, switched, slab), select(switched, far_t, slab));
    }
    return vec2<f32>(near_t, far_t);
}

@fragment
fn deck_fragment(in: Passed) -> @location(0) vec4<f32> {
    let direction = ray_of(in.position.xy);
    let flat_share = sqrt(max(1.0 - direction.z * direction.z, 0.0));
    let piece = piece_of(in.kind, in.shells, direction.z, flat_share);
    let far_t = piece.y;
    // No return stands before the loop: lavapipe lets a loop run to its end for pixels that have returned.
    var going = far_t > piece.x;
    var at = piece.x;
    var near = -1.0;
    var beyond = 0.0;
    // Where a straight line between two looks enters a cloud; 0: not known.
    var edge = 0.0;
    if going {
        let first = look(direction, at, shortest_step(at));
        near = first.margin;
        beyond = first.beyond;
    }
    let view = view_of(direction);
    var light = vec3<f32>(0.0);
    var hidden = 0.0;
    var transmittance = 1.0;
    for (var i = 0u; going && i < MOST_LOOKS; i++) {
        let end = select(min(far_t, next_look(at, beyond)), edge, edge > at);
        let found = look(direction, end, shortest_step(end));
        let far = found.margin;
        if near < 0.0 && far > 0.0 && went_far(at, end) {
            // A long step that ends inside the cloud went too far: its edge is looked for.
            beyond *= RETREAT;
        } else if near < 0.0 && far > 0.0 && edge == 0.0 && end - at > EDGE_STEP_M {
            // A long step that enters a cloud ends at its edge first, or stripes would show where the looks stood.
            edge = at + (end - at) * (near / (near - far));
        } else {
            // Where it lies a little further than expected, once is enough.
            edge = select(edge, 0.0, edge < end || far > 0.0);
            let seen = seen_between(view, near, far, at, end);
            light += seen.light * transmittance;
            hidden += seen.hidden * transmittance;
            transmittance *= 1.0 - seen.alpha;
            going = transmittance >= layer.hidden_below && end < far_t;
            near = far;
            at = end;
            beyond = found.beyond;
        }
    }
    return exposed(direction, light, hidden, 1.0 - transmittance);
}
