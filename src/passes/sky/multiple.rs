//! Light that has been scattered more than once, as if it came alike from all sides (Hillaire 2020, section 5.5).
//!
//! *What it is.* The luminance of all orders from the second on at a height, per lux of a light outside the air at a
//! cosine against the zenith. It is what keeps the sky lit when the sun has set.
//! *How we compute it.* The second order by rays from the point to all sides (eq. 6-7), all further ones as the geometric
//! series of the share that is scattered on (eq. 8-10). Haze scatters mostly forwards, so here it counts with its transport
//! coefficient, and light on its way through haze is lost as in a diffuse slab and not by Beer's law: in fog, too, it is day.
//! *How we store it.* Logarithms over height and cosine, one table for each half decade of haze, made when first asked for.
//! *How we read it back.* Bilinear, and linear in the logarithm of the haze.

use super::atmosphere::{
    Air, HAZE_ALBEDO, HAZE_ASYMMETRY, Medium, RAYLEIGH_PER_M, TOP_M, cosine_to_row, path, row_to_cosine,
};
use crate::passes::common::{AIR_SCALE_M, HAZE_SCALE_M};
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, PI};
use std::sync::OnceLock;

/// Reflectance of the ground from which light goes up again.
pub const GROUND_ALBEDO: f32 = 0.15;
const HEIGHTS: usize = 16;
const COSINES: usize = 64;
/// Rays from a point: so many elevations, and azimuths on one side of the light.
const RAYS: [usize; 2] = [12, 6];
const STEPS: usize = 20;
/// Haze of the first table, 1/m, and tables a decade.
const LEAST_HAZE_PER_M: f32 = 1e-6;
const TABLES_PER_DECADE: f32 = 2.0;
const TABLES: usize = 13;
/// Below this a logarithm is as good as dark.
const DARK: f32 = 1e-18;

type Table = Vec<Vec3>;

/// The orders from the second on in one kind of air.
pub struct HigherOrders(Table);

impl HigherOrders {
    /// None: a sky that scatters light once.
    pub fn none() -> Self {
        Self(vec![Vec3::splat(DARK.ln()); HEIGHTS * COSINES])
    }

    /// Those of this air: between the tables on either side of its haze.
    pub fn of(air: &Air) -> Self {
        let place = (air.haze_per_m.max(LEAST_HAZE_PER_M) / LEAST_HAZE_PER_M).log10() * TABLES_PER_DECADE;
        let place = place.min((TABLES - 1) as f32);
        let low = (place as usize).min(TABLES - 2);
        let share = place - low as f32;
        Self(table(low).iter().zip(table(low + 1)).map(|(a, b)| a.lerp(*b, share)).collect())
    }

    /// Luminance at a height per lux outside the air, of a light at this cosine against the zenith there.
    pub fn luminance(&self, height_m: f32, up: f32) -> Vec3 {
        let y = (height_m / TOP_M).clamp(0.0, 1.0).sqrt() * (HEIGHTS - 1) as f32;
        let x = cosine_to_row(height_m, up) * (COSINES - 1) as f32;
        let (x0, y0) = ((x as usize).min(COSINES - 2), (y as usize).min(HEIGHTS - 2));
        let texel = |dx: usize, dy: usize| self.0[(x0 + dx) + (y0 + dy) * COSINES];
        let fx = x - x0 as f32;
        texel(0, 0).lerp(texel(1, 0), fx).lerp(texel(0, 1).lerp(texel(1, 1), fx), y - y0 as f32).map(f32::exp)
    }
}

/// Sequential inside, so that a thread of a pool that waits here waits for nobody who waits for it.
fn table(index: usize) -> &'static Table {
    static KEPT: [OnceLock<Table>; TABLES] = [const { OnceLock::new() }; TABLES];
    KEPT[index].get_or_init(|| {
        let haze_per_m = LEAST_HAZE_PER_M * 10f32.powf(index as f32 / TABLES_PER_DECADE);
        let entry = |i: usize| {
            let share = (i / COSINES) as f32 / (HEIGHTS - 1) as f32;
            let height_m = share * share * TOP_M;
            let up = row_to_cosine(height_m, (i % COSINES) as f32 / (COSINES - 1) as f32);
            let all = all_orders(&Air { haze_per_m }, height_m, up);
            all.max(Vec3::splat(DARK)).map(f32::ln)
        };
        (0..HEIGHTS * COSINES).map(entry).collect()
    })
}

