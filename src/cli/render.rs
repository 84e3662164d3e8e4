//! `stormdeck render`: any moment of a scenario as a picture file, without a server.

use super::progress::Progress;
use super::{Failure, executor, scenario};
use crate::encode::{Format, encode_pixels};
use crate::frame::Pixels;
use crate::passes::relight::Lighting;
use crate::plan::executor::{Executor, Fault};
use crate::plan::{FramePlan, Output, plan};
use crate::settings::{ExecutorChoice, TerrainChoice, with_heights};
use crate::wire::limits;
use crate::world::World;
use crate::world::command::{Command, ScenarioEdit};
use crate::world::event::Refused;
use crate::world::snapshot::{Quality, ViewState};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Seconds whose light one picture gathers when it stands alone: a frame of 60 a second.
const SHUTTER_S: f64 = 1.0 / 60.0;
/// Quality of JPEG files.
const JPEG_QUALITY: u8 = 92;

/// Draws a moment of a scenario to a picture file (PNG, JPEG or EXR), or a numbered sequence, without a server.
#[derive(Debug, clap::Args)]
pub(super) struct Options {
    /// A scenario file, or the name of a built-in scenario.
    scenario: String,
    /// Simulation time of the picture in seconds.
    #[arg(long, value_name = "SECONDS", value_parser = seconds, required_unless_present = "from", conflicts_with_all = ["from", "to", "fps"])]
    at: Option<f64>,
    /// Simulation time of a sequence's first picture.
    #[arg(long, value_name = "SECONDS", value_parser = seconds, requires_all = ["to", "fps"])]
    from: Option<f64>,
    /// Simulation time at which a sequence ends (its last picture is not after it).
    #[arg(long, value_name = "SECONDS", value_parser = seconds, requires = "from")]
    to: Option<f64>,
    /// Pictures per second of simulation of a sequence.
    #[arg(long, value_name = "RATE", value_parser = rate, requires = "from")]
    fps: Option<f64>,
    /// The file: .png, .jpg or .exr (linear, cd/m2). A sequence puts a number before the dot: sky.png, sky-00000.png.
    #[arg(long, value_name = "FILE", required_unless_present = "explain")]
    out: Option<PathBuf>,
    /// Width and height in pixels instead of the view's own.
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// The view; the first one by name when none is given.
    #[arg(long, value_name = "NAME")]
    view: Option<String>,
    /// What draws: gpu, reference, or auto (the GPU when there is one).
    #[arg(long, value_name = "E", value_parser = executor::choice, default_value = "auto")]
    executor: ExecutorChoice,
    /// Where the ground is: procedural, or ellipsoid (level everywhere).
    #[arg(long, value_name = "T", value_parser = terrain, default_value = "ellipsoid")]
    terrain: TerrainChoice,
    /// GeoTIFF or HGT file of heights that is laid over it.
    #[arg(long, value_name = "FILE")]
    terrain_file: Option<PathBuf>,
    /// Height of mean sea level above the WGS84 ellipsoid, from which the file's heights count.
    #[arg(long, value_name = "METRES", value_parser = sea_level, default_value = "0", requires = "terrain_file", allow_negative_numbers = true)]
    terrain_sea_level_m: f64,
    /// Slices per cloud layer.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(limits::SLICES.min as i64..=limits::SLICES.max as i64))]
    slices: Option<u32>,
    /// How flashes light the clouds: point, single, basis, hybrid, solve or reference.
    #[arg(long, value_name = "METHOD", value_parser = relight)]
    relight: Option<Lighting>,
    /// A folder that keeps tables of virtual lights by content (for `basis` and `hybrid`), so that nothing is baked twice.
    #[arg(long, value_name = "FOLDER")]
    basis_cache: Option<PathBuf>,
    /// MiB that the tables in that folder may take.
    #[arg(long, value_name = "MIB", default_value_t = 1024, requires = "basis_cache", value_parser = clap::value_parser!(u32).range(limits::BASIS_CACHE_MIB.min as i64..=limits::BASIS_CACHE_MIB.max as i64))]
    basis_cache_mib: u32,
    /// Prints the plan of the (first) picture: each pass, kept or left out, and why.
    #[arg(long)]
    explain: bool,
}

/// The ground of a name.
pub(super) fn terrain(text: &str) -> Result<TerrainChoice, String> {
    match text {
        "procedural" => Ok(TerrainChoice::Procedural),
        "ellipsoid" => Ok(TerrainChoice::Ellipsoid),
        _ => Err("procedural or ellipsoid".to_owned()),
    }
}

fn sea_level(text: &str) -> Result<f64, String> {
    let range = limits::SEA_LEVEL_M;
    match text.parse() {
        Ok(sea_level_m) if (range.min..=range.max).contains(&sea_level_m) => Ok(sea_level_m),
        _ => Err(format!("a number of {} to {} metres", range.min, range.max)),
    }
}

