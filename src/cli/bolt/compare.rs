//! The methods side by side: bolts above, the potentials that they see below.

use super::canvas::Canvas;
use super::text::{ADVANCE, ROWS};
use super::view::View;
use super::{Drawn, Options};
use crate::cli::Failure;
use crate::lightning::field::{Potential, potential};
use crate::lightning::grid::{Cell, Grid};
use crate::lightning::grow::Method;
use crate::lightning::scene::{Goal, Scene};
use crate::lightning::shape::Line;

/// Decades of potential that the colours span below the greatest.
const DECADES: f64 = 5.0;
/// Linear colour of labels.
const LABEL: [f32; 3] = [0.75, 0.75, 0.70];
/// From the least to the greatest potential, linear light.
const RAMP: [[f32; 3]; 5] =
    [[0.002, 0.001, 0.012], [0.05, 0.005, 0.12], [0.32, 0.03, 0.12], [0.80, 0.18, 0.02], [0.98, 0.80, 0.22]];

/// Draws columns of equal width: each bolt, and below it the potential with that bolt in place (the middle slice of a volume).
pub(super) fn picture(
    drawn: &[(Drawn, Vec<Line>)],
    scene: &Scene,
    extent_m: [f64; 3],
    options: &Options,
) -> Result<(Vec<u8>, [usize; 2]), Failure> {
    let [column, height] = options.size.map(|side| side as usize);
    let size = [column * drawn.len(), 2 * height];
    let up = scene.grid.axes() - 1;
    let view = View::flat(extent_m, up, [column, height]);
    let mut canvas = Canvas::night(size[0], size[1], 0.5 * view.horizon(height));
    for (number, (bolt, lines)) in drawn.iter().enumerate() {
        let left = (number * column) as f64;
        canvas.lines(lines, |p| {
            let ([x, y], scale) = view.project(p)?;
            (0.0..column as f64).contains(&x).then_some(([left + x, y], scale * 0.5))
        });
        let frame = [number * column, height, (number + 1) * column, 2 * height];
        match seen_by(&bolt.method) {
            Some(kind) => heat(&mut canvas, frame, &field(kind, scene, bolt)?, scene.grid),
            None => canvas.fill(frame, [0.01; 3]),
        }
        // As large as leaves room for the longest label.
        let label = label(&bolt.method);
        let scale = (column / (ADVANCE * (label.len() + 4))).clamp(1, 4);
        let at = [number * column + 2 * ADVANCE * scale / 3, ROWS * scale / 2];
        canvas.text(at, scale, &label, LABEL);
        let below = if seen_by(&bolt.method).is_some() { "potential" } else { "no potential" };
        canvas.text([at[0], height + at[1]], scale, below, LABEL);
    }
    Ok((canvas.finish(), size))
}

/// A method's name and parameters.
fn label(method: &Method) -> String {
    let name = method.name();
    match *method {
        Method::ReedWyvill(_) => name.to_owned(),
        Method::Dielectric { eta } | Method::DielectricConjugate { eta, .. } | Method::Laplacian { eta, .. } => {
            format!("{name} eta {eta}")
        }
        Method::Rational { eta, rho, .. } => format!("{name} eta {eta} rho {rho}"),
    }
}

fn seen_by(method: &Method) -> Option<Potential> {
    match *method {
        Method::ReedWyvill(_) => None,
        Method::Dielectric { .. } | Method::DielectricConjugate { .. } => Some(Potential::Laplace),
        Method::Laplacian { pull, .. } => Some(Potential::Laplacian { pull }),
        Method::Rational { rho, .. } => Some(Potential::Rational { rho }),
    }
}

fn field(kind: Potential, scene: &Scene, bolt: &Drawn) -> Result<Vec<f64>, Failure> {
    let cell = |node: &crate::lightning::channel::Node| scene.grid.cell(node.position.map(|p| p as u32));
    let ends: Vec<Cell> = bolt.channel.ends.iter().map(|&end| cell(&bolt.channel.nodes[end as usize])).collect();
    let channel: Vec<Cell> = bolt.channel.nodes.iter().map(cell).filter(|cell| !ends.contains(cell)).collect();
    // The ground as a target has no single charge: its picture is that of the cell which was reached.
    let scene = match (&scene.goal, ends.first()) {
        (Goal::Ground, Some(&end)) => Scene { goal: Goal::Nearest(vec![end]), ..scene.clone() },
        _ => scene.clone(),
    };
    Ok(potential(kind, &scene, &channel)?)
}

/// Fills a rectangle with a field's logarithm in colours; cells without potential stay black.
fn heat(canvas: &mut Canvas, [x0, y0, x1, y1]: [usize; 4], field: &[f64], grid: Grid) {
    let (size, axes) = (grid.size(), grid.axes());
    let least = field.iter().copied().fold(f64::MAX, f64::min).min(0.0);
    let greatest = field.iter().map(|value| value - least).fold(f64::MIN_POSITIVE, f64::max);
    let side = ((x1 - x0) as f64 / f64::from(size[0])).min((y1 - y0) as f64 / f64::from(size[axes - 1])).max(1e-9);
    let margin = 0.5 * ((x1 - x0) as f64 - side * f64::from(size[0]));
    for row in 0..size[axes - 1] {
        for x in 0..size[0] {
            let cell = if axes == 2 { grid.cell([x, row, 0]) } else { grid.cell([x, size[1] / 2, row]) };
            let share = ((field[cell as usize] - least) / greatest).max(0.0);
            let level = (1.0 + share.log10() / DECADES).clamp(0.0, 1.0);
            let left = x0 as f64 + margin + side * f64::from(x);
            let top = y0 as f64 + side * f64::from(size[axes - 1] - 1 - row);
            let edges = [left, top, left + side, top + side].map(|edge| edge.round() as usize);
            canvas.fill(edges, if field[cell as usize] == 0.0 { [0.0; 3] } else { colour(level as f32) });
        }
    }
}

fn colour(level: f32) -> [f32; 3] {
    let place = level * (RAMP.len() - 1) as f32;
    let low = (place as usize).min(RAMP.len() - 2);
    let share = place - low as f32;
    std::array::from_fn(|k| RAMP[low][k] + (RAMP[low + 1][k] - RAMP[low][k]) * share)
}
