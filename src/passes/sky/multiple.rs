//! Light that has been scattered more than once, as if it came alike from all sides (Hillaire 2020, section 5.5).
//!
//! *What it is.* The luminance of all orders from the second on at a height, per lux of a light outside the air at a
//! cosine against the zenith. It is what keeps the sky lit when the sun has set.
//! *How we compute it.* The second order by rays from the point to all sides (eq. 6-7), the third and fourth likewise from the order
//! before, and all further ones as a geometric series with the ratio of these two at the place itself. (Eq. 8-10 have the
//! series from the second order on, with the share that is scattered on as its ratio, as if there were as much light
//! everywhere: in a twilight and in fog that was up to three times too much.) Haze scatters mostly forwards, so here
//! it counts with its transport coefficient.
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
/// The same for further orders, which are smoother.
const FEW_RAYS: [usize; 2] = [8, 4];
/// Orders that hardly lose light are summed as if each had so much of the one before.
const MOST_RATIO: f32 = 0.95;
const STEPS: usize = 20;
/// Haze of the first table, 1/m, and tables a decade.
const LEAST_HAZE_PER_M: f32 = 1e-6;
const TABLES_PER_DECADE: f32 = 2.0;
const TABLES: usize = 9;
/// Haze that is tabulated, 1/m: 500 m of visibility. What is thicker is fog, whose droplets hardly absorb.
const THICKEST_PER_M: f32 = 6e-3;
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
        let dry_per_m = air.haze_per_m.clamp(LEAST_HAZE_PER_M, THICKEST_PER_M);
        let place = (dry_per_m / LEAST_HAZE_PER_M).log10() * TABLES_PER_DECADE;
        let low = (place as usize).min(TABLES - 2);
        let share = place - low as f32;
        let entry = |(i, (a, b)): (usize, (&Vec3, &Vec3))| {
            // Through fog as through a slab of droplets, diffusely: by Beer's law it would be dark at noon.
            let above_m = HAZE_SCALE_M * (-self::place(i).0 / HAZE_SCALE_M).exp();
            let slab = |haze_per_m: f32| 1.0 + 0.75 * (1.0 - HAZE_ASYMMETRY) * haze_per_m * above_m;
            a.lerp(*b, share) + Vec3::splat((slab(dry_per_m) / slab(air.haze_per_m.max(dry_per_m))).ln())
        };
        Self(table(low).iter().zip(table(low + 1)).enumerate().map(entry).collect())
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
    KEPT[index].get_or_init(|| all_orders(LEAST_HAZE_PER_M * 10f32.powf(index as f32 / TABLES_PER_DECADE)))
}

/// Height and cosine of an entry.
fn place(i: usize) -> (f32, f32) {
    let share = (i / COSINES) as f32 / (HEIGHTS - 1) as f32;
    let height_m = share * share * TOP_M;
    (height_m, row_to_cosine(height_m, (i % COSINES) as f32 / (COSINES - 1) as f32))
}

fn all_orders(haze_per_m: f32) -> Table {
    let air = Air { haze_per_m };
    // What goes on forwards is not scattered, on the light's way as on the rays.
    let clear = Air { haze_per_m: haze_per_m * (1.0 - HAZE_ALBEDO * HAZE_ASYMMETRY) };
    let once = |height_m: f32, up: f32| clear.transmittance(height_m, up) * (0.25 * FRAC_1_PI);
    let lit = |up: f32| clear.transmittance(0.0, up) * (up.max(0.0) * GROUND_ALBEDO * FRAC_1_PI);
    let second = HigherOrders(order(RAYS, &air, &once, &lit));
    let next = |before: &HigherOrders| {
        let sent = |height_m: f32, up: f32| before.luminance(height_m, up);
        HigherOrders(order(FEW_RAYS, &air, &sent, &|up| before.luminance(0.0, up) * GROUND_ALBEDO))
    };
    let third = next(&second);
    let fourth = next(&third);
    let entries = second.0.iter().zip(&third.0).zip(&fourth.0);
    let sum = |((second, third), fourth): ((&Vec3, &Vec3), &Vec3)| {
        let [second, third, fourth] = [second, third, fourth].map(|log| log.map(f32::exp));
        let ratio = (fourth / third).min(Vec3::splat(MOST_RATIO));
        (second + third + fourth / (Vec3::ONE - ratio)).map(f32::ln)
    };
    entries.map(sum).collect()
}

/// One order of the light at each entry of a table.
fn order(rays: [usize; 2], air: &Air, source: &dyn Fn(f32, f32) -> Vec3, ground: &dyn Fn(f32) -> Vec3) -> Table {
    let entry = |i: usize| {
        let (height_m, up) = place(i);
        let light = Vec3::new((1.0 - up * up).max(0.0).sqrt(), 0.0, up);
        let mut sum = Vec3::ZERO;
        for row in 0..rays[0] {
            let rise = 2.0 * (row as f32 + 0.5) / rays[0] as f32 - 1.0;
            let flat = (1.0 - rise * rise).sqrt();
            for column in 0..rays[1] {
                let azimuth = PI * (column as f32 + 0.5) / rays[1] as f32;
                let direction = Vec3::new(azimuth.cos() * flat, azimuth.sin() * flat, rise);
                sum += ray(air, height_m, direction, light, source, ground);
            }
        }
        (sum / (rays[0] * rays[1]) as f32).max(Vec3::splat(DARK)).map(f32::ln)
    };
    (0..HEIGHTS * COSINES).map(entry).collect()
}

/// Light that reaches a point along a ray, given what the air and the ground on it send to all sides (luminance, by height and by the
/// light's cosine).
fn ray(
    air: &Air,
    height_m: f32,
    direction: Vec3,
    light: Vec3,
    source: &dyn Fn(f32, f32) -> Vec3,
    ground: &dyn Fn(f32) -> Vec3,
) -> Vec3 {
    let ([_, end_m], to_ground) = path(height_m, direction.z);
    let (mut sum, mut passed) = (Vec3::ZERO, Vec3::ONE);
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
        sum += passed * scattered * ((Vec3::ONE - through) / extinction.max(Vec3::splat(1e-12))) * source(height_m, up);
        passed *= through;
    }
    if to_ground {
        sum += passed * ground(Medium::along(height_m, direction, light, end_m).up);
    }
    sum
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
            // 3.5 % more haze, which absorbs and is seven free paths deep where it is thickest before it is fog.
            assert!((next / last - 1.0).abs() < 0.12, "{k}: {last} {next}");
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
