//! From a bolt's point sources to the light that every cell scatters: six methods, from one term to the reference.

use super::basis::{Basis, Content, Recipe};
use super::compress::{Ambient, Block, Sum};
use super::medium::Medium;
use super::ordinates::{PointSource, SolveError, Solver};
use crate::numeric::haar::Haar;
use crate::numeric::sphere::Direction;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// How a bolt lights a cloud, roughly from cheap to dear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Method {
    /// Deck paper eq. 21: intensity over distance squared, nothing in between (the distance kept above 0.36 of a cell's edge).
    Point,
    /// Direct light scattered once (the earlier method of Dobashi et al. 2001).
    Single,
    /// The published scheme: virtual lights weighted by eq. 6, sparse sum, inverse Haar (eq. 8-9).
    Basis,
    /// Direct light exactly from clustered points, the table for the diffuse light, one pass of light.
    Hybrid,
    /// One solve for this bolt, its points clustered; no table.
    Solve,
    /// One solve with every point for itself and a tight tolerance.
    Reference,
}

impl Method {
    /// All methods.
    pub const ALL: [Self; 6] = [Self::Point, Self::Single, Self::Basis, Self::Hybrid, Self::Solve, Self::Reference];

    /// Its name on wires and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Single => "single",
            Self::Basis => "basis",
            Self::Hybrid => "hybrid",
            Self::Solve => "solve",
            Self::Reference => "reference",
        }
    }

    /// The table that it needs.
    pub fn table(self) -> Option<Content> {
        match self {
            Self::Basis => Some(Content::Total),
            Self::Hybrid => Some(Content::Diffuse),
            _ => None,
        }
    }
}

/// Light of a bolt in a cloud.
#[derive(Clone, Debug, PartialEq)]
pub struct Relit {
    /// Scattered light per unit of extinction, W/(m^2 sr): directions times cells of the window.
    pub towards: Vec<f32>,
    /// Lower south-west corner of the window in whole cells (0, 0 where the medium does not repeat).
    pub corner: [i64; 2],
    /// Points outside the grid of lights; they were moved to its border and light the cloud from there.
    pub outside: usize,
    /// What was done in the end: a solve that did not converge falls back to `Single`.
    pub method: Method,
    /// Why it fell back.
    pub fallback: Option<SolveError>,
}

/// Fields of virtual lights: a basis, or one that is still being baked.
pub trait Table {
    /// What it is made by.
    fn recipe(&self) -> &Recipe;
    /// A light's fields; none where they are not there (which counts as dark: whoever asks has seen to it).
    fn block(&self, light: usize) -> Option<&Block>;
}

impl Table for Basis {
    fn recipe(&self) -> &Recipe {
        &self.recipe
    }

    fn block(&self, light: usize) -> Option<&Block> {
        self.blocks.get(light)
    }
}

/// Why there is no light.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RelightError {
    /// A table is needed that was not given, or one of the wrong content.
    #[error("method {0} needs a table of {1:?}")]
    Table(&'static str, Content),
    /// A point is none, or the solver refuses.
    #[error(transparent)]
    Solve(#[from] SolveError),
}

/// Relights one cloud again and again.
#[derive(Clone)]
pub struct Relighter<'a> {
    medium: &'a Medium,
    /// For the medium itself, or for its window.
    solver: &'a Solver,
    haar: Haar,
    /// Points closer than this are one, m. The paper's bolts have points much closer than cells are wide.
    pub spacing_m: f64,
    /// What is added for dropped coefficients.
    pub ambient: Ambient,
}

impl<'a> Relighter<'a> {
    /// For a medium and a solver made for it.
    pub fn new(medium: &'a Medium, solver: &'a Solver) -> Self {
        let edge = medium.spacing_m.iter().copied().fold(0.0, f64::max);
        Self { medium, solver, haar: Haar::new(medium.cells), spacing_m: 0.3 * edge, ambient: Ambient::Off }
    }

