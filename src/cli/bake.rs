//! `stormdeck bake`: basis intensities of a scenario's decks, whole, by shares, resumed, merged, and never twice.

use super::Failure;
use super::progress::Progress;
use crate::clouds::coverage::Coverage;
use crate::numeric::haar::Haar;
use crate::scattering::basis::{BakeError, Content, Recipe};
use crate::scattering::compress::{Packing, Width, threshold_for};
use crate::scattering::deck::Deck;
use crate::scattering::file;
use crate::scattering::lights::Lights;
use crate::scattering::ordinates::{self, Params, SolveError, Solver};
use crate::scattering::phase::Phase;
use crate::world::World;
use crate::world::command::{Command, ScenarioEdit};
use std::fs::File;
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Bakes the light of flashes inside a scenario's cloud deck into a basis file, or merges the shares of one.
#[derive(Debug, clap::Args)]
pub(super) struct Options {
    /// A scenario file, or the name of a built-in scenario.
    #[arg(required_unless_present = "merge", conflicts_with = "merge")]
    scenario: Option<String>,
    /// The basis file to write. One that was begun by the same bake is gone on with.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Moment of the scenario whose weather is baked, s.
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
    /// A folder that keeps baked files by content, so that nothing is baked twice.
    #[arg(long, value_name = "FOLDER")]
    cache: Option<PathBuf>,
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
    if !options.merge.is_empty() {
        return merge(&options.merge, &options.out);
    }
    let (index, of) = (options.index.unwrap_or(0), options.of.unwrap_or(1));
    if index >= of {
        return Err(Failure::Input(format!(
            "--index {index} --of {of}: shares are counted from 0 to {}",
            of - of.min(1)
        )));
    }
    let recipe = recipe(options)?;
    let kept = options.cache.as_ref().map(|folder| folder.join(format!("{}.basis", recipe.name())));
    if let Some(kept) = kept.as_ref().filter(|k| of == 1 && k.exists()) {
        // A file of the cache is checked like any other: a damaged one is baked again.
        if std::fs::read(kept).ok().is_some_and(|bytes| file::read(&bytes).is_ok()) {
            std::fs::copy(kept, &options.out).map_err(|why| failed(&options.out, &why))?;
            println!("{}: taken from the cache, nothing baked", options.out.display());
            return Ok(());
        }
    }
    bake(&recipe, index, of, &options.out)?;
    if let Some(kept) = kept.filter(|_| of == 1) {
        // Under another name first, so that the cache never shows half a file.
        let partial = kept.with_extension("partial");
        let put = kept
            .parent()
            .map_or(Ok(()), std::fs::create_dir_all)
            .and_then(|()| std::fs::copy(&options.out, &partial))
            .and_then(|_| std::fs::rename(&partial, &kept));
        put.map_err(|why| failed(&kept, &why))?;
    }
    Ok(())
}

