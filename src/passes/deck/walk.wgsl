// How a ray is walked in both forms of the deck: what carries it, how far a look may go, what a step adds. Stands behind
// field.wgsl. Twin: twin.rs.

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

// The stretch of a ray that may meet the layer; empty where the second range is not beyond the first.
fn bounded(direction: vec3<f32>) -> vec2<f32> {
    if layer.bound_radius_m == 0.0 {
        return vec2<f32>(0.0, FAR);
    }
    let middle = layer.bound_m - vec3<f32>(0.0, 0.0, camera.eye_m);
    let nearest = dot(direction, middle);
    let beside = middle - direction * nearest;
    let half = layer.bound_radius_m * layer.bound_radius_m - dot(beside, beside);
    if half <= 0.0 {
        return vec2<f32>(0.0);
    }
    return nearest + vec2<f32>(-sqrt(half), sqrt(half));
}

fn clamp_sum(m: f32) -> f32 {
    let c = clamp(m, 0.0, 1.0);
    return 0.5 * c * c + max(m - 1.0, 0.0);
}

// Mean of clamp(m, 0, 1) while m runs evenly from a to b.
fn mean_clamped(a: f32, b: f32) -> f32 {
    if abs(b - a) < 1e-4 {
        return clamp(0.5 * (a + b), 0.0, 1.0);
    }
    return (clamp_sum(b) - clamp_sum(a)) / (b - a);
}

// What a step of the walk adds: light towards the eye as the air lets it pass, the share of it that the air hides, and
// its opacity.
struct Seen {
    light: vec3<f32>,
    hidden: f32,
    alpha: f32,
}

fn step_growth() -> f32 {
    return clamp(STEP_PIXELS * 2.0 * length(camera.up) / camera.height_px, STEP_GROWTH.x, STEP_GROWTH.y);
}

// Rungs between two of the ladder: clumps are finer than its steps.
fn rungs_between(at: f32) -> f32 {
    return select(1.0, CLUMP_RUNGS, layer.varied > 0.0 && at < VARIED_M.y);
}

fn shortest_step(at: f32) -> f32 {
    return (layer.step_m + step_growth() * at) / rungs_between(at);
}

// The range of the next look: the next rung, or the last one that surely lies outside the cloud. Rungs are counted from
// the eye, a geometric series, and are the same for all rays, however many are left out and wherever a ray enters the layer.
fn next_look(at: f32, beyond: f32) -> f32 {
    let growth = step_growth();
    let origin = layer.step_m / growth;
    let surely = at + shortest_step(at) + beyond;
    let octaves = log2(1.0 + growth);
    let step = log2(surely / origin + 1.0) / octaves;
    let between = rungs_between(at);
    var rung = origin * exp2(floor(step + RUNG_ROUNDING) * octaves) - origin;
    if between > 1.0 && (surely < VARIED_M.y || rung <= at) {
        rung = origin * exp2(floor(step * between + RUNG_ROUNDING) / between * octaves) - origin;
    }
    return rung;
}

// Whether a look that found cloud went further than one step.
fn went_far(at: f32, end: f32) -> bool {
    return end - at > (1.0 + 3.0 * RUNG_ROUNDING) * shortest_step(at);
}

// Where between two looks that which is seen of the cloud lies, as a share of the way: about a free path behind its edge,
// however long the step is, so that the look that happens to find it does not show. Margins over the edge's width.
fn seen_share(near: f32, far: f32, depth: f32) -> f32 {
    let begin = clamp(-near / max(far - near, 1e-6), 0.0, 1.0);
    let end = select(1.0, clamp(near / max(near - far, 1e-6), 0.0, 1.0), far < 0.0);
    let n = clamp(near, 0.0, 1.0);
    let f = clamp(far, 0.0, 1.0);
    let middle = (n + 2.0 * f) / max(3.0 * (n + f), 1e-6);
    return begin + (end - begin) * middle * inverseSqrt(1.0 + middle * middle * depth * depth);
}

// The cloud between two looks at ranges `at` and `end`, which found the margins `near` and `far`.
fn seen_between(view: View, near: f32, far: f32, at: f32, end: f32) -> Seen {
    var seen = Seen(vec3<f32>(0.0), 0.0, 0.0);
    let whole = mean_clamped(near * layer.inverse_edge, far * layer.inverse_edge);
    if whole > 0.0 {
        let depth = layer.extinction_per_m * (end - at) * whole;
        let t = mix(at, end, seen_share(near * layer.inverse_edge, far * layer.inverse_edge, depth));
        let height = height_at(view.direction.z, t);
        let p = view.direction * t + vec3<f32>(0.0, 0.0, camera.eye_m);
        let passed = air_transmittance(height, t);
        seen.alpha = 1.0 - exp(-depth * varied(p, height, t));
        seen.light = source(light_at(p, height), view, p, height, t) * (passed * seen.alpha);
        seen.hidden = (1.0 - passed) * seen.alpha;
    }
    return seen;
}

// Exposed light of the deck and of the air before it, and opacity.
fn exposed(direction: vec3<f32>, gathered: vec3<f32>, hidden: f32, opacity: f32) -> vec4<f32> {
    var light = gathered;
    if hidden > 0.0 {
        light += air_before_clouds(direction) * hidden;
    }
    return vec4<f32>(min(light * camera.exposure, vec3<f32>(BRIGHTEST)), opacity);
}
