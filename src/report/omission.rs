//! Subject `omission`: what leaving out saves: the same picture with and without what it does not need.

use super::result::Case;
use super::scene::{self, EyePoint};
use super::subject::{Run, Stopped, Subject};
use super::timing::measure;
use crate::clouds::CloudKind;
use crate::frame::Pixels;
use crate::numeric::metrics::relative_mse;
use crate::passes::deck::FLASHES;
use crate::passes::light::library;
use crate::plan::{FramePlan, Output};
use crate::reference::ReferenceExecutor;
use crate::world::DEFAULT_QUALITY;
use crate::world::command::LayerSpec;
use crate::world::snapshot::Snapshot;

/// Leaving out.
pub const SUBJECT: Subject = Subject {
    name: "omission",
    about: "what leaving out saves: what each scene holds in memory; each picture as it is planned, and with what was left out put back in a form that shows nothing",
    measure: cases,
};

fn cases(run: &mut Run) -> Result<(), Stopped> {
    super::memory::cases(run)?;
    super::empty_space::cases(run)?;
    let size_px = run.pick([160, 90], [640, 360]);
    let eye = EyePoint { altitude_m: 500.0, pitch_deg: 5.0, size_px, field_of_view_deg: 60.0 };
    let at = |coverage: f64| {
        let layer = LayerSpec { coverage, ..scene::layer(CloudKind::Cumulus, 1_000.0, 1_200.0) };
        scene::snapshot(eye, &[layer], DEFAULT_QUALITY)
    };
    let planned = |snapshot: &Snapshot| scene::plan_of(snapshot, Output::LinearRgb);
    let runs = run.pick(3, 15);

    // A layer without cloud; put back, a layer whose cloud is too thin to be seen.
    let clear = planned(&at(0.0)?)?;
    let thin = LayerSpec { density: 1e-30, ..scene::layer(CloudKind::Cumulus, 1_000.0, 1_200.0) };
    let invisible = planned(&scene::snapshot(eye, &[thin], DEFAULT_QUALITY)?)?;
    pair(run, "a layer without cloud", &clear, &invisible, runs)?;

    let cloudy = at(0.5)?;
    let broken = planned(&cloudy)?;
    let mut faint = broken.clone();
    for layer in &mut faint.layers {
        // Places without light: their intensity is 0.
        layer.layer.flashes = FLASHES as u32;
    }
    pair(run, "no flash", &broken, &faint, runs)?;

    // Light volumes of the frame before against making them anew.
    let mut executor = ReferenceExecutor::new();
    let (kept, anew) = ("kept from the frame before", "made anew");
    let (first, new_time_s) = measure(run.pick(2, 5), || {
        library::forget();
        ReferenceExecutor::new().draw(&broken)
    });
    executor.draw(&broken);
    let (again, time_s) = measure(runs, || executor.draw(&broken));
    let case = "light volumes and sky table";
    run.record(Case::new(case, anew).time(new_time_s).error("relative MSE", anew, 0.0))?;
    let error = relative_mse(&values(again), &values(first));
    run.record(Case::new(case, kept).time(time_s).error("relative MSE", anew, error))?;

    // Nothing changed since the frame before: planned and compared, against drawn.
    let case = "nothing changed";
    let (same, compared_s) = measure(runs, || planned(&cloudy).map(|plan| plan == broken));
    let (drawn, drawn_s) = measure(runs, || executor.draw(&broken));
    let before = values(executor.draw(&broken));
    let error = if same? { relative_mse(&before, &values(drawn)) } else { f64::NAN };
    run.record(Case::new(case, "drawn").time(drawn_s).error("relative MSE", "drawn", 0.0))?;
    run.record(Case::new(case, "planned, compared and sent again").time(compared_s).error(
        "relative MSE",
        "drawn",
        error,
    ))
}

/// The plan with something left out, and with it put back; both with their times.
fn pair(run: &mut Run, case: &str, left_out: &FramePlan, kept: &FramePlan, runs: u32) -> Result<(), Stopped> {
    let mut executor = ReferenceExecutor::new();
    let mut drawn = |plan: &FramePlan| {
        executor.draw(plan);
        let (pixels, time_s) = measure(runs, || executor.draw(plan));
        (values(pixels), time_s)
    };
    let (whole, whole_s) = drawn(kept);
    let (less, less_s) = drawn(left_out);
    let notes = left_out.notes.iter().filter(|n| !n.kept).map(|n| format!("{}: {}", n.pass, n.why));
    let reference = "kept";
    run.record(Case::new(case, "kept").time(whole_s).error("relative MSE", reference, 0.0))?;
    let row = Case::new(case, "left out").time(less_s).error("relative MSE", reference, relative_mse(&less, &whole));
    let row = row.note(format!("{:.2} times as fast", whole_s.median / less_s.median));
    run.record(notes.fold(row, Case::note))
}

fn values(pixels: Pixels) -> Vec<f32> {
    match pixels {
        Pixels::LinearRgb(values) => values,
        Pixels::Srgb8(_) => Vec::new(),
    }
}