pub(super) fn relight(text: &str) -> Result<Lighting, String> {
    let names = Lighting::ALL.map(Lighting::name).join(", ");
    Lighting::ALL.into_iter().find(|method| method.name() == text).ok_or_else(|| format!("one of {names}"))
}

fn seconds(text: &str) -> Result<f64, String> {
    let range = limits::SIMULATION_TIME_S;
    match text.parse() {
        Ok(at_s) if (range.min..=range.max).contains(&at_s) => Ok(at_s),
        _ => Err(format!("a number of {} to {} seconds", range.min, range.max)),
    }
}

fn rate(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(rate) if (0.001..=1000.0).contains(&rate) => Ok(rate),
        _ => Err("a number of 0.001 to 1000".to_owned()),
    }
}

pub(super) fn size(text: &str) -> Result<[u32; 2], String> {
    let range = limits::SIZE_PX;
    let side = |text: &str| text.parse().ok().filter(|&side| (range.min..=range.max).contains(&u64::from(side)));
    let sides = text.split_once('x').and_then(|(width, height)| Some([side(width)?, side(height)?]));
    sides.ok_or_else(|| format!("two numbers of {} to {}, as in 640x360", range.min, range.max))
}

/// Most pictures of one sequence: a day at 60 a second is 5 million.
const MOST_PICTURES: f64 = 1e6;

/// Draws and writes every picture asked for.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let out = options.out.as_deref().map(|path| format_of(path).map(|format| (path, format))).transpose()?;
    let output = match out {
        Some((_, Format::Exr)) => Output::LinearRgb,
        _ => Output::Srgb8,
    };
    let times = times(options)?;
    let mut world = world(options)?;
    let end_s = world.timeline().map_or(0.0, |timeline| timeline.duration_s);
    if let Some(late_s) = times.last().filter(|&&at_s| end_s > 0.0 && at_s > end_s) {
        return Err(Failure::Input(format!("{late_s} s is after the scenario's end at {end_s} s")));
    }
    let mut plan_at = |at_s: f64| -> Result<FramePlan, Failure> {
        world.advance_to(at_s);
        let snapshot = world.snapshot(options.fps.map_or(SHUTTER_S, |fps| SHUTTER_S.min(1.0 / fps)));
        let mut view = view(&snapshot.views, options.view.as_deref())?.clone();
        view.size_px = options.size.unwrap_or(view.size_px);
        Ok(plan(&snapshot, &view, output))
    };
    let first = plan_at(times.first().copied().unwrap_or_default())?;
    if options.explain {
        explain(&first);
    }
    let Some((path, format)) = out else { return Ok(()) };
    let tables = executor::tables(options.basis_cache.as_deref(), options.basis_cache_mib)?;
    let (mut executor, why) = executor::make(options.executor, &tables)?;
    eprintln!("drawn by {why}");

    // As many pictures are under way as the executor has room for; they come back in order.
    let progress = Progress::new("render", times.len());
    let mut written = 0;
    let mut under_way: Vec<[u32; 2]> = Vec::new();
    let mut first = Some(first);
    for (ticket, &at_s) in times.iter().enumerate() {
        let plan = match first.take() {
            Some(plan) => plan,
            None => plan_at(at_s)?,
        };
        while under_way.len() >= executor.depth().max(1) {
            collect(executor.as_mut(), &mut under_way, &mut written, path, format, times.len())?;
            progress.show(written);
        }
        executor.submit(ticket as u64, &plan)?;
        under_way.push(plan.size_px);
    }
    while !under_way.is_empty() {
        collect(executor.as_mut(), &mut under_way, &mut written, path, format, times.len())?;
        progress.show(written);
    }
    drop(progress);
    tables.complaints().iter().for_each(|what| eprintln!("{what}"));
    let status = tables.status();
    if status.of > 0 {
        eprintln!("tables of virtual lights: {} lights baked, {} read", status.baked, status.read);
    }
    Ok(())
}

impl From<Fault> for Failure {
    fn from(fault: Fault) -> Self {
        Self::Run(fault.to_string())
    }
}

/// The moments asked for.
fn times(options: &Options) -> Result<Vec<f64>, Failure> {
    if let (Some(from), Some(to), Some(fps)) = (options.from, options.to, options.fps) {
        let last = ((to - from) * fps + 1e-9).floor();
        if !(0.0..MOST_PICTURES).contains(&last) {
            let message =
                format!("--from {from} --to {to} --fps {fps} is no sequence of 1 to {MOST_PICTURES} pictures");
            return Err(Failure::Input(message));
        }
        return Ok((0..=last as u64).map(|n| from + n as f64 / fps).collect());
    }
    Ok(options.at.into_iter().collect())
}

