// The deck at a point: how far inside the cloud it is, and how far away cloud is. Stands before both forms of the pass. Twin: field.rs.

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
    clear_rise: f32,
    clear_share: f32,
    theta_slope_per_m: f32,
    light_low: f32,
    light_per_theta: f32,
    light_nodes: f32,
    light_encoding: u32,
    shade_height_m: f32,
    shade_near_m: f32,
    shade_span: f32,
    relief_m: f32,
    detail_per_m: vec3<f32>,
    relief_depth: f32,
    detail_fade_m: vec2<f32>,
    varied: f32,
    clumps_finer: f32,
    low_light: vec3<f32>,
    pad0: f32,
    bound_m: vec3<f32>,
    bound_radius_m: f32,
    chart: array<Chart, 3>,
    outline: array<Region, 16>,
    flash: array<Flash, 64>,
}

// What a scene does not need is not in its pipeline.
override SEVERAL_CHARTS: bool = true;
override REGIONS: bool = true;
override CLUMPS: bool = true;
// Whether empty space is looked up: not on software adapters, which read the shape all the same.
override LEAPS: bool = true;

const DETAIL_MEAN: f32 = 0.62;
const MOST_LOOKS: u32 = 4096u;
const STEP_PIXELS: f32 = 3.5;
const STEP_GROWTH: vec2<f32> = vec2<f32>(0.004, 0.025);
const RETREAT: f32 = 0.25;
const EDGE_STEP_M: f32 = 90.0;
const CLEAR_HEIGHT: f32 = 16.0;
const CLEAR_M: vec4<f32> = vec4<f32>(250.0, 500.0, 1000.0, 2000.0);
const VARIED_M: vec2<f32> = vec2<f32>(150.0, 600.0);
const CLUMP_RUNGS: f32 = 3.0;
const LEAST_VARIED: f32 = 0.1;
const RUNG_ROUNDING: f32 = 0.01;
const HALVINGS: u32 = 10u;
const ALONE: f32 = 0.9999;
const RING_SHARE: f32 = 0.11;
const RING_SLICES: f32 = 6.0;

@group(1) @binding(0) var<storage, read> layer: Layer;
@group(1) @binding(1) var shape: texture_3d<f32>;
@group(1) @binding(2) var light0: texture_3d<f32>;
@group(1) @binding(3) var light1: texture_3d<f32>;
@group(1) @binding(4) var light2: texture_3d<f32>;
// The greatest shape value nearer than four distances, as in clouds::clearance.
@group(1) @binding(5) var bounds: texture_3d<f32>;
@group(1) @binding(6) var detail: texture_3d<f32>;
@group(1) @binding(7) var tiled: sampler;
// The map of shade by higher layers.
@group(1) @binding(8) var shades: texture_2d<f32>;
@group(1) @binding(9) var<storage, read> glow: CityGlow;
// Illuminance from below by cities, for four heights.
@group(1) @binding(10) var glow_table: texture_2d<f32>;

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

fn cell_of(tile: vec2<f32>) -> vec2<u32> {
    return vec2<u32>((tile - floor(tile)) * 128.0) & vec2<u32>(127u);
}

// How far along a ray there is surely no cloud, for theta less what detail adds; 0 where the table does not say.
fn clear_m(tile: vec2<f32>, share: f32, lowered: f32, sine: f32) -> f32 {
    let height = clamp(floor(share * CLEAR_HEIGHT), 0.0, CLEAR_HEIGHT - 1.0);
    let most = textureLoad(bounds, vec3<u32>(cell_of(tile), u32(height)), 0);
    let pace = sqrt(1.0 + (layer.clear_rise * layer.clear_rise - 1.0) * sine * sine);
    let far = CLEAR_M * (layer.clear_share / pace);
    // On the way theta may fall.
    let free = select(vec4<f32>(0.0), far, most + layer.theta_slope_per_m * far < vec4<f32>(lowered));
    return max(max(free.x, free.y), max(free.z, free.w));
}

// What is left of the detail at a range.
fn detail_fade(t: f32) -> f32 {
    return select(0.0, 1.0 - smoothstep(layer.detail_fade_m.x, layer.detail_fade_m.y, t), t < layer.detail_fade_m.y);
}

// Most that detail adds to a margin at a range and farther away.
fn heaped(t: f32) -> f32 {
    return layer.detail * detail_fade(t) * (1.0 - DETAIL_MEAN);
}

// A place in periods of the detail.
fn detail_place(z: vec2<f32>, height: f32) -> vec3<f32> {
    // In the first chart's axes, so that it stands on the ground while the eye moves.
    let moved = displacement(layer.chart[0].a, layer.chart[0].c, z);
    return vec3<f32>(layer.detail_origin, 0.0) + vec3<f32>(moved, height) * layer.detail_per_m;
}

// The detail at a place, less its mean.
fn fine(z: vec2<f32>, height: f32) -> f32 {
    return textureSampleLevel(detail, repeated, detail_place(z, height), 0.0).r - DETAIL_MEAN;
}

// How much of density's variation inside the cloud is left at a range.
fn variation(t: f32) -> f32 {
    if !CLUMPS {
        return 0.0;
    }
    return select(0.0, layer.varied * (1.0 - smoothstep(VARIED_M.x, VARIED_M.y, t)), t < VARIED_M.y);
}

// Clumps of two sizes at a place, 0 on the mean: more water where positive.
fn clumps(z: vec2<f32>, height: f32) -> f32 {
    let at = detail_place(z, height);
    let coarse = textureSampleLevel(detail, repeated, at, 0.0).r;
    return coarse + textureSampleLevel(detail, repeated, at * layer.clumps_finer, 0.0).r - 2.0 * DETAIL_MEAN;
}

