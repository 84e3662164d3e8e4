//! The air: what it is made of, and extinction of light on its way through it.
//!
//! Scale heights are 8 km (molecules) and 1.2 km (haze), ozone is a tent of 300 Dobson units about 25 km (Bruneton 2017);
//! illuminance outside the air is 128 klx. Three colours stand for the spectrum, and their coefficients are not those of three
//! wavelengths: they are fitted so that light scattered once has the colours (linear sRGB, the sun outside the air as white) that
//! the spectrum gives, from the zenith to 8 degrees over the horizon and from a sun at 60 degrees to one at -5. With 680, 550 and 440 nm, as
//! usual (Hillaire 2020, table 1), red stands far outside ozone's Chappuis band, which is strongest at 600 nm, and a
//! twilight's zenith is lilac where it is blue (Hulburt 1953).

use crate::passes::common::{AIR_SCALE_M, HAZE_SCALE_M};
use glam::Vec3;
use std::sync::LazyLock;

/// Illuminance of the sun outside the atmosphere, lux.
pub const SUN_LUX: f32 = 128_000.0;
/// Illuminance of the full moon outside the atmosphere, lux.
pub const MOON_LUX: f32 = 0.32;
/// Molecular scattering at sea level, 1/m, by colour (fitted, see above).
pub const RAYLEIGH_PER_M: Vec3 = Vec3::new(7.29e-6, 14.32e-6, 31.59e-6);
/// Absorption where ozone is densest, 1/m, by colour (fitted likewise).
const OZONE_PER_M: Vec3 = Vec3::new(2.41e-6, 1.71e-6, 0.007e-6);
/// Extinction there by the stratosphere's own haze, 1/m: a depth of 0.006, as between eruptions (Kremser et al. 2016: 0.003 to
/// 0.01), which a twilight's light crosses forty times as thick. By its profile it is taken as if it were ozone.
const HIGH_HAZE_PER_M: f32 = 0.4e-6;
/// Radius of the Earth for the air, m.
pub const EARTH_M: f32 = 6_371_000.0;
/// Height at which the air ends.
pub const TOP_M: f32 = 100_000.0;
/// Haze particles absorb a tenth of what they take out (Hillaire 2020, table 1).
pub const HAZE_ALBEDO: f32 = 0.9;
/// Asymmetry of their phase function.
pub const HAZE_ASYMMETRY: f32 = 0.76;
const HEIGHTS: usize = 64;
const COSINES: usize = 256;

/// Air with a given amount of haze.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Air {
    /// Extinction of the haze at height 0, 1/m.
    pub haze_per_m: f32,
}

/// A source at infinity: sun or moon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Luminary {
    /// Unit direction towards it (east, north, up).
    pub direction: Vec3,
    /// Illuminance outside the air on a plane facing it, lux, per colour.
    pub illuminance_lux: Vec3,
}

impl Air {
    /// Transmittance from a height to space in a direction of cosine `up` against the zenith; 0 behind the Earth.
    pub fn transmittance(&self, height_m: f32, up: f32) -> Vec3 {
        let [rayleigh, haze, ozone] = columns(height_m, up);
        (-(RAYLEIGH_PER_M * rayleigh + Vec3::splat(self.haze_per_m * haze) + absorbed() * ozone)).exp()
    }

    /// Optical depth of the haze from a height to space; huge behind the Earth.
    pub fn haze_depth(&self, height_m: f32, up: f32) -> f32 {
        self.haze_per_m * columns(height_m, up)[1]
    }
}

/// A point of a ray in the air.
pub struct Medium {
    /// Height of the point.
    pub height_m: f32,
    /// Cosine of a light's direction against the zenith there.
    pub up: f32,
}

impl Medium {
    /// The point at range `t_m` along a ray from a height.
    pub fn along(eye_m: f32, direction: Vec3, light: Vec3, t_m: f32) -> Self {
        let p = direction * t_m + Vec3::new(0.0, 0.0, EARTH_M + eye_m);
        let radius = p.length();
        Self { height_m: (radius - EARTH_M).max(0.0), up: p.dot(light) / radius }
    }

    /// Absorption by ozone, and what the haze of the stratosphere takes out, at a height, 1/m.
    pub fn ozone_per_m(height_m: f32) -> Vec3 {
        absorbed() * ozone_density(height_m)
    }
}

/// Where a ray from a height enters the air and where it ends, at the ground or in space, and whether at the ground.
pub fn path(eye_m: f32, up: f32) -> ([f32; 2], bool) {
    let b = (EARTH_M + eye_m) * up;
    let ground = b * b - eye_m * (2.0 * EARTH_M + eye_m);
    let c = (eye_m - TOP_M) * (2.0 * EARTH_M + eye_m + TOP_M);
    let root = (b * b - c).max(0.0).sqrt();
    // From above the air a ray enters it far away, or not at all.
    let begin = if c > 0.0 && b < 0.0 && b * b > c { c / (root - b) } else { 0.0 };
    if up < 0.0 && ground >= 0.0 {
        return ([begin, eye_m * (2.0 * EARTH_M + eye_m) / (ground.sqrt() - b)], true);
    }
    if c > 0.0 && begin == 0.0 {
        return ([0.0; 2], false);
    }
    ([begin, root - b], false)
}

