// The deck: slabs between slices and between rings, near to far. Twin: twin.rs and field.rs.

struct Region {
    centre_m: vec2<f32>,
    rotation: vec2<f32>,
    core_m: vec2<f32>,
    corner_m: f32,
    inverse_transition: f32,
    presence: f32,
    pad0: f32,
    pad1: f32,
    pad2: f32,
}

struct Layer {
    light_lux: vec3<f32>,
    base_m: f32,
    light_direction: vec3<f32>,
    thickness_m: f32,
    sky_lux: vec3<f32>,
    extinction_per_m: f32,
    ground_lux: vec3<f32>,
    inverse_edge: f32,
    theta: f32,
    patchiness: f32,
    spacing_m: f32,
    ring_ratio: f32,
    ring_first_m: f32,
    ring_last_m: f32,
    extent_m: f32,
    detail: f32,
    charts: u32,
    regions: u32,
    flashes: u32,
    region: u32,
    detail_origin: vec2<f32>,
    reach_m: f32,
    step_m: f32,
    chart: array<Chart, 3>,
    outline: array<Region, 4>,
    flash: array<Flash, 8>,
}

// Part of the horizon that the picture sees: first azimuth, step, and the number of steps.
struct Sector {
    first_rad: f32,
    step_rad: f32,
}

// What a scene does not need is not in its pipeline.
override SEVERAL_CHARTS: bool = true;
override REGIONS: bool = true;
override FLASHES: bool = true;

const TILE_M: f32 = 16000.0;
const DETAIL_TILE_M: f32 = 1397.0;
const DETAIL_NEAR_M: f32 = 2500.0;
const DETAIL_FAR_M: f32 = 9000.0;
const DIFFUSE_RANGE: f32 = 5.0;
const MOST_STEPS: u32 = 96u;
const MOST_LOOKS: u32 = 192u;
const HALVINGS: u32 = 10u;
const CLEAR: f32 = -0.25;
const RING_SHARE: f32 = 0.11;
const RING_SLICES: f32 = 6.0;
const PER_STERADIAN: f32 = 0.07957747;

@group(1) @binding(0) var<storage, read> layer: Layer;
@group(1) @binding(1) var<storage, read> sector: Sector;
@group(1) @binding(2) var volume0: texture_3d<f32>;
@group(1) @binding(3) var volume1: texture_3d<f32>;
@group(1) @binding(4) var volume2: texture_3d<f32>;
@group(1) @binding(5) var bounds: texture_2d<f32>;
@group(1) @binding(6) var detail: texture_3d<f32>;
@group(1) @binding(7) var tiled: sampler;

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
    let x = dot(v, camera.right) / dot(camera.right, camera.right);
    let y = dot(v, camera.up) / dot(camera.up, camera.up);
    let w = dot(v, camera.forward);
    var out: Passed;
    out.position = vec4<f32>(x, y, 0.5 * w, w);
    out.kind = kind;
    out.shells = vec4<f32>(near_m, far_m, inner_m, outer_m);
    return out;
}

fn region_presence(region: Region, z: vec2<f32>) -> f32 {
    let d = z - region.centre_m;
    let r = region.rotation;
    let q = abs(vec2<f32>(r.x * d.x + r.y * d.y, r.x * d.y - r.y * d.x)) - region.core_m;
    let outside = length(max(q, vec2<f32>(0.0))) + min(max(q.x, q.y), 0.0) - region.corner_m;
    return region.presence * (1.0 - smoothstep(0.0, 1.0, outside * region.inverse_transition));
}

fn region_shift(z: vec2<f32>) -> f32 {
    var there = 1.0;
    for (var i = 0u; i < layer.regions; i++) {
        let inside = region_presence(layer.outline[i], z);
        if layer.region == 0u {
            there *= 1.0 - inside;
        } else if layer.region == i + 1u {
            there = inside;
        }
    }
    return 1.0 - there;
}