    /// Directions of the results.
    pub fn directions(&self) -> Vec<Direction> {
        self.solver.angles().set.directions.clone()
    }

    /// The mean over directions of light per cell, such as [`Relit::towards`]: W/(m^2 sr).
    pub fn mean(&self, towards: &[f32]) -> Vec<f32> {
        let cells = self.medium.len();
        let mut mean = vec![0.0; cells];
        for (weight, field) in self.solver.angles().set.weights.iter().zip(towards.chunks(cells)) {
            let share = (weight / (4.0 * PI)) as f32;
            mean.iter_mut().zip(field).for_each(|(m, v)| *m += share * v);
        }
        mean
    }

    /// Light of a bolt's points by a method.
    ///
    /// # Errors
    /// [`RelightError`]; a solve that does not converge is not an error but falls back, and says so.
    pub fn relight(
        &self,
        method: Method,
        points: &[PointSource],
        table: Option<&Basis>,
    ) -> Result<Relit, RelightError> {
        self.relight_from(method, points, table.map(|table| table as &dyn Table))
    }

    /// [`Relighter::relight`] from any table.
    ///
    /// # Errors
    /// [`RelightError`].
    pub fn relight_from(
        &self,
        method: Method,
        points: &[PointSource],
        table: Option<&dyn Table>,
    ) -> Result<Relit, RelightError> {
        super::ordinates::check_sources(&[points])?;
        let table = match (method.table(), table) {
            (None, _) => None,
            (Some(content), Some(table)) if table.recipe().content == content => Some(table),
            (Some(content), _) => return Err(RelightError::Table(method.name(), content)),
        };
        let (corner, points) = self.centred(points);
        let windowed = self.medium.periodic.then(|| self.solver.at(&self.window(corner)));
        let solver = windowed.as_ref().unwrap_or(self.solver);
        let mut relit = Relit { towards: Vec::new(), corner, outside: 0, method, fallback: None };
        let merged = || merge(&points, self.spacing_m);
        match method {
            Method::Point => relit.towards = self.point(solver, &points),
            Method::Single => relit.towards = single(solver, &merged(), self.cluster_m()),
            Method::Basis => {
                if let Some(table) = table {
                    (relit.towards, relit.outside) = self.sum(table, &points, corner);
                    relit.towards.iter_mut().for_each(|v| *v = v.max(0.0));
                }
            }
            Method::Hybrid => {
                if let Some(table) = table {
                    let (fields, outside) = self.sum(table, &points, corner);
                    let cells = self.medium.len();
                    let moments = fields.len() / cells;
                    // From moment by moment to cell by cell, and from what is scattered to what arrives; of what is evened out
                    // nothing is scattered again.
                    let scattered = solver.scattered();
                    let over = |share: f32| if share.abs() > 1e-6 { 1.0 / share } else { 0.0 };
                    let arrives: Vec<f32> = scattered.into_iter().map(over).collect();
                    let diffuse: Vec<f32> = (0..fields.len())
                        .map(|i| arrives[i % moments] * fields[i % moments * cells + i / moments])
                        .collect();
                    let merged = merged();
                    let direct = solver.direct_of_clusters(&borrowed(&clusters(&merged, self.cluster_m())));
                    relit.towards = solver.collect(&direct, &diffuse);
                    relit.outside = outside;
                }
            }
            Method::Solve => {
                let merged = merged();
                let direct = solver.direct_of_clusters(&borrowed(&clusters(&merged, self.cluster_m())));
                let towards = solver.scatter_one(&direct).map(|(towards, _)| towards);
                self.solved(towards, solver, &points, &mut relit)?;
            }
            Method::Reference => {
                let towards = solver.solve(&[&points]).map(|(mut lights, _)| lights.pop());
                let towards = towards.map(|light| light.map(|light| light.towards).unwrap_or_default());
                self.solved(towards, solver, &points, &mut relit)?;
            }
        }
        Ok(relit)
    }

