// The sky behind everything else, with the deck laid over it. Twin: twin.rs.

fn disc(direction: vec3<f32>, towards: vec3<f32>, cosine: f32) -> f32 {
    let chord = direction - towards;
    let apart = 0.5 * dot(chord, chord);
    return 1.0 - smoothstep(0.81 * (1.0 - cosine), 1.21 * (1.0 - cosine), apart);
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
    var light = air_along(direction).rgb;
    if camera.eye_m <= 0.0 || crossings(direction.z, 0.0).x >= FAR {
        light += disc(direction, sky.sun_direction, sky.sun_cosine) * sky.sun_luminance
            + disc(direction, sky.moon_direction, sky.moon_cosine) * sky.moon_luminance;
    }
    return vec4<f32>(over.rgb + min(light * camera.exposure, vec3<f32>(BRIGHTEST)) * (1.0 - over.a), 0.0);
}
