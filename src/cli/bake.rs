//! `stormdeck bake`: basis intensities of a scenario's decks, whole, by shares, resumed, merged, and never twice.

mod share;
mod struck;

use super::render::relight;
use super::{Failure, executor};
use crate::clouds::coverage::Coverage;
use crate::numeric::haar::Haar;
use crate::passes::relight::Lighting;
use crate::passes::relight::cache::{Cache, key};
use crate::scattering::basis::{Content, Recipe};
use crate::scattering::compress::{Packing, Width, threshold_for};
use crate::scattering::deck::Deck;
use crate::scattering::file::{self, JoinError};
use crate::scattering::lights::Lights;
use crate::scattering::ordinates::{self, Params, SolveError, Solver};
use crate::scattering::phase::Phase;
use crate::wire::limits;
use crate::world::World;
use crate::world::command::{Command, ScenarioEdit};
use crate::world::timeline::Timeline;
use std::fs::File;
use std::io::{BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Bakes the light of flashes inside a scenario's cloud deck into a basis file, or merges the shares of one.
#[derive(Debug, clap::Args)]
pub(super) struct Options {
    /// A scenario file, or the name of a built-in scenario.
    #[arg(required_unless_present = "merge", conflicts_with = "merge")]
    scenario: Option<String>,
    /// The basis file to write. One that was begun by the same bake is gone on with.
    #[arg(long, value_name = "FILE", required_unless_present = "struck")]
    out: Option<PathBuf>,
    /// Bakes into the cache, in place of a file, the tables of all pieces of cloud that the scenario's own flashes strike, as
    /// `serve` and `render` need them for `relight` by this method: basis or hybrid.
    #[arg(long, value_name = "METHOD", value_parser = relight, requires = "cache", conflicts_with_all = ["out", "merge", "layer", "cells", "lights", "interval", "content", "index", "tolerance", "width", "threshold", "error"])]
    struck: Option<Lighting>,
    /// Moment of the scenario whose weather is baked, or from which on flashes are looked for, s.
    #[arg(long, default_value_t = 0.0)]
    at: f64,
    /// Which layer, counted from the lowest.
    #[arg(long, default_value_t = 0)]
    layer: usize,
    /// How well each light is solved: residual relative to its first scattering.
    #[arg(long, default_value_t = 1e-3)]
    tolerance: f64,
    /// How coefficients are stored: f32, f16 or byte; without it byte for `diffuse`, f16 for `total`.
    #[arg(long, value_parser = width)]
    width: Option<Width>,
    /// Coefficients below this share of the norm (light of 1 W/sr a cell's edge away, times the root of the number of cells) are
    /// dropped; without it what keeps bolts of `total` within 3 % and the paper's table of `diffuse` within 20 MB.
    #[arg(long, value_name = "SHARE", conflicts_with = "error")]
    threshold: Option<f64>,
    /// Drops as much as keeps the stored light within this relative error (root of summed squares), told by a sample of the lights.
    #[arg(long, value_name = "SHARE")]
    error: Option<f64>,
    /// Interval of the lights in place of `--lights`, m: even across and through the layer, and below it as far apart as
    /// `--fall` allows.
    #[arg(long, value_name = "METRES", conflicts_with = "lights")]
    interval: Option<f64>,
    /// By how much light over distance squared may fall from one light below the layer to the next, 1/m^2.
    #[arg(long, value_name = "FALL", default_value_t = 1e-6, requires = "interval")]
    fall: f64,
    /// What is stored: `diffuse` (for the hybrid method) or `total` (the published scheme).
    #[arg(long, default_value = "diffuse", value_parser = ["diffuse", "total"])]
    content: String,
    /// Cells east, north and up; they must divide 256x256x32.
    #[arg(long, default_value = "32x32x4", value_parser = triple)]
    cells: [usize; 3],
    /// Lights east, north and up.
    #[arg(long, default_value = "20x20x7", value_parser = triple)]
    lights: [usize; 3],
    /// The part of the work to do, from 0.
    #[arg(long, value_name = "I", requires = "of", conflicts_with = "merge")]
    index: Option<usize>,
    /// The number of parts.
    #[arg(long, value_name = "N", requires = "index")]
    of: Option<usize>,
    /// Joins the shares of one bake.
    #[arg(long, value_name = "FILES", num_args = 1..)]
    merge: Vec<PathBuf>,
    /// Moment of the scenario until which flashes are looked for, s; without it its end.
    #[arg(long, value_name = "SECONDS", requires = "struck")]
    until: Option<f64>,
    /// A folder that keeps baked tables by content, so that nothing is baked twice; `serve` and `render` may share it.
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["index", "merge"])]
    cache: Option<PathBuf>,
    /// MiB that the tables in that folder may take; those that were not used for longest go first.
    #[arg(long, value_name = "MIB", default_value_t = 1024, requires = "cache", value_parser = clap::value_parser!(u32).range(limits::BASIS_CACHE_MIB.min as i64..=limits::BASIS_CACHE_MIB.max as i64))]
    cache_mib: u32,
}

