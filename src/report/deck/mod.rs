//! Subject `deck`: what each shortcut of the deck costs in error and saves in time, from under, in and above it.
//!
//! Two references: the deck's own model marched in short steps (`reference::converged`), which says what slices, rings,
//! coarser textures and a coarser deck cost, and paths of light through the same density (`reference::monte_carlo`), which
//! alone says whether the model of light is right.

mod methods;
mod truth;

use super::figure::Figure;
use super::images::{displayed, error_map, picture, side_by_side};
use super::result::Case;
use super::scene::{self, EyePoint};
use super::subject::{Run, Stopped, Subject};
use super::timing::measure;
use crate::clouds::CloudKind;
use crate::numeric::metrics::{PIXELS_PER_DEGREE, flip_map, relative_mse};
use crate::passes::light::encoding::Encoding;
use crate::plan::Output;
use crate::reference::ReferenceExecutor;
use crate::world::DEFAULT_QUALITY;
use crate::world::command::LayerSpec;
use crate::world::snapshot::Quality;
use methods::{Drawer, methods};
use truth::{Effort, Truth};

/// The deck.
pub const SUBJECT: Subject = Subject {
    name: "deck",
    about: "the cloud deck by day: slices, rings, resolutions and forms against its own model marched in short steps \
            (f64; light in f16 for many thetas), and against Monte Carlo of the same clouds, sun, sky and ground",
    measure: cases,
};

/// 2026-06-21T11:30:00Z, noon over 8 degrees east.
const NOON_UTC_S: f64 = 1_782_041_400.0;
/// 2026-06-21T17:45:00Z: the sun stands low in the west-north-west, behind the eye.
const LOW_SUN_UTC_S: f64 = NOON_UTC_S + 6.25 * 3600.0;
/// What is looked at: a layer from 1000 to 2200 m.
struct Sight {
    name: &'static str,
    altitude_m: f64,
    pitch_deg: f64,
    kind: CloudKind,
    coverage: f64,
    utc_s: f64,
}

const UNDER: Sight = Sight {
    name: "cumulus, half cover, eye under",
    altitude_m: 400.0,
    pitch_deg: 14.0,
    kind: CloudKind::Cumulus,
    coverage: 0.5,
    utc_s: NOON_UTC_S,
};
const IN: Sight = Sight { name: "cumulus, half cover, eye in", altitude_m: 1_500.0, pitch_deg: 2.0, ..UNDER };
const ABOVE: Sight = Sight { name: "cumulus, half cover, eye above", altitude_m: 4_000.0, pitch_deg: -16.0, ..UNDER };
const LOW_SUN: Sight = Sight { name: "cumulus, half cover, eye above, low sun", utc_s: LOW_SUN_UTC_S, ..ABOVE };
const OVERCAST: Sight =
    Sight { name: "stratocumulus, overcast, eye under", kind: CloudKind::Stratocumulus, coverage: 1.0, ..UNDER };
/// FLIP that is drawn in the lightest colour.
const LIGHTEST: f32 = 0.3;
const CONVERGED: &str = "converged";
const MONTE_CARLO: &str = "Monte Carlo";

fn cases(run: &mut Run) -> Result<(), Stopped> {
    for sight in [UNDER, IN, ABOVE, LOW_SUN, OVERCAST] {
        case(run, run.pick([64, 36], [128, 72]), &sight)?;
    }
    Ok(())
}