fn all_orders(air: &Air, height_m: f32, up: f32) -> Vec3 {
    let light = Vec3::new((1.0 - up * up).max(0.0).sqrt(), 0.0, up);
    let (mut second, mut passed_on) = (Vec3::ZERO, Vec3::ZERO);
    for row in 0..RAYS[0] {
        let rise = 2.0 * (row as f32 + 0.5) / RAYS[0] as f32 - 1.0;
        let flat = (1.0 - rise * rise).sqrt();
        for column in 0..RAYS[1] {
            let azimuth = PI * (column as f32 + 0.5) / RAYS[1] as f32;
            let direction = Vec3::new(azimuth.cos() * flat, azimuth.sin() * flat, rise);
            let (once, on) = ray(air, height_m, direction, light);
            second += once;
            passed_on += on;
        }
    }
    let rays = (RAYS[0] * RAYS[1]) as f32;
    second / rays / (Vec3::ONE - passed_on / rays).max(Vec3::splat(0.05))
}

/// Light that reaches a point along a ray after one scattering, per lux, and the share of light everywhere that would.
fn ray(air: &Air, height_m: f32, direction: Vec3, light: Vec3) -> (Vec3, Vec3) {
    let ([_, end_m], to_ground) = path(height_m, direction.z);
    let (mut once, mut on, mut passed) = (Vec3::ZERO, Vec3::ZERO, Vec3::ONE);
    let mut before = 0.0;
    for step in 0..STEPS {
        let share = (step + 1) as f32 / STEPS as f32;
        let t = end_m * share * share;
        let (mid, ds) = (0.5 * (t + before), t - before);
        before = t;
        let Medium { height_m, up, .. } = Medium::along(height_m, direction, light, mid);
        let rayleigh = RAYLEIGH_PER_M * (-height_m / AIR_SCALE_M).exp();
        let haze = air.haze_per_m * (-height_m / HAZE_SCALE_M).exp();
        let scattered = rayleigh + Vec3::splat(HAZE_ALBEDO * (1.0 - HAZE_ASYMMETRY) * haze);
        let extinction = scattered + Vec3::splat((1.0 - HAZE_ALBEDO) * haze) + Medium::ozone_per_m(height_m);
        let through = (-extinction * ds).exp();
        let gain = passed * scattered * ((Vec3::ONE - through) / extinction.max(Vec3::splat(1e-12)));
        once += gain * air.diffuse_transmittance(height_m, up) * (0.25 * FRAC_1_PI);
        on += gain;
        passed *= through;
    }
    if to_ground {
        let Medium { up, .. } = Medium::along(height_m, direction, light, end_m);
        once += passed * air.diffuse_transmittance(0.0, up) * (up.max(0.0) * GROUND_ALBEDO * FRAC_1_PI);
    }
    (once, on)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_the_tables_nothing_jumps() {
        let at = |haze_per_m: f32| HigherOrders::of(&Air { haze_per_m }).luminance(500.0, 0.3).y;
        let mut last = at(9e-7);
        for k in 0..400 {
            let next = at(9e-7 * 10f32.powf(k as f32 / 66.0));
            // 3.5 % more haze changes what is scattered by as much at most.
            assert!((next / last - 1.0).abs() < 0.04, "{k}: {last} {next}");
            last = next;
        }
    }

    #[test]
    fn thin_air_scatters_as_the_second_order_alone() {
        // Far up the air is so thin that what is scattered twice comes from below: the day side is brighter than the night side.
        let orders = HigherOrders::of(&Air { haze_per_m: 1e-5 });
        let (day, dusk, night) =
            (orders.luminance(60_000.0, 0.9), orders.luminance(60_000.0, -0.1), orders.luminance(60_000.0, -0.6));
        assert!(day.y > dusk.y && dusk.y > night.y && night.y < 1e-8, "{day} {dusk} {night}");
    }
}
