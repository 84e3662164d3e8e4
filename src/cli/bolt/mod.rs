//! `stormdeck bolt`: one lightning channel by any method, as picture, JSON, mesh or thunder, without a server.

mod canvas;
mod compare;
mod json;
mod mesh;
mod request;
mod sound;
mod text;
mod view;

use super::Failure;
use crate::encode::{Format, encode_pixels};
use crate::frame::Pixels;
use crate::lightning::channel::{Channel, Info};
use crate::lightning::grow::{Method, grow};
use crate::lightning::scene::Scene;
use crate::lightning::shape::{Line, Shape, lines};
use crate::lightning::tables::Tables;
use crate::world::limits::PEAK_CURRENT_KA;
use canvas::Canvas;
use request::{GoalName, MethodName, Place, Size, Wall, method, scene};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;
use view::View;

/// Most cells of one bolt.
const MOST_CELLS: u32 = 1_000_000;
/// Radius of the main channel in a mesh: 30 times a real one of some 5 cm, so that it shows.
const MESH_RADIUS_M: f64 = 1.5;

/// Draws one lightning channel by any method to PNG, JSON and OBJ, and lets its thunder be heard.
#[derive(Debug, clap::Args)]
pub(super) struct Options {
    /// What grows it.
    #[arg(long, value_enum, default_value = "rational")]
    method: MethodName,
    /// Cells: NXxNY (a plane, y up) or NXxNYxNZ (a volume, z up).
    #[arg(long, value_name = "NXxNY[xNZ]", default_value = "128x128")]
    grid: Size,
    /// Equal seeds give equal bolts.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Exponent of the potential: more of it, fewer branches (0 to 20).
    #[arg(long)]
    eta: Option<f64>,
    /// Exponent of the distance, of the rational potential (0.1 to 20).
    #[arg(long)]
    rho: Option<f64>,
    /// Pull of a target, of fast Laplacian growth (0 to 1e6).
    #[arg(long)]
    pull: Option<f64>,
    /// Greatest residual of the solver, of dbm-cg.
    #[arg(long, default_value_t = 1e-6)]
    tolerance: f64,
    /// Most cells that are grown.
    #[arg(long, default_value_t = 20_000, value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_CELLS)))]
    cells: u32,
    /// Where it begins; the middle of the top when not given (of the grid, for a free one).
    #[arg(long, value_name = "X,Y[,Z]")]
    start: Option<Place>,
    /// Where it goes; several may be given. The middle of the ground when none is.
    #[arg(long, value_name = "X,Y[,Z]")]
    target: Vec<Place>,
    /// What it makes of the targets.
    #[arg(long, value_enum, default_value = "nearest")]
    goal: GoalName,
    /// A box of obstacles, corner to corner; several may be given.
    #[arg(long, value_name = "X,Y[,Z]:X,Y[,Z]")]
    wall: Vec<Wall>,
    /// Steps through faces of cells only: 4 or 6 neighbours instead of 8 or 26.
    #[arg(long)]
    faces: bool,
    /// No waypoints round obstacles that hide the target.
    #[arg(long)]
    no_waypoints: bool,
    /// Height of the grid in metres: what a cell is follows from it.
    #[arg(long, value_name = "METRES", default_value_t = 2000.0, value_parser = height)]
    height_m: f64,
    /// Draws the grid's cells as they are: no jitter, no curves, no crookedness below a cell.
    #[arg(long)]
    plain: bool,
    /// Size of the pictures in pixels.
    #[arg(long, value_name = "WxH", default_value = "900x900", value_parser = super::render::size)]
    size: [u32; 2],
    /// Writes the bolt as JSON (see protocol/bolt.md).
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Writes the flat view.
    #[arg(long, value_name = "FILE")]
    png: Option<PathBuf>,
    /// Writes the view from a camera on a circle round the bolt.
    #[arg(long, value_name = "FILE")]
    turntable: Option<PathBuf>,
    /// Where on that circle it stands.
    #[arg(long, value_name = "DEGREES", default_value_t = 30.0, requires = "turntable", value_parser = turn)]
    turn: f64,
    /// Writes a mesh for artists: Wavefront OBJ, metres, y up.
    #[arg(long, value_name = "FILE")]
    obj: Option<PathBuf>,
    /// Writes the thunder of a flash along it as a WAV file.
    #[arg(long, value_name = "FILE")]
    thunder: Option<PathBuf>,
    /// Where it is heard: metres east, north and up from the ground below the middle of the grid.
    #[arg(long, value_name = "E,N,U", default_value = "1000,0,2", requires = "thunder", allow_hyphen_values = true, value_parser = listener)]
    listener: Listener,
    /// Peak current of the first stroke that is heard.
    #[arg(long, value_name = "KA", default_value_t = 30.0, requires = "thunder", value_parser = current)]
    peak_current_ka: f64,
    /// Draws Reed and Wyvill, dbm, flg and rational side by side with the potentials that they see, to --png.
    #[arg(long, requires = "png", conflicts_with_all = ["json", "turntable", "obj", "thunder"])]
    compare: bool,
}

fn height(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(metres) if (1.0..=100_000.0).contains(&metres) => Ok(metres),
        _ => Err("a number of 1 to 100000 metres".to_owned()),
    }
}

/// A place in metres: east, north, up.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Listener([f64; 3]);

fn listener(text: &str) -> Result<Listener, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(str::parse).collect();
    match numbers.as_deref() {
        Ok(&[east, north, up]) if [east, north, up].iter().all(|m| m.abs() <= 100_000.0) && up >= 0.0 => {
            Ok(Listener([east, north, up]))
        }
        _ => Err("three numbers of at most 100000 metres, the third not below the ground, as in 1000,0,2".to_owned()),
    }
}