// Density at a place in the cloud over the layer's own: 1 on the mean.
fn varied(p: vec3<f32>, height: f32, t: f32) -> f32 {
    let share = variation(t);
    if share == 0.0 {
        return 1.0;
    }
    return clamp(1.0 + share * clumps(stereographic(p, camera.earth_m + height), height), LEAST_VARIED, 2.0 - LEAST_VARIED);
}

// Whether detail makes a difference to a margin.
fn near_edge(margin: f32, t: f32) -> bool {
    return t < layer.detail_fade_m.y && margin > -heaped(t) && margin < layer.detail + 1.0 / layer.inverse_edge;
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

// A place that a walk looks at, and whether there is certainly no cloud: then no more is read.
struct Place {
    empty: bool,
    // Where it is empty, how far beyond the next step there is surely no cloud.
    beyond: f32,
    z: vec2<f32>,
    height: f32,
    // Share of the layer's height.
    share: f32,
    // In the tile of the chart that rules there, and theta.
    tile: vec2<f32>,
    theta: f32,
    // What regions raise theta by, and the charts' weights.
    shift: f32,
    weights: vec3<f32>,
}

// The chart of greatest weight.
fn ruling(weights: vec3<f32>) -> u32 {
    let best = max(weights.x, max(weights.y, weights.z));
    return select(select(2u, 1u, weights.y >= best), 0u, weights.x >= best);
}

// A place in the tile of a chart, and what its map adds to theta. An index that is a constant is read once for all pixels, so all
// charts are read.
struct Charted {
    tile: vec2<f32>,
    raised: f32,
}

fn charted(chart: u32, z: vec2<f32>) -> Charted {
    if !SEVERAL_CHARTS {
        let moved = displacement(layer.chart[0].a, layer.chart[0].c, z);
        return Charted(tile_at(0u, moved), raised_at(0u, moved));
    }
    let first = chart == 0u;
    let second = chart == 1u;
    let a = select(select(layer.chart[2].a, layer.chart[1].a, second), layer.chart[0].a, first);
    let c = select(select(layer.chart[2].c, layer.chart[1].c, second), layer.chart[0].c, first);
    let origin = select(select(layer.chart[2].tile_origin_m, layer.chart[1].tile_origin_m, second), layer.chart[0].tile_origin_m, first);
    let warp = select(select(layer.chart[2].warp, layer.chart[1].warp, second), layer.chart[0].warp, first);
    let map_origin = select(select(layer.chart[2].map_origin, layer.chart[1].map_origin, second), layer.chart[0].map_origin, first);
    let moved = displacement(a, c, z);
    let raised = layer.patchiness * textureSampleLevel(map, repeated, map_origin + map_coordinates(moved), 0.0).r;
    return Charted(tile_of(origin, warp, moved), raised);
}

// Looks at a place whose next step is `step` long.
fn place_at(direction: vec3<f32>, t: f32, step: f32) -> Place {
    let p = direction * t + vec3<f32>(0.0, 0.0, camera.eye_m);
    var place: Place;
    place.height = height_at(direction.z, t);
    let radius = camera.earth_m + place.height;
    place.z = stereographic(p, radius);
    place.share = (place.height - layer.base_m) / layer.thickness_m;
    if REGIONS {
        place.shift = region_shift(place.z);
    }
    var chart = 0u;
    var alone = true;
    if SEVERAL_CHARTS {
        place.weights = chart_weights((p + vec3<f32>(0.0, 0.0, camera.earth_m)) / radius);
        chart = ruling(place.weights);
        alone = max(place.weights.x, max(place.weights.y, place.weights.z)) > ALONE;
    }
    let there = charted(chart, place.z);
    place.tile = there.tile;
    place.theta = layer.theta + there.raised + place.shift;
    var clear = 0.0;
    // Where regions begin theta falls faster than by the map.
    if LEAPS && alone && place.shift == 0.0 {
        let sine = ((camera.earth_m + camera.eye_m) * direction.z + t) / radius;
        clear = clear_m(there.tile, place.share, place.theta - heaped(t), sine);
    }
    place.empty = clear > step;
    place.beyond = clear - step;
    if REGIONS && place.shift >= 1.0 {
        place.empty = true;
        place.beyond = layer.reach_m;
    }
    return place;
}

// The margin of the shape value over theta at a place that is not known to be empty: cloud where positive.
fn margin_at(place: Place, t: f32) -> f32 {
    var sum = 0.0;
    if SEVERAL_CHARTS {
        var left = place.weights;
        // Nearly everywhere one.
        while max(left.x, max(left.y, left.z)) > 0.0 {
            let chart = ruling(left);
            let there = charted(chart, place.z);
            let theta = layer.theta + there.raised + place.shift;
            sum += max(left.x, max(left.y, left.z)) * (shape_at(vec3<f32>(there.tile, place.share)) - theta);
            left = select(left, vec3<f32>(0.0), vec3<u32>(0u, 1u, 2u) == vec3<u32>(chart));
        }
    } else {
        sum = shape_at(vec3<f32>(place.tile, place.share)) - place.theta;
    }
    if near_edge(sum, t) {
        sum += layer.detail * detail_fade(t) * fine(place.z, place.height);
    }
    return sum;
}

// The margin at a range; any value below 0 where there is certainly no cloud.
fn margin_along(direction: vec3<f32>, t: f32) -> f32 {
    let place = place_at(direction, t, FAR);
    return select(margin_at(place, t), -1.0, place.empty);
}
