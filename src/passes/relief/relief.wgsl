// The range at which each pixel's ray meets the ground. Stands behind field.wgsl. Twin: twin.rs.

const STEPS: u32 = 160u;
const HALVINGS: u32 = 6u;
const GROWTH: f32 = 0.008;
const SAFE_SHARE: f32 = 1.4;

fn clearance(direction: vec3<f32>, t: f32) -> f32 {
    let height = height_at(direction.z, t);
    let p = direction * t + vec3<f32>(0.0, 0.0, camera.eye_m);
    let place = relief_place(p, camera.earth_m + height);
    return height - relief_at(place, relief_level(place, t)).x;
}

fn range_of(direction: vec3<f32>) -> f32 {
    let highest = crossings(direction.z, relief.highest_m);
    let sea = crossings(direction.z, 0.0).x;
    // From above the highest ground to the sea, or out through it again; from below to where it is left.
    let begin = select(0.0, highest.x, camera.eye_m > relief.highest_m);
    let end = min(sea, highest.y);
    var going = begin < end;
    var found = sea;
    var t = begin;
    var clear = 0.0;
    if going {
        clear = clearance(direction, t);
    }
    var over = 0.0;
    var under = 0.0;
    // No return stands before a loop: lavapipe lets it run to its end for pixels that have returned.
    for (var i = 0u; going && i < STEPS; i++) {
        let next = min(t + max(SAFE_SHARE * clear, 0.5 * relief.spacing_m + GROWTH * t), end);
        clear = clearance(direction, next);
        if clear < 0.0 {
            over = t;
            under = next;
        }
        going = clear >= 0.0 && next < end;
        t = next;
    }
    let met = under > over;
    for (var i = 0u; met && i < HALVINGS; i++) {
        let middle = 0.5 * (over + under);
        if clearance(direction, middle) < 0.0 {
            under = middle;
        } else {
            over = middle;
        }
    }
    if met {
        found = 0.5 * (over + under);
    }
    return found;
}

@vertex
fn relief_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return covering(index);
}

@fragment
fn relief_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    return vec4<f32>(range_of(ray_of(at.xy)), 0.0, 0.0, 0.0);
}
