//! From what was typed to a scene and a method.

use super::Options;
use crate::cli::Failure;
use crate::lightning::error::GrowError;
use crate::lightning::grid::{Cell, Grid, Neighbours};
use crate::lightning::grow::Method;
use crate::lightning::laplacian::DEFAULT_PULL;
use crate::lightning::reed_wyvill::ReedWyvill;
use crate::lightning::scene::{Goal, Scene};

/// A method by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum MethodName {
    /// Branching by statistics of angle and length.
    ReedWyvill,
    /// Exact dielectric breakdown by the incremental Green's function.
    Dbm,
    /// Exact dielectric breakdown by conjugate gradients: slow, the reference.
    DbmCg,
    /// Fast Laplacian growth.
    Flg,
    /// The rational potential.
    Rational,
}

/// Where a bolt goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum GoalName {
    /// To the target it reaches first.
    Nearest,
    /// To every target.
    Every,
    /// To the targets one after another.
    Chain,
    /// To the ground layer.
    Ground,
    /// Nowhere: until its cells are used up.
    Free,
}

/// Two or three whole numbers with an `x` between them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Size(pub Grid);

/// Two or three whole numbers with a comma between them; the third is 0 where it is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place(pub [u32; 3]);

/// A box between two corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Wall(pub [u32; 3], pub [u32; 3]);

impl std::str::FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let sides = numbers(text, 'x')?;
        let grid = match sides[..] {
            [nx, ny] => Grid::plane(nx, ny),
            [nx, ny, nz] => Grid::volume(nx, ny, nz),
            _ => return Err("two or three numbers, as in 128x128 or 64x64x64".to_owned()),
        };
        grid.map(Self).map_err(|error| error.to_string())
    }
}

impl std::str::FromStr for Place {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match numbers(text, ',')?[..] {
            [x, y] => Ok(Self([x, y, 0])),
            [x, y, z] => Ok(Self([x, y, z])),
            _ => Err("two or three numbers, as in 64,0 or 32,32,0".to_owned()),
        }
    }
}

impl std::str::FromStr for Wall {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (a, b) = text.split_once(':').ok_or("two corners, as in 10,40:90,42")?;
        let (Place(a), Place(b)) = (a.parse()?, b.parse()?);
        Ok(Self(std::array::from_fn(|k| a[k].min(b[k])), std::array::from_fn(|k| a[k].max(b[k]))))
    }
}

fn numbers(text: &str, separator: char) -> Result<Vec<u32>, String> {
    text.split(separator).map(|part| part.parse().map_err(|_| format!("`{part}` is no whole number"))).collect()
}

impl From<GrowError> for Failure {
    fn from(error: GrowError) -> Self {
        match error {
            GrowError::NoConvergence { .. } | GrowError::Cancelled { .. } => Self::Run(error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}

/// The scene that the options describe.
pub(super) fn scene(options: &Options) -> Result<Scene, Failure> {
    let Size(grid) = options.grid;
    let size = grid.size();
    let cell = |what: &str, Place(p): Place| match (0..3).all(|axis| p[axis] < size[axis]) {
        true => Ok(grid.cell(p)),
        false => Err(Failure::Input(format!("--{what} {},{},{} lies outside the grid", p[0], p[1], p[2]))),
    };
    let mut targets = options.target.iter().map(|&place| cell("target", place)).collect::<Result<Vec<Cell>, _>>()?;
    if targets.is_empty() {
        targets.push(grid.bottom_centre());
    }
    let goal = match options.goal {
        GoalName::Nearest => Goal::Nearest(targets),
        GoalName::Every => Goal::Every(targets),
        GoalName::Chain => Goal::Chain(targets),
        GoalName::Ground => Goal::Ground,
        GoalName::Free => Goal::Free,
    };
    let middle = grid.cell(size.map(|side| side / 2));
    let start = match options.start {
        Some(place) => cell("start", place)?,
        None if goal == Goal::Free => middle,
        None => grid.top_centre(),
    };
    let mut obstacles = Vec::new();
    for &Wall(low, high) in &options.wall {
        cell("wall", Place(high))?;
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                obstacles.extend((low[0]..=high[0]).map(|x| grid.cell([x, y, z])));
            }
        }
    }
    obstacles.sort_unstable();
    obstacles.dedup();
    let neighbours = if options.faces { Neighbours::Faces } else { Neighbours::All };
    Ok(Scene { grid, neighbours, start, goal, obstacles, waypoints: !options.no_waypoints })
}

/// A method with the parameters given, or those that look best at the grid's size.
pub(super) fn method(name: MethodName, options: &Options) -> Method {
    let Size(grid) = options.grid;
    let volume = grid.axes() == 3;
    let eta = |plane: f64, solid: f64| options.eta.unwrap_or(if volume { solid } else { plane });
    match name {
        MethodName::ReedWyvill => Method::ReedWyvill(ReedWyvill::default()),
        MethodName::Dbm => Method::Dielectric { eta: eta(2.0, 3.0) },
        MethodName::DbmCg => Method::DielectricConjugate { eta: eta(2.0, 3.0), tolerance: options.tolerance },
        MethodName::Flg => Method::laplacian(eta(3.0, 4.0), options.pull.unwrap_or(DEFAULT_PULL)),
        // The lightning paper's: 2 for small grids and volumes, 3 for planes of 128 cells and more a side.
        MethodName::Rational => {
            let large = grid.size()[0].max(grid.size()[1]) >= 128;
            Method::rational(eta(if large { 3.0 } else { 2.0 }, 2.0), options.rho.unwrap_or(3.0))
        }
    }
}
