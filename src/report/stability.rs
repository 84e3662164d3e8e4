//! Subject `stability`: the worst that may be asked of the deck: finite or not, how wrong, and what was done about it.

use super::result::Case;
use super::scene::{self, EyePoint};
use super::subject::{Run, Stopped, Subject};
use super::timing::measure;
use crate::clouds::CloudKind;
use crate::frame::Pixels;
use crate::geo::Geodetic;
use crate::geo::frames::enu;
use crate::numeric::metrics::relative_mse;
use crate::plan::{FramePlan, Output};
use crate::reference::ReferenceExecutor;
use crate::reference::converged::{Step, deck};
use crate::world::DEFAULT_QUALITY;
use crate::world::World;
use crate::world::command::{Command, WeatherEdit};
use crate::world::snapshot::{Quality, Snapshot};
use glam::DVec3;

/// Extremes of the deck.
pub const SUBJECT: Subject = Subject {
    name: "stability",
    about: "the extremes of the deck: whether the picture is finite, its error against the deck's own model marched in \
            short steps, and what was done about it",
    measure: cases,
};

type Change = Box<dyn Fn(&mut Snapshot)>;

/// An eye on this height that looks level.
fn eye(altitude_m: f64, pitch_deg: f64) -> EyePoint {
    EyePoint { altitude_m, pitch_deg, size_px: [32, 18], field_of_view_deg: 60.0 }
}

fn cases(run: &mut Run) -> Result<(), Stopped> {
    for (name, change) in extremes() {
        picture(run, name, &change)?;
    }
    coverage(run)?;
    refusals(run)
}

/// Every extreme with its name; each changes a day of cumulus from 1000 to 2000 m with the eye at 1500 m.
fn extremes() -> Vec<(&'static str, Change)> {
    fn layer(change: impl Fn(&mut crate::world::snapshot::LayerState) + 'static) -> Change {
        Box::new(move |s| s.weather.layers.iter_mut().for_each(&change))
    }
    fn with(change: impl Fn(&mut Snapshot) + 'static) -> Change {
        Box::new(change)
    }
    fn eye_at(altitude_m: f64) -> Change {
        Box::new(move |s| s.ownship.position.altitude_m = altitude_m)
    }
    fn place(latitude_deg: f64, longitude_deg: f64) -> Change {
        Box::new(move |s| {
            let position = Geodetic {
                latitude_rad: latitude_deg.to_radians(),
                longitude_rad: longitude_deg.to_radians(),
                ..s.ownship.position
            };
            s.ownship.position = position;
            sun(s, 40.0);
        })
    }
    fn view(change: impl Fn(&mut crate::world::snapshot::ViewState) + 'static) -> Change {
        Box::new(move |s| s.views.iter_mut().for_each(&change))
    }
    vec![
        ("plain", with(|_| ())),
        ("coverage 0", layer(|l| l.coverage = 0.0)),
        ("coverage 1", layer(|l| l.coverage = 1.0)),
        ("density 0", layer(|l| l.density = 0.0)),
        ("density 1e-300", layer(|l| l.density = 1e-300)),
        ("density 100", layer(|l| l.density = 100.0)),
        ("thickness 1 m, eye inside", layer(|l| (l.base_m, l.thickness_m) = (1_499.5, 1.0))),
        ("thickness 18 km", layer(|l| (l.base_m, l.thickness_m) = (500.0, 18_000.0))),
        ("base 500 m below the ground", layer(|l| l.base_m = -500.0)),
        ("one slice", with(|s| s.quality.slices = 1)),
        ("512 slices", with(|s| s.quality.slices = 512)),
        ("eye on the base", eye_at(1_000.0)),
        ("eye on the top", eye_at(2_000.0)),
        ("eye on a slice", eye_at(1_000.0 + 1_000.0 * 8.0 / 31.0)),
        ("eye 1 m up", eye_at(1.0)),
        ("eye 400 km up", eye_at(400_000.0)),
        ("sun in the zenith", with(|s| sun(s, 90.0))),
        ("sun on the horizon", with(|s| sun(s, 0.0))),
        ("sun 12 degrees below", with(|s| sun(s, -12.0))),
        ("north pole", place(90.0, 0.0)),
        ("south pole", place(-90.0, 77.0)),
        ("180th meridian", place(0.0, 180.0)),
        ("field of view 1 degree", view(|v| v.field_of_view_deg = 1.0)),
        ("field of view 170 degrees", view(|v| v.field_of_view_deg = 170.0)),
        ("16 x 16 pixels", view(|v| v.size_px = [16, 16])),
        (
            "two layers that overlap",
            with(|s| {
                let other = s.weather.layers.first().copied();
                s.weather.layers.extend(other.map(|l| crate::world::snapshot::LayerState {
                    kind: CloudKind::Stratocumulus,
                    base_m: 1_400.0,
                    ..l
                }));
            }),
        ),
        ("wind of 150 m/s for ten years", with(|_| ())),
    ]
}

