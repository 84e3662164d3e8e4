//! The two references of one eye point: the converged march for every pixel, Monte Carlo for some of them.

use crate::frame::Pixels;
use crate::numeric::metrics::relative_square_less_noise;
use crate::plan::FramePlan;
use crate::reference::ReferenceExecutor;
use crate::reference::converged::{self, Ray, Seen, Step};
use crate::reference::monte_carlo::deck::Deck;
use crate::reference::monte_carlo::{Pixel, pixel};
use crate::report::images::{displayed, error_map, picture, side_by_side};
use crate::report::result::{Case, TimeSpread};
use crate::report::subject::Stopped;
use crate::report::timing::measure;
use glam::DVec3;
use rayon::prelude::*;

/// Steps of the converged march.
pub const STEP: Step = Step { at_eye_m: 2.0, growth: 0.002 };
/// Pixels that clouds hide to at least this share are compared with Monte Carlo.
const CLOUDY: f64 = 0.5;
/// Seed of the paths.
const SEED: u64 = 20_120_401;

/// What Monte Carlo may cost.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Every how many pixels across and down one is traced.
    pub stride: usize,
    /// Paths a pixel.
    pub paths: u32,
}

/// Reference pictures, cd/m2.
pub struct Truth {
    /// The converged march.
    pub picture: Vec<f32>,
    /// The same in steps of twice the length.
    pub coarse: Vec<f32>,
    /// Time of the march.
    pub time_s: TimeSpread,
    /// Time of the march in longer steps.
    pub coarse_time_s: TimeSpread,
    effort: Effort,
    width: usize,
    traced: Vec<Traced>,
    traced_time_s: f64,
}

/// One traced pixel.
struct Traced {
    /// Which pixel of the picture.
    at: usize,
    luminance: DVec3,
    error: DVec3,
    cloudy: bool,
    lost: u32,
}

impl Truth {
    /// Both references of a plan for a linear picture.
    ///
    /// # Errors
    /// [`Stopped::Failed`]: the plan has no layer, or is not for a linear picture.
    pub fn new(executor: &mut ReferenceExecutor, plan: &FramePlan, effort: Effort) -> Result<Self, Stopped> {
        let mut without = plan.clone();
        // Clouds that nobody sees, but whose shadows lie on the ground.
        without.layers.iter_mut().for_each(|l| l.layer.extinction_per_m = 0.0);
        let Pixels::LinearRgb(behind) = executor.draw(&without) else {
            return Err(Stopped::Failed("the plan is not for a linear picture".into()));
        };
        let width = plan.size_px[0] as usize;
        executor.prepared(plan, |table, layers, _, _| {
            let march = |step: Step| measure(1, || converged::deck(plan, table, layers, step));
            let (fine, time_s) = march(STEP);
            let (coarse, coarse_time_s) = march(Step { at_eye_m: 2.0 * STEP.at_eye_m, growth: 2.0 * STEP.growth });
            let scene = Deck::new(plan).ok_or_else(|| Stopped::Failed("no layer is in sight".into()))?;
            let (traced, spread) = measure(1, || trace(plan, &scene, effort, &fine, &behind, table));
            let traced = traced.ok_or_else(|| Stopped::Failed("no layer is in sight".into()))?;
            let whole = |seen: &[Seen]| -> Vec<f32> {
                seen.iter().zip(behind.chunks_exact(3)).flat_map(|(s, b)| over(s, b).as_vec3().to_array()).collect()
            };
            Ok(Self {
                picture: whole(&fine),
                coarse: whole(&coarse),
                time_s,
                coarse_time_s,
                effort,
                width,
                traced,
                traced_time_s: spread.median,
            })
        })
    }

    /// Adds the errors of a linear picture against Monte Carlo, over cloudy pixels that were traced.
    pub fn monte_carlo_errors(&self, case: Case, drawn: &[f32]) -> Case {
        let (mut own, mut true_values, mut errors) = (Vec::new(), Vec::new(), Vec::new());
        for traced in self.traced.iter().filter(|t| t.cloudy) {
            own.extend(drawn[3 * traced.at..][..3].iter().map(|v| f64::from(*v)));
            true_values.extend(traced.luminance.to_array());
            errors.extend(traced.error.to_array());
        }
        let mean = own.iter().sum::<f64>() / true_values.iter().sum::<f64>() - 1.0;
        let squared = relative_square_less_noise(&own, &true_values, &errors);
        // Below nothing there is only noise.
        case.error("relative square error of cloud", super::MONTE_CARLO, squared.max(0.0))
            .error("error of mean cloud luminance", super::MONTE_CARLO, mean.abs())
            .note(format!("mean cloud luminance {:+.1} % of Monte Carlo's", 100.0 * mean))
    }

