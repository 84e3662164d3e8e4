// How a ray is walked in both forms of the deck: how far a look may go, what is met, how it is lit. Stands behind field.wgsl and
// lit.wgsl. Twin: twin.rs.

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

// The rungs on which looks stand: growth of a step with the range, the shortest step over it, and octaves from one rung to the next.
// Counted from the eye, a geometric series, the same for all rays, however many are left out and wherever a ray enters the layer.
struct Ladder {
    growth: f32,
    origin: f32,
    octaves: f32,
}

fn ladder() -> Ladder {
    let growth = clamp(STEP_PIXELS * 2.0 * length(camera.up) / camera.height_px, STEP_GROWTH.x, STEP_GROWTH.y);
    return Ladder(growth, layer.step_m / growth, log2(1.0 + growth));
}

// Rungs between two of the ladder: clumps are finer than its steps.
fn rungs_between(at: f32) -> f32 {
    return select(1.0, CLUMP_RUNGS, CLUMPS && layer.varied > 0.0 && at < VARIED_M.y);
}

fn shortest_step(rungs: Ladder, at: f32) -> f32 {
    return (layer.step_m + rungs.growth * at) / rungs_between(at);
}

// The range of the next look: the next rung, or the last one that surely lies outside the cloud.
fn next_look(rungs: Ladder, at: f32, beyond: f32) -> f32 {
    let surely = at + shortest_step(rungs, at) + beyond;
    let step = log2(surely / rungs.origin + 1.0) / rungs.octaves;
    var rung = rungs.origin * exp2(floor(step + RUNG_ROUNDING) * rungs.octaves) - rungs.origin;
    if CLUMPS {
        let between = rungs_between(at);
        if between > 1.0 && (surely < VARIED_M.y || rung <= at) {
            rung = rungs.origin * exp2(floor(step * between + RUNG_ROUNDING) / between * rungs.octaves) - rungs.origin;
        }
    }
    return rung;
}

// Whether a look that found cloud went further than one step.
fn went_far(rungs: Ladder, at: f32, end: f32) -> bool {
    return end - at > (1.0 + 3.0 * RUNG_ROUNDING) * shortest_step(rungs, at);
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

// What a walk gathers: light towards the eye as the air lets it pass, the share of it that the air hides, and what still passes.
struct Walked {
    light: vec3<f32>,
    hidden: f32,
    transmittance: f32,
}

// Steps with cloud that are kept until they are lit.
const MOST_KEPT: u32 = 6u;

// Walks two stretches of a ray, near to far, until nothing passes any more. What is met is kept and lit in a loop of its own:
// software adapters run a branch for all pixels of a group whenever they come to it, and leave out only what lies behind the end of
// a loop.
fn walk(direction: vec3<f32>, near_stretch: vec2<f32>, far_stretch: vec2<f32>, passing: f32) -> Walked {
    let rungs = ladder();
    let view = view_of(direction);
    var walked = Walked(vec3<f32>(0.0), 0.0, passing);
    // Ranges at which they are seen, and depths.
    var kept: array<vec2<f32>, MOST_KEPT>;
    var count = 0u;
    let only_far = !(near_stretch.x < near_stretch.y);
    var stretch = select(near_stretch, far_stretch, only_far);
    var next = select(far_stretch, vec2<f32>(0.0), only_far);
    var at = stretch.x;
    var near = -1.0;
    var beyond = 0.0;
    // Where a straight line between two looks enters a cloud; below 0: not known.
    var edge = -1.0;
    var begun = false;
    var looks = 0u;
    // What passes without the density's variation, which only the lighting reads.
    var passes = passing;
    // No return stands before the loop: lavapipe lets a loop run to its end for pixels that have returned.
    var going = stretch.x < stretch.y && passing >= layer.hidden_below;
    while going {
        while going && count < MOST_KEPT {
            let end = select(select(min(stretch.y, next_look(rungs, at, beyond)), edge, edge > at), stretch.x, !begun);
            begun = true;
            let place = place_at(direction, end, shortest_step(rungs, end));
            var far = -1.0;
            var after = place.beyond;
            if !place.empty {
                far = margin_at(place, end);
                after = layer.reach_m * max(-far, 0.0);
            }
            if near < 0.0 && far > 0.0 && went_far(rungs, at, end) {
                // A long step that ends inside the cloud went too far: its edge is looked for.
                beyond *= RETREAT;
            } else if near < 0.0 && far > 0.0 && edge < 0.0 && end - at > EDGE_STEP_M {
                // A long step that enters a cloud ends at its edge first, or stripes would show where the looks stood.
                edge = at + (end - at) * (near / (near - far));
            } else {
                // Where it lies a little further than expected, once is enough.
                edge = select(edge, -1.0, edge < end || far > 0.0);
                let whole = mean_clamped(near * layer.inverse_edge, far * layer.inverse_edge);
                if whole > 0.0 && end > at {
                    let depth = layer.extinction_per_m * (end - at) * whole;
                    let t = mix(at, end, seen_share(near * layer.inverse_edge, far * layer.inverse_edge, depth));
                    kept[count] = vec2<f32>(t, depth);
                    count++;
                    passes *= exp(-depth);
                }
                near = far;
                at = end;
                beyond = after;
                if !(at < stretch.y) {
                    stretch = next;
                    next = vec2<f32>(0.0);
                    at = stretch.x;
                    near = -1.0;
                    edge = -1.0;
                    begun = false;
                }
                going = stretch.x < stretch.y && passes >= layer.hidden_below;
            }
            looks++;
            going = going && looks < MOST_LOOKS;
        }
        for (var i = 0u; i < count && walked.transmittance >= layer.hidden_below; i++) {
            let t = kept[i].x;
            let height = height_at(direction.z, t);
            let p = direction * t + vec3<f32>(0.0, 0.0, camera.eye_m);
            let passed = air_transmittance(height, t);
            let alpha = 1.0 - exp(-kept[i].y * varied(p, height, t));
            let weight = alpha * walked.transmittance;
            walked.light += source(light_at(p, height), view, p, height, t) * (passed * weight);
            walked.hidden += (1.0 - passed) * weight;
            walked.transmittance *= 1.0 - alpha;
        }
        count = 0u;
        passes = walked.transmittance;
        going = stretch.x < stretch.y && passes >= layer.hidden_below && looks < MOST_LOOKS;
    }
    return walked;
}

// The last rung at a range or before it.
fn rung_before(t: f32) -> f32 {
    let rungs = ladder();
    return rungs.origin * exp2(floor(log2(t / rungs.origin + 1.0) / rungs.octaves) * rungs.octaves) - rungs.origin;
}

// Exposed light of the deck and of the air before it, and opacity.
fn exposed(direction: vec3<f32>, gathered: vec3<f32>, hidden: f32, opacity: f32) -> vec4<f32> {
    var light = gathered;
    if hidden > 0.0 {
        light += air_before_clouds(direction) * hidden;
    }
    return vec4<f32>(min(light * camera.exposure, vec3<f32>(BRIGHTEST)), opacity);
}