fn volume_at(chart: u32, at: vec3<f32>) -> vec4<f32> {
    if chart == 0u {
        return textureSampleLevel(volume0, tiled, at, 0.0);
    }
    if chart == 1u {
        return textureSampleLevel(volume1, tiled, at, 0.0);
    }
    return textureSampleLevel(volume2, tiled, at, 0.0);
}

fn bound_at(tile: vec2<f32>) -> f32 {
    let cell = vec2<u32>((tile - floor(tile)) * 128.0) & vec2<u32>(127u);
    return textureLoad(bounds, cell, 0).r;
}

fn fine(z: vec2<f32>, height: f32, t: f32) -> f32 {
    let fade = 1.0 - smoothstep(DETAIL_NEAR_M, DETAIL_FAR_M, t);
    // In the first chart's axes, so that it stands on the ground while the eye moves.
    let moved = displacement(layer.chart[0].a, layer.chart[0].c, z);
    let at = vec3<f32>(layer.detail_origin + moved / DETAIL_TILE_M, height / DETAIL_TILE_M);
    return layer.detail * fade * (textureSampleLevel(detail, repeated, at, 0.0).r - 0.5);
}

fn near_edge(margin: f32, t: f32) -> bool {
    return t < DETAIL_FAR_M && abs(margin) < 0.5 * layer.detail + 1.0 / layer.inverse_edge;
}

// Directional, diffuse and sky light as stored, and the margin over theta.
fn look(direction: vec3<f32>, t: f32) -> vec4<f32> {
    let p = direction * t + vec3<f32>(0.0, 0.0, camera.eye_m);
    let height = height_at(direction.z, t);
    let radius = camera.earth_m + height;
    let z = stereographic(p, radius);
    var shift = 0.0;
    if REGIONS {
        shift = region_shift(z);
        if shift >= 1.0 {
            return vec4<f32>(0.0, 0.0, 0.0, -1.0);
        }
    }
    let share = (height - layer.base_m) / layer.thickness_m;
    var found = vec4<f32>(0.0);
    if SEVERAL_CHARTS {
        let from_centre = (p + vec3<f32>(0.0, 0.0, camera.earth_m)) / radius;
        var best = -1.0;
        for (var i = 0u; i < layer.charts; i++) {
            best = max(best, dot(from_centre, layer.chart[i].w));
        }
        var sum = 0.0;
        for (var i = 0u; i < layer.charts; i++) {
            let weight = max(layer.chart[i].zone + dot(from_centre, layer.chart[i].w) - best, 0.0);
            if weight > 0.0 {
                let moved = displacement(layer.chart[i].a, layer.chart[i].c, z);
                let tile = (layer.chart[i].tile_origin_m + moved) * (1.0 / TILE_M);
                let place = layer.chart[i].map_origin + map_coordinates(moved);
                let theta = layer.theta + layer.patchiness * textureSampleLevel(map, repeated, place, 0.0).r + shift;
                found += weight * (volume_at(i, vec3<f32>(tile, share)) - vec4<f32>(0.0, 0.0, 0.0, theta));
                sum += weight;
            }
        }
        found /= sum;
    } else {
        let moved = displacement(layer.chart[0].a, layer.chart[0].c, z);
        let tile = (layer.chart[0].tile_origin_m + moved) * (1.0 / TILE_M);
        let most = bound_at(tile) + 0.5 * layer.detail - layer.theta - shift;
        if most < CLEAR {
            return vec4<f32>(0.0, 0.0, 0.0, most);
        }
        let place = layer.chart[0].map_origin + map_coordinates(moved);
        let raised = layer.patchiness * textureSampleLevel(map, repeated, place, 0.0).r;
        if most - raised < CLEAR {
            return vec4<f32>(0.0, 0.0, 0.0, most - raised);
        }
        found = volume_at(0u, vec3<f32>(tile, share)) - vec4<f32>(0.0, 0.0, 0.0, layer.theta + raised + shift);
    }
    if near_edge(found.a, t) {
        found.a += fine(z, height, t);
    }
    return found;
}

