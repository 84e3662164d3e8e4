// Pixels behind which nothing more can be seen are moved to the front of the depth range, where they stop what follows.
@group(1) @binding(0) var gathered: texture_2d<f32>;

@vertex
fn cull_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let at = covering(index);
    return vec4<f32>(at.xy, 0.0, 1.0);
}

@fragment
fn cull_fragment(@builtin(position) at: vec4<f32>) {
    if textureLoad(gathered, vec2<u32>(at.xy), 0).a < 1.0 - OPAQUE {
        discard;
    }
}
