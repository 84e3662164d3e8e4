// The light of the deck at a point: what light volumes, higher layers, cities and flashes send towards the eye. Stands behind
// field.wgsl, whose place in the tile and detail it reads. Twin: field.rs.

struct CityGlow {
    a: vec2<f32>,
    c: vec2<f32>,
    stretch: vec2<f32>,
    origin: vec2<f32>,
    strength: f32,
    pad0: f32,
}

// What a scene does not need is not in its pipeline.
override FLASHES: bool = true;
override SHADED: bool = true;
// What the light volumes hold: 0 shares, 1 the flux as a vector, 2 as a vector stored as n/2 + 0.5.
override FLUX: u32 = 0u;
override GLOW: bool = true;

const LIGHT_RANGE: f32 = 5.0;
const LIGHT_SLICES: f32 = 32.0;
const FLUX_FACTOR: f32 = 2.55;
const LEAST_UP: f32 = 0.07;
const SHADE_LEAST_SINE: f32 = 0.05;
const PER_STERADIAN: f32 = 0.07957747;
const BETWEEN_HEAPS: f32 = 0.5;
const RELIEF_NEAR_M: f32 = 300.0;
const CLUMP_SHADE_M: f32 = 80.0;
const CLUMP_SHADE: f32 = 1.0;
const GLOW_WIDTH_M: f32 = 512000.0;
const GLOW_SLAB: f32 = 0.08;
const CITY_COLOUR: vec3<f32> = vec3<f32>(1.0, 0.72, 0.42);

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

// What detail leaves of the source's light at a point, which light volumes do not know, against its mean: as much less as there
// is more of it on the light's way, and less between heaps than on them, where light scatters out to all sides. Near the eye
// clumps inside the cloud do it instead.
fn relieved(p: vec3<f32>, height: f32, t: f32) -> f32 {
    var left = 1.0;
    let near = variation(t);
    if near > 0.0 {
        let towards = layer.light_direction * CLUMP_SHADE_M;
        let z = stereographic(p, camera.earth_m + height);
        left = exp(-CLUMP_SHADE * near * fine(z + towards.xy, height + towards.z));
    }
    if t < layer.detail_fade_m.y {
        let towards = layer.light_direction * layer.relief_m;
        let z = stereographic(p, camera.earth_m + height);
        let more = fine(z + towards.xy, height + towards.z) - BETWEEN_HEAPS * fine(z, height);
        left *= exp(-layer.relief_depth * detail_fade(t) * smoothstep(0.0, RELIEF_NEAR_M, t) * more);
    }
    return left;
}

// Luminance that a point of cloud at a range sends towards the eye where it is opaque.
fn source(stored: vec4<f32>, view: View, p: vec3<f32>, height: f32, t: f32) -> vec3<f32> {
    var shares = lit(stored, view);
    shares.x *= relieved(p, height, t);
    if SHADED {
        shares.x *= shown(p, height);
    }
    let up = clamp((height - layer.base_m) / layer.thickness_m, 0.0, 1.0);
    var light = layer.light_lux * mix(layer.low_light, vec3<f32>(1.0), up) * shares.x + layer.sky_lux * shares.y + layer.ground_lux * shares.z;
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