    /// Far cells see points within two edges of a cell as one.
    fn cluster_m(&self) -> f64 {
        2.0 * self.medium.spacing_m.iter().copied().fold(0.0, f64::max)
    }

    fn solved(
        &self,
        result: Result<Vec<f32>, SolveError>,
        solver: &Solver,
        points: &[PointSource],
        relit: &mut Relit,
    ) -> Result<(), RelightError> {
        match result {
            Ok(towards) => relit.towards = towards,
            Err(why @ SolveError::NoConvergence { .. }) => {
                relit.towards = single(solver, &merge(points, self.spacing_m), self.cluster_m());
                relit.method = Method::Single;
                relit.fallback = Some(why);
            }
            Err(other) => return Err(other.into()),
        }
        Ok(())
    }

    /// The window's corner for points (their mean in its middle) and the points in its coordinates.
    fn centred(&self, points: &[PointSource]) -> ([i64; 2], Vec<PointSource>) {
        let power: f64 = points.iter().map(|p| p.intensity).sum();
        if !self.medium.periodic || power <= 0.0 {
            return ([0, 0], points.to_vec());
        }
        let mean: Direction =
            std::array::from_fn(|k| points.iter().map(|p| p.position_m[k] * p.intensity).sum::<f64>() / power);
        let h = self.medium.spacing_m;
        let corner: [i64; 2] =
            std::array::from_fn(|k| (mean[k] / h[k]).floor() as i64 - self.medium.cells[k] as i64 / 2);
        let moved = points
            .iter()
            .map(|p| {
                let [x, y, z] = p.position_m;
                let position_m = [x - corner[0] as f64 * h[0], y - corner[1] as f64 * h[1], z];
                PointSource { position_m, ..*p }
            })
            .collect();
        (corner, moved)
    }

    fn window(&self, corner: [i64; 2]) -> Medium {
        let h = self.medium.spacing_m;
        let middle = |k: usize| (corner[k] + self.medium.cells[k] as i64 / 2) as f64 * h[k] + 0.5 * h[k];
        self.medium.window([middle(0), middle(1), 0.0]).0
    }

    /// Weighted sum of a table's fields in the window at `corner` (points in its coordinates), and points outside.
    fn sum(&self, table: &dyn Table, points: &[PointSource], corner: [i64; 2]) -> (Vec<f32>, usize) {
        let recipe = table.recipe();
        let h = self.medium.spacing_m;
        let moved = |point: &PointSource| {
            let [x, y, z] = point.position_m;
            let position_m = [x + corner[0] as f64 * h[0], y + corner[1] as f64 * h[1], z];
            PointSource { position_m, ..*point }
        };
        let (weights, outside) = weights(recipe, &points.iter().map(moved).collect::<Vec<_>>());
        let components = recipe.components();
        if !recipe.medium.periodic {
            let mut sum = Sum::new(&self.haar, components, self.ambient);
            for (light, weight) in weights {
                table.block(light).into_iter().for_each(|block| sum.add(block, weight as f32));
            }
            return (sum.fields(), outside);
        }
        let mut out = vec![0.0; components * self.medium.len()];
        let column = recipe.lights.z_m.len();
        let mut weights: Vec<(usize, f64)> = weights.into_iter().collect();
        while let Some((light, _)) = weights.first().copied() {
            // Lights of a column lie in one window; it is moved to the image of the column nearest to the middle.
            let end = weights.partition_point(|(l, _)| l / column == light / column);
            let mut sum = Sum::new(&self.haar, components, self.ambient);
            for (light, weight) in weights.drain(..end) {
                table.block(light).into_iter().for_each(|block| sum.add(block, weight as f32));
            }
            let (_, from) = recipe.window(light);
            let shift = std::array::from_fn(|k| {
                let n = self.medium.cells[k] as i64;
                let apart = (from[k] - corner[k]).rem_euclid(n);
                if apart >= (n + 1) / 2 { apart - n } else { apart }
            });
            unwrap(&sum.fields(), self.medium.cells, shift, &mut out);
        }
        (out, outside)
    }

