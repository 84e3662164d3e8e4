//! The layers of a plan as a scene of the path tracer.

use super::super::shell::{crossings, height_m, stretches};
use super::{Scene, Surroundings};
use crate::clouds::density::DensityVolume;
use crate::clouds::{detail, modulation};
use crate::passes::common::Camera;
use crate::passes::deck::clumps::varied;
use crate::passes::deck::field::{Textures, column_bounds, margin};
use crate::plan::{FramePlan, LayerPlan};
use crate::scattering::phase::Phase;
use glam::DVec3;
use std::sync::Arc;

/// Asymmetry of droplets (Henyey-Greenstein), conservative: as in the project's table of slabs.
const DROPLETS: Phase = Phase::HenyeyGreenstein(0.85);
/// Reflectance that the plan's light from below is made with.
const GROUND_ALBEDO: f64 = 0.13;

/// The layers of a plan: their density at any point, and nothing of their light.
pub struct Deck<'a> {
    camera: Camera,
    layers: Vec<Held<'a>>,
    base_m: f64,
    top_m: f64,
    majorant: f64,
}

struct Held<'a> {
    plan: &'a LayerPlan,
    volume: Arc<DensityVolume>,
    bounds: Vec<u8>,
}

impl<'a> Deck<'a> {
    /// The deck of a plan; `None` where it has no layer.
    pub fn new(plan: &'a FramePlan) -> Option<Self> {
        let edges = |l: &LayerPlan| [f64::from(l.layer.base_m), f64::from(l.layer.base_m + l.layer.thickness_m)];
        let base_m = plan.layers.iter().map(|l| edges(l)[0]).min_by(f64::total_cmp)?;
        let top_m = plan.layers.iter().map(|l| edges(l)[1]).max_by(f64::total_cmp)?;
        let held = |plan: &'a LayerPlan| {
            let volume = DensityVolume::of(plan.kind);
            Held { plan, bounds: column_bounds(&volume.shape), volume }
        };
        let majorant = plan
            .layers
            .iter()
            .map(|l| f64::from(l.layer.extinction_per_m) * if l.layer.varied > 0.0 { 2.0 } else { 1.0 })
            .sum();
        Some(Self { camera: plan.camera, layers: plan.layers.iter().map(held).collect(), base_m, top_m, majorant })
    }

    /// The plan's sun and sky above its highest layer, over a grey ground.
    pub fn surroundings(plan: &FramePlan) -> Option<Surroundings> {
        let highest = &plan.layers.last()?.layer;
        let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        Some(Surroundings {
            sun: wide(highest.light_direction).normalize(),
            sun_lux: wide(highest.light_lux),
            // The plan holds the horizontal illuminance over 4 pi; an even sky has it over pi.
            sky_luminance: wide(highest.sky_lux) * 4.0,
            ground_albedo: DVec3::splat(GROUND_ALBEDO),
            albedo: 1.0,
            phase: DROPLETS,
        })
    }

    /// The eye: over the ground point that is the origin.
    pub fn eye(&self) -> DVec3 {
        DVec3::new(0.0, 0.0, f64::from(self.camera.eye_m))
    }

    fn earth_m(&self) -> f64 {
        f64::from(self.camera.earth_m)
    }
}

impl Scene for Deck<'_> {
    fn extinction(&self, p: DVec3) -> f64 {
        let height = height_m(self.earth_m(), p);
        let range = (p - self.eye()).length();
        let mut sum = 0.0;
        for held in &self.layers {
            let layer = &held.plan.layer;
            let share = (height - f64::from(layer.base_m)) / f64::from(layer.thickness_m);
            if !(0.0..=1.0).contains(&share) {
                continue;
            }
            let textures = Textures {
                shape: &held.volume.shape,
                lights: &[],
                bounds: &held.bounds,
                map: modulation::map(),
                detail: detail::volume(),
                shade: None,
                glow: None,
            };
            let inside = margin(layer, &textures, self.camera.earth_m, p.as_vec3(), height as f32, range as f32);
            let whole = (inside * layer.inverse_edge).clamp(0.0, 1.0);
            if whole > 0.0 {
                let density = varied(layer, &textures, self.camera.earth_m, p.as_vec3(), height as f32, range as f32);
                sum += f64::from(layer.extinction_per_m * whole * density);
            }
        }
        sum
    }

    fn majorant(&self) -> f64 {
        self.majorant
    }

    fn stretch(&self, p: DVec3, d: DVec3, from: f64) -> Option<(f64, f64)> {
        stretches(self.earth_m(), p, d, [self.base_m, self.top_m])
            .into_iter()
            .map(|(begin, end)| (begin.max(from), end))
            .find(|(begin, end)| begin < end)
    }

    fn ground(&self, p: DVec3, d: DVec3) -> Option<(f64, DVec3)> {
        let (near, _) = crossings(self.earth_m(), p, d, 0.0)?;
        let at = p + d * near;
        (near > 0.0).then(|| (near, (at + DVec3::new(0.0, 0.0, self.earth_m())).normalize()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clouds::CloudKind;
    use crate::plan::{Output, plan, scenes};

    fn cumulus() -> FramePlan {
        let mut snapshot = scenes::clear_day();
        snapshot.weather.layers.push(scenes::layer(CloudKind::Cumulus, 1_000.0, 1_200.0));
        plan(&snapshot, &snapshot.views[0], Output::LinearRgb)
    }

    #[test]
    fn density_is_that_of_the_deck_and_within_the_majorant() {
        let plan = cumulus();
        let deck = Deck::new(&plan).expect("a layer");
        let values: Vec<f64> = (0..20_000)
            .map(|i| {
                let (x, y) = (f64::from(i % 200) * 400.0 - 40_000.0, f64::from(i / 200) * 400.0 - 20_000.0);
                // Half-way up at the eye's place; further off the ground is lower by the Earth's curve.
                let drop = (x * x + y * y) / (2.0 * deck.earth_m());
                deck.extinction(DVec3::new(x, y, 1_500.0 - drop))
            })
            .collect();
        assert!(values.iter().all(|v| (0.0..=deck.majorant()).contains(v)));
        let cloudy = values.iter().filter(|v| **v > 0.0).count() as f64 / 20_000.0;
        // Half cover is that of whole columns; one height meets somewhat less.
        assert!((0.2..0.6).contains(&cloudy), "{cloudy}");
        assert_eq!(deck.extinction(DVec3::new(0.0, 0.0, 900.0)), 0.0);
    }

    #[test]
    fn rays_down_meet_the_ground_and_rays_up_do_not() {
        let plan = cumulus();
        let deck = Deck::new(&plan).expect("a layer");
        let (t, normal) = deck.ground(DVec3::new(0.0, 0.0, 800.0), DVec3::NEG_Z).expect("the ground");
        assert!((t - 800.0).abs() < 1e-3 && (normal - DVec3::Z).length() < 1e-9);
        assert!(deck.ground(DVec3::new(0.0, 0.0, 800.0), DVec3::Z).is_none());
    }
}
