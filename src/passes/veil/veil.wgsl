// How much of the light of places in the sky comes to the eye through one layer. Twin: twin.rs.

@group(2) @binding(0) var<storage, read_write> nodes: array<Node>;

// Steps through one piece of a layer at most.
const VEIL_STEPS: f32 = 192.0;
// Growth of a step with the range.
const VEIL_GROWTH: f32 = 0.006;
// Optical depth at which nothing comes through any more.
const VEIL_DARK: f32 = 12.0;

// Optical depth of the layer's cloud between two ranges.
fn depth_between(direction: vec3<f32>, from_t: f32, to_t: f32) -> f32 {
    var depth = 0.0;
    var at = from_t;
    var near = -1.0;
    var going = from_t < to_t;
    if going {
        near = margin_along(direction, from_t);
    }
    let least = max((to_t - from_t) / VEIL_STEPS, 0.01);
    // Each step is at least `least` long, so that this ends.
    while going {
        let step = max(layer.step_m + VEIL_GROWTH * at, least) + layer.reach_m * max(-near, 0.0);
        let end = min(to_t, at + step);
        let far = margin_along(direction, end);
        depth += layer.extinction_per_m * (end - at) * mean_clamped(near * layer.inverse_edge, far * layer.inverse_edge);
        near = far;
        at = end;
        going = at < to_t && depth < VEIL_DARK;
    }
    return depth;
}

@compute @workgroup_size(64)
fn veil(@builtin(global_invocation_id) id: vec3<u32>) {
    let count = arrayLength(&nodes);
    let index = min(id.x, count - 1u);
    let node = nodes[index];
    let away = node.position_m - vec3<f32>(0.0, 0.0, camera.eye_m);
    let range = length(away);
    let direction = away / max(range, 1e-3);
    let flat_share = sqrt(max(1.0 - direction.z * direction.z, 0.0));
    let end = min(range, layer.extent_m / max(flat_share, 1e-3));
    let top_m = layer.base_m + layer.thickness_m;
    let top = crossings(direction.z, top_m);
    let base = crossings(direction.z, layer.base_m);
    // Under the top from `top_in` to `top_out`; below the base from `base_in` to `base_out`.
    let above = camera.eye_m > top_m;
    let over = camera.eye_m > layer.base_m;
    let top_in = select(0.0, top.x, above);
    let top_out = top.y;
    let base_in = select(0.0, base.x, over);
    let base_out = select(base.y, select(base.y, FAR, base.x >= FAR), over);
    let meets = !(above && top.x >= FAR);
    var depth = 0.0;
    if meets {
        depth = depth_between(direction, top_in, min(end, min(top_out, base_in)));
        if base_out < FAR {
            depth += depth_between(direction, max(top_in, base_out), min(end, top_out));
        }
    }
    if id.x < count {
        nodes[index].passed = node.passed * exp(-depth);
    }
}