/// Shutter of the snapshot that the weather is read from, s; nothing depends on it.
const SHUTTER_S: f64 = 0.01;

/// `AxBxC`.
fn triple(text: &str) -> Result<[usize; 3], String> {
    let numbers: Result<Vec<usize>, _> = text.split('x').map(str::parse).collect();
    numbers.ok().and_then(|n| n.try_into().ok()).ok_or_else(|| format!("`{text}` is not like 32x32x4"))
}

fn width(text: &str) -> Result<Width, String> {
    match text {
        "f32" => Ok(Width::F32),
        "f16" => Ok(Width::F16),
        "byte" => Ok(Width::Log8),
        _ => Err("f32, f16 or byte".to_owned()),
    }
}

/// Bakes or merges.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    if let Some(method) = options.struck {
        return struck::bake(options, method);
    }
    let Some(out) = options.out.as_deref() else { return Err(Failure::Input("--out: is missing".to_owned())) };
    if !options.merge.is_empty() {
        return merge(&options.merge, out);
    }
    let (index, of) = (options.index.unwrap_or(0), options.of.unwrap_or(1));
    if index >= of {
        return Err(Failure::Input(format!(
            "--index {index} --of {of}: shares are counted from 0 to {}",
            of - of.min(1)
        )));
    }
    let recipe = recipe(options)?;
    let cache = options.cache.as_deref().map(|folder| {
        Cache::open(folder, u64::from(options.cache_mib) << 20)
            .map_err(|why| failed(folder, &why))
            .map(|c| (c, key(&recipe)))
    });
    let cache = cache.transpose()?;
    if let Some(kept) = cache.as_ref().and_then(|(cache, key)| cache.whole(key, &recipe)) {
        // What is no file of this bake is left alone, as when it is baked.
        share::open(&recipe, out)?;
        let partial = partial(out);
        std::fs::copy(kept, &partial).and_then(|_| std::fs::rename(&partial, out)).map_err(|why| {
            let _gone = std::fs::remove_file(&partial);
            failed(out, &why)
        })?;
        println!("{}: taken from the cache, nothing baked", out.display());
        return Ok(());
    }
    share::bake(&recipe, index, of, out)?;
    if let Some((cache, key)) = cache {
        cache.put_file(&key, out);
        cache.complaints().iter().for_each(|what| eprintln!("{what}"));
    }
    Ok(())
}

/// The scenario, and its world before its first moment.
fn world(options: &Options) -> Result<(Arc<Timeline>, World), Failure> {
    let wrong = |why: String| Failure::Input(why);
    let timeline = Arc::new(super::scenario::read(options.scenario.as_deref().unwrap_or_default())?);
    for (name, at_s) in [("--at", Some(options.at)), ("--until", options.until)] {
        if let Some(at_s) = at_s.filter(|at_s| !(*at_s >= 0.0 && *at_s <= timeline.duration_s)) {
            return Err(wrong(format!("{name} {at_s}: the scenario runs from 0 to {} s", timeline.duration_s)));
        }
    }
    let mut world = World::new();
    let load = Command::Scenario(ScenarioEdit::Load(timeline.clone()));
    world.apply(load).map_err(|refused| wrong(refused.to_string()))?;
    Ok((timeline, world))
}

