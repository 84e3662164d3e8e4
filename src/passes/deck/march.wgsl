// The deck as one walk a pixel, front to back, over the same pieces as the instanced form. One dispatch is one layer, or
// a span of its heights, on the way down or on the way up. Twin: twin.rs.

// Rays on the way down, to their lowest point; otherwise those that rise, or rise beyond it.
override FALLING: bool = false;

// Heights between which this dispatch walks its layer.
struct Heights {
    low_m: f32,
    high_m: f32,
}

// What nearer layers have gathered, and the same with this one.
@group(2) @binding(0) var before: texture_2d<f32>;
@group(2) @binding(1) var after: texture_storage_2d<rgba16float, write>;
@group(2) @binding(2) var<storage, read> heights: Heights;

// Slices that share a shell, as in clouds::slices.
const GROUP: f32 = 8.0;
// The end of the layer's next piece beyond `at`: a ring, the range at which slabs take over, or a shell.
struct Piece {
    end: f32,
    ring: f32,
    shell: f32,
}

struct Leg {
    begin: f32,
    end: f32,
    // Rings carry the ray up to here.
    rings_end: f32,
    up: f32,
    flat_share: f32,
}

fn crossing(up: f32, height: f32) -> f32 {
    let t = crossings(up, height);
    return select(t.y, t.x, FALLING);
}

// `ground`: range at which the ground stops the ray.
fn leg_of(direction: vec3<f32>, ground: f32) -> Leg {
    let up = direction.z;
    let flat_share = max(sqrt(max(1.0 - up * up, 0.0)), 1e-4);
    let lowest = max(-(camera.earth_m + camera.eye_m) * up, 0.0);
    let low_t = crossing(up, heights.low_m);
    var begin = 0.0;
    var end = 0.0;
    if FALLING {
        if camera.eye_m > heights.high_m {
            begin = crossing(up, heights.high_m);
        }
        end = select(min(low_t, lowest), 0.0, up >= 0.0);
    } else {
        begin = select(lowest, low_t, low_t < FAR && (camera.eye_m < heights.low_m || up < 0.0));
        end = crossing(up, heights.high_m);
    }
    // What the ray rises through is left through its upper end, or not met.
    end = select(end, 0.0, end >= FAR);
    end = min(min(end, layer.extent_m / max(flat_share, 1e-3)), ground);
    if REGIONS {
        let stretch = bounded(direction);
        begin = max(begin, stretch.x);
        end = min(end, stretch.y);
    }
    var rings_end = begin;
    if begin < end && carried(up, flat_share, begin) {
        rings_end = end;
        if !carried(up, flat_share, end) {
            rings_end = switch_between(up, flat_share, begin, end);
        }
    }
    return Leg(begin, end, rings_end, up, flat_share);
}

fn shell_count() -> f32 {
    let slices = max(round(layer.thickness_m / layer.spacing_m) + 1.0, 2.0);
    return max(ceil(slices / GROUP), 2.0);
}

fn ring_end(leg: Leg, ring: f32) -> f32 {
    let radius = layer.ring_first_m * pow(layer.ring_ratio, ring);
    let there = ring == 0.0 || radius < layer.ring_last_m * layer.ring_ratio;
    return select(FAR, min(radius, layer.ring_last_m) / leg.flat_share, there);
}

fn next_piece(leg: Leg, at: f32, last: Piece) -> Piece {
    var piece = last;
    if at < leg.rings_end {
        for (var end = 0.0; end <= at && end < FAR; piece.ring += 1.0) {
            end = ring_end(leg, piece.ring);
            piece.end = min(end, leg.rings_end);
        }
        return piece;
    }
    let shells = shell_count();
    piece.end = leg.end;
    for (var found = false; !found && piece.shell < shells; piece.shell += 1.0) {
        let share = select(piece.shell, shells - 1.0 - piece.shell, FALLING) / (shells - 1.0);
        let t = crossing(leg.up, layer.base_m + share * layer.thickness_m);
        found = t > at && t < FAR;
        if found {
            piece.end = min(t, leg.end);
        }
    }
    return piece;
}

// The row of workgroups that is drawn as the n-th: every eighth, then those half-way between, and so on, so that any
// unbroken share of them is spread over the whole picture. Software adapters give each core such a share, and sky and
// cloud do not cost the same.
fn row(n: u32, rows: u32) -> u32 {
    let in_turn = rows / 8u;
    return n % in_turn * 8u + (reverseBits(n / in_turn) >> 29u);
}

@compute @workgroup_size(8, 8)
fn deck_march(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_id) inside: vec3<u32>,
) {
    let id = vec2<u32>(workgroup.x, row(workgroup.y, workgroups.y)) * 8u + inside.xy;
    let there = vec2<f32>(id) + 0.5;
    let direction = ray_of(there);
    let nearer = textureLoad(before, id, 0);
    let leg = leg_of(direction, ground_range(there, direction.z));
    var transmittance = 1.0 - nearer.a;
    // No return stands before the loop: lavapipe lets a loop run to its end for pixels that have returned.
    var going = leg.begin < leg.end && transmittance >= layer.hidden_below;
    var at = leg.begin;
    var piece = Piece(0.0, 0.0, 0.0);
    var near = -1.0;
    var beyond = 0.0;
    // Where a straight line between two looks enters a cloud; 0: not known.
    var edge = 0.0;
    if going {
        let first = log(max(at * leg.flat_share / layer.ring_first_m, 1e-6)) / log(layer.ring_ratio);
        piece.ring = max(ceil(first), 0.0);
        piece = next_piece(leg, at, piece);
        let begun = look(direction, at, shortest_step(at));
        near = begun.margin;
        beyond = begun.beyond;
    }
    let view = view_of(direction);
    var light = vec3<f32>(0.0);
    var hidden = 0.0;
    for (var i = 0u; going && i < MOST_LOOKS; i++) {
        let end = select(min(piece.end, next_look(at, beyond)), edge, edge > at);
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
            near = far;
            at = end;
            beyond = found.beyond;
        }
        if at >= piece.end {
            going = transmittance >= layer.hidden_below && at < leg.end;
            if going {
                piece = next_piece(leg, at, piece);
            }
        }
        going = going && transmittance >= layer.hidden_below;
    }
    let own = exposed(direction, light, hidden, 1.0 - nearer.a - transmittance);
    if there.x < camera.width_px && there.y < camera.height_px {
        let light = min(nearer.rgb + own.rgb, vec3<f32>(BRIGHTEST));
        textureStore(after, id, vec4<f32>(light, nearer.a + own.a));
    }
}