fn phase(cosine: f32) -> f32 {
    let f = vec2<f32>(0.70, -0.25);
    let d = 1.0 + f * f - 2.0 * f * cosine;
    let lobes = 1.5 * (1.0 - f * f) / (2.0 + f * f) * (1.0 + cosine * cosine) / (d * sqrt(d));
    return PER_STERADIAN * dot(lobes, vec2<f32>(0.75, 0.25));
}

// Luminance that a point of cloud sends towards the eye where it is opaque.
fn source(stored: vec3<f32>, along: f32, p: vec3<f32>, height: f32) -> vec3<f32> {
    let shares = stored * stored;
    let below = clamp(1.0 - (height - layer.base_m) / layer.thickness_m, 0.0, 1.0);
    var light = layer.light_lux * (along * shares.x + DIFFUSE_RANGE * PER_STERADIAN * shares.y)
        + layer.sky_lux * (DIFFUSE_RANGE * shares.z) + layer.ground_lux * (below * below);
    if FLASHES {
        for (var i = 0u; i < layer.flashes; i++) {
            let away = p - layer.flash[i].position_m;
            let d2 = max(dot(away, away), FLASH_CAP_M * FLASH_CAP_M);
            light += FLASH_COLOUR * (layer.flash[i].intensity / d2);
        }
    }
    return light;
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
    let up = direction.z;
    let flat_share = sqrt(max(1.0 - up * up, 0.0));
    let piece = piece_of(in.kind, in.shells, up, flat_share);
    let far_t = piece.y;
    let least = (far_t - piece.x) * (1.0 / f32(MOST_STEPS));
    // No return stands before the loop: lavapipe lets a loop run to its end for pixels that have returned.
    var going = far_t > piece.x;
    var at = piece.x;
    var near = vec4<f32>(0.0, 0.0, 0.0, -1.0);
    if going {
        near = look(direction, at);
    }
    var beyond = layer.reach_m * max(-near.a, 0.0);
    var light = vec3<f32>(0.0);
    var hazed = 0.0;
    var transmittance = 1.0;
    for (var i = 0u; going && i < MOST_LOOKS; i++) {
        let shortest = max(layer.step_m + 0.025 * at, least);
        let end = min(far_t, at + shortest + beyond);
        let far = look(direction, end);
        if near.a < 0.0 && far.a > 0.0 && beyond > shortest {
            // A long step that ends inside the cloud went too far: its edge is looked for.
            beyond *= 0.4;
        } else {
            let whole = mean_clamped(near.a * layer.inverse_edge, far.a * layer.inverse_edge);
            if whole > 0.0 {
                let t = 0.5 * (at + end);
                let alpha = 1.0 - exp(-layer.extinction_per_m * (end - at) * whole);
                let height = height_at(up, t);
                let p = direction * t + vec3<f32>(0.0, 0.0, camera.eye_m);
                let weights = max(vec2<f32>(near.a, far.a), vec2<f32>(0.0));
                let stored = (near.rgb * weights.x + far.rgb * weights.y) / (weights.x + weights.y);
                let passed = air_transmittance(height, t);
                let along = phase(dot(direction, layer.light_direction));
                light += source(stored, along, p, height) * (passed * alpha * transmittance);
                hazed += (1.0 - passed) * alpha * transmittance;
                transmittance *= 1.0 - alpha;
            }
            going = transmittance >= OPAQUE && end < far_t;
            near = far;
            at = end;
            beyond = layer.reach_m * max(-near.a, 0.0);
        }
    }
    if hazed > 0.0 {
        light += endless_air(air_along(direction)) * hazed;
    }
    return vec4<f32>(min(light * camera.exposure, vec3<f32>(BRIGHTEST)), 1.0 - transmittance);
}
