//! A bolt as JSON: `protocol/bolt.md` says what each field means.

use super::Drawn;
use crate::lightning::branches::{Appearance, branches};
use crate::lightning::channel::Stop;
use crate::lightning::grow::Method;
use crate::lightning::scene::Scene;
use serde::Serialize;

#[derive(Serialize)]
struct Bolt<'a> {
    r#type: &'static str,
    method: &'static str,
    grid: Vec<u32>,
    seed: u64,
    eta: Option<f64>,
    rho: Option<f64>,
    pull: Option<f64>,
    tolerance: Option<f64>,
    neighbours: usize,
    cells: u32,
    reached: bool,
    targets_reached: u32,
    stop: &'static str,
    iterations: u64,
    residual: f64,
    time_s: f64,
    cell_m: f64,
    ends: &'a [u32],
    nodes: Vec<Node>,
}

#[derive(Serialize)]
struct Node {
    position: [f64; 3],
    parent: Option<u32>,
    order: u32,
    along_m: f64,
    thickness: f64,
    brightness: f64,
}

/// The text of the file.
pub(super) fn text(drawn: &Drawn, scene: &Scene, seed: u64, cell_m: f64) -> Result<String, serde_json::Error> {
    let (channel, info) = (&drawn.channel, &drawn.info);
    let (eta, rho, pull, tolerance) = match drawn.method {
        Method::ReedWyvill(_) => (None, None, None, None),
        Method::Dielectric { eta } => (Some(eta), None, None, None),
        Method::DielectricConjugate { eta, tolerance } => (Some(eta), None, None, Some(tolerance)),
        Method::Laplacian { eta, pull, .. } => (Some(eta), None, Some(pull), None),
        Method::Rational { eta, rho, .. } => (Some(eta), Some(rho), None, None),
    };
    let found = branches(channel, &Appearance::default());
    let node = |number: usize| Node {
        position: channel.nodes[number].position,
        parent: (number > 0).then_some(channel.nodes[number].parent),
        order: found.order[number],
        along_m: found.along[number] * cell_m,
        thickness: found.thickness[number],
        brightness: found.brightness[number],
    };
    let axes = scene.grid.axes();
    let bolt = Bolt {
        r#type: "bolt",
        method: drawn.method.name(),
        grid: scene.grid.size()[..axes].to_vec(),
        seed,
        eta,
        rho,
        pull,
        tolerance,
        neighbours: scene.neighbours.steps(axes).len(),
        cells: info.cells,
        reached: info.reached,
        targets_reached: info.targets_reached,
        stop: match info.stop {
            Stop::Reached => "reached",
            Stop::CellLimit => "cell_limit",
            Stop::Exhausted => "exhausted",
        },
        iterations: info.iterations,
        residual: info.residual,
        time_s: drawn.time_s,
        cell_m,
        ends: &channel.ends,
        nodes: (0..channel.nodes.len()).map(node).collect(),
    };
    serde_json::to_string(&bolt)
}
