//! The deck's own model without its shortcuts: every pixel marched in short even steps in f64, through all layers at once.
//!
//! No slices, rings, pre-integration, stretched steps, early end or coarser deck: what remains is the density field, the
//! light volumes and the source function that the deck pass reads (in f32, as it does). So the difference to it is what the
//! deck's geometry costs. Its own error shows when the step is doubled.

use super::shell::{height_m, stretches};
use crate::passes::common::Camera;
use crate::passes::deck::FLASH_COLOUR;
use crate::passes::deck::clumps::varied;
use crate::passes::deck::field::{light_at, margin, relieved, shown, source, view};
use crate::passes::deck::twin::Prepared;
use crate::passes::ground;
use crate::passes::relight::twin::scattered;
use crate::passes::sky::table::Texel;
use crate::passes::sky::twin as sky;
use crate::plan::FramePlan;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Length of a step: so many metres, and so much more for each metre of range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// At the eye, m; over 0.
    pub at_eye_m: f64,
    /// Growth with the range, m/m.
    pub growth: f64,
}

/// Light that cloud sends to the eye, and what passes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// cd/m2 per colour.
    pub luminance: DVec3,
    /// Share of what is behind that passes.
    pub transmittance: f64,
}

/// What is behind adds less than this share where the march ends.
const OPAQUE: f64 = 1e-6;

/// The deck alone for every pixel of a plan, rows from the top.
pub fn deck(plan: &FramePlan, table: &[Texel], layers: &[Prepared], step: Step) -> Vec<Seen> {
    let [width, height] = plan.size_px.map(|n| n as usize);
    let mut seen = vec![Seen { luminance: DVec3::ZERO, transmittance: 1.0 }; width * height];
    seen.par_chunks_mut(width.max(1)).enumerate().for_each(|(y, row)| {
        for (x, seen) in row.iter_mut().enumerate() {
            let ray = Ray::through(plan, table, [x as f32 + 0.5, y as f32 + 0.5]);
            *seen = march(&plan.camera, layers, &ray, step);
        }
    });
    seen
}

/// A pixel's ray, where it ends, and the air along it.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Unit direction.
    pub direction: Vec3,
    /// Range at which the ground stops it, or infinite.
    pub end_m: f32,
    /// Luminance of an endless column of air along it.
    pub air: Vec3,
}

impl Ray {
    /// The ray through a point of the picture in pixels.
    pub fn through(plan: &FramePlan, table: &[Texel], [x, y]: [f32; 2]) -> Self {
        let direction = plan.camera.ray(x, y);
        let air = sky::endless(&plan.sky, table, direction);
        Self { direction, end_m: ground::twin::range(&plan.camera, direction), air }
    }
}

/// One ray through all layers.
pub fn march(camera: &Camera, layers: &[Prepared], ray: &Ray, step: Step) -> Seen {
    let earth_m = f64::from(camera.earth_m);
    let eye = DVec3::new(0.0, 0.0, f64::from(camera.eye_m));
    let d = ray.direction.as_dvec3().normalize();
    let flat = f64::from(1.0 - ray.direction.z * ray.direction.z).max(0.0).sqrt();
    let mut pieces: Vec<(f64, f64)> = layers
        .iter()
        .flat_map(|l| {
            let edges = [l.layer.base_m, l.layer.base_m + l.layer.thickness_m].map(f64::from);
            let end = f64::from(ray.end_m).min(f64::from(l.layer.extent_m) / flat.max(1e-3));
            stretches(earth_m, eye, d, edges).map(|(a, b)| (a, b.min(end)))
        })
        .filter(|(a, b)| a < b)
        .collect();
    pieces.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut seen = Seen { luminance: DVec3::ZERO, transmittance: 1.0 };
    let mut from = 0.0f64;
    for (begin, end) in pieces {
        let mut t = begin.max(from);
        while t < end && seen.transmittance > OPAQUE {
            // The last step ends where the stretch does.
            let ds = (step.at_eye_m + step.growth * t).min(end - t);
            add(camera, layers, ray, (eye + d * (t + 0.5 * ds), t + 0.5 * ds, ds), &mut seen);
            t = if ds < end - t { t + ds } else { end };
        }
        from = from.max(end);
    }
    seen
}