    /// How far Monte Carlo can be trusted.
    pub fn describe(&self) -> String {
        let cloudy: Vec<&Traced> = self.traced.iter().filter(|t| t.cloudy).collect();
        let light: f64 = cloudy.iter().map(|t| t.luminance.y).sum();
        let noise = cloudy.iter().map(|t| t.error.y * t.error.y).sum::<f64>().sqrt();
        let lost: u32 = self.traced.iter().map(|t| t.lost).sum();
        format!(
            "Monte Carlo: {} paths at each of {} pixels, {} of them cloudy; standard error of their mean {:.1} %; {lost} paths \
             given up; {:.1} s",
            self.effort.paths,
            self.traced.len(),
            cloudy.len(),
            100.0 * noise / light,
            self.traced_time_s
        )
    }

    /// The converged picture beside Monte Carlo at the traced pixels, with the relative difference, and a caption.
    ///
    /// # Errors
    /// [`Stopped::Failed`]: the codec refused.
    pub fn compared(&self, exposure: f32) -> Result<(Vec<u8>, String), Stopped> {
        let columns = self.width.div_ceil(self.effort.stride);
        let own: Vec<f32> = self.traced.iter().flat_map(|t| self.picture[3 * t.at..][..3].to_vec()).collect();
        let other: Vec<f32> = self.traced.iter().flat_map(|t| t.luminance.as_vec3().to_array()).collect();
        let apart: Vec<f32> =
            own.chunks_exact(3).zip(other.chunks_exact(3)).map(|(a, b)| (a[1] - b[1]).abs() / b[1].max(1e-6)).collect();
        let shown = |values: &[f32]| picture(&displayed(values, exposure), columns);
        let strip = [shown(&own), shown(&other), error_map(&apart, columns, 1.0)];
        let caption = "The deck's model of light (converged), Monte Carlo of the same clouds, and the relative difference of \
                       luminance (lightest at 1 and above; the noise of the paths is part of it).";
        Ok((side_by_side(&strip, (480 / columns).max(1))?, caption.to_owned()))
    }
}

/// Light of the deck over what is behind it.
fn over(seen: &Seen, behind: &[f32]) -> DVec3 {
    seen.luminance + DVec3::new(f64::from(behind[0]), f64::from(behind[1]), f64::from(behind[2])) * seen.transmittance
}

/// Traces every `stride`-th pixel; what passes the deck is taken from the march, which has no noise.
fn trace(
    plan: &FramePlan,
    scene: &Deck,
    effort: Effort,
    marched: &[Seen],
    behind: &[f32],
    table: &[crate::passes::sky::table::Texel],
) -> Option<Vec<Traced>> {
    let around = Deck::surroundings(plan)?;
    let [width, height] = plan.size_px.map(|n| n as usize);
    let camera = &plan.camera;
    let rows = (0..height).step_by(effort.stride);
    let pixels: Vec<usize> = rows.flat_map(|y| (0..width).step_by(effort.stride).map(move |x| x + y * width)).collect();
    let one = |at: usize| {
        let ray = Ray::through(plan, table, [(at % width) as f32 + 0.5, (at / width) as f32 + 0.5]);
        // The air between eye and cloud as the deck pass has it.
        let seen = |t: f64, light: DVec3| {
            let height = camera.height_at(ray.direction.z, t as f32);
            let passed = f64::from(camera.air_transmittance(height, t as f32));
            light * passed + ray.air.as_dvec3() * (1.0 - passed)
        };
        let begins = (scene.eye(), ray.direction.as_dvec3().normalize(), f64::from(ray.end_m));
        let Pixel { luminance, error, lost, .. } = pixel(scene, &around, begins, effort.paths, (SEED, at as u64), seen);
        let passed = Seen { luminance, transmittance: marched[at].transmittance };
        let cloudy = 1.0 - marched[at].transmittance >= CLOUDY;
        Traced { at, luminance: over(&passed, &behind[3 * at..]), error, cloudy, lost }
    };
    Some(pixels.into_par_iter().map(one).collect())
}
