// The deck at a point: density, light, and which surfaces carry a ray. Stands before both forms of the pass. Twin: field.rs.

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
    hidden_below: f32,
    clear_below: f32,
    clear_share: f32,
    theta_slope_per_m: f32,
    light_low: f32,
    light_per_theta: f32,
    light_nodes: f32,
    light_encoding: u32,
    shade_height_m: f32,
    shade_near_m: f32,
    shade_span: f32,
    pad2: f32,
    chart: array<Chart, 3>,
    outline: array<Region, 16>,
    flash: array<Flash, 64>,
}

struct CityGlow {
    a: vec2<f32>,
    c: vec2<f32>,
    stretch: vec2<f32>,
    origin: vec2<f32>,
    strength: f32,
    pad0: f32,
}

// What a scene does not need is not in its pipeline.
override SEVERAL_CHARTS: bool = true;
override REGIONS: bool = true;
override FLASHES: bool = true;
override SHADED: bool = true;
// What the light volumes hold: 0 shares, 1 the flux as a vector, 2 as a vector stored as n/2 + 0.5.
override FLUX: u32 = 0u;
override GLOW: bool = true;

const DETAIL_TILE_M: f32 = 1397.0;
const DETAIL_NEAR_M: f32 = 2500.0;
const DETAIL_FAR_M: f32 = 9000.0;
const LIGHT_RANGE: f32 = 5.0;
const LIGHT_SLICES: f32 = 32.0;
const FLUX_FACTOR: f32 = 2.55;
const LEAST_UP: f32 = 0.07;
const SHADE_LEAST_SINE: f32 = 0.05;
const MOST_STEPS: u32 = 96u;
const MOST_LOOKS: u32 = 192u;
const STEP_PIXELS: f32 = 3.5;
const STEP_GROWTH: vec2<f32> = vec2<f32>(0.004, 0.025);
const RETREAT: f32 = 0.4;
const CLEAR_HEIGHT: f32 = 8.0;
const CLEAR_THETAS: f32 = 12.0;
const CLEAR_THETA_STEP: f32 = 0.08;
const CLEAR_UNIT_M: f32 = 8.0;
const RUNG_ROUNDING: f32 = 0.01;
const HALVINGS: u32 = 10u;
const ALONE: f32 = 0.9999;
const RING_SHARE: f32 = 0.11;
const RING_SLICES: f32 = 6.0;
const PER_STERADIAN: f32 = 0.07957747;

@group(1) @binding(0) var<storage, read> layer: Layer;
@group(1) @binding(1) var shape: texture_3d<f32>;
@group(1) @binding(2) var light0: texture_3d<f32>;
@group(1) @binding(3) var light1: texture_3d<f32>;
@group(1) @binding(4) var light2: texture_3d<f32>;
// Bounds of the columns; above them distances to the nearest cloud, as in clouds::clearance.
@group(1) @binding(5) var bounds: texture_3d<f32>;
@group(1) @binding(6) var detail: texture_3d<f32>;
@group(1) @binding(7) var tiled: sampler;
// The map of shade by higher layers.
@group(1) @binding(8) var shades: texture_2d<f32>;
@group(1) @binding(9) var<storage, read> glow: CityGlow;
// Illuminance from below by cities, for four heights.
@group(1) @binding(10) var glow_table: texture_2d<f32>;

const GLOW_WIDTH_M: f32 = 512000.0;
const GLOW_SLAB: f32 = 0.08;
const CITY_COLOUR: vec3<f32> = vec3<f32>(1.0, 0.72, 0.42);

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
    // Squared, so that half-way through the transition some of both weathers is there.
    return (1.0 - there) * (1.0 - there);
}

fn shape_at(at: vec3<f32>) -> f32 {
    return textureSampleLevel(shape, tiled, at, 0.0).r;
}

fn stored_light(chart: u32, at: vec3<f32>) -> vec4<f32> {
    if SEVERAL_CHARTS {
        if chart == 1u {
            return textureSampleLevel(light1, tiled, at, 0.0);
        }
        if chart == 2u {
            return textureSampleLevel(light2, tiled, at, 0.0);
        }
    }
    return textureSampleLevel(light0, tiled, at, 0.0);
}