/// The recipe of a scenario's layer.
fn recipe(options: &Options) -> Result<Recipe, Failure> {
    let wrong = |why: String| Failure::Input(why);
    let (timeline, mut world) = world(options)?;
    world.advance_to(options.at);
    let snapshot = world.snapshot(SHUTTER_S);
    let mut layers = snapshot.weather.layers.clone();
    layers.sort_by(|a, b| a.base_m.total_cmp(&b.base_m));
    let layer = layers.get(options.layer).ok_or_else(|| {
        wrong(format!("--layer {}: {} has {} layers at {} s", options.layer, timeline.name, layers.len(), options.at))
    })?;
    let theta = Coverage::of(layer.kind).threshold(layer.coverage as f32).typical;
    let deck = Deck { kind: layer.kind, theta, density: layer.density as f32, thickness_m: layer.thickness_m as f32 };
    let medium = deck.medium(options.cells).map_err(|why| wrong(why.to_string()))?;
    let below_m = layer.base_m.max(0.0);
    let size_m = medium.size_m();
    let lights = match options.interval {
        Some(interval_m) => Lights::spaced(interval_m, options.fall, size_m, below_m, true),
        None => Lights::even(options.lights, size_m, below_m, true),
    };
    let lights = lights.map_err(|why| wrong(why.to_string()))?;
    let content = if options.content == "total" { Content::Total } else { Content::Diffuse };
    let params = Params { phase: Phase::HenyeyGreenstein(0.85), tolerance: options.tolerance, ..Params::default() };
    ordinates::check(&params).map_err(|why| wrong(why.to_string()))?;
    for (name, value) in [("--threshold", options.threshold), ("--error", options.error)] {
        if let Some(value) = value.filter(|value| !(*value >= 0.0 && *value < 1.0)) {
            return Err(wrong(format!("{name} {value}: 0 or more, below 1")));
        }
    }
    let threshold = options.threshold.unwrap_or(content.usual_packing().threshold);
    let recipe = Recipe {
        medium,
        params,
        lights,
        content,
        packing: Packing { threshold, width: options.width.unwrap_or(content.usual_packing().width) },
    };
    match options.error {
        Some(error) => within(recipe, error),
        None => Ok(recipe),
    }
}

/// Lights whose fields tell the threshold of a target error: some batches, evenly spread.
const SAMPLE: usize = 8;

/// The recipe with the threshold at which its fields are stored within an error. It hangs on the recipe alone, so that shares and
/// resumed bakes find the same one.
fn within(recipe: Recipe, error: f64) -> Result<Recipe, Failure> {
    let failed = |why: SolveError| Failure::Run(why.to_string());
    let solver = Solver::new(&recipe.medium, recipe.params).map_err(|why| Failure::Input(why.to_string()))?;
    let batches = recipe.batches();
    let some: Vec<_> = batches.iter().step_by(batches.len().div_ceil(SAMPLE)).cloned().collect();
    let mut sample = Vec::new();
    for (number, batch) in some.into_iter().enumerate() {
        // One light of each, higher and higher.
        let fields = recipe.fields(&solver, batch).map_err(failed)?;
        let which = number % fields.len().max(1);
        sample.extend(fields.into_iter().nth(which));
    }
    let (width, norm) = (recipe.packing.width, recipe.norm());
    let threshold = threshold_for(&Haar::new(recipe.medium.cells), &sample, width, norm, error).ok_or_else(|| {
        Failure::Input(format!("error = {error}: values of this width are further off; a wider --width is needed"))
    })?;
    Ok(Recipe { packing: Packing { threshold, width }, ..recipe })
}

/// Joins shares.
fn merge(shares: &[PathBuf], out: &Path) -> Result<(), Failure> {
    // Under another name first: the file may be one of the shares.
    let partial = partial(out);
    let mut file = BufWriter::new(File::create_new(&partial).map_err(|why| failed(&partial, &why))?);
    let open = |i: usize| File::open(&shares[i]).map(BufReader::new);
    let joined = file::join(shares.len(), open, &mut file).map_err(|why| match why {
        JoinError::Share(i, why) => Failure::Input(format!("{}: {why}", shares[i].display())),
        JoinError::Whole(why) => Failure::Input(why.to_string()),
        JoinError::Write(why) => failed(&partial, &why),
    });
    let mut put = || {
        let whole = file.flush().and_then(|()| file.get_ref().sync_all());
        whole.and_then(|()| std::fs::rename(&partial, out)).map_err(|why| failed(out, &why))
    };
    let lights = joined.and_then(|lights| put().map(|()| lights)).inspect_err(|_| {
        // What is left of it is nothing.
        let _gone = std::fs::remove_file(&partial);
    })?;
    println!("{}: {} shares, {lights} lights", out.display(), shares.len());
    Ok(())
}

/// A name beside a file under which it can be written before it is there, which no other program and no file of the user has.
fn partial(out: &Path) -> PathBuf {
    let mut name = out.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.partial", std::process::id()));
    out.with_file_name(name)
}

fn failed(path: &Path, why: &std::io::Error) -> Failure {
    Failure::Run(format!("{}: {why}", path.display()))
}

#[cfg(test)]
mod tests;
