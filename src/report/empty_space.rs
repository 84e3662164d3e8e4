//! What skipping saves in the deck: the walk as it is, against the same walk that follows every look, takes no long step through
//! empty space and does not stop at what nothing passes through.

use super::result::Case;
use super::scene::{self, EyePoint};
use super::subject::{Run, Stopped};
use super::timing::measure;
use crate::clouds::CloudKind;
use crate::frame::Pixels;
use crate::gpu::GpuExecutor;
use crate::plan::executor::Executor;
use crate::plan::{FramePlan, Output};
use crate::reference::ReferenceExecutor;
use crate::world::DEFAULT_QUALITY;
use crate::world::command::LayerSpec;
use crate::world::snapshot::{DeckForm, Quality};

/// Name of a place, altitude, pitch and coverage.
const SCENES: [(&str, f64, f64, f64); 5] = [
    ("below, coverage 0.4", 500.0, 5.0, 0.4),
    ("inside, coverage 0.4", 1_500.0, 0.0, 0.4),
    ("above, coverage 0.4", 6_000.0, -8.0, 0.4),
    ("below, coverage 1.0", 500.0, 5.0, 1.0),
    ("clear", 500.0, 5.0, 0.0),
];

/// Measures every scene on each executor there is.
pub fn cases(run: &mut Run) -> Result<(), Stopped> {
    let mut executors: Vec<(&str, Box<dyn Executor>)> = vec![("reference", Box::new(ReferenceExecutor::new()))];
    if let Ok(gpu) = GpuExecutor::new() {
        executors.push(("GPU", Box::new(gpu)));
    }
    let size_px = run.pick([160, 90], [640, 360]);
    let runs = run.pick(3, 9);
    for (name, executor) in &mut executors {
        for (place, altitude_m, pitch_deg, coverage) in SCENES {
            let eye = EyePoint { altitude_m, pitch_deg, size_px, field_of_view_deg: 60.0 };
            let layer = LayerSpec { coverage, ..scene::layer(CloudKind::Cumulus, 1_000.0, 1_200.0) };
            let case = format!("empty space, {place}, {name}");
            let planned = |layers: &[LayerSpec], form| {
                let quality = Quality { deck_form: form, deck_scale: 2, ..DEFAULT_QUALITY };
                scene::snapshot(eye, layers, quality).and_then(|s| scene::plan_of(&s, Output::Srgb8))
            };
            let skipping = planned(&[layer], DeckForm::Marched)?;
            let clear = drawn(executor.as_mut(), &planned(&[], DeckForm::Marched)?)?;
            let reference = "nothing skipped, marched";
            let mut whole = plain(skipping.clone());
            let mut methods = vec![("nothing skipped, marched", whole.clone())];
            if *name == "GPU" {
                whole.deck_form = planned(&[layer], DeckForm::Instanced)?.deck_form;
                methods.push(("nothing skipped, instanced", whole));
            }
            methods.push(("skipping", skipping));
            let mut first = None;
            for (method, plan) in methods {
                drawn(executor.as_mut(), &plan)?;
                let (picture, time) = measure(runs, || drawn(executor.as_mut(), &plan));
                let picture = picture?;
                let truth = first.get_or_insert_with(|| picture.clone());
                let error = over_cloud(&picture, truth, &clear, 999);
                let row = Case::new(&case, method).time(time);
                run.record(row.error("99.9th percentile over cloud, codes of 255", reference, f64::from(error)))?;
            }
        }
    }
    Ok(())
}

/// The plan without anything that skips. (Its pictures are the same: what is skipped shows nothing.)
fn plain(mut plan: FramePlan) -> FramePlan {
    for layer in &mut plan.layers {
        layer.layer.reach_m = 0.0;
        layer.layer.hidden_below = 0.0;
        layer.layer.clear_share = 0.0;
    }
    plan
}

