//! Subject `glow`: light of cities on clouds as it is drawn and by the deck paper's eq. 20, against Monte Carlo of the light that
//! lamps send up.

use super::result::Case;
use super::scene::layer;
use super::subject::{Run, Stopped, Subject};
use super::timing::measure;
use crate::clouds::CloudKind;
use crate::frame::Pixels;
use crate::geo::cities::near;
use crate::geo::wgs84::MEAN_RADIUS_M;
use crate::passes::deck::glow::{at_height, build, sample};
use crate::passes::ground::lights::CORE_LUMINANCE;
use crate::plan::{FramePlan, Output, plan};
use crate::reference::ReferenceExecutor;
use crate::reference::monte_carlo::deck::Deck;
use crate::reference::monte_carlo::{Scene, Surroundings, pixel};
use crate::scattering::phase::Phase;
use crate::world::World;
use crate::world::command::{Command, LayerSpec, Ownship, TimeEdit, ViewAction, ViewEdit, WeatherEdit};
use glam::{DVec2, DVec3, Vec2};
use rayon::prelude::*;
use std::f64::consts::FRAC_1_PI;

/// City glow.
pub const SUBJECT: Subject = Subject {
    name: "glow",
    about: "light of cities on an overcast: as it is drawn, and by eq. 20 of the deck paper, against Monte Carlo of upward light",
    measure: cases,
};

const SIDE_PX: u32 = 16;
const METRIC: &str = "relative difference of the mean luminance";
const REFERENCE: &str = "Monte Carlo of the same density";
/// Way over which haze takes the light of lamps to 1/e, as the glow's table has it.
const CLEAR_M: f64 = 40_000.0;

/// An overcast near Paris, and an eye below or above it.
struct Look {
    kind: CloudKind,
    base_m: f64,
    thickness_m: f64,
    /// From the middle of the city northwards.
    north_m: f64,
    above: bool,
}

fn cases(run: &mut Run) -> Result<(), Stopped> {
    let below = Look { kind: CloudKind::Stratocumulus, base_m: 800.0, thickness_m: 500.0, north_m: 0.0, above: false };
    let all = [
        ("over the middle", Look { ..below }),
        ("10 km from the middle", Look { north_m: 10_000.0, ..below }),
        ("30 km from the middle", Look { north_m: 30_000.0, ..below }),
        ("a base of 2,500 m", Look { base_m: 2_500.0, ..below }),
        ("stratus of 200 m", Look { kind: CloudKind::Stratus, thickness_m: 200.0, ..below }),
        ("nimbostratus of 3,000 m", Look { kind: CloudKind::Nimbostratus, thickness_m: 3_000.0, ..below }),
        ("from above", Look { above: true, ..below }),
        ("from above, 10 km from the middle", Look { above: true, north_m: 10_000.0, ..below }),
    ];
    for (name, look) in &all[..run.pick(2, all.len())] {
        look.measure(run, name)?;
    }
    Ok(())
}

impl Look {
    fn plan(&self) -> Result<FramePlan, Stopped> {
        let mut world = World::new();
        let top_m = self.base_m + self.thickness_m;
        let (altitude_m, pitch_deg) = if self.above { (top_m + 1_500.0, -90.0) } else { (300.0, 90.0) };
        let ownship = Ownship {
            latitude_deg: 48.857 + self.north_m / 111_200.0,
            longitude_deg: 2.352,
            altitude_m,
            yaw_deg: 0.0,
            pitch_deg,
            roll_deg: 0.0,
            velocity_ned_mps: None,
            host_frame: 0,
        };
        let clouds = LayerSpec { coverage: 1.0, ..layer(self.kind, self.base_m, self.thickness_m) };
        let weather = WeatherEdit { layers: Some(vec![clouds]), visibility_m: Some(200_000.0), ..Default::default() };
        let view = ViewEdit {
            action: ViewAction::Change,
            name: "main".into(),
            size_px: Some([SIDE_PX; 2]),
            field_of_view_deg: Some(20.0),
            ..Default::default()
        };
        // 2026-05-16T23:30:00Z: the moon is new.
        let time = TimeEdit { utc_s: Some(1_778_974_200.0), rate: Some(0.0) };
        for command in [Command::Time(time), Command::Ownship(ownship), Command::Weather(weather), Command::View(view)]
        {
            world.apply(command).map_err(|refused| Stopped::Failed(refused.to_string()))?;
        }
        let snapshot = world.snapshot(1.0 / 60.0);
        Ok(plan(&snapshot, &snapshot.views[0], Output::LinearRgb))
    }

