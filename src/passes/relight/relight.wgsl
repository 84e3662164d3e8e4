// Light of flashes' fields at a place. Stands before every pass that they light. Twin: twin.rs.

struct LitPoint {
    position_m: vec3<f32>,
    share: f32,
}

struct Lit {
    east_per_m: vec3<f32>,
    east_origin: f32,
    north_per_m: vec3<f32>,
    north_origin: f32,
    up: vec3<f32>,
    width_m: f32,
    below_m: vec3<f32>,
    below_cd: f32,
    above_m: vec3<f32>,
    above_cd: f32,
    spread_m2: vec2<f32>,
    base_m: f32,
    inverse_thickness: f32,
    intensity_cd: f32,
    cap_m2: f32,
    points: u32,
    levels: u32,
    point: array<LitPoint, 12>,
}

struct Lits {
    fields: u32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
    lit: array<Lit, 8>,
}

@group(0) @binding(8) var<storage, read> lits: Lits;
// One field above the other, each of this many levels.
@group(0) @binding(9) var quotients: texture_3d<f32>;

const LIT_LEVELS: f32 = 16.0;
const LIT_FIELDS: f32 = 8.0;
const ISOTROPIC: f32 = 0.07957747;

// What the points would give in empty air, lux of one candela.
fn lit_in_air(i: u32, p: vec3<f32>) -> f32 {
    var sum = 0.0;
    for (var k = 0u; k < lits.lit[i].points; k++) {
        let away = lits.lit[i].point[k].position_m - p;
        sum += lits.lit[i].point[k].share / (dot(away, away) + lits.lit[i].cap_m2);
    }
    return sum;
}

// Light that comes to a place below or above a field's window, out of the cloud's face and from points that lie
// beyond it: flux as a vector towards the light, and fluence.
fn lit_from_outside(i: u32, p: vec3<f32>, below: bool) -> vec4<f32> {
    let up = lits.lit[i].up;
    let side = select(1.0, -1.0, below);
    let face = select(lits.lit[i].above_m, lits.lit[i].below_m, below);
    let straight = select(lits.lit[i].above_cd, lits.lit[i].below_cd, below);
    let spread = select(lits.lit[i].spread_m2.y, lits.lit[i].spread_m2.x, below);
    let away = face - p;
    let rise = dot(away, up);
    let aside = max(dot(away, away) - rise * rise, 0.0);
    let square = rise * rise + 1.0;
    let wide = square + 2.0 * spread;
    let across = aside + wide;
    let on_plane = straight * (square * (aside - wide) + 2.0 * wide * wide) / (across * across * across);
    // Near a wide patch light comes from far above the horizon; far from it from where the patch is.
    let height = square + spread * wide / across;
    var fluence = on_plane * sqrt((aside + height) / height);
    var flux = (away - up * (side * sqrt(height) + rise)) * (on_plane / sqrt(height));
    for (var k = 0u; k < lits.lit[i].points; k++) {
        let position = lits.lit[i].point[k].position_m;
        if lits.lit[i].levels == 0u || dot(position - face, up) * side > 0.0 {
            let apart = position - p;
            let square = dot(apart, apart) + lits.lit[i].cap_m2;
            let own = lits.lit[i].intensity_cd * lits.lit[i].point[k].share / square;
            fluence += own;
            flux += apart * (own / sqrt(square));
        }
    }
    return vec4<f32>(flux, fluence);
}

// What a place scatters towards a direction of all fields' light, per unit of opacity.
fn lit_scattered(p: vec3<f32>, height: f32, towards: vec3<f32>) -> f32 {
    var sum = 0.0;
    for (var i = 0u; i < lits.fields; i++) {
        let level = (height - lits.lit[i].base_m) * lits.lit[i].inverse_thickness;
        let levels = f32(lits.lit[i].levels);
        if levels > 0.0 && (level < 0.0 || level > 1.0) {
            sum += ISOTROPIC * lit_from_outside(i, p, level < 0.0).w;
        } else {
            var quotient = ISOTROPIC;
            if levels > 0.0 {
                let east = lits.lit[i].east_per_m;
                let north = lits.lit[i].north_per_m;
                let over = f32(i) * LIT_LEVELS + clamp(level * levels, 0.5, levels - 0.5);
                let at = vec3<f32>(dot(east, p) + lits.lit[i].east_origin, dot(north, p) + lits.lit[i].north_origin,
                    over / (LIT_LEVELS * LIT_FIELDS));
                let found = textureSampleLevel(quotients, clamped, at, 0.0);
                let d = vec3<f32>(lits.lit[i].width_m * vec2<f32>(dot(east, towards), dot(north, towards)),
                    dot(lits.lit[i].up, towards));
                quotient = max(found.x + dot(found.yzw, d), 0.0);
            }
            sum += lits.lit[i].intensity_cd * quotient * lit_in_air(i, p);
        }
    }
    return sum;
}

// Illuminance of ground with this normal by all fields: from the lower face, or from the upper one where the ground
// stands above it.
fn lit_on_ground(p: vec3<f32>, normal: vec3<f32>) -> f32 {
    var sum = 0.0;
    for (var i = 0u; i < lits.fields; i++) {
        let below = dot(lits.lit[i].above_m - p, lits.lit[i].up) > 0.0;
        sum += max(dot(lit_from_outside(i, p, below).xyz, normal), 0.0);
    }
    return sum;
}
