// The ground where a ray meets it, seen through the air. Stands behind relief/field.wgsl and hills.wgsl, before lamps.wgsl. Twin: twin.rs.

// A lamp of the own ship.
struct Lamp {
    position_m: vec3<f32>,
    intensity_cd: f32,
    axis: vec3<f32>,
    narrowness: f32,
}

struct Ground {
    light_lux: vec3<f32>,
    flashes: u32,
    light_direction: vec3<f32>,
    city_luminance: f32,
    sky_lux: vec3<f32>,
    charts: u32,
    snow_m: f32,
    shore_m: f32,
    glow_lux: f32,
    glow_level: f32,
    above_light_lux: vec3<f32>,
    sheet_base_m: f32,
    above_sky_lux: vec3<f32>,
    sheet_top_m: f32,
    lamps: u32,
    hills: u32,
    pad0: u32,
    pad1: u32,
    lamp: array<Lamp, 4>,
    chart: array<Chart, 3>,
    flash: array<Flash, 64>,
}

@group(1) @binding(0) var<storage, read> ground: Ground;
// Luminance of lamps by place, on the relief's grids.
@group(2) @binding(2) var<storage, read> lights: array<u32>;
// Share of the light that reaches the ground between the clouds.
@group(1) @binding(1) var shadows: texture_2d<f32>;

// What a scene does not need is not in its pipeline.
override SEVERAL_CHARTS: bool = true;
override FLASHES: bool = true;
override CITIES: bool = true;
override SHADOWS: bool = true;
override LAND: bool = true;
override OWN_LAMPS: bool = true;
// Colour of the light of cities.
const CITY_COLOUR: vec3<f32> = vec3<f32>(1.0, 0.72, 0.42);

// Mean albedo of fields far away.
const FIELDS: vec3<f32> = vec3<f32>(0.125, 0.132, 0.062);
const BLOCK_M: f32 = 2048.0;
const BLOCKS: i32 = 32;
// Mean square slope of the waves in a wind of 5 m/s.
const WAVE_SLOPES: f32 = 0.029;

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

// A number in [0, 1) each, of two counters (Jarzynski and Olano 2020, pcg2d).
fn hash2(counters: vec2<u32>) -> vec2<f32> {
    var v = counters * 1664525u + 1013904223u;
    v.x += v.y * 1664525u;
    v.y += v.x * 1664525u;
    v ^= v >> vec2<u32>(16u);
    v.x += v.y * 1664525u;
    v.y += v.x * 1664525u;
    v ^= v >> vec2<u32>(16u);
    return vec2<f32>(v >> vec2<u32>(8u)) * (1.0 / 16777216.0);
}

// Colour of the field at a place of the first chart in metres: blocks of 2 km, each with fields of its own size and turn.
fn field_albedo(place_m: vec2<f32>) -> vec3<f32> {
    let at = place_m * (1.0 / BLOCK_M);
    let block = floor(at);
    // The charts' origins are told in periods of so many blocks.
    let lot = vec2<u32>(vec2<i32>(block) & vec2<i32>(BLOCKS - 1));
    let kind = hash2(lot);
    let turn = vec2<f32>(cos(3.14159265 * kind.x), sin(3.14159265 * kind.x));
    let local = (at - block - 0.5) * BLOCK_M;
    let turned = vec2<f32>(turn.x * local.x - turn.y * local.y, turn.y * local.x + turn.x * local.y);
    let size = vec2<f32>(190.0 + 260.0 * kind.y, 120.0 + 160.0 * fract(kind.y * 7.0));
    let cell = vec2<u32>(vec2<i32>(floor(turned / size)) + 512);
    let crop = hash2(cell + lot * 1024u);
    var found = vec3<f32>(0.070, 0.112, 0.038);
    found = select(found, vec3<f32>(0.108, 0.150, 0.052), crop.x > 0.3);
    found = select(found, vec3<f32>(0.205, 0.178, 0.086), crop.x > 0.6);
    found = select(found, vec3<f32>(0.138, 0.104, 0.068), crop.x > 0.84);
    return found * (0.85 + 0.3 * crop.y);
}

struct Country {
    albedo: vec3<f32>,
    sea: f32,
}

// What clouds send down of the light of the cities around, as a share of a core's.
fn cloud_glow(place_m: vec2<f32>, own: f32) -> f32 {
    let level = max(ground.glow_level, own);
    let wide = min(level + 1.6, f32(LEVELS - 1u));
    return 0.6 * city_light(place_m, level) + 0.4 * city_light(place_m, wide);
}