    fn measure(&self, run: &mut Run, name: &str) -> Result<(), Stopped> {
        let plan = self.plan()?;
        let nothing = || Stopped::Failed("the plan has no deck with glow".into());
        let deck = Deck::new(&plan).ok_or_else(nothing)?;
        let glow = plan.glow.as_ref().ok_or_else(nothing)?;
        let zenith = zenith_of(48.857 + self.north_m / 111_200.0, 2.352);
        let lit = Lit { deck, lamps: lamps_about(zenith) };
        let camera = &plan.camera;
        let rays: Vec<DVec3> = (0..SIDE_PX * SIDE_PX)
            .map(|i| camera.ray((i % SIDE_PX) as f32 + 0.5, (i / SIDE_PX) as f32 + 0.5).as_dvec3())
            .collect();
        let around = Surroundings {
            sun: DVec3::Z,
            sun_lux: DVec3::ZERO,
            sky_luminance: DVec3::ZERO,
            ground_albedo: DVec3::ZERO,
            albedo: 1.0,
            phase: Phase::HenyeyGreenstein(0.85),
        };
        let paths = run.pick(30, 400);
        let eye = lit.deck.eye();
        let (truth, truth_s) = measure(1, || {
            let seen: Vec<_> = rays
                .par_iter()
                .enumerate()
                .map(|(i, ray)| pixel(&lit, &around, (eye, *ray, f64::INFINITY), paths, (1, i as u64), |_, l| l))
                .collect();
            let count = seen.len() as f64;
            let error = seen.iter().map(|p| p.error.x * p.error.x).sum::<f64>().sqrt() / count;
            (seen.iter().map(|p| p.luminance.x).sum::<f64>() / count, error)
        });
        let (truth, error) = truth;
        let own = format!(
            "Monte Carlo: {truth:.4} cd/m2, standard error {:.1} %, {:.1} s for {paths} paths a ray",
            100.0 * error / truth,
            truth_s.median
        );
        let mut record = |method: &str, found: f64, time_s| {
            let case = Case::new(name, method).time(time_s).note(format!("{found:.4} cd/m2")).note(&own);
            run.record(case.error(METRIC, REFERENCE, found / truth - 1.0))
        };
        // The lamps' colour has a luminance of its own; the red share stands for the light of a white lamp.
        let mut executor = ReferenceExecutor::new();
        let (drawn, time_s) = measure(3, || red_mean(&executor.draw(&plan)));
        record("drawn", drawn, time_s)?;
        let base_m = plan.layers[0].layer.base_m;
        let table = build(&glow.window);
        let arrives_lux = f64::from(at_height(sample(&table, Vec2::from(glow.glow.origin)), base_m));
        let (printed, time_s) = measure(3, || self.printed(&lit, &rays, arrives_lux * FRAC_1_PI));
        record("eq. 20", printed, time_s)
    }

    /// Eq. 20 with a coefficient of 1: glow falls linearly from the base to the top; its texture holds what arrives at the base, as a
    /// white sheet would send it back.
    fn printed(&self, lit: &Lit, rays: &[DVec3], at_base: f64) -> f64 {
        const STEPS: u32 = 400;
        let seen = |ray: &DVec3| {
            let Some((begin, end)) = lit.stretch(lit.deck.eye(), *ray, 0.0) else { return 0.0 };
            let ds = (end - begin) / f64::from(STEPS);
            let (mut light, mut passed) = (0.0, 1.0);
            for step in 0..STEPS {
                let share = (f64::from(step) + 0.5) / f64::from(STEPS);
                let height = if self.above { 1.0 - share } else { share };
                let through = (-lit.extinction(lit.deck.eye() + *ray * (begin + (end - begin) * share)) * ds).exp();
                light += passed * (1.0 - through) * at_base * (1.0 - height);
                passed *= through;
            }
            light
        };
        rays.iter().map(seen).sum::<f64>() / rays.len() as f64
    }
}

/// A deck over lamps.
struct Lit<'a> {
    deck: Deck<'a>,
    /// Middle and square of the radius of each city's disc, from the ground below the eye.
    lamps: Vec<(DVec2, f64)>,
}

impl Scene for Lit<'_> {
    fn extinction(&self, p: DVec3) -> f64 {
        self.deck.extinction(p)
    }

    fn majorant(&self) -> f64 {
        self.deck.majorant()
    }

    fn stretch(&self, p: DVec3, d: DVec3, from: f64) -> Option<(f64, f64)> {
        self.deck.stretch(p, d, from)
    }

    fn ground(&self, p: DVec3, d: DVec3) -> Option<(f64, DVec3)> {
        self.deck.ground(p, d)
    }

    fn ground_luminance(&self, at: DVec3, way_m: f64) -> DVec3 {
        let lit = self.lamps.iter().filter(|(place_m, r2)| place_m.distance_squared(at.truncate()) < *r2).count();
        DVec3::splat(lit as f64 * f64::from(CORE_LUMINANCE) * (-way_m / CLEAR_M).exp())
    }
}

fn zenith_of(latitude_deg: f64, longitude_deg: f64) -> DVec3 {
    let (sin_lat, cos_lat) = latitude_deg.to_radians().sin_cos();
    let (sin_lon, cos_lon) = longitude_deg.to_radians().sin_cos();
    DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat)
}

fn lamps_about(zenith: DVec3) -> Vec<(DVec2, f64)> {
    let east = DVec3::Z.cross(zenith).normalize();
    let north = zenith.cross(east);
    let lamp = |city: crate::geo::cities::City| {
        let place_m = DVec2::new(city.zenith.dot(east), city.zenith.dot(north)) * MEAN_RADIUS_M;
        (place_m, city.radius_m().powi(2))
    };
    near(zenith, 100_000.0).into_iter().map(lamp).collect()
}

fn red_mean(pixels: &Pixels) -> f64 {
    let Pixels::LinearRgb(values) = pixels else { return f64::NAN };
    let reds = values.iter().step_by(3);
    reds.clone().map(|v| f64::from(*v)).sum::<f64>() / reds.count() as f64
}
