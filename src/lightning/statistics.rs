//! Figures of a channel's form: tips, forks and fractal dimensions.

use super::channel::{Channel, distance};

/// Figures of a channel's form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Form {
    /// Nodes without a child.
    pub tips: u32,
    /// Nodes with two children and more.
    pub forks: u32,
    /// Radius of gyration about the start, in cells.
    pub gyration: f64,
    /// Fractal dimension by mass and radius; none for a channel too small for it.
    pub mass_radius: Option<f64>,
    /// Fractal dimension by boxes; none for a channel too small for it.
    pub boxes: Option<f64>,
}

/// Least radius of the fit of mass against radius, in cells: below it the lattice shows.
const LEAST_RADIUS: f64 = 3.0;
/// Radii (and box sizes) of a fit, in equal steps of the logarithm.
const FIT_POINTS: usize = 12;

/// Measures a channel.
pub fn form(channel: &Channel) -> Form {
    let count = channel.nodes.len();
    let mut children = vec![0_u32; count];
    for node in &channel.nodes[1..] {
        children[node.parent as usize] += 1;
    }
    let start = channel.nodes[0].position;
    let radii: Vec<f64> = channel.nodes.iter().map(|node| distance(node.position, start)).collect();
    let gyration = (radii.iter().map(|r| r * r).sum::<f64>() / count as f64).sqrt();
    Form {
        tips: children.iter().filter(|&&n| n == 0).count() as u32,
        forks: children.iter().filter(|&&n| n > 1).count() as u32,
        gyration,
        mass_radius: mass_radius(radii, gyration),
        boxes: boxes(channel, gyration),
    }
}

/// Slope of ln (nodes within r) over ln r, for r from 3 cells to the radius of gyration (Niemeyer et al. 1984).
fn mass_radius(mut radii: Vec<f64>, gyration: f64) -> Option<f64> {
    radii.sort_unstable_by(f64::total_cmp);
    slope(LEAST_RADIUS, gyration, |radius| radii.partition_point(|&r| r <= radius) as f64)
}

/// Less the slope of ln (boxes that are met) over ln (side), for sides from 2 cells to 0.6 radii of gyration.
fn boxes(channel: &Channel, gyration: f64) -> Option<f64> {
    let met = |side: f64| {
        let mut boxes: Vec<[i64; 3]> =
            channel.nodes.iter().map(|node| node.position.map(|x| (x / side).floor() as i64)).collect();
        boxes.sort_unstable();
        boxes.dedup();
        boxes.len() as f64
    };
    slope(2.0, 0.6 * gyration, met).map(|slope| -slope)
}

/// Least squares of ln f over ln x between two ends; none where they are less than a factor of two apart.
fn slope(low: f64, high: f64, f: impl Fn(f64) -> f64) -> Option<f64> {
    if high < 2.0 * low {
        return None;
    }
    let step = (high / low).ln() / (FIT_POINTS - 1) as f64;
    let points = (0..FIT_POINTS).map(|k| {
        let x = low.ln() + step * k as f64;
        (x, f(x.exp()).max(1.0).ln())
    });
    let (mut sx, mut sy, mut sxx, mut sxy) = (0.0, 0.0, 0.0, 0.0);
    for (x, y) in points {
        sx += x;
        sy += y;
        sxx += x * x;
        sxy += x * y;
    }
    let n = FIT_POINTS as f64;
    Some((n * sxy - sx * sy) / (n * sxx - sx * sx))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lightning::channel::Node;
    use crate::lightning::grid::{Grid, Neighbours};
    use crate::lightning::grow::{Method, grow};
    use crate::lightning::scene::Scene;
    use crate::lightning::tables::Tables;
    use std::sync::atomic::AtomicBool;

    #[test]
    fn a_line_has_dimension_one_and_a_disc_two() {
        let line: Vec<Node> =
            (0..200_u32).map(|x| Node { position: [f64::from(x), 0.0, 0.0], parent: x.saturating_sub(1) }).collect();
        let found = form(&Channel { nodes: line, ends: vec![] });
        assert_eq!((found.tips, found.forks), (1, 0));
        // Counts of cells within a radius are off by up to one of r: a few per cent at the least radius.
        assert!((found.mass_radius.expect("large enough") - 1.0).abs() < 0.1, "{found:?}");
        assert!((found.boxes.expect("large enough") - 1.0).abs() < 0.1, "{found:?}");
        let mut disc = vec![Node { position: [0.0; 3], parent: 0 }];
        for x in -40..=40_i32 {
            for y in -40..=40_i32 {
                if x * x + y * y <= 1600 && (x, y) != (0, 0) {
                    disc.push(Node { position: [f64::from(x), f64::from(y), 0.0], parent: 0 });
                }
            }
        }
        let found = form(&Channel { nodes: disc, ends: vec![] });
        assert!((found.mass_radius.expect("large enough") - 2.0).abs() < 0.1, "{found:?}");
        // Boxes that the rim only touches count whole, more of them the larger the box: low by a quarter at this size.
        assert!((found.boxes.expect("large enough") - 2.0).abs() < 0.3, "{found:?}");
    }

    #[test]
    fn breakdown_at_eta_1_has_the_published_dimension() {
        // Niemeyer et al. 1984: 1.70 +- 0.05 in a plane. The mean of 8 clusters of 700 cells has a standard error of 0.03.
        let scene = Scene { neighbours: Neighbours::Faces, ..Scene::free(Grid::plane(161, 161).expect("a grid")) };
        let mut tables = Tables::default();
        let dimension = |seed| {
            let method = Method::Dielectric { eta: 1.0 };
            let (channel, _) =
                grow(&method, &scene, 700, seed, &mut tables, &AtomicBool::new(false)).expect("a right scene");
            form(&channel).mass_radius.expect("large enough")
        };
        let mean = (0..8).map(dimension).sum::<f64>() / 8.0;
        assert!((mean - 1.70).abs() < 0.10, "{mean}");
    }
}