// What the ground is made of: `shore` above 0 on land, `steep` the tangent of its slope.
fn country(places: Places, z: vec2<f32>, shore: f32, height: f32, steep: f32, footprint: f32) -> Country {
    let soft = max(8.0, 0.3 * footprint);
    let sea = 1.0 - smoothstep(-soft, soft, shore);
    let broad = detail(places, 3.0, 0.83, detail_fade(800.0, footprint));
    let middle = detail(places, 14.0, 0.17, detail_fade(56.0, footprint));
    let small = detail(places, 60.0, 0.53, detail_fade(13.0, footprint));
    var land = FIELDS + vec3<f32>(0.03, 0.035, 0.02) * broad;
    let near = 1.0 - smoothstep(50.0, 200.0, footprint);
    if near > 0.0 {
        let bent = 420.0 * vec2<f32>(detail(places, 30.0, 0.1, 1.0), detail(places, 30.0, 0.6, 1.0));
        let at = ground.chart[0].tile_origin_m + displacement(ground.chart[0].a, ground.chart[0].c, z) + bent;
        land += (field_albedo(at) - FIELDS) * near;
    }
    let rough = 2.0 * middle + small;
    let woods = smoothstep(0.06, 0.20, 0.9 * middle + 0.5 * small + 0.8 * broad + 0.0001 * height + 0.35 * steep);
    land = mix(land, vec3<f32>(0.036, 0.052, 0.026) * (1.0 + 0.8 * small), woods);
    let high = smoothstep(-1100.0, -500.0, height - ground.snow_m + 500.0 * rough);
    land = mix(land, vec3<f32>(0.112, 0.112, 0.060) * (1.0 + 0.7 * rough), high);
    let bare = smoothstep(0.55, 1.05, steep + 0.5 * rough + 0.35 * high);
    land = mix(land, vec3<f32>(0.145, 0.138, 0.128) * (1.0 + 0.7 * rough), bare);
    let snow = smoothstep(-250.0, 250.0, height - ground.snow_m + 600.0 * rough)
        * (1.0 - smoothstep(0.9, 1.5, steep + 0.4 * rough));
    land = mix(land, vec3<f32>(0.74, 0.77, 0.81), snow);
    land = mix(land, vec3<f32>(0.29, 0.255, 0.19), (1.0 - smoothstep(15.0, 60.0 + soft, shore)) * (1.0 - bare));
    let shallow = exp(min(shore, 0.0) * (1.0 / 500.0));
    let water = mix(vec3<f32>(0.006, 0.020, 0.032), vec3<f32>(0.030, 0.075, 0.080), shallow * shallow);
    return Country(mix(land, water, sea), sea);
}

// Mean luminance of lamps as a share of a city's core.
fn city_light(place_m: vec2<f32>, level: f32) -> f32 {
    let low = min(u32(level), LEVELS - 1u);
    let share = max((level - f32(low) - ITSELF) * (1.0 / (1.0 - ITSELF)), 0.0);
    var found = city_light_of_level(low, place_m);
    if share > 0.0 && low + 1u < LEVELS {
        found = mix(found, city_light_of_level(low + 1u, place_m), share);
    }
    return found;
}

fn city_light_of_level(level: u32, place_m: vec2<f32>) -> f32 {
    let lies = relief.level[level];
    let at = clamp(lies.xy + place_m / lies.z, vec2<f32>(0.0), vec2<f32>(f32(WIDTH - 1u) - 0.001));
    let low = floor(at);
    let f = at - low;
    let first = level * WIDTH * WIDTH + u32(low.y) * WIDTH + u32(low.x);
    let south = mix(bitcast<f32>(lights[first]), bitcast<f32>(lights[first + 1u]), f.x);
    let north = mix(bitcast<f32>(lights[first + WIDTH]), bitcast<f32>(lights[first + WIDTH + 1u]), f.x);
    return mix(south, north, f.y);
}

// Illuminance by the own ship's lamps.
fn own_lamps(p: vec3<f32>, normal: vec3<f32>, height: f32, t: f32) -> f32 {
    var lux = 0.0;
    for (var i = 0u; i < ground.lamps; i++) {
        let lamp = ground.lamp[i];
        let way = p - vec3<f32>(0.0, 0.0, camera.eye_m) - lamp.position_m;
        let distance = max(length(way), 1.0);
        let towards = way / distance;
        let away = towards - lamp.axis;
        let shines = lamp.intensity_cd * exp(-dot(away, away) * lamp.narrowness);
        lux += shines * max(-dot(normal, towards), 0.0) / (distance * distance);
    }
    return lux * air_transmittance(height, t);
}

