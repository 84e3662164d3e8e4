//! From a request to its field: cloud, light, quotients.

use super::cloud::{medium, window};
use super::emergent::emergent;
use super::{Field, POINTS, Point, Request, Window};
use crate::numeric::sphere::DirectionSet;
use crate::scattering::medium::Medium;
use crate::scattering::ordinates::{Params, PointSource, Solver};
use crate::scattering::phase::Phase;
use crate::scattering::relight::{Relighter, Relit, merge};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Asymmetry of water droplets in visible light.
const ASYMMETRY: f64 = 0.85;

/// How light is found: coarser than elsewhere. At a residual of 3e-3, sped up by diffusion, cells a thousandth as bright as
/// the brightest are right within some hundredths (decks of 300 and 800 m); without it far light comes last, and at 1e-2
/// a deck was dark a kilometre from its flash.
pub fn params() -> Params {
    Params {
        phase: Phase::HenyeyGreenstein(ASYMMETRY),
        tolerance: 3e-3,
        rays: 1024,
        most_sweeps: 400,
        ..Params::default()
    }
}

/// The field of a request; `None` where no light comes to any cloud or a number is none.
pub fn field(request: &Request) -> Option<Field> {
    let window = window(request);
    let medium = medium(request, &window).ok()?;
    if medium.is_empty() {
        return None;
    }
    let solver = solver()?.at(&medium);
    let sources = sources(&request.points, &window);
    let relit = Relighter::new(&medium, &solver).relight(request.method.method(), &sources, None).ok()?;
    Some(stored(request, window, &solver.angles().set, &relit))
}

/// Points in a window's coordinates; those that give no light are left out.
pub fn sources(points: &[Point], window: &Window) -> Vec<PointSource> {
    let source = |p: &Point| PointSource {
        position_m: std::array::from_fn(|k| f64::from(p.position_m[k] - window.corner_m[k])),
        intensity: f64::from(p.share),
    };
    points.iter().filter(|p| p.share > 0.0).map(source).collect()
}

/// A solver whose tables are made once; its own medium is a single clear cell.
pub fn solver() -> Option<&'static Solver> {
    static MADE: LazyLock<Option<Solver>> = LazyLock::new(|| {
        let cell = Medium::new([1; 3], [1.0; 3], vec![0.0], false).ok()?;
        Solver::new(&cell, params()).ok()
    });
    MADE.as_ref()
}

/// Light as pictures read it.
pub fn stored(request: &Request, window: Window, set: &DirectionSet, relit: &Relit) -> Field {
    let (points, cap_m2) = few(&request.points, 0.45 * window.cell_m[0]);
    let [nx, ny, nz] = window.cells;
    let cells = nx * ny * nz;
    let mut moments = vec![[0.0_f32; 4]; cells];
    for ((d, weight), towards) in set.directions.iter().zip(&set.weights).zip(relit.towards.chunks(cells)) {
        // Mean over the sphere, and three times the mean of the direction's components.
        let share = (weight / (4.0 * PI)) as f32;
        let [x, y, z] = d.map(|c| 3.0 * share * c as f32);
        for (m, light) in moments.iter_mut().zip(towards) {
            m[0] += share * light;
            m[1] += x * light;
            m[2] += y * light;
            m[3] += z * light;
        }
    }
    let to_flux = to_flux();
    let plane = nx * ny;
    let face = |z: usize, sign: f32| -> Vec<f32> {
        moments[z * plane..][..plane].iter().map(|m| sign * m[3] * to_flux).collect()
    };
    let (below, above) = (emergent(&window, &face(0, -1.0)), emergent(&window, &face(nz - 1, 1.0)));
    let mut quotients = moments;
    quotients
        .par_iter_mut()
        .enumerate()
        .for_each(|(i, m)| *m = lean_kept(*m, mean_in_air(&window, &points, cap_m2, i)));
    let method = relit.method;
    Field { window, quotients, points, cap_m2, below, above, method, stand_in: false, summed: None }
}

/// From three times the mean of directions to the flux: a third of it is what the cell scatters on balance, albedo times
/// asymmetry times the flux over 4 pi.
pub fn to_flux() -> f32 {
    4.0 * std::f32::consts::PI / (3.0 * ASYMMETRY as f32 * params().albedo as f32)
}

/// A cell's quotients from its moments (mean, and lean towards east, north and up). A sum of four terms is nowhere negative
/// if the lean is no more than the mean.
pub fn lean_kept(m: [f32; 4], in_air: f32) -> [f32; 4] {
    let lean = (m[1] * m[1] + m[2] * m[2] + m[3] * m[3]).sqrt();
    let keep = if lean > m[0] { m[0] / lean } else { 1.0 };
    let scale = 1.0 / in_air;
    [m[0] * scale, m[1] * keep * scale, m[2] * keep * scale, m[3] * keep * scale]
}

/// At most [`POINTS`] points that stand for many, and the square of the distance within which each stands for a piece of
/// the channel. `edge_m`: the least distance between them.
pub fn few(points: &[Point], edge_m: f32) -> (Vec<Point>, f32) {
    let sources: Vec<PointSource> = points
        .iter()
        .map(|p| PointSource { position_m: p.position_m.map(f64::from), intensity: f64::from(p.share) })
        .collect();
    let mut edge = f64::from(edge_m);
    let mut merged = merge(&sources, edge);
    while merged.len() > POINTS {
        edge *= 1.25;
        merged = merge(&sources, edge);
    }
    let points = merged
        .iter()
        .map(|p| Point { position_m: p.position_m.map(|x| x as f32), share: p.intensity as f32 })
        .collect();
    // Points nearer to each other than this melt into a line.
    let cap = 0.8 * edge as f32;
    (points, cap * cap)
}

/// What the points would give in empty air, 1/m^2 of one candela.
pub fn in_air(points: &[Point], cap_m2: f32, p: [f32; 3]) -> f32 {
    let square = |q: &Point| (0..3).map(|k| (p[k] - q.position_m[k]).powi(2)).sum::<f32>();
    points.iter().map(|q| q.share / (square(q) + cap_m2)).sum()
}

/// Its mean over a cell of this number; what is far from all points is even enough to be told by its middle.
pub fn mean_in_air(window: &Window, points: &[Point], cap_m2: f32, cell: usize) -> f32 {
    let [nx, ny, _] = window.cells;
    let cell = [cell % nx, cell / nx % ny, cell / (nx * ny)];
    let at = |offset: [f32; 3]| -> [f32; 3] {
        std::array::from_fn(|k| window.corner_m[k] + (cell[k] as f32 + offset[k]) * window.cell_m[k])
    };
    let middle = at([0.5; 3]);
    let widest = window.cell_m.iter().copied().fold(0.0, f32::max);
    let near = |p: &Point| (0..3).all(|k| (p.position_m[k] - middle[k]).abs() < 2.5 * widest);
    let looks = if points.iter().any(near) { 4 } else { 1 };
    let mut sum = 0.0;
    for look in 0..looks * looks * looks {
        let steps = [look % looks, look / looks % looks, look / (looks * looks)];
        sum += in_air(points, cap_m2, at(steps.map(|i: usize| (i as f32 + 0.5) / looks as f32)));
    }
    (sum / (looks * looks * looks) as f32).max(1e-30)
}
