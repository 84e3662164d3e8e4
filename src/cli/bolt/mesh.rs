//! A bolt as Wavefront OBJ: tubes of six sides, one group an order, for artists.

use crate::lightning::shape::Line;
use glam::DVec3;
use std::fmt::Write;

/// Sides of a tube.
const SIDES: usize = 6;

/// The text of an OBJ file: metres, `y` up as modelling programs have it. `radius_m` is that of the main channel.
///
/// `up` is the axis of the lines that points up (1 or 2).
pub(super) fn obj(lines: &[Line], up: usize, radius_m: f64) -> String {
    let mut text = String::from("# stormdeck bolt: metres, y up, a group for each order of channel\n");
    let mut order = None;
    let mut vertices = 0;
    // Sorted by order, so that each group stands once.
    let mut sorted: Vec<&Line> = lines.iter().filter(|line| line.points.len() > 1).collect();
    sorted.sort_by_key(|line| line.order);
    for line in sorted {
        if order != Some(line.order) {
            order = Some(line.order);
            let name = if line.order == 0 { "main".to_owned() } else { format!("side_{}", line.order) };
            let _infallible = writeln!(text, "g {name}");
        }
        tube(&mut text, line, up, radius_m, &mut vertices);
    }
    text
}

fn tube(text: &mut String, line: &Line, up: usize, radius_m: f64, vertices: &mut usize) {
    let y_up = |p: [f64; 3]| if up == 2 { DVec3::new(p[0], p[2], -p[1]) } else { DVec3::from_array(p) };
    let points: Vec<DVec3> = line.points.iter().map(|point| y_up(point.position_m)).collect();
    let last = points.len() - 1;
    let direction = |k: usize| (points[(k + 1).min(last)] - points[k.saturating_sub(1)]).normalize_or(DVec3::Y);
    // The frame is carried along without twist: what of the last side lies along the line is taken out.
    let mut side = direction(0).any_orthonormal_vector();
    for (k, point) in line.points.iter().enumerate() {
        let along = direction(k);
        side = (side - along * side.dot(along)).normalize_or(along.any_orthonormal_vector());
        let other = along.cross(side);
        // Side channels taper with their brightness.
        let radius = radius_m * point.thickness * (0.15 + 0.85 * point.brightness);
        for corner in 0..SIDES {
            let turn = std::f64::consts::TAU * corner as f64 / SIDES as f64;
            let p = points[k] + (side * turn.cos() + other * turn.sin()) * radius;
            let _infallible = writeln!(text, "v {:.3} {:.3} {:.3}", p.x, p.y, p.z);
        }
    }
    let vertex = |ring: usize, corner: usize| *vertices + ring * SIDES + corner % SIDES + 1;
    for ring in 0..last {
        for corner in 0..SIDES {
            let quad = [(ring, corner), (ring, corner + 1), (ring + 1, corner + 1), (ring + 1, corner)]
                .map(|(r, c)| vertex(r, c));
            let _infallible = writeln!(text, "f {} {} {} {}", quad[0], quad[1], quad[2], quad[3]);
        }
    }
    *vertices += points.len() * SIDES;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lightning::shape::Point;

    #[test]
    fn a_tube_has_its_vertices_on_its_radius_and_its_faces_on_its_vertices() {
        let point = |z: f64| Point { position_m: [1.0, 2.0, z], along_m: z, thickness: 1.0, brightness: 1.0 };
        let main = Line { order: 0, parent: None, points: vec![point(0.0), point(5.0), point(9.0)] };
        let side = Line { order: 1, parent: Some((0, 1)), points: vec![point(5.0), point(6.0)] };
        let text = obj(&[side.clone(), main, side], 2, 0.5);
        assert_eq!(text.matches("\ng ").count(), 2);
        let numbers =
            |line: &str| -> Vec<f64> { line.split(' ').skip(1).map(|n| n.parse().expect("a number")).collect() };
        let vertices: Vec<Vec<f64>> = text.lines().filter(|line| line.starts_with("v ")).map(numbers).collect();
        assert_eq!(vertices.len(), 7 * SIDES);
        // x and -y of the grid are x and z there.
        assert!(vertices.iter().all(|v| ((v[0] - 1.0).hypot(v[2] + 2.0) - 0.5).abs() < 2e-3));
        let faces: Vec<Vec<f64>> = text.lines().filter(|line| line.starts_with("f ")).map(numbers).collect();
        assert_eq!(faces.len(), 4 * SIDES);
        assert!(faces.iter().flatten().all(|&v| v >= 1.0 && v <= vertices.len() as f64));
    }
}
