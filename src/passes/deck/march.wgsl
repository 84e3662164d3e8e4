// The deck as one walk a pixel, front to back. One dispatch is one layer, or a span of its heights, on the way down, on the way
// up, or both one after the other. Twin: twin.rs.

// Rays on the way down, to their lowest point, and those that rise, or rise beyond it.
override FALLING: bool = true;
override RISING: bool = true;

// Heights between which this dispatch walks its layer.
struct Heights {
    low_m: f32,
    high_m: f32,
}

// What nearer layers have gathered, and the same with this one.
@group(2) @binding(0) var before: texture_2d<f32>;
@group(2) @binding(1) var after: texture_storage_2d<rgba16float, write>;
@group(2) @binding(2) var<storage, read> heights: Heights;

// The stretch of a ray between the heights on one of its ways. `ground`: range at which the ground stops it.
fn leg_of(direction: vec3<f32>, ground: f32, falling: bool) -> vec2<f32> {
    let up = direction.z;
    let flat_share = max(sqrt(max(1.0 - up * up, 0.0)), 1e-4);
    let lowest = max(-(camera.earth_m + camera.eye_m) * up, 0.0);
    let low = crossings(up, heights.low_m);
    let high = crossings(up, heights.high_m);
    var begin = 0.0;
    var end = 0.0;
    if falling {
        begin = select(0.0, high.x, camera.eye_m > heights.high_m);
        end = select(min(low.x, lowest), 0.0, up >= 0.0);
    } else {
        begin = select(lowest, low.y, low.y < FAR && (camera.eye_m < heights.low_m || up < 0.0));
        end = high.y;
    }
    // What the ray rises through is left through its upper end, or not met.
    end = select(end, 0.0, end >= FAR);
    end = min(min(end, layer.extent_m / max(flat_share, 1e-3)), ground);
    if REGIONS {
        let stretch = bounded(direction);
        begin = max(begin, stretch.x);
        end = min(end, stretch.y);
    }
    return vec2<f32>(begin, end);
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
    let ground = ground_range(there, direction.z);
    var falling = vec2<f32>(0.0);
    var rising = vec2<f32>(0.0);
    if FALLING {
        falling = leg_of(direction, ground, true);
    }
    if RISING {
        rising = leg_of(direction, ground, false);
    }
    let walked = walk(direction, falling, rising, 1.0 - nearer.a);
    let own = exposed(direction, walked.light, walked.hidden, 1.0 - nearer.a - walked.transmittance);
    if there.x < camera.width_px && there.y < camera.height_px {
        let light = min(nearer.rgb + own.rgb, vec3<f32>(BRIGHTEST));
        textureStore(after, id, vec4<f32>(light, nearer.a + own.a));
    }
}