/// One step of length `ds` with its middle at `p`, range `t`.
fn add(camera: &Camera, layers: &[Prepared], ray: &Ray, (p, t, ds): (DVec3, f64, f64), seen: &mut Seen) {
    let height = height_m(f64::from(camera.earth_m), p) as f32;
    let (p, earth_m) = (p.as_vec3(), camera.earth_m);
    let (mut extinction, mut emitted) = (0.0f64, DVec3::ZERO);
    for Prepared { layer, textures, lit, .. } in layers {
        if !(0.0..=1.0).contains(&((height - layer.base_m) / layer.thickness_m)) {
            continue;
        }
        let inside = margin(layer, textures, earth_m, p, height, t as f32) * layer.inverse_edge;
        if inside > 0.0 {
            let density = varied(layer, textures, earth_m, p, height, t as f32);
            let own = f64::from(layer.extinction_per_m * inside.min(1.0) * density);
            let light = light_at(layer, textures, earth_m, p, height);
            let shown =
                shown(layer, textures, earth_m, p, height) * relieved(layer, textures, earth_m, p, height, t as f32);
            extinction += own;
            emitted += own * source(layer, light, &view(layer, ray.direction), p, height, shown).as_dvec3();
            if let Some(lit) = lit {
                let flashes = scattered(&lit.lits, &lit.fields, p, height, -ray.direction);
                emitted += own * (FLASH_COLOUR * flashes).as_dvec3();
            }
        }
    }
    if extinction > 0.0 {
        let alpha = -(-extinction * ds).exp_m1();
        let passed = f64::from(camera.air_transmittance(height, t as f32));
        let luminance = emitted / extinction * passed + ray.air.as_dvec3() * (1.0 - passed);
        seen.luminance += luminance * (alpha * seen.transmittance);
        seen.transmittance *= 1.0 - alpha;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clouds::CloudKind;
    use crate::plan::{Output, plan, scenes};
    use crate::reference::ReferenceExecutor;

    fn cumulus() -> FramePlan {
        let mut snapshot = scenes::clear_day();
        snapshot.ownship.position.altitude_m = 300.0;
        snapshot.ownship.attitude.pitch_rad = 0.5;
        snapshot.weather.layers.push(scenes::layer(CloudKind::Cumulus, 1_000.0, 1_200.0));
        plan(&snapshot, &snapshot.views[0], Output::LinearRgb)
    }

    #[test]
    fn a_layer_that_is_whole_everywhere_lets_through_what_beer_says() {
        let mut plan = cumulus();
        let layer = &mut plan.layers[0].layer;
        (layer.theta, layer.patchiness, layer.extinction_per_m) = (-3.0, 0.0, 0.002);
        let expected = f64::exp(-0.002 * 1_200.0);
        let up = Ray { direction: Vec3::Z, end_m: f32::INFINITY, air: Vec3::ZERO };
        let seen = ReferenceExecutor::new()
            .prepared(&plan, |_, layers, _, _| march(&plan.camera, layers, &up, Step { at_eye_m: 70.0, growth: 0.0 }));
        // A sum of steps whose length is exact: 1,200 m within the millimetre of the heights.
        assert!((seen.transmittance / expected - 1.0).abs() < 1e-5, "{seen:?} {expected}");
    }

    #[test]
    fn shorter_steps_change_little_and_the_deck_pass_is_near() {
        let plan = cumulus();
        ReferenceExecutor::new().prepared(&plan, |table, layers, _, _| {
            let of = |at_eye_m| deck(&plan, table, layers, Step { at_eye_m, growth: 0.002 });
            let (coarse, fine) = (of(4.0), of(2.0));
            let apart = |other: &dyn Fn(usize) -> f64| {
                let sum: f64 = (0..fine.len()).map(|i| (other(i) - fine[i].transmittance).abs()).sum();
                sum / fine.len() as f64
            };
            // Second order in the step: edges of 0.16 of the shape value are 100 m wide and more.
            assert!(apart(&|i| coarse[i].transmittance) < 2e-3);
            let walked = |i: usize| {
                let [x, y] = [i % plan.size_px[0] as usize, i / plan.size_px[0] as usize].map(|n| n as f32 + 0.5);
                let ray = Ray::through(&plan, table, [x, y]);
                let air = ray.air;
                f64::from(
                    crate::passes::deck::twin::walk(&plan.camera, layers, &plan.legs(), ray.direction, ray.end_m, air)
                        .transmittance,
                )
            };
            // The deck pass in eight slices: its steps are 150 m and longer.
            let error = apart(&walked);
            assert!(error > 0.0 && error < 0.05, "{error}");
        });
    }
}