    fn point(&self, solver: &Solver, points: &[PointSource]) -> Vec<f32> {
        let cells = self.medium.len();
        let least = 0.361 * self.medium.spacing_m.iter().copied().fold(f64::INFINITY, f64::min);
        let fluence: Vec<f32> = (0..cells)
            .map(|cell| {
                let c = self.medium.centre_m(cell);
                let sum: f64 = points
                    .iter()
                    .map(|p| {
                        let d2: f64 = (0..3).map(|k| (c[k] - p.position_m[k]).powi(2)).sum();
                        p.intensity / d2.max(least * least)
                    })
                    .sum();
                (solver.params().albedo * sum / (4.0 * PI)) as f32
            })
            .collect();
        fluence.repeat(solver.angles().set.len())
    }
}

/// The lights that stand for points and their weights (eq. 6), and the number of points outside of the lights. `points` in the
/// coordinates of the recipe's medium.
pub fn weights(recipe: &Recipe, points: &[PointSource]) -> (BTreeMap<usize, f64>, usize) {
    let mut weights: BTreeMap<usize, f64> = BTreeMap::new();
    let mut outside = 0;
    for point in points {
        let shares = recipe.lights.shares(point.position_m);
        outside += usize::from(shares.outside);
        for (light, share) in shares.lights {
            *weights.entry(light).or_insert(0.0) += share * point.intensity;
        }
    }
    (weights, outside)
}

/// Adds fields of one window to those of another, `shift` cells on; what does not lie in it is far away and dark.
fn unwrap(fields: &[f32], [nx, ny, nz]: [usize; 3], shift: [i64; 2], out: &mut [f32]) {
    let cells = nx * ny * nz;
    for (from, to) in fields.chunks(cells).zip(out.chunks_mut(cells)) {
        for row in 0..ny * nz {
            let (y, z) = (row % ny, row / ny);
            let Some(target) = usize::try_from(y as i64 + shift[1]).ok().filter(|t| *t < ny) else { continue };
            for x in 0..nx {
                let Some(column) = usize::try_from(x as i64 + shift[0]).ok().filter(|t| *t < nx) else { continue };
                to[column + nx * (target + ny * z)] += from[x + nx * row];
            }
        }
    }
}

fn single(solver: &Solver, points: &[PointSource], cluster_m: f64) -> Vec<f32> {
    let albedo = solver.params().albedo as f32;
    let direct = solver.direct_of_clusters(&borrowed(&clusters(points, cluster_m)));
    direct.towards.iter().map(|s| albedo * s).collect()
}

fn borrowed(clusters: &[Vec<PointSource>]) -> Vec<&[PointSource]> {
    clusters.iter().map(|c| &c[..]).collect()
}

/// Points grouped by cubes of this edge, in the order of the cubes.
fn clusters(points: &[PointSource], edge_m: f64) -> Vec<Vec<PointSource>> {
    let mut groups: BTreeMap<[i64; 3], Vec<PointSource>> = BTreeMap::new();
    for point in points.iter().filter(|p| p.intensity > 0.0) {
        groups.entry(point.position_m.map(|x| (x / edge_m).floor() as i64)).or_default().push(*point);
    }
    groups.into_values().collect()
}

/// One point per cube of this edge: the sum of the intensities at their middle.
pub fn merge(points: &[PointSource], edge_m: f64) -> Vec<PointSource> {
    clusters(points, edge_m)
        .into_iter()
        .map(|group| {
            let intensity: f64 = group.iter().map(|p| p.intensity).sum();
            let position_m =
                std::array::from_fn(|k| group.iter().map(|p| p.position_m[k] * p.intensity).sum::<f64>() / intensity);
            PointSource { position_m, intensity }
        })
        .collect()
}

#[cfg(test)]
mod tests;
