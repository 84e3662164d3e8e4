// The ground where a ray meets it, seen through the air. Twin: twin.rs.

struct Ground {
    light_lux: vec3<f32>,
    flashes: u32,
    light_direction: vec3<f32>,
    city_luminance: f32,
    sky_lux: vec3<f32>,
    charts: u32,
    chart: array<Chart, 3>,
    flash: array<Flash, 8>,
}

@group(1) @binding(0) var<storage, read> ground: Ground;

var<private> places: array<vec2<f32>, 3>;
var<private> shares: array<f32, 3>;

fn place(from_centre: vec3<f32>, z: vec2<f32>) {
    var best = -1.0;
    for (var i = 0u; i < ground.charts; i++) {
        best = max(best, dot(from_centre, ground.chart[i].w) / camera.earth_m);
    }
    var sum = 0.0;
    for (var i = 0u; i < ground.charts; i++) {
        let raw = dot(from_centre, ground.chart[i].w) / camera.earth_m;
        shares[i] = select(max(ground.chart[i].zone + raw - best, 0.0), 1.0, ground.charts == 1u);
        sum += shares[i];
        let moved = displacement(ground.chart[i].a, ground.chart[i].c, z);
        places[i] = ground.chart[i].map_origin + map_coordinates(moved);
    }
    for (var i = 0u; i < ground.charts; i++) {
        shares[i] /= sum;
    }
}

fn pattern(scale: f32, offset: f32) -> f32 {
    var sum = 0.0;
    for (var i = 0u; i < ground.charts; i++) {
        if shares[i] > 0.0 {
            sum += shares[i] * textureSampleLevel(map, repeated, places[i] * scale + offset, 0.0).r;
        }
    }
    return sum;
}

fn detail_fade(texel: f32, footprint: f32) -> f32 {
    return 1.0 - smoothstep(0.5 * texel, 2.0 * texel, footprint);
}

fn ground_luminance(direction: vec3<f32>, t: f32, passed: f32) -> vec3<f32> {
    let p = direction * t + vec3<f32>(0.0, 0.0, camera.eye_m);
    let normal = (p + vec3<f32>(0.0, 0.0, camera.earth_m)) / camera.earth_m;
    place(normal * camera.earth_m, stereographic(p, camera.earth_m));
    let footprint = t * t / max(camera.eye_m, 10.0) * length(camera.up) * 2.0 / camera.height_px;
    let rough = 0.03 * detail_fade(2000.0, footprint) * (pattern(8.0, 0.37) - 0.5);
    let sea = 1.0 - smoothstep(0.405, 0.415, pattern(1.0, 0.0) + rough);
    let fields = detail_fade(160.0, footprint) * (pattern(5.0, 0.61) - 0.5)
        + 0.7 * detail_fade(40.0, footprint) * (pattern(20.0, 0.17) - 0.5);
    let relief = detail_fade(800.0, footprint) * (pattern(3.0, 0.83) - 0.5);
    let land = vec3<f32>(0.125, 0.135, 0.070) + vec3<f32>(0.085, 0.060, 0.035) * fields
        + vec3<f32>(0.03, 0.035, 0.02) * relief;
    let albedo = land + (vec3<f32>(0.012, 0.030, 0.045) - land) * sea;
    let direct = max(dot(normal, ground.light_direction), 0.0) * passed;
    var lit = ground.light_lux * direct + ground.sky_lux;
    for (var i = 0u; i < ground.flashes; i++) {
        let towards = ground.flash[i].position_m - p;
        let d2 = max(dot(towards, towards), FLASH_CAP_M * FLASH_CAP_M);
        let cosine = max(dot(normal, towards) / sqrt(d2), 0.0);
        lit += FLASH_COLOUR * (12.56637 * ground.flash[i].intensity * cosine / d2);
    }
    var seen = lit * albedo * 0.31830987;
    let facing = clamp(-dot(direction, normal), 0.0, 1.0);
    let fresnel = 0.02 + 0.6 * pow(1.0 - facing, 5.0);
    let middle = ground.light_direction - direction;
    let half_way = middle / max(length(middle), 1e-6);
    let glitter = pow(max(dot(half_way, normal), 0.0), 220.0) * 2.5 * passed * fresnel;
    seen += (ground.sky_lux * (0.31830987 * fresnel) + ground.light_lux * glitter) * sea;
    let towns = smoothstep(0.86, 0.97, pattern(9.0, 0.29)) * (1.0 - sea) * (0.35 + 0.65 * pattern(60.0, 0.71));
    return seen + vec3<f32>(1.0, 0.72, 0.42) * (ground.city_luminance * towns);
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
    if camera.eye_m <= 0.0 || t >= FAR || shows < OPAQUE {
        return vec4<f32>(0.0);
    }
    let air = air_along(direction);
    let seen = ground_luminance(direction, t, 1.0) * (air.a * shows);
    return vec4<f32>(min(seen * camera.exposure, vec3<f32>(BRIGHTEST)), 0.0);
}