/// The recipe of a scenario's layer.
fn recipe(options: &Options) -> Result<Recipe, Failure> {
    let wrong = |why: String| Failure::Input(why);
    let name = options.scenario.as_deref().unwrap_or_default();
    let timeline = super::scenario::read(name)?;
    if !(options.at >= 0.0 && options.at <= timeline.duration_s) {
        return Err(wrong(format!("--at {}: the scenario runs from 0 to {} s", options.at, timeline.duration_s)));
    }
    let mut world = World::new();
    let load = Command::Scenario(ScenarioEdit::Load(Arc::new(timeline)));
    world.apply(load).map_err(|refused| wrong(refused.to_string()))?;
    world.advance_to(options.at);
    let snapshot = world.snapshot(SHUTTER_S);
    let mut layers = snapshot.weather.layers.clone();
    layers.sort_by(|a, b| a.base_m.total_cmp(&b.base_m));
    let layer = layers.get(options.layer).ok_or_else(|| {
        wrong(format!("--layer {}: {name} has {} layers at {} s", options.layer, layers.len(), options.at))
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

/// Bakes one share into a file, going on where one was left.
fn bake(recipe: &Recipe, index: usize, of: usize, out: &Path) -> Result<(), Failure> {
    let batches = recipe.batches();
    let share = recipe.share(index, of);
    let (mut file, done) = open(recipe, out)?;
    // Whole batches only: the lights of half a batch are baked again.
    let due: usize = batches[share.clone()].iter().map(std::ops::Range::len).sum();
    let mut from = share.start;
    let mut there = 0;
    while from < share.end && there + batches[from].len() <= done.lights.len() {
        there += batches[from].len();
        from += 1;
    }
    if done.lights.first().is_some_and(|l| *l != batches[share.start].start) {
        return Err(Failure::Input(format!("{}: holds another share of this bake", out.display())));
    }
    if done.lights.len() > due {
        return Err(Failure::Input(format!("{}: holds more than this share; it is not cut", out.display())));
    }
    let end = done.offsets.get(there).copied().unwrap_or(done.header);
    file.set_len(end).and_then(|()| file.seek(SeekFrom::Start(end))).map_err(|why| failed(out, &why))?;
    if there > 0 {
        println!("{}: going on after {there} of {due} lights", out.display());
    }
    let progress = Progress::new("baking lights", due);
    let mut baked = there;
    let outcome = recipe.bake(from..share.end, |light, block| {
        file.write_all(&file::block(recipe, light, &block))?;
        baked += 1;
        progress.show(baked);
        Ok::<(), std::io::Error>(())
    });
    drop(progress);
    outcome.map_err(|why| match why {
        BakeError::Sink(why) => failed(out, &why),
        other @ BakeError::Solve { .. } => Failure::Run(other.to_string()),
    })?;
    if of == 1 {
        finish(recipe, &mut file, out)?;
    }
    file.sync_all().map_err(|why| failed(out, &why))?;
    println!("{}: {baked} lights of {}", out.display(), recipe.lights.len());
    Ok(())
}

/// What a file of this bake holds already.
struct Done {
    /// Bytes of the header.
    header: u64,
    lights: Vec<usize>,
    /// Where each light's block begins, and where the last one ends.
    offsets: Vec<u64>,
}

/// Opens the file, new or begun by the same recipe; any other file is left alone.
fn open(recipe: &Recipe, out: &Path) -> Result<(File, Done), Failure> {
    let header = file::header(recipe);
    let mut done = Done { header: header.len() as u64, lights: Vec::new(), offsets: Vec::new() };
    let old = match std::fs::metadata(out) {
        Err(why) if why.kind() == std::io::ErrorKind::NotFound => Vec::new(),
        Ok(found) if !found.is_file() => return Err(Failure::Input(format!("{}: is no file", out.display()))),
        _ => std::fs::read(out).map_err(|why| failed(out, &why))?,
    };
    let mut file =
        File::options().create(true).truncate(false).write(true).open(out).map_err(|why| failed(out, &why))?;
    // A bake killed in the header has written a part of just these bytes.
    if old.len() < header.len() && header.starts_with(&old) {
        file.write_all(&header).map_err(|why| failed(out, &why))?;
        return Ok((file, done));
    }
    let contents = file::scan(&old, true).map_err(|why| Failure::Input(format!("{}: {why}", out.display())))?;
    if contents.recipe != *recipe {
        return Err(Failure::Input(format!("{}: is of another bake; it is not written over", out.display())));
    }
    let mut at = done.header;
    for (light, block) in &contents.blocks {
        done.lights.push(*light);
        done.offsets.push(at);
        at += file::block(recipe, *light, block).len() as u64;
    }
    done.offsets.push(at);
    Ok((file, done))
}

/// Writes the trailer of a whole bake.
fn finish(recipe: &Recipe, file: &mut File, out: &Path) -> Result<(), Failure> {
    let bytes = std::fs::read(out).map_err(|why| failed(out, &why))?;
    let contents = file::scan(&bytes, false).map_err(|why| Failure::Run(format!("{}: {why}", out.display())))?;
    let blocks: Vec<_> = contents.blocks.into_iter().map(|(_, block)| block).collect();
    file.write_all(&file::trailer(&blocks, recipe)).map_err(|why| failed(out, &why))
}

/// Joins shares.
fn merge(shares: &[PathBuf], out: &Path) -> Result<(), Failure> {
    let read: Result<Vec<Vec<u8>>, Failure> = shares
        .iter()
        .map(|path| std::fs::read(path).map_err(|why| Failure::Input(format!("{}: {why}", path.display()))))
        .collect();
    let read = read?;
    let borrowed: Vec<&[u8]> = read.iter().map(|bytes| &bytes[..]).collect();
    let whole = file::merge(&borrowed).map_err(|why| Failure::Input(why.to_string()))?;
    std::fs::write(out, &whole).map_err(|why| failed(out, &why))?;
    println!("{}: {} shares, {} bytes", out.display(), shares.len(), whole.len());
    Ok(())
}

fn failed(path: &Path, why: &std::io::Error) -> Failure {
    Failure::Run(format!("{}: {why}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(out: &Path) -> Options {
        Options {
            scenario: Some("overcast-night-cities".into()),
            out: out.to_path_buf(),
            at: 0.0,
            layer: 0,
            tolerance: 1e-2,
            width: None,
            threshold: None,
            error: None,
            interval: None,
            fall: 1e-6,
            content: "diffuse".into(),
            cells: [8, 8, 2],
            lights: [2, 2, 3],
            index: None,
            of: None,
            merge: Vec::new(),
            cache: None,
        }
    }

    /// A folder of its own, gone at the end.
    struct Folder(PathBuf);

    impl Folder {
        fn new(name: &str) -> Self {
            let path = std::env::temp_dir().join(format!("stormdeck-bake-{name}-{}", std::process::id()));
            std::fs::create_dir_all(&path).expect("a folder");
            Self(path)
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn shares_torn_files_and_the_cache_all_give_the_same_bytes() {
        let folder = Folder::new("same");
        let at = |name: &str| folder.0.join(name);
        let cache = Some(at("cache"));
        run(&Options { cache: cache.clone(), ..options(&at("whole")) }).expect("baked");
        let whole = std::fs::read(at("whole")).expect("written");
        assert_eq!(file::read(&whole).expect("a basis").blocks.len(), 12);
        for index in 0..3 {
            let share = at(&format!("share{index}"));
            run(&Options { index: Some(index), of: Some(3), ..options(&share) }).expect("baked");
        }
        let merge = vec![at("share2"), at("share0"), at("share1")];
        run(&Options { scenario: None, merge, ..options(&at("merged")) }).expect("merged");
        assert_eq!(std::fs::read(at("merged")).expect("written"), whole);
        // Killed anywhere: in the header, in a block, between blocks, in the trailer, and not at all.
        let steps = (0..=24).map(|i| whole.len() * i / 24);
        for cut in steps.chain([5, 700, whole.len() - 3]) {
            std::fs::write(at("torn"), &whole[..cut]).expect("written");
            run(&options(&at("torn"))).expect("gone on with");
            assert_eq!(std::fs::read(at("torn")).expect("written"), whole, "{cut}");
        }
        run(&Options { cache, ..options(&at("cached")) }).expect("copied");
        assert_eq!(std::fs::read(at("cached")).expect("written"), whole);
    }

    #[test]
    fn a_target_error_is_kept_by_every_width_that_can() {
        let folder = Folder::new("error");
        for (width, error) in [(Width::F32, 0.01), (Width::F16, 0.03), (Width::Log8, 0.06)] {
            let out = folder.0.join(format!("{width:?}"));
            run(&Options { width: Some(width), error: Some(error), interval: Some(4_000.0), ..options(&out) })
                .expect("baked");
            let basis = file::read(&std::fs::read(&out).expect("written")).expect("a basis");
            assert_eq!(basis.recipe.packing.width, width);
            // A sample told the threshold: the other lights may be a little worse.
            assert!(basis.error() < 1.5 * error && basis.error() > 0.1 * error, "{width:?}: {}", basis.error());
            // Below the layer lights stand farther and farther apart.
            assert!(basis.recipe.lights.z_m[0] < 0.0);
        }
    }

    #[test]
    fn other_files_are_left_alone_and_bad_options_are_told() {
        let folder = Folder::new("alone");
        let other = folder.0.join("other");
        std::fs::write(&other, vec![7; 5000]).expect("written");
        assert!(matches!(run(&options(&other)), Err(Failure::Input(_))));
        assert_eq!(std::fs::read(&other).expect("there"), vec![7; 5000]);
        let out = folder.0.join("out");
        for bad in [
            Options { layer: 99, ..options(&out) },
            Options { at: -1.0, ..options(&out) },
            Options { cells: [7, 8, 2], ..options(&out) },
            Options { lights: [0, 1, 1], ..options(&out) },
            Options { interval: Some(-1.0), ..options(&out) },
            Options { threshold: Some(f64::NAN), ..options(&out) },
            Options { error: Some(1.5), ..options(&out) },
            Options { tolerance: 0.0, ..options(&out) },
            Options { index: Some(3), of: Some(3), ..options(&out) },
            Options { scenario: Some("no such".into()), ..options(&out) },
        ] {
            assert!(matches!(run(&bad), Err(Failure::Input(_))), "{bad:?}");
        }
        assert!(!out.exists());
    }
}
