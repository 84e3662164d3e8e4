// The sky behind everything else, with the deck laid over it. Twin: twin.rs.

fn disc(direction: vec3<f32>, towards: vec3<f32>, cosine: f32) -> f32 {
    let chord = direction - towards;
    let apart = 0.5 * dot(chord, chord);
    return 1.0 - smoothstep(0.81 * (1.0 - cosine), 1.21 * (1.0 - cosine), apart);
}

struct Stars {
    x: vec3<f32>,
    sharpness: f32,
    y: vec3<f32>,
    strength: f32,
    z: vec3<f32>,
    pad0: f32,
}

override STARS: bool = true;

const CELLS: u32 = 32u;
// Light of the dark side of the moon from the Earth, as a share of the lit one's.
const EARTHSHINE: f32 = 0.0003;

@group(1) @binding(0) var<storage, read> stars: Stars;
// For each cell of the sky where its list begins, then the lists.
@group(1) @binding(1) var<storage, read> star_cells: array<u32>;
// For each star its direction and illuminance, then its colour.
@group(1) @binding(2) var<storage, read> star_list: array<vec4<f32>>;

fn star_cell(direction: vec3<f32>) -> u32 {
    let size = abs(direction);
    var axis = 2u;
    var along = vec3<f32>(direction.z, direction.x, direction.y);
    if size.x >= size.y && size.x >= size.z {
        axis = 0u;
        along = direction;
    } else if size.y >= size.z {
        axis = 1u;
        along = vec3<f32>(direction.y, direction.z, direction.x);
    }
    let share = 0.5 + 0.5 * along.yz / abs(along.x);
    let at = min(vec2<u32>(share * f32(CELLS)), vec2<u32>(CELLS - 1u));
    let face = 2u * axis + select(0u, 1u, along.x < 0.0);
    return (face * CELLS + at.y) * CELLS + at.x;
}

// Luminance of the stars along a ray outside the air.
fn starlight(direction: vec3<f32>) -> vec3<f32> {
    let turned = vec3<f32>(dot(stars.x, direction), dot(stars.y, direction), dot(stars.z, direction));
    let cell = star_cell(turned);
    let end = star_cells[cell + 1u];
    var sum = vec3<f32>(0.0);
    for (var at = star_cells[cell]; at < end; at++) {
        let star = 2u * star_cells[at];
        let found = star_list[star];
        let chord = turned - found.xyz;
        sum += star_list[star + 1u].rgb * (found.w * exp(-dot(chord, chord) * stars.sharpness));
    }
    return sum * stars.strength;
}

// Sun and moon, which may stand before the sun.
fn discs(direction: vec3<f32>) -> vec3<f32> {
    let moon = disc(direction, sky.moon_direction, sky.moon_cosine);
    var light = disc(direction, sky.sun_direction, sky.sun_cosine) * (1.0 - moon) * sky.sun_luminance;
    if moon > 0.0 {
        // Where on the moon's ball the ray ends, and how the sun stands there.
        let off = (direction - sky.moon_direction) / sqrt(2.0 * (1.0 - sky.moon_cosine));
        let normal = off - sky.moon_direction * sqrt(max(1.0 - dot(off, off), 0.0));
        let lit = smoothstep(-0.05, 0.20, dot(normal, sky.sun_direction));
        light += sky.moon_luminance * (moon * (EARTHSHINE + lit));
    }
    return light;
}

@vertex
fn sky_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return covering(index);
}

@fragment
fn sky_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let over = deck_over(at.xy);
    if 1.0 - over.a < OPAQUE {
        return vec4<f32>(over.rgb, 0.0);
    }
    let direction = ray_of(at.xy);
    let air = air_along(direction);
    let t = ground_range(at.xy, direction.z);
    var light = air.rgb;
    if TERRAIN {
        if t < FAR {
            // Air up to ground that may stand before the sky.
            var before = endless_air(air);
            if direction.z >= sky.horizon {
                before = air_before_clouds(direction);
            }
            light = before * (1.0 - air_transmittance(height_at(direction.z, t), t));
        }
    }
    if camera.eye_m <= 0.0 || t >= FAR {
        light += discs(direction);
        if STARS {
            let hidden = disc(direction, sky.moon_direction, sky.moon_cosine);
            light += starlight(direction) * (air.a * (1.0 - hidden));
        }
    }
    return vec4<f32>(over.rgb + min(light * camera.exposure, vec3<f32>(BRIGHTEST)) * (1.0 - over.a), 0.0);
}
