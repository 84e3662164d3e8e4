// The lamps of cities, single ones as far as a pixel can tell them apart. Stands behind ground.wgsl. Twin: lamps.rs.

// Cells of the finest lamps, how many of a cell's sides a pixel may span, a lamp's spread in its cell, and a period of the cells.
const LAMP_M: f32 = 64.0;
const LAMP_CELLS: f32 = 0.45;
const LAMP_SPREAD: f32 = 0.11;
const STREETS_M: f32 = 80.0;
const LAMP_PERIOD: i32 = 1024;
// Looks along a footprint at most.
const LAMP_LOOKS: f32 = 10.0;

// Lamps about a place of the first chart, 1 in the mean, of a pixel whose footprint reaches over `along` of the chart and is `across`
// wide: one in each cell, the cells as large as a look can tell apart.
fn lamps(place_m: vec2<f32>, along: vec2<f32>, across: f32, footprint: f32, places: Places) -> vec3<f32> {
    let long = length(along);
    let width = max(across, long * (1.0 / LAMP_LOOKS));
    let looks = clamp(ceil(long / width), 1.0, LAMP_LOOKS);
    let size = max(width * (1.0 / LAMP_CELLS), LAMP_M);
    // A device's logarithm of 1 may lie below 0.
    let octave = max(log2(size * (1.0 / LAMP_M)), 0.0);
    let low = floor(octave);
    var light = vec3<f32>(0.0);
    for (var look = 0u; look < u32(looks); look++) {
        let straight = place_m + along * ((f32(look) + 0.5) / looks - 0.5);
        let at = straight + bent(straight);
        light += mix(lamps_of(at, u32(low), width), lamps_of(at, u32(low) + 1u, width), octave - low);
    }
    // Streets and squares gather lamps, parks have none.
    let district = 1.0 + 2.2 * detail(places, 20.0, 0.71, detail_fade(40.0, footprint));
    return light * (clamp(district, 0.1, 2.2) / looks);
}

// The error function (Winitzki 2008, within 2e-4).
fn error_function(x: f32) -> f32 {
    let squared = x * x;
    return sign(x) * sqrt(1.0 - exp(-squared * (1.2732395 + 0.147 * squared) / (1.0 + 0.147 * squared)));
}

// Streets bend: waves of the charts' period, made of parabolas, which every device computes alike. (A map that is sampled is not: its
// weights of 8 bits moved lamps by half a metre.)
fn bent(place_m: vec2<f32>) -> vec2<f32> {
    let p = place_m * (1.0 / (LAMP_M * f32(LAMP_PERIOD)));
    let phase = vec4<f32>(37.0 * p.x + 22.0 * p.y, 41.0 * p.y - 25.0 * p.x, 83.0 * p.x - 61.0 * p.y, 59.0 * p.x + 97.0 * p.y);
    let f = phase - floor(phase + 0.5);
    let wave = f * (8.0 - 16.0 * abs(f));
    return STREETS_M * (wave.xy + 0.5 * wave.zw);
}

fn lamps_of(place_m: vec2<f32>, octave: u32, footprint: f32) -> vec3<f32> {
    let size = LAMP_M * f32(1u << min(octave, 24u));
    let at = place_m / size;
    let cell = floor(at);
    // As many cells as the charts' period holds, so that it does not show.
    let period = max(LAMP_PERIOD >> min(octave, 10u), 1);
    let lot = vec2<u32>(vec2<i32>(cell) & vec2<i32>(period - 1)) + vec2<u32>(octave * 4096u, 77u);
    let jitter = hash2(lot);
    let kind = hash2(lot + 8191u);
    let middle = 0.55 * (jitter - 0.5);
    let away = at - cell - 0.5 - middle;
    // Gaussian spots, as wide as the pixel blurs them (a square has the variance f^2 / 12 each way), whose mean over the cell is 1;
    // brighter and fainter ones, warmer and whiter ones.
    let blur = footprint / size;
    let spread = sqrt(LAMP_SPREAD * LAMP_SPREAD + blur * blur * (1.0 / 6.0));
    let upper = (vec2<f32>(0.5) - middle) / spread;
    let lower = (vec2<f32>(0.5) + middle) / spread;
    let inside = 0.25 * (error_function(upper.x) + error_function(lower.x)) * (error_function(upper.y) + error_function(lower.y));
    let spot = exp(-dot(away, away) / (spread * spread)) / (3.14159265 * spread * spread * inside);
    let bright = 2.5 * kind.x * kind.x + 0.167;
    // The larger the cell the more lamps it stands for, the less they differ.
    let rough = 0.85 / (1.0 + 0.35 * f32(octave));
    let colour = mix(vec3<f32>(1.0, 0.66, 0.34), vec3<f32>(0.95, 0.86, 0.72), kind.y);
    return colour * mix(1.0, spot * bright, rough);
}