// The stored light between the two thetas around the one that rules at a place of a chart; vectors in the eye's axes.
fn chart_light(chart: u32, z: vec2<f32>, share: f32, shift: f32) -> vec4<f32> {
    let moved = displacement(layer.chart[chart].a, layer.chart[chart].c, z);
    let tile = tile_at(chart, moved);
    let theta = layer.theta + raised_at(chart, moved) + shift;
    let node = clamp((theta - layer.light_low) * layer.light_per_theta, 0.0, layer.light_nodes - 1.0);
    let low = floor(node);
    // Volumes of neighbouring thetas lie one above the other: no look reaches from one into the next.
    let height = clamp(share * LIGHT_SLICES, 0.5, LIGHT_SLICES - 0.5);
    let scale = 1.0 / (LIGHT_SLICES * layer.light_nodes);
    var found = stored_light(chart, vec3<f32>(tile, (low * LIGHT_SLICES + height) * scale));
    if node > low {
        let next = stored_light(chart, vec3<f32>(tile, ((low + 1.0) * LIGHT_SLICES + height) * scale));
        found = mix(found, next, node - low);
    }
    if FLUX != 0u {
        let middle = select(0.0, 0.5, FLUX == 2u);
        let a = normalize(layer.chart[chart].a);
        let v = found.xy - middle;
        found = vec4<f32>(middle + a.x * v.x + a.y * v.y, middle + a.x * v.y - a.y * v.x, found.zw);
    }
    return found;
}

fn cell_of(tile: vec2<f32>) -> vec2<u32> {
    return vec2<u32>((tile - floor(tile)) * 128.0) & vec2<u32>(127u);
}

fn bound_at(tile: vec2<f32>) -> f32 {
    return textureLoad(bounds, vec3<u32>(cell_of(tile), 0u), 0).r;
}