fn absorbed() -> Vec3 {
    OZONE_PER_M + Vec3::splat(HIGH_HAZE_PER_M)
}

fn ozone_density(height_m: f32) -> f32 {
    (1.0 - (height_m - 25_000.0).abs() / 15_000.0).max(0.0)
}

/// Columns of molecules, haze and ozone from a height towards space, in metres of sea-level air (or peak ozone);
/// from a table of height and cosine, huge behind the Earth.
fn columns(height_m: f32, up: f32) -> [f32; 3] {
    static TABLE: LazyLock<Vec<[f32; 3]>> = LazyLock::new(build_columns);
    let y = (height_m / TOP_M).clamp(0.0, 1.0).sqrt() * (HEIGHTS - 1) as f32;
    let x = cosine_to_row(height_m, up) * (COSINES - 1) as f32;
    let (x0, y0) = ((x as usize).min(COSINES - 2), (y as usize).min(HEIGHTS - 2));
    let (fx, fy) = (x - x0 as f32, y - y0 as f32);
    let at = |dx: usize, dy: usize| TABLE[(x0 + dx) + (y0 + dy) * COSINES];
    let [a, b, c, d] = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
    std::array::from_fn(|i| {
        let low = a[i] + (b[i] - a[i]) * fx;
        let high = c[i] + (d[i] - c[i]) * fx;
        low + (high - low) * fy
    })
}

/// Where a cosine stands in a table, 0 to 1: rows are dense about the horizon of the height.
pub fn cosine_to_row(height_m: f32, up: f32) -> f32 {
    let above = up - horizon_cosine(height_m);
    0.5 + 0.5 * above.signum() * (above.abs() / 2.0).min(1.0).powf(1.0 / 3.0)
}

/// The cosine of a place in a table.
pub fn row_to_cosine(height_m: f32, share: f32) -> f32 {
    let row = 2.0 * share - 1.0;
    (horizon_cosine(height_m) + 2.0 * row * row * row).clamp(-1.0, 1.0)
}

fn horizon_cosine(height_m: f32) -> f32 {
    let s = EARTH_M / (EARTH_M + height_m);
    -(1.0 - s * s).max(0.0).sqrt()
}

fn build_columns() -> Vec<[f32; 3]> {
    let mut table = vec![[0.0; 3]; HEIGHTS * COSINES];
    for (i, entry) in table.iter_mut().enumerate() {
        let share = (i / COSINES) as f32 / (HEIGHTS - 1) as f32;
        let height = share * share * TOP_M;
        let up = row_to_cosine(height, (i % COSINES) as f32 / (COSINES - 1) as f32);
        *entry = march_columns(height, up);
    }
    table
}

fn march_columns(height_m: f32, up: f32) -> [f32; 3] {
    let r = EARTH_M + height_m;
    let b = r * up;
    let c = (height_m - TOP_M) * (2.0 * EARTH_M + height_m + TOP_M);
    let end = (b * b - c).max(0.0).sqrt() - b;
    let lowest = if up < 0.0 { r * (1.0 - up * up).max(0.0).sqrt() - EARTH_M } else { height_m };
    // The sun's light fades over the last kilometres above the ground, not at once: its disc has an extent.
    if lowest < -2_000.0 {
        return [1e9; 3];
    }
    let (mut sums, steps) = ([0.0f32; 3], 200);
    for step in 0..steps {
        let t = end * (step as f32 + 0.5) / steps as f32;
        let height = (r * r + 2.0 * t * b + t * t).sqrt() - EARTH_M;
        let ds = end / steps as f32;
        sums[0] += (-height / AIR_SCALE_M).exp() * ds;
        sums[1] += (-height.max(-500.0) / HAZE_SCALE_M).exp() * ds;
        sums[2] += ozone_density(height) * ds;
    }
    sums
}

#[cfg(test)]
mod spectrum;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertical_columns_equal_the_scale_heights() {
        let [rayleigh, haze, ozone] = columns(0.0, 1.0);
        // 200 steps of 500 m under-resolve the haze's 1.2 km by 1.5 % (midpoint rule); the table adds as much.
        assert!((rayleigh / AIR_SCALE_M - 1.0).abs() < 0.01, "{rayleigh}");
        assert!((haze / HAZE_SCALE_M - 1.0).abs() < 0.03, "{haze}");
        assert!((ozone / 15_000.0 - 1.0).abs() < 0.01, "{ozone}");
    }

    #[test]
    fn a_low_sun_is_redder_and_a_sun_below_the_horizon_dark() {
        let air = Air { haze_per_m: 1e-4 };
        let high = air.transmittance(0.0, 0.9);
        let low = air.transmittance(0.0, 0.05);
        assert!(low.x / low.z > 3.0 * high.x / high.z);
        assert!(air.transmittance(0.0, -0.1).max_element() < 1e-6);
    }
}