/// The sun at an elevation to the north, the moon opposite.
fn sun(snapshot: &mut Snapshot, elevation_deg: f64) {
    let (up, north) = elevation_deg.to_radians().sin_cos();
    let direction = enu(&snapshot.ownship.position) * DVec3::new(0.0, north, up);
    (snapshot.sky.sun_direction_ecef, snapshot.sky.moon_direction_ecef) = (direction, -direction);
}

/// The snapshot that an extreme changes.
fn base(name: &str) -> Result<Snapshot, Stopped> {
    let layer = scene::layer(CloudKind::Cumulus, 1_000.0, 1_000.0);
    let quality = Quality { deck_scale: 1, ..DEFAULT_QUALITY };
    let mut snapshot = if name.starts_with("wind") {
        let layer = crate::world::command::LayerSpec { wind_speed_mps: 150.0, wind_from_deg: 250.0, ..layer };
        scene::snapshot_after(eye(1_500.0, 0.0), &[layer], quality, 10.0 * 365.25 * 86_400.0)?
    } else {
        scene::snapshot(eye(1_500.0, 0.0), &[layer], quality)?
    };
    sun(&mut snapshot, 40.0);
    Ok(snapshot)
}

fn picture(run: &mut Run, name: &str, change: &Change) -> Result<(), Stopped> {
    let mut snapshot = base(name)?;
    change(&mut snapshot);
    let plan = scene::plan_of(&snapshot, Output::LinearRgb)?;
    let mut executor = ReferenceExecutor::new();
    // The first picture makes light volumes; its time is theirs.
    executor.draw(&plan);
    let (drawn, time_s) = measure(3, || executor.draw(&plan));
    let drawn = values(drawn);
    let finite = drawn.iter().all(|v| v.is_finite() && *v >= 0.0);
    let done: Vec<String> =
        plan.notes.iter().filter(|n| n.pass == "deck" && !n.kept).map(|n| format!("left out: {}", n.why)).collect();
    let marched = marched(&mut executor, &plan);
    let case = Case::new("pictures", name)
        .time(time_s)
        .note(if finite { "finite" } else { "NOT FINITE" })
        .error("values that are not finite", "none", drawn.iter().filter(|v| !v.is_finite()).count() as f64)
        .error("relative MSE", "converged", relative_mse(&drawn, &marched));
    run.record(done.into_iter().fold(case, Case::note))
}

/// The converged picture.
fn marched(executor: &mut ReferenceExecutor, plan: &FramePlan) -> Vec<f32> {
    let mut without = plan.clone();
    // Clouds that nobody sees, but whose shadows lie on the ground.
    without.layers.iter_mut().for_each(|l| l.layer.extinction_per_m = 0.0);
    let behind = values(executor.draw(&without));
    let step = Step { at_eye_m: 1.0, growth: 0.002 };
    let seen = executor.prepared(plan, |table, layers, _, _| deck(plan, table, layers, step));
    let pixel = |(seen, behind): (&crate::reference::converged::Seen, &[f32])| {
        std::array::from_fn::<f32, 3, _>(|c| (seen.luminance[c] + f64::from(behind[c]) * seen.transmittance) as f32)
    };
    seen.iter().zip(behind.chunks_exact(3)).flat_map(pixel).collect()
}

fn values(pixels: Pixels) -> Vec<f32> {
    match pixels {
        Pixels::LinearRgb(values) => values,
        Pixels::Srgb8(_) => Vec::new(),
    }
}

