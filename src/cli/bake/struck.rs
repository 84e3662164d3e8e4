//! Tables of the pieces of cloud that a scenario's flashes strike, baked before anybody watches: `bake --struck`.

use super::super::progress::Progress;
use super::{Failure, Options, executor, world};
use crate::passes::relight::{Lighting, Request};
use crate::plan::{Output, plan};
use crate::world::snapshot::Quality;
use std::sync::{Mutex, PoisonError};

/// Interval at which the scenario is looked at, s; its shutter is as long, so that no stroke falls between two looks.
const STEP_S: f64 = 1.0 / 60.0;

/// Plays the scenario, notes which pieces of cloud are lit by tables, and bakes these tables into the cache.
pub(super) fn bake(options: &Options, method: Lighting) -> Result<(), Failure> {
    if method.method().table().is_none() {
        return Err(Failure::Input(format!("--struck {}: basis and hybrid have tables", method.name())));
    }
    let tables = executor::tables(options.cache.as_deref(), options.cache_mib)?;
    let (clouds, without) = clouds(options, method)?;
    let (mut baked, mut failed) = (0, 0);
    for (number, cloud) in clouds.iter().enumerate() {
        println!("piece {} of {}", number + 1, clouds.len());
        let progress: Mutex<Option<Progress>> = Mutex::new(None);
        let told = |there: usize, of: usize| {
            let mut progress = progress.lock().unwrap_or_else(PoisonError::into_inner);
            progress.get_or_insert_with(|| Progress::new("baking lights", of)).show(there);
        };
        let [now, not] = tables.bake_whole(cloud, told).unwrap_or_default();
        (baked, failed) = (baked + now, failed + not);
    }
    tables.complaints().iter().for_each(|what| eprintln!("{what}"));
    println!("{} pieces of cloud: {baked} lights baked, {} read from the cache", clouds.len(), tables.status().read);
    if without > 0 {
        println!(
            "{without} geometries are solved in place: their tables would be too large, or their clouds are towers"
        );
    }
    if failed > 0 {
        return Err(Failure::Run(format!("{failed} lights were not found; flashes that need them are solved")));
    }
    Ok(())
}

/// The clouds of the flashes' tables, each once, and the number of channels that have none.
fn clouds(options: &Options, method: Lighting) -> Result<(Vec<Request>, usize), Failure> {
    let (timeline, mut world) = world(options)?;
    world.set_quality(Quality { relight: method, ..world.peek(0.0).quality });
    let (mut clouds, mut without): (Vec<Request>, Vec<Request>) = (Vec::new(), Vec::new());
    let end_s = options.until.unwrap_or(timeline.duration_s);
    for step in 0.. {
        let at_s = options.at + f64::from(step) * STEP_S;
        if at_s > end_s {
            break;
        }
        world.advance_to(at_s);
        let snapshot = world.snapshot(STEP_S);
        let shines = snapshot.flashes.iter().any(|flash| flash.intensity_cd > 0.0);
        let Some(view) = snapshot.views.first().filter(|_| shines) else { continue };
        let plan = plan(&snapshot, view, Output::Srgb8);
        for request in plan.lit.iter().map(|lit| &lit.request) {
            let (list, request) = match request.patch {
                Some(_) => (&mut clouds, Request { points: Vec::new(), ..(**request).clone() }),
                None => (&mut without, (**request).clone()),
            };
            if !list.contains(&request) {
                list.push(request);
            }
        }
    }
    Ok((clouds, without.len()))
}
