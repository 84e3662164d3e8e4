// The ground where a ray meets it, seen through the air. Twin: twin.rs.

struct Ground {
    light_lux: vec3<f32>,
    flashes: u32,
    light_direction: vec3<f32>,
    city_luminance: f32,
    sky_lux: vec3<f32>,
    charts: u32,
    chart: array<Chart, 3>,
    flash: array<Flash, 64>,
}

@group(1) @binding(0) var<storage, read> ground: Ground;
// Share of the light that reaches the ground between the clouds.
@group(1) @binding(1) var shadows: texture_2d<f32>;

// What a scene does not need is not in its pipeline.
override SEVERAL_CHARTS: bool = true;
override FLASHES: bool = true;
override CITIES: bool = true;
override SHADOWS: bool = true;

// Where a point lies in the map by each chart, and the charts' weights. No arrays: indexed ones live in memory.
struct Places {
    first: vec2<f32>,
    second: vec2<f32>,
    third: vec2<f32>,
    weights: vec3<f32>,
}

fn place(chart: u32, z: vec2<f32>) -> vec2<f32> {
    let moved = displacement(ground.chart[chart].a, ground.chart[chart].c, z);
    return ground.chart[chart].map_origin + map_coordinates(moved);
}

fn lead(chart: u32, up: vec3<f32>) -> f32 {
    return select(-2.0, dot(up, ground.chart[chart].w), chart < ground.charts);
}

// `up`: unit vector from the Earth's centre.
fn places_of(up: vec3<f32>, z: vec2<f32>) -> Places {
    var places = Places(place(0u, z), vec2<f32>(0.0), vec2<f32>(0.0), vec3<f32>(1.0, 0.0, 0.0));
    if SEVERAL_CHARTS {
        places.second = place(1u, z);
        places.third = place(2u, z);
        let leads = vec3<f32>(lead(0u, up), lead(1u, up), lead(2u, up));
        let best = max(leads.x, max(leads.y, leads.z));
        let zones = vec3<f32>(ground.chart[0].zone, ground.chart[1].zone, ground.chart[2].zone);
        let weights = max(zones + leads - best, vec3<f32>(0.0));
        places.weights = weights / (weights.x + weights.y + weights.z);
    }
    return places;
}

fn map_at(place: vec2<f32>) -> f32 {
    return textureSampleLevel(map, repeated, place, 0.0).r;
}

fn pattern(places: Places, scale: f32, offset: f32) -> f32 {
    var sum = map_at(places.first * scale + offset);
    if SEVERAL_CHARTS {
        sum *= places.weights.x;
        if places.weights.y > 0.0 {
            sum += places.weights.y * map_at(places.second * scale + offset);
        }
        if places.weights.z > 0.0 {
            sum += places.weights.z * map_at(places.third * scale + offset);
        }
    }
    return sum;
}

// The same less its mean, faded out where it is finer than a pixel's footprint.
fn detail(places: Places, scale: f32, offset: f32, fade: f32) -> f32 {
    if fade <= 0.0 {
        return 0.0;
    }
    return fade * (pattern(places, scale, offset) - 0.5);
}

fn detail_fade(texel: f32, footprint: f32) -> f32 {
    return 1.0 - smoothstep(0.5 * texel, 2.0 * texel, footprint);
}

fn ground_luminance(direction: vec3<f32>, t: f32, passed: f32) -> vec3<f32> {
    let p = direction * t + vec3<f32>(0.0, 0.0, camera.eye_m);
    let normal = (p + vec3<f32>(0.0, 0.0, camera.earth_m)) / camera.earth_m;
    let places = places_of(normal, stereographic(p, camera.earth_m));
    let footprint = t * t / max(camera.eye_m, 10.0) * length(camera.up) * 2.0 / camera.height_px;
    let rough = 0.03 * detail(places, 8.0, 0.37, detail_fade(2000.0, footprint));
    let sea = 1.0 - smoothstep(0.405, 0.415, pattern(places, 1.0, 0.0) + rough);
    let fields = detail(places, 5.0, 0.61, detail_fade(160.0, footprint))
        + 0.7 * detail(places, 20.0, 0.17, detail_fade(40.0, footprint));
    let relief = detail(places, 3.0, 0.83, detail_fade(800.0, footprint));
    let land = vec3<f32>(0.125, 0.135, 0.070) + vec3<f32>(0.085, 0.060, 0.035) * fields
        + vec3<f32>(0.03, 0.035, 0.02) * relief;
    let albedo = land + (vec3<f32>(0.012, 0.030, 0.045) - land) * sea;
    let direct = max(dot(normal, ground.light_direction), 0.0) * passed;
    var lit = ground.light_lux * direct + ground.sky_lux;
    if FLASHES {
        for (var i = 0u; i < ground.flashes; i++) {
            let towards = ground.flash[i].position_m - p;
            let d2 = max(dot(towards, towards), FLASH_CAP_M * FLASH_CAP_M);
            let cosine = max(dot(normal, towards) / sqrt(d2), 0.0);
            lit += FLASH_COLOUR * (12.56637 * ground.flash[i].intensity * cosine / d2);
        }
    }
    var seen = lit * albedo * 0.31830987;
    let facing = clamp(-dot(direction, normal), 0.0, 1.0);
    let fresnel = 0.02 + 0.6 * pow(1.0 - facing, 5.0);
    let middle = ground.light_direction - direction;
    let half_way = middle / max(length(middle), 1e-6);
    let glitter = pow(max(dot(half_way, normal), 0.0), 220.0) * 2.5 * passed * fresnel;
    seen += (ground.sky_lux * (0.31830987 * fresnel) + ground.light_lux * glitter) * sea;
    if CITIES {
        let towns = smoothstep(0.86, 0.97, pattern(places, 9.0, 0.29)) * (1.0 - sea)
            * (0.35 + 0.65 * pattern(places, 60.0, 0.71));
        seen += vec3<f32>(1.0, 0.72, 0.42) * (ground.city_luminance * towns);
    }
    return seen;
}

@vertex
fn ground_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return covering(index);
}

@fragment
fn ground_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let direction = ray_of(at.xy);
    let t = crossings(direction.z, 0.0).x;
    let shows = 1.0 - deck_over(at.xy).a;
    // No return stands before a loop: lavapipe lets it run to its end for pixels that have returned.
    var seen = vec3<f32>(0.0);
    if camera.eye_m > 0.0 && t < FAR && shows >= OPAQUE {
        var passed = 1.0;
        if SHADOWS {
            passed = textureSampleLevel(shadows, clamped, at.xy / vec2<f32>(camera.width_px, camera.height_px), 0.0).r;
        }
        seen = ground_luminance(direction, t, passed) * (air_along(direction).a * shows);
    }
    return vec4<f32>(min(seen * camera.exposure, vec3<f32>(BRIGHTEST)), 0.0);
}