/// A world with the scenario loaded, drawn with the slices asked for.
fn world(options: &Options) -> Result<World, Failure> {
    let timeline = scenario::read(&options.scenario)?;
    let mut world = World::new();
    let around = options.terrain.terrain();
    world.set_terrain(match &options.terrain_file {
        Some(file) => with_heights(around, file, options.terrain_sea_level_m)
            .map_err(|wrong| Failure::Input(wrong.to_string()))?,
        None => around,
    });
    world
        .apply(Command::Scenario(ScenarioEdit::Load(Arc::new(timeline))))
        .map_err(|refused: Refused| Failure::Input(refused.to_string()))?;
    let quality = world.peek(0.0).quality;
    let (slices, relight) = (options.slices.unwrap_or(quality.slices), options.relight.unwrap_or(quality.relight));
    world.set_quality(Quality { slices, relight, ..quality });
    Ok(world)
}

/// The view of this name, or the first one.
fn view<'a>(views: &'a [ViewState], name: Option<&str>) -> Result<&'a ViewState, Failure> {
    let found = match name {
        Some(name) => views.iter().find(|view| view.name == name),
        None => views.first(),
    };
    found.ok_or_else(|| {
        let names: Vec<&str> = views.iter().map(|view| view.name.as_str()).collect();
        Failure::Input(format!("no such view; the scenario has: {}", names.join(", ")))
    })
}

fn explain(plan: &FramePlan) {
    println!("{} x {} pixels", plan.size_px[0], plan.size_px[1]);
    for note in &plan.notes {
        println!("{:<9} {:<12} {}", if note.kept { "kept" } else { "left out" }, note.pass, note.why);
    }
}

/// The format that a file's ending asks for.
fn format_of(path: &Path) -> Result<Format, Failure> {
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_ascii_lowercase();
    match ending.as_str() {
        "png" => Ok(Format::Png),
        "jpg" | "jpeg" => Ok(Format::Jpeg { quality: JPEG_QUALITY }),
        "exr" => Ok(Format::Exr),
        _ => Err(Failure::Input(format!("{}: the ending must be .png, .jpg or .exr", path.display()))),
    }
}

/// Waits for the oldest pictures under way and writes them.
fn collect(
    executor: &mut dyn Executor,
    under_way: &mut Vec<[u32; 2]>,
    written: &mut usize,
    path: &Path,
    format: Format,
    of: usize,
) -> Result<(), Failure> {
    let finished = executor.collect(true)?;
    if finished.is_empty() {
        return Err(Failure::Run("the executor lost a picture".to_owned()));
    }
    for picture in finished {
        let size_px = under_way.remove(0);
        write(&file_name(path, *written, of), &picture.pixels, size_px, format)?;
        *written += 1;
    }
    Ok(())
}

/// The name of one picture: with its number when there are several.
fn file_name(path: &Path, number: usize, of: usize) -> PathBuf {
    if of == 1 {
        return path.to_owned();
    }
    let part = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    path.with_file_name(format!("{}-{number:05}.{}", part(path.file_stem()), part(path.extension())))
}

fn write(path: &Path, pixels: &Pixels, [width, height]: [u32; 2], format: Format) -> Result<(), Failure> {
    let wrong = |why: String| Failure::Run(format!("{}: {why}", path.display()));
    let bytes = encode_pixels(pixels, width, height, format).map_err(|error| wrong(error.to_string()))?;
    std::fs::write(path, bytes).map_err(|error| wrong(format!("cannot be written: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_names_are_what_they_say() {
        assert_eq!(size("640x360"), Ok([640, 360]));
        for wrong in ["640", "640x", "x360", "0x10", "640x99999", "-1x5", "640x360x1"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
        assert_eq!(file_name(Path::new("a/sky.png"), 7, 1), Path::new("a/sky.png"));
        assert_eq!(file_name(Path::new("a/sky.png"), 7, 9), Path::new("a/sky-00007.png"));
        assert!(format_of(Path::new("sky.gif")).is_err());
        assert_eq!(format_of(Path::new("sky.JPG")).ok(), Some(Format::Jpeg { quality: JPEG_QUALITY }));
    }

    #[test]
    fn a_sea_level_is_one_that_there_is() {
        assert_eq!((sea_level("48.5"), sea_level("-100")), (Ok(48.5), Ok(-100.0)));
        for wrong in ["111", "NaN", "-inf", "sea"] {
            assert!(sea_level(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn seconds_are_finite_and_in_range() {
        assert_eq!(seconds("1.5"), Ok(1.5));
        for wrong in ["-1", "NaN", "inf", "1e99", "soon"] {
            assert!(seconds(wrong).is_err(), "{wrong}");
        }
    }
}