/// One sight: the references, then every method against them.
fn case(run: &mut Run, size_px: [u32; 2], sight: &Sight) -> Result<(), Stopped> {
    let Sight { name, altitude_m, pitch_deg, kind, coverage, utc_s } = *sight;
    let eye = EyePoint { altitude_m, pitch_deg, size_px, field_of_view_deg: 60.0 };
    let layer = LayerSpec { coverage, ..scene::layer(kind, 1_000.0, 1_200.0) };
    let plan_for = |quality: Quality| {
        let mut plan = scene::plan_of(&scene::snapshot_at(eye, &[layer], quality, utc_s)?, Output::LinearRgb)?;
        // Between the clouds photons meet no air.
        plan.layers.iter_mut().for_each(|plan| plan.layer.low_light = [1.0; 3]);
        Ok(plan)
    };
    let plan = plan_for(Quality { deck_scale: 1, ..DEFAULT_QUALITY })?;
    let width = plan.size_px[0] as usize;
    let mut executor = ReferenceExecutor::new();
    let effort = run.pick(Effort { stride: 4, paths: 12 }, Effort { stride: 4, paths: 768 });
    // The references read light that is finer than any setting stores it.
    let fine = plan_for(Quality { deck_scale: 1, light_encoding: Encoding::Shares16, ..DEFAULT_QUALITY })?;
    let truth = Truth::new(&mut executor, &methods::with_thetas(&fine, Some(0.04)), effort)?;
    let true_display = displayed(&truth.picture, plan.camera.exposure);

    let own = Case::new(name, "converged").param("step_m", truth::STEP.at_eye_m).time(truth.time_s);
    run.record(truth.monte_carlo_errors(own, &truth.picture).note(truth.describe()))?;
    let coarse = Case::new(name, "converged").param("step_m", 2.0 * truth::STEP.at_eye_m).time(truth.coarse_time_s);
    run.record(against(&truth, &true_display, coarse, &truth.coarse, plan.camera.exposure, width).0)?;

    let mut drawer = Drawer::new(executor);
    let mut extremes: Vec<(f64, String, Vec<f32>, Vec<f32>)> = Vec::new();
    for method in methods(run.quick(), &plan_for, drawer.has_gpu())? {
        let (drawn, time_s) = measure(run.pick(3, 9), || drawer.draw(&method));
        let drawn = drawn?;
        let mut case = Case::new(name, method.name).time(time_s);
        for (param, value) in &method.params {
            case = case.param(param, *value);
        }
        let (case, mean, map) = against(&truth, &true_display, case, &drawn, plan.camera.exposure, width);
        run.record(case)?;
        extremes.push((mean, method.title(), displayed(&drawn, plan.camera.exposure), map));
    }
    extremes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let scale = (480 / width).max(1);
    for (which, extreme) in [("least", extremes.first()), ("greatest", extremes.last())] {
        let Some((mean, title, shown, map)) = extreme else { continue };
        let strip = [picture(&true_display, width), picture(shown, width), error_map(map, width, LIGHTEST)];
        let caption = format!(
            "Converged, {title}, and the FLIP error between them (mean {mean:.4}; lightest at {LIGHTEST} and above)."
        );
        run.figure(Figure::png(format!("{name}: {which} error"), caption, side_by_side(&strip, scale)?))?;
    }
    let (strip, caption) = truth.compared(plan.camera.exposure)?;
    run.figure(Figure::png(format!("{name}: the model of light"), caption, strip))
}

/// A case with every error of a linear picture, its mean FLIP and the map of it.
fn against(
    truth: &Truth,
    true_display: &[f32],
    case: Case,
    drawn: &[f32],
    exposure: f32,
    width: usize,
) -> (Case, f64, Vec<f32>) {
    let map = flip_map(&displayed(drawn, exposure), true_display, width, PIXELS_PER_DEGREE);
    let mean = map.iter().map(|e| f64::from(*e)).sum::<f64>() / map.len() as f64;
    let case =
        case.error("relative MSE", CONVERGED, relative_mse(drawn, &truth.picture)).error("FLIP", CONVERGED, mean);
    (truth.monte_carlo_errors(case, drawn), mean, map)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::result::CaseResult;
    use crate::report::subject::Item;

    #[test]
    fn more_slices_and_a_finer_deck_are_nearer_to_the_converged_picture() {
        let mut results: Vec<CaseResult> = Vec::new();
        let mut figures = 0;
        let mut sink = |item: Item| {
            match item {
                Item::Case(case) => results.extend(case.results("deck")),
                Item::Figure(_) => figures += 1,
            }
            Ok(())
        };
        case(&mut Run::new(true, &mut sink), [32, 18], &UNDER).expect("a case");
        assert_eq!(figures, 3);
        let error = |method: &str, param: &str, value: f64| {
            let wanted = |r: &&CaseResult| {
                r.method == method
                    && r.params.get(param).and_then(|v| v.as_f64()) == Some(value)
                    && (r.error.metric.as_str(), r.error.reference.as_str()) == ("relative MSE", CONVERGED)
            };
            results.iter().find(wanted).and_then(|r| r.error.value).expect("a finite error")
        };
        assert!(error("slices", "slices", 128.0) < error("slices", "slices", 4.0));
        assert!(error("coarser deck", "deck_scale", 2.0) < error("coarser deck", "deck_scale", 4.0));
        // The reference's own error is far below that of what it judges.
        let own = error("converged", "step_m", 2.0 * truth::STEP.at_eye_m);
        assert!(own < 0.1 * error("slices", "slices", 32.0), "{own}");
        let monte_carlo = results.iter().filter(|r| r.error.reference == MONTE_CARLO);
        assert!(monte_carlo.clone().count() > 4 && monte_carlo.clone().all(|r| r.error.value.is_some()));
    }
}