// How far away the nearest cloud is at least; 0 where the table does not say.
fn clear_m(tile: vec2<f32>, share: f32, theta: f32) -> f32 {
    let lowered = theta - 0.5 * layer.detail;
    // A theta some way below this one: it may fall by the difference before its distances are wrong.
    let node = min(floor(lowered * (1.0 / CLEAR_THETA_STEP) - 0.5), CLEAR_THETAS - 1.0);
    if node < 0.0 || layer.clear_share == 0.0 {
        return 0.0;
    }
    let height = clamp(floor(share * CLEAR_HEIGHT), 0.0, CLEAR_HEIGHT - 1.0);
    let at = vec3<u32>(cell_of(tile), u32(1.0 + height + CLEAR_HEIGHT * node));
    let distance = textureLoad(bounds, at, 0).r * (255.0 * CLEAR_UNIT_M * layer.clear_share);
    return min(distance, (lowered - node * CLEAR_THETA_STEP) / max(layer.theta_slope_per_m, 1e-9));
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

// Weights of the charts at a direction from the Earth's centre. Written out, not looped: an index that is a constant is
// read once for all pixels.
fn chart_weights(from_centre: vec3<f32>) -> vec3<f32> {
    let near = vec3<f32>(
        dot(from_centre, layer.chart[0].w),
        dot(from_centre, layer.chart[1].w),
        select(-1.0, dot(from_centre, layer.chart[2].w), layer.charts > 2u),
    );
    let best = max(near.x, max(near.y, near.z));
    let raw = max(layer.chart[0].zone + near - best, vec3<f32>(0.0));
    return raw / (raw.x + raw.y + raw.z);
}

fn tile_at(chart: u32, moved: vec2<f32>) -> vec2<f32> {
    return tile_of(layer.chart[chart].tile_origin_m, layer.chart[chart].warp, moved);
}

// What the 2D map adds to theta.
fn raised_at(chart: u32, moved: vec2<f32>) -> f32 {
    return layer.patchiness * textureSampleLevel(map, repeated, layer.chart[chart].map_origin + map_coordinates(moved), 0.0).r;
}

// What a look finds: the margin of the shape value over theta, cloud where positive (where there is certainly none, any value
// below 0), and how far beyond the next step there is surely no cloud, or hardly any.
struct Look {
    margin: f32,
    beyond: f32,
}

// A look by one chart, `alone` where no other has weight: then an upper bound where there is certainly no cloud, and `clear`
// where it is further away than a step.
struct Found {
    margin: f32,
    clear: f32,
}

fn found_by(chart: u32, z: vec2<f32>, share: f32, shift: f32, alone: bool, step: f32) -> Found {
    let moved = displacement(layer.chart[chart].a, layer.chart[chart].c, z);
    let tile = tile_at(chart, moved);
    var found = Found(bound_at(tile) + 0.5 * layer.detail - layer.theta - shift, 0.0);
    if found.margin >= layer.clear_below || !alone {
        let raised = raised_at(chart, moved);
        found.margin -= raised;
        if found.margin >= layer.clear_below || !alone {
            // Where regions begin theta falls faster than by the map.
            if alone && shift == 0.0 {
                found.clear = clear_m(tile, share, layer.theta + raised);
            }
            if found.clear > step {
                found.margin = -1.0;
            } else {
                found = Found(shape_at(vec3<f32>(tile, share)) - (layer.theta + raised + shift), 0.0);
            }
        }
    }
    return found;
}

// A look whose next step is `step` long: where cloud is further away than that, nothing else is read.
fn look(direction: vec3<f32>, t: f32, step: f32) -> Look {
    let p = direction * t + vec3<f32>(0.0, 0.0, camera.eye_m);
    let height = height_at(direction.z, t);
    let radius = camera.earth_m + height;
    let z = stereographic(p, radius);
    var shift = 0.0;
    if REGIONS {
        shift = region_shift(z);
        if shift >= 1.0 {
            return Look(-1.0, layer.reach_m);
        }
    }
    let share = (height - layer.base_m) / layer.thickness_m;
    var sum = 0.0;
    var clear = 0.0;
    if SEVERAL_CHARTS {
        let weights = chart_weights((p + vec3<f32>(0.0, 0.0, camera.earth_m)) / radius);
        if weights.x > 0.0 {
            let found = found_by(0u, z, share, shift, weights.x > ALONE, step);
            sum += weights.x * found.margin;
            clear += found.clear;
        }
        if weights.y > 0.0 {
            let found = found_by(1u, z, share, shift, weights.y > ALONE, step);
            sum += weights.y * found.margin;
            clear += found.clear;
        }
        if weights.z > 0.0 {
            let found = found_by(2u, z, share, shift, weights.z > ALONE, step);
            sum += weights.z * found.margin;
            clear += found.clear;
        }
    } else {
        let found = found_by(0u, z, share, shift, true, step);
        sum = found.margin;
        clear = found.clear;
    }
    if clear > step {
        return Look(-1.0, clear - step);
    }
    if near_edge(sum, t) {
        sum += fine(z, height, t);
    }
    return Look(sum, layer.reach_m * max(-sum, 0.0));
}

// Light as stored at a point and its height, for the theta that rules there.
fn light_at(p: vec3<f32>, height: f32) -> vec4<f32> {
    let radius = camera.earth_m + height;
    let z = stereographic(p, radius);
    let share = (height - layer.base_m) / layer.thickness_m;
    var shift = 0.0;
    if REGIONS {
        shift = region_shift(z);
    }
    var found = vec4<f32>(0.0);
    if SEVERAL_CHARTS {
        let weights = chart_weights((p + vec3<f32>(0.0, 0.0, camera.earth_m)) / radius);
        if weights.x > 0.0 {
            found += weights.x * chart_light(0u, z, share, shift);
        }
        if weights.y > 0.0 {
            found += weights.y * chart_light(1u, z, share, shift);
        }
        if weights.z > 0.0 {
            found += weights.z * chart_light(2u, z, share, shift);
        }
    } else {
        found = chart_light(0u, z, share, shift);
    }
    return found;
}

// A ray of the picture as the layer's light sees it: its direction, and the phase functions for light that comes from the
// source straight and for what has been scattered on its way.
struct View {
    direction: vec3<f32>,
    lobes: vec2<f32>,
}

fn view_of(direction: vec3<f32>) -> View {
    let cosine = dot(direction, layer.light_direction);
    let f = vec3<f32>(0.75, -0.20, 0.60);
    let d = 1.0 + f * f - 2.0 * f * cosine;
    let lobes = 1.5 * (1.0 - f * f) / (2.0 + f * f) * (1.0 + cosine * cosine) / (d * sqrt(d));
    return View(direction, PER_STERADIAN * vec2<f32>(0.96 * lobes.x + 0.04 * lobes.y, lobes.z));
}

// What of the light outside is sent towards the eye: from the source, from the sky, from below.
fn lit(stored: vec4<f32>, view: View) -> vec3<f32> {
    let mu = max(layer.light_direction.z, LEAST_UP);
    let up = view.direction.z;
    var from_source = 0.0;
    var sky = 0.0;
    var net = 0.0;
    if FLUX != 0u {
        let flux = select(stored.xyz, stored.xyz * 2.0 - 1.0, FLUX == 2u);
        let mean = select(stored.w, LIGHT_RANGE * stored.w * stored.w, FLUX == 2u);
        from_source = PER_STERADIAN * max(mean - FLUX_FACTOR * dot(flux, view.direction), 0.0);
        sky = min(mean * (4.0 / (1.0 + 2.0 * mu)), 4.0);
        net = min(clamp(-flux.z / mu, 0.0, 1.0), 0.5 * sky);
    } else {
        let shares = stored * stored;
        let beam = shares.x;
        sky = 4.0 * shares.w;
        // Lit, but deep below the zenith: a flank.
        let facing = min(2.0 * beam * (1.0 - shares.w), 1.0);
        let cosine = mu + (1.0 - mu) * facing;
        // What leaves the beam in reduced depths: the power 1.25.
        let flux = cosine * (shares.z - beam * sqrt(sqrt(beam)));
        let along = up + (dot(view.direction, layer.light_direction) - up) * facing;
        from_source = beam * mix(view.lobes.y, view.lobes.x, beam)
            + PER_STERADIAN * max(LIGHT_RANGE * shares.y + FLUX_FACTOR * flux * along, 0.0);
        net = min(shares.z * ((4.0 / 3.0) / (2.0 / 3.0 + mu)), 0.5 * sky);
    }
    let from_above = clamp(sky + FLUX_FACTOR * net * up, 0.0, 4.0);
    return vec3<f32>(from_source, from_above, 4.0 - from_above);
}

// Share of the source's light that higher layers leave at a point and its height.
fn shown(p: vec3<f32>, height: f32) -> f32 {
    let radius = camera.earth_m + height;
    let sine = dot(p + vec3<f32>(0.0, 0.0, camera.earth_m), layer.light_direction) / radius;
    let away = (layer.shade_height_m - height) / max(sine, SHADE_LEAST_SINE);
    let z = stereographic(p, radius) + layer.light_direction.xy * away;
    let distance = length(z);
    let share = log(1.0 + distance / layer.shade_near_m) * layer.shade_span;
    let place = z * (0.5 * share / max(distance, 1e-3)) + 0.5;
    return textureSampleLevel(shades, clamped, place, 0.0).r;
}

// What a point sends out of the light of cities; `from_below` is what it sends of a layer's own light from the ground.
fn city_glow(p: vec3<f32>, height: f32, from_below: f32) -> vec3<f32> {
    let moved = displacement(glow.a, glow.c, stereographic(p, camera.earth_m + height) * glow.stretch);
    let lux = textureSampleLevel(glow_table, clamped, glow.origin + moved * (1.0 / GLOW_WIDTH_M), 0.0);
    // Between the table's heights by their logarithm: 250, 1,000, 3,000 and 9,000 m.
    let log_height = log(max(height, 1.0));
    let share = clamp((log_height - vec3<f32>(5.5214609, 6.9077553, 8.0063676)) * vec3<f32>(0.7213475, 0.9102392, 0.9102392),
        vec3<f32>(0.0), vec3<f32>(1.0));
    let arrives = mix(mix(mix(lux.x, lux.y, share.x), lux.z, share.y), lux.w, share.z);
    // Through the cloud below it as through a diffuse slab; a flank has open air before it.
    let depth = layer.extinction_per_m * max(height - layer.base_m, 0.0);
    let through = mix(1.0 / (1.0 + GLOW_SLAB * depth), 1.0, 1.0 - 0.25 * from_below);
    return CITY_COLOUR * (PER_STERADIAN * glow.strength * arrives * through * from_below);
}

// Luminance that a point of cloud sends towards the eye where it is opaque.
fn source(stored: vec4<f32>, view: View, p: vec3<f32>, height: f32) -> vec3<f32> {
    var shares = lit(stored, view);
    if SHADED {
        shares.x *= shown(p, height);
    }
    var light = layer.light_lux * shares.x + layer.sky_lux * shares.y + layer.ground_lux * shares.z;
    if GLOW {
        light += city_glow(p, height, shares.z);
    }
    if FLASHES {
        for (var i = 0u; i < layer.flashes; i++) {
            let away = p - layer.flash[i].position_m;
            let d2 = max(dot(away, away), FLASH_CAP_M * FLASH_CAP_M);
            light += FLASH_COLOUR * (layer.flash[i].intensity / d2);
        }
        light += FLASH_COLOUR * lit_scattered(p, height, -view.direction);
    }
    return light;
}