fn drawn(executor: &mut dyn Executor, plan: &FramePlan) -> Result<Vec<u8>, Stopped> {
    let failed = |fault: crate::plan::executor::Fault| Stopped::Failed(fault.to_string());
    executor.submit(1, plan).map_err(failed)?;
    match executor.collect(true).map_err(failed)?.pop().map(|finished| finished.pixels) {
        Some(Pixels::Srgb8(bytes)) => Ok(bytes),
        _ => Err(Stopped::Failed("no picture came back".into())),
    }
}

/// Percentile (in thousandths) of the largest difference of a pixel, over the pixels in which the truth shows cloud.
fn over_cloud(picture: &[u8], truth: &[u8], clear: &[u8], per_mille: usize) -> u8 {
    let apart = |a: &[u8], b: &[u8]| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0);
    // Dithering alone moves a code by one.
    let shows_cloud = |i: usize| apart(&truth[i..i + 3], &clear[i..i + 3]) > 2;
    let mut differences: Vec<u8> = (0..truth.len())
        .step_by(4)
        .filter(|i| shows_cloud(*i))
        .map(|i| apart(&picture[i..i + 3], &truth[i..i + 3]))
        .collect();
    differences.sort_unstable();
    let last = differences.len().saturating_sub(1);
    differences.get(last.min(differences.len() * per_mille / 1000)).copied().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_percentile_is_over_cloud_alone() {
        let clear = vec![10u8; 4 * 2000];
        let mut truth = clear.clone();
        // A thousand pixels of cloud, in two of which the picture is 40 codes off, and one off in clear air.
        truth[..4000].fill(200);
        let mut picture = truth.clone();
        picture[0] = 240;
        picture[5] = 160;
        picture[7000] = 90;
        assert_eq!(over_cloud(&picture, &truth, &clear, 999), 40, "more than a thousandth is off");
        picture[5] = 200;
        assert_eq!(over_cloud(&picture, &truth, &clear, 999), 40, "the last of a thousand is the 99.9th percentile");
        picture[0] = 200;
        assert_eq!(over_cloud(&picture, &truth, &clear, 999), 0);
        assert_eq!(over_cloud(&clear, &clear, &clear, 999), 0, "no cloud, no difference");
    }

    #[test]
    fn what_is_skipped_shows_nothing() {
        let eye = EyePoint { altitude_m: 500.0, pitch_deg: 8.0, size_px: [128, 72], field_of_view_deg: 60.0 };
        let mut executor = ReferenceExecutor::new();
        for coverage in [0.4, 1.0] {
            let layer = LayerSpec { coverage, ..scene::layer(CloudKind::Cumulus, 1_000.0, 1_200.0) };
            let plan = scene::snapshot(eye, &[layer], DEFAULT_QUALITY).and_then(|s| scene::plan_of(&s, Output::Srgb8));
            let plan = plan.expect("a plan");
            let clear = scene::snapshot(eye, &[], DEFAULT_QUALITY).and_then(|s| scene::plan_of(&s, Output::Srgb8));
            let clear = drawn(&mut executor, &clear.expect("a plan")).expect("drawn");
            let truth = drawn(&mut executor, &plain(plan.clone())).expect("drawn");
            let skipping = drawn(&mut executor, &plan).expect("drawn");
            // How far a ray may go follows from how steep shapes usually are. Some are steeper, above all at their bases, and a
            // look in a hundred goes too far; elsewhere the looks are the same, and stopping at 0.4 % of what is behind
            // moves a code or two.
            let apart = over_cloud(&skipping, &truth, &clear, 990);
            assert!(apart <= 2, "{apart}");
            assert_ne!(skipping, clear, "there is cloud");
            // A walk that goes four times as far at once is noticed.
            let mut careless = plan;
            careless.layers.iter_mut().for_each(|layer| layer.layer.reach_m *= 4.0);
            let careless = drawn(&mut executor, &careless).expect("drawn");
            assert!(coverage == 1.0 || over_cloud(&careless, &truth, &clear, 990) > 2);
        }
    }
}
