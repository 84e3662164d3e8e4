// Fields of virtual lights summed on the device, back from Haar coefficients, into the quotients that pictures read (Dobashi
// et al. 2007, eq. 8 and 9). Twin: sum.rs.

struct SumHead {
    cells: vec3<u32>,
    components: u32,
    lights: u32,
    levels: u32,
    slot: u32,
    pad0: u32,
}

// The coefficients of one component of one light.
struct SumPart {
    first: u32,
    count: u32,
    weight: f32,
    pad0: u32,
}

@group(0) @binding(0) var<storage, read> head: SumHead;
// Light after light, component after component.
@group(0) @binding(1) var<storage, read> parts: array<SumPart>;
@group(0) @binding(2) var<storage, read> places: array<u32>;
@group(0) @binding(3) var<storage, read> values: array<f32>;
// Of each component its share in the mean and in three times the mean of directions.
@group(0) @binding(4) var<storage, read> shares: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> in_air: array<f32>;
// Component after component: coefficients, then light.
@group(0) @binding(6) var<storage, read_write> fields: array<f32>;
@group(0) @binding(7) var quotients: texture_storage_3d<rgba16float, write>;

const THREADS: u32 = 64u;
const ROOT_HALF: f32 = 0.70710678;

// One workgroup a component: lights one after another, so that sums have one order.
@compute @workgroup_size(64)
fn sum(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let count = head.cells.x * head.cells.y * head.cells.z;
    let base = group.x * count;
    for (var i = lane; i < count; i += THREADS) {
        fields[base + i] = 0.0;
    }
    for (var light = 0u; light < head.lights; light++) {
        storageBarrier();
        let part = parts[light * head.components + group.x];
        // No place comes twice in a part.
        for (var k = lane; k < part.count; k += THREADS) {
            let at = base + places[part.first + k];
            fields[at] += part.weight * values[part.first + k];
        }
    }
    // From the coarsest level to the cells; at each level up, north, east.
    for (var step = 0u; step < 3u * head.levels; step++) {
        storageBarrier();
        let level = head.levels - 1u - step / 3u;
        let axis = 2u - step % 3u;
        let add = vec3<u32>((1u << level) - 1u);
        let size = (head.cells + add) >> vec3<u32>(level);
        let stride = vec3<u32>(1u, head.cells.x, head.cells.x * head.cells.y);
        let n = size[axis];
        // The two axes across.
        let a = select(0u, 1u, axis == 0u);
        let b = select(2u, 1u, axis == 2u);
        let lines = select(0u, size[a] * size[b], n > 1u);
        for (var line = lane; line < lines; line += THREADS) {
            let start = base + line % size[a] * stride[a] + line / size[a] * stride[b];
            join(start, stride[axis], n);
        }
    }
}

// Sums in front of differences become pairs; the odd last value stays.
fn join(start: u32, stride: u32, n: u32) {
    var found: array<f32, 64>;
    let half = (n + 1u) / 2u;
    for (var k = 0u; k < n; k++) {
        found[k] = fields[start + k * stride];
    }
    for (var k = 0u; k < n / 2u; k++) {
        fields[start + 2u * k * stride] = (found[k] + found[half + k]) * ROOT_HALF;
        fields[start + (2u * k + 1u) * stride] = (found[k] - found[half + k]) * ROOT_HALF;
    }
    if n % 2u == 1u {
        fields[start + (n - 1u) * stride] = found[half - 1u];
    }
}

// One invocation a cell: what all directions give, over what the points would give in empty air.
@compute @workgroup_size(4, 4, 4)
fn store(@builtin(global_invocation_id) id: vec3<u32>) {
    let count = head.cells.x * head.cells.y * head.cells.z;
    let at = min(id, head.cells - vec3<u32>(1u));
    let cell = at.x + head.cells.x * (at.y + head.cells.y * at.z);
    var moments = vec4<f32>(0.0);
    for (var component = 0u; component < head.components; component++) {
        moments += shares[component] * max(fields[component * count + cell], 0.0);
    }
    // A sum of four terms is nowhere negative if the lean is no more than the mean.
    let lean = length(moments.yzw);
    let keep = select(1.0, moments.x / lean, lean > moments.x);
    let quotient = moments * vec4<f32>(1.0, vec3<f32>(keep)) / in_air[cell];
    if all(id < head.cells) {
        textureStore(quotients, vec3<i32>(id + vec3<u32>(0u, 0u, head.slot)), min(quotient, vec4<f32>(65000.0)));
    }
}