/// Cover seen from above at every step of coverage, for every genus: never less at a higher coverage, and what was asked.
fn coverage(run: &mut Run) -> Result<(), Stopped> {
    let steps = run.pick(10, 100);
    for kind in CloudKind::ALL {
        let look = kind.appearance();
        let thickness_m = f64::from(look.usual_thickness_m);
        let full = f64::from(look.extinction_per_m) * thickness_m;
        // Seen as cloud: what coverage is calibrated with (see `clouds::coverage`).
        let depth = 1f64.min(full / 3.0);
        let mut rows: Vec<(f64, f64, f64)> = Vec::new();
        let mut executor = ReferenceExecutor::new();
        for step in 0..=steps {
            let asked = f64::from(step) / f64::from(steps);
            let layer =
                crate::world::command::LayerSpec { coverage: asked, ..scene::layer(kind, 1_000.0, thickness_m) };
            let above = EyePoint { size_px: [24, 24], field_of_view_deg: 90.0, ..eye(100_000.0, -90.0) };
            let plan = scene::plan_of(&scene::snapshot(above, &[layer], DEFAULT_QUALITY)?, Output::LinearRgb)?;
            let step_m = thickness_m / 64.0;
            let seen = executor.prepared(&plan, |table, layers, _, _| {
                deck(&plan, table, layers, Step { at_eye_m: step_m, growth: 0.0 })
            });
            let opacity = seen.iter().map(|s| 1.0 - s.transmittance).sum::<f64>() / seen.len() as f64;
            // A slanted ray is longer than the column: its depth is brought to the vertical.
            let hidden = seen.iter().enumerate().filter(|(i, s)| {
                let ray = plan.camera.ray((i % 24) as f32 + 0.5, (i / 24) as f32 + 0.5);
                -s.transmittance.ln() * f64::from(-ray.z) >= depth
            });
            rows.push((asked, opacity, hidden.count() as f64 / seen.len() as f64));
        }
        let falls = rows.windows(2).map(|w| w[0].1 - w[1].1).fold(0.0, f64::max);
        let (at, apart) = rows
            .iter()
            .map(|(c, _, cover)| (*c, (cover - c).abs()))
            .fold((0.0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
        let full_direct = rows.last().map_or(f64::NAN, |r| 1.0 - r.1);
        run.record(
            Case::new("coverage from above", format!("{kind:?}"))
                .param("steps", steps)
                .error("fall of mean opacity", "never falls", falls)
                .error("cover less what was asked, greatest", "coverage asked", apart)
                .note(format!(
                    "greatest at coverage {at:.2}; at coverage 1 {full_direct:.4} of direct light pass on average"
                )),
        )?;
    }
    Ok(())
}

/// What no picture can be made of is refused, each with its reason.
fn refusals(run: &mut Run) -> Result<(), Stopped> {
    let layer = scene::layer(CloudKind::Cumulus, 1_000.0, 1_000.0);
    type Spoil = fn(&mut crate::world::command::LayerSpec);
    let wrong: [(&str, Spoil); 7] = [
        ("coverage 1.5", |l| l.coverage = 1.5),
        ("coverage NaN", |l| l.coverage = f64::NAN),
        ("density -1", |l| l.density = -1.0),
        ("density 1e9", |l| l.density = 1e9),
        ("thickness 0", |l| l.thickness_m = 0.0),
        ("thickness infinite", |l| l.thickness_m = f64::INFINITY),
        ("wind 1e6 m/s", |l| l.wind_speed_mps = 1e6),
    ];
    for (name, spoil) in wrong {
        let mut layer = layer;
        spoil(&mut layer);
        let weather = WeatherEdit { layers: Some(vec![layer]), ..Default::default() };
        let (accepted, note) = match World::new().apply(Command::Weather(weather)) {
            Ok(_) => (1.0, "ACCEPTED".to_owned()),
            Err(refused) => (0.0, format!("refused: {refused}")),
        };
        run.record(Case::new("refusals", name).error("accepted", "refused", accepted).note(note))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::subject::Item;

    #[test]
    fn extremes_are_finite_and_a_picture_that_is_not_is_told() {
        let mut results = Vec::new();
        let mut sink = |item: Item| {
            if let Item::Case(case) = item {
                results.extend(case.results("stability"));
            }
            Ok(())
        };
        let mut run = Run::new(true, &mut sink);
        for (name, change) in extremes().iter().filter(|(name, _)| ["one slice", "density 100"].contains(name)) {
            picture(&mut run, name, change).expect("a picture");
        }
        let broken: Change = Box::new(|s| s.weather.layers[0].density = f64::NAN);
        picture(&mut run, "broken", &broken).expect("a picture");
        refusals(&mut run).expect("refusals");
        let values = |metric: &str| -> Vec<Option<f64>> {
            results.iter().filter(|r| r.error.metric == metric).map(|r| r.error.value).collect()
        };
        let counts = values("values that are not finite");
        assert_eq!(counts[..2], [Some(0.0), Some(0.0)]);
        let errors = values("relative MSE");
        assert!(errors[..2].iter().all(|e| e.is_some_and(|e| e < 0.5)), "{errors:?}");
        assert!(counts[2] > Some(0.0) || errors[2].is_none(), "a broken picture: {counts:?} {errors:?}");
        assert!(values("accepted").iter().all(|v| *v == Some(0.0)));
    }
}