fn ground_luminance(direction: vec3<f32>, t: f32, through_clouds: f32) -> vec3<f32> {
    let p = direction * t + vec3<f32>(0.0, 0.0, camera.eye_m);
    var height = 0.0;
    if TERRAIN {
        height = height_at(direction.z, t);
    }
    let radius = camera.earth_m + height;
    let up = (p + vec3<f32>(0.0, 0.0, camera.earth_m)) / radius;
    let z = stereographic(p, radius);
    let places = places_of(up, z);
    let footprint = t * 2.0 * length(camera.up) / (camera.height_px * clamp(-dot(direction, up), 0.02, 1.0));
    var normal = up;
    var shore = ground.shore_m;
    var steep = 0.0;
    var passed = through_clouds;
    var glow = 0.0;
    if LAND {
        let place = relief_place(p, radius);
        let level = relief_level(place, t);
        shore = relief_at(place, level).y;
        if TERRAIN {
            let slope = relief_slope(place, level);
            steep = length(slope);
            normal = normalize(up - vec3<f32>(slope, 0.0));
            if HILLS {
                passed *= through_hills(ground.light_direction, up, p, height, t);
            }
        }
        if CITIES && ground.glow_lux > 0.0 {
            glow = ground.glow_lux * cloud_glow(place, level);
        }
    }
    // Ground that stands over a sheet of cloud is lit as above it.
    let over = smoothstep(ground.sheet_base_m, ground.sheet_top_m, height);
    let light_lux = mix(ground.light_lux, ground.above_light_lux, over);
    let sky_lux = mix(ground.sky_lux, ground.above_sky_lux, over) + CITY_COLOUR * (glow * (1.0 - over));
    let made = country(places, z, shore, height, steep, footprint);
    let direct = max(dot(normal, ground.light_direction), 0.0) * passed;
    // A slope sees less of the sky, and for it lit ground.
    let open = 0.5 + 0.5 * dot(normal, up);
    var lit = light_lux * direct + sky_lux * open
        + (light_lux * max(dot(up, ground.light_direction), 0.0) + sky_lux) * (0.13 * (1.0 - open));
    if FLASHES {
        for (var i = 0u; i < ground.flashes; i++) {
            let towards = ground.flash[i].position_m - p;
            let d2 = max(dot(towards, towards), FLASH_CAP_M * FLASH_CAP_M);
            let cosine = max(dot(normal, towards) / sqrt(d2), 0.0);
            lit += FLASH_COLOUR * (12.56637 * ground.flash[i].intensity * cosine / d2);
        }
    }
    if FLASHES {
        lit += FLASH_COLOUR * lit_on_ground(p, normal);
    }
    if OWN_LAMPS {
        lit += vec3<f32>(own_lamps(p, normal, height, t));
    }
    var seen = lit * made.albedo * 0.31830987;
    // The sea mirrors the sky (Schlick), and the light by waves whose slopes are spread evenly (Cox and Munk 1954).
    let facing = clamp(-dot(direction, up), 0.0, 1.0);
    let fresnel = 0.02 + 0.6 * pow(1.0 - facing, 5.0);
    let middle = ground.light_direction - direction;
    let half_way = middle / max(length(middle), 1e-6);
    let level_share = clamp(dot(half_way, up), 0.05, 1.0);
    let squared = level_share * level_share;
    let spread = exp((squared - 1.0) / (squared * WAVE_SLOPES)) / (3.14159265 * WAVE_SLOPES * squared * squared);
    let grazing = clamp(dot(half_way, ground.light_direction), 0.0, 1.0);
    let mirrors = 0.02 + 0.98 * pow(1.0 - grazing, 5.0);
    let risen = smoothstep(-0.01, 0.01, dot(up, ground.light_direction));
    let glitter = risen * mirrors * spread * passed / (4.0 * max(facing, 0.12));
    seen += (sky_lux * (0.31830987 * fresnel) + light_lux * glitter) * made.sea;
    if CITIES {
        let place = relief_place(p, radius);
        let mean = city_light(place, relief_level(place, t)) * (1.0 - made.sea);
        if mean > 1e-4 {
            let moved = displacement(ground.chart[0].a, ground.chart[0].c, z);
            // Over as much ground as the pixel's footprint is long.
            let level_part = direction - up * dot(direction, up);
            let ahead = level_part * (footprint / max(length(level_part), 1e-6));
            let along = displacement(ground.chart[0].a, ground.chart[0].c, stereographic(p + ahead, radius)) - moved;
            let across = footprint * clamp(-dot(direction, up), 0.02, 1.0);
            let found = lamps(ground.chart[0].tile_origin_m + moved, along, across, footprint, places);
            seen += found * (ground.city_luminance * mean);
        }
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
    let t = ground_range(at.xy, direction.z);
    let shows = 1.0 - deck_over(at.xy).a;
    // No return stands before a loop: lavapipe lets it run to its end for pixels that have returned.
    var seen = vec3<f32>(0.0);
    if camera.eye_m > 0.0 && t < FAR && shows >= OPAQUE {
        var passed = 1.0;
        if SHADOWS {
            passed = textureSampleLevel(shadows, clamped, at.xy / vec2<f32>(camera.width_px, camera.height_px), 0.0).r;
        }
        var clear = air_along(direction).a;
        if TERRAIN {
            clear = air_transmittance(height_at(direction.z, t), t);
        }
        seen = ground_luminance(direction, t, passed) * (clear * shows);
    }
    return vec4<f32>(min(seen * camera.exposure, vec3<f32>(BRIGHTEST)), 0.0);
}