fn current(text: &str) -> Result<f64, String> {
    let [low, high] = PEAK_CURRENT_KA;
    match text.parse() {
        Ok(current_ka) if (low..=high).contains(&current_ka) => Ok(current_ka),
        _ => Err(format!("a number of {low} to {high} kiloamperes")),
    }
}

fn turn(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(degrees) if (-3600.0..=3600.0).contains(&degrees) => Ok(degrees),
        _ => Err("a number of -3600 to 3600 degrees".to_owned()),
    }
}

/// A grown bolt and how long that took.
struct Drawn {
    method: Method,
    channel: Channel,
    info: Info,
    time_s: f64,
}

/// Grows the bolt or bolts and writes what is asked for.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let scene = scene(options)?;
    let up = scene.grid.axes() - 1;
    let size = scene.grid.size();
    let cell_m = options.height_m / f64::from((size[up].max(2)) - 1);
    let extent_m = size.map(|side| f64::from(side - 1) * cell_m);
    if options.compare {
        return compare(options, &scene, cell_m, extent_m);
    }
    let drawn = grown(method(options.method, options), &scene, options)?;
    if let Some(path) = &options.json {
        let text = json::text(&drawn, &scene, options.seed, cell_m).map_err(|e| Failure::Run(e.to_string()))?;
        write(path, text.as_bytes())?;
    }
    let lines = shaped(&drawn, &scene, cell_m, options);
    let size_px = options.size.map(|side| side as usize);
    if let Some(path) = &options.png {
        picture(path, &lines, &View::flat(extent_m, up, size_px), size_px)?;
    }
    if let Some(path) = &options.turntable {
        // A plane stands upright on the turntable.
        let lines = if up == 1 { upright(lines.clone()) } else { lines.clone() };
        let points: Vec<[f64; 3]> = lines.iter().flat_map(|line| &line.points).map(|point| point.position_m).collect();
        picture(path, &lines, &View::turntable(&points, options.turn, size_px), size_px)?;
    }
    if let Some(path) = &options.thunder {
        let standing = if up == 1 { upright(lines.clone()) } else { lines.clone() };
        let middle = [0.5 * extent_m[0], if up == 1 { 0.0 } else { 0.5 * extent_m[1] }, 0.0];
        let Listener(from_middle) = options.listener;
        let place = std::array::from_fn(|axis| middle[axis] + from_middle[axis]);
        sound::write(path, &standing, place, options.peak_current_ka, options.seed)?;
    }
    if let Some(path) = &options.obj {
        write(path, mesh::obj(&lines, up, MESH_RADIUS_M).as_bytes())?;
    }
    Ok(())
}

fn compare(options: &Options, scene: &Scene, cell_m: f64, extent_m: [f64; 3]) -> Result<(), Failure> {
    let names = [MethodName::ReedWyvill, MethodName::Dbm, MethodName::Flg, MethodName::Rational];
    let mut all = Vec::new();
    // Reed and Wyvill know no obstacles.
    for name in names.into_iter().skip(usize::from(!scene.obstacles.is_empty())) {
        let drawn = grown(method(name, options), scene, options)?;
        let lines = shaped(&drawn, scene, cell_m, options);
        all.push((drawn, lines));
    }
    let (rgba, size) = compare::picture(&all, scene, extent_m, options)?;
    match &options.png {
        Some(path) => encoded(path, rgba, size),
        None => Ok(()),
    }
}

fn grown(method: Method, scene: &Scene, options: &Options) -> Result<Drawn, Failure> {
    let begin = Instant::now();
    let (channel, info) =
        grow(&method, scene, options.cells, options.seed, &mut Tables::default(), &AtomicBool::new(false))?;
    let time_s = begin.elapsed().as_secs_f64();
    let end = if info.reached { "target reached" } else { "target not reached" };
    println!("{:<12} {:>6} cells, {end}, {:.3} ms", method.name(), info.cells, 1e3 * time_s);
    Ok(Drawn { method, channel, info, time_s })
}

fn shaped(drawn: &Drawn, scene: &Scene, cell_m: f64, options: &Options) -> Vec<Line> {
    let shape = Shape::of_cells(cell_m);
    let plain = Shape { jitter: 0.0, smoothing: 0, pieces: 1, tortuosity: 0.0, ..shape };
    let shape = match (&drawn.method, options.plain) {
        (_, true) => plain,
        // Its segments lie on no grid: nothing to hide, but still detail to add.
        (Method::ReedWyvill(_), false) => Shape { jitter: 0.0, smoothing: 0, ..shape },
        (_, false) => shape,
    };
    lines(&drawn.channel, scene.grid.axes(), &shape, options.seed)
}

/// A plane's lines with `z` up instead of `y`.
fn upright(mut lines: Vec<Line>) -> Vec<Line> {
    for point in lines.iter_mut().flat_map(|line| &mut line.points) {
        point.position_m.swap(1, 2);
    }
    lines
}

fn picture(path: &Path, lines: &[Line], view: &View, size: [usize; 2]) -> Result<(), Failure> {
    let mut canvas = Canvas::night(size[0], size[1], view.horizon(size[1]));
    canvas.lines(lines, |p| view.project(p));
    encoded(path, canvas.finish(), size)
}

fn encoded(path: &Path, rgba: Vec<u8>, [width, height]: [usize; 2]) -> Result<(), Failure> {
    let bytes = encode_pixels(&Pixels::Srgb8(rgba), width as u32, height as u32, Format::Png);
    write(path, &bytes.map_err(|error| Failure::Run(format!("{}: {error}", path.display())))?)
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    std::fs::write(path, bytes).map_err(|error| Failure::Run(format!("{}: cannot be written: {error}", path.display())))
}

#[cfg(test)]
mod tests;
